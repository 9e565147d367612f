"""One block that slides: every figure of the check by hand, and every complaint when the state is spoiled.

W = 20 kN on 1 m, h = 0.5 m, mu = 0.4: lambda = 0.4, N = W, s = mu W; moment W lambda h/2 = 2 kN m tilts the pressure.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from orchestrator.basis.arrays import read_only
from orchestrator.limit_analysis.paper.equilibrium import assemble_equilibrium
from orchestrator.limit_analysis.paper.limit_state import LimitState, Mechanism
from orchestrator.limit_analysis.paper.yield_conditions import coulomb
from orchestrator.limit_analysis.validation import validate
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.wall import Wall
from tests.support.walls import upright

WEIGHT, HEIGHT, FRICTION = 20e3, 0.5, 0.4


@pytest.fixture
def sliding():
    wall = Wall("block", (upright(0, -1, -1, 3, 1, fixed=True), upright(1, 0, 0, 1, HEIGHT, 40e3)), 1.0, FRICTION)
    assemblage = find_joints(wall, JointSettings())
    equilibrium = assemble_equilibrium(assemblage)
    assert (assemblage.joints.i[0], assemblage.joints.j[0]) == (0, 1)
    toe = WEIGHT / 2 + FRICTION * WEIGHT * HEIGHT / 2  # under the end the load pushes to
    at_right = assemblage.joints.start[0, 0] > assemblage.joints.end[0, 0]
    normal = (toe, WEIGHT - toe) if at_right else (WEIGHT - toe, toe)
    slip = float(assemblage.joints.tangent[0, 0]) / WEIGHT
    state = LimitState(
        flow_rule="sequence",
        load_multiplier=FRICTION,
        joint_forces=read_only([[*normal, -np.sign(slip) * FRICTION * WEIGHT]]),
        mechanism=Mechanism(
            read_only([[0.0, 0.0, 0.0], [1 / WEIGHT, 0.0, 0.0]]), read_only([[0.0, 0.0]]), read_only([slip]), 1 / WEIGHT
        ),
        records=(),
        converged=True,
        equilibrium_residual=0.0,
        yield_residual=0.0,
        power_residual=0.0,
        dilation=0.0,
        horizontal_load=WEIGHT,
        live_total=WEIGHT,
    )
    return assemblage, equilibrium, coulomb(assemblage), state


def test_sliding_block_is_a_limit_state(sliding):
    found = validate(*sliding)
    assert found.complaints == ()
    assert max(found.equilibrium, found.yield_excess, found.flow, found.dilation, found.power) < 1e-12


def test_another_multiplier_is_out_of_equilibrium_by_its_difference(sliding):
    *wall, state = sliding
    found = validate(*wall, replace(state, load_multiplier=0.41))
    assert found.equilibrium == pytest.approx(0.01, rel=1e-9)
    assert {complaint.split()[0] for complaint in found.complaints} == {"equilibrium", "power"}


def test_forces_beyond_friction(sliding):
    *wall, state = sliding
    found = validate(*wall, replace(state, joint_forces=read_only(state.joint_forces * [1, 1, 1.1])))
    assert found.yield_excess == pytest.approx(0.1 * FRICTION, rel=1e-9)


@pytest.mark.parametrize(
    ("velocity", "measure", "value"),
    [
        ((1 / WEIGHT, FRICTION / WEIGHT, 0.0), "dilation", FRICTION),  # the associative mechanism
        ((1 / WEIGHT, FRICTION / WEIGHT, 0.0), "flow", 1.0),  # W mu slip over lambda W slip
        ((1 / WEIGHT, -0.1 / WEIGHT, 0.0), "interpenetration", 0.1),
        ((-1 / WEIGHT, 0.0, 0.0), "backward", 1.0),
    ],
)
def test_mechanisms_that_do_not_belong(sliding, velocity, measure, value):
    *wall, state = sliding
    mechanism = replace(state.mechanism, velocities=read_only([[0.0, 0.0, 0.0], velocity]))
    found = validate(*wall, replace(state, mechanism=mechanism))
    assert getattr(found, measure) == pytest.approx(value, rel=1e-9)
    assert any(measure in complaint for complaint in found.complaints)
