"""The state of a wall too large to be loaded to its end: of smoothed conditions, and how far loading comes towards it.

A path takes one to several thousand factorisations to its end, whatever the size. What it would come to is then not
known; the state that is closed here is valid, as any state of friction without dilation is, and may lie above the one
that loading meets (running bond, 997 blocks: 0.4542 beside a path that rests up to 0.4429 and not at 0.4437).
"""

from __future__ import annotations

from dataclasses import replace

from orchestrator.limit_analysis.paper.limit_state import LimitState, LinearProgramRecord
from orchestrator.limit_analysis.paper.linear_program import LimitSolution
from orchestrator.limit_analysis.problem import Problem
from orchestrator.limit_analysis.search.direct_loading import as_far_as
from orchestrator.limit_analysis.search.loading_path import LoadPath
from orchestrator.limit_analysis.search.lower_states import CLOSE_FACE_WEIGHT, TwoPrograms, descent
from orchestrator.limit_analysis.search.moving_part import moving_part
from orchestrator.limit_analysis.search.other_states import closed_state
from orchestrator.limit_analysis.search.smoothed_complementarity import smoothed_start

BELOW = 0.01
"""Part of the multiplier by which loading is asked to come near the state: two paths that far apart are one answer."""
TURNS_OF_PROGRAMS = 3
"""Turns of the two programs: from a gap of 6e-4 they end 3e-7 out of balance (1,449 irregular blocks)."""


def large_path(problem: Problem, optimum: LimitSolution) -> LoadPath | None:
    """Return the state of smoothed conditions with what loading met on the way to it; None where there is no state."""
    state = None if problem.friction.tension.any() else smoothed_state(problem, optimum)
    return None if state is None else as_far_as(problem, (1.0 - BELOW) * state.load_multiplier, state)


def smoothed_state(problem: Problem, optimum: LimitSolution) -> LimitState | None:
    """Return the first valid state that two programs close from the end of the smoothed conditions, or None.

    optimum: that of Eq. (1); blocks that rest in it, far from those that move, are supports. Joints have no tension.
    """
    equilibrium, friction = problem.equilibrium, problem.friction
    height = problem.assemblage.joints.centroid[:, 1]
    part = moving_part(problem.assemblage, equilibrium, friction, optimum.velocities)
    found, slip = smoothed_start(part, equilibrium.block_length + height.max() - height)
    record = LinearProgramRecord(found.load_multiplier, 0.0, found.iterations, found.seconds, "smoothed")
    for closed in descent(
        TwoPrograms(equilibrium, friction, part), slip, TURNS_OF_PROGRAMS, face_weight=CLOSE_FACE_WEIGHT
    ):
        if closed.balances and closed.forces.load_multiplier > 0:
            state = closed_state(problem, closed)
            if not problem.complaints(state):
                return replace(state, flow_rule="smoothed", records=(record, *state.records))
    return None
