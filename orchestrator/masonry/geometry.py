"""Areas, centroids and weights of blocks."""

from __future__ import annotations

import numpy as np

from orchestrator.masonry.wall import FloatArray, Wall


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
    return np.array([polygon_area(block.polygon) for block in wall.blocks])


def block_centroids(wall: Wall) -> FloatArray:
    """Centroids (n, 2) in m."""
    return np.array([polygon_centroid(block.polygon) for block in wall.blocks])


def block_weights(wall: Wall) -> FloatArray:
    """Weights (n,) in N, supports included."""
    return block_areas(wall) * wall.thickness * np.array([block.unit_weight for block in wall.blocks])
