"""Rigid bodies, in the plane (d = 2) and in space (d = 3): what their points do, moments of forces, plane areas.

    velocity of a point     v + w x r       velocities (v, w): (u, v, rotation rate) or (3 components, 3 components)
    moment of a force       r x f           about the point that the arm r comes from: a number in the plane
    polygon                 area, centroid and polar second moment by Gauss's formula over its edges

so that the power of a force f at r is f . v + (r x f) . w, whichever way it is counted.
"""

from __future__ import annotations

import numpy as np

from orchestrator.basis.arrays import FloatArray


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return a x b of vectors (..., d): their z component (...) in the plane, (..., 3) in space."""
    if a.shape[-1] == 3:
        return np.cross(a, b)
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def velocity_of_points(velocities: FloatArray, arm: FloatArray) -> FloatArray:
    """Return the velocities (..., d) of points of bodies that move with velocities (..., 3 or 6) of their centroids;
    arm (..., d): from the centroid to the point."""
    if arm.shape[-1] == 3:
        return velocities[..., :3] + np.cross(velocities[..., 3:], arm)
    return velocities[..., :2] + velocities[..., 2:] * np.stack([-arm[..., 1], arm[..., 0]], axis=-1)


def polygon_area(polygon: FloatArray) -> float:
    """Return the area in m2 of a simple polygon (n, 2), positive when counter-clockwise."""
    return 0.5 * float(np.sum(cross(polygon, np.roll(polygon, -1, axis=0))))


def polygon_centroid(polygon: FloatArray) -> FloatArray:
    """Return the centroid (2,) in m of a simple polygon (n, 2); taken about its first corner so that far walls lose no
    digits."""
    arm = polygon - polygon[0]
    following = np.roll(arm, -1, axis=0)
    twice_area = cross(arm, following)
    first_moments = np.array([np.sum(side * twice_area) for side in (arm + following).T])
    return polygon[0] + first_moments / (3.0 * np.sum(twice_area))


def polar_moment(polygon: FloatArray) -> float:
    """Return the polar second moment of area (m4) of a polygon (n, 2) about the origin."""
    following = np.roll(polygon, -1, axis=0)
    squares = np.sum(polygon**2 + polygon * following + following**2, axis=1)
    return float(cross(polygon, following) @ squares) / 12.0
