"""The state of a wall too large to be loaded to its end in small displacements: of smoothed conditions.

It is valid, as any state of friction without dilation is, and may lie above the one that loading meets or below it (ten
walls side by side: 0.535 and 0.498 where one wall alone meets 0.533 and 0.532). What loading meets is found in large
displacements (rigid_pushover.py), where the wall is pushed.
"""

from __future__ import annotations

from dataclasses import replace

from orchestrator.limit_analysis.paper.limit_state import LimitState, LinearProgramRecord
from orchestrator.limit_analysis.paper.linear_program import LimitSolution
from orchestrator.limit_analysis.problem import Problem
from orchestrator.limit_analysis.search.loading_path import LoadPath
from orchestrator.limit_analysis.search.lower_states import CLOSE_FACE_WEIGHT, TwoPrograms, descent
from orchestrator.limit_analysis.search.moving_part import moving_part
from orchestrator.limit_analysis.search.other_states import closed_state
from orchestrator.limit_analysis.search.smoothed_complementarity import smoothed_start

TURNS_OF_PROGRAMS = 3
"""Turns of the two programs: from a gap of 6e-4 they end 3e-7 out of balance (1,449 irregular blocks)."""


def large_path(problem: Problem, optimum: LimitSolution) -> LoadPath | None:
    """Return the state of smoothed conditions of a wall that is not loaded; None where there is no state."""
    state = None if problem.friction.tension.any() else smoothed_state(problem, optimum)
    if state is None:
        return None
    return LoadPath.unloaded(state, state.records[0].iterations)


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
