"""Joints: the straight segments that two blocks share.

Convention used by every later stage: `start` -> `end` runs along the counter-clockwise outline of block i, so
tangent t = (end - start)/length, and n = (t_y, -t_x) is the outward normal of block i, pointing from i to j.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import shapely
from annotated_types import Gt, Le
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from orchestrator.errors import CaseError
from orchestrator.masonry.wall import FloatArray, IntArray, Wall, read_only
from orchestrator.units import Unit


@dataclass(frozen=True, slots=True)
class JointSettings:
    """How near two edges must lie to share a joint."""

    tolerance: Annotated[float, Unit("m"), Gt(0), Le(0.01)] = 1e-5
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


def find_joints(wall: Wall, settings: JointSettings) -> Assemblage:
    """Return the assemblage of `wall`: every pair of antiparallel, collinear edges that overlap is a joint.

    Joints are sorted by block i, block j and position along block i's outline; two supports have none.
    """
    segments = [segment for i, j in _neighbours(wall, settings.tolerance) for segment in _shared(wall, i, j, settings)]
    count = len(segments)
    return Assemblage(
        wall=wall,
        block_i=read_only([s[0] for s in segments], np.int64),
        block_j=read_only([s[1] for s in segments], np.int64),
        start=read_only(np.reshape([s[2] for s in segments], (count, 2))),
        end=read_only(np.reshape([s[3] for s in segments], (count, 2))),
        friction=read_only(np.full(count, wall.friction)),
        cohesion=read_only(np.zeros(count)),
    )


def _neighbours(wall: Wall, tolerance: float) -> list[tuple[int, int]]:
    """Return pairs i < j of blocks nearer than `tolerance`, without pairs of supports."""
    outlines = [shapely.Polygon(block.polygon) for block in wall.blocks]
    first, second = shapely.STRtree(outlines).query(outlines, predicate="dwithin", distance=2 * tolerance)
    fixed = np.array([block.fixed for block in wall.blocks])
    keep = (first < second) & ~(fixed[first] & fixed[second])
    return sorted(zip(first[keep].tolist(), second[keep].tolist(), strict=True))


def _shared(wall: Wall, i: int, j: int, settings: JointSettings) -> Iterator[tuple[int, int, FloatArray, FloatArray]]:
    """Yield the segments that blocks i and j share, along i's outline."""
    for a, b in _edges(wall.blocks[i].polygon):
        length = float(np.linalg.norm(b - a))
        tangent = (b - a) / length
        found = []
        for c, d in _edges(wall.blocks[j].polygon):
            distance = np.abs((np.array([c, d]) - a) @ np.array([tangent[1], -tangent[0]]))
            if distance.max() > settings.tolerance or (d - c) @ tangent >= 0:
                continue
            first, last = max(0.0, float((d - a) @ tangent)), min(length, float((c - a) @ tangent))
            if last - first > settings.minimum_length:
                found.append((first, last))
        for first, last in sorted(found):
            yield i, j, a + first * tangent, a + last * tangent


def _edges(polygon: FloatArray) -> Iterator[tuple[FloatArray, FloatArray]]:
    return zip(polygon, np.roll(polygon, -1, axis=0), strict=True)


def check_assemblage(assemblage: Assemblage) -> None:
    """Raise CaseError for a block that no chain of joints connects to a support."""
    blocks = assemblage.wall.blocks
    pairs = (np.ones(len(assemblage.block_i)), (assemblage.block_i, assemblage.block_j))
    _, group = connected_components(coo_matrix(pairs, shape=(len(blocks), len(blocks))), directed=False)
    supported = {int(group[k]) for k, block in enumerate(blocks) if block.fixed}
    touching = {*assemblage.block_i.tolist(), *assemblage.block_j.tolist()}
    for number, block in enumerate(blocks):
        if not block.fixed and group[number] not in supported:
            problem = "is not connected to any support" if number in touching else "touches no other block"
            raise CaseError(f"block {block.id}", problem, "move it until it shares a joint, or remove it")
