"""Files of other people in the folder that a command writes into: they stay, whatever they are called."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from orchestrator.app import cli, driver
from tests.support.paths import DATA

TOWER = str(DATA / "tower_5_blocks.json")
SHORT = ["--model", "macro", "--set", "stepping.final_displacement=0.5mm", "-q"]
FOREIGN = (
    "Documents/.thesis.tmp/chapter1.txt", "other/runs/.7_bodies-0123456789ab.tmp/macro/curve.csv", ".notes.tmp",
    "a.tmp", ".states.12.tmp/x", "macro/notes.txt", "macro/states/notes.txt", "macro/.notes.tmp", "micro/notes.txt",
    "figures/mine.svg", "figures/mine.png", "figures/blocks.xlsx", "figures/macro_end.txt",
    "push/thesis.txt", "joints.csv.bak",
)  # fmt: skip
"""files of which none is the program's"""


def put(folder, names):
    for name in names:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"mine: {name}")


def files_in(folder):
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if not path.is_dir()}


def test_a_run_and_what_overwrites_it_leave_files_of_others_alone(tmp_path):
    put(tmp_path, [name for name in FOREIGN if not name.startswith(("macro", "micro"))])
    run = ["run", TOWER, *SHORT, "--output", str(tmp_path)]
    assert cli.main(run) == 0
    put(tmp_path, FOREIGN)
    assert cli.main([*run, "--resume"]) == 0
    put(tmp_path, ["macro/control_point.csv"])  # as a run with [seismic] leaves it
    assert cli.main([*run, "--force"]) == 0
    assert not (tmp_path / "macro" / "control_point.csv").exists(), "it would be taken for this run's"
    assert {name: (tmp_path / name).read_text() for name in FOREIGN} == {name: f"mine: {name}" for name in FOREIGN}
    assert cli.main(["limit", TOWER, "--output", str(tmp_path), "--force"]) == 0
    written = files_in(tmp_path) - set(FOREIGN)
    pictures = {f"figures/mechanism.{suffix}" for suffix in ("png", "svg")}
    tables = {"joint_forces.csv", "section_forces.csv", "reactions.csv", "mechanism.dxf", "run.log", "results.json"}
    assert written - {name for name in written if "rigid_pushover" in name} == pictures | tables
    assert set(FOREIGN) <= files_in(tmp_path)


@pytest.mark.parametrize("command", ["limit", "segment"])
@pytest.mark.parametrize("name", ["joint_forces.csv", "figures/mechanism.png", "results.json"])
def test_a_file_with_the_name_of_a_result_is_not_overwritten_without_force(tmp_path, capsys, command, name):
    """One of somebody else, and a result to which somebody has added something."""
    mine = tmp_path / name
    mine.parent.mkdir(exist_ok=True)
    mine.write_text("mine")
    again = [command, TOWER, "--output", str(tmp_path)]
    assert cli.main(again) == 2
    assert f"{mine}: would be overwritten, and is no result or has been changed since" in capsys.readouterr().err
    assert (files_in(tmp_path), mine.read_text()) == ({name}, "mine")
    assert cli.main([*again, "--force"]) == 0
    assert cli.main(again) == 0, "what the program has left itself may go"
    changed = next(tmp_path.glob("*.csv"))
    changed.write_text(changed.read_text() + "mine")
    assert cli.main(again) == 2
    assert changed.read_text().endswith("mine")


@pytest.mark.parametrize("command", ["limit", "segment"])
def test_the_wall_that_is_read_is_not_overwritten(tmp_path, capsys, command):
    """Not even with --force, be it named like a result."""
    wall = tmp_path / "results.json"
    wall.write_bytes(Path(TOWER).read_bytes())
    assert cli.main([command, str(wall), "--output", str(tmp_path), "--force"]) == 2
    assert f"{wall}: is read by this command, and would be overwritten" in capsys.readouterr().err
    assert wall.read_bytes() == Path(TOWER).read_bytes()
    assert files_in(tmp_path) == {"results.json"}


def test_load_cases_that_are_overwritten_leave_files_of_others_alone(tmp_path):
    put(tmp_path, FOREIGN)
    cases = ["--set", 'load.cases=[{name="push", direction="+x"}, {name="pull", direction="-x"}]']
    command = ["run", TOWER, *SHORT, *cases, "--output", str(tmp_path), "--force"]
    assert cli.main(command) == 0
    assert (tmp_path / "pull" / "summary.json").exists()
    assert cli.main(["run", TOWER, *SHORT, "--output", str(tmp_path), "--force"]) == 0
    assert {name: (tmp_path / name).read_text() for name in FOREIGN} == {name: f"mine: {name}" for name in FOREIGN}
    assert not (tmp_path / "pull").exists(), "a load case of the run that was overwritten"
    assert files_in(tmp_path / "push") == {"thesis.txt"}


def test_overwriting_follows_no_link(tmp_path):
    run, elsewhere = tmp_path / "run", tmp_path / "elsewhere"
    put(elsewhere, ["curve.csv", "states/000001.h5", "mechanism.png", ".curve.csv.orchestrator-12345678.tmp"])
    run.mkdir()
    (run / "summary.json").write_text("{}")
    names = ("macro", "figures", "case.toml", "reactions.csv")
    for name in names:
        (run / name).symlink_to(elsewhere)
    driver.storage.clear(run)
    assert len(files_in(elsewhere)) == 4
    assert not (run / "summary.json").exists()


def test_a_damaged_list_of_load_cases_leads_nowhere_else(tmp_path):
    put(tmp_path, ["mine/curve.csv", "report.html", "summary.json"])
    run = tmp_path / "run"
    run.mkdir()
    names = ("..", ".", "", "../mine", str(tmp_path / "mine"), 3)
    for name in names:
        (run / "load_cases.json").write_text(json.dumps({"load_cases": [{"name": name}]}))
        driver.storage.clear(run)
    assert files_in(tmp_path) == {"mine/curve.csv", "report.html", "summary.json"}


@pytest.mark.parametrize("command", ["check", "limit", "limit --settle 0", "segment", "run", "study", "sensitivity"])
@pytest.mark.parametrize(("output", "said"), [("", "is empty"), ("/", "is the root of the file system")])
def test_a_folder_that_nobody_means_is_refused_at_once(tmp_path, monkeypatch, capsys, command, output, said):
    def analysed(*_):
        raise AssertionError("the analysis has begun")

    monkeypatch.chdir(tmp_path)
    for name in ("limit", "run", "segment", "check"):
        monkeypatch.setattr(driver, name, analysed)
    ranges = ["--set", "sensitivity.friction=[0.5,0.7]"] if command == "sensitivity" else []
    arguments = [*command.split(), TOWER, "--output", output, *ranges]
    if output:
        assert cli.main(arguments) == 2
    else:
        with pytest.raises(SystemExit) as ended:
            cli.main(arguments)
        assert ended.value.code == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "--output" in line
    assert said in line
    assert list(tmp_path.iterdir()) == []
