"""Non-associative limit states without a sequence: the mixed complementarity problem, by an interior-point method.

    B q - lambda f_L = f_D,      f_L . u = 1,      -B^T u = (e_start, e_end, p - m)
    0 <= n_start _|_ e_start >= 0,          0 <= n_end _|_ e_end >= 0
    0 <= mu N + c + s _|_ p >= 0,           0 <= mu N + c - s _|_ m >= 0

e are the openings, p and m the two directions of slip: no dilation anywhere. Only the missing mu (p + m) in the
openings tells these conditions from the optimality conditions of Eq. (1), so the method is the one that linear programs
are solved with, on an unsymmetric matrix: every product is driven to a common target that falls to zero. A joint's
forces and rates are eliminated joint by joint, which leaves 3 unknowns a block: the pattern of a stiffness matrix.
The problem is not monotone, hence neither is the result unique nor is convergence certain: a run that stalls says so,
and `lower_states` closes any run with linear programs. Cost: 10-80 factorisations, 0.03 s at 146 blocks, 0.8 s at 997.
Very large walls end with a gap, as parts of the live load's power: running bond, 2,979 blocks, 0.018, and 10,050
blocks, 0.5, which two programs close to 2e-6 and 2.5e-2. Walls above 500 blocks begin with `smoothed_complementarity`.
Sources: Ferris and Tin-Loi 2001 (complementarity); Mehrotra 1992 (predictor, corrector); own combination.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.limit_analysis.search.scaled_problem import ScaledProblem
from orchestrator.limit_analysis.search.wall_stiffness import Factors, joint_products

MAXIMUM_ITERATIONS = 300
"""iterations of the interior-point method at most"""
STALL = 10
"""Iterations without a change of the gap (STANDSTILL) after which a run gives up. A running bond wall of 2,950 blocks
stands still from iteration 64 on."""
STANDSTILL = 1e-4
"""Part of the gap that is no change of it."""
STEP = 0.98
"""Part of the way to the nearest bound."""
LARGEST_RATIO = 1e11
"""Largest and smallest ratio rate : force of a joint, scaled, that the matrix sees."""


@dataclass(frozen=True, eq=False, slots=True)
class ComplementarySolution:
    """Where the method ended: load multiplier, normal forces (k,) in N, slips (k,) in m/s at unit live-load power,
    gap (relative to the live load's power), iterations, seconds, and whether gap and errors are small."""

    load_multiplier: float
    normal: FloatArray
    slip: FloatArray
    gap: float
    iterations: int
    seconds: float
    converged: bool


Errors = tuple[FloatArray, FloatArray, float]
"""What is missing in equilibrium (3m,), in the joints' rates (k, 3) and in the live load's power."""


@dataclass(frozen=True, eq=False, slots=True)
class CentralPoint:
    """lambda, u (3m,), q (k, 3), y (k, 4) the left sides of the complementarity conditions and z (k, 4) the right."""

    multiplier: float
    velocities: FloatArray
    forces: FloatArray
    strength: FloatArray
    rates: FloatArray

    def moved(self, along: CentralPoint, step: float) -> CentralPoint:
        """Go `step` times `along`; rounding must not make y or z vanish."""
        return CentralPoint(
            self.multiplier + step * along.multiplier,
            self.velocities + step * along.velocities,
            self.forces + step * along.forces,
            np.maximum(self.strength + step * along.strength, 1e-16),
            np.maximum(self.rates + step * along.rates, 1e-18),
        )


def stalled(gaps: Sequence[float]) -> bool:
    """Whether the gap has not moved for STALL iterations: steps have become too short to lead anywhere."""
    recent = gaps[-STALL:]
    return len(recent) == STALL and max(recent) <= (1.0 + STANDSTILL) * min(recent)


def first_iterate(problem: ScaledProblem, start_normal: FloatArray | float) -> CentralPoint:
    """Equal compression at both ends of every joint, no shear, no motion of blocks, every product 1."""
    joints = len(problem.friction)
    forces = np.zeros((joints, 3))
    forces[:, :2] = np.broadcast_to(start_normal, joints)[:, None]
    strength = strength_of(problem.friction, forces)
    strength[:, 2:] += problem.cohesion[:, None]
    return CentralPoint(0.0, np.zeros(problem.B.shape[0]), forces, strength, 1.0 / strength)


def strength_of(friction: FloatArray, forces: FloatArray) -> FloatArray:
    """Left sides (k, 4) without cohesion: n_start, n_end, mu N + s, mu N - s."""
    limit, shear = friction * forces[:, :2].sum(axis=1), forces[:, 2]
    return np.column_stack([forces[:, :2], limit + shear, limit - shear])


def _opening_and_slip(rates: FloatArray) -> FloatArray:
    """Rates (k, 3) that z (k, 4) stands for."""
    return np.column_stack([rates[:, :2], rates[:, 2] - rates[:, 3]])


def errors_of(problem: ScaledProblem, iterate: CentralPoint) -> Errors:
    """What is missing in equilibrium (3m,), in the joints' rates (k, 3) and in the live load's power."""
    unbalanced = problem.dead + iterate.multiplier * problem.live - problem.B @ iterate.forces.ravel()
    incompatible = -(problem.B_T @ iterate.velocities).reshape(-1, 3) - _opening_and_slip(iterate.rates)
    return unbalanced, incompatible, 1.0 - float(problem.live @ iterate.velocities)


def gap_of(iterate: CentralPoint) -> float:
    """Sum of products over the live load's power."""
    return float(np.sum(iterate.strength * iterate.rates) / max(abs(iterate.multiplier), 1e-3))


def next_iterate(problem: ScaledProblem, iterate: CentralPoint, errors: Errors) -> CentralPoint:
    """One predictor and one corrector; where these get nowhere, one step towards the middle."""
    products = iterate.strength * iterate.rates
    mean = float(products.mean())
    newton = linearised(problem, iterate, errors)
    predicted = newton.direction(-products)
    reached = float(_product_mean(iterate, predicted, _step(iterate, predicted, 1.0)))
    centring = float(np.clip((reached / mean) ** 3, 1e-8, 0.9)) if reached > 0 else 0.5
    direction = newton.direction(centring * mean - products - predicted.strength * predicted.rates)
    step = _step(iterate, direction, STEP)
    if step < 0.1:
        direction = newton.direction(0.5 * mean - products)
        step = _step(iterate, direction, STEP)
    return iterate.moved(direction, step)


def linearised(problem: ScaledProblem, iterate: CentralPoint, errors: Errors, drag: float = 0.0) -> Linearised:
    """Factorise the conditions at an iterate with y, z > 0; drag: force that holds a block back, per velocity.

    Raises RuntimeError when the matrix is singular to rounding.
    """
    stiffness = np.clip(iterate.rates / iterate.strength, 1.0 / LARGEST_RATIO, LARGEST_RATIO)
    flexible = _joint_flexibilities(problem, stiffness)
    return Linearised(problem, iterate, errors, stiffness, flexible, problem.stiffness.factorised(flexible, drag))


def _joint_flexibilities(problem: ScaledProblem, stiffness: FloatArray) -> FloatArray:
    """Inverse (k, 5) of the rates that forces at each joint cause: F diag(z/y) G, G = dy/dq, no dilation.

    Per joint F diag(d) G = [[d1, 0, 0], [0, d2, 0], [c, c, d3 + d4]] with c = mu (d3 - d4).
    """
    d1, d2, d3, d4 = stiffness.T
    ratio = problem.friction * (d3 - d4) / (d3 + d4)
    return np.column_stack([1 / d1, 1 / d2, -ratio / d1, -ratio / d2, 1 / (d3 + d4)])


@dataclass(frozen=True, eq=False, slots=True)
class Linearised:
    """The linearised problem at one iterate, factorised."""

    problem: ScaledProblem
    iterate: CentralPoint
    errors: Errors
    stiffness: FloatArray
    flexible: FloatArray
    factors: Factors

    def direction(self, products: FloatArray) -> CentralPoint:
        """Return the change that removes all errors and adds `products` (k, 4) to y z, to first order."""
        problem, (unbalanced, incompatible, power) = self.problem, self.errors
        free_rates = products / self.iterate.strength
        free_forces = joint_products(self.flexible, _opening_and_slip(free_rates) - incompatible)
        loads = np.stack([unbalanced - problem.B @ free_forces.ravel(), problem.live])
        without, with_load = self.factors.solve(loads)
        multiplier = float((power - problem.live @ without) / (problem.live @ with_load))
        velocities = without + multiplier * with_load
        forces = free_forces + joint_products(self.flexible, (problem.B_T @ velocities).reshape(-1, 3))
        strength = strength_of(problem.friction, forces)
        return CentralPoint(multiplier, velocities, forces, strength, free_rates - self.stiffness * strength)


def _step(iterate: CentralPoint, direction: CentralPoint, part: float) -> float:
    """Largest step up to 1 that keeps y and z positive; `part` of it when shorter than 1."""
    values = np.concatenate([iterate.strength, iterate.rates])
    changes = np.concatenate([direction.strength, direction.rates])
    falls = changes < 0
    largest = float(np.min(-values[falls] / changes[falls], initial=np.inf))
    return 1.0 if largest >= 1.0 else part * largest


def _product_mean(iterate: CentralPoint, direction: CentralPoint, step: float) -> float:
    strength = iterate.strength + step * direction.strength
    return float(np.mean(strength * (iterate.rates + step * direction.rates)))
