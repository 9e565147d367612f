"""Arrays of numbers: their types, and arrays that cannot be written to."""

from __future__ import annotations

import hashlib
from typing import TypeVar

import numpy as np
import numpy.typing as npt

BoolArray = npt.NDArray[np.bool_]
FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
T = TypeVar("T", bound=np.ndarray)


def read_only(values: npt.ArrayLike, dtype: npt.DTypeLike = np.float64) -> np.ndarray:
    """Return a private copy of `values` that cannot be written to (a frozen dataclass alone does not freeze arrays)."""
    array = np.array(values, dtype=dtype)
    array.flags.writeable = False
    return array


def frozen(array: T) -> T:
    """Return an array that has just been made and nobody else has, so that it cannot be written to from now on."""
    array.flags.writeable = False
    return array


def fingerprint(*values: npt.ArrayLike) -> str:
    """Return a text that only the same arrays have: to the last digit, and in the same order."""
    total = hashlib.sha256()
    for array in map(np.asarray, values):
        total.update(repr((array.shape, array.dtype.str)).encode() + array.tobytes())
    return total.hexdigest()
