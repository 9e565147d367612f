"""Corners that were clicked twice are one, and a corner that was forgotten is told: block files and drawings."""

from __future__ import annotations

import json
import warnings

import numpy as np
import pytest

from orchestrator.app import cli
from orchestrator.masonry.sources.block_files import read_blocks
from tests.support.undrawn import undrawn
from tests.support.walls import between

GROUND = between(-0.5, -0.3, 1.7, 0.0).tolist()
STONES = [between(*box).tolist() for box in ((0, 0, 0.6, 0.3), (0.6, 0, 1.2, 0.3), (0.3, 0.3, 0.9, 0.6))]
CLICK = 1e-5
"""m: of 0.014 mm in all, more than the rounding of a drawing of such stones"""
MATERIAL = ["--thickness", "500 mm"]


def stones(click=0.0, spike=0.0):
    """The three stones. The corner of the second at (1.2, 0.3) is clicked again beside it, so that the outline crosses
    itself; the lower edge of the third goes too far and comes back."""
    found = [list(map(list, outline)) for outline in STONES]
    if click:
        found[1].insert(3, [1.2 + click, 0.3 - click])
        found[1].insert(4, [1.2, 0.3 - click])
    if spike:
        found[2].insert(1, [0.9 + spike, 0.3])
    return found


def block_file(path, outlines):
    record = {"units": {"length": "m", "unit_weight": "kN/m3"}, "thickness": 0.5, "friction": 0.6, "unit_weight": 20.0}
    blocks = [{"id": n, "polygon": one, "fixed": n == 0} for n, one in enumerate((GROUND, *outlines))]
    path.write_text(json.dumps(record | {"blocks": blocks}), encoding="utf-8")
    return path


def drawing(path, outlines):
    """Write an SVG of 1 mm a unit, y downwards."""
    groups = {"supports": [GROUND], "blocks": outlines}
    body = ""
    for name, rings in groups.items():
        words = (" L ".join(f"{1e3 * (x + 1):.5f},{1e3 * (1 - y):.5f}" for x, y in ring) for ring in rings)
        body += f'<g id="{name}">' + "".join(f'<path d="M {ring} Z"/>' for ring in words) + "</g>"
    size = 'width="3000mm" height="2000mm" viewBox="0 0 3000 2000"'
    path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" {size}>{body}</svg>', encoding="utf-8")
    return path


def call(*arguments):
    with undrawn():
        return cli.main([*map(str, arguments)])


@pytest.mark.parametrize("kind", ["json", "svg"])
@pytest.mark.parametrize("tolerance", ["1 mm", "4 mm"])
def test_a_second_click_beside_a_corner_is_that_corner(kind, tolerance, tmp_path, capsys):
    write, more = (block_file, []) if kind == "json" else (drawing, MATERIAL)
    areas = {}
    for name, click in (("once", 0.0), ("twice", CLICK)):
        source, output = write(tmp_path / f"{name}.{kind}", stones(click)), tmp_path / f"{name}_read.json"
        assert call("import", source, "--tolerance", tolerance, "--output", output, *more) == 0
        said = capsys.readouterr().out
        assert ("1 outline has corners drawn twice, up to 0.014 mm apart, taken for one" in said) == (name == "twice")
        areas[name] = [len(block.polygon) for block in read_blocks(output).blocks]
    assert areas["twice"] == areas["once"] == [4, 4, 4, 4]


def test_without_a_tolerance_it_is_asked_whether_the_corners_are_one(tmp_path, capsys):
    assert call("check", block_file(tmp_path / "wall.json", stones(CLICK)), "--output", tmp_path / "run") == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "block 2: its polygon crosses or touches itself" in line
    assert 'apart may be one: import the file with --tolerance "1 mm"' in line


def test_an_outline_that_crosses_itself_otherwise_is_refused_as_before(tmp_path, capsys):
    bow = [[0, 0], [0.6, 0.3], [0.6, 0], [0, 0.3]]
    for source, more in (
        (block_file(tmp_path / "wall.json", [bow]), ["--tolerance", "4 mm"]),
        (drawing(tmp_path / "wall.svg", [bow]), MATERIAL),
    ):
        assert call("import", source, "--output", tmp_path / "read.json", *more) == 2
        line = capsys.readouterr().err
        assert "crosses or touches itself at (0.3, 0.15) m" in line
        assert "may be one" not in line


def test_a_second_click_within_the_rounding_of_a_drawing_is_none(tmp_path):
    """0.0014 mm on stones of 0.4 m, where outlines are joined over 0.01 mm."""
    wall = read_blocks(block_file(tmp_path / "wall.json", stones(1e-6)))
    assert [len(block.polygon) for block in wall.blocks] == [4, 4, 4, 4]
    assert not wall.remarks
    assert call("check", tmp_path / "wall.json", "--output", tmp_path / "run") == 0


@pytest.mark.parametrize("kind", ["json", "svg"])
def test_a_spike_without_width_is_taken_away_and_told(kind, tmp_path, capsys):
    write, more = (block_file, []) if kind == "json" else (drawing, MATERIAL)
    source, output = write(tmp_path / f"wall.{kind}", stones(spike=0.2)), tmp_path / "read.json"
    assert call("import", source, "--output", output, *more) == 0
    said = capsys.readouterr().out
    assert "m and back on itself, 200 mm far: that spike is taken away; was a corner forgotten?" in said
    assert said.index("WARNING") == 0
    assert [len(block.polygon) for block in read_blocks(output).blocks] == [4, 4, 4, 4]
    assert np.ptp(read_blocks(output).blocks[3].polygon[:, 0]) == pytest.approx(0.6)


def test_every_command_tells_of_the_spike_of_a_block_file(tmp_path, capsys):
    source = block_file(tmp_path / "wall.json", stones(spike=0.2))
    said = "WARNING: the outline of block 3 goes out to (1.1, 0.3) m and back on itself, 200 mm far"
    for command in ("check", "limit", "segment"):
        assert call(command, source, "--output", tmp_path / command) == 0
        assert capsys.readouterr().out.count(said) == 1, command
    short = ["--set", "stepping.final_displacement=0.1mm", "--model", "micro"]
    assert call("run", source, "--output", tmp_path / "run", *short) == 0
    assert capsys.readouterr().out.count(said) == 1
    assert said in " ".join((tmp_path / "run" / "report.html").read_text(encoding="utf-8").split())


def test_a_spike_of_rounding_is_not_told(tmp_path):
    assert not read_blocks(block_file(tmp_path / "wall.json", stones(spike=1e-4))).remarks


def wedge(gap):
    """Two stones and one that is wedged between their slanting faces: on that of the first, `gap` (m) off the other."""
    left, right = [[0, 0], [0.5, 0], [0.4, 0.4], [0, 0.4]], [[0.7, 0], [1.2, 0], [1.2, 0.4], [0.8, 0.4]]
    along = gap * 17 / 8 / 17**0.5  # up the first face, which rises by four where it recedes by one
    middle = [[0.475, 0.1], [0.725, 0.1], [0.8, 0.4], [0.4, 0.4]]
    return [left, right, [[x - along, y + 4 * along] for x, y in middle]]


@pytest.mark.parametrize("command", ["check", "limit"])
def test_a_wall_that_falls_for_gaps_of_rounding_is_told_of_them(command, tmp_path, capsys):
    """So do stones that fit each other when their coordinates are rounded to 0.1 mm."""
    file = block_file(tmp_path / "wedge.json", wedge(0.00005))
    assert call(command, file, "--output", tmp_path / "out") == 2
    said = capsys.readouterr().err
    assert "cannot stand under its own weight: block 3 would move" in said
    assert "gaps may be why: 1 pair of blocks lies 0.05 mm apart or over each other, without a joint there" in said
    assert "import the file with a larger --tolerance" in said


def test_an_import_that_closes_nothing_tells_of_gaps_and_one_with_a_tolerance_closes_them(tmp_path, capsys):
    file, output = block_file(tmp_path / "wedge.json", wedge(0.00005)), tmp_path / "blocks.json"
    assert call("import", file, "--output", output) == 0
    assert "1 pair of blocks lies 0.05 mm apart" in capsys.readouterr().out
    assert call("import", file, "--output", output, "--force", "--tolerance", "1 mm") == 0
    assert "1 gap between blocks closed" in capsys.readouterr().out
    assert call("check", output, "--output", tmp_path / "out") == 0


def test_a_stone_that_a_block_file_has_twice_is_kept_once_where_it_is_healed(tmp_path, capsys):
    file, output = block_file(tmp_path / "twice.json", [*stones(), stones()[1]]), tmp_path / "blocks.json"
    assert call("import", file, "--output", output, "--tolerance", "1 mm") == 0
    assert "blocks: 1 outline drawn twice, kept once" in capsys.readouterr().out
    assert [block["id"] for block in json.loads(output.read_text(encoding="utf-8"))["blocks"]] == [0, 1, 2, 3]


@pytest.mark.parametrize("other", [{"fixed": True}, {"material": "brick"}, {"unit_weight": 25.0}])
def test_what_lies_on_a_stone_and_is_another_is_refused(other, tmp_path, capsys):
    """A support, or a stone of another material: which of the two is meant nobody knows."""
    file = block_file(tmp_path / "other.json", [*stones(), stones()[1]])
    record = json.loads(file.read_text(encoding="utf-8"))
    record["blocks"][-1] |= other
    file.write_text(json.dumps(record), encoding="utf-8")
    assert call("import", file, "--output", tmp_path / "blocks.json", "--tolerance", "1 mm") == 2
    assert "drawn twice? remove one of them" in capsys.readouterr().err


def test_two_outlines_on_one_another_that_cross_themselves_are_refused(tmp_path, capsys):
    bow = [[0.0, 0.3], [0.6, 0.6], [0.6, 0.3], [0.0, 0.6]]
    file = block_file(tmp_path / "bow.json", [*stones(), bow, bow])
    assert call("import", file, "--output", tmp_path / "blocks.json", "--tolerance", "1 mm") == 2
    assert "block 4: its polygon crosses or touches itself" in capsys.readouterr().err


def test_a_corner_of_three_coordinates_is_no_corner_of_a_plane_wall(tmp_path, capsys):
    outlines = stones()
    outlines[0] = [[*corner, 0.0] for corner in outlines[0]]
    assert call("check", block_file(tmp_path / "solid.json", outlines)) == 2
    assert "block 1.polygon: is not a list of at least three corners [x, y];" in capsys.readouterr().err


def test_a_name_in_letters_that_no_font_has_is_drawn_without_a_warning_of_the_library(tmp_path):
    record = json.loads(block_file(tmp_path / "name.json", stones()).read_text(encoding="utf-8"))
    (tmp_path / "name.json").write_text(json.dumps({"name": "\u58c1"} | record), encoding="utf-8")
    with warnings.catch_warnings():
        warnings.filterwarnings("error", "Glyph")
        assert cli.main(["limit", str(tmp_path / "name.json"), "--output", str(tmp_path / "out")]) == 0
