"""One pushover in its folder: Bodies -> BodyMeshes -> ContactModel -> Increment ... -> PushoverCurve -> Capacity.

Every increment is stored as it comes, so that a run that was interrupted goes on after its last one.
"""

from __future__ import annotations

import hashlib
import logging
import os
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from orchestrator import storage
from orchestrator.app.at_peak import BoundLeft, bound_left
from orchestrator.app.broken_off import SolverSettings
from orchestrator.app.curve_end import Suffices
from orchestrator.app.progress import IncrementDone, Report, StageBegun, StageDone
from orchestrator.app.pushed import Ended, Pushed, follow, judged, loose_of, peak_memory, progress_of
from orchestrator.basis.errors import CaseError, naming
from orchestrator.basis.parallel import on_root, this_rank
from orchestrator.limit_analysis import LimitAnalysis
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.ties import with_ties
from orchestrator.masonry.wall import Wall
from orchestrator.pushover.estimate import Estimate, estimate, free_memory, time_in_words, warning_of
from orchestrator.pushover.increments import Increment, end_of_curve
from orchestrator.pushover.meshing import BodyMeshes, mesh_bodies
from orchestrator.settings.case import Case, ModelName
from orchestrator.storage.identity import identity
from orchestrator.storage.mesh_files import write_mesh

if TYPE_CHECKING:
    from mpi4py import MPI

    from orchestrator.pushover.model import ContactModel
    from orchestrator.pushover.solids.nodal_loads import NodalLoads
    from orchestrator.pushover.solids.tie_bars import TieBars

logger = logging.getLogger(__name__)


def push_model(
    model: ModelName,
    case: Case,
    assemblage: Assemblage,
    bodies: Bodies,
    folder: Path,
    resume: bool,
    comm: MPI.Comm | None,
    report: Report,
    analysis: LimitAnalysis,
    same: Path | None = None,
    suffices: Suffices | None = None,
) -> Pushed:
    """Mesh the bodies of one model and push them, on rank 0 or, if they are many, on all ranks.

    analysis: its associative load multiplier is the measure of load increments, and macroblocks have the stones that
    come loose as bodies of their own. Results go into `folder`; with `resume` the pushover goes on after the last
    increment stored there, without any after those in `same`, the folder of a model with the same bodies. suffices: as
    in `push`. Raises CaseError for what does not fit into the memory, ConvergenceError for a pushover without a curve.
    """
    from orchestrator.pushover.solids.nodal_loads import nodal_loads
    from orchestrator.pushover.solids.tie_bars import find_ties

    start_finite_elements()
    size, warning = on_root(comm, room_for, bodies, case)
    logger.info("expected: %s %s", size, warning)
    said = "; ".join(filter(None, (f"{size}, {time_in_words(size)}", warning)))
    report(StageDone(f"{model} FE, before it starts", 0.0, said))
    report(StageBegun(f"{model} FE", "meshes, contacts and matrices"))
    meshes, wall = on_root(comm, _meshed, bodies, case, folder), assemblage.wall
    bound = bound_left(with_ties(assemblage, case.reinforcement.ties), analysis.loads, bodies)
    loads = nodal_loads(wall, bodies, meshes, case.load)
    ties = find_ties(wall, bodies, meshes, case.reinforcement.ties)
    arguments = (model, case, wall, bodies, meshes, loads, ties, folder, resume, analysis, bound, same, suffices)
    if size.unknowns > case.newton.distribute_above:
        return _follow(*arguments, comm, report)
    return on_root(comm, _follow, *arguments, None, report)


def refuse_own_input(case: Case, output: Path) -> None:
    """Raise CaseError where a run would write its case.toml or blocks.json over a file that it is given."""
    storage.refuse_input((output / "case.toml", output / "blocks.json"), (case.file, case.block_file))


def room_for(bodies: Bodies, case: Case) -> tuple[Estimate, str]:
    """Return what the finite elements of bodies need, and a warning where that is much, or "". Raises CaseError where
    it does not fit into the memory."""
    expected = estimate(bodies, case.mesh, case.elastic.element_order)
    with naming(case.file):
        return expected, warning_of(expected, free_memory())


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
    wall: Wall,
    bodies: Bodies,
    meshes: BodyMeshes,
    loads: NodalLoads,
    ties: TieBars | None,
    folder: Path,
    resume: bool,
    analysis: LimitAnalysis,
    bound: BoundLeft,
    same: Path | None,
    suffices: Suffices | None,
    comm: MPI.Comm | None,
    report: Report,
) -> Pushed:
    """Follow the curve of one model on `comm` (None: this rank alone), storing every increment."""
    from orchestrator.pushover.model import build_model

    working, stepping = comm or this_rank(), case.stepping
    expected, loose = analysis.expected_multiplier, loose_of(model, wall, bodies, analysis)
    store = storage.StateStore(folder, _fingerprint(case, wall, bodies, meshes), storage.IN_MEMORY)
    last = on_root(comm, _opened, store, resume, same)
    began = perf_counter()
    large = case.stepping.large_displacement
    contact_model = build_model(bodies, meshes, case.elastic, case.contact, large, loads, ties)
    assembled = perf_counter()

    def keep(increment: Increment) -> None:
        on_root(comm, store.append, increment)
        report(_told(progress_of(model, increment, stepping, contact_model, perf_counter() - assembled)))

    complaint, factorise = follow(contact_model, working, case.newton, stepping, expected, loose, last, keep, suffices)
    ended = perf_counter()
    seconds = {"mesh": meshes.seconds, "assembly": assembled - began, "factorise": factorise}
    seconds |= {"contact": ended - assembled - factorise, "total": meshes.seconds + ended - began}
    report(StageBegun(f"{model} FE", "checks, ParaView files and pictures"))
    return on_root(
        comm,
        _folded,
        model,
        case,
        wall,
        bodies,
        contact_model,
        store,
        expected,
        bound,
        complaint,
        working.size,
        seconds,
    )


def _told(done: IncrementDone) -> IncrementDone:
    """Write an increment into run.log; return it."""
    model, increment = done.model, done.increment
    logger.info(
        "%s %d %s: multiplier %.5f, control displacement %.4g mm, %d iterations",
        model, increment.number, increment.phase, increment.load_multiplier,
        1e3 * increment.control_displacement, increment.iterations,
    )  # fmt: skip
    for attempt in increment.attempts:
        logger.info("%s %d: %s (tried %.3g): %s", model, increment.number, attempt.cause, attempt.tried, attempt.action)
    return done


def last_state(case: Case, wall: Wall, bodies: Bodies, folder: Path) -> tuple[BodyMeshes, Increment | None]:
    """Return the meshes and the last increment that `push_model` has left in a model's folder."""
    meshes, store = _left(case, wall, bodies, folder)
    return meshes, store.last()


def refuse_longer_curve(case: Case, wall: Wall, bodies: Bodies, folder: Path) -> None:
    """Raise CaseError where `push_model` has left a curve that goes on beyond where the case ends it."""
    meshes, store = _left(case, wall, bodies, folder)
    height = float(np.ptp(meshes.nodes[:, 1]))
    *before, last = store.numbers() or [0]
    for one in store.these(before):
        ends = None if one.phase == "gravity" else end_of_curve(one, case.stepping, height)
        if ends:
            problem = f"would end the curve in {folder} at increment {one.number}, and it has {last}: {ends}"
            remedy = "let final_displacement, final_drop or largest_increments end it no earlier, or leave out --resume"
            raise CaseError("stepping", problem, remedy, str(case.file))


def _left(case: Case, wall: Wall, bodies: Bodies, folder: Path) -> tuple[BodyMeshes, storage.StateStore]:
    """Return the meshes of bodies, and what a model's folder holds of them."""
    meshes = mesh_bodies(bodies, case.mesh, mesh_cache())
    return meshes, storage.StateStore(folder, _fingerprint(case, wall, bodies, meshes))


def start_finite_elements() -> None:
    """Import the finite elements: PETSc starts collectively, so all ranks call this together."""
    from orchestrator.pushover import model  # noqa: F401
    from orchestrator.pushover.solve import linear_system  # noqa: F401


def _opened(store: storage.StateStore, resume: bool, same: Path | None) -> Increment | None:
    """Return the increment to go on from; without `resume` earlier results of this model are cleared.

    same: a folder whose increments are those of this model too, and are taken over where it has none.
    """
    (store.folder / "curve.csv").unlink(missing_ok=True)
    if not resume:
        store.clear()
    if same is not None and not store.numbers():
        for increment in storage.StateStore(same, store.fingerprint).increments():
            store.append(increment)
        logger.info("the bodies are those in %s: its increments are taken over", same)
    last = store.last()
    if resume:
        logger.info("resumed after increment %d", last.number if last else 0)
    return last


def _fingerprint(case: Case, wall: Wall, bodies: Bodies, meshes: BodyMeshes) -> str:
    """Return hashes of everything that an increment depends on: identity of the run; bodies, and their meshes."""
    total = hashlib.sha256()
    for array in (meshes.nodes, meshes.tetrahedra, bodies.interfaces.start, bodies.interfaces.end):
        total.update(array.tobytes())
    total.update(repr([body.parts for body in bodies.bodies]).encode())
    return f"{identity(case, wall)} {total.hexdigest()}"


def _folded(
    model: ModelName,
    case: Case,
    wall: Wall,
    bodies: Bodies,
    contact_model: ContactModel,
    store: storage.StateStore,
    expected: float,
    bound: BoundLeft,
    complaint: Ended,
    ranks: int,
    seconds: dict[str, float],
) -> Pushed:
    """Fold and check the stored increments; write curve, pictures and ParaView files."""
    from orchestrator.present import report as reporting

    kept, stepping = (store.increments, store.last()), case.stepping
    strict = SolverSettings(case.elastic, case.contact, case.newton, case.stepping.large_displacement)
    done = judged(
        model, bodies, contact_model, *kept, stepping, expected, bound, complaint, strict, ranks=ranks, seconds=seconds
    )
    reporting.write_pushover(store, case, model, wall, bodies, contact_model, done.curve, done.summary.valid)
    storage.write_ties(store.folder, store.increments(), len(contact_model.ties or ()))
    return replace(done, summary=replace(done.summary, peak_memory=peak_memory()))
