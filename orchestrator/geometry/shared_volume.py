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


def common_volume(one: Polyhedron, other: Polyhedron, thinnest: float = 0.0) -> float:
    """Return the volume in m3 that two bodies share; of two that are convex, without what is no thicker than `thinnest`
    m."""
    size, pieces, other_pieces = min(one.size, other.size), _pieces(one, thinnest), _pieces(other, thinnest)
    thinnest = thinnest if len(pieces) == len(other_pieces) == 1 else 0.0  # signs cancel between thin ones, too
    return sum(
        sign * other_sign * _of_convex(np.vstack([piece, other_piece]), size, thinnest)
        for (sign, piece), (other_sign, other_piece) in product(pieces, other_pieces)
    )


def _pieces(body: Polyhedron, off: float) -> list[tuple[float, FloatArray]]:
    """Return signs and halfspaces (h, 4) (normal . x + offset <= 0) of convex pieces that make a body, to `off` m."""
    if is_convex(body, off):
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


def _of_convex(halfspaces: FloatArray, size: float, thinnest: float) -> float:
    """Return the volume of the intersection of halfspaces, 0 where the largest ball that fits in has no larger diameter
    than `thinnest`, or no radius of THINNEST_VOLUME size."""
    from scipy.optimize import linprog
    from scipy.spatial import ConvexHull, HalfspaceIntersection, QhullError

    rows = np.column_stack([halfspaces[:, :3], np.ones(len(halfspaces))])
    ball = linprog([0, 0, 0, -1], A_ub=rows, b_ub=-halfspaces[:, 3], bounds=[(None, None)] * 3 + [(0, size)])
    if not ball.success or ball.x[3] < max(THINNEST_VOLUME * size, thinnest / 2.0):
        return 0.0
    try:
        return float(ConvexHull(HalfspaceIntersection(halfspaces, ball.x[:3]).intersections).volume)
    except QhullError:
        return 0.0
