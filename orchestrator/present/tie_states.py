"""Ties as they are shown: where their ends have gone, their force, and whether they are slack or yield."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy.sparse as sparse

from orchestrator.basis.arrays import FloatArray
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.masonry.ties import Tie
from orchestrator.masonry.wall import Wall
from orchestrator.pushover.increments import Increment
from orchestrator.pushover.meshing import BodyMeshes
from orchestrator.pushover.solids.tie_bars import ends_of_ties

YIELDING = 1.0 - 1e-9
"""part of its strength from which a tie is said to yield: rounding"""
State = Literal["slack", "taut", "yields"]


@dataclass(frozen=True, eq=False, slots=True)
class ShownTies:
    """m ties: both ends (m, 2, 2) in m, undeformed; weights (2 m, nodes) of nodal displacements in those of the ends;
    strength (m,) in N."""

    ends: FloatArray
    weights: sparse.csr_matrix
    strength: FloatArray

    def moved(self, increment: Increment) -> FloatArray:
        """Return the displacements (m, 2, 2) of the ends in m."""
        nodal = increment.displacement[: self.weights.shape[1], :2]
        return np.asarray(self.weights @ nodal).reshape(-1, 2, 2)

    def states(self, increment: Increment) -> list[State]:
        """Return what each tie does."""
        pairs = zip(increment.tie_force.tolist(), self.strength.tolist(), strict=True)
        return [state_of(force, strength) for force, strength in pairs]


def shown_ties(wall: Wall, bodies: Bodies, meshes: BodyMeshes, ties: tuple[Tie, ...]) -> ShownTies | None:
    """Return the ties of a wall on its meshes, None where there are none."""
    if not ties:
        return None
    ends = np.array([(tie.start, tie.end) for tie in ties], dtype=float)
    weights = ends_of_ties(wall, bodies, meshes, ties)[1]
    return ShownTies(ends, weights, np.array([tie.strength for tie in ties]))


def state_of(force: float, strength: float) -> State:
    """Return what a tie of a strength does under a force, N; one that pushes too yields both ways."""
    if abs(force) >= YIELDING * strength:
        return "yields"
    return "taut" if force else "slack"
