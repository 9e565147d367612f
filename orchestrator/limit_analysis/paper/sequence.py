"""The paper's sequence of linear programs for non-associative friction, Eq. (2), with seed continuation.

Friction lines with slope -alpha mu through the expected normal forces,
c_j = c + (1 + alpha) mu (beta N_{j-1} + (1 - beta) N_{j-2}), run once for every seed cohesion 1e-1, 1e-3, 1e-4 block
weights, each run started from the last. Without seeds the next program is often infeasible (yield_conditions.py). An
infeasible program is retried with expected forces halfway back to the last that had a solution; when that does not help
there is no answer, and `run_sequence` says so. What it settles on is confirmed by one program on Coulomb's own cone,
    max lambda - sum d N,   d = (1 + alpha) mu |slip|,
for which the last mechanism is optimal exactly if it is a fixed point of Eq. (2). Its forces respect Coulomb's law to
1e-12, without seed (the last iterate: 1e-5 to 1e-2 block weights, because forces wander where lambda hardly feels
them); its power balance with the last mechanism is the proof, and lambda moves by less than the seed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import Annotated, TypeVar

import numpy as np
from annotated_types import Ge, Gt, Le, Lt, MinLen

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.checked import Checked
from orchestrator.basis.errors import ConvergenceError
from orchestrator.limit_analysis.paper.equilibrium import Equilibrium
from orchestrator.limit_analysis.paper.linear_program import (
    FINAL_TOLERANCE,
    ITERATE_TOLERANCE,
    LimitProgram,
    LimitSolution,
)
from orchestrator.limit_analysis.paper.yield_conditions import YieldConditions, falling_line, relaxed_normal

HALVINGS = 6
"""Steps back towards the last expected normal forces that had a solution, before giving up."""
SEED_TOLERANCE = 1e-2
"""Times the seed is settled enough before the last seed: the next one moves the multiplier by more. Same six digits on
the published walls in both directions as with 1e-6 throughout: 47 programs for 83 on wall 6, 25 for 78 on wall 3."""

LP_TOLERANCE = 1e-3
"""Programs of a seed are solved to this part of what its multiplier may still move. Interior points gain little by it:
4 to 15 % of the first seed's iterations (walls 1 to 6), the same eight digits; at 1e-2 wall 6 loses the fifth."""


@dataclass(frozen=True, slots=True)
class LimitAnalysisSettings(Checked):
    """The paper's sequence (alpha, beta, seeds, stopping), the search for other states, and what loading looks at."""

    slope_fraction: Annotated[float, Gt(0), Lt(1)] = 0.01
    """alpha of Eq. (2): the friction lines fall by this part of the coefficient of friction"""
    relaxation: Annotated[float, Gt(0), Le(1)] = 0.6
    """beta of Eq. (2): weight of the last normal forces against those before"""
    seed_cohesions: Annotated[tuple[Annotated[float, Gt(0)], ...], MinLen(1)] = (1e-1, 1e-3, 1e-4)
    """cohesion of every joint in each run of the sequence, in mean block weights"""
    tolerance: Annotated[float, Gt(0), Lt(1)] = 1e-6
    """largest relative change of the load multiplier in a sequence that has settled"""
    power_tolerance: Annotated[float, Gt(0), Lt(1)] = 1e-6
    """largest power imbalance, over that of live or dead load, the larger, of what the sequence settled on"""
    minimum_iterations: Annotated[int, Ge(2)] = 4
    """linear programs with the last seed at least"""
    maximum_iterations: Annotated[int, Ge(2)] = 60
    """linear programs a seed at most"""
    search_slips: Annotated[int, Ge(0)] = 5
    """starts around the slips of the state met, in the search for the lowest and the highest state"""
    search_blocks: Annotated[int, Ge(0)] = 300
    """larger walls are not searched, and the paper's sequence begins at the state that loading meets"""
    sequence_blocks: Annotated[int, Ge(0)] = 500
    """larger walls have no value of the paper's sequence: begun at a state it takes longer than that state did and does
    not settle (997 blocks)"""
    path_blocks: Annotated[int, Ge(0)] = 500
    """the state of larger walls in small displacements is one of smoothed conditions, where there is one"""
    large_displacements: bool = True
    """whether walls whose joints do not hold unpressed, nor crush, are pushed in large displacements, too"""
    local_share: Annotated[float, Ge(0), Lt(1)] = 0.05
    """a mechanism that moves less than this part of the dead load and of the live load is a local failure: its stones
    are taken away, and the wall goes on to its own state; 0 stops at the first mechanism, however small"""


@dataclass(frozen=True, eq=False, slots=True)
class SequenceIterate:
    """Iterate j of Eq. (2): solution, seed (mean block weights), the normal forces expected and those of the iterate
    before, both (k,) in N, and how often the expected ones were set back."""

    solution: LimitSolution
    seed: float
    expected_normal: FloatArray
    previous_normal: FloatArray
    halvings: int


Iterate = TypeVar("Iterate")


def taken_until(
    settled: Callable[[Sequence[Iterate]], bool], iterates: Iterator[Iterate], minimum: int, maximum: int
) -> tuple[list[Iterate], bool]:
    """Take at most `maximum` iterates, fewer once `settled` holds for `minimum` or more of them; say whether it did."""
    taken: list[Iterate] = []
    for iterate in islice(iterates, maximum):
        taken.append(iterate)
        if len(taken) >= minimum and settled(taken):
            return taken, True
    return taken, False


def sequence_iterates(
    program: LimitProgram,
    equilibrium: Equilibrium,
    coulomb: YieldConditions,
    start: SequenceIterate,
    seed: float,
    settings: LimitAnalysisSettings,
) -> Iterator[SequenceIterate]:
    """Yield the iterates of Eq. (2) at one seed, for ever, going on from `start`.

    Raises ConvergenceError when one has no solution, nor any of the programs on the way back to the last that had one.
    """
    iterate = start
    while True:
        expected = relaxed_normal(iterate.solution.normal, iterate.previous_normal, settings.relaxation)
        iterate = feasible_iterate(program, equilibrium, coulomb, iterate, expected, seed, settings)
        yield iterate


def feasible_iterate(
    program: LimitProgram,
    equilibrium: Equilibrium,
    coulomb: YieldConditions,
    before: SequenceIterate,
    expected: FloatArray,
    seed: float,
    settings: LimitAnalysisSettings,
) -> SequenceIterate:
    """Solve Eq. (2) for expected normal forces (k,) in N, set back towards those of the iterate `before` if need be."""
    for halvings in range(HALVINGS + 1):
        line = falling_line(coulomb, expected, settings.slope_fraction, seed * equilibrium.unit_force)
        try:
            solution = program.solve(line.cohesion)
        except ConvergenceError:
            if halvings == HALVINGS:
                raise
            expected = 0.5 * (expected + before.expected_normal)
        else:
            break
    return SequenceIterate(solution, seed, expected, before.solution.normal, halvings)


def run_sequence(
    equilibrium: Equilibrium, coulomb: YieldConditions, associative: LimitSolution, settings: LimitAnalysisSettings
) -> tuple[list[SequenceIterate], LimitSolution]:
    """Run the paper's sequence from the associative solution through all seeds.

    Returns the iterates, of which the last one's mechanism is the answer, and the program that confirms it, whose
    multiplier and forces are. Raises ConvergenceError when a program has no solution or the last seed does not settle.
    """
    taken = [SequenceIterate(associative, 0.0, associative.normal, associative.normal, 0)]
    for number, seed in enumerate(settings.seed_cohesions, start=1):
        is_last = number == len(settings.seed_cohesions)
        of_seed = settings if is_last else _before_the_last(settings, seed)
        lp_tolerance = max(ITERATE_TOLERANCE, LP_TOLERANCE * of_seed.tolerance)
        run, settled = run_seed(equilibrium, coulomb, taken[-1], seed, lp_tolerance, of_seed)
        taken += run
    if not settled:
        raise ConvergenceError("sequence of Eq. (2)", unsettled(run))
    return taken[1:], confirmed(equilibrium, coulomb, taken[-1].solution, settings.slope_fraction)


def _before_the_last(settings: LimitAnalysisSettings, seed: float) -> LimitAnalysisSettings:
    """Return the settings for a seed that only leads to the next one."""
    tolerance = max(settings.tolerance, SEED_TOLERANCE * seed)
    return replace(settings, tolerance=tolerance, minimum_iterations=2)


def run_seed(
    equilibrium: Equilibrium,
    coulomb: YieldConditions,
    start: SequenceIterate,
    seed: float,
    lp_tolerance: float,
    settings: LimitAnalysisSettings,
) -> tuple[list[SequenceIterate], bool]:
    """Iterate Eq. (2) with one seed, going on from `start`; return the iterates and whether they settled."""
    falling = replace(coulomb, slope=-settings.slope_fraction * coulomb.slope)
    program = LimitProgram(equilibrium, falling, lp_tolerance)
    try:
        return taken_until(
            lambda taken: sequence_has_settled(taken, settings.tolerance),
            sequence_iterates(program, equilibrium, coulomb, start, seed, settings),
            settings.minimum_iterations,
            settings.maximum_iterations,
        )
    except ConvergenceError as error:
        where = f"with a seed cohesion of {seed:g} block weights: {error.where}, also after {HALVINGS} steps back"
        raise ConvergenceError("sequence of Eq. (2)", where) from error


def sequence_has_settled(taken: Sequence[SequenceIterate], tolerance: float) -> bool:
    """The multiplier stands still, and not because it was set back."""
    last, before = taken[-1], taken[-2]
    change = abs(last.solution.load_multiplier - before.solution.load_multiplier)
    return change <= tolerance * abs(last.solution.load_multiplier) and last.halvings == before.halvings == 0


def unsettled(run: Sequence[SequenceIterate]) -> str:
    """Say in words how a run that did not settle ended."""
    late = [iterate.solution.load_multiplier for iterate in run[len(run) // 2 :]]
    return (
        f"not settled after {len(run)} linear programs with the last seed: "
        f"the multiplier moves between {min(late):.6f} and {max(late):.6f}"
    )


def confirmed(
    equilibrium: Equilibrium, coulomb: YieldConditions, last: LimitSolution, slope_fraction: float
) -> LimitSolution:
    """Solve for the forces in Coulomb's cone that go with the last mechanism: d = (1 + alpha) mu |slip|."""
    shift = (1.0 + slope_fraction) * coulomb.slope * np.abs(last.rates[:, 2])
    return LimitProgram(equilibrium, coulomb, FINAL_TOLERANCE).solve(coulomb.cohesion, shift)
