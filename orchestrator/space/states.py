"""A limit state of a wall in space: forces and velocities, validated from geometry (validation.py)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.limit_analysis.validation import beyond
from orchestrator.space.conic_program import ConicSolution
from orchestrator.space.contacts import SpaceAssemblage
from orchestrator.space.elastic_joints import Push
from orchestrator.space.equilibrium import Torsion
from orchestrator.space.loads import SpaceLoads
from orchestrator.space.validation import LIMITS, Validation, validate

NEARLY = {name: limit * (10.0 if name in ("equilibrium", "yield_excess") else 1e3) for name, limit in LIMITS.items()}
"""What a state is wrong by at most that is one but for so little: its forces balance, and of how it moves nobody knows
where a joint lies, nor its friction, to a part in a thousand."""


@dataclass(frozen=True, eq=False, slots=True)
class SpaceState:
    """Multiplier, forces (p, 3) in N and velocities (n, 6) of all blocks at unit live-load power; `name` says what
    found it, `error` why it is none ("" for a state), `nearly` whether it is one but for NEARLY."""

    name: str
    load_multiplier: float
    forces: FloatArray
    velocities: FloatArray
    validation: Validation
    seconds: float
    error: str = ""
    nearly: bool = False

    @property
    def valid(self) -> bool:
        """Whether this is a limit state without dilation."""
        return not self.error


def state_of(
    name: str,
    assemblage: SpaceAssemblage,
    loads: SpaceLoads,
    solution: ConicSolution | Push,
    free_velocities: FloatArray,
    torsion: Torsion,
) -> SpaceState:
    """Return forces and velocities of the free blocks as a validated state."""
    velocities = np.zeros((len(assemblage.wall.blocks), 6))
    velocities[~assemblage.wall.fixed] = free_velocities
    validation = validate(assemblage, loads, solution.load_multiplier, solution.forces, velocities, torsion)
    complaints = ", ".join(validation.complaints)
    nearly = bool(complaints) and not beyond(validation, NEARLY)
    found = solution.load_multiplier, solution.forces, velocities, validation, solution.seconds
    return SpaceState(name, *found, complaints, nearly)
