"""Drawn outlines that nearly touch -> outlines that do: small gaps and overlaps between stones are closed.

Three steps, none of which moves a corner by more than the tolerance: edges that lie nearly on one line are put on it
(so that a bed joint stays straight and does not interlock by drawing errors), corners that nearly coincide are made
one, and a corner that still lies beside a neighbour's edge becomes a corner of that edge.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from orchestrator.masonry.wall import FloatArray, IntArray

EXACT = 1e-6
"""m: what lies nearer than this touches already (a tenth of the smallest joint tolerance in use)"""
PARALLEL = 0.02
"""sine of the angle below which two lines have no useful point of intersection"""
NEARLY = 10.0
"""gaps up to this many tolerances are listed as not closed"""


@dataclass(frozen=True, slots=True)
class Gap:
    """What lay between outlines `i` < `j` (positions): `width` in m, negative for an overlap; `closed` if healed."""

    i: int
    j: int
    width: float
    closed: bool


def heal(outlines: Sequence[FloatArray], tolerance: float) -> tuple[list[FloatArray], list[Gap]]:
    """Return outlines (n, 2) of which neighbours share their edges, and every gap or overlap found.

    tolerance in m: largest gap or overlap that is closed. Outlines that would lose their shape are returned unchanged.
    """
    aligned = _aligned(outlines, tolerance)
    joined = _joined(aligned, tolerance)
    points = np.unique(np.vstack(joined), axis=0)
    tree = shapely.STRtree(shapely.points(points))
    healed = [_with_corners(outline, points, tree, tolerance) for outline in joined]
    whole = [_whole(new, old) for old, new in zip(outlines, healed, strict=True)]
    return whole, list(_gaps(outlines, whole, tolerance))


def _aligned(outlines: Sequence[FloatArray], tolerance: float) -> list[FloatArray]:
    """Return the outlines with edges that lie within `tolerance` of one line put on that line."""
    start, end = np.vstack(outlines), np.vstack([np.roll(outline, -1, axis=0) for outline in outlines])
    before = np.concatenate([np.roll(r, 1) for r in _ranges(outlines)])
    point, normal, members = _lines(start, end, _collinear(start, end, tolerance))
    moved = _intersections(start, before, point, normal, members)
    far = np.linalg.norm(moved - start, axis=1) > tolerance
    moved[far] = start[far]
    return [moved[r] for r in _ranges(outlines)]


def _collinear(start: FloatArray, end: FloatArray, tolerance: float) -> IntArray:
    """Return a group number (e,) per edge; edges of a group are near each other and within `tolerance` of one line."""
    segments = shapely.linestrings(np.stack([start, end], axis=1))
    length = np.linalg.norm(end - start, axis=1)
    i, j = shapely.STRtree(segments).query(segments, predicate="dwithin", distance=tolerance)
    keep = (length[i] > length[j]) | ((length[i] == length[j]) & (i < j))
    i, j = i[keep], j[keep]
    along = (end - start)[i] / np.maximum(length[i], 1e-300)[:, None]
    off = np.stack([_cross(along, points[j] - start[i]) for points in (start, end)])
    near = (np.abs(off).max(axis=0) <= tolerance) & (length[j] > 2 * tolerance)
    pairs = (np.ones(np.count_nonzero(near)), (i[near], j[near]))
    return connected_components(coo_matrix(pairs, shape=(len(start), len(start))), directed=False)[1]


def _lines(start: FloatArray, end: FloatArray, group: IntArray) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return a point and the normal (e, 2) of the line that fits an edge's group best, and the group's size (e,)."""
    weight = np.linalg.norm(end - start, axis=1)
    total = np.maximum(np.bincount(group, weight), 1e-300)
    point = np.column_stack([np.bincount(group, weight * 0.5 * (start + end)[:, k]) / total for k in (0, 1)])[group]
    xx, xy, yy = (
        np.bincount(group, weight * sum(d[:, a] * d[:, b] for d in (start - point, end - point)))[group]
        for a, b in ((0, 0), (0, 1), (1, 1))
    )
    angle = 0.5 * np.arctan2(2 * xy, xx - yy)
    return point, np.column_stack([-np.sin(angle), np.cos(angle)]), np.bincount(group)[group]


def _intersections(
    corner: FloatArray, before: IntArray, point: FloatArray, normal: FloatArray, members: IntArray
) -> FloatArray:
    """Return each corner (e, 2) moved to where the lines of its two edges (`before` and its own) meet."""
    n, m = normal[before], normal
    c, d = ((p * q).sum(axis=1) for p, q in ((n, point[before] - corner), (m, point - corner)))
    sine = _cross(n, m)
    crossing = np.abs(sine) > PARALLEL
    safe = np.where(crossing, sine, 1.0)
    step = np.column_stack([(c * m[:, 1] - d * n[:, 1]) / safe, (n[:, 0] * d - m[:, 0] * c) / safe])
    larger = members[before] > members
    projected = np.where(larger[:, None], n * c[:, None], m * d[:, None])
    alone = (members[before] == 1) & (members == 1)
    return corner + np.where(alone[:, None], 0.0, np.where(crossing[:, None], step, projected))


def meeting(points: FloatArray, tolerance: float) -> tuple[IntArray, FloatArray]:
    """Return the group (p,) of each point (p, 2), those within `tolerance` of each other being one, and its mean."""
    places = shapely.points(points)
    pairs = shapely.STRtree(places).query(places, predicate="dwithin", distance=tolerance)
    matrix = coo_matrix((np.ones(pairs.shape[1]), pairs), shape=(len(points), len(points)))
    group = connected_components(matrix, directed=False)[1]
    size = np.bincount(group)
    return group, np.column_stack([np.bincount(group, points[:, k]) / size for k in (0, 1)])[group]


def _joined(outlines: list[FloatArray], tolerance: float) -> list[FloatArray]:
    """Return the outlines with corners within `tolerance` of each other at their mean, each corner once."""
    corners = np.vstack(outlines)
    group, mean = meeting(corners, tolerance)
    chain = np.bincount(group, np.linalg.norm(mean - corners, axis=1) > tolerance)[group] > 0
    joined = np.where(chain[:, None], corners, mean)
    return [_without_repeats(joined[r]) for r in _ranges(outlines)]


def _with_corners(outline: FloatArray, points: FloatArray, tree: shapely.STRtree, tolerance: float) -> FloatArray:
    """Return the outline with those `points` (p, 2) (`tree` of them) as corners that lie beside an edge, not on it."""
    pieces = []
    points = points[tree.query(shapely.LinearRing(outline), predicate="dwithin", distance=tolerance)]
    for start, end in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        length = float(np.linalg.norm(end - start))
        along = (end - start) / length
        place, off = (points - start) @ along, np.abs(_cross(along, points - start))
        beside = (off > EXACT) & (off <= tolerance) & (place > tolerance) & (place < length - tolerance)
        pieces.append(np.vstack([start, points[beside][np.argsort(place[beside])]]))
    return np.concatenate(pieces)


def _whole(outline: FloatArray, drawn: FloatArray) -> FloatArray:
    """Return a healed outline without the spikes that joining corners may leave; the drawn one if little is left."""
    if len(outline) >= 3 and (polygon := shapely.Polygon(outline)).is_valid:
        return outline
    if len(outline) >= 4:
        pieces = [p for p in shapely.get_parts(polygon.buffer(0)) if p.geom_type == "Polygon" and not p.interiors]
        largest = max(pieces, key=lambda piece: piece.area, default=shapely.Polygon())
        if largest.area > 0.9 * shapely.Polygon(drawn).area:
            return shapely.get_coordinates(largest.exterior)[:-1]
    return drawn


def _gaps(before: Sequence[FloatArray], after: Sequence[FloatArray], tolerance: float) -> Iterator[Gap]:
    """Yield gaps and overlaps wider than EXACT between neighbours as drawn; what has a stone in it is no gap."""
    drawn, healed = ([shapely.Polygon(outline) for outline in outlines] for outlines in (before, after))
    tree, standing = shapely.STRtree(drawn), shapely.STRtree(healed)
    for i, j in sorted(zip(*tree.query(drawn, predicate="dwithin", distance=NEARLY * tolerance), strict=True)):
        if i >= j:
            continue
        width = _width(drawn[i], drawn[j], tolerance)
        if abs(width) <= EXACT:
            continue
        closed = abs(_width(healed[i], healed[j], tolerance)) <= EXACT
        if closed or width < 0 or _is_void(healed[i], healed[j], width, healed, standing):
            yield Gap(int(i), int(j), width, closed)


def _is_void(
    first: shapely.Polygon,
    second: shapely.Polygon,
    width: float,
    outlines: list[shapely.Polygon],
    tree: shapely.STRtree,
) -> bool:
    """Return whether nothing fills the gap of `width` (m) between two outlines (else other stones meet there)."""
    between = first.buffer(width).intersection(second.buffer(width))
    stones = [outlines[k] for k in tree.query(between, predicate="intersects")]
    return bool(between.difference(shapely.union_all(stones)).area > 0.25 * width**2)


def _width(first: shapely.Polygon, second: shapely.Polygon, tolerance: float) -> float:
    """Return the widest gap (m) between two outlines where they are near, or minus the depth of their overlap."""
    common = first.intersection(second)
    if common.area > EXACT * min(first.length, second.length, max(common.length, tolerance)):
        return -2.0 * common.area / common.length
    apart = float(first.distance(second))
    if apart > tolerance:
        return apart
    corners = [(a, shapely.points(shapely.get_coordinates(b))) for a, b in ((first, second), (second, first))]
    near = np.concatenate([shapely.distance(outline, points) for outline, points in corners])
    return float(near[near <= tolerance].max(initial=apart))


def _without_repeats(outline: FloatArray) -> FloatArray:
    return outline[np.any(outline != np.roll(outline, 1, axis=0), axis=1)]


def _ranges(outlines: Sequence[FloatArray]) -> list[IntArray]:
    ends = np.cumsum([0, *(len(outline) for outline in outlines)])
    return [np.arange(first, last) for first, last in pairwise(ends)]


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    product: FloatArray = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return product
