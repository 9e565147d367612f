"""Macroblocks pushed, and finer ones until these bear the same: macroblocks/refinement.py says when, and why.

    partition, pushed = push_and_refine(assemblage, analysis, macroblocks_of(assemblage, analysis), push_partition)

with `push_partition` a function of the partition and of which peaks suffice to end with it, e.g.

    lambda bodies, suffices: push(assemblage, analysis, bodies, load, suffices=suffices)

Where they do not, its curve need not go on beyond the peak. `push_segmented` does so for `run`, into its folder, and
`left_off` finds the macroblocks at which a run was stopped.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

from orchestrator.app.curve_end import NOT_ENOUGH, Suffices
from orchestrator.app.progress import Report, StageBegun, StageDone
from orchestrator.app.pushed import Pushed
from orchestrator.app.pushover_run import last_state, push_model, refuse_longer_curve
from orchestrator.app.segmented import Segmented
from orchestrator.basis.errors import CaseError, ConvergenceError
from orchestrator.basis.parallel import on_root
from orchestrator.limit_analysis import LimitAnalysis
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.macroblocks.criteria import MacroblockSettings, Partition, stones_of
from orchestrator.macroblocks.refinement import (
    Borne,
    finer,
    is_enough,
    may_be_last,
    more_bodies,
    remarked,
)
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.ties import idle_ties
from orchestrator.masonry.wall import Wall
from orchestrator.settings.case import Case, ModelName, RunSettings, read
from orchestrator.storage import StateStore
from orchestrator.storage.files import read_json, write_json
from orchestrator.storage.identity import identity, settings_that_differ

if TYPE_CHECKING:
    from mpi4py import MPI

MODELS: tuple[ModelName, ...] = ("macro", "micro")
"""in the order in which a run pushes both"""

BORNE = "borne.json"
"""file in a model's folder: what its macroblocks bore, the coarsest first"""

logger = logging.getLogger(__name__)


def push_and_refine(
    assemblage: Assemblage,
    analysis: LimitAnalysis,
    partition: Partition,
    push_partition: Callable[[Partition, Suffices], Pushed],
    margin: float = MacroblockSettings().margin,
    earlier: Sequence[Borne] = (),
    remember: Callable[[Sequence[Borne]], None] = lambda borne: None,
) -> tuple[Partition, Pushed]:
    """Push macroblocks, and finer ones until finite elements, limit analysis and twice as many agree; return the last.

    margin: as in MacroblockSettings. earlier: what coarser macroblocks bore, of a run that goes on; remember: told of
    them and of all that were pushed, before finer ones are. The remarks of the partition say what was pushed before.
    Raises CaseError where the first do not fit into the memory, ConvergenceError where they have no curve; where finer
    ones do not fit or have none, those before them stand, pushed again to the end of their curve.
    """
    said, borne, stones = partition.remarks, [*earlier], stones_of(assemblage)

    def suffices(multiplier: float) -> bool:
        """Whether those that are pushed now may be the last."""
        return more_bodies(next_one.count, stones) is None or may_be_last(analysis, margin, multiplier)

    next_one = partition
    while True:
        try:
            done = push_partition(next_one, suffices)
        except (CaseError, ConvergenceError) as error:
            if len(borne) == len(earlier):
                raise
            said = (*said, f"{next_one.count} macroblocks could not be pushed: {error}")
            done = push_partition(partition, lambda multiplier: True)
            break
        partition, peak = next_one, done.capacity.peak_multiplier
        is_peak, in_large = done.capacity.peak_reached, done.summary.displacements == "large"
        is_valid = done.summary.valid and not done.cut_short
        borne.append(Borne(partition.count, peak, is_peak, is_valid, in_large, done.summary.held))
        if done.summary.stopped_because != NOT_ENOUGH and is_enough(analysis, margin, borne, stones):
            break
        following = finer(assemblage, analysis, partition)
        if following is None:
            break
        remember(borne)
        logger.info("%d macroblocks bear %.4f: %d are pushed", partition.count, peak, following.count)
        next_one = following
    return remarked(analysis, margin, replace(partition, remarks=said), borne, stones), done


def push_segmented(
    model: ModelName,
    case: Case,
    segmented: Segmented,
    output: Path,
    resume: bool,
    comm: MPI.Comm | None,
    report: Report,
) -> tuple[Segmented, Pushed]:
    """Push one model of a run into its folder; return the wall with the bodies pushed last.

    Macroblocks by tolerances are pushed as they are, those that were chosen automatically are refined. Every stone is
    not pushed a second time where the macroblocks of the run are that.
    """
    wall, analysis, chosen = segmented.assemblage.wall, segmented.analysis, segmented.partition

    def push_bodies(bodies: Bodies, resume: bool, suffices: Suffices | None = None) -> Pushed:
        began, same = perf_counter(), on_root(comm, _of_same_bodies, model, case, segmented, bodies, output)
        if same is not None:
            report(StageBegun(f"{model} FE", f"the bodies of {same.name} FE, every stone: its curve is that of both"))
        done = push_model(
            model, case, segmented.assemblage, bodies, output / model, resume, comm, report, analysis, same, suffices
        )
        report(StageDone(f"{model} FE", perf_counter() - began, done.curve.stopped_because))
        return done

    def push_macroblocks(partition: Partition, suffices: Suffices) -> Pushed:
        nonlocal resume
        if partition is chosen:
            goes_on, resume = resume, False  # pushed a second time they do not find what they left
            return push_bodies(segmented.bodies, goes_on, suffices)
        report(StageBegun("macroblocks", f"{partition.count} in their place: to see whether more bear another load"))
        return push_bodies(segmented.divided(partition).bodies, False, suffices)

    if model == "micro" or chosen.tolerances is not None:
        return segmented, push_bodies(segmented.bodies_of(model), resume)
    known = output / model / BORNE
    partition, done = push_and_refine(
        segmented.assemblage,
        analysis,
        chosen,
        push_macroblocks,
        case.macroblocks.margin,
        on_root(comm, _borne_in, known, chosen.count) if resume else (),
        lambda borne: on_root(comm, write_json, known, [asdict(one) for one in borne]),
    )
    if partition.remarks == chosen.remarks:
        return segmented, done
    before, now = (idle_ties(wall, case.reinforcement.ties, p.body_of_block) for p in (chosen, partition))
    remarks = [remark for remark in partition.remarks if remark not in before]
    return segmented.divided(replace(partition, remarks=(*remarks, *now))), done


def _borne_in(known: Path, bodies: int) -> tuple[Borne, ...]:
    """Return what fewer macroblocks than `bodies` bore before a run was stopped."""
    if not known.is_file():
        return ()
    return tuple(one for one in (Borne(**record) for record in read_json(known)) if one.bodies < bodies)


def _of_same_bodies(model: ModelName, case: Case, segmented: Segmented, bodies: Bodies, output: Path) -> Path | None:
    """Return the folder of the other model of a run where it holds increments of the same bodies, every stone."""
    other: ModelName = "micro" if model == "macro" else "macro"
    pushed = bodies if other == "micro" else segmented.bodies
    are_stones = bodies.moving == pushed.moving == stones_of(segmented.assemblage)
    if other in case.run.models and are_stones and StateStore(output / other, "").numbers():
        return output / other
    return None


def with_finished(case: Case, output: Path) -> Case:
    """Return the case with the models too that `output` holds finished: their results are as good as before."""
    models = case.run.models
    wanted = [name for name in MODELS if name in models or (output / name / "curve.csv").is_file()]
    return case if set(wanted) == set(models) else replace(case, run=RunSettings(tuple(wanted)))


def refuse_another_run(case: Case, wall: Wall, output: Path) -> None:
    """Raise CaseError where `output` holds increments of another wall, case or program, without an analysis."""
    try:
        for model in case.run.models:
            StateStore(output / model, "").refuse_others(identity(case, wall))
    except CaseError:
        stored = output / "case.toml"
        differs = list(settings_that_differ(case, read(stored))) if stored.is_file() else []
        if not differs:
            raise
        (key, here, there), *others = differs
        more = f" ({', '.join(other for other, *_ in others)} differ, too)" if others else ""
        given, stored_as = ("left out" if value is None else repr(value) for value in (here, there))
        problem = f"is {given} here, and {stored_as} in the run that is stored in {output}{more}"
        remedy = "give it the same value, or run without --resume or into another folder"
        raise CaseError(key, problem, remedy, str(case.file)) from None


def left_off(case: Case, segmented: Segmented, output: Path) -> Segmented:
    """Return the segmented wall with the macroblocks that `output` holds increments of, as chosen or refined.

    Raises CaseError where it holds those of another run, or a curve that goes on beyond where the case ends it, before
    anything of it is overwritten.
    """

    def refuse_another(model: ModelName, one: Segmented) -> None:
        if StateStore(output / model, "").numbers():
            last_state(case, one.assemblage.wall, one.bodies_of(model), output / model)

    if "micro" in case.run.models:
        refuse_another("micro", segmented)
    left = segmented
    while "macro" in case.run.models:
        try:
            refuse_another("macro", left)
            break
        except CaseError:
            automatic = left.partition.tolerances is None
            more = finer(left.assemblage, left.analysis, left.partition) if automatic else None
            if more is None:
                raise
            left = segmented.divided(replace(more, remarks=segmented.partition.remarks))
    for model in case.run.models:
        refuse_longer_curve(case, left.assemblage.wall, left.bodies_of(model), output / model)
    return left
