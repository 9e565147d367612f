from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from orchestrator.joints import JointSettings, find_joints
from orchestrator.limit_analysis.equilibrium import block_weights
from orchestrator.masonry.patterns import running_bond
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
