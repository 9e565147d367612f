"""Rigid blocks in large displacements: closed forms of rocking and sliding, images of a wall, micro-FE.

A block of width b and height h that rocks about its toe, R = sqrt(b^2 + h^2)/2, tan(alpha) = b/h: after a turn theta
it bears lambda = tan(alpha - theta), and its centroid has moved by u = R (sin(alpha) - sin(alpha - theta)).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from orchestrator import ElasticSettings, MeshSettings, SteppingSettings, one_body_per_block, push
from orchestrator.app.cli import main
from orchestrator.limit_analysis import LimitAnalysisSettings, analyse
from orchestrator.limit_analysis.gravity import associative_optimum, problem_of
from orchestrator.limit_analysis.search.elastic_contact import (
    SPREAD,
    STIFFNESSES,
    elastic_wall,
    moving_wall,
)
from orchestrator.limit_analysis.search.overdamped import FIRST_DRAG, MOST_IN_ALL, REST_BUDGET
from orchestrator.limit_analysis.search.pushing import STEPS
from orchestrator.limit_analysis.search.rigid_pushover import DisplacedWallSearch, rigid_pushover
from orchestrator.loads import LoadSettings, loads_on
from orchestrator.masonry.joints import JointClass, JointSettings, find_joints
from orchestrator.masonry.patterns import IrregularCourses, irregular_courses
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.masonry.wall import Block, Wall
from orchestrator.present.answer import answer_of_limit
from orchestrator.storage import write_blocks
from tests.support.limit_analysis_cases import FLOOR, assemblage_of, box, case, mirrored, tower, transformed
from tests.support.paths import PROJECT

STIFF = 3.5e13


def pushed_rigid(wall, elastic_modulus=3.5e9, stiffness=STIFFNESSES[0]):
    problem = replace(problem_of(wall), elastic_modulus=elastic_modulus)
    return rigid_pushover(problem, associative_optimum(problem).load_multiplier, stiffness)


def rocking(width, height, moved):
    radius, angle = np.hypot(width, height) / 2, np.arctan2(width, height)
    return np.tan(np.arcsin(np.sin(angle) - moved / radius))


@pytest.mark.parametrize("stiffness", STIFFNESSES)
@pytest.mark.parametrize(("width", "height", "blocks"), [(0.5, 1.0, 1), (1.0, 4.0, 1), (0.3, 0.25, 4)])
def test_a_stiff_block_or_tower_rocks_as_a_rigid_one(width, height, blocks, stiffness):
    found = pushed_rigid(tower(width, height, blocks), STIFF, stiffness)
    total = height * blocks
    assert found.is_past
    assert found.peak == pytest.approx(width / total, rel=2e-3)
    turning = found.displacement > 1e-3 * width
    expected = rocking(width, total, found.displacement[turning])
    assert turning.sum() >= 5
    assert found.multiplier[turning] == pytest.approx(expected, abs=2e-3 * width / total)
    assert found.multiplier[-1] < 0.81 * found.peak


def test_a_block_that_slides_bears_the_same_wherever_it_is():
    """It is followed for a thirtieth of its height: by then it has failed."""
    height = 0.5
    found = pushed_rigid(tower(1.0, height, friction=0.3), STIFF)
    slides = found.displacement > 1e-3
    assert found.multiplier[slides] == pytest.approx(0.3, rel=1e-6)
    assert found.is_past
    assert found.displacement[-1] > height / 30


def test_a_block_that_falls_under_the_load_held_above_its_peak_bears_what_it_bears_at_rest_there():
    """The drag takes the rest of the load, by work. It has passed its peak then, and is not followed far."""
    width, height = 0.5, 2.0
    problem = replace(problem_of(tower(width, height)), elastic_modulus=STIFF)
    search = DisplacedWallSearch(problem.measured_by_load(width / height), STIFFNESSES[0])
    search.far, scale = np.inf, search.wall.problem.per_multiplier
    stands = search.gravity()
    peak = replace(stands, multiplier=scale * width / height)
    falls = search.rest(stands.position, 1.01 * peak.multiplier, FIRST_DRAG, MOST_IN_ALL, search.too_little(peak))
    assert search.spent < 2 * REST_BUDGET
    assert search.is_past(peak, falls)
    bears = rocking(width, height, search.wall.unit * search.moved(falls.position))
    assert bears < 0.9 * width / height
    assert falls.borne / scale == pytest.approx(bears, abs=2e-3 * width / height)


def springy(width, height, modulus, distance):
    """Return the largest multiplier of a block on a springy base: lambda h/2 = e - theta h/2, with the weight at a
    distance e from the middle of a base on three springs without tension (1/6, 2/3, 1/6 of the area); over turns of the
    base, each balanced by bisection. distance: that from centroid to centroid, which the springs stand for."""
    weight = 20e3 * width * height  # N per m of thickness
    springs = SPREAD * modulus * width / distance * np.array([1.0, 4.0, 1.0]) / 6.0
    places = width * np.array([-0.5, 0.0, 0.5])

    def bears(turn):
        low, high = -width * turn, weight / springs.sum() + width * turn
        for _ in range(80):
            sinks = 0.5 * (low + high)
            carried = springs * np.maximum(sinks + turn * places, 0.0)
            low, high = (low, sinks) if carried.sum() > weight else (sinks, high)
        return carried @ places / weight / (height / 2) - turn

    return max(bears(turn) for turn in np.geomspace(1e-4, 0.2, 2000))


def test_a_block_on_a_springy_base_loses_what_its_turn_takes():
    most = springy(0.5, 2.0, 8e6, 1.0)
    found = pushed_rigid(tower(0.5, 2.0), 8e6)
    assert most < 0.9 * 0.25
    assert found.peak == pytest.approx(most, abs=0.5 * 0.25 / STEPS), "a sharp peak is met to half a load step"


def test_a_stone_that_overturns_before_the_wall_slides_is_a_local_failure():
    """In small displacements it would overturn at 0.25, and the block under it slides on the floor at 0.24 before."""
    wall = assemblage_of([FLOOR, box(-2.5, 0.0, 5.0, 1.0), box(-0.1, 1.0, 0.2, 0.8)]).wall
    materials = ("floor", "stone", "stone")
    blocks = tuple(replace(block, material=name) for block, name in zip(wall.blocks, materials, strict=True))
    sliding = JointSettings(classes=(JointClass(between=("floor", "stone"), friction=0.24),))
    found = analyse(find_joints(replace(wall, blocks=blocks), sliding), elastic_modulus=4e6)
    (failure,) = found.local_failures
    assert failure.stones == (2,)
    assert failure.share == pytest.approx(0.16 / 5.16, rel=1e-9)
    spread = 2.5 * 0.2 * 0.5 * np.log1p(2 * 0.5 / 0.2)  # from 0.2 m into a block of 5 m: stone_compliance.py
    most = springy(0.2, 0.8, 4e6, 0.4 + spread)
    assert most < 0.95 * 0.24
    assert failure.multipliers == pytest.approx((most, most), abs=0.5 * 0.24 / STEPS)
    assert found.headline.load_multiplier == pytest.approx(0.24, rel=1e-6), "what is left slides"


def irregular():
    return find_joints(irregular_courses(IrregularCourses(1.2, 1.0, friction=0.6, seed=3)), JointSettings())


def test_a_wall_at_another_scale_with_its_stiffness_scaled_has_the_same_curve_up_to_its_peak():
    """Lengths times s, Young's modulus times s: stresses of the weight over E, and all angles, are the same."""
    here = pushed_rigid(irregular())
    there = pushed_rigid(transformed(irregular(), lambda polygon: 10.0 * polygon), 3.5e10)
    assert there.peak == pytest.approx(here.peak, rel=1e-6)
    rising = slice(int(here.multiplier.argmax()) + 1)
    assert there.displacement[rising] == pytest.approx(10.0 * here.displacement[rising], rel=1e-4, abs=1e-9)


def test_a_mirrored_wall_has_the_same_curve():
    settings = LimitAnalysisSettings(search_blocks=1, sequence_blocks=1)
    here = analyse(mirrored(irregular()), settings)
    there = analyse(irregular(), settings, loads_on(irregular().wall, LoadSettings("-x")))
    assert there.rigid_curve == pytest.approx(here.rigid_curve, rel=1e-6, abs=1e-9)


def test_gaps_and_slips_follow_from_where_blocks_are():
    """B^T is the slope of openings and slips wherever blocks have moved: finite differences."""
    problem = problem_of(case("ferris_tinloi_wall3"))
    drawn = elastic_wall(problem.assemblage, problem.equilibrium, problem.friction)
    wall = moving_wall(problem.assemblage, problem.equilibrium, problem.friction)
    assert abs(wall.problem.B - drawn.problem.B).max() < 1e-12
    rng = np.random.default_rng(3)
    far = rng.normal(size=wall.problem.B.shape[0]) * 0.05 * problem.equilibrium.block_length / wall.unit
    little = rng.normal(size=len(far)) * 1e-6 * problem.equilibrium.block_length / wall.unit
    there = wall.at(far)
    changed = 0.5 * (wall.joints.rates(far + little) - wall.joints.rates(far - little))
    assert there.rates(far) == pytest.approx(wall.joints.rates(far))
    assert changed == pytest.approx(-(there.problem.B_T @ little).reshape(-1, 2), abs=1e-6 * np.abs(little).max())


def test_a_corner_that_has_turned_off_an_edge_does_not_press_its_extension():
    """A stone turns about its right foot; the stone on its left, as high as its foot, is left behind untouched."""
    stones = [FLOOR, box(0.0, 0.0, 0.5, 1.0), box(-0.5, 0.0, 0.5, 1.0)]
    problem = problem_of(assemblage_of(stones))
    wall = moving_wall(problem.assemblage, problem.equilibrium, problem.friction)
    turn, foot = 0.05, np.array([0.5, 0.0])
    rotation = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    moved = foot + rotation @ (np.array([0.25, 0.5]) - foot) - np.array([0.25, 0.5])
    size = problem.equilibrium.block_length
    there = np.concatenate([[*moved, -turn * size], [0.0, 0.0, 0.0]]) / wall.unit
    between = (wall.joints.i > 0) & (wall.joints.j > 0)
    assert (wall.unit * wall.joints.rates(there)[between, 0] > -1e-12).all()


def test_metres_of_displacement_follow_from_each_stone_s_own_modulus_and_from_mortar():
    """One block on a rigid floor, K = t L / (d/E + 1/k) with d half its height: a mean joint has the stiffness 2, so
    that displacement 1 is twice the weight over K."""
    wall = tower(0.5, 1.0).wall
    stone = replace(wall, blocks=(wall.blocks[0], replace(wall.blocks[1], elastic_modulus=1e9)))
    mortar = JointSettings(classes=(JointClass(normal_stiffness=4e9),))
    weight, area, half = 20e3 * 0.5, 0.5, 0.5
    for given, settings, compliance in (
        (wall, JointSettings(), half / 2e9),
        (stone, JointSettings(), half / 1e9),
        (stone, mortar, half / 1e9 + 1 / 4e9),
    ):
        problem = problem_of(find_joints(given, settings))
        springs = elastic_wall(problem.assemblage, problem.equilibrium, problem.friction, elastic_modulus=2e9)
        assert springs.unit == pytest.approx(2.0 * weight * compliance / area)


def test_a_picture_of_a_curve_that_is_no_longer_there_goes(tmp_path):
    (tmp_path / "case.toml").write_text("[wall]\nblocks = 'blocks.json'\n")
    write_blocks(tmp_path, tower(0.5, 1.0).wall)
    for large in ("true", "false"):
        setting = f"limit_analysis.large_displacements={large}"
        command = ["limit", str(tmp_path / "case.toml"), "--set", setting, "--output", str(tmp_path / "out")]
        assert main(command) == 0
        assert (tmp_path / "out" / "figures" / "rigid_pushover.png").exists() == (large == "true")
        assert (tmp_path / "out" / "rigid_pushover.csv").exists() == (large == "true")


def test_a_stone_that_snaps_over_does_not_end_the_curve_of_the_wall():
    """Rubble of 52 stones: beyond the peak a stone falls off its neighbour, which no shorter step goes round. Micro-FE
    has 0.2710 in small displacements (`run --set mesh.size=60mm --set stepping.large_displacement=false`, 70d4e5d); in
    large ones 0.2703, and then a fall by 20 %, if contacts are a tenth as viscous in motion (motion.VISCOUS_FORCE)."""
    found = analyse(case("rubble_52_stones"))
    assert found.headline.converged
    assert found.headline.load_multiplier == pytest.approx(0.2710, rel=2e-3)
    assert found.ways_out["push elsewhere"] == 1
    assert found.rigid_peak == pytest.approx(0.2704, rel=1e-3)
    assert found.rigid_curve[-1, 1] < 0.8 * found.rigid_peak
    high = found.non_associative_range[1]
    assert high == pytest.approx(0.406, rel=1e-3), "what another state bears, and micro-FE with elements of 0.2 m"


@pytest.mark.parametrize(("length", "bears"), [(0.04, 0.7), (0.02, 0.7), (0.01, 0.6992)])
def test_a_large_stone_on_short_pinnings_is_as_stiff_as_in_finite_elements(length, bears):
    """Two stones of 2 m x 1 m with two pinnings between them, which slide; bears: micro-FE (`run --model micro`,
    e270c5a). The force spreads from the pinnings: with prisms as wide as these 0.561 was borne for the last."""
    pinnings = [box(0.0, 1.0, length, length), box(2.0 - length, 1.0, length, length)]
    stones = [FLOOR, box(0.0, 0.0, 2.0, 1.0), *pinnings, box(0.0, 1.0 + length, 2.0, 1.0)]
    found = analyse(assemblage_of(stones, friction=0.7))
    assert found.headline.load_multiplier == pytest.approx(bears, rel=0.03)
    assert found.rigid_peak == pytest.approx(bears, rel=0.03)


def test_a_polygon_of_many_sides_rolls_over_its_short_bed():
    """tan(pi / n); with a prism as wide as its bed 0.049 for 0.0524 was borne."""
    turned = np.pi / 60 * (2 * np.arange(60) - 1) - np.pi / 2
    rim = 0.5 * np.column_stack([np.cos(turned), 1.0 + np.sin(turned)])
    found = analyse(assemblage_of([FLOOR, rim - [0.0, rim[:, 1].min()]], friction=0.7))
    assert found.headline.load_multiplier == pytest.approx(np.tan(np.pi / 60), rel=0.03)


def test_what_a_wall_bears_after_it_has_slid_a_quarter_of_its_height_is_not_its_answer():
    """A slab that leans on a pier with a sloped face: it slides at 0.4252, and jams at 0.454 0.36 m further on."""
    lean = 1.5 / np.tan(np.radians(70.0))
    pier = [[0.0, 0.0], [0.9, 0.0], [0.9, 1.5], [lean, 1.5]]
    slab = [[-0.3, 0.0], [0.0, 0.0], [lean, 1.5], [lean - 0.3, 1.5]]
    ground = [[-2.5, -0.2], [2.0, -0.2], [2.0, 0.0], [-2.5, 0.0]]
    stones = [(0, ground, True), (1, pier, False), (2, slab, False)]
    blocks = tuple(Block(k, np.array(polygon), fixed, 20e3) for k, polygon, fixed in stones)
    found = analyse(find_joints(Wall("leaning slab", blocks, 0.3, 0.5), JointSettings()))
    assert found.headline.converged
    assert found.headline.load_multiplier == pytest.approx(found.associative.load_multiplier, rel=1e-4)
    assert found.rigid_peak == pytest.approx(found.headline.load_multiplier, rel=5e-3)


@pytest.mark.parametrize("name", ["ferris_tinloi_wall1", "ferris_tinloi_wall3"])
def test_published_walls_bear_nearly_their_limit_state(name):
    found = pushed_rigid(case(name))
    assert found.is_past
    assert 0.99 < found.peak / analyse(case(name)).headline.load_multiplier < 1.0


def test_where_deformation_takes_from_the_peak_geometry_decides_and_finite_elements_agree():
    """24 irregular stones: stiff they bear their limit state; of 35 MPa 2 % less, in finite elements 8 %, short
    at pressed edges or short everywhere. No stone of a wall is a column that leans freely."""
    wall, modulus = irregular(), 3.5e7
    alone = LimitAnalysisSettings(search_blocks=1, sequence_blocks=1)
    stiff, soft = analyse(wall, alone), analyse(wall, alone, elastic_modulus=modulus)
    assert stiff.headline.converged
    assert soft.headline.flow_rule == "large_displacements"
    assert soft.interval == (soft.headline.load_multiplier, pytest.approx(stiff.headline.load_multiplier, rel=1e-6))
    assert soft.headline.load_multiplier == soft.rigid_curve[:, 1].max() < 0.98 * stiff.headline.load_multiplier
    assert any(remark.startswith("geometry decides") for remark in soft.remarks)
    assert soft.ways_out["push held"] >= 1, "no curve ends without the load of its peak held"
    assert soft.geometry_decides
    assert not stiff.geometry_decides
    said = answer_of_limit(soft)
    assert said.startswith("Geometry decides: in large displacements the wall bears")
    assert f"is an upper bound in small displacements. Lower is λ = {soft.pressed_peak:.5f}, about" in said
    assert not any("leans on" in remark for remark in soft.remarks)
    peak, fine = (
        push(
            wall, soft, one_body_per_block(wall), mesh=mesh, elastic=ElasticSettings(elastic_modulus=modulus),
            stepping=SteppingSettings(final_displacement=0.02),
        ).capacity.peak_base_shear / soft.horizontal_load
        for mesh in (MeshSettings(), MeshSettings(size=0.025, toe_offset=0.5))
    )  # fmt: skip
    assert peak == pytest.approx(fine, rel=0.015)
    assert 0.9 * stiff.headline.load_multiplier < peak < soft.headline.load_multiplier


def test_what_a_wall_bears_depends_on_the_modulus_in_large_displacements_alone_and_a_remark_says_so():
    """By dimensional analysis angles depend on weight x size / modulus. A tower of 10 MPa loses more than 2 % to its
    lean: ten times as heavy of 100 MPa, or ten times as large of 100 MPa, it bears the same; as large and heavy but of
    1 MPa it bears what the tenfold weight with 10 MPa bears. The limit state in small displacements is b / 2 h always.
    """

    def analysed(modulus, scale=1.0, weight=20e3):
        stone = box(-0.25 * scale, 0.0, 0.5 * scale, 1.0 * scale)
        floor = [(scale * x, scale * y) for x, y in FLOOR]
        return analyse(assemblage_of([floor, stone], friction=3.0, unit_weight=weight), elastic_modulus=modulus)

    soft, heavy, large = analysed(1e7), analysed(1e8, weight=200e3), analysed(1e8, scale=10.0)
    softer, tenfold, stiff = analysed(1e6), analysed(1e7, weight=200e3), analysed(3.5e9)
    for one in (soft, softer, heavy, large, tenfold):
        assert one.geometry_decides
        assert one.drawn.load_multiplier == pytest.approx(0.5, rel=1e-8)
    assert stiff.headline.load_multiplier == pytest.approx(0.5, rel=1e-8)
    for one in (heavy, large):
        assert one.headline.load_multiplier == pytest.approx(soft.headline.load_multiplier, rel=1e-9)
    assert tenfold.headline.load_multiplier == pytest.approx(softer.headline.load_multiplier, rel=1e-9)
    assert softer.headline.load_multiplier < soft.headline.load_multiplier < 0.98 * stiff.headline.load_multiplier
    assert any("elastic modulus of the stones, here 0.01 GPa" in remark for remark in soft.remarks)
    assert not any("elastic modulus" in remark for remark in stiff.remarks)


def test_a_wall_so_soft_that_it_buckles_under_its_weight_has_no_multiplier_that_counts():
    """Three stones of 0.2 MPa lean over by themselves: the foot alone, k b^2 / 4 of its two ends at most, is no match
    for W H / 2. In small displacements they bear b / H, which is not what a wall that does not stand bears."""
    width, height, modulus = 0.5, 3.0, 2e5
    weight = 20e3 * width * height
    springs = SPREAD * modulus * width / 0.5  # centroid of the lowest stone to the floor
    assert springs * width**2 / 4 < weight * height / 2
    found = analyse(tower(width, 1.0, blocks=3, friction=3.0), elastic_modulus=modulus)
    assert found.going_down
    assert answer_of_limit(found).startswith("Whether it stands is open")
    assert any("no rest under a live load was found, with an elastic modulus" in remark for remark in found.remarks)


def test_what_stones_bear_at_rest_that_have_not_moved_is_no_answer_of_geometry():
    """Wedges that springs of another kind press more: 0.0187 at 1 um; the limit state is that of the paper's sequence,
    and every stone in finite elements bears 0.0061 (`run --model micro`)."""
    assemblage = find_joints(read_blocks(PROJECT / "tests" / "data" / "voronoi_20_stones.json"), JointSettings())
    found = analyse(assemblage, loads=loads_on(assemblage.wall, LoadSettings(inclination=np.radians(-20.0))))
    assert found.rigid_curve[:, 1].max() > 2.0 * found.headline.load_multiplier
    assert found.headline.load_multiplier == pytest.approx(found.sequence.load_multiplier, rel=1e-3)
    assert not found.geometry_decides
