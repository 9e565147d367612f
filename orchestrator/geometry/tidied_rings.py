"""What follows once outlines are joined: short edges become points, widths are measured, chains straightened."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import shapely

from orchestrator.basis.arrays import BoolArray
from orchestrator.geometry.outline_rings import KEPT, Rings
from orchestrator.geometry.ring_geometry import area_of, foot_on, kept_of_chain


def collapse(rings: Rings, error: float, short: float) -> list[float]:
    """Take short edges for points, the shortest first: those below `error` (m), over which outlines were joined,
    and those between two blocks below `short` of the size of one of them. Return their lengths (m).

    Short edges in a row are the chords of a curve: no point takes the place of more than such a length.
    """
    there = rings.vertex[rings.following]
    length = np.linalg.norm(rings.point[there] - rings.point[rings.vertex], axis=1)
    begin = np.flatnonzero(np.diff(rings.block, prepend=-1))
    x, y = (rings.point[rings.vertex] - rings.point[rings.vertex[begin]][rings.block]).T
    doubled_area = np.add.reduceat(x * y[rings.following] - x[rings.following] * y, begin)
    size = np.sqrt(0.5 * np.abs(doubled_area))[rings.block]
    key, reverse = rings.keys()
    folded = key[rings.folded()]  # two blocks lie on one another there: no error of a drawing but the tolerance's
    between_two = np.isin(reverse, key) & ~np.isin(key, folded) & ~np.isin(reverse, folded)
    most = np.where(between_two, np.maximum(error, short * size), error)
    rows = np.flatnonzero(length < most)
    rows = rows[np.argsort(-most[rows], kind="stable")]  # of the two blocks at an edge the larger one decides
    p, q = np.minimum(rings.vertex[rows], there[rows]), np.maximum(rings.vertex[rows], there[rows])
    pairs, index = np.unique(np.column_stack([p, q]), axis=0, return_index=True)
    length, most = length[rows[index]], most[rows[index]]
    order = np.lexsort((*pairs.T, length))
    return rings.unite(
        ((*pair, apart) for pair, apart in zip(pairs[order].tolist(), length[order].tolist(), strict=True)),
        most[order].tolist(),
    )


def measure(rings: Rings) -> None:
    """Note for each row what lay between its drawn edge and the one beyond, m, at the middle of both."""
    twin = rings.twins()
    middle = 0.5 * (rings.point[rings.vertex] + rings.point[rings.vertex[rings.following]])
    along = rings.line_end[rings.line] - rings.line_start[rings.line]
    unit = along / np.linalg.norm(along, axis=1)[:, None]
    foot = foot_on(middle, rings.line_start[rings.line], unit)
    outward = np.column_stack([unit[:, 1], -unit[:, 0]])
    width = np.sum(outward * (foot[twin] - foot), axis=1)
    rings.width = np.where((twin >= 0) & (np.abs(width) > rings.rounding), width, 0.0)


def straighten(rings: Rings, within: float, tolerance: float, bend: float) -> float:
    """Drop the vertices of chains between the same two blocks that lie within `within` (m) of a straight line,
    `tolerance` (m) where the drawing has curves (bend > 0) or edges of the chain collapsed, or all of them where it
    bends by no more than `bend` of its length; where there is one block only, no more than `tolerance` from it.
    Return the largest distance (m) over which the line between two blocks changed."""
    key, reverse = rings.keys()
    size = len(rings.point)
    degree = np.bincount(np.unique(np.concatenate([key, reverse])) // size, minlength=size)
    plain = degree == 2
    twin = rings.twins()
    is_open = twin < 0
    second = ~is_open & (rings.block[twin] < rings.block)  # the other block's chain, seen the other way round
    drop, changed = np.zeros(size, bool), 0.0
    for block in np.unique(rings.block[plain[rings.vertex]]).tolist():
        rows = np.arange(*np.searchsorted(rings.block, [block, block + 1]))
        fixed = np.flatnonzero(~plain[rings.vertex[rows]])
        rows = np.roll(rows, -fixed[0] if len(fixed) else 0)
        ends = np.append(np.flatnonzero(~plain[rings.vertex[rows]]), len(rows)) if len(fixed) else [0, len(rows)]
        for begin, end in pairwise(ends):
            if end - begin > 1 and not second[rows[begin]]:
                chain = rings.vertex[np.append(rows[begin:end], rows[end % len(rows)])]
                most = max(within, tolerance) if is_open[rows[begin]] else np.inf
                curved = bend > 0.0 or not np.isnan(rings.low[chain, 0]).all()
                kept = kept_of_chain(rings.point[chain], max(within, tolerance) if curved else within, bend, most)
                drop[chain[~kept]] = True
                if not is_open[rows[begin]] and not kept.all():
                    straight = shapely.LineString(rings.point[chain[kept]])
                    changed = max(changed, shapely.distance(shapely.points(rings.point[chain]), straight).max())
    _give_back(rings, drop)
    rings.drop(drop[rings.vertex])
    return float(changed)


def _give_back(rings: Rings, drop: BoolArray) -> None:
    """Take back from the vertices to be dropped (v,) those of blocks that would keep too little of their area."""
    begins = np.append(np.flatnonzero(np.diff(rings.block, prepend=-1)), len(rings.block))
    spoilt = True
    while spoilt:  # what is given back to one block may be what another one lacked
        spoilt = False
        for ring in (np.arange(a, b) for a, b in pairwise(begins)):
            gone = drop[rings.vertex[ring]]
            if not gone.any():
                continue
            points, rest = (rings.point[rings.vertex[rows]].tolist() for rows in (ring, ring[~gone]))
            if len(rest) < 3 or area_of(rest) < KEPT * area_of(points):
                drop[rings.vertex[ring]] = False
                spoilt = True
