"""Displaced outlines alone: how deep bodies overlap, and how far those that press each other are apart.

Checks on contacts that know nothing of where these are: of forces only that they act between two bodies.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import shapely

from orchestrator.basis.arrays import FloatArray, IntArray
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.pushover.increments import BodyMask
from orchestrator.pushover.meshing import BodyMeshes

GRID = 1e-12
"""of coordinates, over the size of the smallest body: without one, edges that coincide to the last digits now and then
have all of a thin stone as their overlap (the polygons' order decides)"""
LAST_DIGITS = 16.0
"""of the farthest coordinate, to which coordinates are rounded at least: they are larger far from the origin"""
PRESSES = 0.01
"""share of the lighter body's weight from which the force between two bodies counts: ten times what a static body may
be out of balance"""


def largest_overlap(
    bodies: Bodies, meshes: BodyMeshes, displacement: FloatArray, fallen: BodyMask, closed: float = 0.0
) -> tuple[float, float]:
    """Return the largest depth in m of the overlap of two bodies displaced by `displacement` (>= m, 3) in m.

    And that over the size of the smaller body, the square root of its area. The depth of an overlap is its area over
    half its perimeter: the mean thickness of a sliver. Bodies that are `fallen` (b,) do not count, nor does the depth
    (m) by which mortar has `closed`.
    """
    standing = np.append(~fallen, np.ones(len(bodies.bodies) - bodies.moving, bool))
    shapes = np.array(_outlines(bodies, meshes, displacement), dtype=object)[standing]
    moving = int(bodies.moving - fallen.sum())
    first, second = shapely.STRtree(shapes).query(shapes, predicate="intersects")
    pairs = (first < second) & (first < moving)
    sizes = shapely.area(shapes)
    rounding = LAST_DIGITS * float(np.spacing(np.abs(meshes.nodes).max()))
    grid = max(GRID * float(np.sqrt(sizes.min())), rounding)
    common = shapely.intersection(shapes[first[pairs]], shapes[second[pairs]], grid_size=grid)
    area, length = shapely.area(common), shapely.length(common)
    depth = np.maximum(2.0 * area / np.where(length > 0.0, length, 1.0) - closed, 0.0)
    smaller = np.sqrt(np.minimum(sizes[first[pairs]], sizes[second[pairs]]))
    return float(np.max(depth, initial=0.0)), float(np.max(depth / smaller, initial=0.0))


def largest_pressed_gap(
    bodies: Bodies,
    meshes: BodyMeshes,
    displacement: FloatArray,
    fallen: BodyMask,
    pairs: tuple[IntArray, IntArray],
    normal_force: FloatArray,
    weight: FloatArray,
) -> tuple[float, float]:
    """Return the largest distance in m of two bodies that press each other, displaced by `displacement` (>= m, 3) in m.

    And that over the size of the smaller body, the square root of its area. pairs (c,), (c,): the bodies of contacts
    with normal_force (c,) in N; what they press by together counts from `PRESSES` of the lighter body's weight (b,) in
    N, and what pulls (a bond) does not. Bodies that are `fallen` (b,) do not count.
    """
    supports = len(bodies.bodies) - bodies.moving
    weights = np.append(weight, np.full(supports, np.inf))
    gone = np.append(fallen, np.zeros(supports, bool))
    both, contact = np.unique(np.sort(np.column_stack(pairs), axis=1), axis=0, return_inverse=True)
    force = np.bincount(contact.ravel(), np.maximum(normal_force, 0.0), len(both))
    first, second = both[(force > PRESSES * weights[both].min(axis=1)) & ~gone[both].any(axis=1)].T
    shapes = np.array(_outlines(bodies, meshes, displacement), dtype=object)
    sizes = np.sqrt(shapely.area(shapes))
    gap = shapely.distance(shapes[first], shapes[second])
    return float(np.max(gap, initial=0.0)), float(np.max(gap / np.minimum(sizes[first], sizes[second]), initial=0.0))


def _outlines(bodies: Bodies, meshes: BodyMeshes, displacement: FloatArray) -> list[shapely.Geometry]:
    """Return the outlines of all bodies displaced by `displacement` (>= m, 3) in m, about a node of the wall."""
    origin = meshes.nodes[0, :2]
    place = meshes.nodes[:, :2] - origin + displacement[: len(meshes.nodes), :2]
    moving = [_outline(meshes, body, place) for body in range(bodies.moving)]
    return moving + [shapely.Polygon(body.exterior - origin) for body in bodies.bodies[bodies.moving :]]


def _outline(meshes: BodyMeshes, body: int, place: FloatArray) -> shapely.Geometry:
    """Return the displaced outline of a body's face at z = 0, holes included; place (m, 2) of its nodes in m."""
    triangles = meshes.side_triangles[meshes.body_of_side == body]
    edges = np.vstack([triangles[:, list(pair)] for pair in pairwise((0, 1, 2, 0))])
    front = meshes.nodes[:, 2] <= 1e-9 * float(np.ptp(meshes.nodes[:, 2]))
    lines = shapely.linestrings(place[edges[front[edges].all(axis=1)]])
    rings = shapely.get_parts(shapely.polygonize([*lines]))
    return shapely.union_all(rings) if len(rings) == 1 else max(rings, key=shapely.area)
