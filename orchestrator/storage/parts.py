"""The files that are one run: summary.json has the sha256 of each, and readers take no other.

Not among them are pictures, pages, and tables that are made of these, which `report` writes again; case.toml and
blocks.json are compared with what summary.json says of them (stored_run.py).
"""

from __future__ import annotations

from pathlib import Path

from orchestrator.basis.errors import CaseError
from orchestrator.storage.files import hash_file, missing
from orchestrator.storage.outputs import MODELS
from orchestrator.storage.summary import Summary, seal_of

OF_A_WALL = ("limit_analysis.json", "macroblocks.json")
OF_A_MODEL = ("curve.csv", "ties.csv", "geometry.h5", "states.h5")
PARTS = (*OF_A_WALL, *(f"{model}/{name}" for model in MODELS for name in OF_A_MODEL))
REMEDY = "copy it back, or `run` the case with --resume"


def parts_in(folder: Path) -> dict[str, str]:
    """Return the sha256 of each part that a run has written into a folder, by its name there."""
    return {name: hash_file(folder / name) for name in PARTS if (folder / name).is_file()}


def refuse_other_parts(folder: Path, summary: Summary) -> None:
    """Raise CaseError, naming the file, where one is not as the run has written it: changed since, or another run's."""
    if summary.sha256 != seal_of(summary):
        raise _other(folder / "summary.json")
    known, found = summary.files or {}, parts_in(folder)
    for name in dict.fromkeys([*known, *found]):
        if name not in found:
            raise missing(folder / name)
        if found[name] != known.get(name):
            raise _other(folder / name)


def _other(path: Path) -> CaseError:
    return CaseError("", "is not as the run wrote it: changed since, or of another run", REMEDY, str(path))
