"""Blocks after a motion: every block turns and moves as its velocity says, carried on rigidly (a screw in space)."""

from __future__ import annotations

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.geometry.polyhedra import Polyhedron, rotation
from orchestrator.space.wall import SpaceWall


def moved(wall: SpaceWall, displacements: FloatArray) -> list[Polyhedron]:
    """Return the blocks after displacements (n, 6): translation of the centroid (m) and rotation vector (rad), carried
    on as a screw, so that blocks with one velocity field stay one body."""
    return [
        _screwed(block.shape, centroid, displacement)
        for block, centroid, displacement in zip(wall.blocks, wall.centroids, displacements, strict=True)
    ]


def _screwed(body: Polyhedron, centroid: FloatArray, displacement: FloatArray) -> Polyhedron:
    translation, turning = displacement[:3], displacement[3:]
    angle = float(np.linalg.norm(turning))
    if angle < 1e-12:
        return body.moved(np.eye(3), translation)
    turn = rotation((float(turning[0]), float(turning[1]), float(turning[2])), angle)
    cross = np.array([[0.0, -turning[2], turning[1]], [turning[2], 0.0, -turning[0]], [-turning[1], turning[0], 0.0]])
    along = np.eye(3) + (1 - np.cos(angle)) / angle**2 * cross + (angle - np.sin(angle)) / angle**3 * cross @ cross
    return body.moved(turn, centroid + along @ translation - turn @ centroid)
