"""Files that are whole or absent, in folders that belong to one run at a time.

A file is written under a temporary name in its own folder, fsynced and renamed; files that belong together are renamed
when the last one is written. A run folder is locked by flock(2), which the kernel releases when the process dies,
however it dies.
"""

from __future__ import annotations

import errno
import fcntl
import hashlib
import logging
import os
import re
import secrets
import shutil
import signal
import socket
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from orchestrator.basis.errors import CaseError

MARK = "orchestrator"
"""what no other program puts into the names of its temporary files"""
TEMPORARY = ".tmp"
"""suffix of files and folders being written, after the mark"""
HALF_WRITTEN = re.compile(rf"\..+\.{MARK}-[0-9a-f]{{8}}{re.escape(TEMPORARY)}")
"""names that `replacing` writes under; where no run is at work a killed one has left them"""
SHORT = re.compile(r"\d+ requested and \d+ written")
"""what numpy says, without a number, of a disk that is full"""
LOCK = ".lock"
"""name of the file that says which process a run folder belongs to"""
DIGEST = 32
"""bytes of a sha256"""
PIECE = 1 << 20
"""bytes of a file that are in memory at a time"""

logger = logging.getLogger(__name__)


@dataclass(eq=False, slots=True)
class _Waiting:
    """Files that are written and not yet in their places: where they go -> where they are; folders made for them."""

    files: dict[Path, Path] = field(default_factory=dict)
    made: list[Path] = field(default_factory=list)


_waiting: ContextVar[_Waiting | None] = ContextVar("waiting", default=None)
"""of `together`; of this thread"""


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield a temporary path to write to; on success it is fsynced and renamed to `path`, on an error removed.

    Makes the folder. Raises OSError naming `path` (full disk, read-only folder); an older `path` is then untouched.
    Within `together` it is renamed at the end of that.
    """
    temporary, waiting = path.with_name(f".{path.name}.{MARK}-{secrets.token_hex(4)}{TEMPORARY}"), _waiting.get()
    try:
        if waiting is not None:
            waiting.made += [folder for folder in path.parents if not folder.exists()]
        path.parent.mkdir(parents=True, exist_ok=True)
        yield temporary
        _fsync(temporary)
        if waiting is None:
            os.replace(temporary, path)
            _fsync(path.parent)
        else:
            if path in waiting.files:
                _remove(waiting.files[path])
            waiting.files[path] = temporary
    except OSError as error:
        with suppress(OSError):  # the folder may be a file, or gone: the error says so
            temporary.unlink(missing_ok=True)
        raise naming_file(error, path) from error
    except BaseException:
        _remove(temporary)
        raise


@contextmanager
def together(prepare: Callable[[Mapping[Path, Path]], None] = lambda _: None) -> Iterator[None]:
    """Let all files that are written inside take their places at the end, or on an error none of them.

    prepare: is called before they do, with where each of them is, by where it goes. What is `together` inside of
    another one is a part of that.
    """
    if _waiting.get() is not None:
        yield
        return
    waiting = _Waiting()
    token = _waiting.set(waiting)
    try:
        try:
            yield
        finally:
            _waiting.reset(token)
        with _uninterrupted():
            prepare(waiting.files)
            _place(waiting.files)
    except BaseException:
        for temporary in waiting.files.values():
            _remove(temporary)
        for folder in sorted(waiting.made, reverse=True):
            remove_if_empty(folder)
        raise


def _place(files: Mapping[Path, Path]) -> None:
    for path, temporary in files.items():
        try:
            os.replace(temporary, path)
        except OSError as error:
            raise naming_file(error, path) from error
    for folder in dict.fromkeys(path.parent for path in files):
        _fsync(folder)


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Let Ctrl-C wait until what is done inside is done: that takes milliseconds."""
    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(before):
        yield
        return
    came: list[Any] = []
    signal.signal(signal.SIGINT, lambda *how: came.append(how))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if came:
        before(*came[0])


def read_written(path: Path) -> bytes:
    """Return the content of a file, be it in its place or waiting for that."""
    waiting = _waiting.get()
    return (waiting.files.get(path, path) if waiting else path).read_bytes()


def naming_file(error: OSError, path: Path) -> OSError:
    """Return the error with a file name: a full disk does not say which file it had no room for."""
    named = error.errno is not None and error.filename is not None
    if named and not HALF_WRITTEN.fullmatch(Path(str(error.filename)).name):
        return error
    said = str(error).splitlines()[0] if str(error) else ""
    number = error.errno or (errno.ENOSPC if SHORT.fullmatch(said) else errno.EIO)
    return OSError(number, said if number == errno.EIO and not error.errno else os.strerror(number), str(path))


def write_bytes(path: Path, content: bytes) -> None:
    """Write `content` to `path`, whole or not at all."""
    with replacing(path) as temporary:
        temporary.write_bytes(content)


def require_room(path: Path, size: int) -> None:
    """Raise OSError naming `path` unless its disk has room for `size` bytes: HDF5 crashes on one that fills up."""
    if shutil.disk_usage(path.parent).free < size:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))


def sealed(content: bytes) -> bytes:
    """Return the content followed by its sha256."""
    return content + hashlib.sha256(content).digest()


def unsealed(content: bytes) -> bytes:
    """Return what `sealed` was given. Raises ValueError if a bit of it has changed since."""
    inside, seal = content[:-DIGEST], content[-DIGEST:]
    if len(seal) < DIGEST or hashlib.sha256(inside).digest() != seal:
        raise ValueError("its content does not match its sha256")
    return inside


def seal(path: Path) -> None:
    """Append the sha256 of a file to it. What follows the end of an HDF5 file, every reader of HDF5 passes over."""
    digest = _digest(path, path.stat().st_size)
    with path.open("ab") as file:
        file.write(digest)


def require_seal(path: Path) -> None:
    """Raise ValueError if a bit of the file has changed since `seal`, OSError if it cannot be read."""
    inside = path.stat().st_size - DIGEST
    if inside >= 0:
        with path.open("rb") as file:
            file.seek(inside)
            if file.read() == _digest(path, inside):
                return
    raise ValueError("its content does not match its sha256")


def _digest(path: Path, size: int) -> bytes:
    """Return the sha256 of the first `size` bytes of a file, a piece at a time."""
    total = hashlib.sha256()
    with path.open("rb") as file:
        while size > 0 and (piece := file.read(min(size, PIECE))):
            total.update(piece)
            size -= len(piece)
    return total.digest()


def sweep(*folders: Path) -> None:
    """Delete the files that killed runs left half-written directly in folders that this run writes into.

    Nothing in folders below them, nothing behind a link, and nothing of a name that `replacing` does not give.
    """
    for folder in folders:
        if folder.is_symlink() or not folder.is_dir():
            continue
        for path in folder.iterdir():
            if HALF_WRITTEN.fullmatch(path.name) and path.is_file() and not path.is_symlink():
                _remove(path)


def remove_if_empty(folder: Path) -> None:
    """Remove a folder that nothing is in any more; a link to one stays."""
    with suppress(OSError):  # files of others are in it, or it is gone
        folder.rmdir()


@contextmanager
def locked(*folders: Path) -> Iterator[None]:
    """Hold folders (made if need be) for this process alone. Raises CaseError if a living process holds one.

    Those that were made go again where nothing has come to be in them.
    """
    with ExitStack() as held:
        for folder in dict.fromkeys(folders):
            held.enter_context(_locked(folder))
        yield


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    made = [one for one in (folder, *folder.parents) if not one.exists()]
    try:
        descriptor = _taken(folder / LOCK)
        try:
            yield
        finally:
            _remove(folder / LOCK)
            os.close(descriptor)
    finally:
        for one in made:
            remove_if_empty(one)


def is_locked(folder: Path) -> bool:
    """Return whether a process may be holding a folder: one does, or was killed while it did."""
    return (folder / LOCK).exists()


def _taken(path: Path) -> int:
    """Return the descriptor of the locked file, in a folder that is made if need be; the lock ends with it."""
    while True:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        except FileNotFoundError:
            if path.parent.exists():  # a link that leads nowhere
                raise
            continue  # another process had made the folder, and has removed it in between
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            holder = os.pread(descriptor, 200, 0).decode(errors="replace").strip() or "another process"
            os.close(descriptor)
            remedy = "wait for it, or give another folder with --output"
            raise CaseError(str(path.parent), f"is in use by {holder}", remedy) from None
        except OSError as error:
            logger.warning("%s: %s; nothing keeps a second run out of this folder", path, error.strerror)
        if _is(path, descriptor):
            os.ftruncate(descriptor, 0)
            os.pwrite(descriptor, f"process {os.getpid()} on {socket.gethostname()}\n".encode(), 0)
            return descriptor
        os.close(descriptor)  # its holder deleted it in between


def _is(path: Path, descriptor: int) -> bool:
    try:
        return os.path.samestat(path.stat(), os.fstat(descriptor))
    except FileNotFoundError:
        return False


def _remove(path: Path) -> None:
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        logger.warning("%s: %s", path, error.strerror)


def _fsync(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
