"""Command line: arguments -> driver; known errors -> one line and an exit code. Prints, with file_commands.py alone.

Exit codes: 0 done, 1 failed while running, 2 bad input, 3 finished but not valid, 130 interrupted.
"""

from __future__ import annotations

import argparse
import json
import logging
import math
import sys
import traceback
from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table

from orchestrator import case as cases
from orchestrator import driver, file_commands, plots, results, study_runs
from orchestrator.errors import CaseError, ConvergenceError, ResultError
from orchestrator.limit_analysis import LimitAnalysis, LimitState
from orchestrator.masonry.drawing import implausible
from orchestrator.parallel import Ending, all_ranks, is_root, on_root, started_as_rank

if TYPE_CHECKING:
    from mpi4py import MPI

ROOT = Path(__file__).resolve().parent.parent
DEFAULT_CASE = ROOT / "templates" / "benchmark1.toml"
MODELS: dict[str, tuple[cases.ModelName, ...]] = {"macro": ("macro",), "micro": ("micro",), "both": ("macro", "micro")}


def main(arguments: list[str] | None = None) -> int:
    """Run one command and return its exit code."""
    options = _parser().parse_args(arguments)
    parallel = options.action in (_run, _study)
    if not parallel and started_as_rank() > 0:
        return 0  # rank 0 does it alone
    comm = all_ranks() if parallel else None
    quiet = not is_root(comm) or getattr(options, "quiet", False)
    several = comm is not None and comm.size > 1  # mpirun hands rank 0 a terminal that is none
    console = Console(quiet=quiet, highlight=False, force_terminal=False if several else None)
    ending = Ending(comm)
    try:
        return ending.together(int(options.action(options, comm, console)), "")
    except CaseError as error:
        return ending.together(2, str(error))
    except ResultError as error:
        return ending.together(3, str(error))
    except ConvergenceError as error:
        return ending.together(1, _one_line(str(error)))
    except OSError as error:
        return ending.together(1, _one_line(f"{error.filename or 'file system'}: {error.strerror or error}"))
    except KeyboardInterrupt:
        remedy = {_run: "; go on with --resume", _study: "; the same command goes on"}.get(options.action, "")
        return ending.together(130, f"interrupted{remedy}")
    except Exception:  # an error of the program
        return ending.together(1, traceback.format_exc())


def _one_line(text: str) -> str:
    """Return a text without line breaks: PETSc's errors have many, names of files may have some."""
    return " ".join(text.split("\n"))


def _complain(comm: MPI.Comm | None, complaints: Sequence[object]) -> None:
    if is_root(comm):
        for complaint in complaints:
            print(complaint, file=sys.stderr)


class _Completion(argparse.Action):
    """Prints the completion of the command `orchestrator` for a shell."""

    def __call__(self, parser: argparse.ArgumentParser, _: object, values: Any, __: str | None = None) -> None:
        import shtab

        parser.prog = "orchestrator"  # what is completed is a command, not `python -m`
        print(shtab.complete(parser, values))
        parser.exit(0)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m orchestrator",
        description="Pushover analysis of masonry, stone by stone. Without a command: run the shipped benchmark 1.",
        epilog=file_commands.epilog("run templates/benchmark1.toml --output results/benchmark1"),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--print-completion", choices=("bash", "zsh"), action=_Completion, help="print what completes commands (README)"
    )
    parser.add_argument("--version", action="version", version=f"orchestrator {version('orchestrator')}")
    parser.set_defaults(action=_run, command=None, case=DEFAULT_CASE, output=None, resume=False, model=None, set=[])
    commands = parser.add_subparsers(dest="command", metavar="COMMAND")
    run = _command(
        commands, "run", _run, "the whole chain: micro-LA, macroblocks, FE pushover, pictures", "--set mesh.size=100mm"
    )
    run.add_argument("--output", type=Path, help="run folder (default: results/NAME OF THE CASE FILE)")
    run.add_argument("--resume", action="store_true", help="go on after the last stored increment")
    run.add_argument("--model", choices=tuple(MODELS), help="instead of the case file's [run] models")
    run.add_argument("-q", "--quiet", action="store_true", help="print nothing but errors")
    check = _command(
        commands,
        "check",
        _check,
        "read, validate and draw the wall with block numbers, nothing else",
        "--output results/look",
    )
    check.add_argument(
        "--output", type=Path, help="run folder for the picture (default: results/NAME OF THE CASE FILE)"
    )
    limit = _command(commands, "limit", _limit, "stop after micro limit analysis", "--set wall.friction=0.7")
    limit.add_argument("--output", type=Path, help="folder of the picture (default: results/NAME OF THE CASE FILE)")
    limit.add_argument("--settle", type=int, metavar="ID", help="instead of the live load, let this support give way")
    limit.add_argument("--settle-angle", type=float, default=-90.0, help="degrees from +x (default: -90, downwards)")
    limit.add_argument("--json", action="store_true", help="print the limit_analysis part of the summary, nothing else")
    _command(commands, "segment", _segment, "stop after the macroblocks", "--set macroblocks.centre_distance=300mm")
    file_commands.add_commands(commands)
    study = _command(
        commands,
        "study",
        _study,
        "pushover of a grid of macroblock tolerances, and of every stone",
        "--output results/table1",
    )
    study.add_argument("--output", type=Path, help="folder (default: results/NAME OF THE CASE FILE-study)")
    return parser


def _command(
    commands: Any, name: str, action: Callable[..., int], summary: str, example: str
) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = commands.add_parser(
        name,
        help=summary,
        description=summary,
        epilog=file_commands.epilog(f"{name} templates/benchmark1.toml {example}"),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("case", type=Path, metavar="CASE", help="case file (.toml) or block file (.json)")
    parser.add_argument("--set", action="append", default=[], metavar="SECTION.KEY=VALUE", help="override one setting")
    parser.set_defaults(action=action)
    return parser


def _check(options: argparse.Namespace, _: None, console: Console) -> int:
    assemblage = driver.check(cases.read(options.case, options.set))
    figures = (options.output or Path("results") / options.case.stem) / "figures"
    picture, *_rest = plots.save(plots.blocks(assemblage.wall, numbered=True), figures, "blocks")
    for warning in implausible(assemblage.wall):
        console.print(f"{options.case}: {warning}", soft_wrap=True)
    free = sum(not block.fixed for block in assemblage.wall.blocks)
    console.print(
        f"{options.case}: {free} blocks, {len(assemblage.block_i)} joints, nothing to complain about; {picture}",
        soft_wrap=True,
    )
    return 0


def _limit(options: argparse.Namespace, _: None, console: Console) -> int:
    case = cases.read(options.case, options.set)
    output = options.output or Path("results") / options.case.stem
    if options.settle is not None:
        if not math.isfinite(options.settle_angle):
            raise CaseError("--settle-angle", f"{options.settle_angle} is not a number", "give degrees from +x")
        return _settle(options, case, output, console)
    assemblage, analysis = driver.limit(case)
    if options.json:
        summary = results.summary("", assemblage, analysis, None, [])
        print(json.dumps(summary["limit_analysis"], indent=1))
        return 0
    console.print(_limit_table(analysis))
    for remark in analysis.remarks:
        console.print(remark, soft_wrap=True)
    console.print(f"mechanism: {driver.draw_mechanism(case, assemblage, analysis, output)}", soft_wrap=True)
    return 0


def _settle(options: argparse.Namespace, case: cases.Case, output: Path, console: Console) -> int:
    state, picture = driver.settlement(case, options.settle, math.radians(options.settle_angle), output)
    console.print(
        f"support {options.settle} gives way at {options.settle_angle:g} degrees: "
        f"least reaction {-state.load_multiplier / 1e3:.4f} kN (associative); mechanism: {picture}",
        soft_wrap=True,
    )
    return 0


def _limit_table(analysis: LimitAnalysis) -> Table:
    table = Table(
        box=SIMPLE_HEAD,
        padding=0,
        title=f"Micro limit analysis, weight {analysis.weight / 1e3:.3f} kN, {analysis.seconds:.2f} s",
    )
    columns = (
        "",
        "multiplier",
        "base shear\nkN",
        "tilt\ndeg",
        "LPs",
        "time\ns",
        "residuals:\nequilibrium",
        "\nyield",
        "\npower",
    )
    for column in columns:
        table.add_column(column, justify="right" if column else "left", no_wrap=True)
    names = {
        "associative": analysis.associative,
        "sequence": analysis.sequence,
        "dilation shift": analysis.dilation_shift,
        "complementarity": analysis.complementarity,
        "lowest found": analysis.lowest,
    }
    for name, state in names.items():
        table.add_row(name, *(_limit_row(state, analysis) if state else ["none"]))
    return table


def _limit_row(state: LimitState, analysis: LimitAnalysis) -> list[str]:
    seconds = sum(record.seconds for record in state.records)
    residuals = (state.equilibrium_residual, state.yield_residual, state.power_residual)
    shear = state.load_multiplier * analysis.horizontal_load / 1e3
    angle = analysis.tilt_angle(state)
    tilt = "" if angle is None else f"{math.degrees(angle):.3f}"
    found = [f"{state.load_multiplier:.5f}", f"{shear:.4f}", tilt, str(len(state.records)), f"{seconds:.2f}"]
    return found + [f"{residual:.0e}" for residual in residuals]


def _segment(options: argparse.Namespace, _: None, console: Console) -> int:
    segmented = driver.segment(cases.read(options.case, options.set))
    console.print(_limit_table(segmented.analysis))
    table = Table(
        box=SIMPLE_HEAD,
        padding=0,
        title=f"{segmented.partition.count} macroblocks, {len(segmented.bodies.joint)} joints between them",
    )
    for column in ("body", "blocks", "area m2"):
        table.add_column(column, justify="right")
    for body in segmented.bodies.bodies[: segmented.bodies.moving]:
        table.add_row(str(body.number), str(len(body.blocks)), f"{body.area:.4f}")
    console.print(table)
    for remark in (*segmented.analysis.remarks, *segmented.partition.remarks):
        console.print(remark, soft_wrap=True)
    return 0


def _run(options: argparse.Namespace, comm: MPI.Comm | None, console: Console) -> int:
    case = on_root(comm, cases.read, options.case, options.set)
    if options.model:
        case = replace(case, run=cases.RunSettings(MODELS[options.model]))
    output = options.output or Path("results") / options.case.stem
    logging.getLogger("orchestrator").propagate = False  # run.log has it
    with _Reporter(console) as report:
        outcome = driver.run(case, output, options.resume, comm, report)
    console.print(_table(outcome.summary))
    for reason in results.reasons(outcome.summary["pushover"]):
        console.print(f"NOT VALID: {reason}", soft_wrap=True)
    if "seismic" in outcome.summary:
        console.print(_seismic_table(outcome.summary["seismic"]))
    written = (
        f"report: {output / 'report.html'}; pictures: {output / 'figures'}; all figures: {output / 'summary.json'}"
    )
    console.print(written, soft_wrap=True)
    _complain(comm, outcome.complaints)
    failed = [1 if isinstance(complaint, ConvergenceError) else 3 for complaint in outcome.complaints]
    return min(failed, default=0)


def _study(options: argparse.Namespace, comm: MPI.Intracomm | None, console: Console) -> int:
    case = on_root(comm, cases.read, options.case, options.set)
    output = options.output or Path("results") / f"{options.case.stem}-study"
    logging.getLogger("orchestrator").propagate = False
    with _Reporter(console) as report:
        outcome = study_runs.study(case, output, comm, report)
    if outcome is None:
        return 0
    console.print(_study_table(case.name, outcome.rows))
    console.print(f"table: {output / 'table.csv'}; pictures: {output / 'figures'}", soft_wrap=True)
    _complain(comm, outcome.complaints)
    return 3 if outcome.complaints else 0


def _study_table(name: str, rows: Sequence[dict[str, Any]]) -> Table:
    """Return the table of a study; the last row is micro-FE, to which ratios refer."""
    table = Table(box=SIMPLE_HEAD, padding=0, title=f"{name}: peak, stiffness and time as parts of micro-FE's")
    columns = (
        "tol_n", "tol_D\nmm", "bodies", "joints", "peak\nmultiplier", "of\nmicro", "stiffness\nkN/mm", "of\nmicro",
        "time\ns", "of\nmicro",
    )  # fmt: skip
    for column in columns:
        table.add_column(column, justify="right", no_wrap=True)
    for row in rows:
        distance = row["tol_D_m"]
        figures = (
            ("peak_multiplier", ".4f", 1.0), ("peak_over_micro", ".3f", 1.0),
            ("initial_stiffness_N_per_m", ".2f", 1e-6), ("stiffness_over_micro", ".2f", 1.0),
            ("seconds", ".1f", 1.0), ("seconds_over_micro", ".2f", 1.0),
        )  # fmt: skip
        table.add_row(
            str(row["tol_n"]),
            distance if isinstance(distance, str) else f"{1e3 * distance:g}",
            str(row["bodies"]) + ", NOT VALID" * (row["valid"] is False),
            str(row["joints"]),
            *(format(row[key] * factor, form) if row[key] != "" else "" for key, form, factor in figures),
        )
    return table


class _Reporter:
    """Draws what the driver reports: a bar per pushover on a terminal, now and then a line elsewhere."""

    def __init__(self, console: Console) -> None:
        columns = (
            TextColumn("{task.description}"), BarColumn(bar_width=10), TextColumn("{task.fields[state]}"),
            TimeElapsedColumn(), TimeRemainingColumn(),
        )  # fmt: skip
        self._console = console
        self._progress = Progress(*columns, console=console, transient=True, disable=not console.is_terminal)
        self._tasks: dict[str, TaskID] = {}
        self._last_line = 0.0

    def __enter__(self) -> _Reporter:
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()

    def __call__(self, event: driver.StageDone | driver.IncrementDone) -> None:
        if isinstance(event, driver.StageDone):
            self._console.print(f"{event.stage}: {event.text} ({event.seconds:.1f} s)", soft_wrap=True)
            self._last_line = 0.0
        else:
            self._show(event)

    def _show(self, event: driver.IncrementDone) -> None:
        increment = event.increment
        state = (
            f"{increment.number} {increment.phase}: λ {increment.load_multiplier:.4f}, "
            f"{1e3 * increment.control_displacement:.2f} mm, {increment.iterations} it."
        )
        if event.model not in self._tasks:
            self._tasks[event.model] = self._progress.add_task(f"{event.model} FE", total=1.0, state="")
        self._progress.update(self._tasks[event.model], completed=event.fraction, state=state)
        if not self._console.is_terminal and event.seconds - self._last_line > 5.0:
            self._console.print(f"{event.model} FE: {state}, {event.seconds:.0f} s", soft_wrap=True)
            self._last_line = event.seconds


def _table(summary: dict[str, Any]) -> Table:
    """Return the short table at the end of a run."""
    title = [f"{summary['case']}: weight {summary['wall']['weight'] / 1e3:.3f} kN"]
    kinematics = dict.fromkeys(pushover["displacements"] for pushover in summary["pushover"])
    table = Table(box=SIMPLE_HEAD, padding=0, title=", ".join([*title, *(f"{k} displacements" for k in kinematics)]))
    columns = ("", "bodies", "peak\nmultiplier", "base shear\nkN", "at\nmm", "stiffness\nkN/mm", "time\ns")
    for column in columns:
        table.add_column(column, justify="right" if column else "left", no_wrap=True)
    limit = summary["limit_analysis"]
    horizontal_load = limit["base_shear"] / (limit["non_associative"] or limit["associative"])
    rows = {"associative": limit["associative"], "non-assoc.": limit["non_associative"]}
    for rule, multiplier in rows.items():
        found = (
            [f"{multiplier:.4f}", f"{multiplier * horizontal_load / 1e3:.4f}"]
            if multiplier is not None
            else ["none found", ""]
        )
        seconds = f"{limit['seconds']:.1f}" if rule == "associative" else ""
        table.add_row(f"micro-LA {rule}", str(summary["wall"]["blocks"]), *found, "", "", seconds)
    for pushover in summary["pushover"]:
        table.add_row(*_pushover_row(pushover))
    return table


def _seismic_table(record: dict[str, Any]) -> Table:
    """Return the seismic verification: demand, capacity, capacity in terms of ag and safety ratio of each approach."""
    ground = record["spectrum"]["ag_m_per_s2"]
    table = Table(box=SIMPLE_HEAD, padding=0, title=f"Seismic verification, ag {ground:.3g} m/s2")
    for column in ("", "demand", "capacity", "capacity ag\nm/s2", "safety\nratio"):
        table.add_column(column, justify="right" if column else "left", no_wrap=True)
    for row in record["pushover"]:
        name = f"N2, {row['model']} FE"
        if "safety_ratio" not in row:
            table.add_row(name, "none")
            continue
        lengths = (f"{1e3 * row['demand_m']:.3g} mm", f"{1e3 * row['capacity_m']:.3g} mm")
        table.add_row(name, *lengths, f"{row['capacity_ag_m_per_s2']:.3f}", f"{row['safety_ratio']:.2f}")
    kinematic, linear, turning = record["kinematic"], record["kinematic"]["linear"], record["kinematic"]["nonlinear"]
    table.add_row(
        "kinematic, linear", f"{linear['demand_m_per_s2']:.3g} m/s2", f"{kinematic['a0_star_m_per_s2']:.3g} m/s2",
        f"{linear['capacity_ag_m_per_s2']:.3f}", f"{linear['safety_ratio']:.2f}",
    )  # fmt: skip
    if turning:
        table.add_row(
            "kinematic, non-linear", f"{1e3 * turning['demand_m']:.3g} mm", f"{1e3 * turning['du_star_m']:.3g} mm",
            f"{turning['capacity_ag_m_per_s2']:.3f}", f"{turning['safety_ratio']:.2f}",
        )  # fmt: skip
    return table


def _pushover_row(pushover: dict[str, Any]) -> list[str]:
    return [
        {"macro": "macroblock FE", "micro": "micro-FE"}[pushover["model"]] + ", NOT VALID" * (not pushover["valid"]),
        str(pushover["bodies"]),
        f"{pushover['peak_multiplier']:.4f}",
        f"{pushover['peak_base_shear'] / 1e3:.4f}",
        f"{1e3 * pushover['displacement_at_peak']:.2f}",
        f"{pushover['initial_stiffness'] / 1e6:.3f}",
        f"{pushover['seconds']['total']:.1f}",
    ]
