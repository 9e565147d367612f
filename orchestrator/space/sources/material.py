"""What no file of another program says: unit weight, friction, and which blocks are supports."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from annotated_types import Gt

from orchestrator.basis.checked import Checked
from orchestrator.basis.errors import CaseError
from orchestrator.basis.units import Unit
from orchestrator.geometry.polyhedra import Polyhedron, reversed_faces, volume_of
from orchestrator.masonry.wall import Friction
from orchestrator.space.wall import SpaceBlock, SpaceWall

AT_FOOT = 0.05
"""Part of a block's height within which its foot is level with the lowest one."""


@dataclass(frozen=True, slots=True)
class SpaceMaterial(Checked):
    """Of what imported blocks are."""

    unit_weight: Annotated[float, Gt(0), Unit("N/m3")] = 20e3
    """of every block"""
    friction: Friction = 0.6
    """coefficient in every joint"""


def oriented(body: Polyhedron) -> Polyhedron:
    """Return a body with its faces outwards, where all of them are inwards."""
    return body if volume_of(body) >= 0 else reversed_faces(body)


def with_supports(wall: SpaceWall, ids: Sequence[int]) -> SpaceWall:
    """Return the wall with blocks held: those named, else those it has, else the ones that stand lowest. Raises
    CaseError for an id that does not exist."""
    known = {block.id for block in wall.blocks}
    for wanted in ids:
        if wanted not in known:
            raise CaseError("--supports", f"there is no block {wanted}", f"ids are {min(known)} to {max(known)}")
    if not ids and wall.fixed.any():
        return wall
    held = set(ids) or {block.id for block in _lowest(wall)}
    return replace(wall, blocks=tuple(replace(block, fixed=block.id in held) for block in wall.blocks))


def _lowest(wall: SpaceWall) -> list[SpaceBlock]:
    feet = np.array([float((block.shape.vertices @ wall.up).min()) for block in wall.blocks])
    heights = np.array([float(np.ptp(block.shape.vertices @ wall.up)) for block in wall.blocks])
    return [block for block, foot, h in zip(wall.blocks, feet, heights, strict=True) if foot - feet.min() < AT_FOOT * h]
