from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from orchestrator.errors import CaseError
from orchestrator.joints import JointSettings, check_assemblage, find_joints
from orchestrator.masonry.geometry import block_weights
from orchestrator.masonry.patterns import IrregularCourses, irregular_courses, running_bond
from orchestrator.masonry.readers import read_blocks
from orchestrator.masonry.wall import check_wall, read_only

DATA = Path(__file__).parents[1] / "data"


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
    assert len(find_joints(running_bond(per_course, courses), JointSettings()).block_i) == expected


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


def test_openings_that_meet_are_refused():
    with pytest.raises(CaseError, match="openings: "):
        irregular_courses(IrregularCourses(2.0, 1.0, openings=((0.5, 1.0, 0.2, 0.6), (1.1, 1.5, 0.2, 0.6))))
