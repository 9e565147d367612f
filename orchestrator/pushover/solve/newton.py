"""Active-set Newton for one increment (semismooth Newton on the complementarity of gap and normal force).

Residuals, with the active (closed) set A = {lambda - c g >= 0}:

    R_u = K (u - u_rigid) + M (u - u_ref)/dt^2 - f_g - alpha f_h - B_n^T lambda + B_t^T tau(lambda, q_n + B_t (u - u_n))
    g_A = 0,   lambda_I = 0,   and either alpha or the mean displacement is prescribed.

S. Hueeber, B. Wohlmuth, CMAME 194 (2005) 3147-3166; P. Alart, A. Curnier, CMAME 92 (1991) 353-375.
A bonded contact (cohesion.py) has lambda + T in the place of lambda in both, with the tension T that it still carries:
lambda is then the net normal force, negative in tension, and follows T(gap) where the joint is open. In mortar the gap
is what is left of it beyond elastic and permanent closing, and a contact that crushes has the force f_c A (mortar.py).

A contact that just touches (lambda = g = 0) counts as closed: with the strict test the first iterate is a free fall.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.errors import ConvergenceError
from orchestrator.pushover.contact.contact_law import friction_response
from orchestrator.pushover.model import ContactModel
from orchestrator.pushover.settings import NewtonSettings
from orchestrator.pushover.solve.iterate import Iterate, Target, control_error, evaluate
from orchestrator.pushover.solve.linear_system import LinearSystem
from orchestrator.pushover.solve.newton_matrix import Coefficients, coefficients

LINE_SEARCH_SHARE = 0.03
"""stiffness of overlaps in the line search over the contact stiffness"""
FULL_STEP = 0.5
"""a step is taken whole when the work at its end is less than this share of that at its start, or still negative"""
WORK_LEFT = 0.3
"""share of the work at the start of a step that may be left where the line search ends"""
TRIALS = 8
"""of a line search at most"""
REPETITION = 0.95
"""an iterate that returns to earlier contact states with more than this share of their error: Newton goes in circles"""


def iterates(model: ContactModel, system: LinearSystem, problem: Target, first: Iterate) -> Iterator[Iterate]:
    """Yield `first` and then Newton's iterates for ever; knows neither tolerance nor limit."""
    current = first
    while True:
        yield current
        right_side = _right_side(model, problem, current)
        step = system.solve(newton_coefficients(model, problem, current), problem.time_step, right_side)
        following, steps = _advanced(model, problem, current, step), 1
        if _climbs(model, problem, current, step, following):
            eased = newton_coefficients(model, problem, _eased(current))
            step = system.solve(eased, problem.time_step, right_side)
            following, steps = _advanced(model, problem, current, step), 2
        current = replace(following, number=current.number + steps)


def _eased(iterate: Iterate) -> Iterate:
    """Return the iterate with friction that does not follow the pressure: its matrix is never unstable."""
    response = replace(iterate.response, pressure_slope=np.zeros_like(iterate.response.pressure_slope))
    return replace(iterate, response=response)


def _climbs(model: ContactModel, problem: Target, current: Iterate, step: FloatArray, following: Iterate) -> bool:
    """Return whether the out-of-balance forces are worked against, and grow.

    The matrix of friction that follows the pressure may be unstable where the wall is not.
    """
    if current.as_before or problem.bond is not None or not current.response.pressure_slope.any():
        return False
    climbs = _work(model, current, step[: len(current.displacement)]) >= 0.0
    return climbs and _merit(model, following) > _merit(model, current)


def newton_coefficients(model: ContactModel, problem: Target, current: Iterate) -> Coefficients:
    """Return what the Newton matrix at an iterate is made of."""
    response = current.response
    if problem.reference_force and current.number == 0:
        count = len(current.gap)
        response = friction_response(
            np.zeros((count, 2)),
            np.full(count, problem.reference_force),
            model.contacts.friction,
            model.slip_tolerance,
            problem.shear_stiffness,
        )
    slope = np.where(current.crushes, 0.0, current.pull_slope) / model.contact_stiffness
    compliance = None if problem.mortar is None else model.contact_stiffness * problem.mortar.compliance
    active, control = current.active & ~current.crushes, problem.mean_displacement is not None
    stretched = None if current.ties is None else current.ties.slope
    return coefficients(response, active, current.carrying, slope, control, compliance, stretched)


def _right_side(model: ContactModel, problem: Target, current: Iterate) -> FloatArray:
    kappa = model.contact_stiffness
    contact = np.where(current.active, -kappa * current.gap, -(current.normal_force + current.pull))
    if problem.mortar is not None:
        contact = np.where(current.crushes, problem.mortar.strength - current.normal_force, contact)
    control = kappa * control_error(model, problem, current.displacement)
    return np.concatenate([-current.force_residual, contact, [control]])


def _advanced(model: ContactModel, problem: Target, current: Iterate, step: FloatArray) -> Iterate:
    """Return the next iterate, along the step from `current`."""
    n = len(current.displacement)
    change_u, change_lambda = step[:n], step[n:-1] * model.contact_stiffness
    change_alpha = float(step[-1]) / model.height

    def at(share: float) -> Iterate:
        return evaluate(
            model,
            problem,
            current.displacement + share * change_u,
            current.normal_force + share * change_lambda,
            current.load_multiplier + share * change_alpha,
        )

    if current.as_before:
        return at(1.0)
    if problem.bond is not None:
        return _less_out_of_balance(model, current, at)
    return _out_of_work(model, current, at, change_u)


def _out_of_work(model: ContactModel, current: Iterate, at: Callable[[float], Iterate], change: FloatArray) -> Iterate:
    """Return the iterate on the step at which the out-of-balance forces do (almost) no more work along it.

    With given pressures of friction and a given load that is the lowest energy along the step.
    M. A. Crisfield, Non-linear Finite Element Analysis of Solids and Structures 1, Wiley 1991, section 9.2.
    """
    start = _work(model, current, change)
    iterate = at(1.0)
    work = _work(model, iterate, change)
    if start >= 0.0 or work <= -FULL_STEP * start:
        return iterate
    low, high = (0.0, start), (1.0, work)
    for _ in range(TRIALS):
        (behind, less), (ahead, more) = low, high
        share = behind + (ahead - behind) * min(max(less / (less - more), 0.05), 0.95)
        iterate = at(share)
        work = _work(model, iterate, change)
        if abs(work) <= -WORK_LEFT * start:
            break
        # regula falsi; the end that stays counts half, or it would stay for ever (Illinois)
        low, high = ((share, work), (ahead, more / 2)) if work < 0.0 else ((behind, less / 2), (share, work))
    return iterate


def _work(model: ContactModel, iterate: Iterate, change: FloatArray) -> float:
    """Return the work of the out-of-balance forces along a change of displacement, overlaps pressed apart, in J."""
    force = iterate.normal_force
    pressed = iterate.within(force - LINE_SEARCH_SHARE * model.contact_stiffness * iterate.gap) - force
    return float(iterate.force_residual @ change - pressed @ (model.normal_rows @ change))


def _less_out_of_balance(model: ContactModel, current: Iterate, at: Callable[[float], Iterate]) -> Iterate:
    """Return of 1, 1/2 and 1/4 of the step the first iterate that lowers the out-of-balance forces, or the best.

    For joints that soften, whose energy has several lowest points: this one stays nearer to the state it comes from.
    """
    target = 0.9 * _merit(model, current)
    tried = []
    for share in (1.0, 0.5, 0.25):
        iterate = at(share)
        tried.append((_merit(model, iterate), iterate))
        if tried[-1][0] <= target:
            return iterate
    return min(tried, key=lambda pair: pair[0])[1]


def _merit(model: ContactModel, iterate: Iterate) -> float:
    stiffness = LINE_SEARCH_SHARE * model.contact_stiffness
    force = iterate.normal_force + iterate.pull
    contact = force - iterate.within(force - stiffness * iterate.gap)
    return float(np.sqrt(iterate.force_residual @ iterate.force_residual + contact @ contact))


def solve_increment(
    model: ContactModel,
    system: LinearSystem,
    problem: Target,
    first: Iterate,
    settings: NewtonSettings,
) -> Iterate:
    """Return the converged iterate.

    Contacts at the edge of closing or sliding may change their state for ever at the level of the tolerance: the best
    iterate is then accepted within `settings.acceptable` tolerances (its residual is recorded in the increment). Raises
    ConvergenceError when none comes that near.
    """
    best, least = first, np.inf
    seen: dict[bytes, float] = {}
    state = b""
    earlier = iterate = first
    for following in iterates(model, system, problem, first):
        earlier, iterate = iterate, following
        error = _error(iterate, settings)
        if iterate.number and error < least:
            best, least = iterate, error
        before, state = state, _states(iterate)
        circles = state != before and error > REPETITION * seen.get(state, np.inf)
        if least < 1.0 or iterate.number >= settings.iterations or circles or not np.isfinite(error):
            break
        seen[state] = error
    if least < settings.acceptable:
        return replace(best, number=iterate.number)
    where = f"out-of-balance force {best.norms[0]:.1e} of the weight after {iterate.number} iterations"
    raise ConvergenceError("Newton", where + _restless_joints(model, earlier, iterate), iterate.number)


def _states(iterate: Iterate) -> bytes:
    """Return which contacts are closed, slide and crush, and which ties are elastic."""
    contacts = np.packbits([iterate.active, iterate.response.sliding, iterate.crushes]).tobytes()
    return contacts if iterate.ties is None else contacts + (iterate.ties.slope > 0.0).tobytes()


def _restless_joints(model: ContactModel, earlier: Iterate, iterate: Iterate) -> str:
    """Return the joints whose contacts changed their state between two iterates, in words."""
    changed = (earlier.active != iterate.active) | (earlier.response.sliding != iterate.response.sliding)
    changed |= earlier.crushes != iterate.crushes
    contacts = model.contacts
    joints = dict.fromkeys(
        zip(contacts.slave_body[changed].tolist(), contacts.master_body[changed].tolist(), strict=True)
    )
    if not joints:
        return ""
    named = [" | ".join(model.body_names[body] for body in sorted(joint)) for joint in list(joints)[:3]]
    return f", contacts change between {'; '.join([*named, *['...'] * (len(joints) > 3)])}"


def _error(iterate: Iterate, settings: NewtonSettings) -> float:
    """Return the largest norm in units of its tolerance: below 1 the iterate has converged."""
    force, gap, pull, control = iterate.norms
    return max(
        force / max(settings.residual, iterate.rounding), pull / settings.residual, max(gap, control) / settings.gap
    )
