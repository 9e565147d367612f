"""Stored increments of one pushover model, readable after a kill at any moment.

While a model runs, every increment is one small HDF5 file, states/000012.h5, followed by its sha256 and renamed into
place when it is on the disk; HDF5 itself does not survive a kill inside a write.
`assemble` copies them into states.h5 (one group per increment, named like the files), also followed by its sha256, then
deletes them. Reading looks at both, the single files first. A file is opened only if it matches its sha256: HDF5 may
return other numbers, run for ever or crash on one that is damaged, and its own checksums do not cover its directory.
Every increment also carries a sha256 of its content, and the fingerprint of its model (strangers are found).
"""

from __future__ import annotations

import hashlib
import io
import json
import re
from collections.abc import Iterable, Iterator
from contextlib import ExitStack
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from orchestrator.basis.atomic_files import (
    remove_if_empty,
    replacing,
    require_room,
    require_seal,
    seal,
    sealed,
    sweep,
    unsealed,
    write_bytes,
)
from orchestrator.basis.errors import CaseError
from orchestrator.pushover.increments import Attempt, Increment
from orchestrator.storage.files import missing
from orchestrator.storage.hdf5 import hdf5_file

if TYPE_CHECKING:
    import h5py

STATES_FILE = "states.h5"
STATES_FOLDER = "states"
HEADROOM = 1 << 18
"""bytes that states.h5 may need beyond what the single files do"""
IN_MEMORY = 1 << 26
"""bytes of increments that a run keeps in memory for curve, tables and pictures: all of them up to some 500 stones"""


@dataclass(frozen=True, slots=True)
class StateStore:
    """The stored increments in `folder` (macro/ or micro/) of the model with this `fingerprint` (any string).

    memory: bytes of increments that are kept once they are appended or read, the first ones that find room.
    """

    folder: Path
    fingerprint: str
    memory: int = 0
    _kept: dict[int, Increment] = field(default_factory=dict, init=False, repr=False, compare=False)

    def clear(self) -> None:
        """Forget all stored increments. Killed half-way it leaves either all of an earlier run or its beginning."""
        self._kept.clear()
        self._remove_single()
        (self.folder / STATES_FILE).unlink(missing_ok=True)

    def append(self, increment: Increment) -> None:
        """Store one increment, whole or not at all; one of the same number is replaced."""
        content = io.BytesIO()
        with hdf5_file(content, "w") as file:
            _write(file.create_group(_name(increment.number)), increment, self.fingerprint)
        write_bytes(self._part(increment.number), sealed(content.getvalue()))
        self._keep(increment)

    def numbers(self) -> list[int]:
        """Return the numbers of all stored increments, ascending."""
        single = [int(path.stem) for path in self._single()]
        return sorted({*single, *self._assembled_numbers()})

    def read(self, number: int) -> Increment:
        """Return the increment. Raises CaseError if it is damaged or belongs to another model."""
        (increment,) = self.these([number])
        return increment

    def increments(self) -> Iterator[Increment]:
        """Yield all stored increments in order. Raises CaseError as `read` does."""
        return self.these(self.numbers())

    def these(self, numbers: Iterable[int]) -> Iterator[Increment]:
        """Yield the increments of the given numbers. Raises CaseError as `read` does."""
        numbers = list(numbers)
        kept = {number: self._kept[number] for number in numbers if number in self._kept}
        read = self._read(number for number in numbers if number not in kept)
        yield from (kept.get(number) or next(read) for number in numbers)

    def last(self) -> Increment | None:
        """Return the increment to go on from, None where nothing is stored."""
        numbers = self.numbers()
        return self.read(numbers[-1]) if numbers else None

    def refuse_others(self, beginning: str) -> None:
        """Raise CaseError where the last increment is of a model whose fingerprint does not begin like this."""
        for number, file, path in self._files(self.numbers()[-1:]):
            if not str(file[_name(number)].attrs["fingerprint"]).startswith(beginning):
                raise _stranger(path, number)

    def assemble(self) -> Path:
        """Gather everything in states.h5 and return its path; the single files are deleted once it is on the disk."""
        path = self.folder / STATES_FILE
        single = self._single()
        if single or not path.exists():
            parts = [*single, *[path][: path.exists()]]
            self.folder.mkdir(parents=True, exist_ok=True)
            require_room(path, HEADROOM + sum(part.stat().st_size for part in parts))
            numbers = self.numbers()
            with replacing(path) as temporary:
                with hdf5_file(temporary, "w") as target:
                    for number, source, _ in self._files(numbers):
                        source.copy(_name(number), target)
                seal(temporary)
        self._remove_single()
        return path

    def _keep(self, increment: Increment) -> None:
        """Keep an increment in memory where there is room; one takes as much as any other."""
        self._kept.pop(increment.number, None)
        values = (getattr(increment, one.name) for one in fields(increment))
        size = sum(value.nbytes for value in values if isinstance(value, np.ndarray))
        if (len(self._kept) + 1) * size <= self.memory:
            self._kept[increment.number] = increment

    def _read(self, numbers: Iterable[int]) -> Iterator[Increment]:
        for number, file, path in self._files(numbers):
            try:
                increment = _read(file[_name(number)], self.fingerprint)
            except _OtherModelError:
                raise _stranger(path, number) from None
            except (OSError, KeyError, ValueError, TypeError, RuntimeError) as error:
                raise _damaged(path, f"increment {number}") from error
            self._keep(increment)
            yield increment

    def _files(self, numbers: Iterable[int]) -> Iterator[tuple[int, h5py.File, Path]]:
        """Yield each number with the open file that holds it, and its path; states.h5 is opened at most once."""
        with ExitStack() as stack:
            assembled: h5py.File | None = None
            for number in numbers:
                if (part := self._part(number)).exists():
                    with _opened(part) as file:
                        yield number, file, part
                    continue
                path = self.folder / STATES_FILE
                assembled = assembled or stack.enter_context(_opened(path))
                yield number, assembled, path

    @property
    def _parts(self) -> Path:
        return self.folder / STATES_FOLDER

    def _single(self) -> list[Path]:
        """Return the single files in order; what else lies in their folder is not theirs."""
        return sorted(path for path in self._parts.glob("[0-9]*.h5") if re.fullmatch(r"\d{6,}", path.stem))

    def _part(self, number: int) -> Path:
        return self._parts / f"{_name(number)}.h5"

    def _assembled_numbers(self) -> list[int]:
        path = self.folder / STATES_FILE
        if not path.exists():
            return []
        with _opened(path) as file:
            return [int(name) for name in file]

    def _remove_single(self) -> None:
        """Delete the single files, the last one first, and what killed runs left half-written; nothing else."""
        sweep(self.folder, self._parts)
        for path in reversed(self._single()):
            path.unlink(missing_ok=True)
        remove_if_empty(self._parts)


class _OtherModelError(Exception):
    """The increment carries another fingerprint."""


def _opened(path: Path) -> h5py.File:
    """Open states.h5 or a single increment if it is what was written. Raises CaseError."""
    try:
        if path.name != STATES_FILE:
            return hdf5_file(io.BytesIO(unsealed(path.read_bytes())), "r")
        require_seal(path)
        return hdf5_file(path, "r")
    except (OSError, ValueError) as error:
        raise _damaged(path, "") from error


def _stranger(path: Path, number: int) -> CaseError:
    problem = "was stored by another model (wall, mesh or settings differ)"
    return CaseError(f"increment {number}", problem, "run without --resume or into another folder", str(path))


def _damaged(path: Path, key: str) -> CaseError:
    if not path.exists():
        return missing(path)
    problem = "cannot be read (damaged, or written by another version)"
    remedy = "delete it and `run` the case with --resume to go on from the increment before, or run the case anew"
    return CaseError(key, problem, remedy, str(path))


def _name(number: int) -> str:
    return f"{number:06d}"


def _write(group: h5py.Group, increment: Increment, fingerprint: str) -> None:
    """Write arrays as datasets, numbers and words as attributes, the journal as JSON."""
    for one in fields(increment):
        value = getattr(increment, one.name)
        if isinstance(value, np.ndarray):
            group.create_dataset(one.name, data=value)
        elif one.name == "attempts":
            group.create_dataset(one.name, data=_journal(increment))
        else:
            group.attrs[one.name] = _scalar(value)
    group.attrs["fingerprint"] = fingerprint
    group.attrs["sha256"] = _digest(increment)


def _read(group: h5py.Group, fingerprint: str) -> Increment:
    if group.attrs["fingerprint"] != fingerprint:
        raise _OtherModelError
    stored = set(group)
    increment = Increment(**{one.name: _value(group, one.name, one.name in stored) for one in fields(Increment)})
    if group.attrs["sha256"] != _digest(increment):
        raise ValueError(f"content of {group.name} does not match its sha256")
    return increment


def _value(group: h5py.Group, name: str, is_array: bool) -> Any:
    if name == "attempts":
        return tuple(Attempt(**record) for record in json.loads(group[name][()]))
    if is_array:
        array = group[name][()]
        array.flags.writeable = False
        return array
    return _scalar(group.attrs[name])


def _scalar(value: Any) -> Any:
    """Return plain Python numbers (numpy ones differ in type, not in value); arrays and tuples become tuples."""
    if isinstance(value, np.ndarray | tuple):
        return tuple(float(item) for item in value)
    return value.item() if isinstance(value, np.generic) else value


def _journal(increment: Increment) -> str:
    return json.dumps([asdict(attempt) for attempt in increment.attempts], default=_scalar)


def _digest(increment: Increment) -> str:
    """Return the sha256 of every field's name, type, shape and content."""
    total = hashlib.sha256()
    for one in fields(increment):
        value = getattr(increment, one.name)
        if isinstance(value, np.ndarray):
            total.update(f"{one.name} {value.dtype} {value.shape}".encode())
            total.update(np.ascontiguousarray(value).tobytes())
        else:
            content = _journal(increment) if one.name == "attempts" else repr(_scalar(value))
            total.update(f"{one.name} {content}".encode())
    return total.hexdigest()
