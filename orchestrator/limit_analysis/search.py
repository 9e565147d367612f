"""The search for states of the complementarity problem: where to begin, how far to descend, which states count."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Sequence

from orchestrator.limit_analysis.complementarity import ComplementarySolution
from orchestrator.limit_analysis.elastic_joints import push_elastic_joints
from orchestrator.limit_analysis.linear_program import LimitSolution
from orchestrator.limit_analysis.lower_states import (
    CLOSE_FACE_WEIGHT,
    FACE_WEIGHT,
    TURNS,
    ClosedState,
    TwoPrograms,
    complementary_start,
    descent,
    first_tight,
    lowest,
    starts,
)
from orchestrator.limit_analysis.moving_part import moving_part
from orchestrator.limit_analysis.problem import Problem, record_of
from orchestrator.limit_analysis.sequence import LimitAnalysisSettings
from orchestrator.limit_analysis.smoothed_complementarity import smoothed_start
from orchestrator.limit_analysis.state import LimitState, LinearProgramRecord
from orchestrator.limit_analysis.yield_conditions import YieldConditions
from orchestrator.masonry.wall import FloatArray

logger = logging.getLogger(__name__)

PUSHED_BLOCKS = 500
"""Smaller walls are always pushed with elastic joints as well: 3.5 s of CPU at 418 blocks. Larger ones begin with the
smoothed conditions, which took 2.5 s at 997 blocks where the pushover took 12 s."""
CLOSES, SMOOTHED_TURNS = 1e-2, 3
"""Largest gap of the smoothed conditions from which the two programs are tried if there are other ways to begin, and
their turns: a fiftieth of the time that those take, and from a gap of 6e-4 they end 3e-7 out of balance where the other
ways lead nowhere (1,449 irregular blocks)."""


def has_complementarity_program(friction: YieldConditions) -> bool:
    """Whether joints have nothing but friction and cohesion, which is all that the complementarity program knows."""
    return not (friction.tension.any() or friction.crushes.any())


class Search:
    """The states that a search passed, and the first that counts with the start that led to it.

    The first is where the first start leads that leads to a state, before any lower one. `programs` are what it
    descends with: one thread at a time may use them.
    """

    def __init__(self, problem: Problem, settings: LimitAnalysisSettings) -> None:
        """Nothing has been found yet."""
        self.passed: list[ClosedState] = []
        self.first: tuple[ClosedState, ComplementarySolution] | None = None
        self._problem, self._settings = problem, settings
        self.programs = TwoPrograms(problem.equilibrium, problem.friction)
        self._one_is_enough = len(problem.equilibrium.free_blocks) > settings.search_blocks

    def run(self, optimum: LimitSolution) -> None:
        """Begin wherever it may lead to a state at a cost that the wall's size allows; optimum: that of Eq. (1)."""
        problem, settings = self._problem, self._settings
        equilibrium, friction, assemblage = problem.equilibrium, problem.friction, problem.assemblage
        if not has_complementarity_program(friction):
            return
        blocks, height = len(equilibrium.free_blocks), assemblage.midpoint[:, 1]
        depth = equilibrium.block_length + height.max() - height
        very_large = self._one_is_enough and blocks > settings.sequence_blocks
        if self._one_is_enough and blocks > min(PUSHED_BLOCKS, settings.sequence_blocks):
            part = moving_part(assemblage, equilibrium, friction, optimum.velocities)
            found, slip = smoothed_start(part, depth)
            if found.gap <= CLOSES or very_large:
                self.descend(TwoPrograms(equilibrium, friction, part), found, slip, SMOOTHED_TURNS, CLOSE_FACE_WEIGHT)
        if very_large:
            return
        for start in starts(assemblage, 1, settings.search_starts):
            if self.first is not None and self._one_is_enough:
                break
            self.descend(self.programs, *complementary_start(self.programs, equilibrium, friction, start))
        if blocks <= PUSHED_BLOCKS or self.first is None:
            found = push_elastic_joints(equilibrium, friction, depth)
            self.descend(self.programs, found, found.slip)

    def descend(
        self,
        programs: TwoPrograms,
        found: ComplementarySolution,
        slip: FloatArray,
        turns: int = TURNS,
        face_weight: float = FACE_WEIGHT,
    ) -> None:
        """Take the states of a descent from slips (k,) in m/s; `found` is where these come from."""
        reached = []
        for state in descent(programs, slip, turns, self.passed, face_weight):
            reached.append(state)
            logger.info(
                "search: state at %.4f, %d passed", state.forces.load_multiplier, len(self.passed) + len(reached)
            )
            if self._one_is_enough and valid(self._problem, [state]):
                break
        self.passed += reached
        if self.first is None and (first := first_tight(valid(self._problem, reached))) is not None:
            self.first = first, found


def valid(problem: Problem, states: Iterable[ClosedState]) -> list[ClosedState]:
    """Return the states that balance and pass the check without the solver.

    Power may balance to 1e-8 while an end that carries little opens: it does little work.
    """
    return [state for state in states if state.balances and not problem.complaints(closed_state(problem, state))]


def lowest_valid(problem: Problem, states: Sequence[ClosedState]) -> LimitState | None:
    """Return the lowest of the states that balance and pass the check without the solver, or None."""
    left = list(states)
    while (end := lowest(left)) is not None:
        state = closed_state(problem, end)
        if not problem.complaints(state):
            return state
        left.remove(end)
    return None


def closed_state(problem: Problem, closed: ClosedState, found: ComplementarySolution | None = None) -> LimitState:
    """Return a state of the search; its records are the complementarity program and the two programs that closed it."""
    records = (
        ()
        if found is None
        else (LinearProgramRecord(found.load_multiplier, 0.0, found.iterations, found.seconds, "complementarity"),)
    )
    solved = (record_of(closed.forces, 0.0), record_of(closed.mechanism, 0.0))
    return problem.state("complementarity", problem.no_dilatancy, closed.forces, closed.mechanism, (*records, *solved))
