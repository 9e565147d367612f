"""Numbered pixels -> outlines of the stones: along the edges between pixels, simplified together.

Between two corners at which three stones (or two and the void) meet runs one chain of pixel edges, common to both
sides. Each chain is simplified by itself (Douglas and Peucker 1973), so neighbours keep one common edge; chains that
would then cross or touch are simplified less, down to their pixels, which never cross.
"""

from __future__ import annotations

from collections import Counter, defaultdict

import numpy as np
import numpy.typing as npt
import shapely

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray

STRAIGHT_WITHIN_PIXELS = 1.5
"""pixels: how far the steps of a straight edge may lie from it. Steps that are left interlock: stones stand that would
slide out"""
FINEST = 0.2
"""pixels: chains that cross although simplified by no more than this are left as they are"""
APART = "FF*F*****"
"""two chains have at most ends in common (pattern of DE-9IM)"""


def outlines(number: IntArray) -> tuple[IntArray, list[FloatArray], IntArray]:
    """Return the stones' numbers (s,) in order, their simplified outlines (n, 2) in pixels, and holes (s,) in them.

    number: of the stone by pixel (rows from the top, columns), 0 where there is none. x counts columns, y rows. Of a
    stone in pieces the largest is taken, and its holes are filled.
    """
    chains = _chains(np.pad(number, 1))
    sides = _sides(chains, np.pad(number, 1))
    simple = _simplified(chains)
    of: dict[int, list[int]] = defaultdict(list)
    for chain, pair in enumerate(sides.tolist()):
        for stone in set(pair) - {0}:
            of[stone].append(chain)
    largest = {stone: _largest(simple[of[stone]]) for stone in sorted(of)}
    kept = {stone: face for stone, face in largest.items() if face is not None}
    rings = [shapely.get_coordinates(face.exterior)[:-1] - 1.0 for face in kept.values()]
    return np.array(list(kept), np.int64), rings, np.array([len(face.interiors) for face in kept.values()], np.int64)


def _largest(chains: npt.NDArray[np.object_]) -> shapely.Polygon | None:
    """Return the largest face that the chains around a stone enclose; none if it lost its area."""
    faces = shapely.get_parts(shapely.polygonize(chains))
    return faces[np.argmax(shapely.area(faces))] if len(faces) else None


def _chains(number: IntArray) -> npt.NDArray[np.object_]:
    """Return the lines (c,) along which the number changes, each from corner to corner; closed ones are cut in two."""
    upright, level = number[:, 1:] != number[:, :-1], number[1:] != number[:-1]
    turning_x = level[:, 1:] | level[:, :-1]  # at the inner corners of the pixels: a level edge ends or passes there
    turning_y = upright[1:] | upright[:-1]
    x, y, last = _runs(upright.T, turning_x.T)
    vertical = np.stack([np.column_stack([x + 1, y]), np.column_stack([x + 1, last])], axis=1)
    y, x, last = _runs(level, turning_y)
    horizontal = np.stack([np.column_stack([x, y + 1]), np.column_stack([last, y + 1])], axis=1)
    runs = shapely.linestrings(np.concatenate([vertical, horizontal]).astype(float))
    merged = shapely.get_parts(shapely.line_merge(shapely.multilinestrings(runs)))
    closed = shapely.is_closed(merged)
    rings = [shapely.get_coordinates(ring) for ring in merged[closed]]
    ends = shapely.get_coordinates(shapely.boundary(merged[~closed])).tolist() + [ring[0].tolist() for ring in rings]
    met = Counter(map(tuple, ends))
    halves = [half for ring in rings for half in _halves(ring, met[tuple(ring[0].tolist())] == 1)]
    return np.concatenate([merged[~closed], np.array(halves, dtype=object)])


def _runs(edge: BoolArray, turning: BoolArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return row, first and last corner of each straight run of pixel edges.

    edge (rows, n): there is one between corners k and k + 1; turning (rows, n - 1): a run ends at corner k + 1.
    """
    ends = np.ones((edge.shape[0], edge.shape[1] + 1), bool)
    ends[:, 1:-1] = turning | (edge[:, 1:] != edge[:, :-1])
    row, first = np.nonzero(edge & ends[:, :-1])
    _, last = np.nonzero(edge & ends[:, 1:])
    return row, first, last + 1


def _halves(ring: FloatArray, alone: bool) -> list[shapely.LineString]:
    """Return a closed chain (n, 2) in two: cut where it starts, which is another stone's corner unless it is `alone`,
    and far from there; alone, it is cut at corners of its own."""
    if alone:
        outermost = int(np.argmax(np.linalg.norm(ring - ring[:-1].mean(axis=0), axis=1)))
        ring = np.vstack([ring[outermost:], ring[1 : outermost + 1]])
    across = int(np.argmax(np.linalg.norm(ring - ring[0], axis=1)))
    return [shapely.LineString(ring[: across + 1]), shapely.LineString(ring[across:])]


def _sides(chains: npt.NDArray[np.object_], number: IntArray) -> IntArray:
    """Return the numbers (c, 2) of the pixels on both sides of each chain."""
    start, then = (shapely.get_coordinates(shapely.get_point(chains, k)) for k in (0, 1))
    middle = start + 0.5 * np.sign(then - start)
    across = 0.5 * np.sign(then - start)[:, ::-1]
    pixels = [np.floor(middle + turn * across).astype(int) for turn in (1.0, -1.0)]
    return np.column_stack([number[pixel[:, 1], pixel[:, 0]] for pixel in pixels])


def _simplified(chains: npt.NDArray[np.object_]) -> npt.NDArray[np.object_]:
    """Return the chains without the steps of straight edges, none of which crosses or touches another."""
    simple = shapely.simplify(chains, STRAIGHT_WITHIN_PIXELS, preserve_topology=False)
    allowed, changed = np.full(len(chains), STRAIGHT_WITHIN_PIXELS), np.arange(len(chains))
    while len(changed):
        spoilt = _spoilt(simple, changed)
        changed = spoilt[allowed[spoilt] > 0.0]
        allowed[changed] *= 0.5
        allowed[allowed < FINEST] = 0.0
        simple[changed] = shapely.simplify(chains[changed], allowed[changed], preserve_topology=False)
    return simple


def _spoilt(lines: npt.NDArray[np.object_], changed: IntArray) -> IntArray:
    """Return which lines cross themselves or each other, of those that are `changed` or meet such."""
    i, j = shapely.STRtree(lines).query(lines[changed], predicate="intersects")
    i = changed[i]
    pairs = i != j
    i, j = i[pairs], j[pairs]
    wrong = ~shapely.relate_pattern(lines[i], lines[j], APART)
    crossed = changed[~shapely.is_simple(lines[changed])]
    return np.unique(np.concatenate([i[wrong], j[wrong], crossed]))
