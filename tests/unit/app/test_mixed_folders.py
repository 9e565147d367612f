"""A run folder is read where every part of it is as its run has written it; else one line names what is not."""

from __future__ import annotations

import json
import re
import shutil

import pytest

from orchestrator import CaseError, read_run
from orchestrator.app.cli import main
from tests.support.disks import read_only
from tests.support.paths import DATA
from tests.support.undrawn import undrawn

TOWER = str(DATA / "tower_5_blocks.json")
SHORT = ("--set", "stepping.final_displacement=0.3mm", "-q")
CASES = ("--set", 'load.cases=[{name="push", direction="+x"}, {name="pull", direction="-x"}]')
PARTS = ("macro/curve.csv", "macro/geometry.h5", "macro/states.h5", "limit_analysis.json", "macroblocks.json")


def run(folder, *settings):
    with undrawn():
        assert main(["run", TOWER, *SHORT, *settings, "--output", str(folder)]) == 0


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Runs of one wall of two frictions, and by two load cases, of both frictions too."""
    folder = tmp_path_factory.mktemp("runs")
    for name, friction in (("rough", "0.7"), ("smooth", "0.15")):
        setting = ("--set", f"wall.friction={friction}")
        run(folder / name, *setting, "--model", "macro")
        run(folder / f"{name} cases", *setting, *CASES, "--model", "macro")
    return folder


def refused(folder, capsys, named, said):
    """Assert that `report` and `read_run` name a file, in one line, and that nothing is written."""
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    capsys.readouterr()
    assert main(["report", str(folder)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"{folder / named}: ")
    assert said in line
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before


OTHER = "is not as the run wrote it: changed since, or of another run; copy it back, or `run` the case with --resume"


@pytest.mark.parametrize("part", [*PARTS, "macro/ties.csv"])
def test_a_part_of_another_run_is_named(runs, tmp_path, capsys, part):
    folder = shutil.copytree(runs / "rough", tmp_path / "run")
    other = "macro/curve.csv" if part.endswith("ties.csv") else part
    shutil.copy(runs / "smooth" / other, folder / part)
    refused(folder, capsys, part, OTHER)
    with pytest.raises(CaseError, match=re.escape(f"{part}: {OTHER}")):
        read_run(folder)


def digit(text):
    """Return a text with its last digit but twenty changed."""
    place = [found.start() for found in re.finditer(r"\d", text)][-20]
    return text[:place] + str((int(text[place]) + 1) % 10) + text[place + 1 :]


@pytest.mark.parametrize("change", [digit, lambda text: "".join(text.splitlines(keepends=True)[:-3])])
@pytest.mark.parametrize("part", ["macro/curve.csv", "limit_analysis.json", "macroblocks.json"])
def test_a_changed_digit_and_missing_rows_are_named(runs, tmp_path, capsys, part, change):
    folder = shutil.copytree(runs / "rough", tmp_path / "run")
    (folder / part).write_text(change((folder / part).read_text()))
    refused(folder, capsys, part, OTHER)


def test_what_is_named_is_written_again_by_the_command_that_the_line_names(runs, tmp_path, capsys):
    folder = shutil.copytree(runs / "rough", tmp_path / "run")
    shutil.copy(runs / "smooth" / "macro" / "curve.csv", folder / "macro")
    refused(folder, capsys, "macro/curve.csv", "--resume")
    run(folder, "--set", "wall.friction=0.7", "--model", "macro", "--resume")
    curve = (runs / "rough" / "macro" / "curve.csv").read_text()
    assert (folder / "macro" / "curve.csv").read_text() == curve
    with undrawn():
        assert main(["report", str(folder)]) == 0


def test_a_summary_whose_figures_were_changed_is_named(runs, tmp_path, capsys):
    folder = shutil.copytree(runs / "rough", tmp_path / "run")
    record = json.loads((folder / "summary.json").read_text())
    record["pushover"][0]["peak_multiplier"] *= 1.1
    (folder / "summary.json").write_text(json.dumps(record))
    refused(folder, capsys, "summary.json", OTHER)


def test_a_damaged_summary_is_told_in_the_words_of_this_program(runs, tmp_path, capsys):
    folder = shutil.copytree(runs / "rough", tmp_path / "run")
    record = json.loads((folder / "summary.json").read_text())
    record["pushover"][0]["steps"] = "many"
    (folder / "summary.json").write_text(json.dumps(record))
    refused(folder, capsys, "", "summary.json: pushover.0.steps: Input should be a valid integer")
    (folder / "summary.json").write_text(json.dumps(record)[:-40])
    refused(folder, capsys, "", "summary.json: Invalid JSON")


def test_a_run_of_an_earlier_version_is_told(runs, tmp_path, capsys):
    folder = shutil.copytree(runs / "rough", tmp_path / "run")
    record = json.loads((folder / "summary.json").read_text())
    del record["files"], record["sha256"]
    (folder / "summary.json").write_text(json.dumps(record))
    refused(folder, capsys, "summary.json", "it is of an earlier version; run the case again")


def test_a_report_of_its_own_run_is_made_again_and_again(runs, tmp_path):
    folder = shutil.copytree(runs / "rough cases", tmp_path / "run")
    with undrawn():
        for one in ("", "push", "", "pull", ""):
            assert main(["report", str(folder / one)]) == 0


@pytest.mark.parametrize("missing", [False, True])
def test_a_load_case_of_another_run_is_named(runs, tmp_path, capsys, missing):
    """It is whole in itself, and has other settings than its neighbour."""
    folder = shutil.copytree(runs / "rough cases", tmp_path / "run")
    shutil.rmtree(folder / "pull")
    if missing:
        (folder / "pull").mkdir()
        refused(folder, capsys, "pull/summary.json", "is missing from the folder of this run")
        return
    shutil.copytree(runs / "smooth cases" / "pull", folder / "pull")
    with undrawn():
        assert main(["report", str(folder / "pull")]) == 0
    refused(folder, capsys, "pull/summary.json", "is of another run than its neighbours")


def test_one_verdict_is_of_one_action(runs, tmp_path, capsys):
    """Load cases of which one was given another action were judged together."""
    folder = shutil.copytree(runs / "rough cases", tmp_path / "run")
    case = folder / "pull" / "case.toml"
    written = case.read_text()
    case.write_text(written.replace("confidence_factor = 1.35\n", "confidence_factor = 1.2\n"))
    assert case.read_text() != written
    refused(folder, capsys, "pull/case.toml", "seismic: is not that of load case push")


def test_a_part_of_the_last_load_case_is_named_before_the_first_is_drawn(runs, tmp_path, capsys):
    folder = shutil.copytree(runs / "rough cases", tmp_path / "run")
    shutil.copy(runs / "smooth cases" / "pull" / "macro" / "curve.csv", folder / "pull" / "macro")
    refused(folder, capsys, "pull/macro/curve.csv", OTHER)


def test_a_finished_load_case_with_a_part_of_another_run_is_not_taken_for_finished(runs, tmp_path):
    folder = shutil.copytree(runs / "rough cases", tmp_path / "run")
    shutil.copy(runs / "smooth cases" / "pull" / "macro" / "curve.csv", folder / "pull" / "macro")
    run(folder, "--set", "wall.friction=0.7", *CASES, "--model", "macro", "--resume")
    for name in ("push", "pull"):
        curve = (runs / "rough cases" / name / "macro" / "curve.csv").read_text()
        assert (folder / name / "macro" / "curve.csv").read_text() == curve
    with undrawn():
        assert main(["report", str(folder)]) == 0


def test_a_report_into_a_folder_that_takes_no_files_is_bad_input(runs, tmp_path, capsys):
    folder = shutil.copytree(runs / "rough", tmp_path / "run")
    with read_only(folder):
        assert main(["report", str(folder)]) == 2
    said = f"{folder}: cannot be written (read-only file system); give a copy of it elsewhere\n"
    assert capsys.readouterr().err == said
