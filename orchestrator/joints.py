"""Joints: the straight segments that two blocks share.

Convention used by every later stage: `start` -> `end` runs along the counter-clockwise outline of block i, so
tangent t = (end - start)/length, and n = (t_y, -t_x) is the outward normal of block i, pointing from i to j.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from annotated_types import Gt

from orchestrator.masonry.wall import FloatArray, IntArray, Wall
from orchestrator.units import Unit


@dataclass(frozen=True, slots=True)
class JointSettings:
    """How near two edges must lie to share a joint."""

    tolerance: Annotated[float, Unit("m"), Gt(0)] = 1e-5
    """largest distance between two edges that touch; also the overlap of two blocks that passes as rounding"""
    minimum_length: Annotated[float, Unit("m"), Gt(0)] = 1e-3
    """shorter shared segments are no joint"""


@dataclass(frozen=True, eq=False, slots=True)
class Assemblage:
    """A wall and its k joints as arrays (block numbers are positions in `wall.blocks`, not ids).

    block_i, block_j (k,): the blocks on both sides; start, end (k, 2) in m; friction (k,); cohesion (k,) in N/m2.
    """

    wall: Wall
    block_i: IntArray
    block_j: IntArray
    start: FloatArray
    end: FloatArray
    friction: FloatArray
    cohesion: FloatArray

    @property
    def length(self) -> FloatArray:
        """Joint lengths (k,) in m."""
        return np.linalg.norm(self.end - self.start, axis=1)

    @property
    def tangent(self) -> FloatArray:
        """Unit tangents (k, 2), from start to end."""
        return (self.end - self.start) / self.length[:, None]

    @property
    def normal(self) -> FloatArray:
        """Unit normals (k, 2), pointing from block i to block j."""
        tangent = self.tangent
        return np.column_stack([tangent[:, 1], -tangent[:, 0]])

    @property
    def midpoint(self) -> FloatArray:
        """Midpoints (k, 2) in m."""
        return 0.5 * (self.start + self.end)
