"""The dilation shift: non-associative friction by linear programs that all have a solution.

    max  lambda - sum_k d_k N_k    s.t.   B q - lambda f_L = f_D,   Coulomb's law
    d <- (1 - omega) d + omega mu |slip|,   d = 0 at first

Near the fixed point (an error of NEAR) omega follows Aitken's rule, which takes a seventh of the programs away and
settles more walls (random walls of docs/studies up to 200 blocks); from the start it leads to other fixed points.

At the fixed point the mechanism is the same for every damping, but the multiplier is NOT determined: the optimal face
holds all joint forces that go with the mechanism, and lambda differs on it (wall 6: 0.3010-0.3015, wall 3:
0.3603-0.4026), which is why the interior point's lambda drifts on wall 3. `lower_states.closing` finds the lowest end,
which is the answer, and a mechanism that goes with it without the error at which the shift stops.

A block that hangs between its neighbours by friction alone (keystone_wall_13x9) never settles: at N = weight/(2 mu) it
may slide down alone without dilation and without live load, at any lambda, so its slip grows in every iteration.
Sources: Acary, Cadoux, Lemaréchal, Malick 2011 for Coulomb contact; formulation.md, section 1; Irons and Tuck 1969
(Aitken's rule for vectors).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from orchestrator.limit_analysis.equilibrium import Equilibrium
from orchestrator.limit_analysis.linear_program import ITERATE_TOLERANCE, LimitProgram, LimitSolution
from orchestrator.limit_analysis.sequence import LimitAnalysisSettings, taken_until
from orchestrator.limit_analysis.yield_conditions import YieldConditions
from orchestrator.masonry.wall import FloatArray

NEAR = 1e-3
"""Error below which omega follows Aitken's rule."""
LARGEST = 0.9
"""omega at most: with 1 a wall cycles."""
LAST_TOLERANCE = 1e-10
"""Of the last program: 1e-12 costs 90 to 120 iterations on wall 6, this 30, for the same six digits."""


@dataclass(frozen=True, eq=False, slots=True)
class ShiftIterate:
    """Iterate of the dilation shift: solution, the shift d (k,) in m/s it had, the omega that led to it, and the power
    of the dilation left, sum N |mu |slip| - d|, relative to the live load's power."""

    solution: LimitSolution
    shift: FloatArray
    relaxation: float
    error: float


@dataclass(frozen=True, eq=False, slots=True)
class ShiftRun:
    """A finished dilation shift: its iterates, the last program solved tightly (its slips count), and whether the
    iteration settled."""

    iterates: list[ShiftIterate]
    final: LimitSolution
    settled: bool


def shift_iterates(
    program: LimitProgram, coulomb: YieldConditions, settings: LimitAnalysisSettings, slip: FloatArray | None = None
) -> Iterator[ShiftIterate]:
    """Yield the iterates of the dilation shift, for ever, starting from slips (k,) in m/s or none (d = 0)."""
    shift = np.zeros_like(coulomb.slope) if slip is None else coulomb.slope * np.abs(slip)
    least, largest = settings.shift_relaxation, max(LARGEST, settings.shift_relaxation)
    relaxation, dilation_before = least, np.zeros_like(shift)
    while True:
        solution = program.solve(coulomb.cohesion, shift)
        dilation = coulomb.slope * np.abs(solution.rates[:, 2]) - shift
        left = np.sum(solution.normal * np.abs(dilation))
        error = float(left / max(abs(solution.load_multiplier), np.finfo(float).tiny))
        yield ShiftIterate(solution, shift, relaxation, error)
        aitken = aitken_relaxation(relaxation, dilation_before, dilation) if error < NEAR else least
        relaxation, dilation_before = min(max(aitken, least), largest), dilation
        shift = shift + relaxation * dilation


def aitken_relaxation(relaxation: float, before: FloatArray, residual: FloatArray) -> float:
    """Return the next relaxation of a fixed-point iteration from its last one and the residuals (k,) before and after.

    The secant through both, projected on their difference: exact for one unknown and a linear map.
    """
    change = residual - before
    return -relaxation * float(before @ change) / (float(change @ change) or np.inf)


def run_dilation_shift(
    equilibrium: Equilibrium,
    coulomb: YieldConditions,
    settings: LimitAnalysisSettings,
    slip: FloatArray | None = None,
) -> ShiftRun:
    """Run the dilation shift, then solve its last program tightly; begins with `slip` (k,) in m/s.

    Raises ConvergenceError when a linear program fails.
    """
    taken, settled = taken_until(
        lambda taken: taken[-1].error <= settings.shift_tolerance,
        shift_iterates(LimitProgram(equilibrium, coulomb, ITERATE_TOLERANCE), coulomb, settings, slip),
        1,
        settings.maximum_shift_iterations,
    )
    final = LimitProgram(equilibrium, coulomb, LAST_TOLERANCE).solve(coulomb.cohesion, taken[-1].shift)
    return ShiftRun(taken, final, settled)
