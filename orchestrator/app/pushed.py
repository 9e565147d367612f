"""The pushover of bodies as a value: followed, folded into curve and capacity, and checked.

    pushed = push(assemblage, analysis, partition, load)

is for use from Python: no files, no communicator. pushover_run.py does the same for the command line, where increments
are stored as they come and all ranks may share one model.
"""

from __future__ import annotations

import resource
from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields, replace
from functools import partial
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from orchestrator import storage
from orchestrator.app.at_peak import (
    BoundLeft,
    at_the_top,
    bound_left,
    farthest_snap,
    moment_of_load,
    spike_of,
    wall_at_peak,
)
from orchestrator.app.broken_off import SolverSettings, located, place
from orchestrator.app.curve_end import (
    NOT_ENOUGH,
    Suffices,
    after_gravity,
    balanced,
    bears_load,
    before_it_goes_far,
    first_misfit,
    is_cut_short,
    is_past,
    largest,
    misfits_of,
    usable,
    used,
)
from orchestrator.app.progress import IncrementDone, Report
from orchestrator.app.what_moves import part_gone
from orchestrator.assessment.capacity import Capacity, find_capacity
from orchestrator.basis.arrays import BoolArray, read_only
from orchestrator.basis.errors import (
    CaseError,
    CollapseError,
    ConvergenceError,
    HeldError,
    ResultError,
    refuse_other_kind,
    require_kinds,
)
from orchestrator.basis.parallel import this_rank
from orchestrator.basis.printed import millimetres, percent_of
from orchestrator.basis.threads import in_turn
from orchestrator.limit_analysis import LimitAnalysis
from orchestrator.limit_analysis.paper.limit_state import refuse_other_analysis
from orchestrator.limit_analysis.turning_joints import pressed_at_hinges
from orchestrator.loads import LoadSettings, loads_on
from orchestrator.macroblocks.bodies import Bodies, make_bodies
from orchestrator.macroblocks.criteria import Partition, stones_of
from orchestrator.masonry.block_properties import block_areas
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.wall import Wall
from orchestrator.pushover.contact.cohesion import CoarseCracks, coarse_cracks
from orchestrator.pushover.contact.mortar import refuse_bonded_mortar
from orchestrator.pushover.increments import Increment, PushoverCurve, end_of_curve
from orchestrator.pushover.meshing import BodyMeshes, MeshSettings, mesh_bodies
from orchestrator.pushover.path.curve_checks import RowMisfits, check_curve
from orchestrator.pushover.settings import ContactSettings, ElasticSettings, NewtonSettings, SteppingSettings
from orchestrator.settings.case import ModelName

if TYPE_CHECKING:
    from mpi4py import MPI

    from orchestrator.pushover.model import ContactModel

SAME_LOAD = 1e-9
"""part by which the loads of limit analysis and of `push` may differ: rounding"""
TOO_STRONG = 0.05
"""part of the live load's moment that bonds which crack may carry too much at a valid peak"""


Ended = ConvergenceError | CollapseError | HeldError | None
"""why a path ended before `end_of_curve`; None: it did not"""


@dataclass(frozen=True, eq=False, slots=True)
class Pushed:
    """One finished pushover. `complaints`: why the curve ended early, and why it is not valid; none of a good one.
    cut_short: whether the curve ends as bodies overlap before its base shear has fallen."""

    curve: PushoverCurve
    capacity: Capacity
    summary: storage.PushoverSummary
    complaints: tuple[ConvergenceError | ResultError, ...]
    cut_short: bool = False


@in_turn
def push(
    assemblage: Assemblage,
    analysis: LimitAnalysis,
    partition: Partition,
    load: LoadSettings | None = None,
    *,
    mesh: MeshSettings | None = None,
    elastic: ElasticSettings | None = None,
    contact: ContactSettings | None = None,
    newton: NewtonSettings | None = None,
    stepping: SteppingSettings | None = None,
    report: Report | None = None,
    suffices: Suffices | None = None,
) -> Pushed:
    """Push the bodies of a partition: weight, extra dead loads (floors), live load; check the curve as `run` does.

    partition: macroblocks, or `one_body_per_block(assemblage)` for micro-FE. analysis: of the assemblage under the same
    loads; its associative multiplier is the measure of load increments. report: told every increment (progress.py).
    suffices: of which peak the curve goes on beyond it; None: of any, as far as `stepping` says. Settings left out have
    the default of the case file. All increments stay in memory until the curve ends. Raises CaseError for an analysis
    or a partition of another wall, loads other than those of the analysis and for joints of no known law,
    ConvergenceError where there is no curve; a curve that breaks off or is not valid is returned with its `complaints`.
    """
    needed = {"assemblage": (assemblage, Assemblage), "analysis": (analysis, LimitAnalysis)}
    require_kinds("write push(assemblage, analysis, partition, load)", **needed, partition=(partition, Partition))
    refuse_other_kind("load", load, LoadSettings, "give `push` the LoadSettings that loads_on(wall, load) was given")
    load, elastic, contact = load or LoadSettings(), elastic or ElasticSettings(), contact or ContactSettings()
    _refuse_other_loads(assemblage, analysis, load)
    refuse_bonded_mortar(assemblage, contact.softening_displacement)
    model: ModelName = "micro" if partition.count == stones_of(assemblage) else "macro"
    stepping = stepping or SteppingSettings()
    strict = SolverSettings(elastic, contact, newton or NewtonSettings(), stepping.large_displacement)
    began, expected = perf_counter(), analysis.expected_multiplier
    forces, hinges = analysis.headline.joint_forces, pressed_at_hinges(assemblage, analysis)
    softening, modulus = contact.softening_displacement, elastic.elastic_modulus
    bodies = make_bodies(assemblage, partition, forces, modulus, softening, hinges)
    meshes = mesh_bodies(bodies, mesh or MeshSettings(), None)
    contact_model = _model_of(assemblage, bodies, meshes, load, strict)
    assembled = perf_counter()
    increments: list[Increment] = []
    reported = _reported(increments, report, model, stepping, contact_model)
    loose = loose_of(model, assemblage.wall, bodies, analysis)
    complaint, factorise = follow(
        contact_model, this_rank(), strict.newton, stepping, expected, loose, None, reported, suffices
    )
    ended = perf_counter()
    seconds = {"mesh": meshes.seconds, "assembly": assembled - began - meshes.seconds, "factorise": factorise}
    seconds |= {"contact": ended - assembled - factorise, "total": ended - began}
    kept = (lambda: increments, increments[-1] if increments else None)
    bound = bound_left(assemblage, analysis.loads, bodies)
    return judged(
        model, bodies, contact_model, *kept, stepping, expected, bound, complaint, strict, ranks=1, seconds=seconds
    )


def _reported(
    increments: list[Increment],
    report: Report | None,
    model: ModelName,
    stepping: SteppingSettings,
    contact_model: ContactModel,
) -> Callable[[Increment], None]:
    """Return what keeps an increment in memory, and tells it."""
    begun = perf_counter()

    def keep(increment: Increment) -> None:
        increments.append(increment)
        if report:
            report(progress_of(model, increment, stepping, contact_model, perf_counter() - begun))

    return keep


def _model_of(
    assemblage: Assemblage,
    bodies: Bodies,
    meshes: BodyMeshes,
    load: LoadSettings,
    settings: SolverSettings,
) -> ContactModel:
    """Return the contact model of meshed bodies under a load, on this rank alone."""
    from orchestrator.pushover.model import build_model
    from orchestrator.pushover.solids.nodal_loads import nodal_loads

    loads = nodal_loads(assemblage.wall, bodies, meshes, load)
    return build_model(bodies, meshes, settings.elastic, settings.contact, settings.large_displacement, loads)


def follow(
    contact_model: ContactModel,
    comm: MPI.Comm,
    newton: NewtonSettings,
    stepping: SteppingSettings,
    expected: float,
    loose: BoolArray | None,
    last: Increment | None,
    keep: Callable[[Increment], None],
    suffices: Suffices | None,
) -> tuple[Ended, float]:
    """Follow a path from the increment `last` (None: from the start) and `keep` every increment.

    It ends where a peak has passed that does not suffice. Returns why it ended before `end_of_curve` (None: it did
    not, or there), and the seconds of factorisations.
    """
    from orchestrator.pushover.path.stepping import Pushover
    from orchestrator.pushover.solve.linear_system import LinearSystem

    with LinearSystem(contact_model, comm) as system:
        try:
            for increment in Pushover(contact_model, system, newton, stepping, expected, loose).increments(last):
                keep(increment)
                peak = increment.largest_base_shear / contact_model.horizontal_load
                if suffices and is_past(increment) and not suffices(peak):
                    break
        except (ConvergenceError, CollapseError, HeldError) as error:
            return error, system.seconds
        return None, system.seconds


def judged(
    model: ModelName,
    bodies: Bodies,
    contact_model: ContactModel,
    increments: Callable[[], Iterable[Increment]],
    last: Increment | None,
    stepping: SteppingSettings,
    expected: float,
    bound_without: BoundLeft,
    complaint: Ended,
    settings: SolverSettings,
    *,
    ranks: int,
    seconds: dict[str, float],
) -> Pushed:
    """Fold the increments that were kept (`increments()` yields them in order, up to `last`) into a curve; check it.

    bound_without: asked of what has fallen at the peak, where anything has. Where a curve ends before something went
    far (curve_end.py), what stopped it later is no complaint.
    """
    from orchestrator.pushover.contact.mortar import coarse_toes

    if isinstance(complaint, ConvergenceError):
        complaint = located(model, complaint, last, contact_model, settings)
    last, end = after_gravity(model, last, complaint), stepping.end_of(contact_model.height)
    increments, gone, level = before_it_goes_far(contact_model, increments, stepping)
    complaint = None if gone else complaint
    stopped = gone or str(complaint or end_of_curve(last, stepping, contact_model.height) or NOT_ENOUGH)
    failures, large = [complaint] if isinstance(complaint, ConvergenceError) else [], stepping.large_displacement
    curve = bears_load(model, PushoverCurve.from_increments(increments(), stopped))
    rows = misfits_of(bodies, contact_model, curve, increments()) if large else []
    fits = curve if failures else usable(curve, rows)
    cut_short, curve = is_cut_short(curve, fits), balanced(fits, increments())
    kept = (one for one in increments() if one.number <= curve.step[-1])
    effort = storage.effort_of(kept, contact_model.body_names, contact_model.body_weight)
    capacity, rows = find_capacity(curve), used(rows, curve)
    capacity = replace(capacity, peak_reached=level or (capacity.peak_reached and not cut_short))
    peak = int(curve.static.step[np.argmax(curve.static.base_shear_N)])  # of the static increments
    at_rest, at_peak, at_end = (
        next(one for one in increments() if one.number == number)
        for number in (curve.step[0], peak, curve.static.step[-1])
    )
    capacity, moves = at_the_top(capacity, contact_model, at_rest, at_end)
    bound = None if large else expected * contact_model.horizontal_load
    ended = f"it broke off {place(last)}" if failures else ""
    moment = moment_of_load(contact_model, at_peak)
    after = next((one for one in increments() if one.number == peak + 1), None)
    cracks = coarse_cracks(bodies, contact_model.joint_contacts, at_peak, after, moment, contact_model.height)
    invalid = _invalid(model, curve, first_misfit(rows), effort.energy_error, bound, cracks, ended)
    complaints: tuple[ConvergenceError | ResultError, ...] = (*failures, *([invalid] if invalid else []))
    summary = storage.PushoverSummary(
        model=model, bodies=contact_model.bodies, nodes=len(contact_model.meshes.nodes),
        tetrahedra=len(contact_model.meshes.tetrahedra), contacts=len(contact_model.contacts),
        displacements="large" if large else "small", ranks=ranks,
        **{one.name: getattr(value, one.name) for value in (effort, capacity) for one in fields(value)},
        **largest(rows), seconds=seconds, peak_memory=peak_memory(), stopped_because=curve.stopped_because,
        complaint=str(complaints[0]) if complaints else None,
        valid=invalid is None, not_valid_because=None if invalid is None else invalid.detail,
        toe_error=coarse_toes(bodies, contact_model.joint_contacts, at_peak, moment),
        crack_size=cracks.size, crack_error=cracks.error,
        crushing=bool(np.isfinite(bodies.interfaces.compressive_strength).any()),
        at_peak=wall_at_peak(contact_model, at_peak, bound_without), held=isinstance(complaint, HeldError),
        control_share=moves, spike=spike_of(curve, end),
        snap=farthest_snap(increments(), at_peak, end, partial(part_gone, contact_model, stepping)),
    )  # fmt: skip
    return Pushed(curve, capacity, summary, complaints, cut_short)


def peak_memory() -> int:
    """Return the largest memory this process has had, bytes."""
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def loose_of(model: ModelName, wall: Wall, bodies: Bodies, analysis: LimitAnalysis) -> BoolArray | None:
    """Return the macroblocks (b,) that are stones which limit analysis found to come loose before the wall fails.

    None for micro-FE, the reference, to which limit analysis says nothing of the kind, and so for the same bodies.
    """
    moving = [body.blocks for body in bodies.bodies if not body.fixed]
    if model == "micro" or all(len(blocks) == 1 for blocks in moving):
        return None
    stones = {stone for failure in analysis.local_failures for stone in failure.stones}
    return read_only([stones.issuperset(wall.blocks[block].id for block in blocks) for blocks in moving], np.bool_)


def progress_of(
    model: str, increment: Increment, stepping: SteppingSettings, contact_model: ContactModel, seconds: float
) -> IncrementDone:
    """Return what is reported of an increment."""
    reached = increment.pushed / stepping.end_of(contact_model.height)
    return IncrementDone(model, increment, contact_model.weight, seconds, min(max(reached, 0.0), 1.0))


def _refuse_other_loads(assemblage: Assemblage, analysis: LimitAnalysis, load: LoadSettings) -> None:
    """Raise CaseError for a limit analysis of another wall, or one that was made under other loads."""
    refuse_other_analysis(assemblage, analysis)
    free = np.array([not block.fixed for block in assemblage.wall.blocks])
    arms = np.sqrt(block_areas(assemblage.wall)[free])[:, None] ** np.array([0, 0, 1, 0, 0, 1, 1, 1])
    both = loads_on(assemblage.wall, load), analysis.loads
    pushed, analysed = (np.hstack([loads.dead, loads.live, loads.moments_turned])[free] / arms for loads in both)
    if np.abs(pushed - analysed).sum() > SAME_LOAD * np.abs(pushed).sum():
        remedy = "give `analyse` the loads loads_on(wall, load), and `push` the same load"
        raise CaseError("load", "is not the load of this limit analysis", remedy)


def _invalid(
    model: str,
    curve: PushoverCurve,
    misfits: RowMisfits | None,
    energy_error: float,
    highest: float | None,
    cracks: CoarseCracks,
    broke_off: str,
) -> ResultError | None:
    """Return why a curve is not valid: what `check` finds, or that it broke off."""
    try:
        check_curve(curve, misfits, energy_error, highest)
        if cracks.error > TOO_STRONG:
            long = f"elements are too long where they crack: refine mesh.size, {millimetres(cracks.size)} are enough"
            raise ResultError("bonds", f"{percent_of(cracks.error)} of the peak may be too much, as {long}")
        if broke_off:
            raise ResultError("end of the curve", broke_off)
    except ResultError as error:
        return ResultError(f"{model} FE", f"{error.check}: {error.detail}")
    return None
