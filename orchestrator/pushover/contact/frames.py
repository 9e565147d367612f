"""The rigid motion of each body that fits its displaced nodes best (numpy only)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from orchestrator.basis.arrays import FloatArray, IntArray
from orchestrator.geometry.rigid import cross


@dataclass(frozen=True, eq=False, slots=True)
class Frames:
    """Rigid motion of each body that fits its nodes best: x = R X + t in the wall's plane.

    angle (b,) in rad, counter-clockwise; rotation (b, 2, 2); translation (b, 2) in m; supports included, at rest.
    """

    angle: FloatArray
    rotation: FloatArray
    translation: FloatArray


class BodyNodes(Protocol):
    """Nodes of bodies: those of a mesh, or the ones in front (front.py)."""

    @property
    def nodes(self) -> FloatArray:
        """(m, 3) in m."""

    @property
    def body_of_node(self) -> IntArray:
        """(m,)."""


def fit_frames(of: BodyNodes, displacement: FloatArray, bodies: int) -> Frames:
    """Return the frames of `bodies` bodies (the moving ones first); displacement (>= m, 3) in m, nodes first."""
    body, reference = of.body_of_node, of.nodes[:, :2]
    moved = reference + displacement[: len(reference), :2]
    count = np.maximum(np.bincount(body, minlength=bodies), 1.0)

    def mean(values: FloatArray) -> FloatArray:
        return np.stack([np.bincount(body, values[:, k], bodies) for k in range(2)], axis=1) / count[:, None]

    old, new = mean(reference), mean(moved)
    arm, turned = reference - old[body], moved - new[body]
    sine = np.bincount(body, cross(arm, turned), bodies)
    cosine = np.bincount(body, np.sum(arm * turned, axis=1), bodies)
    angle = np.arctan2(sine, cosine)
    rotation = np.stack(
        [np.stack([np.cos(angle), -np.sin(angle)], -1), np.stack([np.sin(angle), np.cos(angle)], -1)], 1
    )
    return Frames(angle, rotation, new - np.einsum("bij,bj->bi", rotation, old))
