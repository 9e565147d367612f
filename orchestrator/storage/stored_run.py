"""A run folder -> the values of its run."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any

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
from orchestrator.storage.files import hash_file, missing, plain
from orchestrator.storage.parts import refuse_other_parts


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


NOT_RUN_WITH = ("project", "seismic", "sensitivity", "study")
"""sections that a run's results do not depend on: they may be changed before its report is written again"""


def read_run(folder: str | PathLike[str]) -> StoredRun:
    """Return the run in a folder. Raises CaseError where none was finished, or case or blocks are not as they were run
    (but for NOT_RUN_WITH)."""
    folder = Path(folder)
    case, summary = read_checked(folder)
    with telling_damage(folder):
        name = read_blocks(case.block_file).name  # what the run drew it with: the case's, or the block file's own
        assemblage = find_joints(replace(cases.read_wall(case), name=name), case.joints)
        tied = with_ties(assemblage, case.reinforcement.ties)
        analysis = replace(storage.read_limit_analysis(folder), wall=fingerprint_of_wall(tied))
        if len(analysis.headline.tie_forces) != len(case.reinforcement.ties):
            raise ValueError("limit_analysis.json has other ties than the case")
        partition = storage.read_macroblocks(folder, assemblage.wall)
        partition = replace(partition, places=fingerprint_of_places(assemblage))
        models = tuple(_model(folder, pushed, assemblage, partition) for pushed in summary.pushover)
    return StoredRun(folder, summary, case, assemblage, analysis, partition, models)


def read_checked(folder: Path) -> tuple[Case, storage.Summary]:
    """Return case and summary of the run in a folder, all of whose parts are as it wrote them. Raises CaseError."""
    if not (folder / "summary.json").is_file():
        raise CaseError("", "holds no finished run (no summary.json)", "give the folder that `run` wrote", str(folder))
    case = cases.read(folder / "case.toml")
    with telling_damage(folder):
        summary = storage.read_summary(folder)
        refuse_edited(folder, case, summary)
    return case, summary


@contextmanager
def telling_damage(folder: Path) -> Iterator[None]:
    """Let what is raised of files in a folder that are missing, or hold something else, be one CaseError."""
    try:
        yield
    except FileNotFoundError as error:
        raise missing(Path(error.filename)) from None
    except (OSError, KeyError, ValueError, TypeError) as error:
        problem = f"a file is damaged or from another version ({type(error).__name__}: {error})"
        raise CaseError("", problem, "`run` the case with --resume, or run it anew", str(folder)) from error


def refuse_edited(folder: Path, case: Case, summary: storage.Summary) -> None:
    """Raise CaseError where a file in a run folder is not what the run was made with, or what it has written."""
    if summary.settings is None or summary.files is None:
        problem = (
            "does not say with which settings the run was made and what it has written: it is of an earlier version"
        )
        raise CaseError("", problem, "run the case again", str(folder / "summary.json"))
    now = plain(cases.as_record(case, "blocks.json"))
    for key, (found, used) in differences(now, summary.settings).items():
        if key.split(".")[0] not in NOT_RUN_WITH:
            problem = f"is {shown(found)}, but the run was made with {shown(used)}"
            remedy = f"set it back, or run the case again; only [{'], ['.join(NOT_RUN_WITH)}] may be changed"
            raise CaseError(key, problem, remedy, str(folder / "case.toml"))
    if hash_file(folder / "blocks.json") != summary.blocks_sha256:
        raise CaseError("", "is not what the run was made with", "run it again", str(folder / "blocks.json"))
    refuse_other_parts(folder, summary)


def differences(one: Any, other: Any, key: str = "") -> dict[str, tuple[Any, Any]]:
    """Return what two records have at each key where they differ, such as "load.dead.0.inertia"; None: nothing."""
    if isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        one, other = dict(enumerate(one)), dict(enumerate(other))
    if not isinstance(one, dict) or not isinstance(other, dict):
        return {} if one == other else {key: (one, other)}
    found = dict[str, tuple[Any, Any]]()
    for name in dict.fromkeys([*one, *other]):
        found |= differences(one.get(name), other.get(name), f"{key}.{name}".lstrip("."))
    return found


def shown(value: Any) -> str:
    """Return a value of a case file in a few characters."""
    return "left out" if value is None else f"{value!r:.60}"


def _model(folder: Path, pushed: storage.PushoverSummary, assemblage: Assemblage, partition: Partition) -> StoredModel:
    name = pushed.model
    bodies = make_bodies(assemblage, partition if name == "macro" else one_body_per_block(assemblage))
    store, meshes, contacts = storage.read_geometry(folder / name)
    curve = storage.read_curve(folder / name, pushed.stopped_because)
    return StoredModel(name, pushed, bodies, meshes, contacts, store, curve)
