"""Where results go: whether they can be written, and what is there already."""

from __future__ import annotations

import errno
import json
import os
import shutil
import tempfile
from collections.abc import Iterable
from pathlib import Path

from orchestrator.basis.errors import CaseError

OF_A_FINISHED_RUN = ("summary.json", "load_cases.json")
OF_A_RUN = (*OF_A_FINISHED_RUN, "macro", "micro")
"""what only a run leaves in its folder; pictures of `check` and `limit` may be there before"""
OF_A_STUDY = ("table.csv", "sensitivity.csv", "runs", "points")
"""what only a study or a sensitivity analysis leaves in its folder"""
RESULTS = (
    *OF_A_RUN, "case.toml", "blocks.json", "joints.csv", "limit_analysis.json", "macroblocks.json", "joint_forces.csv",
    "section_forces.csv", "reactions.csv", "rigid_pushover.csv", "mechanism.dxf", "verdict.csv", "load_cases.csv",
    "report.html", "collapse.html", "directions.json",
)  # fmt: skip
"""all that a run or a limit analysis writes, but run.log, which goes on, pictures, and folders of load cases"""


def try_folder(folder: Path) -> None:
    """Raise CaseError naming `folder` unless it, or what it will be made in, takes files. Leaves nothing behind."""
    try:
        place = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    except OSError as error:  # a name that no folder can have
        raise CaseError("--output", (error.strerror or "").lower(), "give another name", folder.name[:40]) from None
    if not place.is_dir():
        raise CaseError("--output", "is a file", "give a folder", str(place))
    try:
        with tempfile.TemporaryFile(dir=place):
            pass
    except OSError as error:
        reason = os.strerror(error.errno or errno.EIO).lower()
        raise CaseError("--output", f"cannot be written ({reason})", "give another folder", str(folder)) from None


def holds_run(folder: Path, finished: bool = False) -> bool:
    """Return whether a folder holds the results of a run, or of a `finished` one."""
    return any((folder / name).exists() for name in (OF_A_FINISHED_RUN if finished else OF_A_RUN))


def refuse_overwriting_run(folder: Path, resumable: bool = True) -> None:
    """Raise CaseError for a folder that holds the results of a run or study; not resumable: of a finished run only."""
    if holds_run(folder, finished=not resumable):
        remedy = f"give another --output, {'go on with --resume, ' * resumable}or overwrite it with --force"
        raise CaseError("--output", "holds the results of a run", remedy, str(folder))
    if any((folder / name).exists() for name in OF_A_STUDY):
        raise CaseError("--output", "holds the results of a study", "give another --output", str(folder))


def refuse_run(folder: Path) -> None:
    """Raise CaseError for a folder that holds the results of a run, which a study would write its own among."""
    if holds_run(folder):
        raise CaseError("--output", "holds the results of a run", "give another --output", str(folder))


def clear(folder: Path, given: Iterable[Path] = ()) -> None:
    """Remove the results of an earlier run, of all its load cases too: beside others they would be taken for theirs.

    Files that are `given`, and all that no run writes, stay.
    """
    if not holds_run(folder):
        return
    drawn = [path for path in (folder / "figures").glob("*.svg") if path.with_suffix(".png").exists()]
    pictures = [path.with_suffix(suffix) for path in drawn for suffix in (".svg", ".png")]
    for path in (*(folder / name for name in (*_load_cases_in(folder), *RESULTS)), *pictures):
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        elif path.exists() and not any(path.samefile(one) for one in given if one.exists()):
            path.unlink()


def _load_cases_in(folder: Path) -> list[str]:
    """Return the names of the folders of load cases that an earlier run left in `folder`."""
    try:
        record = json.loads((folder / "load_cases.json").read_text(encoding="utf-8"))
        return [entry["name"] for entry in record["load_cases"] if Path(entry["name"]).name == entry["name"]]
    except (OSError, ValueError, KeyError, TypeError):  # none, or damaged
        return []


def try_file(path: Path, force: bool) -> None:
    """Raise CaseError for a file that exists, unless it may be overwritten, and for one that cannot be written."""
    if path.is_dir():
        raise CaseError("--output", "is a folder", "give a file", str(path))
    try_folder(path.parent)
    if path.exists() and not force:
        raise CaseError("", "exists already", "give another name, or overwrite it with --force", str(path))
