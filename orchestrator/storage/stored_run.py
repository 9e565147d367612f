"""A run folder -> the values of its run."""

from __future__ import annotations

from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path

from orchestrator import storage
from orchestrator.basis.errors import CaseError
from orchestrator.limit_analysis import LimitAnalysis
from orchestrator.macroblocks.bodies import Bodies, make_bodies
from orchestrator.macroblocks.criteria import Partition, one_body_per_block
from orchestrator.masonry.joints import Assemblage, find_joints, fingerprint_of_places, fingerprint_of_wall
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.masonry.ties import with_ties
from orchestrator.pushover.increments import PushoverCurve
from orchestrator.pushover.meshing import BodyMeshes
from orchestrator.settings import case as cases
from orchestrator.settings.case import Case


@dataclass(frozen=True, eq=False, slots=True)
class StoredModel:
    """One pushover: its name ("macro" or "micro"), entry of the summary, and what its folder holds."""

    name: str
    summary: storage.PushoverSummary
    bodies: Bodies
    meshes: BodyMeshes
    contacts: storage.ContactPlaces
    store: storage.StateStore
    curve: PushoverCurve


@dataclass(frozen=True, eq=False, slots=True)
class StoredRun:
    """A finished run."""

    folder: Path
    summary: storage.Summary
    case: Case
    assemblage: Assemblage
    analysis: LimitAnalysis
    partition: Partition
    models: tuple[StoredModel, ...]


def read_run(folder: str | PathLike[str]) -> StoredRun:
    """Return the run in a folder. Raises CaseError where none was finished."""
    folder = Path(folder)
    if not (folder / "summary.json").is_file():
        raise CaseError("", "holds no finished run (no summary.json)", "give the folder that `run` wrote", str(folder))
    case = cases.read(folder / "case.toml")
    try:
        name = read_blocks(case.block_file).name  # what the run drew it with: the case's, or the block file's own
        assemblage = find_joints(replace(cases.read_wall(case), name=name), case.joints)
        summary = storage.read_summary(folder)
        tied = with_ties(assemblage, case.reinforcement.ties)
        analysis = replace(storage.read_limit_analysis(folder), wall=fingerprint_of_wall(tied))
        partition = storage.read_macroblocks(folder, assemblage.wall)
        partition = replace(partition, places=fingerprint_of_places(assemblage))
        models = tuple(_model(folder, pushed, assemblage, partition) for pushed in summary.pushover)
    except (OSError, KeyError, ValueError, TypeError) as error:
        problem = f"a file is missing, damaged or from another version ({type(error).__name__}: {error})"
        raise CaseError("", problem, "finish the run with --resume, or run the case again", str(folder)) from error
    return StoredRun(folder, summary, case, assemblage, analysis, partition, models)


def _model(folder: Path, pushed: storage.PushoverSummary, assemblage: Assemblage, partition: Partition) -> StoredModel:
    name = pushed.model
    bodies = make_bodies(assemblage, partition if name == "macro" else one_body_per_block(assemblage))
    store, meshes, contacts = storage.read_geometry(folder / name)
    curve = storage.read_curve(folder / name, pushed.stopped_because)
    return StoredModel(name, pushed, bodies, meshes, contacts, store, curve)
