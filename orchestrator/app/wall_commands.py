"""Commands that take a wall in its plane and go down the chain: check, limit, segment, run. They print."""

from __future__ import annotations

import argparse
import json
import logging
import math
import sys
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console

from orchestrator import storage
from orchestrator.app import case_check, driver, load_case_runs, load_cases
from orchestrator.app.terminal import Reporter, shown
from orchestrator.assessment.seismic.settings import without_verification
from orchestrator.assessment.seismic.verification_record import notes, verdict
from orchestrator.basis.atomic_files import is_locked
from orchestrator.basis.errors import CaseError, ConvergenceError, ResultError
from orchestrator.basis.parallel import is_root, on_root, on_root_while
from orchestrator.loads import DeadLoad
from orchestrator.masonry.joint_warnings import short_contacts
from orchestrator.masonry.sources.drawing import implausible
from orchestrator.present import answer, page, tables
from orchestrator.present.verdict import Answered, sentence
from orchestrator.present.verdict import verdict as verdict_on
from orchestrator.settings.case import Case, RunSettings, as_record

if TYPE_CHECKING:
    from mpi4py import MPI


def check(options: argparse.Namespace, case: Case, _: MPI.Comm | None, console: Console) -> int:
    """Print and draw what a case holds; return the exit code."""
    output = _output(options)
    storage.try_folder(output)
    of_a_run = storage.holds_run(output) or is_locked(output)
    picture = "checked" if of_a_run else "blocks"  # a run's picture is of the wall that it was given
    return case_check.check(case, str(options.case), output / "figures" / picture, console)


def limit(options: argparse.Namespace, case: Case, _: MPI.Comm | None, console: Console) -> int:
    """Find the multipliers of micro limit analysis; return the exit code."""
    output = _output(options)
    if options.settle is not None:
        if options.json:
            raise CaseError("--json", "does not go with --settle", "leave one of them out")
        if not math.isfinite(_settle_angle(options)):
            raise CaseError("--settle-angle", f"{options.settle_angle} is not a number", "give degrees from +x")
        storage.try_folder(output)
        return _settle(options, case, output, console)
    if options.json:
        load_cases.refuse_limit(case)
        analyses = {name: driver.limit(one) for name, one in load_cases.each(case).items()}
        records = {name: asdict(storage.limit_summary(one[1])) for name, one in analyses.items()}
        print(json.dumps(records.get("", records), indent=1))
        return 0
    storage.try_folder(output)
    with storage.held(*_folders(case, output), force=options.force):
        _refuse(case, console)
        with storage.placed(_folders(case, output), _source(options, case), options.force):
            answers, pictures = _limit(case, output, console)
        for picture in pictures:
            console.print(f"mechanism: {picture}", soft_wrap=True)
            if (lowest := picture.with_name("lowest.png")).is_file():
                console.print(f"mechanism of the lowest state found: {lowest}", soft_wrap=True)
        if len(answers) > 1:
            console.print(sentence(verdict_on(case.name, answers)), soft_wrap=True)
    return 0


def _limit(case: Case, output: Path, console: Console) -> tuple[list[Answered], list[Path]]:
    """Analyse and draw every load case; return the answers and their pictures."""
    answers, pictures = [], []
    for name, one in load_cases.each(case).items():
        with Reporter(console):
            assemblage, analysis = driver.limit(one)
        summary = storage.summarise(one.name, assemblage, analysis, None, [])
        about = (name, one.load.direction, one.load.distribution, summary)
        console.print(tables.limit_table(analysis, name))
        for remark in (*analysis.remarks, *short_contacts(assemblage, one.joints), *implausible(assemblage.wall)):
            console.print(remark, soft_wrap=True)
        console.print(answer.answer_of_limit(analysis), soft_wrap=True)
        with shown(console, "pictures", "mechanism"):
            pictures.append(driver.draw_mechanism(one, assemblage, analysis, output / name))
        answers.append(Answered(*about, inclination=one.load.inclination))
    return answers, pictures


def _settle(options: argparse.Namespace, case: Case, output: Path, console: Console) -> int:
    """Let a support give way under every dead load that there is: load cases that share theirs have one answer."""
    angle = _settle_angle(options)
    load_cases.check(case)
    alike: dict[tuple[DeadLoad, ...], list[tuple[str, Case]]] = {}
    for name, one in load_cases.each(case).items():
        alike.setdefault(one.load.dead, []).append((name, one))
    found = [(group, driver.settlement(group[0][1], options.settle, math.radians(angle))) for group in alike.values()]
    for group, (assemblage, state) in found:
        (name, one), *_ = group
        folder = output / name if len(found) > 1 else output
        picture = driver.draw_settlement(one, assemblage, state, math.radians(angle), folder)
        under = f"{', '.join(name for name, _ in group)}: " if len(found) > 1 else ""
        console.print(
            f"{under}support {options.settle} gives way at {angle:g} degrees: "
            f"least reaction {0.0 - state.load_multiplier / 1e3:.4f} kN (associative); mechanism: {picture}",
            soft_wrap=True,
        )
    return 0


def _settle_angle(options: argparse.Namespace) -> float:
    """Return where a support moves to, in degrees from +x: as asked, else downwards."""
    return -90.0 if options.settle_angle is None else options.settle_angle


def segment(options: argparse.Namespace, case: Case, _: MPI.Comm | None, console: Console) -> int:
    """Find the macroblocks; return the exit code."""
    output = _output(options)
    storage.try_folder(output)
    with storage.held(*_folders(case, output), force=options.force):
        _refuse(case, console)
        with storage.placed(_folders(case, output), _source(options, case), options.force):
            drawn = _segment(case, output, console)
        for macroblocks, mechanism in drawn:
            console.print(f"macroblocks: {macroblocks}; mechanism: {mechanism}", soft_wrap=True)
    return 0


def _segment(case: Case, output: Path, console: Console) -> list[tuple[Path, Path]]:
    """Merge the blocks of every load case and draw them; return the pictures."""
    drawn = []
    for name, one in load_cases.each(case).items():
        with Reporter(console):
            segmented = driver.segment(one)
        console.print(tables.limit_table(segmented.analysis, name))
        console.print(tables.bodies_table(segmented.assemblage.wall, segmented.partition, segmented.bodies))
        said = [*short_contacts(segmented.assemblage, one.joints), *implausible(segmented.assemblage.wall)]
        for remark in (*segmented.analysis.remarks, *segmented.partition.remarks, *said):
            console.print(remark, soft_wrap=True)
        console.print(answer.answer_of_limit(segmented.analysis), soft_wrap=True)
        with shown(console, "pictures", "macroblocks and mechanism"):
            drawn.append(driver.draw_macroblocks(one, segmented, output / name))
    return drawn


def run(options: argparse.Namespace, case: Case, comm: MPI.Intracomm | None, console: Console) -> int:
    """Run the whole chain; return the exit code."""
    if options.model:
        case = replace(case, run=RunSettings(("macro", "micro") if options.model == "both" else (options.model,)))
    output, force = _output(options), options.resume or options.force
    on_root(comm, storage.try_folder, output)
    logging.getLogger("orchestrator").propagate = False  # run.log has it
    for remark in without_verification(case.seismic):
        console.print(remark, soft_wrap=True)
    if case.load.several:
        return _run_load_cases(options, case, output, comm, console)
    with (
        on_root_while(comm, storage.held(output, force=force, run_of=(case.file, case.block_file))),
        Reporter(console) as report,
    ):
        outcome = driver.run(case, output, options.resume, comm, report)
    assert outcome.summary is not None, "a run without any curve raises"
    console.print(tables.run_table(outcome.summary))
    for remark in storage.remarks(outcome.summary):
        console.print(remark, soft_wrap=True)
    for why in (outcome.summary.failed or {}).values():
        console.print(f"NO CURVE: {why}", soft_wrap=True)
    for reason in storage.reasons(outcome.summary.pushover):
        console.print(f"NOT VALID: {reason}", soft_wrap=True)
    console.print(answer.answer_of_run(outcome.summary), soft_wrap=True)
    _print_verification(outcome.summary, console)
    if outcome.summary.seismic is not None:
        console.print(sentence(page.verdict_of(case, outcome.summary)), soft_wrap=True)
    written = (
        f"report: {output / 'report.html'}; pictures: {output / 'figures'}; all figures: {output / 'summary.json'}"
    )
    console.print(written, soft_wrap=True)
    _complain(comm, outcome.complaints)
    return _exit_code(outcome.complaints, [outcome.summary])


def _run_load_cases(
    options: argparse.Namespace, case: Case, output: Path, comm: MPI.Intracomm | None, console: Console
) -> int:
    with Reporter(console) as report:
        outcome = load_case_runs.run(case, output, options.resume, comm, report, options.force)
    if outcome is None:
        return 0
    console.print(tables.load_cases_table(case.name, outcome.rows))
    for one in outcome.done:
        if one.summary is not None:
            _print_verification(one.summary, console, one.summary.case)
    console.print(tables.verdict_table(outcome.verdict))
    console.print(sentence(outcome.verdict), soft_wrap=True)
    said = (("reports of all load cases", "report.html"), ("table", "load_cases.csv"), ("verdict", "verdict.csv"))
    console.print("; ".join(f"{what}: {output / name}" for what, name in said), soft_wrap=True)
    _complain(comm, outcome.complaints)
    return _exit_code(outcome.complaints, [one.summary for one in outcome.done if one.summary is not None])


def _print_verification(summary: storage.Summary, console: Console, load_case: str = "") -> None:
    """Print table, control point and notes of the seismic verification, where there is one."""
    record = summary.seismic
    if record is None:
        return
    console.print(tables.seismic_table(record, load_case))
    console.print(f"{verdict(record)}. Control point of N2: {record['control_point']}", soft_wrap=True)
    for number, text in enumerate(notes(record), 1):
        console.print(f"({number}) {text}", soft_wrap=True)


def _exit_code(complaints: Sequence[ConvergenceError | ResultError], summaries: Sequence[storage.Summary]) -> int:
    """Return 1 if a pushover stopped early, else 3 if one is not valid or a run has none that counts, else 0."""
    none_counts = 0 if all(map(storage.counts, summaries)) else 3
    return min((1 if isinstance(complaint, ConvergenceError) else 3 for complaint in complaints), default=none_counts)


def _refuse(case: Case, console: Console) -> None:
    """Refuse whatever limit analysis refuses of any load case (CaseError), before a folder is made."""
    with shown(console, "load cases", "the wall, and whether it stands under each of them"):
        load_cases.refuse_limit(case)


def _source(options: argparse.Namespace, case: Case) -> storage.Source:
    """Return what results of a command are of."""
    settings = as_record(case, str(case.block_file))
    return storage.Source(options.command, settings, (case.file, case.block_file))


def _folders(case: Case, output: Path) -> tuple[Path, ...]:
    """Return the folders that limit and segment write into."""
    return tuple(dict.fromkeys([output, *(output / name for name in load_cases.each(case))]))


def _output(options: argparse.Namespace) -> Path:
    return options.output or Path("results") / options.case.stem


def _complain(comm: MPI.Comm | None, complaints: Sequence[object]) -> None:
    if is_root(comm):
        for complaint in complaints:
            print(complaint, file=sys.stderr)


ACTIONS = {None: run, "check": check, "limit": limit, "segment": segment, "run": run}
"""by command; none: the shipped benchmark 1"""
