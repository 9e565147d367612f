"""Areas, centroids and weights of blocks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.basis.arrays import FloatArray, IntArray
from orchestrator.masonry.wall import Wall


def polygon_area(polygon: FloatArray) -> float:
    """Area in m2 of a simple polygon (n, 2), positive when counter-clockwise."""
    x, y = polygon.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def polygon_centroid(polygon: FloatArray) -> FloatArray:
    """Centroid (2,) in m of a simple polygon (n, 2); taken about its first corner so that far walls lose no digits."""
    origin = polygon[0]
    x, y = (polygon - origin).T
    next_x, next_y = np.roll(x, -1), np.roll(y, -1)
    twice_area = x * next_y - next_x * y
    first_moments = np.array([np.sum((x + next_x) * twice_area), np.sum((y + next_y) * twice_area)])
    return origin + first_moments / (3.0 * np.sum(twice_area))


def block_areas(wall: Wall) -> FloatArray:
    """Areas (n,) in m2."""
    outlines = outlines_of(wall)
    arm = outlines.corner - outlines.corner[outlines.first][outlines.block]
    return 0.5 * np.add.reduceat(_cross(arm, arm[outlines.following]), outlines.first)


def block_centroids(wall: Wall) -> FloatArray:
    """Centroids (n, 2) in m, as `polygon_centroid`."""
    outlines = outlines_of(wall)
    origin = outlines.corner[outlines.first]
    arm = outlines.corner - origin[outlines.block]
    twice_area = _cross(arm, arm[outlines.following])
    first_moments = np.add.reduceat((arm + arm[outlines.following]) * twice_area[:, None], outlines.first)
    return origin + first_moments / (3.0 * np.add.reduceat(twice_area, outlines.first))[:, None]


@dataclass(frozen=True, eq=False, slots=True)
class Outlines:
    """The outlines of n blocks, one behind the other: corner (m, 2) in m, block (m,), following (m,) the number of the
    next corner of the same block, first (n,) that of each block's first corner."""

    corner: FloatArray
    block: IntArray
    following: IntArray
    first: IntArray


def outlines_of(wall: Wall) -> Outlines:
    """Return the corners of all blocks as arrays."""
    counts = np.array([len(block.polygon) for block in wall.blocks])
    first = np.concatenate([[0], np.cumsum(counts)[:-1]])
    following = np.arange(1, counts.sum() + 1)
    following[first + counts - 1] = first
    corner = np.concatenate([block.polygon for block in wall.blocks])
    return Outlines(corner, np.repeat(np.arange(len(counts)), counts), following, first)


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def block_thicknesses(wall: Wall) -> FloatArray:
    """Thicknesses (n,) in m: the wall's where a block has none of its own."""
    return np.array([wall.thickness if block.thickness is None else block.thickness for block in wall.blocks])


def block_weights(wall: Wall) -> FloatArray:
    """Weights (n,) in N, supports included."""
    return block_areas(wall) * block_thicknesses(wall) * np.array([block.unit_weight for block in wall.blocks])


def rounded_up(length: float) -> float:
    """Return a little more than `length` (mm), with one digit: a tolerance that somebody may try."""
    unit = 10.0 ** np.floor(np.log10(max(1.2 * length, 1e-6)))
    return float(np.ceil(1.2 * length / unit) * unit)
