"""The limit state nearest to where a path has led: its forces change as little as a mechanism asks for.

Where a motion creeps, a state is near that it would come to after displacements far beyond any that mean something. The
forces of such a state are not unique; those that a long motion h along the live load would leave behind are

    given slips:           forces of   min (q - q_0) F (q - q_0) / (2 h) - lambda + sum mu |slip| N   in Coulomb's cone
    given normal forces:   mechanism of the second program of lower_states.py

F is the flexibility of the joints, q_0 what they carry now: for slips that repeat themselves the first is one step of
the path under displacement control, but convex, and solved whatever changes. The two in turn come to forces and
mechanism whose power balances, or stand still; then with ten times the displacement, and at last without F, at the
lower end of the face of forces (lower_states.py). What comes out is checked, and counts only between given multipliers.
Sources: lower_states.py; De Saxcé and Feng 1998 (a step of friction as a convex program in which slips are given).
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.errors import ConvergenceError
from orchestrator.limit_analysis.paper.limit_state import LimitState
from orchestrator.limit_analysis.paper.linear_program import LimitProgram, LimitSolution
from orchestrator.limit_analysis.problem import Problem, record_of
from orchestrator.limit_analysis.search.lower_states import CLOSING_TOLERANCE, ClosedState, TwoPrograms

FIRST_MOTION = 1e3
"""h at first, mean block weights over the mean stiffness of the joints."""
LONGER = 10.0
"""Factor on h where power balances no better."""
TURNS_TO_A_STATE = 7
"""Turns at most: h comes to a million where none of them leads on."""
BETTER = 0.3
"""Part of the imbalance of the turn before that is still worth another turn with the same h."""
NEARLY = 1e-5
"""Power out of balance of what is worth a check: ten times what the check lets pass."""
FACE_WEIGHTS = (1e-4, 1e-5)
"""w of lower_states for the last two: the lower end of a face of forces, more and less sharply."""


class Closing:
    """The programs of one wall, each set up once when it is first used."""

    def __init__(self, problem: Problem, stiffness: FloatArray) -> None:
        """Take a wall and the stiffness (k, 3) of its joints, on average 1."""
        self._problem, self._stiffness = problem, stiffness
        self.programs = TwoPrograms(problem.equilibrium, problem.friction)

    @cached_property
    def _forces(self) -> LimitProgram:
        problem = self._problem
        return LimitProgram(problem.equilibrium, problem.friction, CLOSING_TOLERANCE, 1.0 / self._stiffness)

    def near(self, state: LimitState, slip: FloatArray, low: float, high: float) -> LimitState | None:
        """Return the state nearest to one that does not pass the check, from multipliers low to high, or None.

        It goes on from the forces of `state` and slips (k,) in m/s at unit live power.
        """
        problem, found = self._problem, list[LimitState]()
        for closed in self._turns(state.joint_forces, slip, low, high):
            if closed.imbalance <= NEARLY and low <= closed.forces.load_multiplier <= high:
                records = (*state.records, record_of(closed.forces, 0.0), record_of(closed.mechanism, 0.0))
                there = problem.state("path", problem.no_dilatancy, closed.forces, closed.mechanism, records)
                found += [] if problem.complaints(there) else [there]
        return min(found, key=lambda one: abs(one.load_multiplier - state.load_multiplier), default=None)

    def _turns(self, forces: FloatArray, slip: FloatArray, low: float, high: float) -> Iterator[ClosedState]:
        """Yield forces (k, 3) in N and mechanisms in turn, until they leave the multipliers from low to high."""
        first, motion, last = slip, FIRST_MOTION, np.inf
        try:
            for _ in range(TURNS_TO_A_STATE):
                closed = self.programs.closed(self._nearest(forces, slip, motion))
                yield closed
                elsewhere = not low <= closed.forces.load_multiplier <= high
                if closed.balances or elsewhere:
                    break
                motion *= LONGER if closed.imbalance > BETTER * last else 1.0
                last, slip = closed.imbalance, closed.mechanism.rates[:, 2]
            for weight in FACE_WEIGHTS if last < np.inf else ():
                yield self.programs.closed(self.programs.lowest_forces(first, weight))
        except ConvergenceError:
            return

    def _nearest(self, forces: FloatArray, slip: FloatArray, motion: float) -> LimitSolution:
        friction = self._problem.friction
        return self._forces.solve(friction.cohesion, friction.slope * np.abs(slip), around=(forces, 1.0 / motion))
