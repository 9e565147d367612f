"""Stones that are probably an error of the drawing: two in one where a joint is missing, slivers where it is double.

No length decides, only what is far out of the family: shares of a stone's own size, and its area beside the others'.
A wall that has many of such stones was built so, and nothing is said.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import islice, pairwise

import numpy as np
import numpy.typing as npt
import shapely

from orchestrator.basis.arrays import FloatArray, IntArray
from orchestrator.basis.printed import as_place
from orchestrator.masonry.wall import Block, Wall, shapes

Neighbours = Callable[[int], npt.NDArray[np.object_]]
"""the outlines whose boxes touch that of the block with a number"""

FAMILY = 10
"""free stones of a wall from which there is something to compare with"""
FEW = 20
"""one stone in so many may be out of the family, one of any wall; where there are more, they are the family"""
REENTRANT = np.radians(20.0)
"""by which a corner turns inwards: chords of an arch along a stone turn by less (16 to a half circle: 12 degrees)"""
LARGER = 1.8
"""area of two stones in one over that of the next smaller stone: two alike have 2"""
TWO = 1.3
"""area over the median from which a stone with a corner inwards may be two; those hooked round an arch's springing have
less (1.2 in the arched facade), half a stone on a whole one has 1.5"""
SMALLEST_PART = 0.25
"""of the median area: what is cut off along the missing joint is a stone and no corner of one"""
CONVEX = 0.03
"""part of its convex hull that a stone may lack and count as convex; half of what two in one lack at the least"""
IMPLAUSIBLE_SLENDERNESS = 150.0
"""length over width above which a stone is probably an error of the drawing; an invalid pushover is likely (measured:
100 ran, 200, 400 and 2000 fell out or made their neighbours jump)"""
SLIVER = (20.0, 0.1)
"""length over width up to those, and area over the median: of a joint drawn twice, 1/20 of a stone apart"""
NEAR = 1e-3
"""of a stone's size: corners that lie nearer to its outline lie on it"""
FREE_EDGE = 0.1
"""part of a stone's width without a stone under or over it from which it is a lintel or a coping, long by intent"""


def slenderness(outline: shapely.Polygon) -> float:
    """Return length over width of the rectangle that has the outline's area and perimeter, plus 2."""
    return float((0.5 * outline.length) ** 2 / outline.area)


def mean_width(outline: shapely.Polygon) -> float:
    """Return the width in m of the rectangle that has the outline's area and perimeter; a quarter of the perimeter of
    what is rounder than a square."""
    half = 0.5 * outline.length
    return float(0.5 * (half - np.sqrt(max(half**2 - 4.0 * outline.area, 0.0))))


def doubtful_stones(wall: Wall) -> list[str]:
    """Return warnings about stones that may be an error of the drawing, with their places."""
    outlines = shapes(wall)
    stones = np.flatnonzero([not block.fixed for block in wall.blocks])
    if len(stones) < FAMILY:
        return []
    few, tree = max(1, len(stones) // FEW), shapely.STRtree(outlines)
    area = np.asarray(shapely.area(outlines))
    median = float(np.median(area[stones]))

    def around(k: int) -> npt.NDArray[np.object_]:
        return outlines[[other for other in tree.query(outlines[k]).tolist() if other != k]]

    thin = [
        k
        for k in stones
        if area[k] < SLIVER[1] * median and SLIVER[0] < slenderness(outlines[k]) <= IMPLAUSIBLE_SLENDERNESS
    ]
    two = [k for k in stones if area[k] > TWO * median and _is_two(outlines[k], around, k, median)]
    signs = (
        ("is a sliver between its neighbours: was a joint drawn twice?", thin),
        ("has a corner that turns inwards round a neighbour, as if it were two stones: is a joint missing?", two),
        (
            f"is more than {LARGER:g} times as large as the others: is a joint missing?",
            _large(outlines, stones, around, few),
        ),
    )
    return [
        _told(wall.blocks[k], outlines[k], sign) for sign, doubtful in signs if len(doubtful) <= few for k in doubtful
    ]


def _told(block: Block, outline: shapely.Polygon, sign: str) -> str:
    place = outline.representative_point()
    return f"WARNING: block {block.id} at {as_place(place.x, place.y)} m {sign}"


def _large(outlines: npt.NDArray[np.object_], stones: IntArray, around: Neighbours, few: int) -> list[int]:
    """Return the stones above the first gap between areas, if at most `few` are; no lintel, no coping."""
    area = np.asarray(shapely.area(outlines))
    by_size = stones[np.argsort(-area[stones], kind="stable")]
    largest = list(islice((k for k in by_size.tolist() if not _has_free_edge(outlines[k], around(k))), few + 1))
    for count, (one, smaller) in enumerate(pairwise(largest), 1):
        if area[one] > LARGER * area[smaller]:
            return largest[:count]
    return []


def _has_free_edge(outline: shapely.Polygon, neighbours: npt.NDArray[np.object_]) -> bool:
    """Return whether part of a stone's underside or top touches no other block."""
    left, _, right, _ = outline.bounds
    bare = outline.exterior.difference(shapely.union_all(shapely.buffer(neighbours, NEAR * np.sqrt(outline.area))))
    edges = [np.abs(np.diff(shapely.get_coordinates(part), axis=0)) for part in shapely.get_parts(bare)]
    return sum(float(edge[edge[:, 0] > edge[:, 1], 0].sum()) for edge in edges) > FREE_EDGE * (right - left)


def _is_two(outline: shapely.Polygon, around: Neighbours, number: int, median: float) -> bool:
    """Return whether a stone that is not convex is parted into two that are by a cut from a corner that turns inwards
    and is filled by a neighbour: to another such corner, along an edge of the neighbour, or by half its angle."""
    inwards = _reentrant(shapely.get_coordinates(outline)[:-1])
    if not inwards or _lacks(outline) < 2.0 * CONVEX:
        return False
    near, neighbours = NEAR * np.sqrt(outline.area), around(number)
    filled = [(at, half) for at, half in inwards if (shapely.distance(neighbours, shapely.Point(at)) <= near).any()]
    return any(
        _parts_it(outline, at, ahead, median)
        for at, half in filled
        for ahead in (*(other - at for other, _ in filled if other is not at), *_along(at, neighbours, near), half)
    )


def _lacks(outline: shapely.Polygon) -> float:
    """Return the part of its convex hull that is outside an outline."""
    return 1.0 - float(outline.area / outline.convex_hull.area)


def _reentrant(polygon: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
    """Return the corners at which a counter-clockwise outline turns inwards, and what halves the angle."""
    into, out = polygon - np.roll(polygon, 1, axis=0), np.roll(polygon, -1, axis=0) - polygon
    into, out = (edge / np.linalg.norm(edge, axis=1, keepdims=True) for edge in (into, out))
    turn = np.arctan2(into[:, 0] * out[:, 1] - into[:, 1] * out[:, 0], np.sum(into * out, axis=1))
    return [(polygon[k], into[k] - out[k]) for k in np.flatnonzero(turn < -REENTRANT)]


def _along(at: FloatArray, neighbours: npt.NDArray[np.object_], near: float) -> Iterator[FloatArray]:
    """Yield the directions in which edges of neighbours that end at a point go on beyond it."""
    for polygon in (shapely.get_coordinates(one)[:-1] for one in neighbours):
        for k in np.flatnonzero(np.linalg.norm(polygon - at, axis=1) <= near):
            yield from (at - other for other in (polygon[k - 1], polygon[(k + 1) % len(polygon)]))


def _parts_it(outline: shapely.Polygon, at: FloatArray, ahead: FloatArray, median: float) -> bool:
    """Return whether a cut from a corner of the outline, in a direction (2,), leaves two stones."""
    thin = 1e-6 * np.sqrt(outline.area)
    far = at + outline.length / np.linalg.norm(ahead) * ahead
    ways = shapely.get_parts(shapely.LineString([at, far]).intersection(outline))
    inside = [way for way in ways if way.length > 10 * thin and way.distance(shapely.Point(at)) <= thin]
    if not inside:
        return False
    parts = shapely.get_parts(outline.difference(inside[0].buffer(thin, cap_style="square")))
    return len(parts) == 2 and all(one.area > SMALLEST_PART * median and _lacks(one) < CONVEX for one in parts)
