"""Where results go: whether they can be written, and what is there already."""

from __future__ import annotations

import errno
import os
import tempfile
from pathlib import Path

from orchestrator.basis.errors import CaseError

OF_A_FINISHED_RUN = ("summary.json", "load_cases.json")
OF_A_RUN = (*OF_A_FINISHED_RUN, "macro", "micro")
"""what only a run leaves in its folder; pictures of `check` and `limit` may be there before"""


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


def refuse_overwriting_run(folder: Path, resumable: bool = True) -> None:
    """Raise CaseError for a folder that holds the results of a run; not resumable: of a finished one only."""
    if any((folder / name).exists() for name in (OF_A_RUN if resumable else OF_A_FINISHED_RUN)):
        remedy = f"give another --output, {'go on with --resume, ' * resumable}or overwrite it with --force"
        raise CaseError("--output", "holds the results of a run", remedy, str(folder))


def try_file(path: Path, force: bool) -> None:
    """Raise CaseError for a file that exists, unless it may be overwritten, and for one that cannot be written."""
    if path.is_dir():
        raise CaseError("--output", "is a folder", "give a file", str(path))
    try_folder(path.parent)
    if path.exists() and not force:
        raise CaseError("", "exists already", "give another name, or overwrite it with --force", str(path))
