"""How deep plane outlines lie in each other.

The depth of an overlap is the largest distance by which a point of either outline lies inside the other: d for a
rectangle that is pressed into another one by d, the height over the face for a corner pressed into it, the largest
thickness of a sliver along a bed. It is the least translation that parts the two there. Points on both outlines have
none, so edges that coincide, and overlaps elsewhere, take nothing from it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import shapely

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray

GRID = 1e-12
"""Over the size of the smallest shape (the root of its area): what coordinates are rounded to. Without a grid, edges
that coincide to the last digits now and then have all of a thin polygon as their overlap (their order decides)."""
LAST_DIGITS = 16.0
"""Of the farthest coordinate, to which coordinates are rounded at least: they are larger far from the origin."""


@dataclass(frozen=True, eq=False, slots=True)
class Penetrations:
    """Pairs (p, 2) of shapes that overlap, the depth (p,) in m of each, and where it is that deep (p, 2), m."""

    pair: IntArray
    depth: FloatArray
    place: FloatArray


def penetrations(shapes: npt.NDArray[np.object_], free: BoolArray, farthest: float) -> Penetrations:
    """Return the overlaps of polygons (n,) of which at least one is `free` (n,).

    farthest: largest coordinate that they were drawn with, m, before they were moved to where they are compared.
    """
    grid = max(GRID * float(np.sqrt(shapely.area(shapes).min())), LAST_DIGITS * float(np.spacing(farthest)))
    pair = shapely.STRtree(shapes).query(shapes, predicate="intersects").T
    pair = pair[(pair[:, 0] < pair[:, 1]) & free[pair].any(axis=1)]
    common = shapely.intersection(*shapes[pair].T, grid_size=grid)
    points, of = _outline_points(common)
    outlines = shapely.boundary(shapes)
    inside = np.max([shapely.distance(shapely.points(points), outlines[side]) for side in pair[of].T], axis=0)
    depth, deepest = np.zeros(len(pair)), np.zeros(len(pair), np.int64)
    order = np.argsort(inside, kind="stable")
    depth[of[order]], deepest[of[order]] = inside[order], order  # the last of each pair is the deepest
    found = depth > 0.0
    return Penetrations(pair[found], depth[found], points[deepest[found]] + 0.0)  # no -0


def _outline_points(common: npt.NDArray[np.object_]) -> tuple[FloatArray, IntArray]:
    """Return corners and middles of edges (m, 2) of the polygons in geometries, and of which (m,): two bars that cross
    have no corner in each other."""
    part, of_part = shapely.get_parts(common, return_index=True)
    ring, of_ring = shapely.get_rings(part, return_index=True)
    corner, of_corner = shapely.get_coordinates(ring, return_index=True)
    edge = np.flatnonzero(of_corner[1:] == of_corner[:-1])
    points = np.vstack([corner, 0.5 * (corner[edge] + corner[edge + 1])])
    return points, of_part[of_ring[np.append(of_corner, of_corner[edge])]]
