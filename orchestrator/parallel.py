"""Serial stages under MPI: rank 0 computes, every rank returns or raises the same.

The only file besides pushover/ that names MPI; without mpi4py (no FE installed) one process is all there is.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

if TYPE_CHECKING:
    from mpi4py import MPI

P = ParamSpec("P")
T = TypeVar("T")


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
    variables = ("OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK")
    return next((int(os.environ[name]) for name in variables if name in os.environ), 0)


def abort_others(comm: MPI.Comm | None, code: int) -> None:
    """End all ranks if there are several: a rank that fails alone would leave the others waiting for ever."""
    if comm is not None and comm.size > 1:
        comm.Abort(code)


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
def workers(comm: MPI.Intracomm | None) -> Iterator[Callable[[Callable[[Any], T], Iterable[Any]], Iterable[T]] | None]:
    """Yield what calls a function for every value, in any order: spread over ranks 1 and up, on one rank `map`.

    Rank 0 hands out the values; the other ranks get None when rank 0 leaves: there is nothing left to do for them.
    """
    if comm is None or comm.size == 1:
        yield map
        return
    from mpi4py.futures import MPICommExecutor

    with MPICommExecutor(comm, root=0) as executor:
        yield None if executor is None else lambda function, values: executor.map(function, values, unordered=True)


def is_root(comm: MPI.Comm | None) -> bool:
    """Return whether this process is rank 0."""
    return comm is None or comm.rank == 0
