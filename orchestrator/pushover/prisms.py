"""Tetrahedra of triangles that are extruded (numpy only)."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from orchestrator.basis.arrays import FloatArray, IntArray


def extruded_lines(lines: IntArray, above: int, layers: int) -> IntArray:
    """Return all triangles (f, 3) that the extrusion of `lines` (f, 2) may have, with either diagonal."""
    a, b = lines.T
    layer = np.concatenate([np.column_stack(corners) for corners in combinations((a, b, a + above, b + above), 3)])
    return np.concatenate([layer + number * above for number in range(layers)])


def extruded(plane: FloatArray, triangles: IntArray, layers: int) -> IntArray:
    """Return three tetrahedra of each prism over the triangles (t, 3), (3 t layers, 4); level k begins at node k m.

    The diagonal of every side runs from its left (or lower) edge at the bottom of the layer to the other edge at the
    top, whichever body it belongs to: two bodies that share a joint have the same triangles there, and node-to-surface
    contact passes the patch test. J. Dompierre et al., 8th Int. Meshing Roundtable (1999) 195-204; order: x, then y.
    """
    rank = np.empty(len(plane), np.int64)
    rank[np.lexsort(np.round(plane, 6).T[::-1])] = np.arange(len(plane))
    ordered = np.take_along_axis(triangles, np.argsort(rank[triangles], axis=1), axis=1)
    a, b, c = ordered.T
    above = len(plane)
    layer = np.concatenate(
        [
            np.column_stack([a, b, c, c + above]),
            np.column_stack([a, b, b + above, c + above]),
            np.column_stack([a, a + above, b + above, c + above]),
        ]
    )
    return np.concatenate([layer + number * above for number in range(layers)])
