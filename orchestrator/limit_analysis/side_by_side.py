"""Independent parts of an analysis at the same time.

The solver of linear programs and sparse factorisations let other threads of Python run.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

First = TypeVar("First")
Second = TypeVar("Second")


def side_by_side(first: Callable[[], First], second: Callable[[], Second]) -> tuple[First, Second]:
    """Run both and return what they return, the same as one after the other.

    They must not change anything they share; a LimitProgram is changed by solving it. Raises what `first` raises, else
    what `second` raises.
    """
    with ThreadPoolExecutor(max_workers=1) as other:
        running = other.submit(second)
        return first(), running.result()
