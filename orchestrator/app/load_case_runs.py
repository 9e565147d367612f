"""Several load cases of one wall: each a run of its own in a folder of its name; table, picture and index page of all.

Under MPI the load cases are spread over ranks 1 and up, unless one of them is so large that all ranks share it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING, Any

from orchestrator import storage
from orchestrator.app import driver, load_cases, pushover_run
from orchestrator.app.driver import Outcome
from orchestrator.app.progress import IncrementDone, Report, StageBegun, StageDone
from orchestrator.basis.errors import CaseError, ConvergenceError, ResultError, resumable
from orchestrator.basis.parallel import on_root, on_root_while, workers
from orchestrator.macroblocks.bodies import make_bodies
from orchestrator.macroblocks.criteria import one_body_per_block
from orchestrator.masonry.joints import Assemblage
from orchestrator.present import page, plots
from orchestrator.present.report import as_run
from orchestrator.present.verdict import Answered, Verdict, verdict
from orchestrator.pushover.estimate import estimate
from orchestrator.settings.case import Case, refuse_verification
from orchestrator.settings.project import ProjectSettings
from orchestrator.storage.files import missing
from orchestrator.storage.stored_run import read_checked, telling_damage

if TYPE_CHECKING:
    from mpi4py import MPI

COLUMNS = (
    "load_case", "direction", "inclination_deg", "distribution", "weight_N", "vertical_load_N", "horizontal_load_N",
    "model", "bodies", "associative", "non_associative", "kind", "limit_base_shear_N", "peak_multiplier",
    "peak_base_shear_N", "displacement_at_peak_m", "initial_stiffness_N_per_m", "peak_reached", "valid",
    "stopped_because", "complaint",
)  # fmt: skip
INDEX = "load_cases.json"


@dataclass(frozen=True, eq=False, slots=True)
class LoadCaseRun:
    """One load case: its name, the case that runs it alone, and its folder."""

    name: str
    case: Case
    folder: Path
    resume: bool


@dataclass(frozen=True, eq=False, slots=True)
class LoadCasesOutcome:
    """What all load cases leave: their rows of the table, the verdict on them, their outcomes, and their complaints,
    named after them."""

    rows: tuple[dict[str, Any], ...]
    verdict: Verdict
    done: tuple[Outcome, ...]
    complaints: tuple[ConvergenceError | ResultError, ...]


def run(
    case: Case, output: Path, resume: bool, comm: MPI.Intracomm | None, report: Report, force: bool = True
) -> LoadCasesOutcome | None:
    """Run every load case into its folder in `output`; None on ranks that have worked for others.

    With `resume` finished load cases stay as they are; with `force` results of an earlier run are removed, with neither
    it is refused. Raises CaseError before anything is written.
    """
    runs = [LoadCaseRun(name, one, output / name, resume) for name, one in load_cases.each(case).items()]
    folders = (output, *(one.folder for one in runs))
    with on_root_while(comm, storage.held(*folders, force=resume or force, run_of=(case.file, case.block_file))):
        assemblage = on_root(comm, load_cases.refuse_run, case)
        on_root(comm, load_cases.refuse_folders, case, output, resume)
        if comm is not None and comm.size > 1:
            pushover_run.start_finite_elements()
            if not _is_large(case, assemblage):
                return _spread(case, runs, output, resume, comm, report)
        with resumable():
            on_root(comm, _begin, case, output, resume)
            done = [compute(one, comm, _named(report, one.name)) for one in runs]
            report(StageBegun("report", "all load cases"))
            return on_root(comm, _collected, case, runs, done, output)


def _begin(case: Case, output: Path, resume: bool) -> None:
    """Remove the results of an earlier run from the folder, which is held, unless it is gone on with."""
    if not resume:
        storage.clear(output, (case.file, case.block_file))


def _spread(
    case: Case, runs: list[LoadCaseRun], output: Path, resume: bool, comm: MPI.Intracomm, report: Report
) -> LoadCasesOutcome | None:
    with workers(comm) as spread, resumable():
        if spread is None:
            return None
        _begin(case, output, resume)
        outcomes: dict[str, Outcome] = {}
        for name, outcome in spread(_compute_alone, runs):
            outcomes[name] = outcome
            report(StageDone(f"{len(outcomes)} of {len(runs)}", _seconds(outcome), name))
        report(StageBegun("report", "all load cases"))
        return _collected(case, runs, [outcomes[one.name] for one in runs], output)


def _is_large(case: Case, assemblage: Assemblage) -> bool:
    stones = make_bodies(assemblage, one_body_per_block(assemblage))
    return estimate(stones, case.mesh, case.elastic.element_order).unknowns > case.newton.distribute_above


def _compute_alone(run: LoadCaseRun) -> tuple[str, Outcome]:
    return run.name, compute(run, None, lambda event: None)


def compute(run: LoadCaseRun, comm: MPI.Comm | None, report: Report) -> Outcome:
    """Run one load case into its folder; one without a curve is a complaint, not an end of all."""
    if run.resume and (finished := on_root(comm, _finished, run)):
        return finished
    try:
        return driver.run(run.case, run.folder, run.resume, comm, report)
    except ConvergenceError as error:  # before the first lateral increment
        return Outcome(None, (error,))


def _finished(run: LoadCaseRun) -> Outcome | None:
    """Return the outcome of a load case that was run with the same settings, inputs and sources, without complaints."""
    written = run.folder / "case.toml"
    if not (run.folder / "summary.json").is_file():
        return None
    if _without_commit(written.read_text(encoding="utf-8")) != _without_commit(as_run(run.case)):
        return None
    summary = storage.read_summary(run.folder)
    try:
        storage.refuse_other_parts(run.folder, summary)
    except CaseError:  # gone on with, it writes them again
        return None
    complains = summary.failed or any(pushed.complaint for pushed in summary.pushover)
    return None if complains else Outcome(summary, ())


def _without_commit(text: str) -> list[str]:
    """Return the lines of a case.toml but the one that names a commit: other commits may have the same sources."""
    return [line for line in text.splitlines() if not line.startswith("# commit ")]


def _seconds(outcome: Outcome) -> float:
    return sum(pushed.seconds["total"] for pushed in outcome.summary.pushover) if outcome.summary else 0.0


def _named(report: Report, name: str) -> Report:
    """Return a report that says which load case an event belongs to."""

    def named(event: Any) -> None:
        key = "model" if isinstance(event, IncrementDone) else "stage"
        report(replace(event, **{key: f"{name}: {getattr(event, key)}"}))

    return named


def _collected(case: Case, runs: list[LoadCaseRun], done: list[Outcome], output: Path) -> LoadCasesOutcome:
    record = {
        "case": case.name,
        "project": asdict(case.project),
        "load_cases": [
            {
                "name": one.name,
                "direction": one.case.load.direction,
                "distribution": one.case.load.distribution,
                "inclination": one.case.load.inclination,
                "complaints": [str(complaint) for complaint in outcome.complaints],
                "summary_sha256": outcome.summary and outcome.summary.sha256,
            }
            for one, outcome in zip(runs, done, strict=True)
        ],
    }
    storage.write_json(output / INDEX, record)
    complaints = (
        type(complaint)(f"load case {one.name}: {complaint.args[0]}", *complaint.args[1:])
        for one, outcome in zip(runs, done, strict=True)
        for complaint in outcome.complaints
    )
    return LoadCasesOutcome(*_presented(output), tuple(done), tuple(complaints))


def are_in(folder: Path) -> bool:
    """Return whether `run` has left several load cases in a folder."""
    return (folder / INDEX).is_file()


def rebuild(folder: Path) -> Path:
    """Draw all pictures of all load cases again and write their pages, from stored results alone; return the index.
    Raises CaseError before anything is written."""
    finished = _finished_in(folder)
    for one in finished:
        driver.rebuild_report(one)
    _presented(folder)
    return folder / "report.html"


def _finished_in(folder: Path) -> list[Path]:
    """Return the folders of the load cases that have curves. Raises CaseError where one is not as it was when all were
    done, a verification of it is not made, or it is of another action than that of the first."""
    with telling_damage(folder):
        listed = {
            folder / entry["name"]: entry["summary_sha256"] for entry in storage.read_json(folder / INDEX)["load_cases"]
        }
    first: tuple[str, Case] | None = None
    for one, digest in listed.items():
        path = one / "summary.json"
        if path.is_file():
            case, summary = read_checked(one)
            if summary.sha256 != digest:
                problem = "is of another run than its neighbours"
                raise CaseError("", problem, "`run` the load cases with --resume, or run them anew", str(path))
            refuse_verification(case)
            first = first or (one.name, case)
            if case.seismic != first[1].seismic:
                remedy = "one verdict is of one action, one factor of confidence"
                raise CaseError("seismic", f"is not that of load case {first[0]}", remedy, str(one / "case.toml"))
        elif digest is not None:
            raise missing(path)
    return [one for one, digest in listed.items() if digest is not None]


def _presented(folder: Path) -> tuple[tuple[dict[str, Any], ...], Verdict]:
    """Write tables, picture and index page from the stored load cases; return the rows and the verdict."""
    record = storage.read_json(folder / INDEX)
    rows = tuple(row for entry in record["load_cases"] for row in _rows(entry, folder / entry["name"]))
    storage.write_csv(folder / "load_cases.csv", COLUMNS, ([row[name] for name in COLUMNS] for row in rows))
    drawn = [row for row in rows if row["model"]]
    curves = [storage.read_curve(folder / row["load_case"] / row["model"], row["stopped_because"]) for row in drawn]
    lines = [
        plots.ModelCurve(row["load_case"], row["model"], row["valid"], curve)
        for row, curve in zip(drawn, curves, strict=True)
    ]
    project = ProjectSettings(**record["project"])
    language = project.language
    plots.save(plots.load_case_curves(lines, record["case"]), folder / "figures", "curves", language)
    answers = [_answered(entry, folder / entry["name"]) for entry in record["load_cases"]]
    judgement = verdict(record["case"], answers)
    page.write_verdict(folder, judgement)
    verified = next((one.summary.seismic for one in answers if one.summary and one.summary.seismic), None)
    page.write_index(folder, record["case"], rows, judgement, project, verified)
    return rows, judgement


def _answered(entry: dict[str, Any], folder: Path) -> Answered:
    summary = storage.read_summary(folder) if (folder / "summary.json").is_file() else None
    about = (entry["name"], entry["direction"], entry["distribution"])
    return Answered(*about, summary, tuple(entry["complaints"]), entry.get("inclination", 0.0))


def _rows(entry: dict[str, Any], folder: Path) -> Iterator[dict[str, Any]]:
    """Yield the table's rows of one load case: one for each of its curves, or one that says why there is none."""
    about = {"load_case": entry["name"], "direction": entry["direction"], "distribution": entry["distribution"]}
    about["inclination_deg"] = round(degrees(entry.get("inclination", 0.0)), 9)
    row = dict.fromkeys(COLUMNS, "") | about
    if not (folder / "summary.json").is_file():
        yield row | {"complaint": "; ".join(entry["complaints"])}
        return
    summary = storage.read_summary(folder)
    limit = summary.limit_analysis
    lowest = "" if limit.non_associative is None else limit.non_associative
    sums = {f"{name}_N": getattr(summary.wall, name) for name in ("weight", "vertical_load", "horizontal_load")}
    for why in (summary.failed or {}).values():
        yield row | {"complaint": why}
    for pushed in summary.pushover:
        figures = {
            "model": pushed.model,
            "bodies": pushed.bodies,
            "associative": limit.associative,
            "non_associative": lowest,
            "kind": limit.kind,
            "limit_base_shear_N": limit.base_shear,
            "peak_multiplier": pushed.peak_multiplier,
            "peak_base_shear_N": pushed.peak_base_shear,
            "displacement_at_peak_m": pushed.displacement_at_peak,
            "initial_stiffness_N_per_m": pushed.initial_stiffness,
            "peak_reached": pushed.peak_reached,
            "valid": pushed.valid,
            "stopped_because": pushed.stopped_because,
            "complaint": pushed.complaint or "",
        }
        yield row | sums | figures
