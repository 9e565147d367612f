"""A stone that was left out is a hole that import names; slits, doors and what is open to a side are none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from orchestrator.app.intake import import_wall
from orchestrator.masonry.patterns import IrregularCourses, Rubble, irregular_courses, rubble, running_bond
from orchestrator.masonry.sources.holes import said_holes
from tests.support.drawings import polylines

BOND = running_bond(4, 6, block_length=0.5, block_height=0.25)


def without(wall, *ids):
    return replace(wall, blocks=tuple(block for block in wall.blocks if block.id not in ids))


def at(wall, x, y):
    """The block whose centroid is nearest to a point."""
    return min(wall.blocks, key=lambda block: float(np.hypot(*(block.polygon.mean(axis=0) - [x, y])))).id


def test_a_stone_that_was_left_out_is_named_with_place_and_size(tmp_path):
    file = polylines(tmp_path / "wall.dxf", without(BOND, at(BOND, 0.75, 0.625)), error=2e-4)
    remarks = import_wall(file, {"thickness": "0.3 m"}).remarks
    assert [said for said in remarks if "hole" in said] == [
        "1 hole of the size of a stone or two between stones: 0.5 m x 0.25 m at (0.75, 0.625) m"
    ]


def test_two_neighbours_that_were_left_out_are_one_hole():
    """Nothing was told of it: a hole was of one stone's size."""
    left, right = at(BOND, 0.75, 0.625), at(BOND, 1.25, 0.625)
    (said,) = said_holes(without(BOND, left, right))
    assert "1 m x 0.25 m at (1, 0.625) m" in said


def test_a_hole_is_as_large_as_the_stone_that_was_there():
    """It was smaller by a thousandth of a stone's size, 0.799 m."""
    wall = running_bond(4, 6, block_length=0.8, block_height=0.8)
    (said,) = said_holes(without(wall, at(wall, 1.2, 2.0)))
    assert "0.8 m x 0.8 m at (1.2, 2) m" in said


def test_an_opening_of_row_notation_is_no_hole(tmp_path):
    file = tmp_path / "wall.txt"
    courses = "250: 500 500 500 500\n250: 250 500 -500 500 250\n250: 500 500 500 500"
    file.write_text(f"unit = mm\nthickness = 100\nunit_weight = 25 kN/m3\nfriction = 0.65\nsupport = 200\n{courses}\n")
    intake = import_wall(file, {})
    assert said_holes(intake.wall)
    assert not [said for said in intake.remarks if "hole" in said]


def test_a_stone_of_rubble_that_was_left_out_is_named():
    wall = rubble(Rubble(2.4, 2.0, stone=0.35, seed=3))
    assert said_holes(wall) == []
    (said,) = said_holes(without(wall, at(wall, 1.2, 1.0)))
    assert said.startswith("1 hole of the size of a stone or two between stones: ")


@pytest.mark.parametrize("place", [(0.25, 0.125), (1.0, 1.375)])
def test_what_is_open_to_a_side_is_no_hole(place):
    assert said_holes(without(BOND, at(BOND, *place))) == []


def test_a_window_is_no_hole():
    wall = irregular_courses(IrregularCourses(2.4, 1.8, openings=((0.8, 1.4, 0.5, 1.2),)))
    assert said_holes(wall) == []
