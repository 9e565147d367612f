"""What the program has left is removed: of a run files of the names that it gives, in its own folders; of other
commands those that results.json names and that have not been changed since. No others.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from pathlib import Path, PurePosixPath
from typing import Any

from orchestrator.basis.atomic_files import remove_if_empty, sweep
from orchestrator.storage.files import hash_file, read_json
from orchestrator.storage.outputs import MODELS, OF_A_RUN, holds_run
from orchestrator.storage.stored_increments import StateStore

RESULTS = (
    *OF_A_RUN, "case.toml", "blocks.json", "joints.csv", "limit_analysis.json", "macroblocks.json", "joint_forces.csv",
    "section_forces.csv", "reactions.csv", "tie_forces.csv", "rigid_pushover.csv", "mechanism.dxf", "verdict.csv",
    "load_cases.csv", "report.html", "collapse.html", "directions.json",
)  # fmt: skip
"""all that a run or a limit analysis writes, but run.log, which goes on, pictures, and folders of load cases"""
OF_A_MODEL = (
    "borne.json", "mesh.msh", "mesh.vtu", "curve.csv", "ties.csv", "geometry.h5", "wall.h5", "derived.h5", "wall.xdmf",
    "contacts.xdmf", "control_point.csv",
)  # fmt: skip
"""all that a run writes into the folder of a model, but its increments"""
PICTURES = (
    "blocks", "checked", "mechanism", "lowest", "macroblocks", "settlement", "rigid_pushover", "directions", "curves",
    "bilinear", "verification", *(f"{model}_{moment}" for model in MODELS for moment in ("peak", "end")),
)  # fmt: skip
"""all that commands draw into the figures of a run folder, as .png, most as .svg too"""
OF_OTHERS = ("blocks", "checked", "settlement", "directions")
"""those of them that others draw, without a record or in space: none of these keeps a run from its folder"""
RECORD = "results.json"
"""what limit, segment, study and sensitivity name the files in that they leave (placing.py)"""


def clear(folder: Path, given: Iterable[Path] = ()) -> None:
    """Remove the results of earlier commands, of all load cases too: beside others they would be taken for theirs.

    Files that are `given`, and all that the program has not written, stay, in the folders of models, pictures and load
    cases too.
    """
    given = tuple(given)
    remove_recorded(folder, given)
    if holds_run(folder):
        cases = [folder / name for name in _load_cases_in(folder)]
        sweep(*(part for one in (folder, *cases) if not one.is_symlink() for part in (one, one / "figures")))
        clear_run(folder, given)


def files_of_a_run(folder: Path) -> list[Path]:
    """Return what a run would write into its folder, but pictures that other commands leave there, too."""
    names = [name for name in PICTURES if name not in OF_OTHERS]
    drawn = [folder / "figures" / f"{name}.{suffix}" for name in names for suffix in ("png", "svg")]
    return [*(folder / name for name in RESULTS), *drawn]


def remove_recorded(folder: Path, given: Iterable[Path] = ()) -> None:
    """Remove what results.json names, and then that itself; what has been changed since it was written stays."""
    record = read_record(folder)
    if record:
        remove_named(folder, named_in(record), given)
        (folder / RECORD).unlink(missing_ok=True)


def read_record(folder: Path) -> dict[str, Any]:
    """Return what results.json holds, nothing where there is none or it is damaged."""
    try:
        record = read_json(folder / RECORD)
    except (OSError, ValueError):
        return {}
    return record if isinstance(record, dict) else {}


def named_in(record: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the names of files, from their folder, and their sha256, as results.json has them; of a command that was
    killed while it put them in their places, those of before too."""
    files, earlier = record.get("files"), record.get("earlier")
    pairs = [*(files.items() if isinstance(files, dict) else ()), *(earlier if isinstance(earlier, list) else ())]
    whole = [pair for pair in pairs if isinstance(pair, tuple | list) and len(pair) == 2]
    return [(name, digest) for name, digest in whole if isinstance(name, str) and isinstance(digest, str)]


def remove_named(folder: Path, named: Iterable[tuple[str, str]], given: Iterable[Path] = ()) -> None:
    """Remove files of these names and sha256 in a folder, and folders that they leave empty; no link is followed."""
    kept, left = [one for one in given if one.exists()], dict[Path, None]()
    for name, digest in named:
        parts = PurePosixPath(name).parts
        if not parts or ".." in parts or PurePosixPath(name).is_absolute():
            continue
        path = folder.joinpath(*parts)
        within = [path, *(one for one in path.parents if one.is_relative_to(folder) and one != folder)]
        if any(one.is_symlink() for one in within) or not path.is_file():
            continue
        if hash_file(path) == digest and not any(path.samefile(one) for one in kept):
            path.unlink()
            left |= dict.fromkeys(within[1:])
    for one in sorted(left, reverse=True):
        remove_if_empty(one)


def clear_run(folder: Path, given: Iterable[Path] = ()) -> None:
    """Remove the results of an earlier run, as `clear` does, but nothing half-written: what takes their places may be
    that."""
    if not holds_run(folder):
        return
    kept = [one for one in given if one.exists()]
    for name in _load_cases_in(folder):
        if not _unlinked(folder / name):
            _clear(folder / name, kept, "run.log")
            remove_if_empty(folder / name)
    _clear(folder, kept)


def _clear(folder: Path, given: Sequence[Path], *more: str) -> None:
    """Remove the files of one run, first the one that says it was finished, those of its pictures and models, and the
    folders of these where they are empty."""
    figures = folder / "figures"
    _remove_files(folder, ("summary.json",), given)
    for model in (folder / name for name in MODELS):
        if not _unlinked(model):
            StateStore(model, "").clear()
            _remove_files(model, OF_A_MODEL, given)
            remove_if_empty(model)
    if not figures.is_symlink():
        for name in PICTURES:
            remove_picture(figures, name)
    remove_if_empty(figures)
    _remove_files(folder, [*RESULTS, *more], given)


def remove_what_some_have(folder: Path) -> None:
    """Remove what a run of other settings that is gone on with has written, and this one may not write."""
    _remove_files(folder, ("tie_forces.csv", "rigid_pushover.csv"), ())
    for name in ("rigid_pushover", "lowest"):
        remove_picture(folder / "figures", name)


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
