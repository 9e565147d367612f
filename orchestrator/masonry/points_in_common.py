"""Where the corner of one stone touches a face of another in one point, beside a void that closes when they slide.

Such a point is no joint: it has no length. Two stones that touch so at an angle press each other in finite elements;
limit analysis, whose forces act on joints, knows nothing of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.geometry.planar_map import NO_BLOCK
from orchestrator.masonry.joints import Assemblage

LEAST_ANGLE = 0.1
"""rad; between a face and both sides of the corner: others are nearly parallel, and will touch over a length"""


@dataclass(frozen=True, slots=True)
class PointInCommon:
    """Ids of two stones, the smaller one first, that touch at place (x, y), m."""

    stones: tuple[int, int]
    place: tuple[float, float]


def points_in_common(assemblage: Assemblage) -> tuple[PointInCommon, ...]:
    """Return where stones touch in one point, in the order of their ids; nothing for an assemblage without outlines.

    Round a vertex of the planar map are stones and voids, each with its angle. The void's is that between the face on
    one side of it and the nearer side of the corner on the other, and both together that to the corner's farther side.
    """
    outlines = assemblage.outlines
    if outlines is None:
        return ()
    along = outlines.vertex[outlines.end] - outlines.vertex[outlines.start]
    vertex = np.concatenate([outlines.start, outlines.end])
    angle = np.concatenate([np.arctan2(along[:, 1], along[:, 0]), np.arctan2(-along[:, 1], -along[:, 0])])
    owner = np.concatenate([outlines.left, outlines.right])  # of what lies counter-clockwise of the edge from there
    order = np.lexsort((angle, vertex))
    blocks, found = assemblage.wall.blocks, set[PointInCommon]()
    for row in np.split(order, np.flatnonzero(np.diff(vertex[order])) + 1):
        width = np.diff(angle[row], append=angle[row[0]] + 2 * np.pi)
        for void in np.flatnonzero(owner[row] == NO_BLOCK):
            sides = owner[row[void - 1]], owner[row[(void + 1) % len(row)]]
            one, other = (blocks[side] for side in sides)
            if sides[0] == sides[1] or (one.fixed and other.fixed):
                continue
            if _closes(width[void], np.array([width[void - 1], width[(void + 1) % len(row)]])):
                x, y = outlines.vertex[vertex[row[0]]].tolist()
                found.add(PointInCommon((min(one.id, other.id), max(one.id, other.id)), (x, y)))
    return tuple(sorted(found, key=lambda point: (point.stones, point.place)))


def _closes(void: float, corners: FloatArray) -> bool:
    """Return whether a corner (rad) on one side of a void is in front of the face on the other one, at an angle."""
    return void > LEAST_ANGLE and bool((void + corners < np.pi - LEAST_ANGLE).any())
