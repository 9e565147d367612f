"""Threads of one process: PETSc and gmsh know one only, so who uses them takes turns."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from threading import RLock
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")
TURN = RLock()
"""held by the thread that uses PETSc or gmsh"""


def in_turn(function: Callable[P, T]) -> Callable[P, T]:
    """Return a function that waits until no other thread is in one of these."""

    @wraps(function)
    def waiting(*args: P.args, **kwargs: P.kwargs) -> T:
        with TURN:
            return function(*args, **kwargs)

    return waiting
