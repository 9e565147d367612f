"""The chain, written out once: what each command runs, in order.

Case -> Wall -> Assemblage -> LimitAnalysis -> Partition -> Bodies -> BodyMeshes -> ContactModel -> Increment ... ->
PushoverCurve -> Capacity -> run folder. Every stage is a function of the values before it; only this module knows all.

Under MPI rank 0 does everything, but all ranks share a pushover of more than newton.distribute_above unknowns.
"""

from __future__ import annotations

import hashlib
import logging
import os
import resource
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

from orchestrator import results
from orchestrator.automatic import macroblocks_of
from orchestrator.bodies import Bodies, make_bodies
from orchestrator.capacity import Capacity, find_capacity
from orchestrator.case import Case, ModelName, read_wall, refuse_spectrum, refuse_what_only_limit_analysis_takes
from orchestrator.errors import CaseError, CollapseError, ConvergenceError, ResultError, naming
from orchestrator.estimate import Estimate, estimate, free_memory, time_in_words, warning_of
from orchestrator.joints import Assemblage, check_assemblage, find_joints
from orchestrator.limit_analysis import LimitAnalysis, LimitState, analyse, loads_on, settle
from orchestrator.macroblocks import Partition, one_body_per_block
from orchestrator.masonry.drawing import implausible, refuse_implausible_size
from orchestrator.masonry.wall import Wall, check_wall
from orchestrator.meshing import BodyMeshes, mesh_bodies, write_mesh
from orchestrator.parallel import is_root, on_root, on_root_while, this_rank
from orchestrator.pushover.state import Increment, PushoverCurve

if TYPE_CHECKING:
    from mpi4py import MPI

    from orchestrator.pushover.model import ContactModel
    from orchestrator.pushover.nodal_loads import NodalLoads
    from orchestrator.seismic import EquivalentSystem

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class StageDone:
    """A stage is done: its name, what it cost in s, its result in a few words."""

    stage: str
    seconds: float
    text: str


@dataclass(frozen=True, slots=True)
class IncrementDone:
    """One converged increment of a pushover; `fraction` of the final displacement that is reached."""

    model: str
    increment: Increment
    weight: float
    seconds: float
    fraction: float


Report = Callable[[StageDone | IncrementDone], None]


@dataclass(frozen=True, eq=False, slots=True)
class Segmented:
    """Everything before the finite elements."""

    assemblage: Assemblage
    analysis: LimitAnalysis
    partition: Partition
    bodies: Bodies


@dataclass(frozen=True, eq=False, slots=True)
class Pushed:
    """One finished pushover. `complaints`: why the curve ended early, and why it is not valid; none of a good one."""

    curve: PushoverCurve
    capacity: Capacity
    system: EquivalentSystem
    summary: dict[str, Any]
    complaints: tuple[ConvergenceError | ResultError, ...]


@dataclass(frozen=True, eq=False, slots=True)
class Outcome:
    """What a run leaves: the summary as written, and the complaints of its pushovers."""

    summary: dict[str, Any]
    complaints: tuple[ConvergenceError | ResultError, ...]


def check(case: Case) -> Assemblage:
    """Read the wall, find its joints, and refuse what cannot be analysed (CaseError)."""
    wall = read_wall(case)
    try:
        check_wall(wall, case.joints.tolerance)
        assemblage = find_joints(wall, case.joints)
        check_assemblage(assemblage)
    except CaseError as error:
        raise error.in_file(str(case.file if error.key.startswith("joints.") else case.block_file)) from None
    return assemblage


def refuse_size(case: Case, wall: Wall) -> None:
    """Raise CaseError for a wall that is too large to be one, before its pushover is begun."""
    with naming(case.block_file):
        refuse_implausible_size(wall)


def _refuse_own_input(case: Case, output: Path) -> None:
    """Raise CaseError where a run would write its case.toml or blocks.json over the file that it is given."""
    for given, name in ((case.file, "case.toml"), (case.block_file, "blocks.json")):
        if (output / name).exists() and (output / name).samefile(given):
            problem = "is what this run is given, and would be overwritten"
            raise CaseError("", problem, "give another folder with --output", str(output / name))


def limit(case: Case) -> tuple[Assemblage, LimitAnalysis]:
    """Run micro limit analysis on a checked wall. Raises CaseError for a wall that cannot stand."""
    assemblage = check(case)
    with naming(case.file):
        loads = loads_on(assemblage.wall, case.load)
    with naming(case.block_file):
        return assemblage, analyse(assemblage, case.limit_analysis, case.load.sign, loads)


def draw_mechanism(case: Case, assemblage: Assemblage, analysis: LimitAnalysis, output: Path) -> Path:
    """Draw the mechanism into the run folder `output`; return its PNG."""
    from orchestrator import report as reporting

    return reporting.write_mechanism(output / "figures", case, assemblage, analysis)[0]


def settlement(case: Case, support: int, angle: float, output: Path) -> tuple[LimitState, Path]:
    """Let a support give way at `angle` (rad from +x); draw and return the state. Raises CaseError."""
    from orchestrator import report as reporting

    assemblage = check(case)
    with naming(case.file):
        state = settle(assemblage, support, angle, loads_on(assemblage.wall, case.load))
    return state, reporting.write_settlement(output / "figures", assemblage, state, angle)[0]


def segment(case: Case) -> Segmented:
    """Run everything before the finite elements."""
    assemblage, analysis = limit(case)
    with naming(case.file):
        loads = loads_on(assemblage.wall, case.load)
        partition = macroblocks_of(assemblage, analysis, case.macroblocks, loads)
    return Segmented(assemblage, analysis, partition, make_bodies(assemblage, partition))


def run(case: Case, output: Path, resume: bool, comm: MPI.Comm | None, report: Report) -> Outcome:
    """Run the whole chain into the folder `output`; the same outcome on every rank.

    With `resume` a pushover goes on after its last stored increment. Raises CaseError before anything is written.
    """
    began = perf_counter()
    on_root(comm, refuse_what_only_limit_analysis_takes, case)
    on_root(comm, refuse_spectrum, case)
    segmented = on_root(comm, segment, case)
    on_root(comm, refuse_size, case, segmented.assemblage.wall)
    on_root(comm, _refuse_own_input, case, output)
    report(StageDone("micro-LA and macroblocks", perf_counter() - began, _words(segmented)))
    return push(case, segmented, output, resume, comm, report)


def push(
    case: Case, segmented: Segmented, output: Path, resume: bool, comm: MPI.Comm | None, report: Report
) -> Outcome:
    """Run the finite elements of a segmented wall into the folder `output`; else as `run`."""
    from orchestrator import report as reporting  # pictures cost 0.2 s that check, limit and segment need not wait for

    with on_root_while(comm, results.locked(output), results.logging_to(output / "run.log")):
        on_root(comm, results.sweep, output)
        on_root(
            comm,
            reporting.write_segmentation,
            output, case, segmented.assemblage, segmented.analysis, segmented.partition, segmented.bodies,
        )  # fmt: skip
        if is_root(comm):
            for line in results.provenance((case.file, case.block_file)):
                logger.info(line)
            logger.info("settings as run: %s", output / "case.toml")
            logger.info("micro-LA and macroblocks: %s", _words(segmented))
        pushed: dict[ModelName, Pushed] = {}
        for model in dict.fromkeys(case.run.models):
            began = perf_counter()
            pushed[model] = _push(model, case, segmented, output, resume, comm, report)
            report(StageDone(f"{model} FE", perf_counter() - began, pushed[model].curve.stopped_because))
        outcome = on_root(comm, _finished, case, segmented, pushed, output)
        for model, done in pushed.items():
            peak, stopped = done.capacity.peak_base_shear, done.curve.stopped_because
            logger.info("%s: peak base shear %.6g N; %s", model, peak, stopped)
        for complaint in outcome.complaints:
            logger.error("%s", complaint)
        logger.info("finished: %s", output / "summary.json")
        return outcome


def rebuild_report(run_folder: Path) -> Path:
    """Draw the pictures of a finished run again and write report.html, from stored results alone; return its path."""
    from orchestrator import report as reporting

    return reporting.rebuild(run_folder)


def _finished(case: Case, segmented: Segmented, pushed: dict[ModelName, Pushed], output: Path) -> Outcome:
    from orchestrator import report as reporting

    summary = reporting.write_summary(
        output,
        case,
        segmented.assemblage,
        segmented.analysis,
        segmented.partition,
        {model: (done.curve, done.capacity) for model, done in pushed.items()},
        {model: done.system for model, done in pushed.items()},
        [done.summary for done in pushed.values()],
    )
    return Outcome(summary, tuple(complaint for done in pushed.values() for complaint in done.complaints))


def _words(segmented: Segmented) -> str:
    analysis, partition = segmented.analysis, segmented.partition
    bodies = "1 macroblock" if partition.count == 1 else f"{partition.count} macroblocks"
    found = f"multiplier {analysis.headline.load_multiplier:.4f}, {bodies}"
    return "; ".join([found, *analysis.remarks, *partition.remarks, *implausible(segmented.assemblage.wall)])


def _push(
    model: ModelName,
    case: Case,
    segmented: Segmented,
    output: Path,
    resume: bool,
    comm: MPI.Comm | None,
    report: Report,
) -> Pushed:
    """Mesh one partition and push it, on rank 0 or on all ranks."""
    from orchestrator.pushover.contact_search import find_contacts
    from orchestrator.pushover.nodal_loads import nodal_loads

    start_finite_elements()

    assemblage = segmented.assemblage
    bodies = segmented.bodies if model == "macro" else make_bodies(assemblage, one_body_per_block(assemblage))
    expected = estimate(bodies, case.mesh, case.elastic.element_order)
    warning = on_root(comm, _room_for, expected, case)
    said = "; ".join(filter(None, (f"{expected}, {time_in_words(expected)}", warning)))
    report(StageDone(f"{model} FE, before it starts", 0.0, said))
    meshes = on_root(comm, _meshed, bodies, case, output / model)
    loads = nodal_loads(assemblage.wall, bodies, meshes, case.load)
    arguments = (model, case, bodies, meshes, loads, output / model, resume)
    unknowns = 3 * len(meshes.nodes) + len(find_contacts(bodies, meshes))
    if unknowns > case.newton.distribute_above:
        return _follow(*arguments, comm, report)
    return on_root(comm, _follow, *arguments, None, report)


def _room_for(expected: Estimate, case: Case) -> str:
    """Return a warning about a large run, or "". Raises CaseError for one that does not fit into the memory."""
    with naming(case.file):
        warning = warning_of(expected, free_memory())
    logger.info("expected: %s %s", expected, warning)
    return warning


def _meshed(bodies: Bodies, case: Case, folder: Path) -> BodyMeshes:
    meshes = mesh_bodies(bodies, case.mesh, mesh_cache())
    for name in ("mesh.msh", "mesh.vtu"):
        write_mesh(meshes, folder / name)
    return meshes


def mesh_cache() -> Path:
    """Return the folder where meshes are kept between runs."""
    return Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "orchestrator" / "meshes"


def _follow(
    model: ModelName,
    case: Case,
    bodies: Bodies,
    meshes: BodyMeshes,
    loads: NodalLoads,
    folder: Path,
    resume: bool,
    comm: MPI.Comm | None,
    report: Report,
) -> Pushed:
    """Follow the curve of one model on `comm` (None: this rank alone), storing every increment."""
    from orchestrator.pushover.linear_system import LinearSystem
    from orchestrator.pushover.model import build_model
    from orchestrator.pushover.stepping import Pushover

    working = comm or this_rank()
    store = results.StateStore(folder, _fingerprint(case, bodies, meshes))
    last = on_root(comm, _opened, store, resume)
    began = perf_counter()
    large = case.stepping.large_displacement
    contact_model = build_model(bodies, meshes, case.elastic, case.contact, case.load.sign, working, large, loads)
    assembled = perf_counter()
    complaint: ConvergenceError | CollapseError | None = None
    with LinearSystem(contact_model, working) as system:
        pushover = Pushover(contact_model, system, case.newton, case.stepping)
        try:
            for increment in pushover.increments(last):
                on_root(comm, store.append, increment)
                report(_progress(model, increment, case, contact_model.weight, perf_counter() - assembled))
        except (ConvergenceError, CollapseError) as error:
            complaint = error
        seconds = {"assembly": assembled - began, "factorise": system.seconds}
    seconds |= {"mesh": meshes.seconds, "contact": perf_counter() - assembled - system.seconds}
    seconds["total"] = meshes.seconds + perf_counter() - began
    return on_root(comm, _folded, model, case, bodies, contact_model, store, complaint, working.size, seconds)


def _progress(model: str, increment: Increment, case: Case, weight: float, seconds: float) -> IncrementDone:
    reached = increment.control_displacement / case.stepping.final_displacement
    logger.info(
        "%s %d %s: multiplier %.5f, control displacement %.4g mm, %d iterations",
        model, increment.number, increment.phase, increment.load_multiplier,
        1e3 * increment.control_displacement, increment.iterations,
    )  # fmt: skip
    for attempt in increment.attempts:
        logger.info("%s %d: %s (tried %.3g): %s", model, increment.number, attempt.cause, attempt.tried, attempt.action)
    return IncrementDone(model, increment, weight, seconds, min(max(reached, 0.0), 1.0))


def last_state(case: Case, bodies: Bodies, folder: Path) -> tuple[BodyMeshes, Increment | None]:
    """Return the meshes and the last increment that `push` has left in a model's folder."""
    meshes = mesh_bodies(bodies, case.mesh, mesh_cache())
    return meshes, results.StateStore(folder, _fingerprint(case, bodies, meshes)).last()


def start_finite_elements() -> None:
    """Import the finite elements: PETSc starts collectively, so all ranks call this together."""
    from orchestrator.pushover import linear_system, model  # noqa: F401


def _opened(store: results.StateStore, resume: bool) -> Increment | None:
    """Return the increment to go on from; without `resume` earlier results of this model are cleared."""
    (store.folder / "curve.csv").unlink(missing_ok=True)
    if not resume:
        store.clear()
        return None
    last = store.last()
    logger.info("resumed after increment %d", last.number if last else 0)
    return last


def _fingerprint(case: Case, bodies: Bodies, meshes: BodyMeshes) -> str:
    """Return a hash of everything that an increment depends on, except how far the curve is followed."""
    stepping = replace(case.stepping, final_displacement=1.0, final_drop=1.0, largest_increments=1)
    settings = (case.elastic, case.contact, case.newton, stepping, case.load, bodies.thickness)
    total = hashlib.sha256(repr(settings).encode())
    for array in (meshes.nodes, meshes.tetrahedra, meshes.unit_weight, bodies.start, bodies.end, bodies.friction):
        total.update(array.tobytes())
    total.update(repr([body.parts for body in bodies.bodies]).encode())
    for strength in (bodies.cohesion, bodies.tensile_strength):
        total.update(strength.tobytes())
    return total.hexdigest()


def _folded(
    model: ModelName,
    case: Case,
    bodies: Bodies,
    contact_model: ContactModel,
    store: results.StateStore,
    complaint: ConvergenceError | CollapseError | None,
    ranks: int,
    seconds: dict[str, float],
) -> Pushed:
    """Fold the stored increments into curve, capacity, pictures and ParaView files; check the result."""
    from orchestrator import report as reporting
    from orchestrator.pushover.stepping import end_of_curve
    from orchestrator.verification import elastic_step, equivalent_system_of

    last = store.last()
    if isinstance(complaint, ConvergenceError):
        complaint = _located(model, complaint, last)
    if last is None or last.phase == "gravity":
        raise complaint if isinstance(complaint, ConvergenceError) else ConvergenceError(f"{model} FE", str(complaint))
    stopped = str(complaint or end_of_curve(last, case.stepping))
    curve = PushoverCurve.from_increments(store.increments(), stopped)
    effort = results.effort_of(store.increments())
    capacity = find_capacity(curve, contact_model.horizontal_load)
    failures = [complaint] if isinstance(complaint, ConvergenceError) else []
    invalid = _check(model, curve, effort, contact_model.horizontal_load)
    reporting.write_pushover(store, model, bodies, contact_model, curve, invalid is None)
    complaints: tuple[ConvergenceError | ResultError, ...] = (*failures, *([invalid] if invalid else []))
    return Pushed(
        curve=curve,
        capacity=capacity,
        system=equivalent_system_of(contact_model, store.read(int(curve.step[0])), store.read(elastic_step(curve))),
        summary=results.pushover_summary(
            model,
            contact_model.meshes,
            len(contact_model.contacts),
            effort,
            capacity,
            stopped,
            large_displacement=case.stepping.large_displacement,
            ranks=ranks,
            seconds=seconds,
            peak_memory=1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss,
            complaint=str(complaints[0]) if complaints else None,
            not_valid_because=None if invalid is None else invalid.detail,
        ),
        complaints=complaints,
    )


def _located(model: str, error: ConvergenceError, last: Increment | None) -> ConvergenceError:
    """Return the error with the model and the last good increment in its text."""
    place = "before any increment"
    if last is not None:
        moved = f"{1e3 * last.control_displacement:.4g} mm, multiplier {last.load_multiplier:.4f}"
        place = f"after increment {last.number} ({last.phase}, {moved})"
    return ConvergenceError(f"{model} FE", f"stopped {place}: {error}", error.iterations)


def _check(model: str, curve: PushoverCurve, effort: results.Effort, weight: float) -> ResultError | None:
    from orchestrator.pushover.checks import check as check_curve

    try:
        check_curve(curve, effort.max_penetration, effort.energy_error, weight)
    except ResultError as error:
        return ResultError(f"{model} FE", f"{error.check}: {error.detail}")
    return None
