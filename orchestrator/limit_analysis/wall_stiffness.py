"""Stiffness of a wall from those of its joints, B J B^T, for ever new joints: assembled and ordered once.

J has a 3 x 3 matrix for each joint (opening at start, at end, slip). Friction makes shear depend on normal forces,
never the reverse, so that five of its entries can differ from 0:

    [[a, 0, 0], [0, b, 0], [c, d, e]]

The entries of the wall's matrix are linear in those of the joints; that map and an order of elimination with little
fill-in are found once. Per factorisation, product and order cost more than the elimination itself at 146 blocks.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import SuperLU, splu

from orchestrator.masonry.wall import FloatArray, IntArray

ENTRIES = ((0, 0), (1, 1), (2, 0), (2, 1), (2, 2))
"""Row and column of a, b, c, d, e in the matrix of a joint."""
MOST = 6
"""Rows that a joint unknown has entries in: two blocks, three degrees of freedom each."""
PIVOT = {"diag_pivot_thresh": 0.01, "options": {"SymmetricMode": True}}
"""Of SuperLU: the diagonal, unless it is far smaller than what stands below."""
PANEL = {"relax": 1, "panel_size": 4}
"""Of SuperLU: short panels, 10 to 20 % less time than its own choice (146 and 2,979 blocks)."""


def joint_products(joints: FloatArray, vectors: FloatArray) -> FloatArray:
    """Return J times vectors (k, 3), joint by joint; joints (k, 5) as ENTRIES."""
    a, b, c, d, e = joints.T
    start, end, slip = vectors.T
    return np.column_stack([a * start, b * end, c * start + d * end + e * slip])


class Factors:
    """Factors of a wall's matrix."""

    def __init__(self, order: IntArray, factors: SuperLU) -> None:
        """Take the factors of rows and columns in the given order."""
        self._order, self._factors = order, factors

    def solve(self, load: FloatArray) -> FloatArray:
        """Return velocities (3m,) for a load (3m,)."""
        velocities = np.empty_like(load)
        velocities[self._order] = self._factors.solve(load[self._order])
        return velocities


class WallStiffness:
    """What the matrices B J B^T of one wall have in common."""

    def __init__(self, B: sp.spmatrix) -> None:
        """Find the pattern of B J B^T for B (3m, 3k), and the order to eliminate in."""
        size, (rows, values) = B.shape[0], _columns(B)
        first = [(rows[i::3, :, None], values[i::3, :, None]) for i, _ in ENTRIES]
        second = [(rows[j::3, None, :], values[j::3, None, :]) for _, j in ENTRIES]
        products = np.stack([v * w for (_, v), (_, w) in zip(first, second, strict=True)], axis=1).ravel()
        places = np.stack([size * c + r for (r, _), (c, _) in zip(first, second, strict=True)], axis=1).ravel()
        there = products != 0.0
        diagonal = np.arange(size) * (size + 1)
        found, number = np.unique(np.concatenate([places[there], diagonal]), return_inverse=True)
        entry = np.repeat(np.arange(len(places) // MOST**2), MOST**2)[there]
        column, row = np.divmod(found, size)
        pattern = sp.csc_matrix((np.ones(len(found)), row, np.searchsorted(column, np.arange(size + 1))))
        self._order = _order(pattern)
        rank = np.argsort(self._order)
        sorted_places = np.lexsort([rank[row], rank[column]])
        moved = np.argsort(sorted_places)[number]
        shape = len(found), len(places) // MOST**2
        self._map = sp.csr_matrix((products[there], (moved[: len(entry)], entry)), shape=shape)
        self._diagonal = moved[len(entry) :]
        start = np.searchsorted(rank[column][sorted_places], np.arange(size + 1))
        self._pattern = rank[row][sorted_places].astype(np.int32), start.astype(np.int32)

    def factorised(self, joints: FloatArray, drag: float = 0.0) -> Factors:
        """Return the factors of B J B^T + drag I for joints (k, 5) as ENTRIES.

        Raises RuntimeError when the matrix is singular to rounding.
        """
        values = self._map @ joints.ravel()
        values[self._diagonal] += drag
        size = len(self._order)
        matrix = sp.csc_matrix((values, *self._pattern), shape=(size, size))
        return Factors(self._order, splu(matrix, permc_spec="NATURAL", **PIVOT, **PANEL))


def _columns(B: sp.spmatrix) -> tuple[IntArray, FloatArray]:
    """Return the rows and values (3k, MOST) of every column's entries, filled up with zeros."""
    B = B.tocsc()
    rows, values = np.zeros((B.shape[1], MOST), dtype=np.int64), np.zeros((B.shape[1], MOST))
    column = np.repeat(np.arange(B.shape[1]), np.diff(B.indptr))
    place = np.arange(B.nnz) - B.indptr[column]
    rows[column, place], values[column, place] = B.indices, B.data
    return rows, values


def _order(pattern: sp.csc_matrix) -> IntArray:
    """Return rows (and columns) of a symmetric pattern in an order with little fill-in."""
    matrix = pattern + sp.diags(pattern.sum(axis=0).A1)
    order: IntArray = np.argsort(splu(matrix, permc_spec="MMD_AT_PLUS_A", **PIVOT).perm_c)
    return order
