"""Other states beside the one that loading meets: the lowest and the highest that descents find, from slips that are
known and from mechanisms that would begin on the way there.

They say what is possible, never what the wall carries. A state that rests on self-stress which loading does not bring
about is no such possibility: forces of the path at its multiplier then do more work in its mechanism than the live load
gives it (`reach`). Such states, and those at no load at all, tell of loose stones.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.errors import ConvergenceError
from orchestrator.limit_analysis.paper.limit_state import LimitState
from orchestrator.limit_analysis.problem import Problem, record_of
from orchestrator.limit_analysis.search.loading_path import LoadPath
from orchestrator.limit_analysis.search.lower_states import ClosedState, TwoPrograms, descent
from orchestrator.limit_analysis.search.scattered_starts import (
    TURNS_AROUND_A_STATE,
    scattered_starts,
    scattered_states,
    while_hopeful,
)

REACHED = 2.0
"""Largest `reach` of a state that loading could lead to: 1.67 where finite elements come to one, 8 to 66 for single
wedged stones."""
RESTS = (0.0, 0.75)
"""Parts of the last rest of a path at which the mechanisms that would begin there are tried. Of 120 pushovers of
docs/studies seven have a lower state by that, among them four that bore less in finite elements than the lowest known
before, and one more with a quarter and a half too."""
TOUCHED = 1e-2
"""Largest `reach` of a state that loading meets."""


def states_around(
    problem: Problem, slips: Sequence[FloatArray], scattered: int, path: LoadPath | None
) -> tuple[list[LimitState], list[LimitState]]:
    """Return what descents from slips (k,) in m/s pass, and from `scattered` starts around the first; and what those
    from the mechanisms that would begin on the way of a path do."""
    programs = TwoPrograms(problem.equilibrium, problem.friction)
    passed = list[ClosedState]()
    for slip in slips:
        passed += list(descent(programs, slip, passed=passed))
    begun = [] if path is None else _begun_on_the_way(programs, path, passed)
    if slips and scattered:
        with ThreadPoolExecutor(max_workers=1) as other:
            starts = scattered_starts(problem.assemblage, slips[0], scattered)
            other_programs = TwoPrograms(problem.equilibrium, problem.friction)
            passed += scattered_states(other, (programs, other_programs), starts)
    around, on_the_way = ([closed_state(problem, one) for one in found if one.balances] for found in (passed, begun))
    return around, on_the_way


def _begun_on_the_way(programs: TwoPrograms, path: LoadPath, known: Sequence[ClosedState]) -> list[ClosedState]:
    """Return what descents pass from mechanisms that would begin at RESTS if normal forces stayed as they are there.

    Under load stones may hold each other by friction that only the load brings about. What falls without it does so
    where it is lost: of 46 stones of rubble a column at the edge overturns by itself under 0.168, and finite elements
    come there, where a stone that leans on it holds it up to 0.226 (`tests/verification/test_lower_states.py`).
    """
    passed = list[ClosedState]()
    for part in RESTS if path.forces else ():
        forces = path.forces[int(np.searchsorted(path.multipliers, part * path.last_rest))]
        try:
            begins = programs.mechanism(forces[:, :2].sum(axis=1))
        except ConvergenceError:
            continue
        turns = descent(programs, begins.rates[:, 2], TURNS_AROUND_A_STATE, [*known, *passed])
        passed += while_hopeful(turns)
    return passed


def reached(problem: Problem, states: Sequence[LimitState], forces: FloatArray | None) -> list[LimitState]:
    """Return the valid states that loading could lead to; forces (k, 3) in N: those of the path, None where there is
    none."""

    def could_be(state: LimitState) -> bool:
        return state.load_multiplier > 0 and (forces is None or reach(problem, state, forces) <= REACHED)

    return [state for state in states if could_be(state) and not problem.complaints(state)]


def reach(problem: Problem, state: LimitState, forces: FloatArray) -> float:
    """Work of forces (k, 3) in N in the mechanism of a state, over the live load's at its multiplier.

    That of joints that open while loaded, or slide before they must: 0 if these forces are those of a limit state with
    this mechanism.
    """
    moves, friction = state.mechanism, problem.friction
    spare = np.maximum(friction.slope * forces[:, :2].sum(axis=1) + friction.cohesion - np.abs(forces[:, 2]), 0.0)
    done = np.sum(np.maximum(forces[:, :2], 0.0) * np.abs(moves.opening)) + np.sum(spare * np.abs(moves.slip))
    u = moves.velocities[problem.equilibrium.free_blocks].ravel()
    return float(done / max(abs(state.load_multiplier * float(problem.equilibrium.live_load @ u)), 1e-300))


def touched(problem: Problem, states: Sequence[LimitState], path: LoadPath, below: float) -> LimitState | None:
    """Return the lowest of the states below a multiplier whose mechanism the path was about to take, or None.

    Its forces at the last rest before that state reach it, but for the load that is missing. That the wall then found
    rest beyond is a matter of how it moved; pushed by displacements it would have stayed.
    """
    met = list[LimitState]()
    for state in states:
        before = int(np.searchsorted(path.multipliers, state.load_multiplier)) - 1
        if state.load_multiplier < below and before > 0:
            missing = 1.0 - float(path.multipliers[before]) / state.load_multiplier
            if reach(problem, state, path.forces[before]) - missing <= TOUCHED:
                met.append(state)
    return min(met, key=lambda state: state.load_multiplier, default=None)


def closing_state(problem: Problem, states: Sequence[LimitState], last: LimitState, near: float) -> LimitState | None:
    """Return the state whose mechanism is nearest to the one about to begin at the last rest of a path, or None.

    last: forces of that rest. Only states whose multiplier is its own to a part `near`.
    """
    found = [each for each in states if abs(each.load_multiplier - last.load_multiplier) <= near * last.load_multiplier]
    return min(found, key=lambda state: reach(problem, state, last.joint_forces), default=None)


def closed_state(problem: Problem, closed: ClosedState) -> LimitState:
    """Return a state of the search; its records are the two programs that closed it."""
    solved = (record_of(closed.forces, 0.0), record_of(closed.mechanism, 0.0))
    return problem.state("descent", problem.no_dilatancy, closed.forces, closed.mechanism, solved)
