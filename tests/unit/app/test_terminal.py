"""What the terminal says: that it works, which number counts, and what it will not overwrite."""

from __future__ import annotations

import io
import json
import logging
import shlex
from dataclasses import replace
from pathlib import Path
from time import monotonic, sleep

import pytest

from orchestrator import storage
from orchestrator.app import cli, driver, terminal
from orchestrator.app.commands import console_of
from orchestrator.app.progress import StageBegun, StageDone
from orchestrator.app.terminal import Reporter
from orchestrator.basis.errors import CaseError
from orchestrator.limit_analysis import analyse
from orchestrator.present.answer import answer_of_limit, answer_of_run
from orchestrator.storage.notes import remarks
from orchestrator.storage.summary import AtPeak, LimitSummary, Summary, WallSummary
from tests.support.limit_analysis_cases import assemblage_of, box
from tests.support.paths import DATA, PROJECT
from tests.support.pushed import PUSHED
from tests.support.undrawn import undrawn

TOWER = str(DATA / "tower_5_blocks.json")


@pytest.fixture(scope="module")
def slender():
    """A block 0.5 m wide and 1 m high overturns at 0.5, with or without dilation."""
    return analyse(assemblage_of([box(-3, -1, 6, 1), box(0, 0, 0.5, 1.0)]))


def without_any_state(analysis):
    return replace(analysis, sequence=None, path=None, lowest=None)


def at(analysis, *, lowest=None, bound=None):
    """Return the analysis with another lowest state or another associative bound."""
    associative = analysis.associative
    if bound is not None:
        associative = replace(associative, load_multiplier=bound)
    found = None if lowest is None else replace(analysis.headline, load_multiplier=lowest)
    return replace(analysis, associative=associative, lowest=found)


def test_the_multiplier_that_counts_is_named_with_its_base_shear(slender):
    said = answer_of_limit(slender)
    assert said.startswith("λ = 0.50000 counts (collapse state met by loading): base shear ")
    assert slender.horizontal_load == 10e3
    assert "base shear 5.000 kN, " in said
    assert "it reaches the associative upper bound" in said


def test_a_lower_state_and_a_higher_bound_are_said(slender):
    said = answer_of_limit(at(slender, lowest=0.45, bound=0.6))
    assert "from 0.45000 to 0.50000" in said
    assert "the associative 0.60000 is an upper bound" in said
    alone = answer_of_limit(at(slender, bound=0.6))
    assert "from" not in alone
    assert "the associative 0.60000 is an upper bound" in alone


def test_the_bound_alone_counts_as_no_more_than_that(slender):
    said = answer_of_limit(without_any_state(slender))
    assert said.startswith("λ = 0.50000 counts (associative solution)")
    assert "an upper bound only" in said


def test_a_last_rest_is_called_no_collapse_state(slender):
    rest = replace(slender.path, flow_rule="last_rest", converged=False)
    said = answer_of_limit(replace(slender, path=rest))
    assert said.startswith("Loading met no limit state; the wall was at rest up to λ = (0.50000): ")
    assert "counts" not in said
    assert "a collapse state with" not in said


def test_beside_a_last_rest_states_found_otherwise_are_told_apart(slender):
    """Nothing may be called a state of rest that is none, nor may it be said that there is no limit state."""
    rest = replace(slender.path, flow_rule="last_rest", converged=False)
    found = replace(slender, path=rest, lowest=replace(slender.path, load_multiplier=0.52), highest=0.55)
    assert "limit states found without loading have 0.52000 to 0.55000; the associative" in answer_of_limit(found)
    assert "such states" not in answer_of_limit(found)


def test_nothing_printed_denies_the_state_that_counts(monkeypatch, capsys, tmp_path):
    """The paper's sequence finds nothing, another rule does: no line may say that no solution was found (D12)."""
    few = ["--set", "limit_analysis.maximum_iterations=4", "--set", "limit_analysis.tolerance=1e-300"]
    assert cli.main(["limit", TOWER, "--output", str(tmp_path), *few]) == 0
    printed = capsys.readouterr().out
    assert "the paper's sequence found no state: " in printed
    assert "no non-associative solution" not in printed
    assert "λ = 0.20000 counts (" in printed


def entry(model, peak, *, valid=True, reached=True):
    changed = {"peak_reached": reached, "peak_base_shear": peak, "peak_multiplier": peak / 1e5}
    return replace(PUSHED, model=model, bodies={"macro": 2, "micro": 4}[model], valid=valid, **changed)


def summary_of(*pushovers, failed=None):
    limit = LimitSummary(0.3, 0.25, (0.25, 0.26), 4, True, 1e-12, 8e3, 1.0)
    return Summary("tower", WallSummary(4, 8, 40e3, 40e3, 40e3), limit, None, pushovers, failed=failed)


@pytest.mark.parametrize(
    ("pushover", "words", "absent"),
    [
        (
            [entry("macro", 21e3), entry("micro", 20e3)],
            ["20.00 kN counts (λ = 0.2000", "macroblocks (21.00 kN, +5.0%)", "limit analysis (+25.0%)"],
            [],
        ),
        (
            [entry("macro", 25e3 * (1 - 1e-6)), entry("micro", 25e3)],
            ["macroblocks (25.00 kN, +0.0%)", "limit analysis (+0.0%)"],
            ["-0.0"],
        ),
        (
            [replace(entry("macro", 20e3), bodies=4), entry("micro", 20e3)],
            ["FE of every stone); macroblocks are every stone, too (20.00 kN, +0.0%); limit analysis"],
            ["approximation"],
        ),
        ([replace(entry("macro", 21e3), bodies=4)], ["FE of every stone); limit analysis"], ["macroblocks"]),
        ([entry("macro", 21e3)], ["21.00 kN counts", "FE of macroblocks"], ["approximation"]),
        (
            [entry("macro", 21e3), entry("micro", 20e3, valid=False)],
            [
                "21.00 kN counts (λ = 0.2100, FE of macroblocks), but the curve of every stone, the reference of "
                "macroblocks, is not valid; limit analysis"
            ],
            ["20.00"],
        ),
        ([entry("micro", 20e3), entry("macro", 21e3, valid=False)], ["20.00 kN counts"], ["but"]),
        ([entry("micro", 20e3, reached=False)], ["a lower bound", "; limit analysis takes"], ["%"]),
        ([entry("micro", 20e3, valid=False)], ["No peak counts"], ["20.0"]),
    ],
)
def test_the_peak_that_counts(pushover, words, absent):
    said = answer_of_run(summary_of(*pushover))
    assert all(word in said for word in words), said
    assert not any(word in said for word in absent), said


@pytest.mark.parametrize(
    ("macro", "words"),
    [
        (entry("macro", 25e3), "25.00 kN counts (λ = 0.2500, FE of macroblocks), but {why}; limit analysis"),
        (entry("macro", 30e3), "No finite element number counts: 30.00 kN (λ = 0.3000, FE of macroblocks)"),
        (entry("macro", 30e3), "take limit analysis (λ = 0.25000), but {why}."),
        (replace(entry("macro", 30e3), held=True), "(λ = 0.3000, FE of macroblocks), but {why}; as drawn it moves"),
    ],
)
def test_no_number_of_macroblocks_hides_that_their_reference_has_no_curve(macro, words):
    said = answer_of_run(summary_of(macro, failed={"micro": "it broke off"}))
    assert words.format(why="every stone, the reference of macroblocks, has no curve") in said
    assert "reference" not in answer_of_run(summary_of(entry("micro", 25e3), failed={"macro": "it broke off"}))


def test_macroblocks_that_supports_hold_are_no_stones_and_have_no_peak():
    held = replace(entry("macro", 30e3), held=True)
    said = answer_of_run(summary_of(held))
    assert said.endswith("(limit analysis); whether every stone is, --model micro says.")
    assert remarks(summary_of(held)) == [
        "macro FE: held by supports once it has moved: this load does not bring the wall down"
    ]
    stones = answer_of_run(summary_of(replace(entry("micro", 30e3), held=True)))
    assert stones.endswith("(limit analysis).")


@pytest.mark.parametrize(("drawn", "words"), [(0.2427, "bears λ = 0.2427 there"), (0.0, "does not stand there")])
def test_what_a_wall_that_leans_on_new_contacts_bears_without_them(drawn, words):
    found = summary_of(replace(entry("micro", 60e3), at_peak=AtPeak(drawn_contacts=drawn)))
    assert f"with contacts that were not drawn, without which it {words}" in answer_of_run(found)
    assert ("does not stand" in " ".join(remarks(found))) == (drawn == 0.0)


IN_LARGE = {"rigid_peak": 0.199, "large_displacements": 0.199}


@pytest.mark.parametrize(
    ("changed", "displacements", "ending"),
    [
        ({}, "large", "limit analysis (+25.0%) takes the stones as rigid and displacements as small."),
        ({}, "small", "limit analysis (+25.0%) takes the stones as rigid."),
        (
            IN_LARGE,
            "large",
            "limit analysis takes the stones as rigid: +25.0% in small displacements, -0.5% in large ones.",
        ),
        (
            {"rigid_peak": 0.25004, "large_displacements": 0.25004},
            "large",
            "limit analysis takes the stones as rigid: +25.0% in small displacements and in large ones.",
        ),
        (IN_LARGE, "small", "limit analysis (+25.0%) takes the stones as rigid."),
        (
            {"rigid_peak": None, "large_displacements": 0.199},
            "large",
            "limit analysis (+25.0%) takes the stones as rigid and displacements as small.",
        ),
        (
            {"non_associative": 0.199, "converged": False, **IN_LARGE},
            "large",
            "limit analysis in large displacements (-0.5%) takes the stones as rigid.",
        ),
        (
            {"non_associative": 0.199, "converged": False, **IN_LARGE},
            "small",
            "limit analysis in large displacements (-0.5%) takes the stones as rigid, finite elements displacements as "
            "small.",
        ),
        (
            {"converged": False},
            "large",
            "the last load at rest in limit analysis (+25.0%), no collapse state, takes the stones as rigid and "
            "displacements as small.",
        ),
        (
            {"non_associative": None},
            "large",
            "the upper bound of limit analysis (+50.0%) takes the stones as rigid and displacements as small.",
        ),
    ],
)
def test_what_limit_analysis_and_finite_elements_do_not_share_is_said_of_the_case_at_hand(
    changed, displacements, ending
):
    found = summary_of(replace(entry("micro", 20e3), displacements=displacements))
    found = replace(found, limit_analysis=replace(found.limit_analysis, **changed))
    assert answer_of_run(found).endswith(f"; {ending}")


def test_a_peak_far_off_but_among_states_that_limit_analysis_found_is_told_as_another_state():
    """Rubble of 52 stones, finite elements of 0.2 m: 0.4062; loading meets 0.2708, other states reach 0.4060."""
    limit = LimitSummary(0.40867, 0.27081, (0.27081, 0.40597), 1, True, 1e-12, 13e3, 1.0)
    found = replace(summary_of(entry("micro", 40.62e3)), limit_analysis=limit)
    takes = "limit analysis (-33.3%) takes the stones as rigid and displacements as small"
    states = "friction leaves open which state is met, from λ = 0.27081 to 0.40597 were found"
    assert answer_of_run(found).endswith(f"; {takes}; {states}.")
    alike = replace(summary_of(entry("micro", 27.1e3)), limit_analysis=limit)
    assert "friction leaves open" not in answer_of_run(alike)


def test_bonds_that_soften_explain_why_limit_analysis_bears_more():
    found = summary_of(entry("micro", 20e3))
    said = answer_of_run(replace(found, wall=replace(found.wall, bonded=True)))
    taken = "takes the stones as rigid, displacements as small and bonds as plastic, which soften."
    assert said.endswith(f"; limit analysis (+25.0%) {taken}")


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


@pytest.fixture
def recorded(monkeypatch):
    """Stands in for the chain: the folders it was asked to run into."""
    folders = []

    def run(case, output, *_):
        folders.append(output)
        return driver.Outcome(summary_of(), ())

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
    assert cli.main(["run", TOWER, "--output", str(tmp_path), "-q"]) == 0
    assert recorded == [tmp_path]


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
