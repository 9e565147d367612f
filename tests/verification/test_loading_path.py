"""The path under growing load: closed forms, published values, images of a wall, what comes loose, what is soft.

The elastic answer before anything slides is computed here by another road: a dense matrix put together block by block.
"""

from __future__ import annotations

from dataclasses import replace
from math import cos, radians, sin

import numpy as np
import pytest

from orchestrator.limit_analysis import LimitAnalysisSettings, analyse
from orchestrator.limit_analysis.gravity import associative_optimum, problem_of
from orchestrator.limit_analysis.paper.equilibrium import assemble_equilibrium
from orchestrator.limit_analysis.paper.yield_conditions import coulomb
from orchestrator.limit_analysis.search.elastic_contact import (
    STIFFNESSES,
    elastic_wall,
    joint_forces,
    tried,
    undeformed,
)
from orchestrator.limit_analysis.search.implicit_step import (
    INTERIOR_STEPS,
    Task,
    implicit_step,
    interior_step,
    newton_step,
)
from orchestrator.limit_analysis.search.loading import loaded, lower_of
from orchestrator.limit_analysis.search.loading_path import load_path
from orchestrator.limit_analysis.validation import validate
from orchestrator.loads import loads_on
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.patterns import IrregularCourses, irregular_courses
from orchestrator.present.answer import answer_of_limit
from tests.support.limit_analysis_cases import (
    analysed,
    answers,
    assemblage_of,
    audit,
    box,
    case,
    transformed,
    weight_along,
)
from tests.support.pushover_chain import model_of
from tests.support.pushover_chain import run as pushed

FLOOR = box(-3.0, -0.5, 6.0, 0.5)
PUBLISHED = {
    "ferris_tinloi_wall1": 0.640,
    "ferris_tinloi_wall3": 0.356,
    "ferris_tinloi_wall4": 0.264,
    "ferris_tinloi_wall6": 0.2963,
}


@pytest.mark.parametrize("name", PUBLISHED)
def test_published_walls(name):
    found = answers(name)
    assert found.headline is found.path
    assert found.path.load_multiplier == pytest.approx(PUBLISHED[name], abs=1e-3)
    assert found.last_rest == pytest.approx(found.path.load_multiplier, abs=1.1e-3 * found.associative.load_multiplier)
    assert found.local_failures == ()
    assert found.interval is None


@pytest.mark.parametrize("stiffness", STIFFNESSES)
@pytest.mark.parametrize(("width", "height", "friction"), [(0.5, 1.0, 0.65), (1.0, 1.0, 0.65), (0.4, 0.175, 0.3)])
def test_one_block_slides_or_overturns(width, height, friction, stiffness):
    problem = problem_of(assemblage_of([FLOOR, box(-width / 2, 0, width, height)], friction=friction))
    expected = min(friction, width / height)
    path = load_path(problem, expected, stiffness)
    assert path.state.converged
    assert path.state.load_multiplier == pytest.approx(expected, rel=1e-6)
    assert path.last_rest == pytest.approx(expected, rel=2e-3)
    assert path.last_rest <= expected * (1 + 1e-9)


def test_elastic_displacement_of_a_wall_whose_joints_stay_closed():
    """A glued wall of three stones: (B K B^T) u = loads, with K of the springs, put together here stone by stone."""
    wall = assemblage_of([FLOOR, box(-1, 0, 1, 0.5), box(0, 0, 1, 0.5), box(-0.5, 0.5, 1, 0.5)], friction=50.0)
    problem = problem_of(wall)
    springs = elastic_wall(wall, problem.equilibrium, problem.friction)
    free, shapes = [1, 2, 3], [np.array(block.polygon) for block in wall.wall.blocks]
    size = problem.equilibrium.block_length
    K = np.zeros((12, 12))
    for k, (i, j) in enumerate(wall.joints.pairs):
        (x0, y0), (x1, y1) = wall.joints.start[k], wall.joints.end[k]
        length = np.hypot(x1 - x0, y1 - y0)
        t = np.array([x1 - x0, y1 - y0]) / length
        n = np.array([t[1], -t[0]])
        normal, along = springs.stiffness.reshape(-1, 3, 2)[k].sum(axis=0)
        points = [(x0, y0), ((x0 + x1) / 2, (y0 + y1) / 2), (x1, y1)]
        shares = [1 / 6, 2 / 3, 1 / 6]
        for point, direction, stiffness in (
            *((point, n, share * normal) for point, share in zip(points, shares, strict=True)),
            (points[1], t, along),
        ):
            row = np.zeros(12)
            for block, sign in ((i, -1.0), (j, 1.0)):
                if block in free:
                    arm = np.array(point) - shapes[block].mean(axis=0)
                    turn = (arm[0] * direction[1] - arm[1] * direction[0]) / size
                    row[3 * block : 3 * block + 3] += sign * np.array([*direction, turn])
            K += stiffness * np.outer(row, row)
    K = K[3:, 3:]
    press = 40.0 * problem.equilibrium.row_scale * problem.equilibrium.dead_load / problem.equilibrium.unit_force
    expected = np.linalg.solve(K, press)
    trial = tried(springs, undeformed(springs), expected)
    closed = trial.forces[:, 0] > 1e-3
    assert closed.sum() >= 9
    carried = joint_forces(springs, trial.forces).ravel()
    residual = problem.equilibrium.matrix @ carried * problem.equilibrium.row_scale - press
    opened = np.abs(springs.stiffness[~closed] * trial.rates[~closed]).max(initial=0.0)
    assert np.abs(residual).max() <= opened + 1e-3


@pytest.mark.parametrize("eccentricity", [0.0, 0.1, 0.16])
def test_a_joint_turns_like_one_that_is_pressed_all_along(eccentricity):
    """Navier: N at a distance e from the middle presses the ends with N (1 -+ 6 e / L) / L, none open below e = L/6."""
    wall = assemblage_of([FLOOR, box(0.0, 0.0, 1.0, 0.5)])
    problem = problem_of(wall)
    springs = elastic_wall(wall, problem.equilibrium, problem.friction)
    size, stiffness = problem.equilibrium.block_length, springs.stiffness[:, 0].sum()
    pressed = 100.0
    sinks, turns = pressed / stiffness, 12.0 * pressed * eccentricity / stiffness
    trial = tried(springs, undeformed(springs), np.array([0.0, -sinks, -turns * size]))
    start, end, _ = joint_forces(springs, trial.forces)[0]
    assert start + end == pytest.approx(pressed, rel=1e-3)
    assert abs(end - start) / 2 == pytest.approx(pressed * eccentricity, rel=1e-3, abs=1e-6)
    assert (trial.forces[:, 0] > 1e-2).all()


def test_the_first_state_on_the_path_is_met_and_no_later_one():
    """22 stones along -x: micro-FE has its peak there; beyond a fall of the wall there are other rests, up to 0.569."""
    wall = irregular_courses(IrregularCourses(0.8, 0.6, seed=1))
    wall = replace(wall, blocks=tuple(replace(b, polygon=(b.polygon * [-1.0, 1.0])[::-1]) for b in wall.blocks))
    problem = problem_of(find_joints(wall, JointSettings()))
    bound = associative_optimum(problem).load_multiplier
    peak = pushed(model_of(wall), 5e-3).peak
    for stiffness in STIFFNESSES:
        path = load_path(problem, bound, stiffness)
        assert path.state.converged
        assert path.state.load_multiplier == pytest.approx(peak, rel=5e-3)


@pytest.mark.parametrize("advance", [None, 0.5])
def test_both_methods_of_a_step_find_one_position(advance):
    wall = case("ferris_tinloi_wall3")
    problem = problem_of(wall)
    springs = elastic_wall(wall, problem.equilibrium, problem.friction)
    nothing = np.zeros(springs.problem.B.shape[0])
    at_rest = undeformed(springs)
    for drag in (1.0, 1e-1, 1e-2, 1e-3, 1e-5, 1e-7):
        at_rest = implicit_step(springs, at_rest, Task(0.0, drag), nothing).position
    task = Task(0.5, 1e-2 if advance is None else 0.0, advance)
    one = newton_step(springs, at_rest, task, nothing)
    other = interior_step(springs, at_rest, task, 1.0)
    assert one.found
    assert other.found
    assert other.factorisations <= INTERIOR_STEPS
    moved = one.position.displacements - at_rest.displacements
    gone = other.position.displacements - at_rest.displacements
    assert gone == pytest.approx(moved, abs=2e-3 * np.abs(moved).max())
    assert other.multiplier == pytest.approx(one.multiplier, rel=1e-3)


def irregular():
    return find_joints(irregular_courses(IrregularCourses(1.2, 1.0, friction=0.6, seed=3)), JointSettings())


@pytest.mark.parametrize(
    ("change", "times"),
    [
        pytest.param(lambda polygon: 0.1 * polygon, 0.1, id="scale 0.1"),
        pytest.param(lambda polygon: 1e2 * polygon, 1e2, id="scale 100"),
        pytest.param(lambda polygon: polygon + [300.0, 40.0], 1.0, id="shift"),
    ],
)
def test_headline_does_not_depend_on_scale_or_place(change, times):
    """Young's modulus is scaled as lengths are, for the weight to press stones by the same part of themselves."""
    here = analyse(irregular()).headline.load_multiplier
    there = analyse(transformed(irregular(), change), elastic_modulus=times * 3.5e9)
    assert there.headline.load_multiplier == pytest.approx(here, rel=1e-6)


def test_headline_of_a_mirrored_wall_and_of_one_with_other_weights():
    wall = irregular()
    here = analyse(wall).headline.load_multiplier
    behind = transformed(wall, lambda polygon: polygon * [-1.0, 1.0])
    assert analysed(behind, -1).headline.load_multiplier == pytest.approx(here, rel=1e-6)
    polygons = [block.polygon for block in wall.wall.blocks]
    fixed = [number for number, block in enumerate(wall.wall.blocks) if block.fixed]
    light = assemblage_of(polygons, fixed, wall.wall.friction, 0.07, 3.0)
    assert analyse(light).headline.load_multiplier == pytest.approx(here, rel=1e-6)


def test_headline_of_a_wall_with_openings_its_mirror_image_and_another_numbering():
    """71 stones round two openings, whose path slides and rocks long before its end."""
    openings = ((0.5, 1.0, 0.0, 1.2), (1.6, 2.1, 0.6, 1.3))
    pattern = IrregularCourses(2.6, 1.8, openings=openings, widths=(0.2, 0.4), heights=(0.15, 0.2), seed=7)
    wall = find_joints(irregular_courses(pattern), JointSettings())
    settings = LimitAnalysisSettings(sequence_blocks=1, search_blocks=1)
    here = analyse(wall, settings).headline.load_multiplier
    behind = transformed(wall, lambda polygon: polygon * [-1.0, 1.0])
    assert analyse(behind, settings, weight_along(behind, -1)).headline.load_multiplier == pytest.approx(here, rel=1e-6)
    order = np.random.default_rng(1).permutation(len(wall.wall.blocks))
    stones = [wall.wall.blocks[number] for number in order]
    fixed = [number for number, block in enumerate(stones) if block.fixed]
    shuffled = assemblage_of([block.polygon for block in stones], fixed, wall.wall.friction)
    assert analyse(shuffled, settings).headline.load_multiplier == pytest.approx(here, rel=1e-6)


def test_block_on_a_slope_that_turns_with_the_wall():
    """tan(phi - angle) down the slope; both for a slope that was drawn and one that was turned."""
    angle, friction = radians(8.0), 0.4
    turn = np.array([[cos(angle), -sin(angle)], [sin(angle), cos(angle)]])
    stones = [np.array(polygon) @ turn.T for polygon in (box(-3, -0.5, 6, 0.5), box(-0.5, 0, 1.0, 0.4))]
    found = analysed(assemblage_of(stones, friction=friction), -1)
    assert found.headline.load_multiplier == pytest.approx(np.tan(np.arctan(friction) - angle), rel=1e-6)


def loose_top(friction=0.65):
    """A stack of 1 x 2 m in ten stones, which tips at 0.5, with a slender stone on top: 0.06 / 0.24 = 0.25."""
    stones = [box(-0.5, 0.2 * course, 1.0, 0.2) for course in range(10)]
    return assemblage_of([FLOOR, *stones, box(-0.03, 2.0, 0.06, 0.24)], friction=friction)


def test_a_stone_that_tips_first_is_a_local_failure_and_the_wall_goes_on():
    found = analyse(loose_top())
    (failure,) = found.local_failures
    assert failure.stones == (11,)
    assert failure.share == pytest.approx(0.0144 / 2.0144, rel=1e-9)
    assert failure.multipliers == pytest.approx((0.25, 0.25), rel=2e-3)
    assert found.headline.load_multiplier == pytest.approx(0.5, rel=1e-6), "what is left tips about its toe"
    assert found.headline.mechanism.velocities[11] == pytest.approx(0.0)
    assert any("local failure at 0.25" in remark and ": stone 11 (" in remark for remark in found.remarks)


def test_the_wall_without_the_stone_has_the_same_state():
    """Taken away with its weight: audited on the wall without it, by code that shares nothing with the program."""
    whole = analyse(loose_top())
    blocks = [block.polygon for block in loose_top().wall.blocks[:-1]]
    alone = assemblage_of(blocks)
    assert whole.headline.load_multiplier == pytest.approx(analyse(alone).headline.load_multiplier, rel=1e-9)
    found = audit(alone, analyse(alone).headline)
    assert found.unbalanced < 1e-9
    assert found.power == pytest.approx(found.friction_power, abs=1e-6)


def test_wedges_that_slide_out_under_a_rest_that_no_state_closed_take_with_them_what_falls_then():
    """Herringbone that ends in wedges steeper than friction: load pushes two of them out on the left, and then the two
    on the right find no rest under their weight. The other stones are as if they had been drawn without them."""
    wall = case("herringbone_44_stones")
    found = analysed(wall, -1)
    (failure,) = found.local_failures
    assert failure.stones == (5, 22, 23, 40)
    assert failure.share == pytest.approx(0.15 / 4.32, rel=1e-6)
    assert not failure.state.converged
    assert not found.geometry_decides
    stones = [block.polygon for block in wall.wall.blocks if block.id not in failure.stones]
    alone = analysed(assemblage_of(stones, friction=0.6, thickness=0.5), -1)
    assert found.headline.converged
    assert found.headline.load_multiplier == pytest.approx(alone.headline.load_multiplier, rel=1e-6)
    assert alone.headline.load_multiplier == pytest.approx(alone.associative.load_multiplier, rel=1e-6)
    assert alone.associative.load_multiplier == pytest.approx(0.55895, abs=1e-5)


def test_the_bound_beside_the_headline_is_that_of_the_same_wall():
    """Irregular courses with a slender stone on top: without it everything is as if it had never been drawn."""
    wall = irregular()
    stones = [block.polygon for block in wall.wall.blocks]
    fixed = [number for number, block in enumerate(wall.wall.blocks) if block.fixed]
    top = max(float(polygon[:, 1].max()) for polygon in stones)
    slender = box(0.57, top, 0.06, 0.6)
    alone = analyse(assemblage_of(stones, fixed, friction=wall.wall.friction))
    with_it = analyse(assemblage_of([*stones, slender], fixed, friction=wall.wall.friction))
    (failure,) = with_it.local_failures
    assert failure.stones == (len(stones),)
    assert failure.state.load_multiplier == pytest.approx(0.1, rel=1e-6)
    assert failure.state.mechanism.velocities[:-1] == pytest.approx(0.0, abs=1e-6)
    assert with_it.headline.load_multiplier == pytest.approx(alone.headline.load_multiplier, rel=1e-6)
    assert with_it.bound.load_multiplier == pytest.approx(alone.associative.load_multiplier, rel=1e-6)
    assert with_it.associative.load_multiplier == pytest.approx(0.1, rel=1e-6), "of the wall with the stone"
    assert with_it.headline.load_multiplier <= with_it.bound.load_multiplier


def test_stopping_at_the_first_mechanism_however_small():
    found = analyse(loose_top(), LimitAnalysisSettings(local_share=0.0))
    assert found.local_failures == ()
    assert found.headline.load_multiplier == pytest.approx(0.25, rel=1e-6)
    wall = loose_top()
    checked = validate(wall, assemble_equilibrium(wall), coulomb(wall), found.headline)
    assert checked.complaints == ()


def test_a_larger_share_is_no_local_failure():
    stones = [FLOOR, box(-0.5, 0.0, 1.0, 1.0), box(-0.15, 1.0, 0.3, 0.6)]
    found = analyse(assemblage_of(stones))
    assert found.local_failures == ()
    assert found.headline.load_multiplier == pytest.approx(0.5, rel=1e-6)


def test_load_is_never_above_the_bound_and_displacements_grow():
    problem = problem_of(case("ferris_tinloi_wall4"))
    bound = answers("ferris_tinloi_wall4").associative.load_multiplier
    path = load_path(problem, bound)
    assert path.state.load_multiplier <= bound
    assert (np.diff(path.multipliers) > 0).all()
    assert path.displacements[0] == path.displacements[1] == 1.0
    for multiplier, forces in zip(path.multipliers, path.forces, strict=True):
        assert problem.equilibrium.residual(forces, multiplier) < 1e-6 / len(problem.equilibrium.free_blocks) * 10
        assert problem.friction.excess(forces) < 1e-9 * problem.equilibrium.unit_force


def test_stones_that_hang_by_friction_go_down():
    """keystone_wall: nothing but self-stress that no history brings about holds its two middle stones, a local part."""
    (failure,) = answers("keystone_wall_13x9").local_failures
    assert (len(failure.stones), failure.multipliers) == (2, (0.0, 0.0))


def test_a_wall_that_hangs_by_friction_has_no_path():
    """The same where no part is local."""
    found = analyse(case("keystone_wall_13x9"), LimitAnalysisSettings(local_share=0.0))
    assert found.path is None
    assert len(found.going_down) == 2
    stones = ", ".join(map(str, found.going_down))
    said = f"loading: no state of rest under the dead load was found: stones {stones} go down unless wedged"
    assert said in found.remarks
    assert answer_of_limit(found).startswith("Whether it stands is open; λ = ")


def test_a_limit_state_counts_before_a_lower_rest_that_none_closed():
    """Both in the interval; of two states the lower counts."""
    tower = problem_of(case("tower_5_blocks"))
    closed = loaded(tower, loads_on(case("tower_5_blocks").wall), associative_optimum(tower), 0.05, 500, False)
    multiplier = closed.state.load_multiplier
    lower = replace(closed, state=replace(closed.state, load_multiplier=0.5 * multiplier))
    rest = replace(lower, state=replace(lower.state, converged=False))
    for found in ([closed, rest], [rest, closed]):
        assert lower_of(found).state.load_multiplier == multiplier
        assert lower_of(found).spread == (0.5 * multiplier, multiplier)
    assert lower_of([closed, lower]).state.load_multiplier == 0.5 * multiplier
