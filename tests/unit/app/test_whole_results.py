"""Results of a command are those of one analysis, or there are none: interrupted, killed, beside another one."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from orchestrator import storage
from orchestrator.app import cli
from orchestrator.present import plots
from orchestrator.present.in_space import space_pictures
from tests.support.killing import MORTAL, wait_for
from tests.support.paths import DATA, PROJECT
from tests.support.ranks import ENVIRONMENT
from tests.support.undrawn import undrawn

TOWER = str(DATA / "tower_5_blocks.json")
ROUGH, SMOOTH = ("--set", "wall.friction=0.7"), ("--set", "wall.friction=0.1")
IN_SPACE = ("--set", "load.direction=+z", "--set", "load.directions=2", "--set", "limit_analysis.states=headline")
PUSH_AND_PULL = ("--set", 'load.cases=[{name="push", direction="+x"}, {name="pull", direction="-x"}]')
UNDRAWN = "from tests.support.undrawn import undrawn\nundrawn = undrawn()\nundrawn.__enter__()\n"
SHORT = ("--model", "macro", "--set", "stepping.final_displacement=0.3mm", "-q")


def contents(folder):
    """Return the content of every file in a folder, by its name."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def settled(found):
    """Return contents without what differs between equal analyses: how long they took."""
    timed = ("limit_analysis.json", "results.json", "collapse.html")
    return {name: content for name, content in found.items() if name.split("/")[-1] not in timed}


def call(command, *arguments, output):
    name, *rest = command.split()
    with undrawn():
        return cli.main([name, TOWER, *rest, *arguments, "--output", str(output)])


@pytest.mark.parametrize(
    ("command", "settings", "broken"),
    [
        ("limit", (), (plots, "mechanism")),
        ("limit", PUSH_AND_PULL, (plots, "mechanism")),
        ("segment", (), (plots, "mechanism_dxf")),
        ("limit", IN_SPACE, (space_pictures, "save_polar")),
        ("limit --force", (), (plots, "mechanism")),
    ],
)
def test_an_interrupted_analysis_leaves_the_earlier_one(tmp_path, monkeypatch, capsys, command, settings, broken):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    assert call(command, *settings, *ROUGH, output=tmp_path) == 0
    before = contents(tmp_path)
    with monkeypatch.context() as patched:
        patched.setattr(*broken, interrupted)
        assert call(command, *settings, *SMOOTH, output=tmp_path) == 130
        assert contents(tmp_path) == before
        assert call(command, *settings, *SMOOTH, output=tmp_path / "new" / "folder") == 130
        assert not (tmp_path / "new").exists(), "neither a folder"
    assert capsys.readouterr().err == "interrupted\n" * 2


@pytest.mark.parametrize("last", ["joint_forces.csv", "mechanism.dxf", "figures/mechanism.png", "results.json"])
def test_an_analysis_that_is_killed_among_its_last_steps_is_never_mixed_with_the_earlier_one(tmp_path, last):
    """It puts its files in their places one right after the other; killed between two of them it leaves some of them,
    and next time these go."""
    folder, other = tmp_path / "out", tmp_path / "other"
    assert call("limit", *ROUGH, output=folder) == call("limit", *SMOOTH, output=other) == 0
    old, new = settled(contents(folder)), settled(contents(other))
    assert old["joint_forces.csv"] != new["joint_forces.csv"]
    killed = [sys.executable, "-c", UNDRAWN + MORTAL, last, "limit", TOWER, *SMOOTH, "--output", str(folder)]
    assert subprocess.run(killed, env=ENVIRONMENT, cwd=PROJECT, capture_output=True, timeout=120).returncode == -9
    left = {name: one for name, one in settled(contents(folder)).items() if not Path(name).name.startswith(".")}
    assert left.items() <= (old if last == "results.json" else new).items()
    assert (left == old) == (last == "results.json")
    assert call("limit", *PUSH_AND_PULL, output=folder) == 0
    assert {name.partition("/")[0] for name in contents(folder)} == {"push", "pull", "results.json"}
    assert not [path for path in folder.rglob(".*")], "nothing half-written"


def test_an_analysis_leaves_nothing_of_another_one_beside_its_own(tmp_path):
    """In space, by load cases, with macroblocks: what each of them alone has goes with it."""
    expected = None
    for command, settings in (
        ("limit", ()),
        ("limit", IN_SPACE),
        ("limit", ()),
        ("segment", ()),
        ("limit", ()),
        ("segment", PUSH_AND_PULL),
        ("limit", ()),
    ):
        assert call(command, *settings, output=tmp_path) == 0
        expected = expected or set(contents(tmp_path))
        assert (set(contents(tmp_path)) == expected) == (command == "limit" and settings == ())
    assert sorted(path.name for path in tmp_path.iterdir() if path.is_dir()) == ["figures"]
    call("segment", *PUSH_AND_PULL, output=tmp_path)
    assert call("run", *SHORT, output=tmp_path) == 0
    assert not (tmp_path / "push").exists()
    assert not (tmp_path / "results.json").exists(), "a run has its summary"


@pytest.mark.parametrize("command", ["limit", "segment"])
def test_files_of_others_stay_whatever_they_are_called(tmp_path, command):
    """What the program would call its own, had it written them, and what somebody has changed since."""
    mine = ("collapse.html", "directions.json", "tie_forces.csv", "figures/directions.png", "push/reactions.csv")
    mine += ("figures/settlement.png", "verdict.csv")
    for name in mine:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("mine")
    assert call(command, output=tmp_path) == 0
    (tmp_path / "section_forces.csv").write_text("mine, now")
    assert call("limit", *IN_SPACE, output=tmp_path / "space") == 0
    assert call("limit", *ROUGH, output=tmp_path) == 2, "it has a section_forces.csv of its own"
    assert call("limit", *ROUGH, "--force", output=tmp_path) == 0
    assert {name: (tmp_path / name).read_text() for name in mine} == dict.fromkeys(mine, "mine")
    (tmp_path / "section_forces.csv").write_text("mine, now")
    (tmp_path / "figures" / "mechanism.svg").unlink()
    (tmp_path / "figures" / "mechanism.svg").symlink_to(tmp_path / "verdict.csv")
    assert call("limit", "--set", "load.direction=+z", output=tmp_path) == 2, "it has a collapse.html of its own"
    (tmp_path / "collapse.html").unlink()
    assert call("limit", "--set", "load.direction=+z", output=tmp_path) == 0
    assert (tmp_path / "section_forces.csv").read_text() == "mine, now"
    assert (tmp_path / "verdict.csv").read_text() == "mine"
    assert not (tmp_path / "reactions.csv").exists()


@pytest.mark.parametrize(
    "record", ["{", "[]", '{"files": 3}', '{"files": {"../mine.txt": "x"}, "earlier": [1, ["a"], ["/etc/hosts", "x"]]}']
)
def test_a_damaged_record_leads_nowhere_else(tmp_path, record):
    (tmp_path / "mine.txt").write_text("mine")
    folder = tmp_path / "out"
    folder.mkdir()
    digest = storage.hash_file(tmp_path / "mine.txt")
    (folder / "results.json").write_text(record.replace('"x"', f'"{digest}"'))
    storage.clear(folder)
    assert (tmp_path / "mine.txt").read_text() == "mine"


def test_results_say_what_they_are_of(tmp_path):
    """With which settings, of which files, and which files they are."""
    case = tmp_path / "case.toml"
    case.write_text(f"[wall]\nblocks = '{TOWER}'\n")
    with undrawn():
        for settings in (ROUGH, (*ROUGH, *IN_SPACE)):
            assert cli.main(["limit", str(case), *settings, "--output", str(tmp_path / "out")]) == 0
            record = json.loads((tmp_path / "out" / "results.json").read_text())
            assert record["command"] == "limit"
            assert record["settings"]["wall"]["friction"] == 0.7
            assert record["sha256"] == {str(path): storage.hash_file(path) for path in (case, Path(TOWER))}
            found = {name: storage.hash_file(tmp_path / "out" / name) for name in contents(tmp_path / "out")}
            assert record["files"] | {"results.json": found["results.json"]} == found


@pytest.mark.parametrize(
    ("command", "settings"),
    [("run", SHORT), ("run", (*SHORT, *PUSH_AND_PULL)), ("limit", ()), ("limit", IN_SPACE), ("segment", ())],
)
def test_a_run_that_ends_while_another_command_begins_is_not_overwritten(
    tmp_path, monkeypatch, capsys, command, settings
):
    """It ends between the first question about the folder and the moment from which nobody else can write there."""
    folder = tmp_path / "run"

    def ends(*_):
        storage.write_json(folder / "summary.json", {"of": "another"})

    monkeypatch.setattr(storage, "try_folder", ends)
    assert call(command, *settings, output=folder) == 2
    assert f"{folder}: --output: holds the results of a run; " in capsys.readouterr().err
    assert contents(folder) == {"summary.json": b'{\n "of": "another"\n}\n'}


def test_a_run_holds_its_folder_while_it_is_in_limit_analysis(tmp_path, capsys):
    folder = tmp_path / "run"
    facade = [str(PROJECT / "templates" / "arched_facade.toml"), "--output", str(folder), "-q"]
    with subprocess.Popen(
        [sys.executable, "-m", "orchestrator", "run", *facade], cwd=PROJECT, env=ENVIRONMENT
    ) as process:
        try:
            assert wait_for(lambda: (folder / ".lock").exists() or (folder / "run.log").exists(), 60)
            assert not (folder / "run.log").exists(), "limit analysis is over"
            assert call("run", *SHORT, output=folder) == 2
            assert f"{folder}: is in use by process {process.pid} on " in capsys.readouterr().err
        finally:
            process.kill()


def test_a_load_case_does_not_overwrite_a_run_of_its_name(tmp_path, capsys):
    (tmp_path / "pull" / "macro").mkdir(parents=True)
    assert call("run", *SHORT, *PUSH_AND_PULL, output=tmp_path) == 2
    assert f"{tmp_path / 'pull'}: --output: holds the results of a run; " in capsys.readouterr().err


def test_a_second_sensitivity_of_other_ranges_is_refused_unless_by_force(tmp_path, capsys):
    def of(ranges, *more):
        settings = ("--set", f"sensitivity.friction={ranges}", "--set", "sensitivity.samples=0", *more)
        return call("sensitivity", *settings, output=tmp_path)

    assert of("[0.5,0.7]") == 0
    before = contents(tmp_path)
    assert of("[0.5,0.7]") == 0, "the same again"
    assert settled(contents(tmp_path)) == settled(before)
    capsys.readouterr()
    for other in (("[0.4,0.7]",), ("[0.5,0.7]", "--set", "wall.thickness=0.2")):
        assert of(*other) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert line.startswith(f"{tmp_path}: --output: holds a sensitivity of other settings, ")
        assert line.endswith("; give another --output, or overwrite it with --force")
    assert contents(tmp_path) == before
    assert of("[0.4,0.7]", "--force") == 0
    assert (tmp_path / "sensitivity.csv").read_bytes() != before["sensitivity.csv"]
    assert set(before) < set(contents(tmp_path)), "points that were run are used again"


def test_a_sensitivity_does_not_replace_a_limit_analysis(tmp_path, capsys):
    assert call("limit", output=tmp_path) == 0
    before = contents(tmp_path)
    settings = ("--set", "sensitivity.friction=[0.5,0.7]", "--set", "sensitivity.samples=0")
    assert call("sensitivity", *settings, output=tmp_path) == 2
    assert f"{tmp_path}: --output: holds the results of limit; give another" in capsys.readouterr().err
    assert contents(tmp_path) == before
