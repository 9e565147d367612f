"""Openings, piers and spandrels of walls drawn by hand, and sections that balance whatever the bond."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import shapely

from orchestrator.assessment.panels import cut, in_storeys, openings, piers, spandrels, storeys
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.patterns import ARCHED_FACADE, arched_wall, running_bond
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.masonry.wall import Block, Wall
from tests.support.paths import PROJECT
from tests.support.walls import upright


@pytest.fixture(scope="module")
def facade():
    """Benchmark 1: two storeys of two openings 0.4 m x 0.875 m in a wall 2.8 m x 3.675 m (Ferris and Tin-Loi 2001)."""
    return read_blocks(PROJECT / "meshes" / "ferris_tinloi_wall6.json")


def test_openings_of_benchmark_1_are_those_of_its_drawing(facade):
    found = openings(facade)
    drawn = [(x, x + 0.4, y, y + 0.875) for y in (0.7, 2.1) for x in (0.6, 1.8)]
    assert np.array([(o.left, o.right, o.bottom, o.top) for o in found]) == pytest.approx(np.array(drawn), abs=1e-9)
    assert [len(row) for row in storeys(found)] == [2, 2]


def test_piers_stand_between_openings_and_spandrels_lie_between_storeys(facade):
    found = piers(facade)
    assert [(p.left, p.right) for p in found[:3]] == pytest.approx(np.array([(0, 0.6), (1, 1.8), (2.2, 2.8)]), abs=1e-6)
    assert [len(row) for row in in_storeys(found)] == [3, 3]
    heights = {(round(p.bottom, 6), round(p.top, 6)) for p in spandrels(facade)}
    assert heights == {(0.0, 0.7), (1.575, 2.1), (2.975, 3.675)}


def test_rounding_at_the_edge_of_a_wall_is_no_pier():
    """A door of row notation, in mm: some stones end at 2.5 m, others 4e-16 m further."""
    wall = door_of_stones(2.5 + 4.4e-16)
    assert [(p.name, p.left, p.right) for p in piers(wall)] == [
        ("pier 1.1", 0.0, pytest.approx(0.8)), ("pier 1.2", pytest.approx(1.7), pytest.approx(2.5))
    ]  # fmt: skip


def door_of_stones(end):
    """Two piers of two stones and a lintel; the lower stone on the right ends at 2.5 m, the others at `end`."""
    below = [upright(1, 0.0, 0.0, 0.8, 0.2), upright(2, 1.7, 0.0, 0.8, 0.2)]
    above = [upright(3, 0.0, 0.2, 0.8, 0.2), upright(4, 1.7, 0.2, end - 1.7, 0.2)]
    whole = [upright(0, -0.2, -0.2, 2.9, 0.2, fixed=True), *below, *above, upright(5, 0.0, 0.4, end, 0.2)]
    return Wall("door", tuple(whole), 0.3, 0.6)


def test_a_door_on_the_ground_is_an_opening_and_a_wall_without_any_has_no_pier():
    wall = arched_wall(ARCHED_FACADE)
    door, window, *upper = openings(wall)
    assert (door.bottom, len(upper)) == (0.0, 3)
    assert window.bottom > 0.0
    assert [len(row) for row in in_storeys(piers(wall))] == [3, 4]
    assert piers(running_bond(5, 6)) == ()


def test_a_pier_holds_no_opening_of_another_storey():
    """A door up to 0.6 m, and beside it a window from 0.4 to 1.0 m: the pier beside the door ends at the sill, that
    beside the window begins at the head of the door."""
    blocks, opened = [upright(0, -0.2, -0.2, 2.8, 0.2, fixed=True)], ((0.4, 0.8, 0.0, 0.6), (1.2, 1.6, 0.4, 1.0))
    for y in np.arange(0.0, 1.4, 0.2):
        for x in np.arange(0.0, 2.4, 0.4):
            if not any(left <= x + 0.2 <= right and low <= y + 0.1 <= high for left, right, low, high in opened):
                blocks.append(upright(len(blocks), x, y, 0.4, 0.2))
    found = piers(Wall("staggered", tuple(blocks), 0.3, 0.6))
    assert [(p.left, p.right, p.bottom, p.top) for p in found] == pytest.approx(np.array([
        (0.0, 0.4, 0.0, 0.4), (0.8, 2.4, 0.0, 0.4), (0.0, 1.2, 0.6, 1.0), (1.6, 2.4, 0.6, 1.0)
    ]), abs=1e-9)  # fmt: skip


@pytest.mark.parametrize("name", ["ferris_tinloi_wall6.json", "benchmark2.json", "arched_facade.json"])
def test_every_joint_of_a_cut_belongs_to_one_panel(name):
    assemblage = find_joints(read_blocks(PROJECT / "meshes" / name), JointSettings())
    for row in in_storeys(piers(assemblage.wall)):
        sections = [cut(assemblage, pier, pier.bottom) for pier in row]
        joints = np.concatenate([section.joints for section in sections])
        assert len(joints) == len(set(joints.tolist())) > 0
        lower = set(np.concatenate([section.lower for section in sections]).tolist())
        upper = set(np.concatenate([assemblage.joints.i[joints], assemblage.joints.j[joints]]).tolist()) - lower
        assert upper, "blocks stand on the section"
        assert all(assemblage.wall.blocks[block].polygon[:, 1].max() > row[0].bottom for block in upper)


def test_openings_that_are_not_drawn_above_each_other_have_sections_of_their_own():
    """A window a tenth of a millimetre, or half a stone, beside the one below. Sections through the upper spandrel were
    those of all three solid parts of its line, through 21 joints for 7."""
    for shift in (0.0, 1e-4, 0.2):
        assemblage = find_joints(windows_in_running_bond(shift), JointSettings())
        found = spandrels(assemblage.wall)
        assert len(found) == (4 if shift > 0.1 else 3)
        for panel in found:
            section = cut(assemblage, panel, 0.5 * (panel.left + panel.right))
            heights = assemblage.joints.centroid[section.joints, 1]
            assert panel.bottom - 1e-9 <= heights.min()
            assert heights.max() <= panel.top + 1e-9


def windows_in_running_bond(shift):
    """Two windows of 0.8 m x 0.8 m one above the other in a wall of 4 m x 4 m, the upper one `shift` m to the right."""
    windows = [shapely.box(1.6, 0.8, 2.4, 1.6), shapely.box(1.6 + shift, 2.4, 2.4 + shift, 3.2)]
    stones = [shapely.box(-0.1, -0.2, 4.1, 0.0)]
    for course in range(20):
        ends = np.clip(np.arange(-0.2 * (course % 2), 4.3, 0.4), 0.0, 4.0)
        stones += [shapely.box(a, 0.2 * course, b, 0.2 * course + 0.2) for a, b in pairwise(ends) if b > a]
    left = [part for stone in stones for part in shapely.get_parts(stone.difference(shapely.union_all(windows)))]
    left = [part for part in left if part.area > 1e-9]
    outlines = [np.array(shapely.normalize(part).exterior.coords)[-2::-1] for part in left]
    return Wall("windows", tuple(Block(k, outline, k == 0, 20e3) for k, outline in enumerate(outlines)), 0.4, 0.6)
