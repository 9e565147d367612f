"""The volume that two polyhedra share.

A body is the signed sum of the tetrahedra from one of its corners to the triangles of its surface, so the common volume
is the signed sum over pairs of convex pieces (a convex body is one piece). Two convex pieces are halfspaces together:
their common volume is that of the intersection's hull.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.geometry.polyhedra import Polyhedron, face_normals, fans, is_convex

THINNEST_VOLUME = 1e-7
"""Part of the bodies' size: an intersection whose largest inscribed ball is smaller has no volume."""


def common_volume(one: Polyhedron, other: Polyhedron) -> float:
    """Return the volume in m3 that two bodies share."""
    size = min(one.size, other.size)
    return sum(
        sign * other_sign * _of_convex(np.vstack([piece, other_piece]), size)
        for (sign, piece), (other_sign, other_piece) in product(_pieces(one), _pieces(other))
    )


def _pieces(body: Polyhedron) -> list[tuple[float, FloatArray]]:
    """Return signs and halfspaces (h, 4) (normal . x + offset <= 0) of convex pieces that add up to the body."""
    if is_convex(body):
        normal = face_normals(body)
        corner = np.array([body.vertices[face[0]] for face in body.faces])
        return [(1.0, np.column_stack([normal, -np.einsum("fi,fi->f", normal, corner)]))]
    apex, pieces = body.vertices[0], []
    for a, b, c in body.vertices[fans(body)]:
        sixfold = float((a - apex) @ np.cross(b - apex, c - apex))
        if abs(sixfold) > 1e-12 * body.size**3:
            pieces.append((float(np.sign(sixfold)), _tetrahedron(np.array([apex, a, b, c]))))
    return pieces


def _tetrahedron(corners: FloatArray) -> FloatArray:
    """Return the halfspaces (4, 4) of a tetrahedron."""
    rows = []
    for k in range(4):
        a, b, c = np.delete(corners, k, axis=0)
        normal = np.cross(b - a, c - a)
        normal /= np.linalg.norm(normal)
        normal = -normal if normal @ (corners[k] - a) > 0 else normal
        rows.append([*normal, -normal @ a])
    return np.array(rows)


def _of_convex(halfspaces: FloatArray, size: float) -> float:
    """Return the volume of the intersection of halfspaces, 0 where no ball of THINNEST_VOLUME size fits in."""
    from scipy.optimize import linprog
    from scipy.spatial import ConvexHull, HalfspaceIntersection, QhullError

    rows = np.column_stack([halfspaces[:, :3], np.ones(len(halfspaces))])
    ball = linprog([0, 0, 0, -1], A_ub=rows, b_ub=-halfspaces[:, 3], bounds=[(None, None)] * 3 + [(0, size)])
    if not ball.success or ball.x[3] < THINNEST_VOLUME * size:
        return 0.0
    try:
        return float(ConvexHull(HalfspaceIntersection(halfspaces, ball.x[:3]).intersections).volume)
    except QhullError:
        return 0.0
