"""Where no static state is near: motion against mass and viscous contacts, until the wall rests."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.basis.errors import ConvergenceError
from orchestrator.pushover.increments import Attempt, Increment
from orchestrator.pushover.model import ContactModel
from orchestrator.pushover.path.increment_solver import OF_BEFORE, Aim, IncrementSolver
from orchestrator.pushover.path.moving import body_motion, body_size
from orchestrator.pushover.path.prediction import carried_on

FAST = 2e-3
"""motion of a body in one step of a motion, over its size, from which what moves may be driven"""
LONGEST = 100
"""steps of a motion that has gone nowhere after which it is kept as it is"""
FASTEST = 0.05
"""largest motion of a body in an increment, over its size; and in a motion that may yet come to rest: under a held load
it goes further than a slip does, and what is driven in its place snaps back to a lower load"""
TOO_FAR = 2.0
"""a step of motion in which a body goes farther than FASTEST times this is taken again, as much shorter: a stone creeps
off its neighbour in steps of seconds, in which it would fall by many walls"""
VISCOUS_FORCE = 0.01
"""a contact that slides by the length of a step of motion resists with this share of the weight (where none did, three
of 13 walls of larger rubble came to states that bear 1 to 4 % less, farther from those of rigid blocks)"""
INERTIA = 0.1
"""a body that moves by the length of a step of motion resists with this share of its weight"""
FASTER = 5.0
"""largest ratio of the lengths of two steps of motion"""
SHORTER_STEP = 3.0
"""a step of motion that fails is made shorter by this factor"""
LEAST_GIVEN = 300.0
"""slip tolerances below which steps of a motion do not become shorter for the friction of before (with 30 a wall cut by
straight lines comes to no rest under its weight, from 100 to 1,000 nothing known changes, without end motions halt, and
with all steps alike columns side by side bore 4 % more)"""
NEAR_REST = 10.0
"""rest is looked for when the out-of-balance forces have fallen to this many times what counts as static"""
TRIES = 20
"""times that a step of motion is made shorter"""


def motion(solver: IncrementSolver, state: Increment, aim: Aim) -> list[Increment]:
    """Return the states of a motion from a static state: until it rests, or a body has gone FASTEST of its size."""
    length = aim.size if aim.phase == "displacement" else float(body_motion(solver.model, state.change.ravel()).max())
    moved = replace(state, step=(max(length, solver.model.slip_tolerance), 0.0), moving=True)
    rows: list[Increment] = []
    while moved.moving and farthest(solver.model, state, (moved.displacement - state.displacement).ravel()) < FASTEST:
        moved = step_of_motion(solver, moved, aim, goes_on=bool(rows))
        rows.append(moved)
        if len(rows) == LONGEST:
            break
    return rows


def farthest(model: ContactModel, state: Increment, change: FloatArray) -> float:
    """Return the largest motion of a body that has not fallen in a change (n,), over its size."""
    return float(np.max(body_motion(model, change) * ~state.fallen / body_size(model)))


def step_of_motion(solver: IncrementSolver, state: Increment, aim: Aim, goes_on: bool = True) -> Increment:
    """Return the state after one step of motion against mass and viscous contacts, or where the wall rests.

    It rests where a static increment says so, and where bodies are in balance, but for what Newton's method leaves: of
    a wall that does not move, friction may leave none to be found.

    goes_on: the last change is a step of the same motion, from which this one is expected to go on.
    """
    length, attempts = state.step[0], list[Attempt]()
    here = state.displacement.ravel()
    predicted = carried_on(solver.model, here, state.change.ravel(), 1.0) if goes_on else here
    for _ in range(TRIES):
        reached = aim
        if aim.phase == "displacement":
            reached = replace(aim, value=min(aim.value, state.mean_displacement + length))
        try:
            moved = _moved(solver, state, reached, predicted, length)
        except ConvergenceError as error:
            attempts.append(Attempt(str(error), length, "a shorter step", error.iterations))
            length, predicted = length / SHORTER_STEP, here
            continue
        attempts.extend(replace(attempt, tried=length) for attempt in moved.attempts)
        motions = body_motion(solver.model, moved.change.ravel())
        far = float(np.max(motions / body_size(solver.model)))
        if far <= TOO_FAR * FASTEST:
            break
        attempts.append(Attempt("a body goes too far", length, "a shorter step", moved.iterations))
        length, predicted = length * FASTEST / far, here
    else:
        spent = sum(attempt.iterations for attempt in attempts)
        raise ConvergenceError("Newton", f"no motion is found: {attempts[-1].cause}", spent)
    slows = np.linalg.norm(moved.change) <= np.linalg.norm(state.change)
    if slows and reached == aim and moved.out_of_balance <= NEAR_REST * solver.stepping.out_of_balance:
        try:
            rest = solver.static(moved, replace(aim, size=0.0))
            attempts.extend(rest.attempts)
            if not rest.moving:
                iterations = moved.iterations + rest.iterations
                return replace(rest, number=moved.number, attempts=tuple(attempts), iterations=iterations)
            attempts.append(Attempt("it does not rest", length, "moved on", rest.iterations))
        except ConvergenceError as error:
            attempts.append(Attempt(str(error), length, "moved on", error.iterations))
    if reached == aim and moved.out_of_balance <= solver.newton.residual:
        attempts.append(Attempt("bodies are in balance", length, "at rest without a static increment", 0))
        return replace(moved, moving=False, attempts=tuple(attempts))
    if any(attempt.action == OF_BEFORE for attempt in moved.attempts):
        length = max(length / SHORTER_STEP, min(length, LEAST_GIVEN * solver.model.slip_tolerance))
    elif far < FASTEST / FASTER and length >= state.step[0]:
        length *= FASTER
    length *= min(1.0, FASTEST / far) if far else 1.0
    gone = read_only(state.gone + motions)
    return replace(moved, moving=True, gone=gone, attempts=tuple(attempts), step=(length, 0.0))


def _moved(solver: IncrementSolver, state: Increment, aim: Aim, predicted: FloatArray, length: float) -> Increment:
    """Return the state after a step of motion of `length` (m)."""
    viscosity = VISCOUS_FORCE * solver.model_of(state).weight / length
    return solver.solved(state, aim, predicted, _time_step(solver, state, length), viscosity)


def _time_step(solver: IncrementSolver, state: Increment, length: float) -> float:
    """Return the time step of a step of motion of `length` (m), s."""
    return float(np.sqrt(length * float(solver.model.body_mass.sum()) / (INERTIA * solver.model_of(state).weight)))
