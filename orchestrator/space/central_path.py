"""States without dilation in space as the end of the path of smoothed contact conditions, without springs.

    N v_N = tau,    mu N gamma + T . v_T = tau,    mu N v_T + gamma T = 0,    B q + lambda f_L + f_D = 0,    f_L . u = 1

For every tau > 0 joints resist as a stiffening fluid, and for a large one the wall has one solution. From there a curve
of solutions leads on; where it reaches tau = 0 is a limit state without dilation. On walls of some hundreds of blocks
tau falls all along it. On larger ones it turns back at first and comes down again further on: without dilation a joint
that is pressed harder moves the mechanism away from it, and a few joints have to change from one state to another. So
tau is an unknown, as the load multiplier is beyond a limit point, and the curve's length is what is prescribed.

Unknowns are measured relative to themselves: N, v_N, gamma by their own value, T by mu N, v_T by gamma. One matrix is
factorised a step: for the way along the curve, the way back to it and what the second order adds to both.
Sources: Riks 1979 (length of the curve prescribed); Kleinert, Simeon, Obermayr 2014 (interior points for Coulomb
friction); own combination.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from time import thread_time

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.errors import ConvergenceError
from orchestrator.space.conic_program import ConicSolution
from orchestrator.space.equilibrium import SpaceEquilibrium
from orchestrator.space.interior_step import BALANCED, InteriorPoint, InteriorStep, Products
from orchestrator.space.springs import Springs
from orchestrator.space.validation import LIMITS
from orchestrator.space.work import Work

STAGE = "smoothed contact"
PRODUCTS_LEFT = 0.5 * LIMITS["flow"]
"""Sum of all products over the live load's power, at the end."""
FIRST_PRODUCT = 100.0
"""Sum of all products at the beginning, over the live load's power in the associative mechanism."""
CENTRING = 60
"""Steps to the curve at the beginning, at most."""
LAST_STEPS = 3
"""Steps to the curve at the end."""
NEAR_THE_CURVE = 3.0
"""Products between tau / NEAR_THE_CURVE and NEAR_THE_CURVE tau are near the curve."""
TANGENT_TO_BOUNDARY = 0.9
"""Part of the way along the tangent to the nearest boundary that is gone at most."""
LARGEST_LOG_STEP = 3.0
"""Change of log tau in a step, at most."""
LONGER = 1.5
"""Growth, after a step, of the part of the way that is gone of what could be."""
SHORTEST = 1e-6
"""Part of the way below which the path is lost."""
CORRECTORS = 2
"""Corrections of a way with the same matrix."""


@dataclass(frozen=True, eq=False, slots=True)
class PathEnd:
    """Where the path was left: load multiplier, forces (p, 3) in N, size (p,) of the slips in m/s at unit live-load
    power, sum of products over the live load's power, factorisations, turning points passed, seconds."""

    load_multiplier: float
    forces: FloatArray
    slip: FloatArray
    left: float
    factorisations: int
    turns: int
    seconds: float


@dataclass(frozen=True, eq=False, slots=True)
class _Curve:
    """A point near the curve and log tau; tangent there, measured relative to the unknowns (none at first)."""

    at: InteriorPoint
    log_tau: float
    tangent: FloatArray | None
    length: float


def follow(
    springs: Springs,
    equilibrium: SpaceEquilibrium,
    associative: ConicSolution,
    work: Work,
    report: Callable[[str], None] = lambda _: None,
    enough: float = PRODUCTS_LEFT,
) -> PathEnd:
    """Follow the path from large tau until the sum of products is at most `enough` of the live load's power, no work is
    left, or the path is lost. Raises ConvergenceError where its beginning is not found."""
    started = thread_time()
    count = len(springs.friction)
    step = InteriorStep(replace(springs, stiffness=np.full(count, np.inf)), np.zeros((count, 3)), 1.0)
    begun = work.done
    curve = _begun(step, springs, equilibrium, associative, work)
    turns, falling, rows = 0, True, 0
    while work.left > 0:
        try:
            following = _followed(step, curve)
        except ConvergenceError:
            break
        work.done, rows = work.done + 1, rows + 1
        if (following.log_tau < curve.log_tau) is not falling:
            turns, falling = turns + 1, not falling
        curve = following
        if rows % 10 == 0:
            report(f"λ {_physical(curve.at, equilibrium):.4f}, products {_left(step, curve):.0e}, {turns} turns")
        if _left(step, curve) <= enough:
            break
    at = _centred(step, curve)
    work.done += LAST_STEPS
    rates = springs.contacts.rates(at.displacements) / equilibrium.live_total
    return PathEnd(
        load_multiplier=_physical(at, equilibrium),
        forces=equilibrium.weight_scale * step.forces(at),
        slip=np.linalg.norm(rates[:, 1:], axis=1),
        left=_left(step, curve),
        factorisations=work.done - begun,
        turns=turns,
        seconds=thread_time() - started,
    )


def _physical(at: InteriorPoint, equilibrium: SpaceEquilibrium) -> float:
    return at.multiplier * equilibrium.weight_scale / equilibrium.live_total


def _left(step: InteriorStep, curve: _Curve) -> float:
    return step.products(curve.at).total() / max(abs(curve.at.multiplier), 1e-3)


def _begun(
    step: InteriorStep, springs: Springs, equilibrium: SpaceEquilibrium, associative: ConicSolution, work: Work
) -> _Curve:
    """Return a point on the curve at a large tau."""
    multiplier = associative.load_multiplier * equilibrium.live_total / equilibrium.weight_scale
    displacements = associative.velocities.ravel() / equilibrium.row_scale * equilibrium.live_total
    tau = FIRST_PRODUCT * max(abs(multiplier), 1e-3) / step.count
    normal = np.maximum(associative.forces[:, 0] / equilibrium.weight_scale, np.sqrt(tau))
    if step.tied.any():
        normal = np.where(step.tied, np.minimum(normal, 0.5 * springs.capacity), normal)
    flat = np.zeros((len(normal), 2))
    excess = np.where(step.tied, tau / step.room(normal), 0.0)
    at = InteriorPoint(multiplier, displacements, normal, flat, tau / normal, excess, tau / (step.mu * normal), flat)
    for _ in range(CENTRING):
        work.done += 1
        way = step.linearised(at)(step.wanted(at, tau))
        at = at.moved(min(1.0, TANGENT_TO_BOUNDARY * step.length(at, way)), way)
        if _near(step, at, tau) and np.abs(step.unbalanced(at)).max() < BALANCED:
            return _Curve(at, float(np.log(tau)), None, 1.0)
    raise ConvergenceError(STAGE, f"no point of the path after {CENTRING} steps")


def _centred(step: InteriorStep, curve: _Curve) -> InteriorPoint:
    """Return the point of the curve itself: where a face of forces goes with one mechanism, its middle."""
    at = curve.at
    for _ in range(LAST_STEPS):
        try:
            way = step.linearised(at)(step.wanted(at, float(np.exp(curve.log_tau))))
        except RuntimeError:
            break
        at = at.moved(min(1.0, TANGENT_TO_BOUNDARY * step.length(at, way)), way)
    return at


def _followed(step: InteriorStep, curve: _Curve) -> _Curve:
    """Return a point further along the curve. Raises ConvergenceError where no step, however short, stays near it."""
    at, tau = curve.at, float(np.exp(curve.log_tau))
    try:
        way_to = step.linearised(at)
    except RuntimeError:
        raise ConvergenceError(STAGE, "the equations of the path are singular") from None
    feasible = way_to(step.wanted(at, 0.0, 0.0))  # back to equations that are linear; nil but for rounding
    along = way_to(step.wanted(at, tau, 0.0)).moved(-1.0, feasible)  # for a unit of log tau
    measured = _measured(step, at, along)
    ahead = -1.0 if curve.tangent is None else float(np.sign(curve.tangent @ np.append(measured, 1.0)))
    tangent = (ahead / float(np.sqrt(1.0 + measured @ measured))) * np.append(measured, 1.0)
    back = way_to(step.wanted(at, tau))
    shift = -float(_measured(step, at, back) @ tangent[:-1]) / float(tangent @ np.append(measured, 1.0))
    back = back.moved(shift, along)  # at a right angle to the tangent
    reach = TANGENT_TO_BOUNDARY * LARGEST_LOG_STEP * step.length(at, _times(LARGEST_LOG_STEP * ahead, along))
    length = curve.length
    while length > SHORTEST:
        change = length * reach * ahead
        log_tau = curve.log_tau + shift + change
        there = _tried(step, at, back.moved(change, along), float(np.exp(log_tau)), way_to, feasible)
        if there is not None:
            return _Curve(there, log_tau, tangent, min(1.0, LONGER * length))
        length *= 0.5
    raise ConvergenceError(STAGE, "the path is lost")


def _tried(
    step: InteriorStep,
    at: InteriorPoint,
    way: InteriorPoint,
    tau: float,
    way_to: Callable[[Products], InteriorPoint],
    feasible: InteriorPoint,
) -> InteriorPoint | None:
    """Return the end of a way, corrected to the second order and the third, if it is near the curve."""
    for _ in range(CORRECTORS + 1):
        if step.length(at, way) < 1.0:
            return None
        there = at.moved(1.0, way)
        if _near(step, there, tau):
            return there
        way = way.moved(1.0, way_to(step.wanted(there, tau))).moved(-1.0, feasible)
    return None


def _near(step: InteriorStep, at: InteriorPoint, tau: float) -> bool:
    """Whether all products are within NEAR_THE_CURVE of tau."""
    products, rubs = step.products(at), step.rubs
    size = np.linalg.norm(products.turn, axis=1)
    every = np.concatenate(
        [products.normal, products.tie[step.tied], (products.cone - size)[rubs], (products.cone + size)[rubs]]
    )
    return bool(every.min() > tau / NEAR_THE_CURVE and every.max() < NEAR_THE_CURVE * tau)


def _measured(step: InteriorStep, at: InteriorPoint, way: InteriorPoint) -> FloatArray:
    """Return a way relative to the unknowns."""
    rubs, limit = step.rubs, (step.mu * at.normal)[:, None]
    shear, slip = (way.shear / limit)[rubs].ravel(), (way.slip / at.slack[:, None])[rubs].ravel()
    return np.concatenate([way.normal / at.normal, way.gap / at.gap, (way.slack / at.slack)[rubs], shear, slip])


def _times(part: float, way: InteriorPoint) -> InteriorPoint:
    return InteriorPoint(*(part * getattr(way, name) for name in InteriorPoint.__slots__))
