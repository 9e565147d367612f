"""Groups of things that pairs connect."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from orchestrator.basis.arrays import IntArray


def connected_groups(count: int, one: npt.ArrayLike, other: npt.ArrayLike) -> IntArray:
    """Return for each of `count` things the number of its group (count,), from 0; pairs (k,), (k,) connect them."""
    pairs = np.array([one, other], dtype=np.int64).reshape(2, -1)
    return connected_components(coo_matrix((np.ones(pairs.shape[1]), pairs), shape=(count, count)), directed=False)[1]
