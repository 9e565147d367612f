"""Stiffness of a wall from those of its joints, B J B^T, for ever new joints: assembled and ordered once.

J has a 3 x 3 matrix for each joint (opening at start, at end, slip). Friction makes shear depend on normal forces,
never the reverse, so that five of its entries can differ from 0:

    [[a, 0, 0], [0, b, 0], [c, d, e]]

The entries of the wall's matrix are linear in those of the joints; that map and an order of elimination with little
fill-in are found once. Per factorisation, product and order cost more than the elimination itself at 146 blocks.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from copy import copy
from typing import TypeVar

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp
from scipy.sparse.linalg import SuperLU, splu

from orchestrator.basis.arrays import FloatArray, IntArray

Scalar = TypeVar("Scalar", bound=np.generic)

ENTRIES = ((0, 0), (1, 1), (2, 0), (2, 1), (2, 2))
"""Row and column of a, b, c, d, e in the matrix of a joint."""
POINT_ENTRIES = ((0, 0), (1, 0), (1, 1))
"""Row and column of what can differ from 0 in the matrix of a point of a joint (opening, slip)."""
MOST = 6
"""Rows that a joint unknown has entries in: two blocks, three degrees of freedom each."""
PIVOT = {"diag_pivot_thresh": 0.01, "options": {"SymmetricMode": True}}
"""Of SuperLU: the diagonal, unless it is far smaller than what stands below."""
SUPERLU_PANELS = {"relax": 1, "panel_size": 4}
"""Of SuperLU: short panels, 10 to 20 % less time than its own choice (146 and 2,979 blocks)."""

M_TRIM_THRESHOLD = -1
"""Of the GNU C library's mallopt: free memory at the end of the heap that goes back to the system."""
M_MMAP_THRESHOLD = -3
"""Of mallopt: the least block that comes from the system and goes back to it."""
KEEPS = 2**31 - 1
"""Bytes, for both, while walls are factorised again and again."""
AFTERWARDS = 2**25
"""Bytes, for both, from then on: the most that the C library comes to by itself."""


@contextmanager
def kept_memory() -> Iterator[None]:
    """Let the C library keep the memory of factors for the next ones, if it can.

    Otherwise the system hands out new pages for each large factorisation, a fifth of its time (10,326 unknowns). For
    the whole process: no other thread may begin or end the same meanwhile.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", lambda *_: 1)

    def keep(least: int) -> bool:
        return all(mallopt(threshold, least) for threshold in (M_TRIM_THRESHOLD, M_MMAP_THRESHOLD))

    if not keep(KEEPS):  # some allow no more
        keep(AFTERWARDS)
    try:
        yield
    finally:
        keep(AFTERWARDS)


def joint_products(joints: FloatArray, vectors: FloatArray) -> FloatArray:
    """Return J times vectors (k, 3), joint by joint; joints (k, 5) as ENTRIES."""
    a, b, c, d, e = joints.T
    start, end, slip = vectors.T
    return np.column_stack([a * start, b * end, c * start + d * end + e * slip])


def point_products(points: FloatArray, vectors: FloatArray) -> FloatArray:
    """Return J times vectors (k, 2), point by point; points (k, 3) as POINT_ENTRIES."""
    a, c, e = points.T
    opening, slip = vectors.T
    return np.column_stack([a * opening, c * opening + e * slip])


class Factors:
    """Factors of a wall's matrix."""

    def __init__(self, order: IntArray, factors: SuperLU) -> None:
        """Take the factors of rows and columns in the given order."""
        self._order, self._factors = order, factors

    def solve(self, loads: FloatArray) -> FloatArray:
        """Return velocities (..., 3m) for loads (..., 3m); two loads at once cost little more than one."""
        velocities = np.empty_like(loads)
        velocities[..., self._order] = self._factors.solve(loads[..., self._order].T).T
        return velocities


class WallStiffness:
    """What the matrices B J B^T of one wall have in common."""

    def __init__(self, B: sp.spmatrix, entries: tuple[tuple[int, int], ...] = ENTRIES) -> None:
        """Find the order to eliminate in, and in it the pattern of B J B^T, for B (3m, 3k), or (3m, 2k) for points."""
        size, each, B = B.shape[0], entries[-1][0] + 1, B.tocsc()
        self._order = _order(B, each)
        self._pairs = [(slice(i, None, each), slice(j, None, each)) for i, j in entries]
        rows = _filled(B, np.argsort(self._order)[B.indices])
        places = np.stack([size * rows[j, None, :] + rows[i, :, None] for i, j in self._pairs], axis=1).ravel()
        there = np.flatnonzero(self._products(_filled(B, np.ones(B.nnz))))
        diagonal = np.arange(size) * (size + 1)
        found, number = np.unique(np.concatenate([places[there], diagonal]), return_inverse=True)
        shape = len(found), len(places) // MOST**2
        self._map = sp.csr_matrix((there.astype(float), (number[: len(there)], there // MOST**2)), shape=shape)
        self._there = self._map.data.astype(np.int64)
        self._map.data = self._products(_filled(B, B.data))[self._there]
        self._diagonal = number[len(there) :]
        column, row = np.divmod(found, size)
        pattern = row.astype(np.int32), np.searchsorted(column, np.arange(size + 1)).astype(np.int32)
        self._matrix = sp.csc_matrix((np.ones(len(found)), *pattern), shape=(size, size))
        self._matrix.sum_duplicates()  # there are none; from now on nobody asks again

    def _products(self, values: FloatArray) -> FloatArray:
        """Return every product of two entries that the columns of a joint have, of values (columns, MOST)."""
        return np.stack([values[i, :, None] * values[j, None, :] for i, j in self._pairs], axis=1).ravel()

    def of(self, B: sp.csc_matrix) -> WallStiffness:
        """Return the same of another B that has its entries in the same places."""
        other = copy(self)
        products = self._products(_filled(B, B.data))[self._there]
        other._map = sp.csr_matrix((products, self._map.indices, self._map.indptr), shape=self._map.shape)
        return other

    def factorised(self, joints: FloatArray, drag: FloatArray | float = 0.0) -> Factors:
        """Return the factors of B J B^T + drag I for joints (k, 5) as ENTRIES, or points (k, 3) as POINT_ENTRIES.

        drag: of every row, or of each (3m,). Raises RuntimeError when the matrix is singular to rounding.
        """
        values = self._map @ joints.ravel()
        values[self._diagonal] += np.broadcast_to(drag, len(self._order))[self._order]
        self._matrix.data = values
        return Factors(self._order, splu(self._matrix, permc_spec="NATURAL", **PIVOT, **SUPERLU_PANELS))


def _order(B: sp.spmatrix, each: int) -> IntArray:
    """Return the rows of B (3m, k each) in an order in which B J B^T has little fill-in."""
    beside = abs(B) @ sp.kron(sp.identity(B.shape[1] // each), np.ones((each, 1)))
    pattern = beside @ beside.T + sp.identity(B.shape[0])
    order: IntArray = np.argsort(splu(pattern.tocsc(), permc_spec="MMD_AT_PLUS_A", **PIVOT).perm_c)
    return order


def _filled(B: sp.csc_matrix, values: npt.NDArray[Scalar]) -> npt.NDArray[Scalar]:
    """Return values of the entries of B as (columns, MOST), filled up with zeros."""
    filled = np.zeros((B.shape[1], MOST), dtype=values.dtype)
    column = np.repeat(np.arange(B.shape[1]), np.diff(B.indptr))
    filled[column, np.arange(B.nnz) - B.indptr[column]] = values
    return filled
