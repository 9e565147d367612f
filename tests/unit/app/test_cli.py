from __future__ import annotations

import json
import re

import pytest

from orchestrator.app import cli, driver, load_case_runs
from orchestrator.basis.errors import ConvergenceError, ResultError
from orchestrator.storage.summary import LimitSummary, Summary, WallSummary
from tests.support.paths import DATA
from tests.support.undrawn import undrawn

TOWER = str(DATA / "tower_5_blocks.json")


def test_limit_prints_the_multipliers_and_draws_the_mechanism(capsys, tmp_path):
    assert cli.main(["limit", TOWER, "--output", str(tmp_path)]) == 0
    assert sorted(path.name for path in (tmp_path / "figures").iterdir()) == [
        "mechanism.png", "mechanism.svg", "rigid_pushover.png", "rigid_pushover.svg",
    ]  # fmt: skip
    printed = capsys.readouterr().out
    assert "weight 16.000 kN" in printed
    for rule in ("associative, a bound", "met by loading", "the paper's value", "lowest found"):
        assert any("0.20000" in line for line in printed.splitlines() if rule in line), rule


def test_limit_draws_the_lowest_state_too_where_it_bears_far_less(capsys, tmp_path):
    assert cli.main(["limit", str(DATA / "rubble_46_stones.json"), "--output", str(tmp_path)]) == 0
    picture = tmp_path / "figures" / "lowest.png"
    assert picture.exists()
    assert f"mechanism of the lowest state found: {picture}\n" in capsys.readouterr().out
    assert cli.main(["limit", TOWER, "--output", str(tmp_path)]) == 0
    assert not picture.exists(), "its mechanism is of another wall"


def test_limit_lets_a_support_settle(capsys, tmp_path):
    """A tower on one support: it carries all its weight, also while it sinks."""
    assert cli.main(["limit", TOWER, "--settle", "0", "--output", str(tmp_path)]) == 0
    assert "least reaction 16.0000 kN" in capsys.readouterr().out
    assert (tmp_path / "figures" / "settlement.png").exists()
    assert cli.main(["limit", TOWER, "--settle", "1"]) == 2
    assert "tower_5_blocks.json: settlement.support: block 1 is not a support" in capsys.readouterr().err


def test_limit_json_is_the_summary_s_part_and_nothing_else(capsys):
    assert cli.main(["limit", TOWER, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["associative"] == pytest.approx(0.2, abs=1e-6)
    assert found["base_shear"] == pytest.approx(0.2 * 16e3, rel=1e-5)
    assert set(found) == {
        "associative", "non_associative", "non_associative_range", "going_down", "iterations", "converged",
        "equilibrium_residual",
        "base_shear", "seconds", "path", "last_rest", "soft_from", "interval", "papers_value", "lowest", "highest",
        "large_displacements", "rigid_peak", "pressed_peak", "local_failures", "associative_left", "base_shear_left",
        "is_bound",
        "meets_in_points",
    }  # fmt: skip


def test_segment_lists_the_bodies_with_their_blocks_and_draws_them(tmp_path, capsys):
    assert cli.main(["segment", TOWER, "--set", "macroblocks.tol_n=1e-3", "--output", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert re.search(r"^ +0 +5 +[\d.]+ 1-5 *$", printed, re.M), printed
    assert {path.name for path in (tmp_path / "figures").glob("*.png")} == {
        "macroblocks.png", "mechanism.png", "rigid_pushover.png",
    }  # fmt: skip
    assert "1 macroblock" in printed
    assert "one macroblock" in printed, "the trivial partition is said to be trivial"


def test_quiet_run_prints_nothing_and_leaves_the_run_folder(tmp_path, capsys):
    folder = tmp_path / "run"
    settings = ["--set", "stepping.final_displacement=0.5mm", "--set", "run.models=['macro']"]
    assert cli.main(["run", TOWER, "--output", str(folder), "-q", *settings]) == 0
    assert capsys.readouterr() == ("", "")
    expected = {
        "case.toml", "blocks.json", "joints.csv", "limit_analysis.json", "macroblocks.json", "summary.json", "run.log",
        "report.html", "verdict.csv", "joint_forces.csv", "section_forces.csv", "reactions.csv", "mechanism.dxf",
        "rigid_pushover.csv", "figures", "macro",
    }  # fmt: skip
    assert {path.name for path in folder.iterdir()} == expected
    log = (folder / "run.log").read_text()
    assert all(word in log for word in ("command: ", "versions: orchestrator ", f"sha256 of {TOWER}", "environment: "))
    inside = {
        "mesh.msh", "mesh.vtu", "curve.csv", "states.h5", "geometry.h5", "wall.xdmf", "wall.h5", "derived.h5",
        "contacts.xdmf",
    }  # fmt: skip
    assert {path.name for path in (folder / "macro").iterdir()} == inside
    with undrawn():
        assert cli.main(["run", str(folder / "case.toml"), "--output", str(tmp_path / "again"), "-q"]) == 0
    first, second = ((run / "macro" / "curve.csv").read_text() for run in (folder, tmp_path / "again"))
    assert first == second, "case.toml of a run folder repeats the run"


@pytest.mark.parametrize(
    ("complaint", "code"), [(ResultError("energy", "lost"), 3), (ConvergenceError("macro FE", "stopped"), 1)]
)
def test_exit_code_of_a_run_with_a_complaint(monkeypatch, tmp_path, capsys, complaint, code):
    limit = LimitSummary(0.1, None, None, 1, False, 0.0, 0.1, 0.1)
    record = Summary("x", WallSummary(1, 1, 1.0, 1.0, 1.0), limit, None, ())
    monkeypatch.setattr(driver, "run", lambda *arguments: driver.Outcome(record, (complaint,)))
    assert cli.main(["run", TOWER, "--output", str(tmp_path / "run"), "-q"]) == code
    assert capsys.readouterr().err == f"{complaint}\n"


@pytest.mark.parametrize(
    ("command", "remedy"),
    [
        ("run", " before anything was written"),
        ("run --force", " before anything was written"),
        ("run --resume", "; go on with --resume"),
        ("limit", ""),
    ],
)
def test_interruption_is_one_line(monkeypatch, capsys, command, remedy):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(driver, "run", interrupted)
    monkeypatch.setattr(driver, "limit", interrupted)
    assert cli.main([*command.split(), TOWER]) == 130
    assert capsys.readouterr().err == f"interrupted{remedy}\n"


def test_options_that_contradict_each_other_are_refused(tmp_path, capsys):
    assert cli.main(["run", TOWER, "--resume", "--force", "--output", str(tmp_path)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("--resume: does not go with --force, ")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("setting", ["load.direction=+x", "load.direction=+z"])
def test_an_angle_without_a_settlement_is_refused(tmp_path, capsys, setting):
    command = ["limit", TOWER, "--set", setting, "--settle-angle", "30", "--output", str(tmp_path)]
    assert cli.main(command) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line == "--settle-angle: is of a settlement, and there is none; give --settle ID with it"
    assert list(tmp_path.iterdir()) == []


SEISMIC = ("seismic.ground=B", "seismic.damping=0.04")


@pytest.mark.parametrize("cases", [[], ["--set", "load.cases=[{name='push', direction='+x'}]"]])
def test_a_verification_that_is_not_made_is_said(monkeypatch, tmp_path, capsys, cases):
    """Without any ground acceleration there is none, whatever else is asked of it."""
    settings = [word for one in SEISMIC for word in ("--set", one)]
    assert cli.main(["check", TOWER, *settings, *cases, "--output", str(tmp_path / "look")]) == 0
    said = "seismic.ground, seismic.damping: not read, as no verification is made without a ground acceleration"
    printed = capsys.readouterr().out
    assert printed.count(said) == 1
    assert "see the warnings above" in printed
    limit = LimitSummary(0.1, None, None, 1, False, 0.0, 0.1, 0.1)
    record = Summary("x", WallSummary(1, 1, 1.0, 1.0, 1.0), limit, None, ())
    monkeypatch.setattr(driver, "run", lambda *arguments: driver.Outcome(record, ()))
    monkeypatch.setattr(load_case_runs, "run", lambda *arguments: None)
    for given, times in ((settings, 1), ([], 0), ([*settings, "--set", "seismic.peak_ground_acceleration=0.1 g"], 0)):
        assert cli.main(["run", TOWER, *given, *cases, "--output", str(tmp_path / "run")]) == 0
        assert capsys.readouterr().out.count(said) == times
