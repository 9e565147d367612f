"""Joints that crush: a rocking block with a finite toe, against the rectangular stress block and limit analysis."""

from __future__ import annotations

import numpy as np
import pytest
from mpi4py import MPI

from orchestrator.app.pushed import push
from orchestrator.limit_analysis import analyse
from orchestrator.macroblocks.criteria import one_body_per_block
from orchestrator.masonry.joints import JointClass
from orchestrator.pushover.contact.mortar import coarse_toes
from orchestrator.pushover.path.increment_record import in_front
from orchestrator.pushover.path.increment_solver import Aim, IncrementSolver
from orchestrator.pushover.settings import NewtonSettings, SteppingSettings
from orchestrator.pushover.solve.linear_system import LinearSystem
from tests.support.pushover_chain import assemblage_of, bodies_of, model_of, run, stack

WIDTH, HEIGHT, THICKNESS, UNIT_WEIGHT = 0.4, 1.0, 0.1, 25e3
WEIGHT = UNIT_WEIGHT * WIDTH * HEIGHT * THICKNESS


def toe_of(strength):
    """W / (f_c t): what of the bed carries the weight when it crushes, m."""
    return WEIGHT / (strength * THICKNESS)


def rocked(share, mesh_size=0.025, stiffness=None, final=2e-3, step=0.05, **options):
    """A block whose toe takes `share` of its width, pushed over."""
    joints = JointClass(compressive_strength=WEIGHT / (share * WIDTH * THICKNESS), normal_stiffness=stiffness)
    model = model_of(stack((WIDTH, HEIGHT), friction=2.0), joints=joints, mesh_size=mesh_size, **options)
    return run(model, final, displacement_increment=step), joints


@pytest.mark.parametrize("share", [0.05, 0.1, 0.2, 0.4])
def test_a_rocking_block_with_a_finite_toe(share):
    """The resultant is at x / 2 from the edge, x = W / (f_c t): lambda = (b - x) / h, in both analyses."""
    result, joints = rocked(share)
    expected = WIDTH * (1 - share) / HEIGHT
    assert result.peak == pytest.approx(expected, rel=0.01)
    wall = assemblage_of(stack((WIDTH, HEIGHT), friction=2.0), joints)
    assert analyse(wall).associative.load_multiplier == pytest.approx(expected, rel=0.01)
    last = result.increments[-1]
    assert last.base_shear == pytest.approx(result.peak * WEIGHT, rel=0.01), "small displacements: a plateau"
    assert last.normal_force.max() <= result.model.mortar.strength.max() * (1 + 1e-9)


def test_an_elastic_toe_before_it_crushes():
    """k_n = 1e11 N/m3: the same plateau."""
    result, _ = rocked(0.1, 0.05, 1e11)
    assert result.peak == pytest.approx(WIDTH * 0.9 / HEIGHT, rel=0.01)


@pytest.mark.parametrize("stiffness", [None, 5e10])
def test_what_is_crushed_stays(stiffness):
    """Pushed over by 5 mm at the top and half the way back: the toe keeps its shape, and carries less."""
    result, _ = rocked(0.2, 0.05, stiffness, 5e-3)
    model, tilted = result.model, result.increments[-1]
    step, state = tilted.mean_displacement / 60, in_front(model, tilted)
    with LinearSystem(model, MPI.COMM_SELF) as system:
        solver = IncrementSolver(model, system, NewtonSettings(), SteppingSettings(final_displacement=5e-3))
        for number in range(1, 31):
            aim = Aim("displacement", tilted.mean_displacement - number * step, step)
            state = solver.solved(state, aim, state.displacement.ravel(), solver.time_step(aim))
    assert tilted.closing.max() > 1e-4
    assert (state.closing >= tilted.closing).all()
    assert state.closing[tilted.closing > 1e-4] == pytest.approx(tilted.closing[tilted.closing > 1e-4], rel=1e-9)
    assert state.dissipated_energy == pytest.approx(model.mortar.strength @ state.closing, rel=0.05)
    assert state.load_multiplier < 0.8 * tilted.load_multiplier
    elastic = model.mortar.compliance * state.normal_force
    assert (state.gap + state.closing + elastic).min() > -1e-9
    assert (state.gap + state.closing)[state.normal_force == 0.0].max() > 1e-4, "the bed is open behind the toe"


@pytest.mark.parametrize("large_displacement", [False, True])
@pytest.mark.parametrize("stiffness", [None, 1e10])
def test_the_energy_of_a_toe_that_crushes_closes(stiffness, large_displacement):
    result, _ = rocked(0.2, 0.05, stiffness, 0.02, large_displacement=large_displacement)
    last, first = result.increments[-1], result.under_gravity
    assert result.effort.energy_error < 0.01
    total = last.internal_energy + last.dissipated_energy + last.other_work + last.energy_error + last.lost_in_motion
    assert last.external_work == pytest.approx(total, rel=1e-9)
    crushing = result.model.mortar.strength[np.isfinite(result.model.mortar.strength)] @ last.closing
    assert crushing > 0.1 * (last.external_work - first.external_work)
    assert last.dissipated_energy == pytest.approx(crushing, rel=0.05), "friction takes little"


def test_a_toe_in_large_displacements_goes_on_crushing():
    """The multiplier falls as (b - x) / h does with the turn: the resultant stays x / 2 from the moving edge."""
    result, _ = rocked(0.1, 0.05, None, 0.1, 0.02, large_displacement=True)
    rotation = np.arcsin(result.curve.control_displacement_m / HEIGHT)
    expected = WIDTH * 0.9 / HEIGHT - np.tan(rotation)
    later = rotation > 0.005
    assert np.count_nonzero(later) > 5
    assert result.curve.base_shear_N[later] / WEIGHT == pytest.approx(expected[later], rel=0.02)


@pytest.mark.parametrize("share", [0.02, 0.05, 0.1, 0.2, 0.4])
@pytest.mark.parametrize("large_displacement", [False, True])
def test_the_default_mesh_is_as_fine_as_a_toe_takes(share, large_displacement):
    """Elements of 0.2 m, two on a bed of 0.4 m, gave 25 % too much with a toe of a fifth of it."""
    joints = JointClass(compressive_strength=WEIGHT / (share * WIDTH * THICKNESS))
    wall = assemblage_of(stack((WIDTH, HEIGHT), friction=2.0), joints)
    stepping = SteppingSettings(final_displacement=2e-3, large_displacement=large_displacement)
    pushed = push(wall, analyse(wall), one_body_per_block(wall), stepping=stepping)
    assert pushed.summary.peak_multiplier == pytest.approx(WIDTH * (1 - share) / HEIGHT, rel=0.01)
    assert pushed.summary.toe_error < 0.005
    assert pushed.summary.valid


def test_a_toe_finer_than_the_mesh_is_told():
    """An end node that stands for a quarter of the width carries all: the FE take the resultant to the edge. Eight
    elements take that of a toe of 0.4 of the width farther from it, not nearer."""
    coarse, _ = rocked(0.1, 0.2)
    fine, _ = rocked(0.4, 0.05)
    bodies = bodies_of(
        stack((WIDTH, HEIGHT), friction=2.0), JointClass(compressive_strength=WEIGHT / (0.1 * WIDTH * THICKNESS))
    )
    assert coarse.peak == pytest.approx(WIDTH / HEIGHT, rel=1e-3), "nothing crushes"
    moment = coarse.peak * WEIGHT * HEIGHT / 2
    excess = coarse_toes(bodies, coarse.model.contacts, coarse.increments[-1], moment)
    assert excess == pytest.approx(0.05 * WIDTH * WEIGHT / moment, rel=1e-3)
    assert excess == pytest.approx(1 - WIDTH * 0.9 / HEIGHT / coarse.peak, rel=0.01), "what the peak is too high by"
    bodies = bodies_of(
        stack((WIDTH, HEIGHT), friction=2.0), JointClass(compressive_strength=WEIGHT / (0.4 * WIDTH * THICKNESS))
    )
    assert coarse_toes(bodies, fine.model.contacts, fine.increments[-1], moment) == 0.0
    assert fine.peak < WIDTH * 0.6 / HEIGHT
