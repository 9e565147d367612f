"""Zero-dilation states exactly, and ever lower ones: two linear programs in turn.

    given slips:           min-lambda forces of   max (1 - w) lambda - sum mu |slip| N   in Coulomb's cone
    given normal forces:   mechanism of           max lambda,   |s| <= c + mu N_given    (no slope, hence no dilation)

Slips fix a face of admissible forces on which lambda still varies; a slightly smaller weight of lambda takes its lowest
end. There more joints open or slide, so other mechanisms become possible; the second program returns one. Its optimum
is lambda of the forces given exactly if these forces and its mechanism are a non-associative limit state: the
difference of the two is the power that does not balance (virtual work), 1e-10 of the live load's power as a rule, after
one or two turns, whatever they began with. Each turn with a balance is a state, and lambda does not grow from one to
the next (the forces given stay admissible). That is a local search: where it ends depends on where it begins.
Source: De Saxcé's bipotential is the sum that these two programs minimise in turn; own derivation.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.errors import ConvergenceError
from orchestrator.limit_analysis.paper.equilibrium import Equilibrium
from orchestrator.limit_analysis.paper.linear_program import LimitProgram, LimitSolution
from orchestrator.limit_analysis.paper.yield_conditions import YieldConditions
from orchestrator.limit_analysis.search.moving_part import MovingPart

FACE_WEIGHT = 1e-3
"""w above at first. What it costs is power that does not balance, at most w times the range of the face: with the
weight kept at 1e-3 a wall of 290 irregular blocks (random 25 of docs/studies) stays out of balance by 7e-7, at whatever
turn. A descent that stands still out of balance therefore goes on with a tenth of it: there 2e-9 at 1e-4."""
LEAST_FACE_WEIGHT = 1e-6
"""w above at least."""
CLOSE_FACE_WEIGHT = 1e-5
"""w for slips that are those of a state already, to within what is to be closed: at FACE_WEIGHT what stays out of
balance is 2.7e-7 at 2,979 blocks and 6.0e-7 at 997, here it is 9e-9 and 4.5e-9."""
POWER_LEFT = 1e-7
"""Power out of balance, relative to the live load's power, that makes forces and mechanism one state: a thousand times
CLOSING_TOLERANCE; reached is 1e-8 as a rule."""
NO_SLOPE = 1e-12
"""Slope of friction lines that shall have none. Exact zeros leave the matrix, and the solver then eliminates in an
order that costs five times more (3.1 s for 0.6 s a program at 997 blocks)."""
CLOSING_TOLERANCE = 1e-10
"""Of the two programs: at 1e-12 they cost twice as much, and what is left out of balance is below TIGHT here too."""
TIGHT = 1e-8
"""Where there is a choice, states this well balanced are taken."""
SMALLEST = 1e-8
"""A load multiplier that is zero: relative to less nothing is said."""
LEAST_FALL = 1e-6
"""Relative fall of lambda below which a descent has ended."""
TURNS_OF_DESCENT = 12
"""Turns of a descent at most."""


@dataclass(frozen=True, eq=False, slots=True)
class ClosedState:
    """Forces in Coulomb's cone and a mechanism without dilation; their power is out of balance by `imbalance`."""

    forces: LimitSolution
    mechanism: LimitSolution

    @property
    def imbalance(self) -> float:
        """Power that does not balance, relative to the live load's power."""
        reached = self.forces.load_multiplier
        return abs(self.mechanism.load_multiplier - reached) / max(abs(reached), SMALLEST)

    @property
    def balances(self) -> bool:
        """Whether this is a limit state."""
        return self.imbalance <= POWER_LEFT


class TwoPrograms:
    """The two programs of one wall, each set up once when it is first used.

    With a `part`, mechanisms that close forces are of that part if that is enough.
    """

    def __init__(self, equilibrium: Equilibrium, coulomb: YieldConditions, part: MovingPart | None = None) -> None:
        """Take the terms of Eq. (1)."""
        self._equilibrium, self._coulomb, self._part = equilibrium, coulomb, part

    @cached_property
    def _forces(self) -> LimitProgram:
        return LimitProgram(self._equilibrium, self._coulomb, CLOSING_TOLERANCE)

    @cached_property
    def _mechanism(self) -> LimitProgram:
        return _without_slope(self._equilibrium, self._coulomb)

    @cached_property
    def _mechanism_of_part(self) -> LimitProgram:
        assert self._part is not None
        return _without_slope(self._part.equilibrium, self._part.friction)

    def lowest_forces(self, slip: FloatArray, face_weight: float = FACE_WEIGHT) -> LimitSolution:
        """Forces in Coulomb's cone with the lowest multiplier that go with slips (k,) in m/s."""
        return self._forces.solve(self._coulomb.cohesion, self._coulomb.slope * np.abs(slip), 1.0 - face_weight)

    def mechanism(self, normal: FloatArray) -> LimitSolution:
        """Mechanism without dilation for given normal forces (k,) in N."""
        return self._mechanism.solve(self._strength(normal))

    def closed(self, forces: LimitSolution) -> ClosedState:
        """Return forces with the mechanism that fits them best."""
        if (part := self._part) is not None:
            found = self._mechanism_of_part.solve(self._strength(forces.normal)[part.joints])
            if (state := ClosedState(forces, part.of_wall(found))).balances:
                return state
        return ClosedState(forces, self.mechanism(forces.normal))

    def _strength(self, normal: FloatArray) -> FloatArray:
        return self._coulomb.cohesion + self._coulomb.slope * np.maximum(normal, -self._coulomb.tension)


def _without_slope(equilibrium: Equilibrium, coulomb: YieldConditions) -> LimitProgram:
    no_slope = replace(coulomb, slope=np.where(coulomb.slope > 0.0, NO_SLOPE, 0.0))
    return LimitProgram(equilibrium, no_slope, CLOSING_TOLERANCE)


def descent(
    programs: TwoPrograms,
    slip: FloatArray,
    turns: int = TURNS_OF_DESCENT,
    passed: Sequence[ClosedState] = (),
    face_weight: float = FACE_WEIGHT,
) -> Iterator[ClosedState]:
    """Yield states (some may not balance) with ever lower multipliers, beginning with slips (k,) in m/s.

    Ends when the multiplier of a state falls no more or is that of one already `passed`, when the face weight cannot be
    what is out of balance, after `turns`, or when a program fails.
    """
    known = [state.forces.load_multiplier for state in passed if state.imbalance <= TIGHT]
    last = np.inf
    for _ in range(turns):
        try:
            state = programs.closed(programs.lowest_forces(slip, face_weight))
        except ConvergenceError:
            return
        yield state
        reached = state.forces.load_multiplier
        falls_no_more = last - reached <= LEAST_FALL * abs(reached)
        was_here = any(abs(reached - before) <= LEAST_FALL * abs(reached) for before in known)
        if state.imbalance <= TIGHT and (falls_no_more or was_here):
            return
        if falls_no_more:
            face_weight *= 0.1
        if face_weight < 0.5 * LEAST_FACE_WEIGHT:
            return
        last, slip = reached, state.mechanism.rates[:, 2]
