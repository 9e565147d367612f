from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
import shapely

from orchestrator.basis.arrays import read_only
from orchestrator.basis.errors import CaseError
from orchestrator.limit_analysis.gravity import refuse_what_cannot_be_analysed
from orchestrator.loads import loads_on
from orchestrator.masonry.block_properties import block_weights
from orchestrator.masonry.joints import JointSettings, check_assemblage, find_joints
from orchestrator.masonry.patterns import (
    ARCHED_FACADE,
    Arch,
    ArchedOpening,
    ArchedWall,
    IrregularCourses,
    Rubble,
    arch_on_piers,
    arched_wall,
    irregular_courses,
    rubble,
    running_bond,
)
from orchestrator.masonry.patterns.tiling import wall_of_tiles
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.masonry.wall import check_wall, shapes
from tests.support.paths import DATA


def outlines(wall):
    """Return every block as (fixed, unit weight, corners from the lower left one), in an order of their own."""
    corners = [np.round(block.polygon, 9) + 0.0 for block in wall.blocks]
    first = [min(range(len(p)), key=lambda k, p=p: tuple(p[k])) for p in corners]
    turned = [np.roll(p, -k, axis=0).tolist() for p, k in zip(corners, first, strict=True)]
    return sorted((b.fixed, b.unit_weight, p) for b, p in zip(wall.blocks, turned, strict=True))


def without_lowest_course(wall, height=0.175):
    lowered = [replace(b, polygon=read_only(b.polygon - [0, height])) for b in wall.blocks[1:]]
    return replace(wall, blocks=(wall.blocks[0], *(b for b in lowered if b.polygon[:, 1].min() > -height / 2)))


def test_upper_courses_are_wall_1_of_ferris_and_tin_loi():
    """Wall 1 is 5 x 6 with the halved course at the bottom, where the pattern has the whole one."""
    made, published = without_lowest_course(running_bond(5, 7)), read_blocks(DATA / "ferris_tinloi_wall1.json")
    assert len(made.blocks) == 34
    assert outlines(made) == outlines(published)
    assert (made.thickness, made.friction) == (published.thickness, published.friction)


@pytest.mark.parametrize(("per_course", "courses", "free"), [(5, 6, 33), (5, 10, 55), (10, 20, 210)])
def test_number_of_blocks_and_weight(per_course, courses, free):
    wall = running_bond(per_course, courses)
    check_wall(wall)
    assert sum(not block.fixed for block in wall.blocks) == free
    moving = [not block.fixed for block in wall.blocks]
    total = per_course * 0.4 * courses * 0.175 * 0.1 * 25e3
    assert block_weights(wall)[moving].sum() == pytest.approx(total)


@pytest.mark.parametrize(("per_course", "courses"), [(1, 1), (3, 2), (5, 6)])
def test_number_of_joints(per_course, courses):
    """Base: one a stone. Bed joints: half a stone each, 2n. Head joints: n - 1 in whole courses, n in halved ones."""
    expected = per_course + 2 * per_course * (courses - 1)
    expected += (per_course - 1) * ((courses + 1) // 2) + per_course * (courses // 2)
    assert find_joints(running_bond(per_course, courses), JointSettings()).joints.count == expected


OPENINGS = ((0.5, 1.0, 0.0, 1.2), (1.6, 2.1, 0.6, 1.3))


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(("length", "height", "openings"), [(1.4, 1.0, ()), (2.6, 1.8, OPENINGS)])
def test_irregular_courses_fill_their_outline(length, height, openings, seed):
    pattern = IrregularCourses(length, height, openings=openings, seed=seed)
    wall = irregular_courses(pattern)
    check_wall(wall)
    check_assemblage(find_joints(wall, JointSettings()))
    corners = np.array([block.polygon for block in wall.blocks[1:]])
    width, rise = np.ptp(corners[:, :, 0], axis=1), np.ptp(corners[:, :, 1], axis=1)
    holes = sum((right - left) * (head - sill) for left, right, sill, head in openings)
    assert width @ rise == pytest.approx(length * height - holes)
    assert width.min() >= 0.5 * pattern.widths[0] - 1e-9
    assert np.count_nonzero(width > pattern.widths[1] + 1e-9) <= len(openings)  # lintels


@pytest.mark.parametrize("seed", range(6))
def test_head_joints_keep_the_overlap(seed):
    pattern = IrregularCourses(2.0, 1.2, overlap=0.04, seed=seed)
    corners = np.array([block.polygon for block in irregular_courses(pattern).blocks[1:]])
    courses = {}
    for x, y in corners.reshape(-1, 4, 2)[:, 0]:
        courses.setdefault(round(y, 9), []).append(x)
    levels = sorted(courses)
    assert len(levels) > 8
    for below, above in itertools.pairwise(levels):
        first, second = (np.array([x for x in courses[y] if x > 1e-9]) for y in (below, above))
        assert np.abs(first[:, None] - second[None]).min() >= 0.04 - 1e-9


def test_irregular_courses_are_reproducible():
    made = [irregular_courses(IrregularCourses(1.4, 1.0, seed=seed)) for seed in (3, 3, 4)]
    assert outlines(made[0]) == outlines(made[1]) != outlines(made[2])


def test_an_overlap_that_no_stones_can_keep_is_refused():
    with pytest.raises(CaseError, match="overlap: no stones of these widths fit"):
        irregular_courses(IrregularCourses(2.0, 1.0, widths=(0.1, 0.11), overlap=0.09))


def test_long_courses_keep_the_overlap():
    """With 2000 draws of whole courses alone, walls of 6 m found none."""
    check_wall(irregular_courses(IrregularCourses(6.0, 0.5)))


def test_openings_that_meet_are_refused():
    with pytest.raises(CaseError, match="openings: "):
        irregular_courses(IrregularCourses(2.0, 1.0, openings=((0.5, 1.0, 0.2, 0.6), (1.1, 1.5, 0.2, 0.6))))


def check_tiles(wall, area, size):
    """Check what every wall cut out of one plane keeps: `size` is that of a usual stone, `area` that of the wall."""
    check_wall(wall)
    check_assemblage(find_joints(wall, JointSettings()))
    stones = shapes(wall)[1:]
    assert sum(stone.area for stone in stones) == pytest.approx(area, abs=1e-9)
    edges = [np.linalg.norm(b.polygon - np.roll(b.polygon, 1, axis=0), axis=1).min() for b in wall.blocks[1:]]
    assert min(edges) >= size / 12 - 1e-9
    assert all(not stone.buffer(-size / 8).is_empty for stone in stones)
    check_shared_corners(wall)


def check_shared_corners(wall):
    """Every corner on the outline of a stone is one of its corners, and no two corners are almost the same."""
    stones = [block.polygon for block in wall.blocks if not block.fixed]
    corners = np.unique(np.vstack(stones), axis=0)
    points = shapely.points(corners)
    first, second = shapely.STRtree(points).query(points, "dwithin", distance=1e-6)
    assert np.array_equal(first, second)
    for stone in stones:
        on = corners[shapely.dwithin(points, shapely.LinearRing(stone), 1e-6)]
        assert sorted(on.tolist()) == sorted(stone.tolist())


def stands(wall):
    """Return the associative multiplier of a wall; CaseError where it falls under its own weight."""
    assemblage = find_joints(wall, JointSettings())
    return refuse_what_cannot_be_analysed(assemblage, loads_on(assemblage.wall)).load_multiplier


WINDOW = (1.0, 1.8, 0.8, 1.6)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize(
    ("stone", "flatness", "openings"), [(0.3, 1.6, (WINDOW,)), (0.25, 2.2, ()), (0.35, 1.0, (WINDOW,))]
)
def test_rubble_fills_its_outline(stone, flatness, openings, seed):
    wall = rubble(Rubble(3.0, 2.4, stone, flatness, openings=openings, seed=seed))
    area = 3.0 * 2.4 - 0.64 * len(openings)
    check_tiles(wall, area, stone / flatness)
    assert area / (len(wall.blocks) - 1) == pytest.approx(stone**2 / flatness, rel=0.25)


@pytest.mark.parametrize("flatness", [1.0, 2.0])
def test_rubble_has_stones_of_its_flatness(flatness):
    """A hexagon standing on a corner is sqrt(3) / 2 as wide as it is high, a rectangle as wide."""
    wall = rubble(Rubble(4.0, 3.0, 0.25, flatness))
    width, height = np.mean([np.ptp(block.polygon, axis=0) for block in wall.blocks[1:]], axis=0)
    assert 0.85 * flatness < width / height < flatness


def test_rubble_is_reproducible():
    made = [rubble(Rubble(1.5, 1.0, seed=seed)) for seed in (3, 3, 4)]
    assert outlines(made[0]) == outlines(made[1]) != outlines(made[2])


@pytest.mark.parametrize("seed", range(2))
def test_rubble_stands(seed):
    assert 0.05 < stands(rubble(Rubble(2.4, 2.0, openings=((0.8, 1.6, 0.6, 1.3),), friction=0.65, seed=seed))) < 0.65


def test_a_lintel_that_leaves_the_wall_is_refused():
    with pytest.raises(CaseError, match="openings: an opening, its arch or its lintel leaves the wall"):
        rubble(Rubble(2.0, 2.0, openings=((0.1, 1.0, 0.9, 1.2),)))


def test_a_stone_all_round_an_opening_is_refused():
    void, stone = shapely.box(0.9, 0.9, 1.1, 1.1), shapely.box(0.0, 0.0, 2.0, 2.0)
    with pytest.raises(CaseError, match="openings: a stone would lie all round"):
        wall_of_tiles("one stone", (2.0, 2.0), [void], [], [stone], 1.0, thickness=0.5, unit_weight=2e4, friction=0.6)


def area_of_facade(pattern):
    holes = [(right - left) * (head - sill) for left, right, sill, head in pattern.courses.openings]
    return pattern.courses.length * pattern.courses.height - sum(holes) - sum(a.void().area for a in pattern.arches)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("quoins", "at_jambs"), [(None, False), ((0.7, 0.45), False), ((0.7, 0.45), True)])
def test_facades_fill_their_outline(quoins, at_jambs, seed):
    courses = replace(ARCHED_FACADE.courses, seed=seed)
    pattern = replace(ARCHED_FACADE, courses=courses, quoins=quoins, quoins_at_jambs=at_jambs)
    check_tiles(arched_wall(pattern), area_of_facade(pattern), 0.5 * sum(courses.heights))


@pytest.mark.parametrize("rise", [None, 0.2, 0.0])
@pytest.mark.parametrize("seed", range(4))
def test_every_kind_of_arch_fits_into_a_wall(rise, seed):
    arch = ArchedOpening(1.0, 1.9, 0.5, 1.1, rise, depth=0.22, voussoirs=9)
    pattern = ArchedWall(IrregularCourses(3.0, 2.2, seed=seed), (arch,))
    wall = arched_wall(pattern)
    check_tiles(wall, area_of_facade(pattern), 0.11)
    for voussoir in arch.stones():
        assert min(shapely.hausdorff_distance(voussoir, stone) for stone in shapes(wall)) < 1e-9


def test_the_facade_has_two_hundred_stones_and_stands():
    wall = arched_wall(ARCHED_FACADE)
    assert len(wall.blocks) - 1 == pytest.approx(200, rel=0.1)
    assert 0.2 < stands(wall) < wall.friction


def test_quoins_alternate():
    wall = arched_wall(replace(ARCHED_FACADE, arches=(), courses=replace(ARCHED_FACADE.courses, openings=())))
    for side in (0.0, 6.0):
        lengths = [np.ptp(b.polygon[:, 0]) for b in wall.blocks[1:] if (b.polygon[:, 0] == side).any()]
        assert lengths == pytest.approx(np.resize([0.7, 0.45], len(lengths)), abs=1e-9)


def test_a_void_under_a_polygon_of_chords_has_its_closed_form():
    """Half a regular polygon of 2 n corners, n r2 sin(pi / n) / 2, and for the segment the triangle less."""
    below = 0.8 * 0.5
    assert ArchedOpening(1.0, 1.8, 0.5, 1.0, voussoirs=9).void().area == pytest.approx(
        below + 0.5 * 9 * 0.4**2 * np.sin(np.pi / 9)
    )
    radius, half_angle = 0.8 / np.sqrt(3), np.pi / 3  # embraces 120 degrees: rise = radius / 2
    segment = 0.5 * radius**2 * (7 * np.sin(2 * half_angle / 7) - np.sin(2 * half_angle))
    arch = ArchedOpening(1.0, 1.8, 0.5, 1.0, 0.5 * radius, voussoirs=7)
    assert arch.void().area == pytest.approx(below + segment)
    assert ArchedOpening(1.0, 1.8, 0.5, 1.0, 0.0).void().area == pytest.approx(below)


def test_joints_of_a_flat_arch_meet_in_one_point():
    inner, outer = ArchedOpening(1.0, 1.8, 0.5, 1.0, 0.0, depth=0.3, voussoirs=7).rings()
    assert np.ptp(inner[:, 1]) == np.ptp(outer[:, 1]) == 0.0
    assert outer[0, 1] - inner[0, 1] == pytest.approx(0.3)
    focus, along = np.array([1.4, 1.0 - 0.4 * np.sqrt(3)]), outer - inner
    assert along[:, 0] * (inner - focus)[:, 1] == pytest.approx(along[:, 1] * (inner - focus)[:, 0])


@pytest.mark.parametrize(("key", "given"), [("voussoirs", {"voussoirs": 8}), ("rise", {"rise": 0.5})])
def test_arches_that_are_none_are_refused(key, given):
    with pytest.raises(CaseError, match=f"{key}: "):
        ArchedOpening(1.0, 1.8, 0.5, 1.0, **given)


@pytest.mark.parametrize("courses", [0, 4])
@pytest.mark.parametrize("angle", [np.pi, 2.0])
def test_arch_has_equal_voussoirs_on_its_piers(angle, courses):
    pattern = Arch(11, 1.5, 0.3, angle, courses, pier_width=0.6, pier_height=1.6)
    wall = arch_on_piers(pattern)
    check_wall(wall)
    assemblage = find_joints(wall, JointSettings())
    check_assemblage(assemblage)
    assert assemblage.joints.count == 12 + 2 * courses
    assert [block.fixed for block in wall.blocks] == [True, True] + [False] * (2 * courses + 11)
    voussoir = 0.5 * (1.65**2 - 1.35**2) * np.sin(angle / 11)
    assert [stone.area for stone in shapes(wall)[-11:]] == pytest.approx([voussoir] * 11)
    assert np.allclose(sorted(assemblage.joints.length)[:12], 0.3)


@pytest.mark.parametrize(("depth", "standing"), [(0.112, True), (0.100, False)])
def test_least_depth_of_a_semicircular_arch(depth, standing):
    """Milankovitch (1907): 0.1075 of the mean radius for radial joints however many, less for few voussoirs."""
    wall = arch_on_piers(Arch(51, 1.0, depth, friction=2.0))
    if standing:
        assert stands(wall) > 0
    else:
        with pytest.raises(CaseError, match="stand"):
            stands(wall)


def test_a_pier_narrower_than_the_springing_is_refused():
    with pytest.raises(CaseError, match=r"pier_width: .* give at least 0.3 m"):
        arch_on_piers(Arch(9, 1.0, 0.3, courses=2, pier_width=0.2, pier_height=1.0))


@pytest.mark.parametrize(
    ("make", "key"),
    [
        (lambda: Rubble(-1.8, 1.6), "Rubble.length: -1.8 "),
        (lambda: Rubble(1.8, 1.6, stone=0), "Rubble.stone: 0.0 "),
        (lambda: Rubble(1.8, float("nan")), "Rubble.height: nan "),
        (lambda: Rubble(1.8, 1.6, flatness=-1), "Rubble.flatness: -1 "),
        (
            lambda: Rubble(1.8, 1.6, openings=((1.0, 0.5, 0.0, 1.0),)),
            r"Rubble.openings\[0\]: .* has no area; give left",
        ),
        (lambda: Rubble(1.8, 1.6, seed=-1), "Rubble.seed: -1 "),
        (lambda: IrregularCourses(2.0, 1.0, thickness=-0.4), "IrregularCourses.thickness: -0.4 "),
        (lambda: IrregularCourses(2.0, 1.0, widths=(0.3, 0.1)), "IrregularCourses.widths: 0.3 to 0.1 m is not a range"),
        (lambda: IrregularCourses(2.0, 1.0, heights=(0, 0.1)), "IrregularCourses.heights.0: 0.0 "),
        (lambda: IrregularCourses(2.0, 1.0, openings=((0.5, 1.0, 1.0, 0.2),)), "has no area"),
        (lambda: ArchedOpening(1.8, 1.0, 0.0, 1.0), "ArchedOpening: .* has no area; give left, right, sill and spr"),
        (lambda: ArchedOpening(1.0, 1.8, 0.0, 1.0, depth=0), "ArchedOpening.depth: 0.0 "),
        (lambda: ArchedWall(IrregularCourses(2.0, 1.0), quoins=(0.4, -0.6)), "ArchedWall.quoins.*: -0.6 "),
        (lambda: Arch(9, 0.1, 0.3), "Arch.depth: 0.3 m is not below twice the radius"),
        (lambda: Arch(9.5, 1.0, 0.3), "Arch.voussoirs: 9.5 is not a whole number"),
        (lambda: Rubble(1.0, 1.0, stone=1e-4), r"Rubble.stone: about 1.6e\+08 blocks, more than 100000; give larger"),
        (lambda: IrregularCourses(2.0, 1.0, widths=(1e-4, 2e-4)), "IrregularCourses.widths: about 1.2e.05 blocks"),
        (lambda: running_bond(4000, 3000), r"RunningBond.courses: about 1.2e\+07 blocks"),
        (lambda: running_bond(0, 3), "RunningBond.blocks_per_course: 0 "),
        (lambda: running_bond(2, 3, block_height=-0.1), "RunningBond.block_height: -0.1 "),
    ],
)
def test_a_pattern_of_nothing_is_refused_in_one_line(make, key):
    with pytest.raises(CaseError, match=key) as refused:
        make()
    assert "\n" not in str(refused.value)


def test_a_pattern_takes_texts_with_units():
    assert Rubble("180 cm", 1.6).length == pytest.approx(1.8)


def test_rubble_smaller_than_its_shortest_edge_is_one_of_few_stones():
    wall = rubble(Rubble(0.01, 0.01))
    check_wall(wall)
    assert len(wall.blocks) >= 2
