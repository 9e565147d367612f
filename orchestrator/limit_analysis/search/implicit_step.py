"""One step of a wall on elastic joints: the next position under a load, or after a displacement along the live load.

    B q(u) - lambda f_L - f_D + drag (u - u_0) = 0         motion against a drag: backward Euler, lambda given
    B q(u) - lambda f_L - f_D = 0,   f_L . (u - u_0) = h   displacement control, lambda unknown

Where blocks have moved the moments of f_L and f_D change as the blocks turn (moved_loads.py), in the matrix too.

Newton's method on the forces of a position takes 3 to 6 factorisations while few joints open, close, stick or slide,
and swings between two sets of them for ever when many do. Then the same step is solved with forces and gaps as unknowns
of their own that stay positive (an interior-point method: products of force and gap fall together to zero), 15 to 25
factorisations whatever changes. Source: Mehrotra 1992 (predictor, corrector).

Tried, and not used: paths from kink to kink, as of finite elements, without smoothing and in the place of both methods
(benchmark 1: 661 factorisations for 2,413, but 46 kinks a step of a millisecond or more each: 3 times as long), or of
the second one (2.5 times); leaving the second after four steps in a row shorter than 0.1 (of benchmark 2 two thirds of
the time, of 78 pushovers all of it, and some other answers). Figures of throw-away scripts.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.limit_analysis.search.elastic_contact import ElasticWall, Position, positive, tried
from orchestrator.limit_analysis.search.wall_stiffness import Factors, point_products

FORCE_LEFT = 1e-10
"""Force out of balance that ends a step, mean block weights."""
NEWTON_STEPS = 10
"""Factorisations after which Newton's method is left."""
LEAST_PART = 0.1
"""Part of a Newton step below which the method is left."""
INTERIOR_STEPS = 30
"""Factorisations of the interior-point method at most."""
CENTRE = 1.0
"""Force that it begins with in open joints, mean block weights."""
CENTRING = 4
"""Power of the part of the products that a predictor leaves, which says how far a step aims at the centre. Mehrotra's 3
takes a thirtieth more factorisations."""
PRODUCT = 1e-8
"""Largest product of force and gap (times stiffness) at its end: the square of JOINT_SMOOTHING."""
INTERIOR_PRODUCT = 1e-3
"""Product of force and gap (times stiffness) that it begins with, over the displacement expected."""
SHORTEST = 1e-4
"""Part of an interior-point step below which it gets nowhere."""


@dataclass(frozen=True, eq=False, slots=True)
class Task:
    """What to solve: load multiplier (scaled; where to begin in displacement control), drag, displacement h or None."""

    multiplier: float
    drag: float = 0.0
    advance: float | None = None


@dataclass(frozen=True, eq=False, slots=True)
class Step:
    """The position reached and the multiplier there, factorisations spent, whether it balances, and how hard it was.

    effort: factorisations of Newton's method, 10 or more where it needed the other one.
    """

    position: Position
    multiplier: float
    factorisations: int
    found: bool
    effort: int


def implicit_step(wall: ElasticWall, before: Position, task: Task, expected: FloatArray) -> Step:
    """Solve one step from the position `before`; expected (3m,): the change of displacements to begin with."""
    first = newton_step(wall, before, task, expected)
    if first.found:
        return first
    second = interior_step(wall, before, task, float(np.abs(expected).max()))
    spent = first.factorisations + second.factorisations
    return Step(second.position, second.multiplier, spent, second.found, NEWTON_STEPS + second.factorisations // 10)


def _factorised(wall: ElasticWall, tangent: FloatArray, task: Task, multiplier: float) -> Factors:
    """Return the factors of the matrix with the tangent (c, 3) of points. Raises RuntimeError if it is singular."""
    return wall.problem.stiffness.factorised(tangent, task.drag + wall.loads.restoring(multiplier))


def _change(
    wall: ElasticWall, before: Position, factors: Factors, task: Task, unbalanced: FloatArray, moved: FloatArray
) -> tuple[FloatArray, float]:
    """Return the change of displacements (3m,) and multiplier that removes unbalanced (3m,), moved (3m,) so far."""
    if task.advance is None:
        return factors.solve(-unbalanced), 0.0
    live = wall.problem.live
    change, along = factors.solve(np.stack([-unbalanced, wall.loads.at(before.displacements + moved)[1]]))
    more = float((task.advance - live @ (moved + change)) / (live @ along))
    return change + more * along, more


def missing(
    wall: ElasticWall, before: Position, task: Task, forces: FloatArray, moved: FloatArray, multiplier: float
) -> FloatArray:
    """Return what is missing from equilibrium (3m,) with forces (c, 2) after displacements `moved` (3m,)."""
    dead, live = wall.loads.at(before.displacements + moved)
    lacks: FloatArray = wall.problem.B @ forces.ravel() - multiplier * live - dead + task.drag * moved
    return lacks


def going_on(wall: ElasticWall, before: Position, task: Task, expected: FloatArray) -> tuple[FloatArray, float]:
    """Return the change of displacements (3m,) and the multiplier of a step in which no point opens, closes, sticks or
    slides.

    expected (3m,): about which it is looked for. Displacements that go on along a straight line press hinges of blocks
    that turn into each other, by many times what is elastic; forces that go on do not.
    """
    forces = before.goes_on(wall.rates(before.displacements + expected))
    lacks = missing(wall, before, task, forces, expected, task.multiplier)
    try:
        factors = _factorised(wall, before.tangent, task, task.multiplier)
    except RuntimeError:  # the matrix is singular to rounding
        return expected, task.multiplier
    change, more = _change(wall, before, factors, task, lacks, expected)
    return expected + change, task.multiplier + more


def newton_step(wall: ElasticWall, before: Position, task: Task, expected: FloatArray) -> Step:
    """Solve one step by Newton's method, or leave it."""
    moved, multiplier = expected, task.multiplier
    trial = tried(wall, before, before.displacements + moved)
    unbalanced = missing(wall, before, task, trial.forces, moved, multiplier)
    for spent in range(NEWTON_STEPS + 1):
        if np.abs(unbalanced).max() < FORCE_LEFT and (task.advance is None or spent):
            return Step(trial, multiplier, spent, True, spent)
        if spent == NEWTON_STEPS:
            break
        try:
            factors = _factorised(wall, trial.tangent, task, multiplier)
        except RuntimeError:  # the matrix is singular to rounding
            break
        change, more = _change(wall, before, factors, task, unbalanced, moved)
        size, part = np.linalg.norm(unbalanced), 1.0
        while part > LEAST_PART:
            there = moved + part * change
            trial = tried(wall, before, before.displacements + there)
            unbalanced = missing(wall, before, task, trial.forces, there, multiplier + part * more)
            if np.linalg.norm(unbalanced) < (1.0 - 0.1 * part) * size:
                break
            part *= 0.5
        else:
            break
        moved, multiplier = there, multiplier + part * more
    return Step(before, task.multiplier, spent, False, spent)


@dataclass(frozen=True, eq=False, slots=True)
class _Inside:
    """An iterate of the interior-point method.

    moved (3m,), multiplier, forces (c, 2); strength (c, 3) > 0: n + T, mu n + c + s, mu n + c - s; apart (c, 3) > 0:
    what each is complementary to (gap, slip forth, slip back), times stiffness: a force.
    """

    moved: FloatArray
    multiplier: float
    forces: FloatArray
    strength: FloatArray
    apart: FloatArray

    def advanced(self, along: _Inside, part: float) -> _Inside:
        """Go `part` of the way `along`."""
        return _Inside(*(getattr(self, one.name) + part * getattr(along, one.name) for one in fields(self)))

    def part_to_bound(self, along: _Inside, short: float) -> float:
        """Return the part of the way, at most 1, that keeps everything positive; `short` of it where it is shorter."""
        fastest = max(float((-along.strength / self.strength).max()), float((-along.apart / self.apart).max()))
        return 1.0 if fastest <= 1.0 else short / fastest


def _first_inside(wall: ElasticWall, before: Position, task: Task, expected: float) -> _Inside:
    pressed = before.forces[:, 0] + wall.tension
    gap = np.maximum(wall.stiffness[:, 0] * before.rates[:, 0] + before.forces[:, 0], 0.0)
    normal, apart = (positive(sign * (pressed - gap), CENTRE)[0] for sign in (1.0, -1.0))
    product = max(CENTRE**2, INTERIOR_PRODUCT * expected)
    apart = np.maximum(apart, product / normal)
    limit = np.maximum(wall.strength(normal - wall.tension), CENTRE**2 * 1e-6)
    shear = 0.98 * np.clip(before.forces[:, 1], -limit, limit)
    strength = np.column_stack([normal, limit + shear, limit - shear])
    apart = np.column_stack([apart, product / strength[:, 1:]])
    forces = np.column_stack([normal - wall.tension, shear])
    return _Inside(np.zeros_like(before.displacements), task.multiplier, forces, strength, apart)


def interior_step(wall: ElasticWall, before: Position, task: Task, expected: float) -> Step:
    """Solve one step by the interior-point method; expected: largest change of displacements."""
    k = wall.stiffness
    at = _first_inside(wall, before, task, expected)
    for spent in range(INTERIOR_STEPS + 1):
        rates = wall.rates(before.displacements + at.moved)
        unbalanced = missing(wall, before, task, at.forces, at.moved, at.multiplier)
        gap, forth, back = (at.apart / k[:, [0, 1, 1]]).T
        slip = rates[:, 1] - before.rates[:, 1] + (at.forces[:, 1] - before.forces[:, 1]) / k[:, 1]
        incompatible = np.column_stack([rates[:, 0] + at.forces[:, 0] / k[:, 0] - gap, slip - forth + back])
        products = at.strength * at.apart
        wrong = np.abs(k * incompatible).max() / max(1.0, np.abs(k * rates).max())
        if products.max() < PRODUCT and np.abs(unbalanced).max() < FORCE_LEFT and wrong < FORCE_LEFT:
            moved = before.displacements + at.moved
            return Step(Position(moved, at.forces, rates, _flexible(wall, at)), at.multiplier, spent, True, spent)
        if spent == INTERIOR_STEPS:
            break
        flexible = _flexible(wall, at)
        try:
            factors = _factorised(wall, flexible, task, at.multiplier)
        except RuntimeError:  # the matrix is singular to rounding
            break
        system = _System(wall, before, task, at, unbalanced, incompatible, flexible, factors)
        mean = float(products.mean())
        along = system.direction(-products)
        reached = at.advanced(along, at.part_to_bound(along, 1.0))
        centring = float(np.clip((float((reached.strength * reached.apart).mean()) / mean) ** CENTRING, 1e-6, 0.9))
        target = max(centring * mean, 0.1 * PRODUCT)
        along = system.direction(target - products - along.strength * along.apart)
        part = at.part_to_bound(along, 0.98)
        if part < 0.1:
            along = system.direction(0.5 * mean - products)
            part = at.part_to_bound(along, 0.98)
        if part < SHORTEST:
            break
        at = at.advanced(along, part)
    return Step(before, task.multiplier, spent + 1, False, spent)


def _flexible(wall: ElasticWall, at: _Inside) -> FloatArray:
    """Inverse (c, 3) of the rates that forces cause at each point: its own and those that keep the products."""
    k = wall.stiffness
    gap, forth, back = (at.apart / at.strength / k[:, [0, 1, 1]]).T
    pressed = 1.0 / (1.0 / k[:, 0] + gap)
    slip = 1.0 / (1.0 / k[:, 1] + forth + back)
    slide = wall.problem.friction * (forth - back) * slip
    return np.column_stack([pressed, -slide * pressed, slip])


@dataclass(frozen=True, eq=False, slots=True)
class _System:
    """The conditions of a step, linearised at one iterate and factorised."""

    wall: ElasticWall
    before: Position
    task: Task
    at: _Inside
    unbalanced: FloatArray
    incompatible: FloatArray
    flexible: FloatArray
    factors: Factors

    def direction(self, products: FloatArray) -> _Inside:
        """Return the change that removes all errors and adds `products` (c, 3), to first order."""
        wall, at, problem = self.wall, self.at, self.wall.problem
        gap, forth, back = (products / at.strength / wall.stiffness[:, [0, 1, 1]]).T
        free_forces = point_products(self.flexible, np.column_stack([gap, forth - back]) - self.incompatible)
        unbalanced = self.unbalanced + problem.B @ free_forces.ravel()
        moved, more = _change(wall, self.before, self.factors, self.task, unbalanced, at.moved)
        forces = free_forces + point_products(self.flexible, (problem.B_T @ moved).reshape(-1, 2))
        limit = problem.friction * forces[:, 0]
        strength = np.column_stack([forces[:, 0], limit + forces[:, 1], limit - forces[:, 1]])
        return _Inside(moved, more, forces, strength, (products - at.apart * strength) / at.strength)
