"""Where results go: whether they can be written, and what is there already."""

from __future__ import annotations

import errno
import os
import tempfile
from collections.abc import Iterable
from pathlib import Path

from orchestrator.basis.errors import CaseError

MODELS = ("macro", "micro")
OF_A_RUN = ("summary.json", "load_cases.json", *MODELS)
"""what only a run leaves in its folder; pictures of `check` and `limit` may be there before"""
OF_A_STUDY = ("table.csv", "sensitivity.csv", "runs", "points")
"""what only a study or a sensitivity analysis leaves in its folder"""


def try_folder(folder: Path, option: str = "--output", remedy: str = "give another folder") -> None:
    """Raise CaseError naming `folder`, and the option that it is of, unless it, or what it will be made in, takes
    files. Leaves nothing behind.

    The root of the file system takes none: nobody means it.
    """
    _try_place(folder, option, remedy)
    if folder.exists() and folder.samefile(folder.absolute().anchor):
        raise CaseError(option, "is the root of the file system", "give a folder", str(folder))


def _try_place(folder: Path, option: str = "--output", remedy: str = "give another folder") -> None:
    try:
        place = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    except OSError as error:  # a name that no folder can have
        raise CaseError(option, (error.strerror or "").lower(), "give another name", folder.name[:40]) from None
    if not place.is_dir():
        raise CaseError(option, "is a file", "give a folder", str(place))
    try:
        with tempfile.TemporaryFile(dir=place):
            pass
    except OSError as error:
        reason = os.strerror(error.errno or errno.EIO).lower()
        raise CaseError(option, f"cannot be written ({reason})", remedy, str(folder)) from None


def holds_run(folder: Path) -> bool:
    """Return whether a folder holds the results of a run, finished or not."""
    return any((folder / name).exists() for name in OF_A_RUN)


def refuse_overwriting_run(folder: Path, resumable: bool = True) -> None:
    """Raise CaseError for a folder that holds the results of a run or study; resumable: the command can go on with
    it."""
    if holds_run(folder):
        remedy = f"give another --output, {'go on with --resume, ' * resumable}or overwrite it with --force"
        raise CaseError("--output", "holds the results of a run", remedy, str(folder))
    if any((folder / name).exists() for name in OF_A_STUDY):
        raise CaseError("--output", "holds the results of a study", "give another --output", str(folder))


def refuse_run(folder: Path) -> None:
    """Raise CaseError for a folder that holds the results of a run, which a study would write its own among."""
    if holds_run(folder):
        raise CaseError("--output", "holds the results of a run", "give another --output", str(folder))


def refuse_input(paths: Iterable[Path], read: Iterable[Path]) -> None:
    """Raise CaseError for a file that a command would write over one that it reads, which nothing allows."""
    inputs = [one for one in read if one.exists()]
    for path in paths:
        if path.exists() and any(path.samefile(one) for one in inputs):
            problem = "is read by this command, and would be overwritten"
            raise CaseError("", problem, "give another name or folder with --output", str(path))


def try_file(path: Path, force: bool) -> None:
    """Raise CaseError for a file that exists, unless it may be overwritten, and for one that cannot be written."""
    if path.is_dir():
        raise CaseError("--output", "is a folder", "give a file", str(path))
    _try_place(path.parent)
    if path.exists() and not force:
        raise CaseError("", "exists already", "give another name, or overwrite it with --force", str(path))
