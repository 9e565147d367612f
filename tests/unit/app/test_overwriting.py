"""What no command overwrites unasked: results of a run, of another command, files that are there."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest

from orchestrator import storage
from orchestrator.app import cli, driver
from orchestrator.basis.errors import CaseError
from tests.support.paths import DATA, PROJECT
from tests.support.verdicts import summary

TOWER = str(DATA / "tower_5_blocks.json")


@pytest.fixture
def recorded(monkeypatch):
    """Stands in for the chain: the folders it was asked to run into."""
    folders = []

    def run(case, output, *_):
        folders.append(output)
        return driver.Outcome(summary(), ())

    monkeypatch.setattr(driver, "run", run)
    return folders


@pytest.mark.parametrize("left", ["summary.json", "macro", "load_cases.json"])
def test_a_run_is_not_overwritten_unasked(tmp_path, capsys, recorded, left):
    (tmp_path / left).mkdir()
    command = ["run", TOWER, "--output", str(tmp_path), "-q"]
    assert cli.main(command) == 2
    complaint = capsys.readouterr().err
    assert complaint.startswith(f"{tmp_path}: --output: holds the results of a run; ")
    assert "--force" in complaint
    assert recorded == []
    assert cli.main([*command, "--force"]) == cli.main([*command, "--resume"]) == 0
    assert recorded == [tmp_path, tmp_path]


def test_a_run_goes_beside_the_pictures_of_check(tmp_path, recorded):
    assert cli.main(["check", TOWER, "--output", str(tmp_path)]) == 0
    assert cli.main(["limit", TOWER, "--settle", "0", "--output", str(tmp_path)]) == 0
    assert cli.main(["run", TOWER, "--output", str(tmp_path), "-q"]) == 0
    assert recorded == [tmp_path]


@pytest.mark.parametrize("cases", ["", "[[load.cases]]\nname = 'east'\ndirection = '+x'\n"])
def test_a_run_overwrites_no_file_that_somebody_else_has_left_or_changed(tmp_path, capsys, recorded, cases):
    """`limit` and `run` follow each other in one folder; what was edited between them stays, as does a file of others
    with the name of a result."""
    (tmp_path / "wall.json").write_bytes(Path(TOWER).read_bytes())
    case, out = tmp_path / "mine.toml", tmp_path / "out"
    case.write_text(f'[wall]\nblocks = "wall.json"\n{cases}')
    command = ["run", str(case), "--output", str(out), "-q"]
    assert cli.main(["limit", str(case), "--output", str(out)]) == 0
    edited = next(out.rglob("joint_forces.csv"))
    left = edited.read_bytes()
    for mine in (edited, edited.parent / "mechanism.dxf", edited.parent / "figures" / "curves.png"):
        mine.write_text("mine")
        capsys.readouterr()
        assert cli.main(command) == 2
        assert capsys.readouterr().err.startswith(f"{mine}: would be overwritten, and is no result or has been changed")
        assert mine.read_text() == "mine"
        mine.unlink()
    edited.write_bytes(left)
    (edited.parent / "notes.txt").write_text("of no result")
    assert cli.main(command) == 0


@pytest.mark.parametrize("command", [("limit",), ("segment",), ("limit", "--set", "load.direction=+z")])
@pytest.mark.parametrize("left", ["summary.json", "load_cases.json"])
def test_a_finished_run_is_not_overwritten_by_limit_and_segment(tmp_path, capsys, command, left):
    call = [command[0], TOWER, *command[1:], "--output", str(tmp_path)]
    (tmp_path / left).write_text("{}")
    assert cli.main(call) == 2
    complaint = capsys.readouterr().err
    assert complaint.startswith(f"{tmp_path}: --output: holds the results of a run; give another --output, or ")
    assert [path.name for path in tmp_path.iterdir()] == [left], "nothing was drawn"
    (tmp_path / "macro").mkdir()
    if command[0] == "limit":
        assert cli.main([*call, "--json"]) == 0
    assert cli.main([*call, "--force"]) == 0
    assert not (tmp_path / left).exists(), "results of one wall beside those of another would be taken for its own"
    assert not (tmp_path / "macro").exists()
    assert cli.main(call) == 0


def test_no_command_says_first_what_it_runs_and_overwrites_no_results(tmp_path, monkeypatch, capsys, recorded):
    monkeypatch.chdir(tmp_path)
    assert cli.main([]) == 0
    first = capsys.readouterr().out.splitlines()[0]
    assert first.startswith("No command given: this runs the shipped benchmark 1 into results/benchmark1, as `")
    command = shlex.split(first.partition("`")[2].partition("`")[0])
    assert recorded == [Path("results/benchmark1")]
    (tmp_path / "results" / "benchmark1" / "macro").mkdir(parents=True)
    assert cli.main([]) == 2
    assert capsys.readouterr().err.startswith("results/benchmark1: --output: holds the results of a run; give another")
    assert recorded == [Path("results/benchmark1")]
    assert cli.main([*command[3:], "--force"]) == cli.main([*command[3:], "--resume"]) == 0
    assert len(recorded) == 3


@pytest.mark.parametrize("command", ["check", "limit", "limit --settle 0", "limit --set load.angle=9", "run", "study"])
def test_the_folder_is_tried_before_the_analysis(tmp_path, monkeypatch, capsys, command):
    def analysed(*_):
        raise AssertionError("the analysis has begun")

    for name in ("limit", "run", "segment", "check"):
        monkeypatch.setattr(driver, name, analysed)
    (tmp_path / "taken").write_text("a file")
    for output in (tmp_path / "taken", tmp_path / "taken" / "inside"):
        assert cli.main([*command.split(), TOWER, "--output", str(output)]) == 2
        assert capsys.readouterr().err == f"{tmp_path / 'taken'}: --output: is a file; give a folder\n"


def test_trying_a_folder_leaves_nothing(tmp_path):
    storage.try_folder(tmp_path / "not" / "yet")
    assert list(tmp_path.iterdir()) == []


def test_files_are_not_overwritten_unasked(tmp_path, capsys):
    rows = PROJECT / "templates" / "wall1.txt"
    for arguments in (
        ["import", str(rows), "--output", str(tmp_path / "wall.json")],
        ["schema", "--output", str(tmp_path / "schema.json")],
        ["new", "mine", "--output", str(tmp_path)],
    ):
        assert cli.main(arguments) == 0
        before = {path: path.stat().st_mtime_ns for path in tmp_path.iterdir()}
        capsys.readouterr()
        assert cli.main(arguments) == 2
        assert "exists already; " in capsys.readouterr().err
        assert {path: path.stat().st_mtime_ns for path in tmp_path.iterdir()} == before
        assert cli.main([*arguments, "--force"]) == 0


def test_an_export_is_not_overwritten_unasked(tmp_path):
    (tmp_path / "deck.inp").write_text("mine")
    with pytest.raises(CaseError, match="exists already"):
        storage.try_file(tmp_path / "deck.inp", force=False)
    assert cli.main(["export", TOWER, "--format", "abaqus", "--output", str(tmp_path / "deck.inp")]) == 2
    assert (tmp_path / "deck.inp").read_text() == "mine"


def test_no_command_writes_among_the_results_of_another(tmp_path, capsys):
    """A run is not drawn over by the check of an edited case, nor mixed with a study."""
    (tmp_path / "figures").mkdir()
    (tmp_path / "summary.json").write_text("{}")
    (tmp_path / "figures" / "blocks.png").write_text("of the run")
    assert cli.main(["check", TOWER, "--output", str(tmp_path)]) == 0
    assert (tmp_path / "figures" / "blocks.png").read_text() == "of the run"
    assert (tmp_path / "figures" / "checked.png").exists()
    for command in ("study", "sensitivity"):
        assert cli.main([command, TOWER, "--output", str(tmp_path)]) == 2
        assert "holds the results of a run; give another --output" in capsys.readouterr().err
    (tmp_path / "summary.json").unlink()
    (tmp_path / "table.csv").write_text("")
    assert cli.main(["run", TOWER, "--output", str(tmp_path)]) == 2
    assert "holds the results of a study" in capsys.readouterr().err


def test_force_removes_no_file_that_the_case_is_given(tmp_path, monkeypatch):
    """`import` writes blocks.json, as a run does: here it is the wall itself."""
    wall = tmp_path / "blocks.json"
    wall.write_text(Path(TOWER).read_text())
    (tmp_path / "summary.json").write_text("{}")
    monkeypatch.chdir(tmp_path)
    assert cli.main(["limit", "blocks.json", "--force", "--output", "."]) == 0
    assert wall.read_text() == Path(TOWER).read_text()
    assert not (tmp_path / "summary.json").exists()
