"""Ties: bars between two points of two blocks that pull, up to a strength, and never push.

A tie is a contact point without friction whose normal is turned round: its force N >= 0 pulls the second block towards
the first along the line between the two points, and v_N > 0 means that it goes slack. So every program and the
validator treat it as a joint, but for its capacity: N <= strength, and at N = strength it may lengthen (v_N < 0).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from annotated_types import Gt, MinLen

from orchestrator.basis.arrays import read_only
from orchestrator.basis.checked import Checked
from orchestrator.basis.errors import CaseError
from orchestrator.basis.units import Unit
from orchestrator.geometry.polyhedra import tangents_of
from orchestrator.masonry.interfaces import Interfaces
from orchestrator.space.contacts import SpaceAssemblage


@dataclass(frozen=True, slots=True)
class Tie(Checked):
    """A bar between two points of two blocks; it weighs nothing."""

    blocks: Annotated[tuple[int, ...], MinLen(2)]
    """ids of the two blocks"""
    start: Annotated[tuple[Annotated[float, Unit("m")], ...], MinLen(3)]
    """where it is fixed to the first one, [x, y, z]"""
    end: Annotated[tuple[Annotated[float, Unit("m")], ...], MinLen(3)]
    """where it is fixed to the second one"""
    strength: Annotated[float, Gt(0), Unit("N")]
    """force at which it yields"""


@dataclass(frozen=True, slots=True)
class TieSettings(Checked):
    """The ties of a wall."""

    ties: tuple[Tie, ...] = ()
    """each a table [[reinforcement.ties]] with `blocks`, `start`, `end`, `strength`"""


def with_ties(assemblage: SpaceAssemblage, ties: Sequence[Tie]) -> SpaceAssemblage:
    """Return the assemblage with ties added to its joints. Raises CaseError for one that joins no two blocks."""
    if not ties:
        return assemblage
    wall = assemblage.wall
    place = {block.id: k for k, block in enumerate(wall.blocks)}
    ends, normals, starts = [], [], []
    for number, tie in enumerate(ties):
        key = f"reinforcement.ties.{number}"
        if len(tie.blocks) != 2 or len(set(tie.blocks)) != 2 or not set(tie.blocks) <= place.keys():
            raise CaseError(f"{key}.blocks", f"{[*tie.blocks]} are not two blocks", "name two blocks of the wall")
        start, end = np.array(tie.start, dtype=float), np.array(tie.end, dtype=float)
        length = float(np.linalg.norm(end - start)) if start.shape == end.shape == (3,) else 0.0
        if not length > 0:
            raise CaseError(f"{key}.end", "its two points are one", "give two points [x, y, z] that lie apart")
        ends.append([place[block] for block in tie.blocks])
        normals.append((start - end) / length)
        starts.append(start)
    blocks, normal, point = np.array(ends), np.array(normals), np.array(starts)
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
    )
    return replace(assemblage, joints=assemblage.joints.and_also(added))
