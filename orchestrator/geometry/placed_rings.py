"""Where the vertices of joined outlines lie: at the mean of their corners, then on the lines half-way between edges."""

from __future__ import annotations

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.geometry.outline_rings import Rings
from orchestrator.geometry.ring_geometry import foot_on

PULL = 1e-3
"""weight that holds a vertex to the mean of its corners, against the lines through it: decides along parallel lines"""
FARTHEST_VERTEX_RATIO = 5.0
"""a vertex lies no farther from the mean of its corners than this many times the farthest of them"""


def place(rings: Rings) -> None:
    """Put every vertex at the mean of the points that blocks have there; on one of them where they agree."""
    vertex, own = (np.concatenate(parts) for parts in zip(*rings.members, strict=True))
    count = np.maximum(np.bincount(vertex, minlength=len(rings.point)), 1)
    mean = np.column_stack([np.bincount(vertex, own[:, k], len(rings.point)) / count for k in (0, 1)])
    rings.spread = np.zeros(len(rings.point))
    np.maximum.at(rings.spread, vertex, np.linalg.norm(own - mean[vertex], axis=1))
    moved = rings.spread > rings.rounding
    rings.point = np.where(moved[:, None], mean, rings.point)


def place_on_lines(rings: Rings) -> None:
    """Put every joined vertex where the lines half-way between the drawn edges meet there, by least squares."""
    size = len(rings.point)
    rows, twin = np.arange(len(rings.vertex)), rings.twins()
    twin = np.where(twin >= 0, twin, rows)  # itself where there is none
    along = rings.line_end[rings.line] - rings.line_start[rings.line]
    length = np.linalg.norm(along, axis=1)
    unit = along / length[:, None]
    tangent = np.where((twin == rows)[:, None], unit, unit - unit[twin])
    tangent /= np.maximum(np.linalg.norm(tangent, axis=1), 1e-300)[:, None]
    normal = np.column_stack([tangent[:, 1], -tangent[:, 0]])
    weight = np.minimum(length, length[twin])
    matrix, right, total = np.zeros((size, 2, 2)), np.zeros((size, 2)), np.zeros(size)
    for vertex in (rings.vertex, rings.vertex[rings.following]):
        feet = [foot_on(rings.point[vertex], rings.line_start[rings.line[r]], unit[r]) for r in (rows, twin)]
        offset = np.sum(normal * (0.5 * (feet[0] + feet[1]) - rings.point[vertex]), axis=1)
        np.add.at(matrix, vertex, weight[:, None, None] * normal[:, :, None] * normal[:, None, :])
        np.add.at(right, vertex, (weight * offset)[:, None] * normal)
        np.add.at(total, vertex, weight)
    matrix += (PULL * np.maximum(total, 1e-300))[:, None, None] * np.eye(2)
    step = np.linalg.solve(matrix, right[..., None])[..., 0]
    far = np.linalg.norm(step, axis=1)
    step *= np.minimum(1.0, FARTHEST_VERTEX_RATIO * rings.spread / np.maximum(far, 1e-300))[:, None]
    rings.point = rings.point + _without_folds(rings, np.where((rings.spread > rings.rounding)[:, None], step, 0.0))


def _without_folds(rings: Rings, step: FloatArray) -> FloatArray:
    """Return the steps (v, 2) of vertices, halved until no edge runs the other way round: lines that are nearly
    parallel meet far off, beyond the next vertex."""
    there = rings.vertex[rings.following]
    before = rings.point[there] - rings.point[rings.vertex]
    while True:
        folded = np.sum(before * (before + step[there] - step[rings.vertex]), axis=1) < 0
        if not folded.any():
            return step
        step = step.copy()
        step[np.union1d(rings.vertex[folded], there[folded])] *= 0.5
