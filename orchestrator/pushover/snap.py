"""From a state that cannot go on to the next state of rest, by way of overdamped motion.

Where a contact begins to slide and sheds more load than the rest takes up, no static state is near, however small the
increment. The wall then moves against a resistance r: contacts that slide resist with the viscosity r eta x slip, and
mass with M (u - u_n) r / dt^2, both measured from the last solution. Each solution is a step of overdamped motion, the
longer the lower r. (With dt of a small increment kept, mass alone once held a wall that was to move 5 mm back to steps
of 1 mm, whatever the viscosity.)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from orchestrator.errors import ConvergenceError
from orchestrator.masonry.wall import FloatArray
from orchestrator.pushover.increment_size import EASY, FOLLOWED
from orchestrator.pushover.iterate import Problem
from orchestrator.pushover.model import ContactModel
from orchestrator.pushover.prediction import carried_on
from orchestrator.pushover.settings import SteppingSettings
from orchestrator.pushover.state import Attempt, Increment

VISCOUS_FORCE = 0.01
"""a contact that slides by the whole increment resists with this share of the weight when a snap begins"""
NEAR_REST = 5e-5
"""a state of rest is looked for when the viscous force of a contact has fallen to this share of the weight"""
STEPS = 50
"""solutions tried until the wall rests"""
FASTER = 5.0
"""largest ratio of the resistances of two steps"""
RECOVERY = 1.7
"""after a failure that ratio begins at 1 and grows by this factor from step to step"""

ProblemFrom = Callable[..., Problem]
"""the problem of an increment from a state, and with a viscosity (N/m) other than 0"""
Solve = Callable[[Increment, Problem, FloatArray], Increment]
"""the solution of a problem from a state, expected at a displacement (n,)"""


def rest_after_snap(
    model: ContactModel,
    stepping: SteppingSettings,
    start: Increment,
    problem: ProblemFrom,
    solve: Solve,
    failure: ConvergenceError,
) -> Increment:
    """Return the static state in which the wall comes to rest, as the increment after `start`.

    As soon as the motion slows down and a state without viscosity is found, that is the answer. Raises ConvergenceError
    when there is none after STEPS solutions, or no motion is found at all.
    """
    state, spent = start, failure.iterations
    whole = problem(start)
    viscosity = _viscosity(model, start, whole)
    resistance = before = 1.0
    faster, slower = FASTER, np.inf
    change = np.zeros(start.displacement.size)
    for _ in range(STEPS):
        here = state.displacement.ravel()
        time_step = min(whole.time_step / resistance**0.5, stepping.proximal_time)
        resisted = replace(problem(state, resistance * viscosity), time_step=time_step)
        try:
            moved = solve(state, resisted, carried_on(model, here, change, min(before / resistance, 2.0)))
        except ConvergenceError as error:
            spent, resistance, faster = spent + error.iterations, 3 * resistance, 1.0
            if resistance > (30 if state is start else 1e4):
                break
            continue
        spent += moved.iterations
        change = moved.displacement.ravel() - here
        force = float(np.abs(change).max()) * resistance * viscosity
        state, before, slows = moved, resistance, force <= slower
        if moved.iterations <= EASY:
            resistance, faster = resistance / faster, min(RECOVERY * faster, FASTER)
        slower = force
        if not slows or force > NEAR_REST * model.weight:
            continue
        try:
            state = solve(state, problem(state), state.displacement.ravel())
        except ConvergenceError as error:
            spent += error.iterations
            continue
        attempt = Attempt(str(failure), state.mean_displacement - start.mean_displacement, FOLLOWED, spent)
        peak = max(start.largest_base_shear, state.base_shear)  # not what moved in between
        return replace(state, number=start.number + 1, largest_base_shear=peak, attempts=(attempt,))
    raise ConvergenceError("Newton", f"no state of rest after a snap ({failure})", spent)


def _viscosity(model: ContactModel, start: Increment, whole: Problem) -> float:
    """Return the viscosity (N/m) with which a snap begins."""
    largest = 3 * model.contact_stiffness
    if whole.mean_displacement is None:
        return largest
    return min(largest, VISCOUS_FORCE * model.weight / (whole.mean_displacement - start.mean_displacement))
