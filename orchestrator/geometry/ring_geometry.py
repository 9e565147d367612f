"""Geometry of one outline while outlines are being joined: feet on lines, ways along a ring, areas, straight chains."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import pairwise
from math import sqrt

import numpy as np
import shapely
from shapely.validation import explain_validity

from orchestrator.basis.arrays import BoolArray, FloatArray
from orchestrator.geometry.rigid import cross

SHARPEST = 0.02
"""angle (rad) between two edges below which an outline goes back on itself: no stone has such a tip"""


def foot_on(point: FloatArray, start: FloatArray, unit: FloatArray) -> FloatArray:
    """Return the points (r, 2) at right angles on lines through `start` (r, 2) along `unit` (r, 2)."""
    return start + np.sum((point - start) * unit, axis=1)[:, None] * unit


def sine_of_acute(coming: FloatArray, leaving: FloatArray) -> FloatArray:
    """Return the sine (r,) of a block's angle between edges (r, 2) that end and begin at a corner; 1 if not acute."""
    sine = cross(coming, leaving) / (np.linalg.norm(coming, axis=1) * np.linalg.norm(leaving, axis=1))
    return np.where((np.sum(coming * leaving, axis=1) < 0) & (sine > 0), sine, 1.0)


def rows_between(ring: range, points: list[list[float]], rows: list[int]) -> tuple[set[int], int]:
    """Return the rows of a ring that lie between `rows`, but for those on the longest way from one to the next; and
    the row where that way begins. points: [x, y] of every row of the ring, in m."""
    walked = [0.0]
    for (x, y), (next_x, next_y) in zip(points, points[1:] + points[:1], strict=True):
        walked.append(walked[-1] + sqrt((next_x - x) * (next_x - x) + (next_y - y) * (next_y - y)))
    place = [row - ring.start for row in rows]
    reached = [walked[k] for k in place]
    ways = [after - before for before, after in pairwise([*reached, reached[0] + walked[-1]])]
    longest = ways.index(max(ways))
    begin, end = place[(longest + 1) % len(place)], place[longest]
    inner = range(begin, end + 1) if begin <= end else [*range(begin, len(ring)), *range(end + 1)]
    return {ring[k] for k in inner} - {*rows}, rows[longest]


def area_of(points: list[list[float]]) -> float:
    """Return the area (m2) within [x, y] in m, counter-clockwise; of a few corners plain numbers are ten times as fast
    as arrays."""
    origin_x, origin_y = points[0]
    doubled = 0.0
    for (x, y), (next_x, next_y) in zip(points, points[1:] + points[:1], strict=True):
        doubled += (x - origin_x) * (next_y - origin_y) - (next_x - origin_x) * (y - origin_y)
    return 0.5 * doubled


@dataclass(frozen=True, slots=True)
class Spike:
    """Where an outline went out and back on itself: its tip, and how long it was, m."""

    tip: tuple[float, float]
    length: float


def without_spikes(ring: FloatArray, within: float) -> tuple[FloatArray, list[Spike]]:
    """Return an outline (n, 2) without the corners from which it goes back on itself, no farther than `within` (m) from
    where it came, and those spikes: boolean operations on outlines leave such, and corners that were forgotten do. What
    would keep less than three corners is left."""
    drawn, found = ring, list[Spike]()
    while len(ring) > 2:
        back, on = np.roll(ring, 1, axis=0) - ring, np.roll(ring, -1, axis=0) - ring
        lengths = np.linalg.norm([back, on], axis=2)
        apart = np.abs(cross(back, on))  # over the longer edge: how far the end of the shorter one lies off it
        sharp = (np.sum(back * on, axis=1) > 0.0) & (apart <= SHARPEST * lengths.prod(axis=0))
        spikes = np.flatnonzero(sharp & (apart <= within * lengths.max(axis=0)))
        if not len(spikes):
            break
        x, y = ring[spikes[0]].tolist()
        found.append(Spike((x, y), float(lengths[:, spikes[0]].min())))
        ring = np.delete(ring, spikes[0], axis=0)
        after = spikes[0] % len(ring)
        if np.linalg.norm(ring[after] - ring[after - 1]) <= within:  # the spike ended where it began
            ring = np.delete(ring, after, axis=0)
    return (ring, found) if len(ring) > 2 else (drawn, [])


def clicked_once(ring: FloatArray, within: float) -> FloatArray:
    """Return an outline (n, 2) without the corners within a distance (m) of the one before, as second clicks are.
    What would keep less than three corners is left."""
    kept = [0]
    for row in range(1, len(ring)):
        if np.linalg.norm(ring[row] - ring[kept[-1]]) > within:
            kept.append(row)
    while len(kept) > 1 and np.linalg.norm(ring[kept[-1]] - ring[0]) <= within:
        kept.pop()
    return ring[kept] if len(kept) > 2 else ring


def kept_of_chain(chain: FloatArray, within: float, bend: float, most: float) -> BoolArray:
    """Return which points of a chain (p, 2) Douglas and Peucker's rule keeps: those farther than `within` (m) from the
    line between two kept ones. A closed chain keeps three.

    None but its ends of a chain that bends by no more than `bend` of its length and `most` (m), and no part of it more
    in proportion: an arc does, a hump on a long bed does not. (Were each part of a longer arc judged so, its chords
    would meet at up to 23 degrees, and stones that slide along it would hook into them.)
    """
    keep = np.zeros(len(chain), bool)
    keep[[0, -1]] = True
    stack = [(0, len(chain) - 1)]
    while stack:
        a, b = stack.pop()
        middle, off = _farthest(chain, a, b)
        if off <= within:
            continue
        if b - a == len(chain) - 1 and off <= most:
            whole = _bend(chain, a, b)
            if max(_bend(chain, a, middle), _bend(chain, middle, b)) <= whole <= bend:
                continue
        keep[middle] = True
        stack += [(a, middle), (middle, b)]
    return keep


def _farthest(chain: FloatArray, a: int, b: int) -> tuple[int, float]:
    """Return the point between two of a chain (p, 2) that is farthest from the line between them, and how far (m)."""
    if b - a < 2:
        return a, 0.0
    off = shapely.distance(shapely.points(chain[a + 1 : b]), shapely.LineString(chain[[a, b]]))
    return a + 1 + int(off.argmax()), float(off.max())


def _bend(chain: FloatArray, a: int, b: int) -> float:
    """Return by what part of its length a chain (p, 2) bends between two of its points; infinity where it is closed."""
    length = float(np.hypot(*(chain[b] - chain[a])))
    return _farthest(chain, a, b)[1] / length if length else np.inf


def depth_of_overlap(common: shapely.Geometry) -> float:
    """Return how deep an overlap is, m: of its parts the greatest width of the narrowest rectangle round one."""
    with np.errstate(divide="ignore", invalid="ignore"):  # of edges shorter than rounding
        around = [shapely.get_coordinates(shapely.oriented_envelope(part)) for part in shapely.get_parts(common)]
    sides = [np.linalg.norm(np.diff(corners, axis=0), axis=1)[:2] for corners in around if len(corners) > 4]
    return float(max((side.min() for side in sides), default=0.0))


def where_it_meets_itself(ring: FloatArray) -> tuple[float, float] | None:
    """Return where a ring (n, 2) crosses or touches itself, in m; None where it does not, or has no area."""
    found = re.search(r"Self-intersection\[(\S+) (\S+)\]", explain_validity(shapely.Polygon(ring)))
    return (float(found[1]), float(found[2])) if found else None
