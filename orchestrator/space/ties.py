"""Ties: bars between two points of two blocks that pull, up to a strength, and never push.

A tie is a contact point without friction whose normal is turned round: its force N >= 0 pulls the second block towards
the first along the line between the two points, and v_N > 0 means that it goes slack. So every program and the
validator treat it as a joint, but for its capacity: N <= strength, and at N = strength it may lengthen (v_N < 0).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Literal

import numpy as np
from annotated_types import Gt, MaxLen, MinLen

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.basis.checked import Checked
from orchestrator.basis.errors import CaseError
from orchestrator.basis.printed import counted
from orchestrator.basis.units import Unit
from orchestrator.geometry.polyhedra import distance_to, tangents_of
from orchestrator.masonry.block_properties import refuse_beyond_weight
from orchestrator.masonry.interfaces import Interfaces
from orchestrator.space.contacts import SpaceAssemblage
from orchestrator.space.wall import SpaceWall

ON_BLOCK = 1e-3
"""of a block's size, as much as joints may gape by: an end so near its block is on it"""
AT_STRENGTH = 1e-6
"""part of its strength by which a tie that yields may be off it, as in the validator"""
SLACK = 1e-6
"""part of a block's mean weight that slack ties may pull with, by rounding"""


@dataclass(frozen=True, slots=True)
class Tie(Checked):
    """A bar between two points of two blocks; it weighs nothing."""

    blocks: Annotated[tuple[int, ...], MinLen(2)]
    """ids of the two blocks"""
    start: Annotated[tuple[Annotated[float, Unit("m")], ...], MinLen(3), MaxLen(3)]
    """where it is fixed to the first one, on it or in it: x, y and z, as in ["0.3 m", "0 m", "0.4 m"]"""
    end: Annotated[tuple[Annotated[float, Unit("m")], ...], MinLen(3), MaxLen(3)]
    """where it is fixed to the second one, on it or in it"""
    strength: Annotated[float, Gt(0), Unit("N")]
    """force at which it yields"""


@dataclass(frozen=True, slots=True)
class TieSettings(Checked):
    """The ties of a wall."""

    ties: tuple[Tie, ...] = ()
    """each a table [[reinforcement.ties]] with `blocks`, `start`, `end`, `strength`"""


def with_ties(assemblage: SpaceAssemblage, ties: Sequence[Tie]) -> SpaceAssemblage:
    """Return the assemblage with ties added to its joints. Raises CaseError for one that joins nothing."""
    if not ties:
        return assemblage
    wall = assemblage.wall
    place = wall.place_of
    for number, tie in enumerate(ties):
        _refuse(wall, tie, f"reinforcement.ties.{number}")
    blocks = np.array([[place[block] for block in tie.blocks] for tie in ties])
    point, last = (np.array([getattr(tie, name) for tie in ties], dtype=float) for name in ("start", "end"))
    normal = (point - last) / np.linalg.norm(point - last, axis=1)[:, None]
    added = Interfaces(
        i=blocks[:, 0],
        j=blocks[:, 1],
        normal=normal,
        tangents=np.array([tangents_of(n) for n in normal]),
        area=np.zeros(len(ties)),
        centroid=point,
        friction=np.zeros(len(ties)),
        capacity=np.array([tie.strength for tie in ties]),
        point=point,
        joint=np.arange(len(ties)),
        outlines=tuple(read_only([tie.start, tie.end]) for tie in ties),
        holes=((),) * len(ties),
    )
    return replace(assemblage, joints=assemblage.joints.and_also(added))


@dataclass(frozen=True, slots=True)
class TieForce:
    """A tie, numbered from 1 as in the case, what it pulls with and its strength in N, and what it does."""

    number: int
    pull: float
    strength: float
    state: Literal["slack", "taut", "yields"]


def tie_forces(assemblage: SpaceAssemblage, forces: FloatArray) -> tuple[TieForce, ...]:
    """Return the forces of all ties in a state with forces (p, 3) in N of all contact points."""
    joints, wall = assemblage.joints, assemblage.wall
    pulls, strengths = forces[joints.is_tie[joints.joint], 0], joints.capacity[joints.is_tie]
    pulls = np.where(pulls > SLACK * wall.weights[~wall.fixed].mean(), pulls, 0.0)
    states = np.select([pulls > (1.0 - AT_STRENGTH) * strengths, pulls > 0.0], ["yields", "taut"], "slack")
    return tuple(map(TieForce, range(1, len(pulls) + 1), pulls.tolist(), strengths.tolist(), states.tolist()))


def counted_joints(assemblage: SpaceAssemblage) -> str:
    """Return how many joints there are, with the ties beside them, as in "4 joints, 1 tie"."""
    ties = int(assemblage.joints.is_tie.sum())
    joints = counted(assemblage.joints.count - ties, "joint")
    return f"{joints}, {counted(ties, 'tie')}" if ties else joints


def _refuse(wall: SpaceWall, tie: Tie, key: str) -> None:
    """Raise CaseError for a tie between no two blocks or points, or whose ends lie beside its blocks."""
    blocks = {block.id: block for block in wall.blocks}
    if len(tie.blocks) != 2 or len(set(tie.blocks)) != 2 or not set(tie.blocks) <= blocks.keys():
        raise CaseError(f"{key}.blocks", f"{[*tie.blocks]} are not two blocks", "name two blocks of the wall")
    if all(blocks[name].fixed for name in tie.blocks):
        raise CaseError(f"{key}.blocks", "a tie between supports holds nothing", "name a block that can move")
    refuse_beyond_weight(wall.weights[~wall.fixed], tie.strength, f"{key}.strength")
    if tie.start == tie.end:
        raise CaseError(f"{key}.end", "its two points are one", "give two points [x, y, z] that lie apart")
    for end, name in zip(("start", "end"), tie.blocks, strict=True):
        shape, point = blocks[name].shape, np.array(getattr(tie, end), dtype=float)
        if distance_to(shape, point) > ON_BLOCK * shape.size:
            low, high = shape.vertices.min(axis=0), shape.vertices.max(axis=0)
            remedy = f"give a point of the block, which reaches from {shown_point(low)} to {shown_point(high)}"
            raise CaseError(f"{key}.{end}", f"{shown_point(point)} is not on block {name}", remedy)


def shown_point(point: Sequence[float] | FloatArray) -> str:
    """Return a point (3,) as it is told, in m."""
    return f"({', '.join(f'{x:.6g}' for x in point)}) m"
