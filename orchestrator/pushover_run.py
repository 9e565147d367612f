"""One pushover in its folder: Bodies -> BodyMeshes -> ContactModel -> Increment ... -> PushoverCurve -> Capacity.

Every increment is stored as it comes, so that a run that was interrupted goes on after its last one.
"""

from __future__ import annotations

import hashlib
import logging
import os
import resource
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

from orchestrator import results
from orchestrator.bodies import Bodies
from orchestrator.capacity import Capacity, find_capacity
from orchestrator.case import Case, ModelName
from orchestrator.errors import CollapseError, ConvergenceError, ResultError, naming
from orchestrator.estimate import Estimate, estimate, free_memory, time_in_words, warning_of
from orchestrator.masonry.wall import Wall
from orchestrator.meshing import BodyMeshes, mesh_bodies, write_mesh
from orchestrator.parallel import on_root, this_rank
from orchestrator.progress import IncrementDone, Report, StageDone
from orchestrator.pushover.state import Increment, PushoverCurve

if TYPE_CHECKING:
    from mpi4py import MPI

    from orchestrator.pushover.model import ContactModel
    from orchestrator.pushover.nodal_loads import NodalLoads
    from orchestrator.pushover.settings import SteppingSettings

logger = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False, slots=True)
class Pushed:
    """One finished pushover. `complaints`: why the curve ended early, and why it is not valid; none of a good one."""

    curve: PushoverCurve
    capacity: Capacity
    summary: dict[str, Any]
    complaints: tuple[ConvergenceError | ResultError, ...]


def push_model(
    model: ModelName,
    case: Case,
    wall: Wall,
    bodies: Bodies,
    folder: Path,
    resume: bool,
    comm: MPI.Comm | None,
    report: Report,
    expected: float,
) -> Pushed:
    """Mesh the bodies of one model and push them, on rank 0 or, if they are many, on all ranks.

    expected: associative load multiplier of limit analysis, the measure of load increments. Results go into `folder`;
    with `resume` the pushover goes on after the last increment stored there. Raises CaseError
    for what does not fit into the memory, ConvergenceError for a pushover without a curve.
    """
    from orchestrator.pushover.contact_search import find_contacts
    from orchestrator.pushover.nodal_loads import nodal_loads

    start_finite_elements()
    size = estimate(bodies, case.mesh, case.elastic.element_order)
    warning = on_root(comm, _room_for, size, case)
    said = "; ".join(filter(None, (f"{size}, {time_in_words(size)}", warning)))
    report(StageDone(f"{model} FE, before it starts", 0.0, said))
    meshes = on_root(comm, _meshed, bodies, case, folder)
    loads = nodal_loads(wall, bodies, meshes, case.load)
    arguments = (model, case, bodies, meshes, loads, folder, resume, expected)
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
    expected: float,
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
        pushover = Pushover(contact_model, system, case.newton, _stepping(model, case), expected)
        try:
            for increment in pushover.increments(last):
                on_root(comm, store.append, increment)
                report(_progress(model, increment, case, contact_model.weight, perf_counter() - assembled))
        except (ConvergenceError, CollapseError) as error:
            complaint = error
        seconds = {"assembly": assembled - began, "factorise": system.seconds}
    seconds |= {"mesh": meshes.seconds, "contact": perf_counter() - assembled - system.seconds}
    seconds["total"] = meshes.seconds + perf_counter() - began
    return on_root(comm, _folded, model, case, bodies, contact_model, store, complaint, expected, working.size, seconds)


def _stepping(model: ModelName, case: Case) -> SteppingSettings:
    """Return how a path is followed: macroblocks are those of one mechanism, and know no other once it has fallen."""
    return case.stepping if model == "micro" else replace(case.stepping, local_share=0.0)


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
    """Return the meshes and the last increment that `push_model` has left in a model's folder."""
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
    expected: float,
    ranks: int,
    seconds: dict[str, float],
) -> Pushed:
    """Fold the stored increments into curve, capacity, pictures and ParaView files; check the result."""
    from orchestrator import report as reporting
    from orchestrator.pushover.overlap import largest_overlap
    from orchestrator.pushover.stepping import end_of_curve

    last = store.last()
    if isinstance(complaint, ConvergenceError):
        complaint = _located(model, complaint, last)
    if last is None or last.phase == "gravity":
        raise complaint if isinstance(complaint, ConvergenceError) else ConvergenceError(f"{model} FE", str(complaint))
    stopped = str(complaint or end_of_curve(last, case.stepping))
    curve = PushoverCurve.from_increments(store.increments(), stopped)
    effort = results.effort_of(store.increments(), contact_model.body_names, contact_model.body_mass)
    capacity = find_capacity(curve)
    failures = [complaint] if isinstance(complaint, ConvergenceError) else []
    large = case.stepping.large_displacement
    overlap = largest_overlap(bodies, contact_model.meshes, last.displacement, last.fallen) if large else (0.0, 0.0)
    highest = None if large else expected * contact_model.horizontal_load
    invalid = _check(model, curve, overlap[1], effort.energy_error, highest, failures)
    reporting.write_pushover(store, model, bodies, contact_model, curve, invalid is None)
    complaints: tuple[ConvergenceError | ResultError, ...] = (*failures, *([invalid] if invalid else []))
    return Pushed(
        curve=curve,
        capacity=capacity,
        summary=results.pushover_summary(
            model,
            contact_model.meshes,
            len(contact_model.contacts),
            effort,
            capacity,
            stopped,
            overlap=overlap,
            large_displacement=large,
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


def _check(
    model: str,
    curve: PushoverCurve,
    overlap: float,
    energy_error: float,
    highest: float | None,
    failures: list[ConvergenceError],
) -> ResultError | None:
    """Return why a curve is not valid: what `check` finds, or that it broke off."""
    from orchestrator.pushover.checks import check as check_curve

    try:
        check_curve(curve, overlap, energy_error, highest)
        if failures:
            raise ResultError("end of the curve", f"it broke off: {failures[0].where}")
    except ResultError as error:
        return ResultError(f"{model} FE", f"{error.check}: {error.detail}")
    return None
