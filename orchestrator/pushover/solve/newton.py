"""Newton's method for one increment: semismooth, along the path of the piecewise linear problem (contact_path.py).

Residuals, with the active (closed) set A = {lambda - c g >= 0}:

    R_u = K (u - u_rigid) + M (u - u_n)/dt^2 - f_g - alpha f_h - B_n^T lambda + B_t^T tau(lambda, q_n + B_t (u - u_n))
    g_A = 0,   lambda_I = 0,   and either alpha or the mean displacement is prescribed.

S. Hueeber, B. Wohlmuth, CMAME 194 (2005) 3147-3166; P. Alart, A. Curnier, CMAME 92 (1991) 353-375.
A bonded contact (cohesion.py) has lambda + T in the place of lambda in both, with the tension T that it still carries:
lambda is then the net normal force, negative in tension, and follows T(gap) where the joint is open. In mortar the gap
is what is left of it beyond elastic and permanent closing, and a contact that crushes has the force f_c A (mortar.py).

A contact that just touches (lambda = g = 0) counts as closed: with the strict test the first iterate is a free fall.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.errors import ConvergenceError
from orchestrator.pushover.contact.contact_law import FrictionResponse, friction_response
from orchestrator.pushover.model import ContactModel
from orchestrator.pushover.settings import NewtonSettings
from orchestrator.pushover.solve.contact_path import Kinks, followed
from orchestrator.pushover.solve.iterate import Iterate, Target, control_error, evaluate
from orchestrator.pushover.solve.linear_system import LinearSystem
from orchestrator.pushover.solve.newton_matrix import Coefficients

OF_BODIES = 1e-3
"""error of a body's forces over its weight up to which an iterate is accepted at all: all of a small stone's weight may
be less than what rounding may leave of that of the wall"""


def iterates(model: ContactModel, system: LinearSystem, problem: Target, first: Iterate) -> Iterator[Iterate]:
    """Yield `first` and then Newton's iterates, while paths lead on; knows neither tolerance nor limit."""
    current, leads_on = first, True
    while leads_on:
        yield current
        matrix = newton_coefficients(model, problem, current)
        try:
            solution = system.solve(matrix, problem.time_step, _right_side(model, problem, current))
        except ConvergenceError as error:
            raise ConvergenceError(error.stage, error.where, current.number + 1) from error
        if _at_every_kink(problem, current):
            change = solution
        else:
            change, leads_on = followed(model, system, Kinks.at(model, problem, current), solution)
        n, multiplier = len(current.displacement), current.load_multiplier + float(change[-1]) / model.height
        force = current.normal_force + change[n:-1] * model.contact_stiffness
        following = evaluate(model, problem, current.displacement + change[:n], force, multiplier)
        current = replace(following, number=current.number + 1)
    yield current


def _at_every_kink(problem: Target, current: Iterate) -> bool:
    """Return whether an iterate is the first of a wall without any contact force yet, which takes the whole step.

    All its contacts are where they close, open and slide. From there a path crossed 660 planes one by one in a wall of
    512 stones, and 95 in the next iteration; from the end of the whole step it crosses 114.
    """
    return bool(problem.reference_force) and not current.number


def _friction(model: ContactModel, problem: Target, current: Iterate) -> FrictionResponse:
    """Return the friction that the matrix at an iterate has."""
    if not _at_every_kink(problem, current):
        return current.response
    count = len(current.gap)
    return friction_response(
        np.zeros((count, 2)),
        np.full(count, problem.reference_force),
        model.contacts.friction,
        model.slip_tolerance,
        problem.shear_stiffness,
    )


def newton_coefficients(model: ContactModel, problem: Target, current: Iterate) -> Coefficients:
    """Return what the Newton matrix at an iterate is made of."""
    friction, active = _friction(model, problem, current), current.active & ~current.crushes
    slope = np.where(current.crushes, 0.0, current.pull_slope) / model.contact_stiffness
    given = 0.0 if problem.mortar is None else model.contact_stiffness * problem.mortar.compliance
    return Coefficients(
        slip_stiffness=friction.slip_stiffness,
        pressure_slope=friction.pressure_slope,
        gap_slope=np.where(active, 1.0, slope),
        softness=np.where(active, given, 1.0 + slope * given),
        active=active,
        displacement_control=problem.mean_displacement is not None,
        tie_stiffness=None if current.ties is None else current.ties.slope,
    )


def _right_side(model: ContactModel, problem: Target, current: Iterate) -> FloatArray:
    kappa = model.contact_stiffness
    contact = np.where(current.active, -kappa * current.gap, -(current.normal_force + current.pull))
    if problem.mortar is not None:
        contact = np.where(current.crushes, problem.mortar.strength - current.normal_force, contact)
    control = kappa * control_error(model, problem, current.displacement)
    return np.concatenate([-current.force_residual, contact, [control]])


def solve_increment(
    model: ContactModel,
    system: LinearSystem,
    problem: Target,
    first: Iterate,
    settings: NewtonSettings,
) -> Iterate:
    """Return the converged iterate.

    Rounding may hold the error just above the tolerance: the best iterate is then accepted within `settings.acceptable`
    tolerances (its residual is recorded in the increment). Raises ConvergenceError when none comes that near.
    """
    best, least = first, np.inf
    earlier = iterate = first
    for following in iterates(model, system, problem, first):
        earlier, iterate = iterate, following
        error = _error(iterate, settings, model.height)
        goes_no_further = error >= least and least < settings.acceptable
        if iterate.number and error < least:
            best, least = iterate, error
        if least < 1.0 or iterate.number >= settings.iterations or goes_no_further or not np.isfinite(error):
            break
    if least < settings.acceptable:
        return replace(best, number=iterate.number)
    where = f"out-of-balance force {best.norms[0]:.1e} of the weight after {iterate.number} iterations"
    raise ConvergenceError("Newton", where + _restless_joints(model, earlier, iterate), iterate.number)


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


def _error(iterate: Iterate, settings: NewtonSettings, height: float) -> float:
    """Return the largest norm in units of its tolerance: below 1 the iterate has converged."""
    force, gap, pull, control = iterate.norms
    of_bodies = iterate.of_bodies / OF_BODIES
    return max(
        force / max(settings.residual, iterate.rounding),
        settings.acceptable * of_bodies if of_bodies > 1.0 else 0.0,
        pull / settings.residual,
        max(gap, control) / (settings.gap * height),
    )
