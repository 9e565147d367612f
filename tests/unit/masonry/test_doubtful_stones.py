"""Errors of a drawing that leave a wall: a joint left out, which makes two stones one, and a joint drawn twice."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely

from orchestrator.app import intake
from orchestrator.app.cli import main
from orchestrator.basis.arrays import read_only
from orchestrator.basis.errors import CaseError
from orchestrator.masonry.patterns import (
    ARCHED_FACADE,
    IrregularCourses,
    Rubble,
    arched_wall,
    irregular_courses,
    rubble,
    running_bond,
)
from orchestrator.masonry.sources.doubtful_stones import doubtful_stones
from orchestrator.masonry.wall import Block, shapes
from tests.support.drawings import METRES, polylines
from tests.support.walls import between

OPENING = ((1.2, 2.2, 0.8, 1.8),)
WALLS = {
    "bond": running_bond(6, 8),
    "irregular courses": irregular_courses(IrregularCourses(3.0, 2.2, openings=((0.6, 1.3, 0.5, 1.3),))),
    "rubble": rubble(Rubble(2.5, 2.0)),
    "rubble with a window": rubble(Rubble(4.0, 3.0, openings=OPENING)),
    "arched facade": arched_wall(ARCHED_FACADE),
}


def without_joint(wall, i, j, size=1.0):
    """Return the wall with the blocks at two positions drawn as one, in the place of the first; None where it is none.

    The whole wall is `size` times as large."""
    outlines = shapes(wall)
    whole = shapely.union_all([outlines[i], outlines[j]], grid_size=1e-9)
    if whole.geom_type != "Polygon" or whole.interiors:
        return None
    outline = shapely.get_coordinates(shapely.simplify(shapely.geometry.polygon.orient(whole), 1e-9))[:-1]
    blocks = list(wall.blocks)
    blocks[i] = replace(blocks[i], polygon=read_only(outline))
    del blocks[j]
    return replace(wall, blocks=tuple(replace(b, polygon=read_only(size * b.polygon)) for b in blocks))


def at(wall, x, y):
    """Return the position of the block over a point, in m."""
    (found,) = shapely.STRtree(shapes(wall)).query(shapely.Point(x, y), predicate="within").tolist()
    return found


def bed_joints(wall, count=20):
    """Return pairs of free blocks (positions), one over the other with a joint of a fifth of a stone, a few of all."""
    outlines = shapes(wall)
    size = np.sqrt(np.median(shapely.area(outlines)))
    found = []
    for i, j in shapely.STRtree(outlines).query(outlines, predicate="touches").T.tolist():
        left, low, right, high = outlines[i].intersection(outlines[j]).bounds
        if i < j and not wall.blocks[i].fixed and right - left > max(high - low, 0.2 * size):
            found.append((i, j))
    return [found[k] for k in np.random.default_rng(0).permutation(len(found))[:count]]


@pytest.mark.parametrize("wall", WALLS.values(), ids=WALLS)
def test_nothing_is_said_of_a_wall_without_errors(wall):
    """Lintels, quoins, half stones, voussoirs, and stones hooked round a springing are meant."""
    assert doubtful_stones(wall) == []


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("name", ["bond", "irregular courses", "rubble", "rubble with a window"])
def test_a_bed_joint_left_out_is_told_with_its_stone(name, size):
    """In four of five places at the least (of 35 walls: 93 %); not where both are no larger than other stones."""
    wall = WALLS[name]
    merged = [(wall.blocks[i].id, without_joint(wall, i, j, size)) for i, j in bed_joints(wall)]
    told = [any(f"block {number} at" in said for said in doubtful_stones(one)) for number, one in merged if one]
    assert len(told) > 10
    assert np.mean(told) > 0.8


def test_a_head_joint_left_out_is_told_where_stones_are_alike():
    """Two whole stones of a bond in one rectangle: no corner shows it, but no other stone is as large."""
    wall = running_bond(8, 8)
    i, j = (at(wall, x, 0.4) for x in (1.4, 1.8))
    (said,) = doubtful_stones(without_joint(wall, i, j))
    assert said.startswith(f"WARNING: block {wall.blocks[i].id} at (")
    assert "more than 1.8 times as large" in said


def test_a_joint_drawn_twice_leaves_a_sliver_that_is_told():
    wall = running_bond(6, 8)
    k = at(wall, 1.0, 0.4)
    (left, bottom), (right, top) = wall.blocks[k].polygon[[0, 2]]
    parts = between(left, bottom, right - 3e-3, top), between(right - 3e-3, bottom, right, top)
    blocks = [replace(wall.blocks[k], id=900 + n, polygon=read_only(part)) for n, part in enumerate(parts)]
    others = tuple(block for block in wall.blocks if block is not wall.blocks[k])
    (said,) = doubtful_stones(replace(wall, blocks=(*others, *blocks)))
    assert "block 901 at" in said
    assert "was a joint drawn twice?" in said


def test_what_many_stones_have_is_no_error():
    """A course of slips in every bed: they are the family."""
    beds = [between(0.0, 0.22 * n, 3.0, 0.22 * n + 0.02) for n in range(6)]
    stones = [between(0.5 * k, 0.22 * n + 0.02, 0.5 * k + 0.5, 0.22 * n + 0.22) for n in range(6) for k in range(6)]
    ground = Block(99, read_only(between(-0.2, -0.2, 3.2, 0.0)), True, 20e3)
    blocks = [Block(k, read_only(outline), False, 20e3) for k, outline in enumerate((*beds, *stones))]
    assert doubtful_stones(replace(running_bond(2, 2), blocks=(ground, *blocks))) == []


def test_import_and_check_tell_it_and_refuse_nothing(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    wall = WALLS["rubble"]
    one = next(one for one in (without_joint(wall, *pair) for pair in bed_joints(wall)) if one and doubtful_stones(one))
    polylines(tmp_path / "survey.dxf", one)
    friction = ["--friction", "2", "--thickness", "500 mm"]
    assert main(["import", "survey.dxf", *friction, "--output", "survey.json"]) == 0
    assert "as if it were two stones: is a joint missing?" in capsys.readouterr().out
    assert main(["check", "survey.json"]) == 0
    assert "as if it were two stones: is a joint missing?" in capsys.readouterr().out


def test_a_drawing_in_another_unit_than_its_header_says_is_asked_about_its_unit(tmp_path):
    """Read as mm, a wall drawn in m has stones that are smaller than the tolerance: no corner of theirs is at fault."""
    drawn = polylines(tmp_path / "wall.dxf", WALLS["bond"], METRES)
    with pytest.raises(CaseError) as refused:
        intake.import_wall(drawn, {"thickness": "300 mm", "unit": "mm"})
    assert "m: is the unit right?" in str(refused.value)


def test_a_wall_half_as_thick_as_it_is_long_is_asked_about_its_unit(tmp_path):
    drawn = polylines(tmp_path / "wall.dxf", WALLS["bond"], METRES)
    said = intake.import_wall(drawn, {"thickness": "300 mm", "unit": "cm", "tolerance": "0.01 mm"}).remarks
    assert any("is the unit right?" in remark for remark in said)
