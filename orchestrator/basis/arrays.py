"""Arrays of numbers: their types, and arrays that cannot be written to."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


def read_only(values: npt.ArrayLike, dtype: npt.DTypeLike = np.float64) -> np.ndarray:
    """Return a private copy of `values` that cannot be written to (a frozen dataclass alone does not freeze arrays)."""
    array = np.array(values, dtype=dtype)
    array.flags.writeable = False
    return array
