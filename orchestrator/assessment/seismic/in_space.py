"""Start of a mechanism of blocks in space by the kinematic approach (kinematic.py has its formulas)."""

from __future__ import annotations

import numpy as np

from orchestrator.assessment.seismic.kinematic import as_bodies, participation
from orchestrator.basis.arrays import FloatArray
from orchestrator.geometry.rigid import velocity_of_points
from orchestrator.space.loads import SpaceLoadSettings, direction_of, masses_on
from orchestrator.space.mechanism import SpaceMechanism
from orchestrator.space.wall import SpaceWall

HORIZONTAL = 1e-9
"""cosine between a live load and the vertical up to which it is horizontal but for rounding"""


def participation_in_space(
    wall: SpaceWall, load: SpaceLoadSettings, mechanism: SpaceMechanism, velocities: FloatArray
) -> float | None:
    """Return e* [C8.7.1.5] of a mechanism with velocities (n, 6) of all blocks, under a horizontal load proportional to
    mass; None for another load, whose multiplier is no part of g.

    Blocks that move as one are one body; what rests on one body is another one, at its own place (the Q_k of
    C8.7.1.2.1.1 beside its P_k).
    """
    direction = direction_of(load, wall.up)
    if load.distribution != "mass" or abs(direction @ wall.up) > HORIZONTAL:
        return None
    masses = masses_on(wall, load)
    body = mechanism.body[masses.block]
    number = np.where(masses.own, body, body + mechanism.body.max() + 1)
    moved = velocity_of_points(velocities[masses.block], masses.point - wall.centroids[masses.block])
    return participation(*as_bodies(masses.weight, moved, number, direction))
