"""Walls in space as drawings have them: what corners that are a hair off must not change."""

from __future__ import annotations

from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest

from orchestrator.app.space_commands import assemblage_of, doubtful_joints
from orchestrator.app.space_intake import as_record
from orchestrator.basis.arrays import read_only
from orchestrator.basis.errors import CaseError
from orchestrator.geometry.polyhedra import Polyhedron, box, flaw_of, prism, rotation
from orchestrator.settings.space_case import read
from orchestrator.space.alignment import aligned, common
from orchestrator.space.analysis import SpaceLimitSettings, analyse
from orchestrator.space.contacts import FaceContactSettings, find_joints
from orchestrator.space.generators import GENERATORS, build
from orchestrator.space.generators.shapes import Plan, Stones, l_wall
from orchestrator.space.loads import SpaceLoadSettings, loads_on
from orchestrator.space.wall import SpaceWall, refuse_overlaps
from orchestrator.storage.files import write_json
from tests.support.space_walls import GROUND, cut_by_planes, wall_of

LARGER = Stones(length=0.4, height=0.2, thickness=0.2)
MIRROR = np.diag([-1.0, 1.0, 1.0])


def drawn(wall: SpaceWall, turn: np.ndarray, error) -> SpaceWall:
    """Return the wall turned, with every corner where a drawing has it."""
    moved = [(block, block.shape) for block in wall.moved(turn).blocks]
    return replace(
        wall,
        blocks=tuple(
            replace(block, shape=replace(shape, vertices=read_only(error(shape.vertices)))) for block, shape in moved
        ),
    )


def rounded(step: float):
    return lambda corners: np.round(corners / step) * step


def scattered(size: float, seed: int = 0):
    chance = np.random.default_rng(seed)
    return lambda corners: corners + chance.uniform(-size, size, corners.shape)


def headline_of(wall: SpaceWall, direction: np.ndarray, contact: FaceContactSettings | None = None) -> float:
    assemblage = find_joints(wall, contact)
    loads = loads_on(assemblage.wall, SpaceLoadSettings(direction=tuple(direction)))
    headline = analyse(assemblage, loads, SpaceLimitSettings(states="headline")).headline
    assert headline is not None
    return headline.load_multiplier


@pytest.mark.parametrize("error", [rounded(1e-5), rounded(1e-4), scattered(5e-5)], ids=["10 um", "0.1 mm", "scattered"])
def test_a_wall_that_is_drawn_with_errors_bears_what_it_is_meant_to_bear(error):
    """Stones of 0.2 x 0.1 x 0.1 m in an L, turned by 1 rad: without levels 6 and 8 % less, and a wall that falls."""
    wall, turn, away = l_wall(Plan(4, 2, 8), Stones()), rotation((0.0, 0.0, 1.0), 1.0), np.array([0.0, -1.0, 0.0])
    assert headline_of(drawn(wall, turn, error), turn @ away) == pytest.approx(headline_of(wall, away), rel=1e-3)


def test_corners_of_an_octagonal_tower_come_to_lie_in_its_sides():
    """Its four pairs of axes are at 45 degrees: corners that belong to two sides have to suit both."""
    angles = np.arange(8) * np.pi / 4.0
    octagon = np.column_stack([np.cos(angles), np.sin(angles)])
    rings = [prism(octagon, np.array([0.0, 0.0, k]), np.eye(3)) for k in range(4)]
    wall = aligned(drawn(wall_of(rings, 0.5), rotation((0.0, 0.0, 1.0), 0.3), scattered(2e-4)), 1e-3)
    corners = np.array([block.shape.vertices for block in wall.blocks])
    for side in range(8):
        inside = corners[:, [side, (side + 1) % 8, 8 + side, 8 + (side + 1) % 8]].reshape(-1, 3)
        assert np.linalg.svd(inside - inside.mean(axis=0))[1][2] < 1e-7
    assert np.ptp(corners[:, 8:, 2], axis=1).max() < 1e-12


@pytest.mark.parametrize("name", sorted(GENERATORS))
def test_walls_as_they_are_meant_stay_as_they_are(name):
    wall = build(name, [Plan(8) if settings is Plan else settings() for settings in GENERATORS[name].settings])
    turned = wall.moved(rotation((0.0, 0.0, 1.0), 0.7))
    assert aligned(turned, 1e-3) is turned


def test_a_mirrored_drawing_is_moved_alike():
    wall = drawn(l_wall(Plan(4, 2, 4), Stones()), rotation((0.0, 0.0, 1.0), 0.4), scattered(5e-5))
    one, other = aligned(wall, 1e-3), aligned(wall.moved(MIRROR), 1e-3)
    for block, image in zip(one.blocks, other.blocks, strict=True):
        assert image.shape.vertices == pytest.approx(block.shape.vertices @ MIRROR, abs=1e-12)


def test_a_plate_is_not_flattened_and_bodies_stay_closed():
    plate = prism(np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]), np.zeros(3), np.diag([1.0, 1.0, 0.05]))
    ground = prism(
        np.array([[-1.0, -1.0], [5.0, -1.0], [5.0, 5.0], [-1.0, 5.0]]), np.array([0.0, 0.0, -1.0]), np.eye(3)
    )
    wall = aligned(drawn(wall_of([ground, plate], 0.5), np.eye(3), scattered(1e-3)), 0.1)
    assert np.ptp(wall.blocks[1].shape.vertices[:, 2]) == pytest.approx(0.05, abs=2e-3)
    assert flaw_of(wall.blocks[1].shape) is None


@pytest.mark.parametrize("order", list(permutations(range(3))))
def test_the_numbering_of_blocks_does_not_choose_levels(order):
    """A small stone between two large ones, of which one is drawn half a millimetre higher."""
    levels, apart, order = np.array([1.0, 1.0, 1.0005]), np.array([1e-3, 3e-4, 1e-3]), list(order)
    assert common(levels[order], apart[order]) == pytest.approx(common(levels, apart)[order], abs=1e-15)


def test_levels_of_which_nobody_knows_which_are_the_same_stay():
    steps = np.arange(10) * 0.9
    assert common(steps, np.ones(10)) == pytest.approx(steps)
    assert common(steps[:3], np.ones(3)) == pytest.approx(np.full(3, 0.9))
    assert common(np.array([0.0, 0.5, 3.0]), np.ones(3)) == pytest.approx([0.25, 0.25, 3.0])


def test_a_wall_far_from_the_origin_stays_as_it_is():
    """At 1e6 m the last digit is 1e-10 m, as much as stones of 0.1 m tell apart."""
    wall = l_wall(Plan(4, 2, 4), Stones()).moved(rotation((0.0, 0.0, 1.0), 0.4), np.array([1e6, 2e6, 0.0]))
    assert aligned(wall, 1e-3) is wall


def test_a_block_file_is_checked_to_what_its_joints_allow(tmp_path):
    """Faces with four corners, none of them plane, and blocks that go into each other by as much."""
    wall, file = l_wall(Plan(4, 2, 8), Stones()), tmp_path / "wall.json"
    for size in (1e-5, 2e-5, 5e-5):
        write_json(file, as_record(drawn(wall, np.eye(3), scattered(size))))
        assert find_joints(read(file).wall).joints.pairs == find_joints(wall).joints.pairs
    write_json(file, as_record(drawn(wall, np.eye(3), scattered(2e-3))))
    with pytest.raises(CaseError, match=r"is not plane, its corners lie .* mm off .*contact\.gap"):
        read(file)


def test_faces_that_slope_by_less_than_a_degree_stay_plane():
    """Two stones, their joint 0.5 degrees off level: two of its corners lie 0.55 mm apart in height, two 0.73 mm."""
    outline = np.array([[0.0, 0.0], [1.0, 0.0], [0.9, 0.35], [0.05, 0.35]])
    ground, low, high = (
        prism(outline, np.array([0.0, 0.0, level]), np.diag([1.0, 1.0, 0.6])) for level in (-0.6, 0.0, 0.6)
    )
    heights = outline @ [8.5e-3, 8.6e-4]

    def leaning(body: Polyhedron, end: slice) -> Polyhedron:
        vertices = body.vertices.copy()
        vertices[end, 2] = 0.6 + heights
        return replace(body, vertices=read_only(vertices))

    wall = wall_of([ground, leaning(low, slice(4, 8)), leaning(high, slice(0, 4))], 0.5)
    assert aligned(wall, 1e-3) is wall


@pytest.mark.parametrize(("seed", "cuts"), [(0, 7), (4, 15), (5, 15), (4, 30)])
def test_walls_that_planes_cut_stay_bodies_and_bear_what_they_bear_as_drawn(seed, cuts):
    """A block of 1.2 x 0.35 x 1.2 m cut by planes at random, some of them nearly level or upright."""
    wall, away = wall_of([GROUND, *cut_by_planes(seed, cuts)], 0.6), SpaceLoadSettings(direction=(0.0, 1.0, 0.0))
    bounds = []
    for gap in (1e-3, 1e-6):
        assemblage = find_joints(wall, FaceContactSettings(gap))
        assert not any(flaw_of(block.shape) for block in assemblage.wall.blocks)
        bounds.append(analyse(assemblage, loads_on(assemblage.wall, away), SpaceLimitSettings(states="none")).bound)
    assert bounds[0] == pytest.approx(bounds[1], rel=1e-3)


def test_a_drawing_less_exact_than_its_joints_is_told_with_the_gap_that_heals_it(tmp_path):
    """An L of stones of 0.4 x 0.2 x 0.2 m that is turned and rounded to 1 mm loses 15 % of what it bears."""
    wall, turn, away = l_wall(Plan(4, 2, 5), LARGER), rotation((0.0, 0.0, 1.0), 0.7), np.array([0.0, -1.0, 0.0])
    file = tmp_path / "wall.json"
    write_json(file, as_record(drawn(wall, turn, rounded(1e-3))))
    case = read(file)
    (said,) = (one for one in doubtful_joints(case, assemblage_of(case)) if "planes that they seem to have" in one)
    assert said.endswith("contact.gap = 0.001 leaves them there: 0.004 puts them in")
    case = read(file, ["contact.gap=0.004"])
    assert doubtful_joints(case, assemblage_of(case)) == []
    meant = headline_of(wall, away)
    assert headline_of(case.wall, turn @ away, case.contact) == pytest.approx(meant, rel=3e-3), "1 mm of 200"


def test_a_long_lintel_beside_stones_that_hardly_lean_keeps_its_two_faces():
    """Stones of 0.2 m behind it are up to 0.08 degrees askew, within the gap of each, but not within that of 3 m."""
    chance = np.random.default_rng(4)
    lintel = prism(np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 0.2], [0.0, 0.2]]), np.zeros(3), np.diag([1.0, 1.0, 0.3]))
    shapes = [replace(lintel, vertices=read_only(scattered(4e-5)(lintel.vertices)))]
    square = np.array([[0.0, 0.0], [0.2, 0.0], [0.2, 0.2], [0.0, 0.2]])
    for row in range(1, 11):
        for k in range(15):
            turn = rotation((0.0, 0.0, 1.0), chance.uniform(5e-4, 1.4e-3))
            stone = prism(square, np.zeros(3), np.diag([1.0, 1.0, 0.3]))
            shapes.append(stone.moved(turn, np.array([0.2 * k, 0.01, 0.3 * row])))
    front = aligned(wall_of(shapes, 0.5), 1e-3).blocks[0].shape.vertices[[0, 1, 4, 5]]
    assert np.linalg.svd(front - front.mean(axis=0))[1][2] < 1e-9


def test_a_stone_that_goes_into_another_by_more_than_the_gap_is_told():
    """Stones of 0.2 x 0.1 x 0.1 m that share an edge 4 mm deep, a thousandth of the volume of one."""
    stone = box((0.0, 0.0, 0.0), (0.2, 0.1, 0.1))
    for deep, is_told in ((4e-3, True), (1e-4, False)):
        wall = wall_of([stone, stone.moved(np.eye(3), np.array([0.2 - deep, 0.0, 0.1 - deep]))], 0.6)
        if is_told:
            with pytest.raises(CaseError, match="block 0: overlaps block 1"):
                refuse_overlaps(wall, 1e-3)
        else:
            refuse_overlaps(wall, 1e-3)


@pytest.mark.parametrize("gap", [1e-3, 1e-2, 5e-2])
def test_a_ring_and_its_core_that_only_touch_do_not_go_into_each_other(gap):
    """A half ring of chords and the half disc in it: no convex body, and their parts cancel; given twice it does."""
    angles = np.linspace(0.0, np.pi, 8)
    arc = np.column_stack([np.cos(angles), np.sin(angles)])
    ring = prism(np.vstack([1.3 * arc, arc[::-1]]), np.zeros(3), np.diag([1.0, 1.0, 0.4]))
    core = prism(arc, np.zeros(3), np.diag([1.0, 1.0, 0.4]))
    refuse_overlaps(wall_of([ring, core], 0.6), gap)
    with pytest.raises(CaseError, match="given twice"):
        refuse_overlaps(wall_of([ring, ring], 0.6), gap)
