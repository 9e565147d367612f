"""Command line: arguments -> driver; known errors -> one line and an exit code. Prints, with
file_commands.py and study_commands.py alone.

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
from dataclasses import asdict, replace
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console

from orchestrator import storage
from orchestrator.app import case_check, driver, file_commands, load_case_runs, space_commands, study_commands
from orchestrator.app.terminal import Reporter
from orchestrator.assessment.seismic.verification_record import notes, verdict
from orchestrator.basis.errors import CaseError, ConvergenceError, ResultError
from orchestrator.basis.installed import refuse_missing
from orchestrator.basis.parallel import Ending, all_ranks, is_root, on_root, started_as_rank
from orchestrator.present import answer, page, tables
from orchestrator.present.verdict import Answered, sentence
from orchestrator.present.verdict import verdict as verdict_on
from orchestrator.settings import case as cases
from orchestrator.settings.space_case import refuse_space, spatial

if TYPE_CHECKING:
    from mpi4py import MPI

PACKAGE = Path(__file__).resolve().parents[1]
SHIPPED = PACKAGE / "shipped" if (PACKAGE / "shipped").exists() else PACKAGE.parent
"""folder of templates/ and meshes/: within a wheel (setup.py), or a clone"""
DEFAULT_CASE = SHIPPED / "templates" / "benchmark1.toml"
MODELS: dict[str, tuple[cases.ModelName, ...]] = {"macro": ("macro",), "micro": ("micro",), "both": ("macro", "micro")}


def main(arguments: list[str] | None = None) -> int:
    """Run one command and return its exit code."""
    options = _parser().parse_args(arguments)
    parallel = options.action in (_benchmark1, _run, *study_commands.ACTIONS)
    if not parallel and started_as_rank() > 0:
        return 0  # rank 0 does it alone
    comm = all_ranks() if parallel else None
    quiet = not is_root(comm) or getattr(options, "quiet", False)
    several = comm is not None and comm.size > 1  # mpirun hands rank 0 a terminal that is none
    console = Console(quiet=quiet, highlight=False, force_terminal=False if several else None)
    ending = Ending(comm)
    try:
        if options.action in (_run, _segment, *study_commands.ACTIONS):
            refuse_space(options.case, options.set, options.command)
        if parallel and options.action is not study_commands.sensitivity:
            refuse_missing(options.command or "run")
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
        remedies = {_run: "; go on with --resume"} | dict.fromkeys(study_commands.ACTIONS, "; the same command goes on")
        remedy = remedies.get(options.action, "")
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
        description="Pushover analysis of masonry, stone by stone. Without a command: run the shipped benchmark 1"
        " into results/benchmark1, anew.",
        epilog=file_commands.epilog("run templates/benchmark1.toml --output results/benchmark1"),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    about = "print what completes commands (docs/runs.md)"
    parser.add_argument("--print-completion", choices=("bash", "zsh"), action=_Completion, help=about)
    parser.add_argument("--version", action="version", version=f"orchestrator {version('orchestrator')}")
    parser.set_defaults(
        action=_benchmark1, command=None, case=DEFAULT_CASE, output=None, resume=False, force=True, model=None, set=[]
    )
    commands = parser.add_subparsers(dest="command", metavar="COMMAND")
    run = _command(
        commands, "run", _run, "the whole chain: micro-LA, macroblocks, FE pushover, pictures", "--set mesh.size=100mm"
    )
    run.add_argument("--output", type=Path, help="run folder (default: results/NAME OF THE CASE FILE)")
    run.add_argument("--resume", action="store_true", help="go on after the last stored increment")
    run.add_argument("--force", action="store_true", help="overwrite the results of an earlier run")
    run.add_argument("--model", choices=tuple(MODELS), help="instead of the case file's [run] models")
    run.add_argument("-q", "--quiet", action="store_true", help="print nothing but errors")
    check = _command(
        commands,
        "check",
        _check,
        "what a case holds: loads, materials, joints, what is unusual, whether it stands; a picture with block numbers",
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
    example = "--set macroblocks.centre_distance=300mm"
    segment = _command(commands, "segment", _segment, "stop after the macroblocks", example)
    segment.add_argument("--output", type=Path, help="folder of the pictures (default: results/NAME OF THE CASE FILE)")
    file_commands.add_commands(commands)
    study_commands.add_commands(commands, _command)
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
    if spatial(options.case, options.set):
        output = options.output or Path("results") / options.case.stem
        return space_commands.check(options.case, options.set, output, console)
    case, output = cases.read(options.case, options.set), options.output or Path("results") / options.case.stem
    storage.try_folder(output)
    return case_check.check(case, str(options.case), output / "figures", console)


def _limit(options: argparse.Namespace, _: None, console: Console) -> int:
    output = options.output or Path("results") / options.case.stem
    if options.settle is None and spatial(options.case, options.set):
        return space_commands.limit(options.case, options.set, output, options.json, console)
    case = cases.read(options.case, options.set)
    if options.settle is not None:
        if not math.isfinite(options.settle_angle):
            raise CaseError("--settle-angle", f"{options.settle_angle} is not a number", "give degrees from +x")
        return _settle(options, case, output, console)
    if options.json:
        found = {name: driver.limit(one) for name, one in load_case_runs.each(case).items()}
        records = {name: asdict(storage.limit_summary(one[1])) for name, one in found.items()}
        print(json.dumps(records.get("", records), indent=1))
        return 0
    storage.try_folder(output)
    answers = []
    for name, one in load_case_runs.each(case).items():
        with Reporter(console):
            assemblage, analysis = driver.limit(one)
        summary = storage.summary(one.name, assemblage, analysis, None, [])
        answers.append(Answered(name, one.load.direction, one.load.distribution, summary))
        console.print(tables.limit_table(analysis, name))
        for remark in analysis.remarks:
            console.print(remark, soft_wrap=True)
        console.print(answer.answer_of_limit(analysis), soft_wrap=True, markup=False)
        picture = driver.draw_mechanism(one, assemblage, analysis, output / name)
        console.print(f"mechanism: {picture}", soft_wrap=True)
    if len(answers) > 1:
        console.print(sentence(verdict_on(case.name, answers)), soft_wrap=True, markup=False)
    return 0


def _settle(options: argparse.Namespace, case: cases.Case, output: Path, console: Console) -> int:
    state, picture = driver.settlement(case, options.settle, math.radians(options.settle_angle), output)
    console.print(
        f"support {options.settle} gives way at {options.settle_angle:g} degrees: "
        f"least reaction {-state.load_multiplier / 1e3:.4f} kN (associative); mechanism: {picture}",
        soft_wrap=True,
    )
    return 0


def _segment(options: argparse.Namespace, _: None, console: Console) -> int:
    case = cases.read(options.case, options.set)
    output = options.output or Path("results") / options.case.stem
    storage.try_folder(output)
    for name, one in load_case_runs.each(case).items():
        with Reporter(console):
            segmented = driver.segment(one)
        console.print(tables.limit_table(segmented.analysis, name))
        console.print(tables.bodies_table(segmented.assemblage.wall, segmented.partition, segmented.bodies))
        for remark in (*segmented.analysis.remarks, *segmented.partition.remarks):
            console.print(remark, soft_wrap=True)
        console.print(answer.answer_of_limit(segmented.analysis), soft_wrap=True, markup=False)
        pictures = driver.draw_macroblocks(one, segmented, output / name)
        console.print(f"macroblocks: {pictures[0]}; mechanism: {pictures[1]}", soft_wrap=True)
    return 0


def _benchmark1(options: argparse.Namespace, comm: MPI.Intracomm | None, console: Console) -> int:
    """Run the shipped benchmark 1, and say so first: nobody asked for it by name."""
    console.print(
        "No command given: this runs the shipped benchmark 1 into results/benchmark1. --help lists all commands."
    )
    return _run(options, comm, console)


def _run(options: argparse.Namespace, comm: MPI.Intracomm | None, console: Console) -> int:
    case = on_root(comm, cases.read, options.case, options.set)
    if options.model:
        case = replace(case, run=cases.RunSettings(MODELS[options.model]))
    output = options.output or Path("results") / options.case.stem
    on_root(comm, storage.try_folder, output)
    if not (options.resume or options.force):
        on_root(comm, storage.refuse_overwriting_run, output)
    logging.getLogger("orchestrator").propagate = False  # run.log has it
    if case.load.cases:
        return _run_load_cases(options, case, output, comm, console)
    with Reporter(console) as report:
        outcome = driver.run(case, output, options.resume, comm, report)
    assert outcome.summary is not None, "a run without any curve raises"
    console.print(tables.run_table(outcome.summary))
    for remark in storage.remarks(outcome.summary):
        console.print(remark, soft_wrap=True, markup=False)
    for reason in storage.reasons(outcome.summary.pushover):
        console.print(f"NOT VALID: {reason}", soft_wrap=True)
    console.print(answer.answer_of_run(outcome.summary), soft_wrap=True, markup=False)
    _print_verification(outcome.summary, console)
    if outcome.summary.seismic is not None:
        console.print(sentence(page.verdict_of(case, outcome.summary)), soft_wrap=True, markup=False)
    written = (
        f"report: {output / 'report.html'}; pictures: {output / 'figures'}; all figures: {output / 'summary.json'}"
    )
    console.print(written, soft_wrap=True)
    _complain(comm, outcome.complaints)
    return _exit_code(outcome.complaints)


def _run_load_cases(
    options: argparse.Namespace, case: cases.Case, output: Path, comm: MPI.Intracomm | None, console: Console
) -> int:
    with Reporter(console) as report:
        outcome = load_case_runs.run(case, output, options.resume, comm, report)
    if outcome is None:
        return 0
    console.print(tables.load_cases_table(case.name, outcome.rows))
    for one in outcome.done:
        if one.summary is not None:
            _print_verification(one.summary, console, one.summary.case)
    console.print(tables.verdict_table(outcome.verdict))
    console.print(sentence(outcome.verdict), soft_wrap=True, markup=False)
    said = (("reports of all load cases", "report.html"), ("table", "load_cases.csv"), ("verdict", "verdict.csv"))
    console.print("; ".join(f"{what}: {output / name}" for what, name in said), soft_wrap=True)
    _complain(comm, outcome.complaints)
    return _exit_code(outcome.complaints)


def _print_verification(summary: storage.Summary, console: Console, load_case: str = "") -> None:
    """Print table, control point and notes of the seismic verification, where there is one."""
    record = summary.seismic
    if record is None:
        return
    console.print(tables.seismic_table(record, load_case))
    console.print(f"{verdict(record)}. Control point of N2: {record['control_point']}", soft_wrap=True)
    for number, text in enumerate(notes(record), 1):
        console.print(f"({number}) {text}", soft_wrap=True, markup=False)


def _exit_code(complaints: Sequence[ConvergenceError | ResultError]) -> int:
    """Return 1 if a pushover stopped early, else 3 if one is not valid, else 0."""
    return min((1 if isinstance(complaint, ConvergenceError) else 3 for complaint in complaints), default=0)
