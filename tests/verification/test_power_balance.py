"""Every state checked without the solver: statics, Coulomb's law, kinematics, flow rule, power (`audit`).

Tolerances: equilibrium 1e-10 of the total weight and yield 1e-9 mean block weights are what linear programs solved to
1e-12 must keep. Flow rules: associative 1e-8 (exact but for rounding), those that two programs close 1e-6. A state
that loading meets is no program's: its power is right to 1e-6 of the live load's, so that an end under a small force
may open by 1e-4, which validation.py promises. How sharp it is depends on the rounding of the processor: wall 6 has
less than 1e-6 with AVX-512, and 3e-5 without.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from orchestrator.basis.arrays import read_only
from tests.support.limit_analysis_cases import answers, audit, case

NAMES = [
    "arch27_t0107", "block_on_10deg_slope", "ferris_tinloi_wall1", "ferris_tinloi_wall3", "ferris_tinloi_wall4",
    "ferris_tinloi_wall6", "orduna_panel_set13", "tower_5_blocks", "tower_slide_5_blocks",
]  # fmt: skip


def of(name, rule):
    """Return a state of a wall as drawn: the arch is so thin that in large displacements it bears a third less."""
    found = answers(name)
    return found.drawn if rule == "path" and found.drawn is not None else getattr(found, rule)


@pytest.mark.parametrize("rule", ["associative", "sequence", "path", "lowest"])
@pytest.mark.parametrize("name", [*NAMES, "keystone_wall_13x9"])
def test_forces_balance_within_friction(name, rule):
    state = of(name, rule)
    # stones that have come loose are in no balance
    if state is None or (rule != "associative" and answers(name).local_failures):
        assert name == "keystone_wall_13x9"
        assert rule in ("sequence", "path", "lowest")
        return
    found = audit(case(name), state)
    assert found.unbalanced < 1e-10
    assert found.tension < 1e-9
    assert found.excess_shear < 1e-9
    assert found.wrong_rates < 1e-12
    assert state.equilibrium_residual == pytest.approx(found.unbalanced, abs=1e-13)
    assert state.yield_residual == pytest.approx(max(0.0, found.tension, found.excess_shear), abs=1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_associative_mechanism_takes_no_power(name):
    """Without cohesion friction's power equals that of the dilation against N: live and dead load cancel."""
    found = audit(case(name), answers(name).associative)
    assert abs(found.power) < 1e-8
    assert found.penetration < 1e-9
    assert found.backward < 1e-9
    assert found.idle < 1e-10
    assert answers(name).associative.power_residual < 1e-8


@pytest.mark.parametrize("rule", ["sequence", "path", "lowest"])
@pytest.mark.parametrize("name", NAMES)
def test_non_associative_mechanism_without_dilation(name, rule):
    state = of(name, rule)
    found = audit(case(name), state)
    assert state.converged
    assert found.power == pytest.approx(found.friction_power, abs=1e-6)
    assert found.penetration < 1e-9
    opens = 1e-4 if rule == "path" else 1e-6
    assert found.loaded_gap < opens
    assert found.backward < 1e-9
    assert found.idle < opens
    assert state.dilation == pytest.approx(found.loaded_gap, abs=1e-12)


@pytest.mark.parametrize("name", ["ferris_tinloi_wall3", "ferris_tinloi_wall6"])
def test_mechanism_is_scaled_to_unit_live_power_and_to_unit_displacement(name):
    wall = case(name)
    state = answers(name).sequence
    weights = [block.unit_weight * _area(block.polygon) * wall.wall.thickness for block in wall.wall.blocks]
    assert np.dot(weights, state.mechanism.velocities[:, 0]) == pytest.approx(1.0, abs=1e-10)
    scaled = state.mechanism.scaled("unit_displacement")
    corners = [
        np.hypot(u - omega * (y - cy), v + omega * (x - cx))
        for block, (u, v, omega) in zip(wall.wall.blocks, scaled.velocities, strict=True)
        for cx, cy in [_rectangle_centre(block.polygon)]
        for x, y in block.polygon
    ]
    assert max(corners) == pytest.approx(1.0, abs=1e-12)


def _area(polygon):
    return float(np.prod(np.ptp(polygon, axis=0)))  # these walls are made of upright rectangles


def _rectangle_centre(polygon):
    return 0.5 * (polygon.min(axis=0) + polygon.max(axis=0))


def test_the_audit_notices_what_is_wrong():
    """Each of the audit's alarms goes off when a good state is spoiled."""
    wall, good = case("ferris_tinloi_wall4"), answers("ferris_tinloi_wall4").associative
    loaded = int(np.argmax(good.joint_forces[:, 0]))

    def spoiled(column, factor):
        forces = np.array(good.joint_forces)
        forces[loaded, column] *= factor
        return audit(wall, replace(good, joint_forces=read_only(forces)))

    assert spoiled(0, 1.001).unbalanced > 1e-6
    assert spoiled(0, -1.0).tension > 0.1
    assert spoiled(2, -1e3).excess_shear > 0.1
    assert audit(wall, replace(good, load_multiplier=1.001 * good.load_multiplier)).unbalanced > 1e-6
    assert abs(audit(wall, replace(good, load_multiplier=1.001 * good.load_multiplier)).power) > 1e-4

    turned = replace(good.mechanism, velocities=read_only(-good.mechanism.velocities))
    assert audit(wall, replace(good, mechanism=turned)).penetration > 1e-2
    assert audit(wall, replace(good, mechanism=turned)).wrong_rates > 1e-2
    assert audit(wall, replace(good, mechanism=turned)).backward > 1e-3
    other = answers("ferris_tinloi_wall4").sequence.mechanism
    assert abs(audit(wall, replace(good, mechanism=other)).power) > 1e-2
    assert audit(wall, good, load_direction=-1).unbalanced > 1e-4
