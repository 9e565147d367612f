"""Blocks and the wall they form (all SI: N, m)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

GRAVITY = 9.81
"""Standard acceleration of gravity used to turn unit weight into density, m/s2."""


def read_only(values: npt.ArrayLike, dtype: npt.DTypeLike = np.float64) -> np.ndarray:
    """Return a private copy of `values` that cannot be written to (a frozen dataclass alone does not freeze arrays)."""
    array = np.array(values, dtype=dtype)
    array.flags.writeable = False
    return array


@dataclass(frozen=True, eq=False, slots=True)
class Block:
    """One stone: `polygon` (n, 2) in m, counter-clockwise, not closed; `unit_weight` in N/m3; `fixed` for supports."""

    id: int
    polygon: FloatArray
    fixed: bool
    unit_weight: float


@dataclass(frozen=True, eq=False, slots=True)
class Wall:
    """Blocks of one thickness (m) with one coefficient of friction in every joint."""

    name: str
    blocks: tuple[Block, ...]
    thickness: float
    friction: float
