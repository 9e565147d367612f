"""The chain, written out once: what each command runs, in order.

Case -> Wall -> Assemblage -> LimitAnalysis -> Partition -> Bodies -> BodyMeshes -> ContactModel -> Increment ... ->
PushoverCurve -> Capacity -> run folder. Every stage is a function of the values before it; only this module knows all,
and pushover_run.py those from Bodies to Capacity.

Under MPI rank 0 does everything, but all ranks share a pushover of more than newton.distribute_above unknowns.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

from orchestrator import storage
from orchestrator.app.progress import Report, StageBegun, StageDone
from orchestrator.app.pushed import Pushed
from orchestrator.app.pushover_run import refuse_own_input, room_for
from orchestrator.app.refining import left_off, push_segmented, refuse_another_run, with_finished
from orchestrator.app.segmented import Segmented
from orchestrator.assessment.seismic.settings import limit_states, without_verification
from orchestrator.basis.atomic_files import sweep
from orchestrator.basis.errors import CaseError, ConvergenceError, ResultError, naming, resumable
from orchestrator.basis.parallel import is_root, on_root, on_root_while
from orchestrator.basis.printed import as_lambda, wedged_words
from orchestrator.limit_analysis import LimitAnalysis, LimitState, analyse, settle
from orchestrator.limit_analysis.gravity import problem_of, refuse_what_cannot_be_analysed, refuse_what_falls
from orchestrator.limit_analysis.paper.limit_state import of_first_joints
from orchestrator.limit_analysis.pretension import refuse_what_pretension_moves
from orchestrator.limit_analysis.wedged_stones import stones_in_wedges
from orchestrator.loads import Loads, loads_on
from orchestrator.loads.dead_loads import not_accelerated
from orchestrator.macroblocks.automatic import macroblocks_of
from orchestrator.macroblocks.bodies import make_bodies
from orchestrator.macroblocks.criteria import MacroblockSettings, one_body_per_block
from orchestrator.masonry.joint_warnings import (
    idle_classes,
    lost_joints,
    naming_gaps,
    short_contacts,
    strengths_beyond_the_cone,
)
from orchestrator.masonry.joints import Assemblage, check_assemblage, find_joints
from orchestrator.masonry.sources.drawing import implausible, refuse_implausible_size
from orchestrator.masonry.ties import idle_ties, with_ties
from orchestrator.masonry.wall import check_wall
from orchestrator.pushover.contact.mortar import refuse_bonded_mortar
from orchestrator.settings.case import (
    Case,
    ModelName,
    read_wall,
    refuse_seismic,
    refuse_ties_of_run,
    refuse_what_only_limit_analysis_takes,
)

if TYPE_CHECKING:
    from mpi4py import MPI

logger = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False, slots=True)
class Outcome:
    """What a run leaves: the summary as written (None: there is no curve), and the complaints of its pushovers."""

    summary: storage.Summary | None
    complaints: tuple[ConvergenceError | ResultError, ...]


def check(case: Case) -> Assemblage:
    """Read the wall, find its joints, and refuse what cannot be analysed (CaseError)."""
    wall = read_wall(case)
    with _naming_input(case):
        assemblage = find_joints(wall, case.joints)
        if assemblage.wall is not wall:
            check_wall(assemblage.wall, case.joints.tolerance)
        check_assemblage(assemblage)
    return assemblage


@contextmanager
def _naming_input(case: Case, assemblage: Assemblage | None = None) -> Iterator[None]:
    """Let every CaseError raised inside name the file that has its key, the case file or the block file, and gaps of
    the assemblage that may be why it falls."""
    try:
        yield
    except CaseError as error:
        error = error if assemblage is None else naming_gaps(error, assemblage, case.joints)
        of_case = error.key.startswith(("joints.", "load."))
        raise error.in_file(str(case.file if of_case else case.block_file)) from None


def _loaded(case: Case, assemblage: Assemblage, settling: int | None = None) -> tuple[Assemblage, Loads]:
    """Return a wall with its ties (settling: id of the support that is to give way) and its loads. Raises CaseError."""
    with naming(case.file):
        tied, loads = with_ties(assemblage, case.reinforcement.ties, settling), loads_on(assemblage.wall, case.load)
        refuse_what_pretension_moves(assemblage, loads, case.reinforcement.ties, settling)
        return tied, loads


def refuse_what_does_not_stand(case: Case, assemblage: Assemblage) -> None:
    """Raise CaseError, of one load case, for a wall that cannot stand, or that no live load brings down."""
    tied, loads = _loaded(case, assemblage)
    with _naming_input(case, assemblage):
        refuse_what_cannot_be_analysed(tied, loads)


def refuse_pushover(case: Case, assemblage: Assemblage) -> None:
    """Raise CaseError, of one load case, for what limit analysis takes and the finite elements do not."""
    refuse_what_only_limit_analysis_takes(case)
    refuse_ties_of_run(case)
    refuse_what_cannot_be_pushed(case, assemblage)
    if "micro" in case.run.models:
        room_for(make_bodies(assemblage, one_body_per_block(assemblage)), case)


def examine(case: Case, assemblage: Assemblage, key_in_file: Callable[[str], str] = str) -> list[str]:
    """Refuse, of one load case, whatever `limit` would refuse, and a verification that `run` would (CaseError); return
    what else is to be said.

    assemblage: of the case, as `check` returns it. key_in_file: of a key, as in "load.dead.0", what the file calls it.
    """
    refuse_seismic(case)
    refuse_what_does_not_stand(case, assemblage)
    wedged = stones_in_wedges(*_loaded(case, assemblage), case.limit_analysis, case.elastic.elastic_modulus)
    said = [
        *[f"WARNING: {wedged_words(wedged)}"] * bool(wedged),
        *assemblage.wall.remarks,
        *lost_joints(assemblage, case.joints),
        *short_contacts(assemblage, case.joints),
        *idle_classes(assemblage, case.joints.classes),
        *strengths_beyond_the_cone(assemblage, case.joints.classes),
        *implausible(assemblage.wall),
        *without_verification(case.seismic),
    ]
    if limit_states(case.seismic):
        said += not_accelerated(assemblage.wall, case.load.dead, key_in_file)
    try:
        refuse_pushover(case, assemblage)
    except CaseError as error:
        error = CaseError(key_in_file(error.key), error.problem, error.remedy, error.file)
        said.append(f"WARNING: check, limit and segment take this case, run does not: {error}")
    return said


def refuse_what_is_not_run(case: Case) -> None:
    """Raise CaseError for one load case with loads, ties or a verification that `run` does not take."""
    refuse_what_only_limit_analysis_takes(case)
    refuse_ties_of_run(case)
    refuse_seismic(case)


def refuse_what_cannot_be_pushed(case: Case, assemblage: Assemblage) -> None:
    """Raise CaseError for a wall that is too large to be one or has joints of no known law, before its pushover."""
    with naming(case.block_file):
        refuse_implausible_size(assemblage.wall)
    with naming(case.file):
        refuse_bonded_mortar(assemblage, case.contact.softening_displacement)


def limit(case: Case) -> tuple[Assemblage, LimitAnalysis]:
    """Run micro limit analysis on a checked wall; ties are no joints of what is returned, and have their forces apart.
    Raises CaseError for a wall that cannot stand."""
    assemblage = check(case)
    _, analysis = _analysed(case, assemblage)
    return assemblage, of_first_joints(analysis, assemblage.joints.count)


def _analysed(case: Case, assemblage: Assemblage) -> tuple[Assemblage, LimitAnalysis]:
    """Return a checked wall with its ties after its joints, and the limit analysis of that."""
    tied, loads = _loaded(case, assemblage)
    with _naming_input(case, assemblage):
        analysis = analyse(tied, case.limit_analysis, loads, case.elastic.elastic_modulus)
    classes = case.joints.classes
    of_classes = (*idle_classes(assemblage, classes), *strengths_beyond_the_cone(assemblage, classes))
    warnings = (*lost_joints(assemblage, case.joints), *of_classes)
    return tied, replace(analysis, remarks=(*assemblage.wall.remarks, *warnings, *analysis.remarks))


def draw_mechanism(case: Case, assemblage: Assemblage, analysis: LimitAnalysis, output: Path) -> Path:
    """Draw the mechanism into the run folder `output`; return its PNG."""
    from orchestrator.present import report as reporting

    return reporting.write_mechanism(output / "figures", case, assemblage, analysis)[0]


def draw_macroblocks(case: Case, segmented: Segmented, output: Path) -> tuple[Path, Path]:
    """Draw macroblocks and mechanism into the run folder `output`; return their PNGs."""
    from orchestrator.present import plots

    drawn = plots.macroblocks(segmented.assemblage, segmented.partition)
    picture = plots.save(drawn, output / "figures", "macroblocks", case.project.language)[0]
    return picture, draw_mechanism(case, segmented.assemblage, segmented.analysis, output)


def settlement(case: Case, support: int, angle: float) -> tuple[Assemblage, LimitState]:
    """Let a support give way at `angle` (rad from +x) under the dead load of one load case. Raises CaseError."""
    assemblage = check(case)
    tied, loads = _loaded(case, assemblage, support)
    with _naming_input(case, assemblage):
        refuse_what_falls(problem_of(tied, loads))
    with naming(case.file):
        return tied, settle(tied, support, angle, loads)


def draw_settlement(case: Case, assemblage: Assemblage, state: LimitState, angle: float, output: Path) -> Path:
    """Draw a support that has given way at `angle` (rad from +x) into the run folder `output`; return its PNG."""
    from orchestrator.present import report as reporting

    return reporting.write_settlement(output / "figures", assemblage, state, angle, case.project.language)[0]


def segment(case: Case) -> Segmented:
    """Run everything before the finite elements. Ties are no joints: nothing after limit analysis has them as such."""
    assemblage = check(case)
    tied, analysis = _analysed(case, assemblage)
    with naming(case.file):
        criteria = case.macroblocks
        if criteria.choose == "automatic":  # a case file that says so and has tolerances has them for `study`
            criteria = MacroblockSettings(margin=criteria.margin)
        partition = macroblocks_of(assemblage, analysis, criteria, tied)
    idle = idle_ties(assemblage.wall, case.reinforcement.ties, partition.body_of_block)
    partition = replace(partition, remarks=(*partition.remarks, *idle))
    analysis = of_first_joints(analysis, assemblage.joints.count)
    return Segmented.into(assemblage, analysis, partition, case.contact.softening_displacement)


def run(case: Case, output: Path, resume: bool, comm: MPI.Comm | None, report: Report) -> Outcome:
    """Run the whole chain into the folder `output`; the same outcome on every rank.

    With `resume` a pushover goes on after its last stored increment, and a model that the folder holds finished is
    carried on beside those of the case; else results of an earlier run are removed: who calls holds the folder
    (`storage.held`), and has asked about them. A model without a curve is a complaint where another one has a curve.
    Raises CaseError before anything is written, ConvergenceError where no model has a curve.
    """
    began = perf_counter()
    if resume:
        case = on_root(comm, resumed, case, output)
    on_root(comm, refuse_what_is_not_run, case)
    segmented = on_root(comm, segment, case)
    on_root(comm, refuse_what_cannot_be_pushed, case, segmented.assemblage)
    for model in case.run.models:
        on_root(comm, room_for, segmented.bodies_of(model), case)
    on_root(comm, refuse_own_input, case, output)
    report(StageDone("micro-LA and macroblocks", perf_counter() - began, _words(segmented)))
    return push(case, segmented, output, resume, comm, report)


def resumed(case: Case, output: Path) -> Case:
    """Return the case with all models to be gone on with. Raises CaseError where the folder holds another run."""
    case = with_finished(case, output)
    refuse_another_run(case, check(case).wall, output)
    return case


def push(
    case: Case, segmented: Segmented, output: Path, resume: bool, comm: MPI.Comm | None, report: Report
) -> Outcome:
    """Run the finite elements of a segmented wall into the folder `output`; else as `run`."""
    from orchestrator.present import report as reporting  # pictures cost 0.2 s, which others need not wait for

    if resume:
        segmented = on_root(comm, left_off, case, segmented, output)
    with resumable(), on_root_while(comm, storage.logging_to(output / "run.log")):
        on_root(comm, sweep, output, output / "figures")
        on_root(comm, storage.remove_recorded if resume else storage.clear, output, (case.file, case.block_file))
        report(StageBegun("pictures", "wall, mechanism and macroblocks"))
        on_root(
            comm,
            reporting.write_segmentation,
            output, case, segmented.assemblage, segmented.analysis, segmented.partition, segmented.bodies,
        )  # fmt: skip
        if is_root(comm):
            for line in storage.provenance((case.file, case.block_file)):
                logger.info(line)
            logger.info("settings as run: %s", output / "case.toml")
            logger.info("micro-LA and macroblocks: %s", _words(segmented))
        pushed: dict[ModelName, Pushed] = {}
        failed: dict[ModelName, ConvergenceError] = {}
        for model in dict.fromkeys(case.run.models):
            chosen = segmented.partition
            try:
                segmented, pushed[model] = push_segmented(model, case, segmented, output, resume, comm, report)
            except ConvergenceError as error:  # before the first lateral increment
                failed[model] = error
            if segmented.partition is not chosen:
                on_root(
                    comm,
                    reporting.write_partition,
                    output, case, segmented.assemblage, segmented.partition, segmented.bodies,
                )  # fmt: skip
        if failed and not pushed:
            first, *others = failed.values()
            raise ConvergenceError(first.stage, "; ".join([first.where, *map(str, others)]), first.iterations)
        report(StageBegun("report", "curves, verification where asked for, and report.html"))
        outcome = on_root(comm, _finished, case, segmented, pushed, failed, output)
        for model, done in pushed.items():
            peak, stopped = done.capacity.peak_base_shear, done.curve.stopped_because
            logger.info("%s: peak base shear %.6g N; %s", model, peak, stopped)
        for complaint in outcome.complaints:
            logger.error("%s", complaint)
        logger.info("finished: %s", output / "summary.json")
        return outcome


def rebuild_report(run_folder: Path) -> Path:
    """Draw the pictures of a finished run again and write report.html, from stored results alone; return its path."""
    from orchestrator.present import report as reporting

    return reporting.rebuild(run_folder)


def _finished(
    case: Case,
    segmented: Segmented,
    pushed: dict[ModelName, Pushed],
    failed: dict[ModelName, ConvergenceError],
    output: Path,
) -> Outcome:
    from orchestrator.present import report as reporting

    summary = reporting.write_summary(
        output,
        case,
        segmented.assemblage,
        segmented.analysis,
        segmented.partition,
        {model: (done.curve, done.capacity) for model, done in pushed.items()},
        [done.summary for done in pushed.values()],
        {model: str(error) for model, error in failed.items()},
    )
    complaints = (complaint for done in pushed.values() for complaint in done.complaints)
    return Outcome(summary, (*failed.values(), *complaints))


def _words(segmented: Segmented) -> str:
    analysis, partition = segmented.analysis, segmented.partition
    bodies = "1 macroblock" if partition.count == 1 else f"{partition.count} macroblocks"
    outcome = f"multiplier {as_lambda(analysis.headline.load_multiplier)}, {bodies}"
    return "; ".join([outcome, *analysis.remarks, *partition.remarks, *implausible(segmented.assemblage.wall)])
