"""What an earlier run has left is removed: files of the names that the program gives, in its own folders, no others."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from pathlib import Path

from orchestrator.basis.atomic_files import remove_if_empty, sweep
from orchestrator.storage.outputs import MODELS, OF_A_RUN, holds_run
from orchestrator.storage.stored_increments import StateStore

RESULTS = (
    *OF_A_RUN, "case.toml", "blocks.json", "joints.csv", "limit_analysis.json", "macroblocks.json", "joint_forces.csv",
    "section_forces.csv", "reactions.csv", "tie_forces.csv", "rigid_pushover.csv", "mechanism.dxf", "verdict.csv",
    "load_cases.csv", "report.html", "collapse.html", "directions.json",
)  # fmt: skip
"""all that a run or a limit analysis writes, but run.log, which goes on, pictures, and folders of load cases"""
OF_A_MODEL = (
    "mesh.msh", "mesh.vtu", "curve.csv", "ties.csv", "geometry.h5", "wall.h5", "derived.h5", "wall.xdmf",
    "contacts.xdmf",
)  # fmt: skip
"""all that a run writes into the folder of a model, but its increments"""
PICTURES = (
    "blocks", "checked", "mechanism", "macroblocks", "settlement", "rigid_pushover", "directions", "curves", "bilinear",
    "verification", *(f"{model}_{moment}" for model in MODELS for moment in ("peak", "end")),
)  # fmt: skip
"""all that commands draw into the figures of a run folder, as .png, most as .svg too"""


def clear(folder: Path, given: Iterable[Path] = ()) -> None:
    """Remove the results of an earlier run, of all its load cases too: beside others they would be taken for theirs.

    Files that are `given`, and all that no run writes, stay, in the folders of models, pictures and load cases too.
    """
    if not holds_run(folder):
        return
    kept = [one for one in given if one.exists()]
    for name in _load_cases_in(folder):
        if not _unlinked(folder / name):
            _clear(folder / name, kept, "run.log")
            remove_if_empty(folder / name)
    _clear(folder, kept)


def _clear(folder: Path, given: Sequence[Path], *more: str) -> None:
    """Remove the files of one run, those of its pictures and models, and the folders of these where they are empty."""
    figures = folder / "figures"
    for model in (folder / name for name in MODELS):
        if not _unlinked(model):
            StateStore(model, "").clear()
            _remove_files(model, OF_A_MODEL, given)
            remove_if_empty(model)
    if not figures.is_symlink():
        for name in PICTURES:
            remove_picture(figures, name)
    sweep(folder, figures)
    remove_if_empty(figures)
    _remove_files(folder, [*RESULTS, *more], given)


def remove_picture(figures: Path, name: str) -> None:
    """Remove a picture that an earlier run has drawn, where there is one."""
    _remove_files(figures, [f"{name}.{suffix}" for suffix in ("png", "svg")], ())


def _unlinked(path: Path) -> bool:
    """Remove a link that stands where a run has a folder, not what it leads to; return whether it was one."""
    if path.is_symlink():
        path.unlink()
        return True
    return False


def _remove_files(folder: Path, names: Iterable[str], given: Sequence[Path]) -> None:
    for path in (folder / name for name in names):
        is_given = path.exists() and any(path.samefile(one) for one in given)
        if (path.is_symlink() or path.is_file()) and not is_given:
            path.unlink()


def _load_cases_in(folder: Path) -> list[str]:
    """Return the names of the folders of load cases that an earlier run left in `folder`."""
    try:
        record = json.loads((folder / "load_cases.json").read_text(encoding="utf-8"))
        names = [entry["name"] for entry in record["load_cases"]]
        return [name for name in names if Path(name).name == name and name not in ("", "..")]
    except (OSError, ValueError, KeyError, TypeError):  # none, or damaged
        return []
