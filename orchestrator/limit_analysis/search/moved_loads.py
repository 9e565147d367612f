"""Loads on blocks that have moved: forces keep their size and direction, and their place on the block.

A force F at an arm r from the centroid, turned with its block by an angle t, has the moment

    (R(t) r) x F = M cos(t) + Q sin(t),    M = r x F,    Q = -r . F  the moment on a block turned by a right angle

so that a load on top of a block that leans overturns it as the weight of another block there does. Its work is
F . u + M sin(t) + Q (1 - cos(t)), of which force and moment are the slopes. Source: rigid bodies.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.limit_analysis.paper.equilibrium import Equilibrium
from orchestrator.limit_analysis.search.scaled_problem import ScaledProblem


@dataclass(frozen=True, eq=False, slots=True)
class LinearLoads:
    """Dead and live load (3m,) about some displacements (3m,), in the units of `ScaledProblem`, with their slopes: a
    moment changes as its own block turns and with nothing else. By default they are the same wherever blocks are."""

    dead: FloatArray
    live: FloatArray
    dead_slope: FloatArray | float = 0.0
    live_slope: FloatArray | float = 0.0
    about: FloatArray | float = 0.0

    def at(self, displacements: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return dead and live load (3m,)."""
        since = displacements - self.about
        return self.dead + self.dead_slope * since, self.live + self.live_slope * since

    def restoring(self, multiplier: float) -> FloatArray | float:
        """Return by how much loads resist displacements (3m,), negative where they add to them: a stiffness."""
        return -(self.dead_slope + multiplier * self.live_slope)


@dataclass(frozen=True, eq=False, slots=True)
class MovedLoads:
    """Dead and live load (3m,) as drawn, in the units of `ScaledProblem`; turned (m, 2): their moments on blocks turned
    by a right angle; radians: turn of displacement 1."""

    dead: FloatArray
    live: FloatArray
    turned: FloatArray
    radians: float

    def linearised(self, displacements: FloatArray) -> LinearLoads:
        """Return dead and live load about displacements (3m,)."""
        turn = self.radians * displacements[2::3]

        def about(load: FloatArray, turned: FloatArray) -> tuple[FloatArray, FloatArray]:
            there, slope = load.copy(), np.zeros_like(load)
            there[2::3] = load[2::3] * np.cos(turn) + turned * np.sin(turn)
            slope[2::3] = self.radians * (turned * np.cos(turn) - load[2::3] * np.sin(turn))
            return there, slope

        dead, dead_slope = about(self.dead, self.turned[:, 0])
        live, live_slope = about(self.live, self.turned[:, 1])
        return LinearLoads(dead, live, dead_slope, live_slope, displacements)

    def beyond(self, displacements: FloatArray) -> float:
        """Return by how much further the points where live forces act have moved along them, on average over the
        forces, than `live` times the displacements (3m,)."""
        turn = self.radians * displacements[2::3]
        work = self.live[2::3] @ (np.sin(turn) - turn) + self.turned[:, 1] @ (2.0 * np.sin(0.5 * turn) ** 2)
        return float(work) / self.radians


def moved_loads(problem: ScaledProblem, equilibrium: Equilibrium, unit: float) -> MovedLoads:
    """Return the loads of a wall; unit: metres of displacement 1."""
    assert equilibrium.moments_turned is not None
    length = equilibrium.block_length
    over = np.array([equilibrium.unit_force, equilibrium.live_total])
    return MovedLoads(problem.dead, problem.live, equilibrium.moments_turned / (length * over), unit / length)
