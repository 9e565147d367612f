"""States without dilation by cone programs: the dilation shift, closing, descent. They give the range, not the
headline.

    dilation shift    max lambda - sum s_k N_k in Coulomb's cone,   s <- (1 - w) s + w mu |v_T|,   s = 0 at first
    given slips       forces of   max (1 - w) lambda - sum mu |v_T| N   in Coulomb's cone: the lowest that go with them
    given normals     mechanism of   max lambda,   |T| <= mu N^   (constant radius, hence no dilation)

Forces and mechanism are a state where both programs have the same multiplier; each turn of a descent that balances is
one, and its multiplier does not grow from turn to turn. That is a local search: where it ends depends on where it
begins. It is the plane's limit_analysis.lower_states with cones. Sources: Acary et al. 2011; De Saxcé's bipotential.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.errors import ConvergenceError
from orchestrator.space.conic_program import TOLERANCE, ConicSolution, solve_associative, solve_given_normals
from orchestrator.space.equilibrium import SpaceEquilibrium
from orchestrator.space.validation import LIMITS
from orchestrator.space.work import Work

DILATION_RELAXATION = 0.5
"""w of the dilation shift: with 1 a wall cycles."""
SETTLED = 1e-6
"""Power of the dilation left over the live load's, at which the shift has settled."""
FACE_WEIGHT = 1e-4
"""How much less lambda weighs for the lowest forces that go with slips, how much more for the highest; what it costs is
power out of balance, at most this times the range of the face."""
PROGRAMS_AGREE = LIMITS["power"]
"""Relative difference of the two programs' multipliers that makes forces and mechanism one state."""
SLIP_RELAXATION = 1.7
"""Part of the change of slips that is taken from the second turn on while states do not balance: 1.1e-5 is left after
six turns at 1,010 blocks, 2.3e-5 with 1."""
ROUGH = 1e-7
"""Tolerance of programs before states balance: a quarter fewer iterations."""
LEAST_DESCENT = 1e-5
"""Relative fall of lambda below which a descent has ended."""


@dataclass(frozen=True, eq=False, slots=True)
class Closed:
    """Forces in Coulomb's cone and the mechanism without dilation that fits them best."""

    forces: ConicSolution
    mechanism: ConicSolution

    @property
    def imbalance(self) -> float:
        """Relative difference of the multipliers: power that does not balance."""
        reached = self.forces.load_multiplier
        return abs(self.mechanism.load_multiplier - reached) / max(abs(reached), 1e-8)

    @property
    def balances(self) -> bool:
        """Whether this is a limit state."""
        return self.imbalance <= PROGRAMS_AGREE


@dataclass(frozen=True, eq=False, slots=True)
class Shifted:
    """An iterate of the dilation shift: solution, and the power of the dilation left over the live load's."""

    solution: ConicSolution
    error: float


def dilation_shift(equilibrium: SpaceEquilibrium, work: Work) -> Iterator[Shifted]:
    """Yield the iterates of the dilation shift, for ever, from no slips. Raises ConvergenceError, also where no work is
    left."""
    mu = equilibrium.friction
    shift = np.zeros_like(mu)
    while True:
        solution = solve_associative(equilibrium, shift, work=work)
        dilation = mu * solution.slip - shift
        left = float(np.sum(solution.forces[:, 0] * np.abs(dilation)))
        yield Shifted(solution, left / max(abs(solution.load_multiplier), 1e-8))
        shift = shift + DILATION_RELAXATION * dilation


def settled(iterates: Iterator[Shifted], most: int, work: Work) -> Shifted | None:
    """Return the first settled iterate, else the last of `most` or for which work was left."""
    last = None
    try:
        for number, last in enumerate(iterates, 1):
            if last.error <= SETTLED or number >= most or work.left <= 0:
                break
    except ConvergenceError:
        return last
    return last


def closed(
    equilibrium: SpaceEquilibrium,
    slip: FloatArray,
    work: Work,
    face_weight: float = FACE_WEIGHT,
    tolerance: float = TOLERANCE,
) -> Closed:
    """Return the lowest forces that go with slips (p,) in m/s and the mechanism that goes with them; the highest for a
    negative face weight. Raises ConvergenceError."""
    forces = solve_associative(equilibrium, equilibrium.friction * slip, 1.0 - face_weight, tolerance, work)
    return Closed(forces, solve_given_normals(equilibrium, forces.forces[:, 0], tolerance, work))


def descent(equilibrium: SpaceEquilibrium, slip: FloatArray, turns: int, work: Work) -> Iterator[Closed]:
    """Yield states (some may not balance) with ever lower multipliers, beginning with slips (p,) in m/s, until a state
    falls no more, what does not balance comes no nearer to it, so many turns have balanced, a program fails, or no work
    is left."""
    last, imbalance, balanced, farther, tolerance = np.inf, np.inf, 0, 1.0, ROUGH
    while balanced < turns and work.left > 0:
        try:
            state = closed(equilibrium, slip, work, tolerance=tolerance)
            if tolerance > TOLERANCE and state.imbalance <= PROGRAMS_AGREE + 100 * tolerance:
                tolerance = TOLERANCE
                state = closed(equilibrium, slip, work)
        except ConvergenceError:
            return
        yield state
        reached = state.forces.load_multiplier
        if state.balances:
            balanced += 1
            if last - reached <= LEAST_DESCENT * abs(reached):
                return
        elif state.imbalance >= imbalance and farther == 1.0:
            return
        farther = SLIP_RELAXATION if state.imbalance < imbalance < np.inf else 1.0
        slip = state.mechanism.slip if state.balances else np.maximum(slip + farther * (state.mechanism.slip - slip), 0)
        last, imbalance = reached, state.imbalance
