"""Serial stages under MPI: rank 0 computes, every rank returns or raises the same.

The only file besides pushover/ that names MPI; without mpi4py (no FE installed) one process is all there is.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from pathlib import Path
from time import monotonic, sleep
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar
from zlib import crc32

import numpy as np

from orchestrator.basis.atomic_files import locked

if TYPE_CHECKING:
    from mpi4py import MPI

P = ParamSpec("P")
T = TypeVar("T")
Spread = Callable[[Callable[[Any], Any], Iterable[Any]], Iterable[Any]]
"""what calls a function for every value, in any order"""
RANK = ("OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK")
"""variables in which mpirun and srun tell a process its rank"""


def all_ranks() -> MPI.Intracomm | None:
    """Return the communicator of all ranks, or None where mpi4py is not installed. Starts MPI."""
    try:
        from mpi4py import MPI
    except ImportError:
        return None
    return MPI.COMM_WORLD


def this_rank() -> MPI.Comm:
    """Return the communicator of this process alone."""
    from mpi4py import MPI

    return MPI.COMM_SELF


def started_as_rank() -> int:
    """Return the rank that mpirun or srun gave this process, 0 without either. Does not start MPI."""
    return next((int(os.environ[name]) for name in RANK if name in os.environ), 0)


def started_by_launcher() -> bool:
    """Return whether mpirun or srun has started this process, be it alone. Does not start MPI."""
    return any(name in os.environ for name in RANK)


class Ending:
    """How the ranks of `comm` end: together, or all of them because one failed alone.

    A rank that fails by itself would leave the others waiting for ever in what they do together. Made by all ranks at
    the start: a communicator of its own keeps it from meeting whatever the others wait for.
    """

    def __init__(self, comm: MPI.Comm | None) -> None:
        self._comm = comm.Dup() if comm is not None and comm.size > 1 else None

    def together(self, code: int, message: str, patience: float = 5.0) -> int:
        """Print `message` once and return the exit code of all ranks: the largest, of them that come here too.

        A failed rank waits for the others for `patience` s, one that is done for 20 times as long; then all are ended.
        """
        if self._comm is None:
            _print_error(message)
            return code
        codes = np.zeros(self._comm.size, np.int32)
        request = self._comm.Iallgather(np.array([code], np.int32), codes)
        end = monotonic() + (patience if code else 20 * patience)
        while not request.Test():
            if monotonic() > end:
                _print_error(message or f"rank {self._comm.rank} is done, but other ranks do not end")
                self._comm.Abort(code or 1)
            sleep(0.02)
        if self._comm.rank == np.argmax(codes):
            _print_error(message)
        return int(codes.max())


def _print_error(message: str) -> None:
    if message:
        print(message, file=sys.stderr, flush=True)


def refuse_disagreement(comm: MPI.Comm, values: bytes, what: str) -> None:
    """Raise RuntimeError on every rank unless all have come here with the same bytes."""
    if len({*comm.allgather(crc32(values))}) > 1:
        raise RuntimeError(f"the ranks disagree on {what}: this result cannot be trusted; run on one rank")


def on_root(comm: MPI.Comm | None, stage: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
    """Call `stage` on rank 0 and broadcast its value, or raise its exception, on every rank of `comm`."""
    if comm is None or comm.size == 1:
        return stage(*args, **kwargs)
    outcome: tuple[Any, Exception | None] = (None, None)
    if comm.rank == 0:
        try:
            outcome = (stage(*args, **kwargs), None)
        except Exception as failure:  # any failure of rank 0 must reach the ranks that wait for it
            outcome = (None, failure)
    value, raised = comm.bcast(outcome, root=0)
    if raised is not None:
        raise raised
    return value


@contextmanager
def on_root_while(comm: MPI.Comm | None, *contexts: AbstractContextManager[None]) -> Iterator[None]:
    """Hold contexts on rank 0, each entered after the one before; what entering raises is raised on every rank."""
    with ExitStack() as held:
        for context in contexts:
            on_root(comm, held.enter_context, context)
        yield


@contextmanager
def workers(comm: MPI.Intracomm | None) -> Iterator[Spread | None]:
    """Yield what calls a function for every value, in any order: spread over ranks 1 and up, on one rank `map`.

    Rank 0 hands out the values; the other ranks get None when rank 0 leaves: there is nothing left to do for them.
    """
    if comm is None or comm.size == 1:
        yield map
        return
    from mpi4py.futures import MPICommExecutor

    with MPICommExecutor(comm, root=0) as executor:
        yield None if executor is None else lambda function, values: executor.map(function, values, unordered=True)


@contextmanager
def workers_into(folder: Path, comm: MPI.Intracomm | None) -> Iterator[Spread | None]:
    """Yield what `workers` does while rank 0 holds `folder` alone. Raises CaseError where another process has it."""
    with workers(comm) as spread, locked(folder) if spread else nullcontext():
        yield spread


def is_root(comm: MPI.Comm | None) -> bool:
    """Return whether this process is rank 0."""
    return comm is None or comm.rank == 0
