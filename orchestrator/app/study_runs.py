"""The tolerance study: one run folder per different partition of the grid, and one of every stone; table and pictures.

A run is computed in a folder of a temporary name and renamed when it is whole. Its name ends with a hash of everything
it depends on (wall, settings, partition, this program's mechanics): a run that is there is not run again, so that an
interrupted study continues where it stopped. Runs are independent; ranks 1 and up share them.
"""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from math import inf
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

from orchestrator import storage
from orchestrator.app import driver, pushover_run
from orchestrator.app.progress import Report, StageBegun, StageDone
from orchestrator.app.segmented import Segmented
from orchestrator.basis.atomic_files import MARK, TEMPORARY
from orchestrator.basis.errors import CaseError, ConvergenceError
from orchestrator.basis.parallel import Spread, workers_into
from orchestrator.basis.printed import printed
from orchestrator.macroblocks.criteria import Partition, one_body_per_block
from orchestrator.macroblocks.tolerance_grid import Cell, distinct, grid, key
from orchestrator.masonry.wall import Wall
from orchestrator.present import plots
from orchestrator.settings.case import Case, RunSettings, as_record
from orchestrator.storage.identity import identity
from orchestrator.storage.notes import why_not

if TYPE_CHECKING:
    from mpi4py import MPI

COLUMNS = (
    "tol_n", "tol_D_m", "bodies", "joints", "peak_multiplier", "peak_base_shear_N", "displacement_at_peak_m",
    "initial_stiffness_N_per_m", "seconds", "bodies_over_micro", "peak_over_micro", "stiffness_over_micro",
    "seconds_over_micro", "run", "stopped_because", "valid", "complaints",
)  # fmt: skip


@dataclass(frozen=True, eq=False, slots=True)
class PartitionRun:
    """One pushover of the study: a partition, and the folder that holds its result once it is whole."""

    case: Case
    segmented: Segmented
    folder: Path

    @property
    def model(self) -> str:
        """`micro` for every stone, else `macro`."""
        return self.case.run.models[0]


@dataclass(frozen=True, eq=False, slots=True)
class StudyOutcome:
    """What a study leaves: the rows of table.csv, the last one of micro-FE, and the complaints of its runs."""

    rows: tuple[dict[str, Any], ...]
    complaints: tuple[str, ...]


def study(
    case: Case, output: Path, comm: MPI.Intracomm | None, report: Report, force: bool = False
) -> StudyOutcome | None:
    """Run the grid of [study] into the folder `output`; None on the ranks that only work. Raises CaseError, where not
    by `force` for a folder with the table of another study too."""
    pushover_run.start_finite_elements()
    with workers_into(output, comm) as spread:
        return _study(case, output, spread, report, force) if spread else None


def _study(case: Case, output: Path, spread: Spread, report: Report, force: bool) -> StudyOutcome:
    began = perf_counter()
    storage.refuse_run(output)
    assemblage, analysis = driver.limit(case)
    driver.refuse_what_cannot_be_pushed(case, assemblage)
    try:
        cells = grid(assemblage, analysis.headline.mechanism, case.macroblocks, case.study)
    except CaseError as error:
        key_here = error.key.replace("macroblocks", "study")
        raise CaseError(key_here, error.problem, error.remedy, str(case.file)) from None
    micro = one_body_per_block(assemblage)
    segmented = Segmented.into(assemblage, analysis, micro, case.contact.softening_displacement)
    runs = [
        _run_of(partition, case, segmented, output) for partition in distinct([micro, *(c.partition for c in cells)])
    ]
    points = hashlib.sha256(repr([(cell.tol_n, cell.tol_d) for cell in cells]).encode())
    points.update(repr([run.folder.name for run in runs]).encode())
    source = storage.Source(
        "study", as_record(case, str(case.block_file)), (case.file, case.block_file), points.hexdigest()
    )
    if not force:
        storage.refuse_other_points(output, "table.csv", source)
    missing = [run for run in sorted(runs, key=lambda run: -run.segmented.partition.count) if not run.folder.exists()]
    text = f"{len(cells)} cells, {len(runs)} different partitions, {len(runs) - len(missing)} of them run before"
    report(StageDone("micro-LA and grid", perf_counter() - began, text))
    if missing:
        report(StageBegun("study", f"the first of {len(missing)} pushovers"))
    for number, done in enumerate(spread(compute, missing), 1):
        report(StageDone(f"{number} of {len(missing)}", perf_counter() - began, done))
    by_partition = {key(run.segmented.partition): run for run in runs}
    rows = tuple(_table(cells, micro, by_partition))
    report(StageBegun("study", "pictures"))
    with storage.placed([output], source, force):
        storage.write_csv(output / "table.csv", COLUMNS, ([row[name] for name in COLUMNS] for row in rows))
        _draw(case, segmented, cells, by_partition[key(micro)], by_partition, output / "figures")
    complaints = (f"{run.folder.name}: {text}" for run in runs for text in _complaints(run))
    return StudyOutcome(rows, tuple(complaints))


def _run_of(partition: Partition, case: Case, segmented: Segmented, output: Path) -> PartitionRun:
    """Return the run of one partition; the case it is given reads back as this run alone."""
    every_stone = partition.tolerances is None
    settings = replace(
        case,
        run=RunSettings(("micro",) if every_stone else ("macro",)),
        macroblocks=partition.tolerances or case.macroblocks,
    )
    name = "micro" if every_stone else f"{partition.count}_bodies"
    folder = output / "runs" / f"{name}-{_digest(case, segmented.assemblage.wall, partition)}"
    return PartitionRun(settings, segmented.divided(partition), folder)


def _digest(case: Case, wall: Wall, partition: Partition) -> str:
    """Return a hash of everything that the finished run of a partition depends on."""
    settings = (case.stepping, case.limit_analysis, case.seismic)
    total = hashlib.sha256(repr((identity(case, wall), settings)).encode())
    total.update(key(partition))
    return total.hexdigest()[:12]


def compute(run: PartitionRun) -> str:
    """Compute one run into its folder, whole or not at all; return what happened in a few words."""
    temporary = run.folder.with_name(f".{run.folder.name}.{MARK}{TEMPORARY}")
    shutil.rmtree(temporary, ignore_errors=True)
    try:
        outcome = driver.push(run.case, run.segmented, temporary, False, None, lambda event: None)
        complaints = [str(complaint) for complaint in outcome.complaints]
        assert outcome.summary is not None
        (pushed,) = outcome.summary.pushover
        peak, seconds = printed("multiplier", pushed.peak_multiplier), pushed.seconds["total"]
        text = f"peak {peak}, {printed('seconds', seconds)} s"
    except ConvergenceError as error:  # before the first lateral increment: there is no curve
        complaints, text = [str(error)], str(error)
    storage.write_json(temporary / "complaints.json", complaints)
    os.replace(temporary, run.folder)
    return f"{run.folder.name}: {text}"


def _complaints(run: PartitionRun) -> list[str]:
    return list(storage.read_json(run.folder / "complaints.json"))


def _pushover(run: PartitionRun) -> storage.PushoverSummary | None:
    """Return the summary of a finished run's pushover, None where it has no curve."""
    return storage.read_summary(run.folder).pushover[0] if (run.folder / "summary.json").exists() else None


def _not_valid(run: PartitionRun) -> str:
    """Return why the curve of a finished run is not valid, "" where it is or there is none."""
    pushed = _pushover(run)
    return (pushed and pushed.not_valid_because) or ""


def _does_not_count(run: PartitionRun) -> list[str]:
    """Return why the peak of a finished run with a valid curve does not count, if it does not."""
    if not (run.folder / "summary.json").exists():
        return []
    found = storage.read_summary(run.folder)
    why = why_not(found.pushover[0], found.limit_analysis, found.wall.blocks) if found.pushover[0].valid else None
    return [why] if why else []


def _table(cells: Sequence[Cell], micro: Partition, runs: dict[bytes, PartitionRun]) -> Iterable[dict[str, Any]]:
    reference = _pushover(runs[key(micro)])
    for cell in cells:
        tolerances = {"tol_n": _tolerance(cell.tol_n), "tol_D_m": _tolerance(cell.tol_d)}
        yield tolerances | _row(runs[key(cell.partition)], reference)
    yield {"tol_n": "micro-FE", "tol_D_m": ""} | _row(runs[key(micro)], reference)


def _tolerance(value: float) -> float | str:
    return "none" if value == inf else value


def _row(run: PartitionRun, micro: storage.PushoverSummary | None) -> dict[str, Any]:
    """Return the columns of one run after the tolerances; empty where there is no curve."""
    counted = {"bodies": run.segmented.partition.count, "joints": len(run.segmented.bodies.joint)}
    pushed = _pushover(run)
    said = {"run": run.folder.name, "complaints": "; ".join([*_complaints(run), *_does_not_count(run)])}
    row = dict.fromkeys(COLUMNS[2:], "") | counted | said
    if pushed is None:
        return row
    figures = {
        "peak_multiplier": pushed.peak_multiplier,
        "peak_base_shear_N": pushed.peak_base_shear,
        "displacement_at_peak_m": pushed.displacement_at_peak,
        "initial_stiffness_N_per_m": pushed.initial_stiffness,
        "seconds": pushed.seconds["total"],
        "stopped_because": pushed.stopped_because,
        "valid": pushed.valid,
    }
    if micro is None:
        return row | figures
    stiffness = pushed.initial_stiffness, micro.initial_stiffness
    ratios = {
        "bodies_over_micro": pushed.bodies / micro.bodies,
        "peak_over_micro": pushed.peak_base_shear / micro.peak_base_shear,
        "stiffness_over_micro": stiffness[0] / stiffness[1] if stiffness[0] and stiffness[1] else None,
        "seconds_over_micro": pushed.seconds["total"] / micro.seconds["total"],
    }
    return row | figures | ratios


def _draw(
    case: Case,
    segmented: Segmented,
    cells: Sequence[Cell],
    micro: PartitionRun,
    runs: dict[bytes, PartitionRun],
    folder: Path,
) -> None:
    """Draw the sheet of the grid (Table 1), the collapse of micro-LA and micro-FE (Figure 5) and all curves (4a)."""
    mechanism = plots.mechanism_panel(segmented.assemblage, segmented.analysis.headline)
    panel = {partition: _panel(run, segmented) for partition, run in runs.items()}
    sheet = [replace(panel[key(cell.partition)], title=_words(cell)) for cell in cells]
    references = [mechanism, replace(panel[key(micro.segmented.partition)], title="micro-FE")]
    columns = len(case.study.tol_d)
    if columns == 1:  # one row of everything, as in the paper's Figure 6
        plots.save(plots.panels([*sheet, *references], len(cells) + 2, case.name), folder, "table")
    else:
        plots.save(plots.panels(sheet, columns, case.name), folder, "table")
    plots.save(plots.panels(references, 2, case.name), folder, "mechanisms")
    finished = {partition: curve for partition, run in runs.items() if (curve := _curve(run)) is not None}
    reference = finished.pop(key(micro.segmented.partition), None)
    labelled = [(runs[partition].segmented.partition.count, curve) for partition, curve in finished.items()]
    wrong = [f"{run.folder.name}: {reason}" for run in runs.values() if (reason := _not_valid(run))]
    plots.save(plots.study_curves(labelled, reference, segmented.analysis, case.name, wrong), folder, "curves")


def _words(cell: Cell) -> str:
    normal = "none" if cell.tol_n == inf else f"{cell.tol_n:.3g}"
    distance = "none" if cell.tol_d == inf else f"{1e3 * cell.tol_d:g} mm"
    bodies = "1 body" if cell.partition.count == 1 else f"{cell.partition.count} bodies"
    return f"tol_n {normal}, tol_D {distance}\n{bodies}"


def _curve(run: PartitionRun) -> Any:
    pushed = _pushover(run)
    return pushed and storage.read_curve(run.folder / run.model, pushed.stopped_because)


def _panel(run: PartitionRun, segmented: Segmented) -> plots.SmallWall:
    meshes, last = pushover_run.last_state(
        run.case, run.segmented.assemblage.wall, run.segmented.bodies, run.folder / run.model
    )
    panel = plots.deformed_panel(segmented.assemblage, run.segmented.partition, run.segmented.bodies, meshes, last)
    return replace(panel, valid=not _not_valid(run))
