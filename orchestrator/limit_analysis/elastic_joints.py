"""Non-associative limit states as the end of a pushover: rigid blocks, joints with springs that yield without dilation.

    trial    t = q_before + h k B^T u                           (k: stiffness of springs, u: velocities, h: the step)
    normal   n = max(0, t),    shear   s = t cut to |s| <= mu N + c      (plastic: what opens or slides forgets it)
    balance  B q - lambda f_L = f_D,    f_L . u = 1

Gravity first, then step after step of the live load's displacement h, each longer than the last. While h grows, the
springs give way to ever less of the motion; in the end forces stand still and what moves is a mechanism: forces in
Coulomb's cone that balance, openings where there is no force, slips without dilation where friction is at its limit. A
step is one of the proximal point method on forces, hence there is no bound to run into and no barrier to follow: the
program of `complementarity` is what is left for h without end. Its state is one that loading leads to.

Steps are solved by Newton's method. max(0, t) is smoothed to (t + sqrt(t^2 + 4 m^2))/2, which a state no longer feels
when h has grown (n x opening = m^2/(h k)). Springs are stiffer and m is larger with depth below the top, as are the
forces: equal ones take four times the factorisations at 997 blocks of running bond, and swing for ever with a large m.
That is not a material: k only says which of several states is reached.
Sources: Rockafellar 1976 (proximal point); Chen and Harker 1993 (smoothing); own combination.
"""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter

import numpy as np

from orchestrator.limit_analysis.complementarity import (
    ComplementarySolution,
    ScaledProblem,
    scaled_problem,
)
from orchestrator.limit_analysis.equilibrium import Equilibrium
from orchestrator.limit_analysis.yield_conditions import YieldConditions
from orchestrator.masonry.wall import FloatArray

SMOOTHING = 0.03
"""m in mean block weights, at mean depth."""
FIRST_STEP = 3.0
"""h: mean displacement along the live load, times stiffness of a spring at mean depth over the mean block weight."""
GAP = 1e-6
"""Sum of what is done by joints that open while loaded or slide before they must, over the live load's power."""
BALANCE = 1e-6
"""Force out of balance, mean block weights, that ends Newton's method: 15 % fewer factorisations than with 1e-9."""
NEWTON_STEPS, GRAVITY_STEPS, HALVINGS = 12, 60, 5
FACTORISATIONS, FAILURES = 1500, 20
"""In all, and steps in a row that fail at most."""
LEAST_STIFFNESS = 1e-8
"""Part of its spring's that an open joint has in the matrix: a block that hangs free for a moment is held."""


@dataclass(frozen=True, eq=False, slots=True)
class _Springs:
    """Stiffness (k, 1) of the springs of each joint and smoothing m (k, 1), and the problem that they belong to."""

    problem: ScaledProblem
    stiffness: FloatArray
    smoothing: FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class _Pushed:
    """lambda, displacements u (3m,), forces q (k, 3) at their end, and what forces (3m,) are out of balance.

    slopes (k, 4): of the normal forces at both ends over their trials, of the shear over its trial and over the limit.
    """

    multiplier: float
    displacements: FloatArray
    forces: FloatArray
    slopes: FloatArray
    unbalanced: FloatArray

    @property
    def error(self) -> float:
        """Largest force out of balance, mean block weights."""
        return float(np.abs(self.unbalanced).max())


def push_elastic_joints(equilibrium: Equilibrium, coulomb: YieldConditions, depth: FloatArray) -> ComplementarySolution:
    """Push a wall whose joints lie at depth (k,) > 0 (any unit) until its forces stand still.

    Never raises: returns where it ended, with `converged` False unless the gap is GAP.
    """
    started = perf_counter()
    problem = scaled_problem(equilibrium, coulomb)
    relative = (depth / depth.mean())[:, None]
    springs = _Springs(problem, relative**2, SMOOTHING * relative)
    last, used = _newton(springs, np.zeros((len(depth), 3)), 0.0, np.zeros(problem.B.shape[0]), None, GRAVITY_STEPS)
    stands, velocities, gap = last.error < BALANCE, np.zeros_like(last.displacements), np.inf
    h, failures = FIRST_STEP, 0
    while stands and used < FACTORISATIONS and failures < FAILURES and gap > GAP:
        pushed, steps = _newton(springs, last.forces, last.multiplier, h * velocities, h, NEWTON_STEPS)
        used += steps
        if not pushed.error < BALANCE:
            h, failures = 0.25 * h, failures + 1
            continue
        last, velocities, failures = pushed, pushed.displacements / h, 0
        gap = _gap(problem, last, velocities)
        h *= 3.0 if steps <= 4 else 1.5 if steps <= 6 else 1.0 if steps <= 9 else 0.7
    return ComplementarySolution(
        load_multiplier=last.multiplier * equilibrium.mean_weight / equilibrium.live_total,
        normal=equilibrium.mean_weight * last.forces[:, :2].sum(axis=1),
        slip=_rates(problem, velocities)[:, 2] / equilibrium.live_total,
        gap=gap,
        iterations=used,
        seconds=perf_counter() - started,
        converged=gap <= GAP,
    )


def _newton(
    springs: _Springs, before: FloatArray, multiplier: float, displacements: FloatArray, h: float | None, most: int
) -> tuple[_Pushed, int]:
    """Return the step to live displacement h from forces `before` (k, 3), and the Newton steps taken, `most` at most.

    multiplier and displacements are where to begin. Without h there is no live load.
    """
    problem = springs.problem
    pushed = _displaced(springs, before, multiplier, displacements)
    for taken in range(1, most + 1):
        try:
            factors = problem.stiffness.factorised(_joint_stiffnesses(springs, pushed.slopes))
        except RuntimeError:  # the matrix is singular to rounding
            return pushed, taken
        change, more = factors.solve(-pushed.unbalanced), 0.0
        if h is not None:
            along = factors.solve(problem.live)
            more = float((h - problem.live @ (pushed.displacements + change)) / (problem.live @ along))
            change = change + more * along
        parts = 0.5 ** np.arange(1 if taken == 1 else 1 + HALVINGS)  # the first step brings the live displacement
        pushed = _best(springs, before, pushed, change, more, parts)
        if not BALANCE <= pushed.error < np.inf:
            return pushed, taken
    return pushed, most


def _best(
    springs: _Springs, before: FloatArray, pushed: _Pushed, change: FloatArray, more: float, parts: FloatArray
) -> _Pushed:
    """Return the first of the parts of a Newton step that leaves clearly less out of balance, else the best of them."""
    out_of_balance, tried = np.linalg.norm(pushed.unbalanced), list[_Pushed]()
    for part in parts:
        tried.append(_displaced(springs, before, pushed.multiplier + part * more, pushed.displacements + part * change))
        if np.linalg.norm(tried[-1].unbalanced) < (1.0 - 0.1 * part) * out_of_balance:
            return tried[-1]
    return min(tried, key=lambda end: float(np.linalg.norm(end.unbalanced)))


def _displaced(springs: _Springs, before: FloatArray, multiplier: float, displacements: FloatArray) -> _Pushed:
    """Return the forces after displacements (3m,) from forces `before` (k, 3)."""
    problem = springs.problem
    trial = before - springs.stiffness * _rates(problem, displacements)
    normal, d_normal = _positive(trial[:, :2], springs.smoothing)
    limit, m = problem.friction * normal.sum(axis=1) + problem.cohesion, springs.smoothing[:, 0]
    above, d_above = _positive(trial[:, 2] + limit, m)
    below, d_below = _positive(trial[:, 2] - limit, m)
    forces = np.column_stack([normal, above - below - limit])
    unbalanced = problem.B @ forces.ravel() - multiplier * problem.live - problem.dead
    slopes = np.column_stack([d_normal, d_above - d_below, d_above + d_below - 1.0])
    return _Pushed(multiplier, displacements, forces, slopes, unbalanced)


def _positive(trial: FloatArray, smoothing: FloatArray) -> tuple[FloatArray, FloatArray]:
    """max(0, t), smoothed, and its slope; without cancellation for t < 0."""
    root = np.sqrt(trial**2 + 4.0 * smoothing**2)
    larger = 0.5 * (np.abs(trial) + root)
    return np.where(trial > 0, larger, smoothing**2 / larger), 0.5 * (1.0 + trial / root)


def _joint_stiffnesses(springs: _Springs, slopes: FloatArray) -> FloatArray:
    """Tangent stiffness (k, 5) of every joint from its slopes (k, 4)."""
    start, end, stick = np.maximum(slopes[:, :3], LEAST_STIFFNESS).T
    slide = springs.problem.friction * slopes[:, 3]
    return springs.stiffness * np.column_stack([start, end, slide * start, slide * end, stick])


def _gap(problem: ScaledProblem, pushed: _Pushed, velocities: FloatArray) -> float:
    """What is done by joints that open while loaded or slide before they must, over the live load's power."""
    rates, normal, shear = _rates(problem, velocities), pushed.forces[:, :2], pushed.forces[:, 2]
    spare = np.maximum(problem.friction * normal.sum(axis=1) + problem.cohesion - np.abs(shear), 0.0)
    done = np.sum(normal * np.abs(rates[:, :2])) + np.sum(spare * np.abs(rates[:, 2]))
    return float(done / max(abs(pushed.multiplier), 1e-3))


def _rates(problem: ScaledProblem, velocities: FloatArray) -> FloatArray:
    """Openings at both ends and slip (k, 3) of blocks that move with velocities (3m,)."""
    return -(problem.B_T @ velocities).reshape(-1, 3)
