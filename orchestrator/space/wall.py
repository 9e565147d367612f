"""Blocks in space and the wall they form (all SI: N, m), and what makes a wall one that can be analysed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import shapely

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.basis.errors import CaseError
from orchestrator.geometry.polyhedra import Polyhedron, centroid_of, face_normals, flaw_of, is_convex, volume_of
from orchestrator.geometry.shared_volume import common_volume
from orchestrator.masonry.wall import LARGEST_COORDINATE, refuse_extreme

SHARED_PART = 1e-4
"""Part of the smaller block's volume that two blocks may share: the rounding of a drawing."""
PLATE = 0.25
"""Part of a block's least extent that another one may go into it at most, whatever the gap."""
UPRIGHT = np.array([0.0, 0.0, 1.0])
"""direction against gravity of walls in space"""


@dataclass(frozen=True, eq=False, slots=True)
class SpaceBlock:
    """One stone: its shape, `unit_weight` in N/m3, `fixed` for supports; friction None: the wall's. along (3,): unit
    vector along the wall it is a stone of, None where that is not known."""

    id: int
    shape: Polyhedron
    fixed: bool = False
    unit_weight: float = 20e3
    material: str = ""
    friction: float | None = None
    along: FloatArray | None = None

    def moved(self, turn: FloatArray, shift: FloatArray) -> SpaceBlock:
        """Return the stone after x -> turn x + shift."""
        along = None if self.along is None else read_only(turn @ self.along)
        return replace(self, shape=self.shape.moved(turn, shift), along=along)


@dataclass(frozen=True, eq=False, slots=True)
class SpaceWall:
    """Blocks, the coefficient of friction of all that have none of their own, and the unit vector `up` (3,)."""

    name: str
    blocks: tuple[SpaceBlock, ...]
    friction: float
    up: FloatArray

    def moved(self, turn: FloatArray, shift: FloatArray | None = None) -> SpaceWall:
        """Return the wall after x -> turn x + shift, gravity with it."""
        offset = np.zeros(3) if shift is None else shift
        blocks = tuple(block.moved(turn, offset) for block in self.blocks)
        return replace(self, blocks=blocks, up=read_only(turn @ self.up))

    @property
    def place_of(self) -> dict[int, int]:
        """Position in `blocks` of every block by its id."""
        return {block.id: position for position, block in enumerate(self.blocks)}

    @property
    def fixed(self) -> np.ndarray:
        """Which blocks are supports (n,)."""
        return np.array([block.fixed for block in self.blocks])

    @property
    def centroids(self) -> FloatArray:
        """Centroids (n, 3) in m."""
        return np.array([centroid_of(block.shape) for block in self.blocks])

    @property
    def weights(self) -> FloatArray:
        """Weights (n,) in N, supports included."""
        return np.array([block.unit_weight * volume_of(block.shape) for block in self.blocks])


def check_wall(wall: SpaceWall, gap: float = 0.0, looser: str = "") -> None:
    """Raise CaseError for a wall that is not one: bodies, ids, supports, material, overlaps.

    gap: part of a block's size (cube root of its volume) by which corners may lie off the plane of their face, and
    blocks in each other. looser: what helps, too, where that is not enough.
    """
    if not wall.blocks:
        raise CaseError("blocks", "there are none", "list the blocks, each with vertices and faces, and a support")
    refuse_extreme("friction", wall.friction)
    seen: set[int] = set()
    for block in wall.blocks:
        key = f"block {block.id}"
        if block.id in seen:
            raise CaseError(key, "two blocks have this id", "give every block its own id")
        seen.add(block.id)
        _check_block(block, key, gap, looser)
    if not wall.fixed.any():
        raise CaseError("blocks", "no block is a support", 'mark the ground as a block with "fixed": true')
    if wall.fixed.all():
        raise CaseError(
            "blocks", "every block is a support", 'add one that stands on it, without "fixed" in a block file'
        )
    refuse_overlaps(wall, gap, looser)


def _check_block(block: SpaceBlock, key: str, gap: float, looser: str) -> None:
    vertices = block.shape.vertices
    if not np.isfinite(vertices).all():
        raise CaseError(key, "a coordinate is not a finite number", "give finite coordinates")
    if np.abs(vertices).max() > LARGEST_COORDINATE:
        problem = f"lies {np.abs(vertices).max():.3g} m from the origin, where numbers are too coarse for joints"
        raise CaseError(key, problem, "subtract a common offset from all coordinates, or check the unit of length")
    if flaw := flaw_of(block.shape, gap * float(np.cbrt(abs(volume_of(block.shape)))), looser):
        raise CaseError(key, *flaw)
    for name, value in (("unit_weight", block.unit_weight), ("friction", block.friction)):
        if value is not None:
            refuse_extreme(f"{key}.{name}", value)


def refuse_overlaps(wall: SpaceWall, gap: float = 0.0, looser: str = "") -> None:
    """Raise CaseError for two blocks that share more than SHARED_PART of the smaller one's volume, and go into each
    other by more than `gap` of its size, or, where one is not convex, share `gap` of that volume more."""
    shapes = [block.shape for block in wall.blocks]
    low, high = np.array([s.vertices.min(axis=0) for s in shapes]), np.array([s.vertices.max(axis=0) for s in shapes])
    volume = np.array([volume_of(shape) for shape in shapes])
    normals = [face_normals(shape) for shape in shapes]
    slack, thickness = 1e-6 * (high - low).max(axis=1), (high - low).min(axis=1)
    for i, j in zip(*pairs_of_boxes(low + slack[:, None], high - slack[:, None]), strict=True):
        smaller = min(volume[i], volume[j])
        thinnest = min(gap * float(np.cbrt(smaller)), PLATE * min(thickness[i], thickness[j]))
        if _apart(shapes[i], normals[i], shapes[j], thinnest) or _apart(shapes[j], normals[j], shapes[i], thinnest):
            continue
        convex = is_convex(shapes[i], thinnest) and is_convex(shapes[j], thinnest)
        common = common_volume(shapes[i], shapes[j], thinnest)
        if common > (SHARED_PART + (0.0 if convex else gap)) * smaller:
            one, other = wall.blocks[i], wall.blocks[j]
            twice = common > 0.9 * smaller
            problem = f"overlaps block {other.id} by {common:.3g} m3"
            remedy = "given twice? remove one of them" if twice else f"correct one of them{looser}"
            raise CaseError(f"block {one.id}", problem, remedy)


def _apart(one: Polyhedron, normals: FloatArray, other: Polyhedron, by: float) -> bool:
    """Return whether the plane of a face of `one` has all of it behind and all of `other` in front, to `by` m or
    rounding."""
    slack = max(by, 1e-5 * min(one.size, other.size))
    behind = (normals @ one.vertices.T).max(axis=1)
    return bool(((normals @ other.vertices.T).min(axis=1) > behind - slack).any())


def pairs_of_boxes(low: FloatArray, high: FloatArray) -> tuple[np.ndarray, np.ndarray]:
    """Return the pairs i < j of boxes (n, 3) that share a point."""
    flat = shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1])
    i, j = shapely.STRtree(flat).query(flat)
    keep = (i < j) & (low[i, 2] <= high[j, 2]) & (low[j, 2] <= high[i, 2])
    order = np.lexsort((j[keep], i[keep]))
    return i[keep][order], j[keep][order]
