"""Situations that break programs: no traceback, no hang, nothing of the user's overwritten, the right exit code."""

from __future__ import annotations

import json
import os

import pytest

from orchestrator.app.cli import main
from tests.support.paths import PROJECT
from tests.support.two_blocks import WALL, changed

MICRO = "[run]\nmodels = ['micro']\n"


@pytest.fixture
def wall(tmp_path):
    path = tmp_path / "wall.json"
    path.write_text(json.dumps(WALL))
    return path


def complaint(capsys, code, *arguments):
    """Run a command that must end with `code`, and return the one line it says on standard error."""
    assert main([str(argument) for argument in arguments]) == code
    (line,) = capsys.readouterr().err.splitlines()
    assert "Traceback" not in line
    return line


@pytest.mark.parametrize("suffix", ["json", "toml", "txt", "dxf", "png"])
@pytest.mark.parametrize("kind", ["pipe", "device"])
def test_what_has_no_end_is_refused_unread(tmp_path, capsys, kind, suffix):
    """A pipe that nobody writes to hangs its reader; /dev/zero fills the memory."""
    path = tmp_path / f"wall.{suffix}"
    if kind == "pipe":
        os.mkfifo(path)
    else:
        path.symlink_to("/dev/zero")
    if suffix in ("json", "toml"):
        line = complaint(capsys, 2, "check", path)
    else:
        options = () if suffix == "txt" else ("--thickness", "0.3", *(("--scale", "0.01") * (suffix == "png")))
        line = complaint(capsys, 2, "import", path, "--output", tmp_path / "out.json", *options)
    assert f"{path}: is no file but a pipe or a device" in line


@pytest.mark.parametrize("own", ["case.toml", "blocks.json"])
def test_a_run_does_not_overwrite_what_it_is_given(tmp_path, wall, capsys, own):
    folder = tmp_path / "mine"
    folder.mkdir()
    wall = wall.rename(folder / ("blocks.json" if own == "blocks.json" else "wall.json"))
    case = folder / ("case.toml" if own == "case.toml" else "mine.toml")
    case.write_text(f"{MICRO}# my comment\n[wall]\nblocks = '{wall.name}'\n")
    before = {path: path.read_bytes() for path in folder.iterdir()}
    line = complaint(capsys, 2, "run", case, "--output", folder)
    assert f"{folder / own}: is read by this command" in line
    assert {path: path.read_bytes() for path in folder.iterdir()} == before


def test_import_does_not_overwrite_what_it_reads(wall, capsys):
    before = wall.read_bytes()
    assert "is read by this command" in complaint(capsys, 2, "import", wall, "--output", wall)
    assert wall.read_bytes() == before


@pytest.mark.parametrize("name", ["out", "o\nut"])
@pytest.mark.parametrize("command", ["check", "run"])
def test_an_output_folder_that_is_a_file_stays_as_it_is(tmp_path, wall, capsys, command, name):
    (tmp_path / name).write_text("mine")
    assert str(tmp_path / "o") in complaint(capsys, 2, command, wall, "--output", tmp_path / name)
    assert (tmp_path / name).read_text() == "mine"


@pytest.mark.parametrize("angle", ["nan", "inf"])
def test_a_support_settles_along_a_line(wall, capsys, angle):
    assert "--settle-angle" in complaint(capsys, 2, "limit", wall, "--settle", "0", "--settle-angle", angle)


@pytest.mark.parametrize("key", ["thickness", "unit_weight", "friction"])
@pytest.mark.parametrize("value", [1e-250, 1e250])
def test_numbers_whose_products_are_none_are_refused(wall, capsys, key, value):
    wall.write_text(json.dumps(changed([key], value)))
    remedy = "give the tangent of an angle" if key == "friction" else "is its unit right?"
    assert remedy in complaint(capsys, 2, "limit", wall)


@pytest.mark.parametrize("key", ["thickness", "unit_weight", "friction"])
@pytest.mark.parametrize("value", [1e-250, 1e250])
def test_such_numbers_of_a_case_are_told_by_its_file_and_key(wall, capsys, key, value):
    case = wall.with_name("case.toml")
    case.write_text(f'[wall]\nblocks = "{wall.name}"\n{key} = {value}\n')
    assert complaint(capsys, 2, "limit", case).startswith(f"{case}: wall.{key}: ")


@pytest.mark.parametrize("modulus", ["1e-300", "1e300"])
def test_stones_of_rubber_or_of_nothing_known_are_refused(wall, capsys, modulus):
    assert "elastic.elastic_modulus" in complaint(
        capsys, 2, "check", wall, "--set", f"elastic.elastic_modulus={modulus}"
    )


@pytest.mark.parametrize("tolerance", ["1e-300", "1e9"])
def test_a_slip_that_no_joint_has_is_refused(wall, capsys, tolerance):
    setting = f"contact.slip_tolerance={tolerance}"
    assert "contact.slip_tolerance" in complaint(capsys, 2, "check", wall, "--set", setting)


@pytest.mark.parametrize("name", ["no\nsuch.json", "a\0b.json", f"{5000 * 'a'}.json"])
def test_names_of_files_that_are_none(tmp_path, capsys, name):
    complaint(capsys, 2, "check", tmp_path / name)


@pytest.mark.parametrize("depth", ["[" * 200_000, '{"a":' * 100_000])
@pytest.mark.parametrize("name", ["wall.json", "case.toml"])
def test_files_that_are_deeper_than_the_stack(tmp_path, capsys, name, depth):
    (tmp_path / name).write_text(depth if name == "wall.json" else f"a = {depth}")
    assert name in complaint(capsys, 2, "check", tmp_path / name)


@pytest.mark.parametrize("setting", ["=", ".=1", "mesh..size=1", "mesh=1", "mesh.size=", "mesh.size=1\n2", "a.b=1"])
def test_settings_that_are_none(wall, capsys, setting):
    assert "; " in complaint(capsys, 2, "check", wall, "--set", setting)


@pytest.mark.parametrize("text", ["null", "[]", "{}", '{"pushover": null}', "{", '{"pushover": [{"model": "../.."}]}'])
def test_a_summary_that_is_none_is_named_by_report(tmp_path, wall, capsys, text):
    wall.rename(tmp_path / "blocks.json")
    (tmp_path / "case.toml").write_text("[wall]\nblocks = 'blocks.json'\n")
    (tmp_path / "summary.json").write_text(text)
    assert str(tmp_path) in complaint(capsys, 2, "report", tmp_path)


def test_a_misspelt_command_or_option_takes_one_line(capsys):
    for arguments in (
        ["chek", "wall.json"],
        ["run"],
        ["limit", "wall.json", "--settle", "x"],
        ["run", "a", "--mdoel", "b"],
    ):
        with pytest.raises(SystemExit) as ended:
            main(arguments)
        (line,) = capsys.readouterr().err.splitlines()
        assert ended.value.code == 2
        assert line.endswith("--help lists what there is")


def test_bytes_of_another_encoding_are_said_with_their_line(tmp_path, wall, capsys):
    for name in ("case.toml", "wall.json", "wall.txt"):
        (tmp_path / name).write_bytes('# one line\nname = "façade"\n'.encode("latin-1"))
        command = ["import"] if name == "wall.txt" else ["check"]
        assert main([*command, str(tmp_path / name), "--output", str(tmp_path / "out.json")]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert line == f"{tmp_path / name}: is not UTF-8 text (byte 0xe7 in line 2); save it as UTF-8"


def test_a_missing_block_file_is_told_by_its_key(tmp_path, capsys):
    (tmp_path / "case.toml").write_text("[wall]\nblocks = 'absent.json'")
    assert main(["check", str(tmp_path / "case.toml"), "--output", str(tmp_path / "out")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"{tmp_path / 'case.toml'}: wall.blocks: {tmp_path / 'absent.json'}: no such file; ")


@pytest.mark.parametrize("command", ["check", "limit", "run", "import", "new mine", "schema", "export"])
def test_what_cannot_be_written_is_refused_before_anything_is_done(wall, capsys, command):
    """No process may make files in /proc."""
    name, *rest = command.split()
    given = [] if name in ("new", "schema") else [str(wall)]
    output = "/proc/new" + {"import": ".json", "schema": ".json", "export": ".msh"}.get(name, "")
    assert main([name, *rest, *given, "--output", output]) == 2
    out, err = capsys.readouterr()
    (line,) = err.splitlines()
    assert "--output: cannot be written (" in line
    assert out == ""


def test_a_folder_is_no_file_to_write(tmp_path, capsys):
    assert main(["schema", "--output", str(tmp_path), "--force"]) == 2
    assert capsys.readouterr().err == f"{tmp_path}: --output: is a folder; give a file\n"


def test_a_unit_left_out_is_pointed_out(tmp_path, wall, capsys):
    """A thickness of 300 m, and a wall of a kilometre."""
    drawing = tmp_path / "wall.txt"
    rows = (PROJECT / "templates" / "wall1.txt").read_text()
    drawing.write_text(rows.replace("thickness = 100", "thickness = 300 m"))
    assert main(["import", str(drawing), "--output", str(tmp_path / "out.json")]) == 0
    assert "WARNING: the wall is 300 m thick" in capsys.readouterr().out
    (tmp_path / "mm.json").write_text(json.dumps(WALL | {"units": {"length": "km", "unit_weight": "kN/m3"}}))
    assert main(["limit", str(tmp_path / "mm.json"), "--output", str(tmp_path / "out")]) == 0
    assert "m: is the unit right?" in capsys.readouterr().out
