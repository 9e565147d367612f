"""Non-associative limit states of very large walls: the complementarity conditions smoothed, and blocks that drag.

    y + sigma z = sqrt((y - sigma z)^2 + 4 sigma t)       in place of   y z = t,   y, z > 0       (one t a condition)
    B q - lambda f_L = f_D - drag (u - u_before)

The interior-point program stops where one joint among thousands bars the way: every step is cut to the nearest bound.
Smoothed (Chen, Harker, Kanzow) the conditions have no bound; Newton's method takes whole steps, and what is wrong at a
joint stays there. But while t falls, states come to an end one after the other: without dilation a joint that is
pressed harder moves the mechanism away from it, and a few joints (half blocks at an edge, head joints that carry load)
jump to another state. Newton's method finds none; motion does: blocks that drag have a state near the last one for a
drag large enough, and one such step after the other leads to where nothing moves on (pseudo-transient continuation).

Only blocks that move and their neighbours take part (`moving_part`).
Sources: Chen and Harker 1993, Kanzow 1996; Kelley and Keyes 1998 (pseudo-transient continuation); own combination.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import cycle
from time import perf_counter

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.limit_analysis.paper.equilibrium import Equilibrium
from orchestrator.limit_analysis.paper.yield_conditions import YieldConditions
from orchestrator.limit_analysis.search.complementarity import (
    MAXIMUM_ITERATIONS,
    CentralPoint,
    ComplementarySolution,
    errors_of,
    first_iterate,
    gap_of,
    linearised,
    next_iterate,
    stalled,
    strength_of,
)
from orchestrator.limit_analysis.search.moving_part import MovingPart
from orchestrator.limit_analysis.search.scaled_problem import ScaledProblem, scaled_problem
from orchestrator.limit_analysis.search.wall_stiffness import kept_memory

FIRST_GAP = 0.2
"""Gap (part of the live load's power) at which the interior-point program hands over."""
LAST_GAP = 1e-7
"""Gap at the end."""
TARGET_SPREAD = 100.0
"""Products of the interior-point program are kept as targets t as far as they are within this factor of their mean."""
FALL = 0.75
"""Factor of all t from one state to the next."""
FASTER = 0.8
"""Factor of FALL where Newton's method alone gets there."""
FLATTER = 0.2
"""Power with which all t approach their mean."""
SCALES = (300.0, 1000.0, 100.0, 30.0)
"""sigma: typical force (mean block weights) over typical rate of a joint. Any of them gets stuck on some wall; after a
failure the next one takes its turn."""
OFF = 1.0
"""Residual of a smoothed condition, over 2 sqrt(sigma t), above which a joint is off. Blocks that may be off by more
have interpenetrated: from there even much drag leads to no state, and a long motion comes to an early end."""
WELL_OFF = 3.0
"""Residual of a joint that is off. Newton's method has failed where more joints than MANY and than FEW are, or one has
FAR_OFF."""
MANY = 0.003
"""Part of all joints."""
FEW = 3
"""Number of joints."""
FAR_OFF = 1e8
"""Residual of one joint."""
NEWTON_STEPS = 8
"""Newton steps at most without drag."""
DRAG_STEPS = 8
"""Newton steps at most with it."""
DRAG = 1.0
"""First drag, mean block weights per scaled velocity."""
MORE_DRAG = 5.0
"""Factor on it after a failure."""
FAILURES = 5
"""Failures in a row at most."""
AT_REST = 1e-5
"""Force out of balance (mean block weights) that may be left when nothing moves on."""
FAR_FROM_REST = 20.0
"""This times the gap may be left while the gap is larger than FAR: those states are only on the way."""
FAR = 1e-2
"""Gap from which on states are only on the way."""
LOST_MOTION = 10.0
"""Force out of balance (mean block weights) with which a motion is lost: one that ended at rest stayed below 2 (10,050
blocks)."""
FACTORISATIONS_AT_ONE_SIGMA = 700
"""Factorisations at most before sigma is changed on the way to rest."""
FACTORISATIONS = 500
"""Factorisations at most of a wall of no blocks."""
A_BLOCK = 2
"""So many more a block."""
WORK = 2.5e7
"""Blocks times factorisations at most."""
CLOSEST = 0.9
"""Factor of all t with which a state is looked for last."""
BACK = 3
"""States by which the search goes back where not even a fall by CLOSEST leads to one, twice as many each time that it
gets no further."""


@dataclass(frozen=True, eq=False, slots=True)
class Reached:
    """Where an attempt ended: iterate (y and z may be negative), factorisations, whether it is a state."""

    iterate: CentralPoint
    factorisations: int
    found: bool


def smoothed_start(part: MovingPart, depth: FloatArray) -> tuple[ComplementarySolution, FloatArray]:
    """Look for a state of the part that moves.

    depth (k,) of all joints below the top, in m: forces begin in proportion to it. Returns where that ended and the
    slips (k,) in m/s of all joints to descend from.
    """
    start = depth[part.joints] / part.equilibrium.block_length
    with kept_memory():
        found = solve_smoothed(part.equilibrium, part.friction, start)
    slip = np.zeros_like(depth)
    slip[part.joints] = found.slip
    return found, slip


def solve_smoothed(
    equilibrium: Equilibrium, coulomb: YieldConditions, start_normal: FloatArray | float
) -> ComplementarySolution:
    """Look for a non-associative state, beginning with forces start_normal (k,) (mean block weights) at joints' ends.

    Never raises: returns the state with the smallest gap, with `converged` False unless that is LAST_GAP.
    """
    started = perf_counter()
    problem = scaled_problem(equilibrium, coulomb)
    iterate, used = _interior(problem, start_normal)
    products = iterate.strength * iterate.rates
    targets = np.clip(products, products.mean() / TARGET_SPREAD, products.mean() * TARGET_SPREAD)
    passed = [(replace(iterate, strength=_own_strength(problem, iterate)), targets)]
    nearest = passed[-1]
    scales, fall = cycle(SCALES), FALL / FASTER
    scale, begin = next(scales), passed[-1][0]
    back, furthest = BACK, np.inf
    blocks = len(equilibrium.free_blocks)
    most = min(FACTORISATIONS + A_BLOCK * blocks, WORK / blocks)
    while used < most and _gap(*passed[-1]) > LAST_GAP:
        targets = passed[-1][1]
        lower = targets if len(passed) == 1 else fall * targets ** (1.0 - FLATTER) * targets.mean() ** FLATTER
        reached = by_newton = dragged(problem, begin, lower, scale, 0.0, NEWTON_STEPS)
        used += by_newton.factorisations
        if not by_newton.found:
            reached = relaxed(problem, begin, lower, scale)
            used += reached.factorisations
        begin = reached.iterate
        if reached.found:
            passed.append((begin, lower))
            nearest = min(nearest, passed[-1], key=lambda state: _gap(*state))
            fall = FASTER * fall if by_newton.found else FALL
            continue
        scale = next(scales)
        if fall < CLOSEST:
            fall = float(np.sqrt(fall))
            continue
        back, furthest = BACK if _gap(*passed[-1]) < furthest else 2 * back, min(furthest, _gap(*passed[-1]))
        del passed[max(1, len(passed) - back) :]
        begin, fall = passed[-1][0], FALL
    iterate, targets = nearest
    return ComplementarySolution(
        load_multiplier=iterate.multiplier * equilibrium.unit_force / equilibrium.live_total,
        normal=equilibrium.unit_force * iterate.forces[:, :2].sum(axis=1),
        slip=(iterate.rates[:, 2] - iterate.rates[:, 3]) / equilibrium.live_total,
        gap=_gap(iterate, targets),
        iterations=used,
        seconds=perf_counter() - started,
        converged=_gap(iterate, targets) <= LAST_GAP,
    )


def relaxed(problem: ScaledProblem, iterate: CentralPoint, targets: FloatArray, scale: float) -> Reached:
    """Follow the motion of blocks that drag to where they rest in a state with targets t (k, 4); scale: sigma.

    Returns how far they got if they do not come to rest, where they began if they are lost.
    """
    begin, drag, used, failures = iterate, DRAG, 0, 0
    gap = _gap(iterate, targets)
    at_rest = FAR_FROM_REST * gap if gap > FAR else AT_REST
    while used < FACTORISATIONS_AT_ONE_SIGMA and failures < FAILURES:
        step = dragged(problem, iterate, targets, scale, drag, DRAG_STEPS)
        used += step.factorisations
        if not step.found:
            drag, failures = MORE_DRAG * drag, failures + 1
            continue
        iterate, failures = step.iterate, 0
        out_of_balance = np.abs(errors_of(problem, iterate)[0]).max()
        if out_of_balance < at_rest:
            return Reached(iterate, used, True)
        if out_of_balance > LOST_MOTION:
            return Reached(begin, used, False)
        drag *= 0.3 if step.factorisations <= 2 else 0.6 if step.factorisations <= 4 else 1.0
    return Reached(iterate, used, False)


def dragged(
    problem: ScaledProblem, before: CentralPoint, targets: FloatArray, scale: float, drag: float, steps: int
) -> Reached:
    """Newton's method for targets t (k, 4), blocks being held back by drag (u - u_before)."""
    iterate = before
    for taken in range(1, steps + 1):
        try:
            iterate = _newton(problem, iterate, targets, scale, drag, before.velocities)
        except RuntimeError:  # the matrix is singular to rounding
            return Reached(iterate, taken, False)
        root = _smoothed(iterate, targets, scale)[1]
        residual = np.abs(iterate.strength + scale * iterate.rates - root)
        off = (residual / np.sqrt(4.0 * scale * targets)).max(axis=1)
        if not off.max() <= FAR_OFF or np.count_nonzero(off > WELL_OFF) > max(FEW, MANY * len(off)):
            return Reached(iterate, taken, False)
        if off.max() <= OFF:
            return Reached(replace(iterate, rates=both_slips(problem, iterate, targets, scale)), taken, True)
    return Reached(iterate, steps, False)


def _newton(
    problem: ScaledProblem, iterate: CentralPoint, targets: FloatArray, scale: float, drag: float, reference: FloatArray
) -> CentralPoint:
    """One whole Newton step on the smoothed conditions; they are linearised where y z = t and y - sigma z is kept."""
    root = _smoothed(iterate, targets, scale)[1]
    residual = iterate.strength + scale * iterate.rates - root
    strength, scaled_rates = _on_curve(iterate, targets, scale)
    strength, rates = np.maximum(strength, 1e-14), np.maximum(scaled_rates, 1e-16) / scale
    unbalanced, incompatible, power = errors_of(problem, iterate)
    errors = unbalanced - drag * (iterate.velocities - reference), incompatible, power
    on_curve = replace(iterate, strength=strength, rates=rates)
    change = linearised(problem, on_curve, errors, drag).direction(-residual * root / (2.0 * scale))
    return CentralPoint(
        iterate.multiplier + change.multiplier,
        iterate.velocities + change.velocities,
        iterate.forces + change.forces,
        iterate.strength + change.strength,
        iterate.rates + change.rates,
    )


def _smoothed(iterate: CentralPoint, targets: FloatArray, scale: float) -> tuple[FloatArray, FloatArray]:
    """y - sigma z and sqrt((y - sigma z)^2 + 4 sigma t), both (k, 4)."""
    difference = iterate.strength - scale * iterate.rates
    return difference, np.sqrt(difference**2 + 4.0 * scale * targets)


def _on_curve(iterate: CentralPoint, targets: FloatArray, scale: float) -> tuple[FloatArray, FloatArray]:
    """y and sigma z, both (k, 4), with y z = t and the y - sigma z of the iterate."""
    difference, root = _smoothed(iterate, targets, scale)
    larger = 0.5 * (root + np.abs(difference))
    smaller = scale * targets / larger
    return np.where(difference > 0, larger, smaller), np.where(difference > 0, smaller, larger)


def both_slips(problem: ScaledProblem, iterate: CentralPoint, targets: FloatArray, scale: float) -> FloatArray:
    """Return the rates (k, 4) of an iterate with the p and m that go with slip p - m and strength mu N + c.

        t_p / p + t_m / m = 2 (mu N + c)

    Nothing else depends on p + m. Where a joint opens it is large, 2 t / (mu N + c), and wrong by as much as the little
    force that is left there: linearised, p and m then turn negative, which for sigma looks like a pressed joint.
    """
    normal = _on_curve(iterate, targets, scale)[0][:, :2].sum(axis=1)
    twice = 2.0 * (problem.friction * normal + problem.cohesion)
    slip = iterate.rates[:, 2] - iterate.rates[:, 3]
    along, against = np.where(slip > 0, targets[:, 2:].T, targets[:, :1:-1].T)
    power = twice * np.abs(slip)
    root = np.sqrt((power + against - along) ** 2 + 4.0 * along * against)
    larger = (power + along + against + root) / (2.0 * twice)
    smaller = against / (twice - along / larger)
    return np.column_stack([iterate.rates[:, :2], *np.where(slip > 0, (larger, smaller), (smaller, larger))])


def _interior(problem: ScaledProblem, start_normal: FloatArray | float) -> tuple[CentralPoint, int]:
    """Run the interior-point program to FIRST_GAP, or to where it stops."""
    iterate, gaps = first_iterate(problem, start_normal), list[float]()
    while len(gaps) < MAXIMUM_ITERATIONS and not stalled(gaps) and gap_of(iterate) > FIRST_GAP:
        gaps.append(gap_of(iterate))
        try:
            iterate = next_iterate(problem, iterate, errors_of(problem, iterate))
        except RuntimeError:
            break
    return iterate, len(gaps)


def _own_strength(problem: ScaledProblem, iterate: CentralPoint) -> FloatArray:
    """y (k, 4) that goes with the forces: the interior-point program lets it differ by what is still missing."""
    strength = strength_of(problem.friction, iterate.forces)
    strength[:, 2:] += problem.cohesion[:, None]
    return strength


def _gap(iterate: CentralPoint, targets: FloatArray) -> float:
    """Sum of the targets over the live load's power."""
    return float(targets.sum() / max(abs(iterate.multiplier), 1e-3))
