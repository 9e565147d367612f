"""Serial stages under MPI: rank 0 computes, every rank returns or raises the same.

The only file besides pushover/ that names MPI; without mpi4py (no FE installed) one process is all there is.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

if TYPE_CHECKING:
    from mpi4py import MPI

P = ParamSpec("P")
T = TypeVar("T")


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


def is_root(comm: MPI.Comm | None) -> bool:
    """Return whether this process is rank 0."""
    return comm is None or comm.rank == 0
