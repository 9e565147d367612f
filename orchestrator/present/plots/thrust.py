"""The thrust in a wall: where the resultant of every joint crosses it, joined up from block to block.

A resultant crosses its joint at start + n_end/N (end - start). In each block the crossings are joined to their mean,
weighted with the resultants: in an arch, where a block has two joints, that is the line of thrust (the locus of the
crossings); in a wall it is a tree of struts. At a support the resultant's own line of action is drawn.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray
from orchestrator.geometry.rigid import velocity_of_points
from orchestrator.masonry.block_properties import block_areas, block_centroids
from orchestrator.masonry.joints import Assemblage

CARRIES = 1e-6
"""normal force of a joint that carries load, part of the largest one"""
STUB = 0.5
"""length of a line of action in a support, in lengths of a mean block"""


@dataclass(frozen=True, eq=False, slots=True)
class Thrust:
    """Struts in blocks: block (c,), segments (c, 2, 2) in m from the joint inwards, resultant (c,) in N."""

    block: IntArray
    segments: FloatArray
    resultant: FloatArray


def carrying(joint_forces: FloatArray) -> BoolArray:
    """Return which joints (k,) carry load; `joint_forces` (k, 3) as in LimitState."""
    normal = joint_forces[:, :2].sum(axis=1)
    return normal > CARRIES * normal.max()


def thrust(assemblage: Assemblage, joint_forces: FloatArray) -> Thrust:
    """Return the thrust of joint forces (k, 3) in the wall as it stands; two struts a joint that carries load."""
    carry = carrying(joint_forces)
    forces, joints = joint_forces[carry], assemblage.joints.part(carry)
    normal = forces[:, :2].sum(axis=1)
    resultant = normal[:, None] * joints.normal + forces[:, 2:] * joints.tangent
    size = np.linalg.norm(resultant, axis=1)
    part = np.clip(forces[:, 1] / normal, 0.0, 1.0)[:, None]
    crossing = (1.0 - part) * joints.start + part * joints.end
    block = np.concatenate([joints.i, joints.j])
    points, sizes = np.vstack([crossing, crossing]), np.concatenate([size, size])
    inwards = np.vstack([-resultant, resultant]) / sizes[:, None]
    ends = _hubs(len(assemblage.wall.blocks), block, points, sizes)[block]
    support = np.array([b.fixed for b in assemblage.wall.blocks])[block]
    stub = STUB * np.sqrt(np.mean(block_areas(assemblage.wall)[~np.array([b.fixed for b in assemblage.wall.blocks])]))
    ends[support] = (points + stub * inwards)[support]
    return Thrust(block, np.stack([points, ends], axis=1), sizes)


def _hubs(blocks: int, block: IntArray, points: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the weighted mean (n, 2) of the points (c, 2) of each block; nan where a block has none."""
    total = np.bincount(block, weights, blocks)
    sums = np.column_stack([np.bincount(block, weights * x, blocks) for x in points.T])
    return np.divide(sums, total[:, None], out=np.full((blocks, 2), np.nan), where=total[:, None] > 0)


def moved(assemblage: Assemblage, drawn: Thrust, displacements: FloatArray) -> FloatArray:
    """Return the segments (c, 2, 2) of a thrust moved with their blocks by displacements (n, 3) in m and rad."""
    arm = drawn.segments - block_centroids(assemblage.wall)[drawn.block][:, None]
    return drawn.segments + velocity_of_points(displacements[drawn.block][:, None], arm)
