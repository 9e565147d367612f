"""The outlines of blocks while they are being joined (planar_map.py): rings of common vertices."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence

import numpy as np
import shapely

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray
from orchestrator.geometry.rigid import cross
from orchestrator.geometry.ring_geometry import area_of, rows_between, sine_of_acute

SAME_POINT = 1e-9
"""part of the wall's size (and 1e-14 of its coordinates) below which two points are the same"""
FOLDED = 0.5
"""cosine of the largest angle at which two edges still run against each other"""
KEPT = 0.8
"""part of its area that a block keeps where one of its short edges is taken for a point"""


class Rings:
    """Outlines as rings of vertex numbers, while they are being joined.

    One row for every corner of a block, block after block: vertex, block, and line, the drawn edge that begins there. A
    row's edge runs to the row `following`. members: vertices and the points that blocks have there. low, high (v, 2):
    corners of the box round what collapsed into a vertex, NaN where nothing did.
    """

    def __init__(self, outlines: Sequence[FloatArray]) -> None:
        counts = np.array([len(outline) for outline in outlines])
        own = np.concatenate(outlines).astype(float)
        self.block = np.repeat(np.arange(len(counts)), counts)
        self.point, self.vertex = np.unique(own, axis=0, return_inverse=True)
        self.vertex = self.vertex.ravel()
        self._link()
        self.line, self.width = np.arange(len(own)), np.zeros(len(own))
        self.line_start, self.line_end = own, own[self.following]
        size = float(np.ptp(own, axis=0).max())
        self.rounding = SAME_POINT * size + 1e-14 * float(np.abs(own).max())
        self.spread = np.zeros(len(self.point))
        self.low, self.high = np.full((2, *self.point.shape), np.nan)
        self.members = [(self.vertex.copy(), own)]

    def _link(self) -> None:
        first = np.flatnonzero(np.diff(self.block, prepend=-1))
        self.following = np.arange(1, len(self.block) + 1)
        self.following[np.append(first[1:], len(self.block)) - 1] = first
        self.preceding = np.empty_like(self.following)
        self.preceding[self.following] = np.arange(len(self.block))

    def keys(self) -> tuple[IntArray, IntArray]:
        """Return a number for each row's edge, and that of the same edge seen from the other side."""
        there = self.vertex[self.following]
        return self.vertex * len(self.point) + there, there * len(self.point) + self.vertex

    def twins(self) -> IntArray:
        """Return for each row that of the other block along its edge, -1 where there is none."""
        key, reverse = self.keys()
        order = np.argsort(key, kind="stable")
        at = np.minimum(np.searchsorted(key[order], reverse), len(key) - 1)
        return np.where(key[order][at] == reverse, order[at], -1)

    def _open_rows(self) -> IntArray:
        """Return the rows whose edge has no other block."""
        key, reverse = self.keys()
        return np.flatnonzero(~np.isin(reverse, key))

    def _corner_pairs(self, within: float) -> tuple[IntArray, IntArray, FloatArray]:
        """Return pairs of vertices p < q on open edges that may belong together, and their distances.

        They are on different blocks. Two that an edge joins already belong together only where two blocks overlap there
        or leave a wedge open: an edge by itself is the end of a thin block, not a gap.
        """
        rows, size = self._open_rows(), len(self.point)
        vertices = np.unique(np.concatenate([self.vertex[rows], self.vertex[self.following[rows]]]))
        places = shapely.points(self.point[vertices])
        first, second = shapely.STRtree(places).query(places, predicate="dwithin", distance=within)
        p, q = (vertices[x[first < second]] for x in (first, second))
        key, reverse = self.keys()
        pair, opposite = p * size + q, q * size + p
        an_edge = np.isin(pair, key) | np.isin(pair, reverse)
        before, end, after = self._gap_ends(rows, within)
        between = (self.block[end] != self.block[before]) & (self.block[end] != self.block[after])
        allowed = np.concatenate([self._wedges(rows), key[end[between]]])
        an_edge &= ~(np.isin(pair, allowed) | np.isin(opposite, allowed))
        some_block = np.full(size, -1)
        some_block[self.vertex] = self.block
        shared = np.zeros(size, bool)
        shared[self.vertex[some_block[self.vertex] != self.block]] = True
        one_block = (some_block[p] == some_block[q]) & ~shared[p] & ~shared[q]
        p, q = p[~an_edge & ~one_block], q[~an_edge & ~one_block]
        return p, q, np.linalg.norm(self.point[p] - self.point[q], axis=1)

    def _wedges(self, rows: IntArray) -> IntArray:
        """Return pairs of vertices, as numbers of edges, at the open end of a wedge between two blocks.

        Of two blocks that meet in a vertex, one has an open edge that ends there, the other one that begins there
        (`rows` are the open ones); or both have the same edge on one side.
        """
        key, _ = self.keys()
        distinct, count = np.unique(key, return_counts=True)
        order = np.argsort(self.vertex[rows], kind="stable")
        begins = self.vertex[rows[order]]
        apex = self.vertex[self.following[rows]]
        low, high = np.searchsorted(begins, apex), np.searchsorted(begins, apex, side="right")
        coming = np.repeat(rows, high - low)
        nth = np.arange(len(coming)) - np.repeat(np.cumsum(high - low) - (high - low), high - low)
        leaving = rows[order][np.repeat(low, high - low) + nth]
        two = self.block[coming] != self.block[leaving]
        wedge = self.vertex[coming] * len(self.point) + self.vertex[self.following[leaving]]
        return np.concatenate([distinct[count > 1], wedge[two]])

    def _gap_ends(self, rows: IntArray, longest: float) -> tuple[IntArray, IntArray, IntArray]:
        """Return open edges no longer than `longest` (m) that close the end of a gap, with those before and after them.

        Those are of two blocks and run against each other; along the end of a thin block they run the same way.
        """
        there = self.vertex[self.following]
        along = self.point[there[rows]] - self.point[self.vertex[rows]]
        length = np.linalg.norm(along, axis=1)
        unit = along / np.maximum(length, 1e-300)[:, None]
        short = np.flatnonzero(length <= longest)
        ends = np.concatenate([self.vertex[rows[short]], there[rows[short]]])
        coming: dict[int, list[int]] = defaultdict(list)
        leaving: dict[int, list[int]] = defaultdict(list)
        for k in np.flatnonzero(np.isin(there[rows], ends) | np.isin(self.vertex[rows], ends)).tolist():
            coming[int(there[rows[k]])].append(k)
            leaving[int(self.vertex[rows[k]])].append(k)
        found = [
            (before, k, after)
            for k in short.tolist()
            for before in coming[int(self.vertex[rows[k]])]
            for after in leaving[int(there[rows[k]])]
            if self.block[rows[before]] != self.block[rows[after]] and unit[before] @ unit[after] < -FOLDED
        ]
        before, end, after = rows[np.array(found, dtype=int).reshape(-1, 3).T]
        return before, end, after

    def _beside(self, within: float) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
        """Return vertices, rows of open edges of blocks without them that they lie beside, place along and distance."""
        rows = self._open_rows()
        vertices = np.unique(np.concatenate([self.vertex[rows], self.vertex[self.following[rows]]]))
        a, b = self.point[self.vertex[rows]], self.point[self.vertex[self.following[rows]]]
        places = shapely.points(self.point[vertices])
        segments = shapely.linestrings(np.stack([a, b], axis=1))
        v, e = shapely.STRtree(segments).query(places, predicate="dwithin", distance=within)
        known = self.block * len(self.point) + self.vertex
        keep = ~np.isin(self.block[rows[e]] * len(self.point) + vertices[v], known)
        v, e = v[keep], e[keep]
        along, arm = (b - a)[e], self.point[vertices[v]] - a[e]
        square = np.sum(along**2, axis=1)
        place = np.sum(along * arm, axis=1) / square
        distance = np.abs(cross(along, arm)) / np.sqrt(square)
        beside = (place > 0) & (place < 1) & (distance <= within)
        order = np.lexsort((rows[e], distance, self.block[rows[e]], vertices[v]))
        order = order[beside[order]]
        pair = self.block[rows[e[order]]] * len(self.point) + vertices[v[order]]
        nearest = np.sort(np.unique(pair, return_index=True)[1])
        chosen = order[nearest]
        return vertices[v[chosen]], rows[e[chosen]], place[chosen], distance[chosen]

    def distances(self, tolerance: float, beyond: float) -> FloatArray:
        """Return the distances above `beyond`, in m, that are still to be joined."""
        apart = np.concatenate([self._corner_pairs(tolerance)[2], self._beside(tolerance)[3]])
        return apart[apart > beyond] if beyond else apart

    def join_corners(self, within: float) -> list[float]:
        """Join vertices, the nearest first; return the distances that were joined."""
        p, q, distance = self._corner_pairs(within)
        order = np.lexsort((q, p, distance))
        return self.unite(zip(p[order].tolist(), q[order].tolist(), distance[order].tolist(), strict=True))

    def join_folds(self, tolerance: float, farthest: float) -> list[float]:
        """Join the ends of edges that two blocks have on one side, up to the tolerance (m); return their lengths.

        Edges off by the tolerance end so much farther on, the sharper their tip, up to `farthest` times the tolerance.
        """
        rows = np.flatnonzero(self.folded())
        p, q = self.vertex[rows], self.vertex[self.following[rows]]
        distance = np.linalg.norm(self.point[p] - self.point[q], axis=1)
        along = self.line_end[self.line] - self.line_start[self.line]
        ends = (rows, self.following[rows])
        sine = np.minimum(*(sine_of_acute(along[self.preceding[end]], along[end]) for end in ends))
        order = np.argsort(distance, kind="stable")
        order = order[(distance * np.maximum(sine, 1.0 / farthest) <= tolerance)[order]]
        return self.unite(zip(p[order].tolist(), q[order].tolist(), distance[order].tolist(), strict=True))

    def join_gap_ends(self, tolerance: float, farthest: float) -> list[float]:
        """Join the ends of edges that close the end of a gap of their own block and another; return their lengths.

        Corners that face each other across a joint that turns lie the farther apart the sharper it turns, and find the
        edges beside them first. The gap is no wider than the tolerance (m), the edge no longer than `farthest` times.
        """
        before, end, after = self._gap_ends(self._open_rows(), farthest * tolerance)
        own = (self.block[end] == self.block[before]) | (self.block[end] == self.block[after])
        side = np.where(self.block[end] == self.block[before], after, before)[own]
        p, q = self.vertex[end[own]], self.vertex[self.following[end[own]]]
        along = self.point[self.vertex[self.following[side]]] - self.point[self.vertex[side]]
        across = self.point[q] - self.point[p]
        width = np.abs(cross(along, across)) / np.linalg.norm(along, axis=1)
        distance = np.linalg.norm(across, axis=1)
        order = np.argsort(distance, kind="stable")
        order = order[width[order] <= tolerance]
        return self.unite(zip(p[order].tolist(), q[order].tolist(), distance[order].tolist(), strict=True))

    def folded(self) -> BoolArray:
        """Return for each row whether another block has its edge on the same side."""
        _, number, count = np.unique(self.keys()[0], return_inverse=True, return_counts=True)
        return np.asarray(count[number.ravel()] > 1)

    def unite(self, pairs: Iterable[tuple[int, int, float]], most: Sequence[float] | None = None) -> list[float]:
        """Make one vertex of each pair, in this order, where outlines stay simple; return the distances joined.

        most: no vertex gathers others from farther apart than so (m), for each pair; None: however far.
        """
        pairs = list(pairs)
        rows_of = self._rows_by_block(np.unique([vertex for p, q, _ in pairs for vertex in (p, q)]))
        to = np.arange(len(self.point))
        joined = []
        for pair, (a, b, apart) in enumerate(pairs):
            one, other = _root(to, a), _root(to, b)
            if one == other or (most is not None and self._gathered(one, other) > most[pair]):
                continue
            if self._stays_simple(rows_of[one], rows_of[other]):
                if most is not None:
                    low, high = self._box(one, other)
                    self.low[one], self.high[one] = low, high
                to[other] = one
                for block, rows in rows_of.pop(other).items():
                    rows_of[one][block] = rows_of[one].get(block, []) + rows
                joined.append(apart)
        if joined:
            self._relabel(np.array([_root(to, a) for a in range(len(to))]))
        return joined

    def _box(self, one: int, other: int) -> tuple[FloatArray, FloatArray]:
        """Return the corners of the box round two vertices and what collapsed into them."""
        two = [one, other]
        low, high = (np.where(np.isnan(at[two]), self.point[two], at[two]) for at in (self.low, self.high))
        return low.min(axis=0), high.max(axis=0)

    def _gathered(self, one: int, other: int) -> float:
        """Return how far apart what collapsed into two vertices lies at most, m."""
        low, high = self._box(one, other)
        return float(np.hypot(*(high - low)))

    def _rows_by_block(self, vertices: IntArray) -> dict[int, dict[int, list[int]]]:
        """Return the rows of each vertex, by block."""
        rows: dict[int, dict[int, list[int]]] = defaultdict(dict)
        for row in np.flatnonzero(np.isin(self.vertex, vertices)).tolist():
            rows[int(self.vertex[row])].setdefault(int(self.block[row]), []).append(row)
        return rows

    def _stays_simple(self, one: dict[int, list[int]], other: dict[int, list[int]]) -> bool:
        """Return whether both vertices may be one: no outline would touch itself or be left with less than an area."""
        return all(self._is_run({*rows, *other[block]}) for block, rows in one.items() if block in other)

    def _is_run(self, rows: set[int]) -> bool:
        """Return whether the rows of one block, and what little lies between them, may be one corner of the block."""
        ring = self._ring(min(rows))
        points = self.point[self.vertex[ring.start : ring.stop]].tolist()
        between, last = rows_between(ring, points, sorted(rows))
        kept = [
            point
            for row, point in zip(ring, points, strict=True)
            if row == last or (row not in rows and row not in between)
        ]
        return len(kept) >= 3 and area_of(kept) > KEPT * area_of(points)

    def _ring(self, row: int) -> range:
        """Return all rows of the block that has this row."""
        return range(*np.searchsorted(self.block, [self.block[row], self.block[row] + 1]).tolist())

    def join_edges(self, within: float) -> list[float]:
        """Give edges the vertices that lie beside them; return the distances that were joined."""
        vertex, row, place, distance = self._beside(within)
        if not len(vertex):
            return []
        order = np.lexsort((vertex, place, row))
        vertex, row, place = vertex[order], row[order], place[order]
        a, b = self.point[self.vertex[row]], self.point[self.vertex[self.following[row]]]
        foot = a + place[:, None] * (b - a)
        self.members.append((vertex, foot))
        self.vertex = np.insert(self.vertex, row + 1, vertex)
        self.block = np.insert(self.block, row + 1, self.block[row])
        self.line = np.insert(self.line, row + 1, self.line[row])
        self.width = np.zeros(len(self.line))
        self._link()
        return distance.tolist()

    def _relabel(self, number: IntArray) -> None:
        """Give vertices new numbers (v,); what an outline has between two corners that became one is dropped."""
        self.vertex = number[self.vertex]
        self.members = [(number[vertex], own) for vertex, own in self.members]
        drop = np.zeros(len(self.vertex), bool)
        pair = self.block * len(self.point) + self.vertex
        order = np.argsort(pair, kind="stable")
        same = np.flatnonzero(np.diff(pair[order], prepend=-1) == 0)
        groups: dict[int, list[int]] = defaultdict(list)
        for k in same.tolist():
            group = groups[int(pair[order[k]])]
            group += [int(order[k])] if group else [int(order[k - 1]), int(order[k])]
        for rows in groups.values():
            ring = self._ring(rows[0])
            points = self.point[self.vertex[ring.start : ring.stop]].tolist()
            between, last = rows_between(ring, points, sorted(rows))
            drop[[row for row in (*between, *rows) if row != last]] = True  # the last of them keeps its edge
        self.drop(drop)

    def drop(self, rows: BoolArray) -> None:
        """Leave out some rows (rows,)."""
        keep = ~rows
        self.vertex, self.block = self.vertex[keep], self.block[keep]
        self.line, self.width = self.line[keep], self.width[keep]
        self._link()


def _root(to: IntArray, vertex: int) -> int:
    while to[vertex] != vertex:
        to[vertex] = to[to[vertex]]
        vertex = int(to[vertex])
    return vertex
