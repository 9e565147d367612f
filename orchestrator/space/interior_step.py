"""One step of the push by an interior-point method: much longer steps than Newton's method on the springs can take.

Unknown besides lambda and u, at every point: N, T; gap g and plastic slip s (3 components in all), slack gamma:

    g = v_N + (N - N_old) / k,    s = v_T + (T - T_old) / k,    v = B^T u           (what springs do not give way to)
    N g = tau,    mu N gamma + T . s = tau,    mu N s + gamma T = 0                 (tau -> 0; gamma -> |s|)
    B q + lambda f_L + f_D = 0,    f_L . u = h

For tau -> 0 these are Signorini's and Coulomb's conditions without dilation: the friction disc is that of the point's
own N, hence the conditions are those of no minimum and the path of tau may turn back. The step then ends where it does,
with forces that balance and are admissible, and tau as an error of its flow. A tie has a second gap, at its strength.
Sources: Mehrotra 1992 (predictor, corrector); Gondzio 1996 (further correctors); Kleinert, Simeon, Obermayr 2014
(interior points for Coulomb friction in granular matter).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.space.springs import SpringForces, Springs, positive

ITERATIONS = 70
"""Of a step, at most."""
CORRECTORS = 2
"""Corrections of a way with the same matrix."""
TO_BOUNDARY = 0.95
"""Part of the way to the nearest boundary that is gone."""
STALLED = 0.1
"""Part of the way below which an iteration has stalled."""
STALLS = 4
"""Iterations in a row that may stall: the path of tau turns back."""
PRODUCT_SPREAD = 10.0
"""Products between tau / PRODUCT_SPREAD and PRODUCT_SPREAD tau are left alone by the correctors."""
BALANCED = 1e-9
"""Largest force out of balance, mean block weights, of a step that has reached its goal."""
INSIDE = 0.9
"""Part of friction's limit that shear has at most at the start."""
RUBBING = 1e-6
"""Less friction is none: such points have no shear."""


@dataclass(frozen=True, eq=False, slots=True)
class InteriorPoint:
    """An iterate, all of it positive or inside its cone: N (p,) and shear T (p, 2) in mean block weights; gap, slack
    (p,), slip (p, 2); excess (p,), the lengthening of ties at their strength; lambda; displacements u (6m,)."""

    multiplier: float
    displacements: FloatArray
    normal: FloatArray
    shear: FloatArray
    gap: FloatArray
    excess: FloatArray
    slack: FloatArray
    slip: FloatArray

    def moved(self, part: float, way: InteriorPoint) -> InteriorPoint:
        """Return the iterate a part of a way further."""
        return InteriorPoint(*(getattr(self, name) + part * getattr(way, name) for name in InteriorPoint.__slots__))


@dataclass(frozen=True, eq=False, slots=True)
class Products:
    """What tends to tau at every point: N gap and room x excess (p,); of the cones, first (p,) and other two (p, 2)."""

    normal: FloatArray
    tie: FloatArray
    cone: FloatArray
    turn: FloatArray

    def total(self) -> float:
        """Sum of all, the power of what is not complementary."""
        return float(self.normal.sum() + self.tie.sum() + self.cone.sum())


class InteriorStep:
    """The equations of one step."""

    def __init__(self, springs: Springs, before: FloatArray, h: float) -> None:
        self.springs, self.before, self.h = springs, before, h
        self.rubs = springs.friction >= RUBBING
        self.tied = np.isfinite(springs.capacity)
        self.count = len(before) + int(self.rubs.sum()) + int(self.tied.sum())
        self.mu = np.where(self.rubs, springs.friction, 1.0)

    def start(self, multiplier: float, displacements: FloatArray, tau: float) -> InteriorPoint:
        """Return a point near the path of tau: normal forces on it, shear inside its limit."""
        springs, k = self.springs, self.springs.stiffness
        trial = self.before - k[:, None] * springs.contacts.rates(displacements)
        normal, _ = positive(trial[:, 0], np.sqrt(tau * k))
        normal = np.where(self.tied, np.minimum(normal, 0.5 * np.where(self.tied, springs.capacity, 1.0)), normal)
        limit = self.mu * normal
        size = np.maximum(np.linalg.norm(trial[:, 1:], axis=1), 1e-300)
        shear = np.where(self.rubs[:, None], trial[:, 1:] * np.minimum(1.0, INSIDE * limit / size)[:, None], 0.0)
        inside = limit**2 - np.einsum("pi,pi->p", shear, shear)
        excess = np.where(self.tied, tau / self.room(normal), 0.0)
        return InteriorPoint(
            multiplier, displacements, normal, shear, tau / normal, excess, tau * limit / inside,
            -(tau / inside)[:, None] * shear,
        )  # fmt: skip

    def room(self, normal: FloatArray) -> FloatArray:
        """Return how far ties (p,) are from their strength, mean block weights; 1 for other points."""
        return np.where(self.tied, np.where(self.tied, self.springs.capacity, 1.0) - normal, 1.0)

    def products(self, at: InteriorPoint) -> Products:
        """Return what tends to tau."""
        limit = self.mu * at.normal
        cone = limit * at.slack + np.einsum("pi,pi->p", at.shear, at.slip)
        turn = limit[:, None] * at.slip + at.slack[:, None] * at.shear
        tie = np.where(self.tied, self.room(at.normal) * at.excess, 0.0)
        return Products(
            at.normal * at.gap, tie, np.where(self.rubs, cone, 0.0), np.where(self.rubs[:, None], turn, 0.0)
        )

    def wanted(self, at: InteriorPoint, tau: float, share: float = 1.0) -> Products:
        """Return the changes that bring all products to tau (share 0: what tau itself wants)."""
        products = self.products(at)
        return Products(
            tau - share * products.normal,
            np.where(self.tied, tau - share * products.tie, 0.0),
            np.where(self.rubs, tau - share * products.cone, 0.0),
            -share * products.turn,
        )

    def forces(self, at: InteriorPoint) -> FloatArray:
        """Return forces (p, 3)."""
        return np.column_stack([at.normal, at.shear])

    def unbalanced(self, at: InteriorPoint) -> FloatArray:
        """Return what forces (6m,) are out of balance."""
        springs = self.springs
        return springs.contacts.sums(self.forces(at)) + at.multiplier * springs.live + springs.dead

    def linearised(self, at: InteriorPoint) -> Callable[[Products], InteriorPoint]:
        """Return the way to go for changes of the products that are wanted. Raises RuntimeError where it is
        singular.

        With the rates dv of the way: dN = b (wanted - dv_N), then the slack and the shear from dN and dv_T.
        """
        springs, k, mu = self.springs, self.springs.stiffness, self.mu
        limit, room = mu * at.normal, self.room(at.normal)
        rates = springs.contacts.rates(at.displacements)
        compliance = 1.0 / k
        off_normal = rates[:, 0] + (at.normal - self.before[:, 0]) * compliance - at.gap + at.excess
        off_shear = rates[:, 1:] + (at.shear - self.before[:, 1:]) * compliance[:, None] - at.slip
        b = 1.0 / (compliance + at.gap / at.normal + at.excess / room)
        c = at.slack + limit * compliance
        e = at.slip + at.shear * compliance[:, None]
        e_slip = np.einsum("pi,pi->p", e, at.slip)
        w = limit - np.einsum("pi,pi->p", e, at.shear) / c
        slack_of_normal = mu * (e_slip / c - at.slack) / w
        slack_of_rate = (limit[:, None] * e / c[:, None] - at.shear) / w[:, None]
        shear_of_normal = -(mu[:, None] * at.slip + slack_of_normal[:, None] * at.shear) / c[:, None]
        shear_of_rate = -at.shear[:, :, None] * slack_of_rate[:, None, :] / c[:, None, None]
        shear_of_rate -= (limit / c)[:, None, None] * np.eye(2)
        shear_of_normal[~self.rubs], shear_of_rate[~self.rubs] = 0.0, 0.0
        tangent = np.zeros((len(k), 3, 3))
        tangent[:, 0, 0] = b
        tangent[:, 1:, 0] = b[:, None] * shear_of_normal
        tangent[:, 1:, 1:] = -shear_of_rate
        solve = springs.contacts.factorised(np.ones_like(k), tangent)
        along = solve(springs.live)
        unbalanced, missing = self.unbalanced(at), self.h - float(springs.live @ at.displacements)

        def way(wanted: Products) -> InteriorPoint:
            normal = b * (wanted.normal / at.normal - wanted.tie / room - off_normal)
            cone = wanted.cone - np.einsum("pi,pi->p", at.shear, off_shear)
            turn = wanted.turn - limit[:, None] * off_shear
            slack = (cone - np.einsum("pi,pi->p", e, turn) / c) / w + slack_of_normal * normal
            shear = (turn - mu[:, None] * at.slip * normal[:, None] - slack[:, None] * at.shear) / c[:, None]
            shear[~self.rubs] = 0.0
            change = solve(unbalanced + springs.contacts.sums(np.column_stack([normal, shear])))
            more = float((missing - springs.live @ change) / (springs.live @ along))
            change = change + more * along
            dv = springs.contacts.rates(change)
            d_normal = normal - b * dv[:, 0]
            d_slack = slack - slack_of_normal * b * dv[:, 0] + np.einsum("pi,pi->p", slack_of_rate, dv[:, 1:])
            d_shear = shear - shear_of_normal * (b * dv[:, 0])[:, None]
            d_shear += np.einsum("pij,pj->pi", shear_of_rate, dv[:, 1:])
            d_excess = np.where(self.tied, (wanted.tie + at.excess * d_normal) / room, 0.0)
            d_gap = dv[:, 0] + d_normal * compliance + off_normal + d_excess
            d_slip = dv[:, 1:] + d_shear * compliance[:, None] + off_shear
            d_slack[~self.rubs], d_slip[~self.rubs] = 0.0, 0.0
            return InteriorPoint(more, change, d_normal, d_shear, d_gap, d_excess, d_slack, d_slip)

        return way

    def length(self, at: InteriorPoint, way: InteriorPoint) -> float:
        """Return the part of a way to the nearest boundary, 1 at most."""
        parts = [_to_zero(at.normal, way.normal), _to_zero(at.gap, way.gap)]
        if self.tied.any():
            room = self.room(at.normal)[self.tied]
            parts += [_to_zero(room, -way.normal[self.tied]), _to_zero(at.excess[self.tied], way.excess[self.tied])]
        r = self.rubs
        parts.append(_to_cone((self.mu * at.normal)[r], at.shear[r], (self.mu * way.normal)[r], way.shear[r]))
        parts.append(_to_cone(at.slack[r], at.slip[r], way.slack[r], way.slip[r]))
        return min(1.0, *parts)

    def second_order(self, way: InteriorPoint) -> Products:
        """Return the products of a way with itself."""
        limit = self.mu * way.normal
        cone = limit * way.slack + np.einsum("pi,pi->p", way.shear, way.slip)
        turn = limit[:, None] * way.slip + way.slack[:, None] * way.shear
        tie = np.where(self.tied, -way.normal * way.excess, 0.0)
        return Products(
            way.normal * way.gap, tie, np.where(self.rubs, cone, 0.0), np.where(self.rubs[:, None], turn, 0.0)
        )


def interior_step(
    springs: Springs, before: FloatArray, multiplier: float, displacements: FloatArray, h: float, goal: float
) -> tuple[SpringForces, float, int]:
    """Return the step to live displacement h from forces `before` (p, 3), what is left of the products over the live
    load's power, and the factorisations taken. Goal: how little of them is enough.

    multiplier and displacements are where to begin. Where the way is lost what is left is infinite.
    """
    step = InteriorStep(springs, before, h)
    at, stalls, taken = step.start(multiplier, displacements, h), 0, 0
    while taken < ITERATIONS and stalls < STALLS:
        taken += 1
        try:
            at, part = _advanced(step, at)
        except RuntimeError:  # singular to rounding
            break
        stalls = stalls + 1 if part < STALLED else 0
        if _left(step, at) <= goal and np.abs(step.unbalanced(at)).max() < BALANCED:
            break
    pushed = SpringForces(at.multiplier, at.displacements, step.forces(at), np.empty((0, 3, 3)), step.unbalanced(at))
    return pushed, _left(step, at), taken


def _left(step: InteriorStep, at: InteriorPoint) -> float:
    left = step.products(at).total() / (step.h * max(abs(at.multiplier), 1e-3))
    return left if np.isfinite(left) else np.inf


def _advanced(step: InteriorStep, at: InteriorPoint) -> tuple[InteriorPoint, float]:
    """Return the next iterate and the part of the way that could be gone."""
    way_to, products = step.linearised(at), step.products(at)
    mean = products.total() / step.count
    nothing = step.wanted(at, 0.0)
    predictor = way_to(nothing)
    part = step.length(at, predictor)
    after = step.products(at.moved(part, predictor)).total() / step.count
    centring = max(float(np.clip(after / mean, 0.0, 1.0)) ** 3, 0.3 * (1.0 - part) ** 3)
    wanted = step.wanted(at, centring * mean)
    if part > 0.1:  # the second order of a way that is hardly gone says nothing
        wanted = _less(wanted, step.second_order(predictor), part**2)
    way = way_to(wanted)
    part = step.length(at, way)
    for _ in range(CORRECTORS):
        if part > 0.9:
            break
        corrected = _corrected(step, at.moved(min(1.0, 1.5 * part + 0.1), way), wanted, centring * mean)
        other = way_to(corrected)
        longer = step.length(at, other)
        if longer <= part:
            break
        part, way, wanted = longer, other, corrected
    part = min(1.0, TO_BOUNDARY * part)
    return at.moved(part, way), part


def _less(one: Products, other: Products, part: float) -> Products:
    return Products(*(getattr(one, name) - part * getattr(other, name) for name in Products.__slots__))


def _corrected(step: InteriorStep, there: InteriorPoint, wanted: Products, tau: float) -> Products:
    """Return what is wanted, and besides that products that would be far from tau at a point come nearer to it."""
    products = step.products(there)
    size = np.linalg.norm(products.turn, axis=1)
    low, high = (
        _pull(products.cone - size, tau),
        _pull(products.cone + size, tau),
    )  # the eigenvalues of the cones' products
    along = products.turn / np.maximum(size, 1e-300)[:, None]
    return Products(
        wanted.normal + _pull(products.normal, tau),
        np.where(step.tied, wanted.tie + _pull(products.tie, tau), 0.0),
        np.where(step.rubs, wanted.cone + 0.5 * (low + high), 0.0),
        wanted.turn + np.where(step.rubs, 0.5 * (high - low), 0.0)[:, None] * along,
    )


def _pull(value: FloatArray, tau: float) -> FloatArray:
    return np.maximum(np.clip(value, tau / PRODUCT_SPREAD, PRODUCT_SPREAD * tau) - value, -PRODUCT_SPREAD * tau)


def _to_zero(value: FloatArray, change: FloatArray) -> float:
    """Return the part of a change that brings the first of positive values (p,) to zero."""
    falls = change < 0
    return float((-value[falls] / change[falls]).min(initial=np.inf))


def _to_cone(first: FloatArray, other: FloatArray, d_first: FloatArray, d_other: FloatArray) -> float:
    """Return the part of a change that brings the first of the points (first, other), |other| < first, out of its
    cone."""
    a = d_first**2 - np.einsum("pi,pi->p", d_other, d_other)
    b = first * d_first - np.einsum("pi,pi->p", other, d_other)
    c = np.maximum(first**2 - np.einsum("pi,pi->p", other, other), 1e-300)
    root = np.sqrt(np.maximum(b**2 - a * c, 0.0)) - b
    part = np.where((b**2 >= a * c) & (root > 0), c / np.where(root > 0, root, 1.0), np.inf)
    return min(float(part.min(initial=np.inf)), _to_zero(first, d_first))
