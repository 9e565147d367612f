"""What the terminal says: that a command works, what it is given, and what a drawing may have lost."""

from __future__ import annotations

import io
import json
import logging
from pathlib import Path
from time import monotonic, sleep

import pytest

from orchestrator.app import cli, terminal
from orchestrator.app.commands import console_of
from orchestrator.app.progress import StageBegun, StageDone
from orchestrator.app.terminal import Reporter
from tests.support.paths import DATA
from tests.support.undrawn import undrawn

TOWER = str(DATA / "tower_5_blocks.json")


def test_nothing_printed_denies_the_state_that_counts(monkeypatch, capsys, tmp_path):
    """The paper's sequence finds nothing, another rule does: no line may say that no solution was found (D12)."""
    few = ["--set", "limit_analysis.maximum_iterations=4", "--set", "limit_analysis.tolerance=1e-300"]
    assert cli.main(["limit", TOWER, "--output", str(tmp_path), *few]) == 0
    printed = capsys.readouterr().out
    assert "the paper's sequence found no state: " in printed
    assert "no non-associative solution" not in printed
    assert "λ = 0.20000 counts (" in printed


def reported(terminal, *actions, kind="xterm"):
    console = console_of(file=io.StringIO(), force_terminal=terminal, width=200, _environ={"TERM": kind})
    with Reporter(console) as report:
        for action in actions:
            action(report)
    return console.file.getvalue()


def log(text):
    return lambda report: logging.getLogger("orchestrator.limit_analysis.search.other_states").info(text)


def test_limit_analysis_says_at_once_what_it_does_and_then_not_too_often():
    assert reported(False, log("first"), log("second")) == "micro-LA: first\n"
    assert "second" in reported(True, log("first"), log("second"))
    assert reported(True, log("first"), log("second"), kind="dumb") == "micro-LA: first\n"


def test_nothing_is_shown_of_limit_analysis_after_its_stage():
    """Finite elements have bars of their own."""
    stage = StageDone("micro-LA and macroblocks", 1.0, "done")
    assert "late" not in reported(False, lambda report: report(stage), log("late"))
    log("after")(None)
    assert logging.getLogger("orchestrator.limit_analysis").level == logging.NOTSET


@pytest.mark.parametrize("kind", ["xterm", "dumb"])
def test_what_a_run_does_between_its_analyses_is_shown(kind):
    """Bars on a terminal; elsewhere a plain line for each stage, without control characters."""
    begun = [StageBegun("pictures", "wall"), StageBegun("macro FE", "meshes [a]")]
    shown = reported(kind == "xterm", *[lambda report, one=one: report(one) for one in begun], kind=kind)
    if kind == "xterm":
        assert "pictures" in shown
        assert "meshes [a]" in shown
    else:
        assert shown == "pictures: wall ...\nmacro FE: meshes [a] ...\n"


def test_a_run_has_a_line_for_each_of_its_stages(tmp_path, capsys):
    settings = ["--set", "stepping.final_displacement=0.5mm", "--set", "run.models=['macro']"]
    assert cli.main(["run", TOWER, "--output", str(tmp_path / "run"), *settings]) == 0
    printed = capsys.readouterr().out
    stages = ("pictures: wall", "macro FE: meshes", "macro FE: checks", "report: curves")
    places = [printed.index(stage) for stage in stages]
    assert places == sorted(places)
    assert "\x1b" not in printed


@pytest.mark.parametrize(("patience", "said"), [(0.0, "report: pages ...\n"), (60.0, "")])
def test_a_command_that_takes_long_says_what_it_does(patience, said):
    console = console_of(file=io.StringIO(), force_terminal=False)
    with terminal.shown(console, "report", "pages", patience):
        until = monotonic() + 5.0
        while console.file.getvalue() != said and monotonic() < until:
            sleep(0.01)
    assert console.file.getvalue() == said


def test_a_terminal_shows_at_once_what_a_command_does():
    console = console_of(file=io.StringIO(), force_terminal=True, width=200, _environ={"TERM": "xterm"})
    with terminal.shown(console, "report", "pages"):
        until = monotonic() + 5.0
        while "pages" not in console.file.getvalue() and monotonic() < until:
            sleep(0.01)
    assert "pages" in console.file.getvalue()


def test_limit_begins_with_what_it_is_given(capsys, tmp_path):
    assert cli.main(["limit", TOWER, "--output", str(tmp_path)]) == 0
    assert capsys.readouterr().out.startswith("micro-LA: 5 blocks, 5 joints")


@pytest.mark.parametrize("suffix", ["json", "toml"])
def test_a_byte_order_mark_is_read_over(tmp_path, suffix):
    """Editors on Windows put one before UTF-8."""
    text = Path(TOWER).read_text() if suffix == "json" else f'[wall]\nblocks = "{TOWER}"\n'
    (tmp_path / f"wall.{suffix}").write_text("\ufeff" + text, encoding="utf-8")
    assert cli.main(["check", str(tmp_path / f"wall.{suffix}"), "--output", str(tmp_path / "out")]) == 0


def test_joints_that_a_drawing_may_have_lost_are_told_by_every_command(tmp_path, capsys):
    """Towers 1 mm apart: `check` warns, and so do those who do not ask it first."""
    boxes = [[-1, -0.2, 3, 0], [0, 0, 0.5, 1], [0.501, 0, 1, 1]]
    polygons = [[[left, low], [right, low], [right, high], [left, high]] for left, low, right, high in boxes]
    blocks = [{"id": n, "polygon": polygon, "fixed": n == 0} for n, polygon in enumerate(polygons)]
    record = {"units": {"length": "m", "unit_weight": "kN/m3"}, "thickness": 0.3, "friction": 0.6, "unit_weight": 20.0}
    (tmp_path / "towers.json").write_text(json.dumps(record | {"blocks": blocks}), encoding="utf-8")
    short = ["--set", "stepping.final_displacement=0.1mm", "--set", "run.models=['micro']"]
    said = "WARNING: 1 pair of blocks lies 1 mm apart or over each other, without a joint there"
    for command in ("check", "limit", "segment", "run"):
        more = short if command == "run" else []
        with undrawn():
            assert cli.main([command, str(tmp_path / "towers.json"), "--output", str(tmp_path / command), *more]) == 0
        assert capsys.readouterr().out.count(said) == 1, command
    assert said in (tmp_path / "run" / "report.html").read_text(encoding="utf-8")
