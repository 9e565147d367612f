"""Outlines that nearly touch -> one planar map: vertices, and straight edges with the block on either side.

Every later stage refers to its vertices and edges by number, so nothing is searched for by distance again. Outlines are
joined from the smallest distance to the largest:

    corners of two blocks that lie nearer than the present distance become one vertex,
    a vertex that lies so near to an edge of another block becomes a vertex of that edge.

Only edges that have no block on the other side yet take part, and the distance grows step by step up to the tolerance.
What a small tolerance joins is therefore joined in the same way by a larger one. A vertex lies where the lines half-way
between the drawn edges meet. Where nothing had to be joined over a distance, no coordinate moves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray, read_only
from orchestrator.geometry.outline_rings import Rings
from orchestrator.geometry.placed_rings import place, place_on_lines
from orchestrator.geometry.tidied_rings import collapse, measure, straighten

NO_BLOCK = -1
"""the block on the right of an edge that has none"""
TIP = 6.0
"""a tip of 10 degrees ends so many errors from where it would without any: overlaps of its two sides are that long"""
GROWTH = 2.0
"""factor from the smallest distance that is still open to the distance joined next"""


@dataclass(frozen=True, eq=False, slots=True)
class PlanarMap:
    """v vertices and e straight edges of the outlines of n blocks.

    vertex (v, 2) in m; start, end (e,): vertices, counter-clockwise round the block left (e,); right (e,): the block
    beyond, of a larger number, or NO_BLOCK. width (e,) in m: what lay between both blocks as drawn, negative for an
    overlap, 0 where they touched. The outline of block b is ring_edge[first[b]:first[b + 1]], from its first corner;
    ring_forward tells whether b is the edge's left block.
    error: largest distance in m over which anything was joined; tips: distances (m) beyond the tolerance over which the
    ends of acute tips that overlap were joined; collapsed: lengths (m) of short edges that became points; straightened:
    by how much (m) the straight edge between two blocks is off what was drawn there.
    """

    vertex: FloatArray
    start: IntArray
    end: IntArray
    left: IntArray
    right: IntArray
    width: FloatArray
    ring_edge: IntArray
    ring_forward: BoolArray
    first: IntArray
    error: float
    straightened: float
    tips: tuple[float, ...] = ()
    collapsed: tuple[float, ...] = ()

    def ring(self, block: int) -> IntArray:
        """Return the vertices of the outline of `block`, counter-clockwise from its first corner."""
        part = slice(self.first[block], self.first[block + 1])
        edge = self.ring_edge[part]
        return np.where(self.ring_forward[part], self.start[edge], self.end[edge])


class OverlapError(ValueError):
    """Two blocks lie on the same side of one edge: `blocks`, near `point` (2,) in m."""

    def __init__(self, blocks: tuple[int, int], point: FloatArray) -> None:
        super().__init__(blocks, point)
        self.blocks, self.point = blocks, point


def planar_map(
    outlines: Sequence[FloatArray], tolerance: float, bend: float = 0.0, short: float = 0.0, known_error: float = 0.0
) -> PlanarMap:
    """Return the planar map of counter-clockwise `outlines` (n, 2); tolerance in m. Raises OverlapError.

    bend: what lies between two blocks is one straight edge where it bends by no more than this part of its length.
    short: edges below this part of a block's size become points. known_error in m: over what distance the lines of the
    outlines had to be joined before.
    """
    rings = Rings(outlines)
    tolerance += rings.rounding  # a gap as wide as the tolerance is closed, whatever its last digit
    error, reached = known_error, 0.0
    tips, collapsed = list[float](), list[float]()
    while True:
        while len(open_ := rings.distances(tolerance, reached)):
            reached = min(tolerance, GROWTH * max(float(open_.min()), rings.rounding))
            while joined := rings.join_corners(reached) + rings.join_edges(reached):
                error = max(error, max(joined))
                place(rings)
        if error <= rings.rounding and not short:
            break
        place_on_lines(rings)
        collapsed += collapse(rings, error, short)
        place(rings)
        place_on_lines(rings)
        if len(rings.distances(tolerance, reached)):
            continue
        folds = rings.join_folds(tolerance, TIP)
        tips += [apart for apart in folds if apart > tolerance]
        ends = rings.join_gap_ends(tolerance, TIP)
        collapsed += ends
        if not folds and not ends:
            break
    measure(rings)
    straightened = straighten(rings, max(error, rings.rounding), tolerance, bend)
    return replace(_as_map(rings, error, straightened), tips=tuple(tips), collapsed=tuple(collapsed))


def _as_map(rings: Rings, error: float, straightened: float) -> PlanarMap:
    """Return joined rings as vertices and edges. Raises OverlapError where two have one edge on the same side."""
    key, _ = rings.keys()
    order = np.argsort(key, kind="stable")
    twice = np.flatnonzero(np.diff(key[order]) == 0)
    if len(twice):
        rows = order[twice[0] : twice[0] + 2]
        one, other = sorted(rings.block[rows].tolist())
        raise OverlapError((one, other), rings.point[rings.vertex[rows[0]]])
    twin = rings.twins()
    beyond = np.where(twin >= 0, rings.block[twin], NO_BLOCK)
    forward = (beyond == NO_BLOCK) | (rings.block < beyond)
    number = np.cumsum(forward) - 1
    rows = np.flatnonzero(forward)
    used, vertex = np.unique(rings.vertex, return_inverse=True)
    vertex = vertex.ravel()
    return PlanarMap(
        vertex=read_only(rings.point[used]),
        start=read_only(vertex[rows], np.int64),
        end=read_only(vertex[rings.following[rows]], np.int64),
        left=read_only(rings.block[rows], np.int64),
        right=read_only(beyond[rows], np.int64),
        width=read_only(rings.width[rows]),
        ring_edge=read_only(np.where(forward, number, number[twin]), np.int64),
        ring_forward=read_only(forward, bool),
        first=read_only(np.append(np.flatnonzero(np.diff(rings.block, prepend=-1)), len(rings.block)), np.int64),
        error=error if error > rings.rounding else 0.0,
        straightened=straightened if straightened > rings.rounding else 0.0,
    )
