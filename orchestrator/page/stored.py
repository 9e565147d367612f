"""A run folder -> the values of its run."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from orchestrator import case as cases
from orchestrator import results
from orchestrator.bodies import Bodies, make_bodies
from orchestrator.case import Case
from orchestrator.errors import CaseError
from orchestrator.joints import Assemblage, find_joints
from orchestrator.limit_analysis import LimitAnalysis
from orchestrator.macroblocks import Partition, one_body_per_block
from orchestrator.meshing import BodyMeshes
from orchestrator.pushover.state import PushoverCurve


@dataclass(frozen=True, eq=False, slots=True)
class StoredModel:
    """One pushover: its name ("macro" or "micro"), entry of the summary, and what its folder holds."""

    name: str
    summary: results.PushoverSummary
    bodies: Bodies
    meshes: BodyMeshes
    contacts: results.ContactPlaces
    store: results.StateStore
    curve: PushoverCurve


@dataclass(frozen=True, eq=False, slots=True)
class StoredRun:
    """A finished run."""

    folder: Path
    summary: results.Summary
    case: Case
    assemblage: Assemblage
    analysis: LimitAnalysis
    partition: Partition
    models: tuple[StoredModel, ...]


def read_run(folder: Path) -> StoredRun:
    """Return the run in a folder. Raises CaseError where none was finished."""
    if not (folder / "summary.json").is_file():
        raise CaseError("", "holds no finished run (no summary.json)", "give the folder that `run` wrote", str(folder))
    case = cases.read(folder / "case.toml")
    try:
        assemblage = find_joints(cases.read_wall(case), case.joints)
        summary = results.read_summary(folder)
        analysis = results.read_limit_analysis(folder)
        partition = results.read_macroblocks(folder, assemblage.wall)
        models = tuple(_model(folder, pushed, assemblage, partition) for pushed in summary.pushover)
    except (OSError, KeyError, ValueError, TypeError) as error:
        problem = f"a file is missing or damaged ({type(error).__name__}: {error})"
        raise CaseError("", problem, "finish the run again, with --resume", str(folder)) from error
    return StoredRun(folder, summary, case, assemblage, analysis, partition, models)


def _model(folder: Path, pushed: results.PushoverSummary, assemblage: Assemblage, partition: Partition) -> StoredModel:
    name = pushed.model
    bodies = make_bodies(assemblage, partition if name == "macro" else one_body_per_block(assemblage))
    store, meshes, contacts = results.read_geometry(folder / name)
    curve = results.read_curve(folder / name, pushed.stopped_because)
    return StoredModel(name, pushed, bodies, meshes, contacts, store, curve)
