"""What a mechanism does: how every joint moves, and which blocks move as one body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from orchestrator.basis.arrays import FloatArray, IntArray
from orchestrator.basis.graphs import connected_groups
from orchestrator.geometry.rigid import velocity_of_points
from orchestrator.space.contacts import SpaceAssemblage

Motion = Literal["rests", "hinges", "slides", "twists", "opens"]
AT_REST = 1e-3
"""Part of the wall's largest velocity below which nothing moves."""
NOTICED = 1e-2
"""part of it from which the slip of a joint that turns is told, as that of joints in the plane is marked"""
BEARS = 1e-6
"""part of the largest force from which a contact point bears"""


@dataclass(frozen=True, eq=False, slots=True)
class SpaceMechanism:
    """motion (k,) of every joint; body (n,) of every block (blocks of one number move as one, 0: at rest)."""

    motion: tuple[Motion, ...]
    body: IntArray

    @property
    def moving(self) -> IntArray:
        """Positions of the blocks that move."""
        return np.flatnonzero(self.body > 0)

    def count(self, kind: Motion) -> int:
        """How many joints move in this way."""
        return self.motion.count(kind)


def mechanism_of(
    assemblage: SpaceAssemblage, velocities: FloatArray, forces: FloatArray | None = None
) -> SpaceMechanism:
    """Classify a mechanism with velocities (n, 6) of all blocks; forces (p, 3) in N of all contact points, where known,
    say which of them bear although they open, as those of an associative mechanism do where they slide.

    A joint opens where it opens at all contact points and bears at none, hinges where it opens at some and slips by no
    more than NOTICED at the others: a floor that is dragged off its pier slides, however little it lifts off an edge.
    It twists where it turns about its normal faster than its middle slides, slides otherwise; it rests where no point
    moves by more than AT_REST.
    """
    joints = assemblage.joints
    speeds = corner_speeds(assemblage, velocities)
    limit = AT_REST * (float(speeds.max()) or 1.0)
    of = joints.joint
    relative = relative_velocities(assemblage, velocities, joints.point)
    opening = np.einsum("pi,pi->p", relative, joints.normal[of])
    slip = relative - opening[:, None] * joints.normal[of]
    first = np.searchsorted(of, np.arange(joints.count))
    points = np.bincount(of, minlength=joints.count)
    closed = opening <= limit
    if forces is not None:
        closed |= forces[:, 0] > BEARS * forces[~joints.is_tie[of], 0].max(initial=0.0)
    bears, most = np.logical_or.reduceat(closed, first), np.maximum.reduceat(opening, first)
    speed = np.linalg.norm(slip, axis=1)
    sliding = np.maximum.reduceat(speed, first)
    turning = np.maximum.reduceat(np.where(closed, speed, 0.0), first) <= NOTICED / AT_REST * limit
    mean = np.linalg.norm(np.add.reduceat(slip, first, axis=0) / points[:, None], axis=1)
    motion = np.select(
        [~bears, (most > limit) & turning, (sliding > limit) & (sliding > 2.0 * mean), sliding > limit],
        ["opens", "hinges", "twists", "slides"],
        "rests",
    )
    motion[joints.is_tie] = "rests"
    return SpaceMechanism(tuple(motion.tolist()), _bodies(assemblage, motion, speeds > limit))


def relative_velocities(assemblage: SpaceAssemblage, velocities: FloatArray, point: FloatArray) -> FloatArray:
    """Return the velocities (p, 3) of the points (p, 3) of all joints: of their blocks j relative to their blocks i."""
    joints, centroids = assemblage.joints, assemblage.wall.centroids
    of_j, of_i = (
        velocity_of_points(velocities[block], point - centroids[block])
        for block in (joints.j[joints.joint], joints.i[joints.joint])
    )
    return of_j - of_i


def corner_speeds(assemblage: SpaceAssemblage, velocities: FloatArray) -> FloatArray:
    """Return the largest velocity (n,) of a corner of each block, m/s."""
    centroids = assemblage.wall.centroids
    return np.array(
        [
            np.linalg.norm(velocity_of_points(velocities[k], block.shape.vertices - centroids[k]), axis=1).max()
            for k, block in enumerate(assemblage.wall.blocks)
        ]
    )


def _bodies(assemblage: SpaceAssemblage, motion: np.ndarray, moves: np.ndarray) -> IntArray:
    """Number the groups of moving blocks that joints at rest connect, the largest first; 0 for blocks at rest."""
    joints, count = assemblage.joints, len(assemblage.wall.blocks)
    together = (motion == "rests") & ~joints.is_tie & moves[joints.i] & moves[joints.j]
    group = connected_groups(count, joints.i[together], joints.j[together])
    numbers, sizes = np.unique(group[moves], return_counts=True)
    order = {int(number): k + 1 for k, number in enumerate(numbers[np.argsort(-sizes, kind="stable")])}
    return np.array([order[int(group[k])] if moves[k] else 0 for k in range(count)], dtype=np.int64)
