"""Edges of 10-node tetrahedra (numpy only): the displacement of their middles is an unknown unless on the outline."""

from __future__ import annotations

import numpy as np

from orchestrator.basis.arrays import BoolArray, IntArray
from orchestrator.pushover.meshing import BodyMeshes

TETRAHEDRON_EDGES = np.array([(2, 3), (1, 3), (1, 2), (0, 3), (0, 2), (0, 1)])
"""vertices of the edges of a tetrahedron, in the order of the form compiler's middle nodes"""


def edges_of(tetrahedra: IntArray) -> IntArray:
    """Return the edges (e, 2) of the tetrahedra (t, 4), smaller node number first, in ascending order."""
    pairs = tetrahedra[:, TETRAHEDRON_EDGES].reshape(-1, 2)
    return np.unique(np.sort(pairs, axis=1), axis=0)


def on_outline(edges: IntArray, meshes: BodyMeshes) -> BoolArray:
    """Return which edges (e, 2) belong to a triangle on the outline."""
    triangles = np.sort(meshes.side_triangles, axis=1)
    sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [0, 2]], triangles[:, [1, 2]]])
    width = len(meshes.nodes)
    return np.isin(edges @ [width, 1], sides @ [width, 1])
