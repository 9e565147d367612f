"""Drawn outlines that nearly touch -> outlines that do, and what lay between them as drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.geometry.outline_rings import SAME_POINT
from orchestrator.geometry.planar_map import NO_BLOCK, PlanarMap, planar_map
from orchestrator.geometry.rigid import cross

BEND = 1 / 20
"""part of its length by which the joint of two blocks may bend where a drawing has arcs, and still be one straight
joint: an arc of 23 degrees (the extrados of a voussoir), whatever chords it came as"""
SHORT_EDGE = 0.01
"""part of a block's size below which an edge of it is the error of a drawing, not a joint; it would only make slivers
of finite elements"""
VISIBLE = 0.125
"""part of the smaller block's size (root of its area) below which a gap between two blocks is hardly meant as one"""
FACING_COSINE = 0.9
"""cosine of the largest angle between two edges that face each other"""
BESIDE = 0.25
"""part of the shorter of two edges along which they face each other"""
SAME_CORNER = 1e-7
"""part of a block's size below which two corners in a row are one, drawn twice"""
WIDTH_ROUNDING = 1e-6
"""part of the smallest block's size: a width below it is rounding"""


@dataclass(frozen=True, slots=True)
class Gap:
    """What lay between outlines `i` < `j` (positions): `width` in m, negative for an overlap, at the point `at` (m)."""

    i: int
    j: int
    width: float
    at: tuple[float, float]


def heal(
    outlines: Sequence[FloatArray], tolerance: float, known_error: float = 0.0, curved: bool = False
) -> tuple[list[FloatArray], PlanarMap]:
    """Return outlines (n, 2) of which neighbours share their vertices, and the planar map that they are.

    outlines: counter-clockwise; tolerance in m: largest gap or overlap that is closed; known_error in m: what was
    closed before, between the lines of a drawing; curved: arcs came as chords, and a joint along an arc becomes
    straight (BEND). Raises OverlapError for blocks that lie on one another.
    """
    drawn = [_corners(outline) for outline in outlines]
    joined = planar_map(drawn, tolerance, BEND if curved else 0.0, SHORT_EDGE, known_error)
    return [_corners(joined.vertex[joined.ring(block)]) for block in range(len(outlines))], joined


def _corners(ring: FloatArray) -> FloatArray:
    """Return the ring (n, 2) without points that come twice in a row, or lie on its straight edges as the corners of
    other blocks do."""
    apart = np.linalg.norm(ring - np.roll(ring, 1, axis=0), axis=1)
    ring = ring[~(apart < SAME_CORNER * np.ptp(ring, axis=0).max())]
    chord, arm = np.roll(ring, -1, axis=0) - np.roll(ring, 1, axis=0), ring - np.roll(ring, 1, axis=0)
    height = np.abs(cross(chord, arm))
    corners = ring[~(height < SAME_POINT * np.sum(chord**2, axis=1))]
    return read_only(corners if len(corners) > 2 else ring)


def closed_gaps(joined: PlanarMap) -> list[Gap]:
    """Return for each pair of blocks the widest gap or overlap that was closed between them."""
    size = _sizes(joined)
    edges = np.flatnonzero((joined.right != NO_BLOCK) & (np.abs(joined.width) > WIDTH_ROUNDING * size.min()))
    widest: dict[tuple[int, int], int] = {}
    for edge in edges[np.argsort(-np.abs(joined.width[edges]), kind="stable")].tolist():
        widest.setdefault((int(joined.left[edge]), int(joined.right[edge])), edge)
    middle = 0.5 * (joined.vertex[joined.start] + joined.vertex[joined.end])
    return [Gap(i, j, float(joined.width[e]), _place(middle[e])) for (i, j), e in sorted(widest.items())]


def open_gaps(joined: PlanarMap) -> list[Gap]:
    """Return what looks like joints that were not closed: edges of two blocks without a block beyond, facing each other
    over less than a visible width; the narrowest of each pair of blocks."""
    free = np.flatnonzero(joined.right == NO_BLOCK)
    if len(free) < 2:
        return []
    a, b = joined.vertex[joined.start[free]], joined.vertex[joined.end[free]]
    length = np.linalg.norm(b - a, axis=1)
    tangent = (b - a) / length[:, None]
    block = joined.left[free]
    visible = VISIBLE * _sizes(joined)[block]
    segments = shapely.linestrings(np.stack([a, b], axis=1))
    i, j = shapely.STRtree(segments).query(segments, predicate="dwithin", distance=visible)
    keep = (block[i] != block[j]) & (np.sum(tangent[i] * tangent[j], axis=1) < -FACING_COSINE)
    i, j = i[keep], j[keep]
    along = [np.sum((p[j] - a[i]) * tangent[i], axis=1) for p in (b, a)]  # in the direction of edge i
    outward = np.column_stack([tangent[:, 1], -tangent[:, 0]])[i]
    first, last = np.maximum(along[0], 0.0), np.minimum(along[1], length[i])
    off = [np.sum((p[j] - a[i]) * outward, axis=1) for p in (b, a)]
    share = (0.5 * (first + last) - along[0]) / (along[1] - along[0])
    width = off[0] + share * (off[1] - off[0])
    narrow = np.abs(width) < np.minimum(visible[i], visible[j])
    facing = narrow & (last - first > BESIDE * np.minimum(length[i], length[j]))
    gaps: dict[tuple[int, int], Gap] = {}
    middle = a[i] + (0.5 * (first + last))[:, None] * tangent[i] + 0.5 * width[:, None] * outward
    for k in np.flatnonzero(facing)[np.argsort(np.abs(width[facing]), kind="stable")].tolist():
        one, other = sorted((int(block[i[k]]), int(block[j[k]])))
        gaps.setdefault((one, other), Gap(one, other, float(width[k]), _place(middle[k])))
    return [gaps[pair] for pair in sorted(gaps)]


def _sizes(joined: PlanarMap) -> FloatArray:
    """Return the root of each block's area (n,) in m."""
    rings = [joined.vertex[joined.ring(block)] for block in range(len(joined.first) - 1)]
    return np.sqrt(np.abs(shapely.area([shapely.Polygon(ring) for ring in rings])))


def _place(point: FloatArray) -> tuple[float, float]:
    return float(point[0]), float(point[1])
