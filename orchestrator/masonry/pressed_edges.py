"""Over what length a stone that leans on the end of a joint is pressed there, when the joint bears most (numpy only).

A stone that turns by r about the end of a joint presses a = 4 N / (pi E t r) of it, with the resultant at a / 4 from
the end (a flat punch that tilts on a half-plane; Johnson, Contact Mechanics, 1985, chapter 2), and loses N a / 4 of its
moment to that. The more it turns the less, but the more it loses to

    the bond, f_t, which has gone at an opening of delta      f_t t r L^3 / (3 delta)
    the lean of what stands on it, h high                      N h r

The sum of both is least, N times 2 x / 3, where x = 3 a / 4 (a pressure that falls evenly over x has its resultant at
the same place) is

    L (3 f_t L / (pi E delta))^(1/2)      and      3 (N h / (pi E t))^(1/2)

The compliances of both stones add up; supports are rigid.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray
from orchestrator.basis.graphs import connected_groups
from orchestrator.masonry.block_properties import block_moduli
from orchestrator.masonry.interfaces import Interfaces
from orchestrator.masonry.wall import Wall

CORNER = 1.23
"""times the length on half-planes over which stones are pressed, as these give way more at a corner: measured by the
peak of a bonded tower of five blocks of 0.4 m in fine elements"""
PRESSED = 0.01
"""part of the force on its beds with which a stone beside it has to press a stone to hold it"""
AT_END = 0.05
"""part of a joint's force at its other end, at most, where what leans on it presses one end"""
LEVEL = 0.94
"""vertical part of the normal of beds of a column at least: 20 degrees"""


def compliances(wall: Wall, joints: Interfaces, elastic_modulus: float) -> FloatArray:
    """Return 1 / E (k, 2) in 1/Pa of the stones on both sides of joints between blocks, 0 of supports; elastic_modulus:
    of stones that have none of their own, Pa."""
    moduli, free = block_moduli(wall, elastic_modulus), np.array([not block.fixed for block in wall.blocks])
    return np.column_stack([free[side] / moduli[side] for side in (joints.i, joints.j)])


def under_bond(joints: Interfaces, compliant: FloatArray, softening: float) -> FloatArray:
    """Return x (k,) in m of joints that crack, 0 without tensile strength; compliant (k, 2): 1 / E of the stones at
    them, 1/Pa; softening: delta, m."""
    strained = joints.tensile_strength * joints.length * compliant.sum(axis=1) / softening
    return np.asarray(np.minimum(CORNER * np.sqrt(3.0 / np.pi * strained), 1.0) * joints.length)


def under_column(force: FloatArray, soft: FloatArray) -> FloatArray:
    """Return x in m under columns with forces (N); soft: their height over E t of both stones at the bed, m2/N."""
    return np.asarray(3.0 * CORNER * np.sqrt(force * soft / np.pi))


def under_turning(force: FloatArray, soft: FloatArray, turn: FloatArray) -> FloatArray:
    """Return x in m where stones with forces (N) have turned by so much (rad) about the end of a joint; soft: 1 / (E t)
    of both stones at it, m/N."""
    return np.asarray(3.0 * force * soft / (np.pi * turn))


def is_at_end(normal: FloatArray) -> BoolArray:
    """Return which joints press at one end; normal (k, 2): their forces at both, none negative, N."""
    force = normal.sum(axis=1)
    return np.asarray((force > 0.0) & (normal.min(axis=1) <= AT_END * force))


def is_level(joints: Interfaces) -> BoolArray:
    """Return which joints (k,) may be beds of a column."""
    return np.asarray(np.abs(joints.normal[:, 1]) > LEVEL)


@dataclass(frozen=True, eq=False, slots=True)
class Columns:
    """Columns that joints (k,) between blocks are beds of: their height (k,) from there, up or down, and width (k,) in
    m, 0 where none is; of_block (n,): number of the column that each block is in, of_joint (k,): of the one at the
    joint, -1 where none is."""

    height: FloatArray
    width: FloatArray
    of_block: IntArray
    of_joint: IntArray


def columns_on(wall: Wall, joints: Interfaces, force: FloatArray) -> Columns:
    """Return the columns of a wall whose joints carry normal forces (k,) in N: stones one on the other, each on one
    stone and under one at most, or on several where the one on it is half as wide at least, or under several so, and
    pressed by none beside it."""
    drum, up = np.array([not block.fixed for block in wall.blocks]), joints.normal[:, 1] > 0.0
    level, sides = is_level(joints), (joints.i, joints.j)
    carried = np.zeros(len(drum))
    for side in sides:
        np.maximum.at(carried, side[level], force[level])
    for side in sides:
        drum[side[~level & (force > PRESSED * carried[side])]] = False
    wide = np.array([np.ptp(block.polygon[:, 0]) for block in wall.blocks])
    above, below = (
        (np.bincount(end, minlength=len(drum)), np.bincount(end, joints.length, len(drum)))
        for end in (np.where(up, *sides), np.where(up, *sides[::-1]))
    )
    for (count, _), (beyond, length) in ((above, below), (below, above)):
        drum &= (count <= 1) | ((beyond == 1) & (length >= 0.5 * wide))
    column = connected_groups(len(drum), *(side[drum[joints.i] & drum[joints.j]] for side in sides))
    low, high, width = np.full(len(drum), np.inf), np.full(len(drum), -np.inf), np.full(len(drum), np.inf)
    for number, block in zip(column[drum], (wall.blocks[k] for k in np.flatnonzero(drum)), strict=True):
        x, y = block.polygon.T
        low[number], high[number] = min(low[number], y.min()), max(high[number], y.max())
        width[number] = min(width[number], np.ptp(x))
    beside = np.where(drum[joints.i], joints.i, joints.j)
    there = drum[joints.i] | drum[joints.j]
    at, bed = column[beside], joints.centroid[:, 1]
    return Columns(
        height=np.where(there, np.maximum(high[at] - bed, bed - low[at]), 0.0),
        width=np.where(there, width[at], 0.0),
        of_block=np.where(drum, column, -1),
        of_joint=np.where(there, at, -1),
    )


def left_of_column(
    force: FloatArray, height: FloatArray, width: FloatArray, lever: FloatArray, soft: FloatArray
) -> FloatArray:
    """Return which part of what it bears as drawn is left of a column that leans on the end of its bed and bends.

    force (N) at `height` h (m) above the bed, by which it is pushed too; width of the column, m; lever d (m): of the
    force about that end, as drawn; soft (..., 2): 1 / (E t) of the stones on both sides of the bed, m/N. With k^2 = N /
    (E I) a beam-column that turns by r at its foot has the moment N (tan(k h) / k) (lambda + r) there (Timoshenko and
    Gere, Theory of Elastic Stability, 1961, 1.11), and its bed bears N (d - x^2 / (9 h r)), x of `under_column`. The
    largest lambda over r, times h / d, which makes it 1 as drawn, is k h / tan(k h) - (2 x / (3 d)) (k h / tan(k
    h))^(1/2); 0 where the column buckles. A force beside the middle, by e, bends it too, by e / cos(k h) - e, by which
    d is less.
    """
    angle = np.minimum(height * np.sqrt(12.0 * force * soft.max(axis=-1) / width**3), 0.5 * np.pi)
    bends = np.where(angle > 0.0, angle / np.tan(np.maximum(angle, 1e-9)), 1.0)
    edge = 2.0 * under_column(force, height * soft.sum(axis=-1)) / (3.0 * lever)
    beside = (0.5 * width - lever) * (1.0 / np.maximum(np.cos(angle), 1e-9) - 1.0)
    return np.maximum((1.0 - beside / lever) * bends - edge * np.sqrt(np.maximum(bends, 0.0)), 0.0)
