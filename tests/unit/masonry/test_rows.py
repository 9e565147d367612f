"""Walls in row notation: wall 1 of Ferris and Tin-Loi comes back, and mistakes are named by line."""

from __future__ import annotations

import pytest

from orchestrator.app.intake import Intake, import_wall, write_wall
from orchestrator.basis.errors import CaseError
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.masonry.sources.rows import parse_rows, read_rows
from tests.support.intake import (
    PUBLISHED,
    ROWS,
    WALL_1,
    assert_same_wall,
    associative,
)


def test_wall_1_comes_back_from_row_notation(tmp_path):
    (tmp_path / "wall.txt").write_text(ROWS)
    wall = read_rows(tmp_path / "wall.txt")
    assert_same_wall(wall, WALL_1)
    assert associative(wall) == pytest.approx(PUBLISHED, abs=5e-4)
    assert [block.id for block in wall.blocks] == [block.id for block in WALL_1.blocks]


def test_negative_widths_are_openings_and_numbers_may_carry_units():
    wall = parse_rows(
        "unit=m\nthickness=30 cm\nunit_weight=20 kN/m3\nfriction=.6\nsupport=.1\n.2: .5 -1 .5 # door\n", "door"
    )
    assert [tuple(block.polygon.min(axis=0)) for block in wall.blocks] == [(-0.1, -0.2), (0.0, 0.0), (1.5, 0.0)]
    assert wall.thickness == pytest.approx(0.3)


def test_a_course_that_ends_before_the_others_is_pointed_out(tmp_path):
    head = "unit=m\nthickness=.3\nunit_weight=20 kN/m3\nfriction=.6\nsupport=.1\n"
    (tmp_path / "wall.txt").write_text(head + ".2: .4 .4 .4\n.2: .6 .6\n.2: .4 .3\n")
    remarks = import_wall(tmp_path / "wall.txt", {}).remarks
    assert remarks == ["course 3 from the bottom ends at 0.7 m, the longest at 1.2 m: is a stone missing?"]
    (tmp_path / "wall.txt").write_text(head + ".2: .4 .4 .4\n.2: .5 .7\n.2: .1 .4 .7\n")
    assert import_wall(tmp_path / "wall.txt", {}).remarks == []


def test_row_notation_names_materials(tmp_path):
    head = "unit=m\nthickness=.3\nunit_weight=20 kN/m3\nfriction=.6\nsupport=.1\n"
    wall = parse_rows(head + ".4: .3/stone -.6 .3\n.1: 1.2/timber\n", "door")
    assert [block.material for block in wall.blocks] == ["", "stone", "", "timber"]
    write_wall(Intake(wall, []), tmp_path / "door.json")
    assert [block.material for block in read_blocks(tmp_path / "door.json").blocks] == ["", "stone", "", "timber"]
    for words in (".4: .3/ .3", ".4: .3 -.6/stone .3"):
        with pytest.raises(CaseError, match=r"line 6: .* is no block's material; write it behind the width"):
            parse_rows(head + words, "door")
    with pytest.raises(CaseError, match=r"line 6: '\.4/stone' is not a number"):
        parse_rows(head + ".4/stone: .3", "door")


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("unit = mm\n", "", r"line \d+: a length before its unit is known; .*unit = mm"),
        ("unit = mm", "unit = kN", r"line 2: unit: unit 'kN' does not fit; use one of m, mm"),
        ("friction", "fricton", r"line 5: 'fricton' is not a known key; did you mean friction"),
        ("friction = 0.65\n", "", r"friction: is missing"),
        ("thickness = 100", "thickness = -100", r"line 3: thickness: -100 is not a positive number"),
        ("25 kN/m3", "25 kN/m2", r"line 4: unit_weight: unit 'kN/m2' does not fit"),
        ("175: 200 400", "175: 200 4OO", r"line 7: '4OO' is not a number"),
        ("175: 200", "0: 200", r"line 7: is not a course: '0' is no size"),
        ("175: 200", "-175: 200", r"line 7: is not a course: '-175' is no size"),
        ("175: 200", "175: -0 200", r"line 7: is not a course: '-0' is no size"),
        ("unit = mm", ":", r"line 2: is not a course"),
        ("unit = mm", "unit = mm\nunit = cm", r"line 3: unit: is given twice"),
        ("friction = 0.65", "friction = 0.65\nfriction = 0.1", r"line 6: friction: is given twice"),
        ("175: 200", "175: 0 200", r"line 7: is not a course"),
    ],
)
def test_row_notation_that_cannot_be_read(old, new, complaint):
    assert old in ROWS
    with pytest.raises(CaseError, match=complaint):
        parse_rows(ROWS.replace(old, new, 1), "wall")


def test_courses_of_openings_alone_are_refused():
    with pytest.raises(CaseError, match="courses: they hold openings only; write the width of a block without a minus"):
        parse_rows(ROWS.partition("175:")[0] + "175: -400 -200", "void")


def test_a_width_that_is_lost_in_rounding_is_refused(tmp_path):
    path = tmp_path / "thin.txt"
    path.write_text(ROWS.replace("175: 200", "175: 1e-300 200", 1))
    with pytest.raises(CaseError, match=r"thin\.txt: block \d+: "):
        import_wall(path, {})
