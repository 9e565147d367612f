"""Running-bond walls under gravity and a growing horizontal load, every stone a body."""

from dataclasses import replace

import numpy as np
import pytest
from mpi4py import MPI

from orchestrator import push
from orchestrator.limit_analysis import analyse
from orchestrator.macroblocks.bodies import make_bodies
from orchestrator.macroblocks.criteria import one_body, one_body_per_block
from orchestrator.masonry.patterns import running_bond
from orchestrator.pushover.path.body_overlap import DisplacedOutlines
from orchestrator.pushover.path.curve_checks import OVERLAP, check_curve, equilibrium_error
from orchestrator.pushover.path.stepping import Pushover
from orchestrator.pushover.settings import NewtonSettings, SteppingSettings
from orchestrator.pushover.solve.linear_system import LinearSystem
from tests.support.pushover_chain import Run, assemblage_of, model_of, run


def overlap(result: Run) -> float:
    """Largest depth of an overlap at the end, over the size of the smaller stone."""
    last = result.increments[-1]
    assemblage = assemblage_of(running_bond(5, 6))
    bodies = make_bodies(assemblage, one_body_per_block(assemblage))
    return DisplacedOutlines(bodies, result.model.meshes).largest_overlap(last.displacement, last.fallen).share


@pytest.fixture(scope="module")
def wide() -> Run:
    """5 x 6 blocks: sliding and overturning mixed."""
    return run(model_of(running_bond(5, 6)), final_displacement=5e-3)


@pytest.mark.parametrize(
    ("courses", "blocks", "associative", "peak"),
    [
        (6, 33, 0.6500, 0.6500),  # slides
        (10, 55, 0.5928, 0.579),  # an independent FE prototype; this program: 0.5773
    ],
)
def test_peak_against_limit_analysis_and_an_independent_prototype(courses, blocks, associative, peak):
    wall = running_bond(5, courses)
    assert sum(not block.fixed for block in wall.blocks) == blocks
    limit = analyse(assemblage_of(wall))
    assert limit.associative.load_multiplier == pytest.approx(associative, abs=1e-4)
    result = run(model_of(wall), final_displacement=10e-3)
    assert result.curve.control_displacement_m[-1] == pytest.approx(10e-3, rel=2e-3)
    assert result.peak <= limit.associative.load_multiplier + 1e-6
    assert result.peak == pytest.approx(peak, rel=5e-3)
    assert result.peak == pytest.approx(limit.headline.load_multiplier, rel=5e-3)


@pytest.mark.parametrize("far", [1e3, 1e6])
def test_a_wall_far_from_the_origin_has_the_same_peak(far):
    """In coordinates of a national grid, checks included."""

    def pushed(away):
        wall = running_bond(4, 5)
        blocks = tuple(replace(block, polygon=block.polygon + away) for block in wall.blocks)
        assemblage = assemblage_of(replace(wall, blocks=blocks))
        stepping = SteppingSettings(final_displacement=5e-3)
        return push(assemblage, analyse(assemblage), one_body_per_block(assemblage), stepping=stepping)

    here, there = pushed(0.0), pushed(far)
    assert there.complaints == ()
    assert there.summary.max_penetration_over_size < 1e-6
    assert there.capacity.peak_multiplier == pytest.approx(here.capacity.peak_multiplier, rel=1e-4)


def test_a_tall_thin_wall_rests_under_its_weight():
    """86 times as high as thick: the top sinks by rho g h^2 / (2 E), in large displacements as in small ones.

    The wall leans out of its plane by 1 mm, because its tetrahedra are not symmetric; nothing may amplify that.
    """
    wall = running_bond(2, 49)
    height = 49 * 0.175
    sinking = 25e3 * height**2 / (2 * 3.5e9)
    tops = []
    for large in (False, True):
        model = model_of(wall, mesh_size=0.1, large_displacement=large)  # 0.2 m: 4 % too soft; 0.06 m: 0.2 %
        result = run(model, final_displacement=1e-2, largest_increments=10)
        rest = result.under_gravity
        assert rest.number <= 10
        nodes = model.meshes.nodes
        highest = nodes[:, 1] > height - 1e-6
        tops.append(rest.displacement[: len(nodes)][highest].mean(axis=0))
        assert -tops[-1][1] == pytest.approx(sinking, rel=0.02)
    assert tops[1] == pytest.approx(tops[0], rel=0.01, abs=2e-6)


def test_courses_that_slide_in_large_displacements_reach_the_end():
    """Contacts of all courses stick and slip in turn at one multiplier, where plain Newton goes in circles."""
    wall = running_bond(5, 6)
    result = run(model_of(wall, large_displacement=True), final_displacement=20e-3)
    assert result.curve.control_displacement_m[-1] == pytest.approx(20e-3, rel=2e-3)
    assert result.peak == pytest.approx(0.65, rel=1e-3), "the whole wall slides at the coefficient of friction"
    assert overlap(result) <= OVERLAP
    check_curve(result.curve, None, result.effort.energy_error, None)


def test_curve_is_quasi_static_and_in_equilibrium(wide):
    check_curve(wide.curve, None, wide.effort.energy_error, 0.65 * wide.model.weight)
    assert equilibrium_error(wide.curve) < 1e-3
    assert all(np.all(i.normal_force >= 0) for i in wide.increments)


def test_load_to_the_left_on_the_mirrored_wall_gives_nearly_the_same_curve(wide):
    """The wall is its own mirror image; its tetrahedra are not, which leaves a difference of their stiffness only."""
    left = run(model_of(running_bond(5, 6), direction=-1), final_displacement=5e-3)
    assert left.peak == pytest.approx(wide.peak, rel=2e-3)


def test_one_body_slides_at_the_coefficient_of_friction():
    wall = running_bond(5, 10)
    result = run(model_of(wall, one_body(assemblage_of(wall))), final_displacement=1e-3)
    assert result.peak == pytest.approx(0.65, abs=1e-4)


@pytest.mark.parametrize("phase", ["gravity", "load", "displacement"])
def test_any_stored_increment_can_be_continued(wide, phase):
    """Going on from a stored increment gives the increments that followed it, to solver accuracy."""
    of_phase = [k for k, i in enumerate(wide.increments) if i.phase == phase]
    start = of_phase[len(of_phase) // 2]
    settings = SteppingSettings(final_displacement=5e-3)
    with LinearSystem(wide.model, MPI.COMM_SELF) as system:
        onward = Pushover(wide.model, system, NewtonSettings(), settings).increments(wide.increments[start])
        for expected in wide.increments[start + 1 : start + 6]:
            found = next(onward)
            assert (found.number, found.phase) == (expected.number, expected.phase)
            assert found.base_shear == pytest.approx(expected.base_shear, rel=1e-9, abs=1e-6)
            assert found.displacement == pytest.approx(expected.displacement, rel=1e-9, abs=1e-13)
