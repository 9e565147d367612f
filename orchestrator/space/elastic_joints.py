"""States without dilation in space as the end of a push: rigid blocks on springs at the contact points (docs/space.md).

    trial    t = q_before - k B^T u                           (k: stiffness of a point's springs, u: displacements)
    normal   N = max(0, t_N),    shear   T = t_T / |t_T| min(|t_T|, mu N)      (what opens or slides forgets its trial)
    balance  B q + lambda f_L + f_D = 0,    f_L . u = h

From the gravity state on, step after step of the live load's displacement h, each longer than the last. While h grows
the springs give way to ever less of the motion: in the end forces stand still and what moves is a mechanism that opens
only where there is no force and slides without dilation only where friction is at its limit. A step is one of the
proximal point method on forces. It is the plane's limit_analysis.elastic_joints with a cone for friction.

Steps are solved by Newton's method on the springs (springs.py). Where that loses its way again and again, and from the
start on large walls, a step it cannot do is left to an interior-point method (interior_step.py), which can take ten
times longer ones; what that leaves out of balance is less than what is still missing.
Springs are stiffer with depth below the top, as the forces are larger there; k only says which of several states is
reached. Sources: Rockafellar 1976 (proximal point); own combination.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from time import thread_time

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.space.contacts import SpaceAssemblage
from orchestrator.space.equilibrium import SpaceEquilibrium
from orchestrator.space.interior_step import interior_step
from orchestrator.space.springs import SpringForces, Springs, displaced, flow_error, springs_of
from orchestrator.space.validation import LIMITS
from orchestrator.space.work import Work

FIRST_STEP = 1.0
"""h: mean displacement along the live load, times stiffness of a spring at mean depth over the mean block weight."""
FLOW = 0.5 * LIMITS["flow"]
"""Sum of what is done by points that open while loaded or slide before they must, over the live load's power, at which
the end is reached."""
BALANCE = 0.5 * LIMITS["equilibrium"]
"""Force out of balance, weights of the wall, at the end."""
NEWTON_BALANCE = 1e-7
"""Force out of balance, mean block weights, that ends Newton's method."""
NEAR = 1e3
"""Times FLOW, from which on Newton's method ends at a tenth of BALANCE."""
ASTRAY = 100.0
"""Times the first force out of balance from which Newton's method is given up."""
RUNAWAY = 1e5
"""Flow error of a step in which a block flies off: it held by nothing, and the step is refused."""
NEWTON_STEPS = 16
"""Iterations of Newton's method in a step, at most; their square under gravity, from which there is no smaller step."""
HALVINGS = 6
"""Tries of a correction beside the whole one, each half as long, once the displacement of the step is reached."""
HELD_BY = 1e6
"""Live load, mean block weights, that holds a wall, as far as a push can tell."""
FAILURES = 20
"""Steps that may fail before the push is left."""
PATIENCE = 4
"""Steps that Newton's method may fail at before the interior-point method is asked."""
LEAPING_BLOCKS = 300
"""Walls of more blocks ask the interior-point method only: at 1,010 blocks it is 2 % below where the multiplier stays
after 20 s, Newton's method alone 7 %."""
LEAP = 10.0
"""Growth of h after a step of the interior-point method."""
LEAPS_LOST = 1
"""Such steps that may fail on a large wall: what is left is done faster by closing the state (descent.py)."""
PRESTRESS_STEP = 1e-3
"""Part of the prestress from which a step that takes it away, and has no state of rest, is not made shorter. Walls that
stand need one or two steps to nothing, arches next to collapse five; a lintel between two piers loses its first one."""
FLOW_ERROR_LEFT = 0.05
"""Part of the last flow error that such a step may leave."""


@dataclass(frozen=True, eq=False, slots=True)
class Push:
    """Where a push ended: multiplier, forces (p, 3) in N, velocities (m, 6) and rates (p, 3) at unit live-load power,
    flow error, factorisations and seconds it took; converged: whether the flow error is below FLOW.

    path: multiplier after every step, for the remark on what the push was still doing when it was stopped."""

    load_multiplier: float
    forces: FloatArray
    velocities: FloatArray
    rates: FloatArray
    flow: float
    factorisations: int
    seconds: float
    converged: bool
    path: tuple[float, ...]

    @property
    def slip(self) -> FloatArray:
        """Size (p,) of the slip in m/s."""
        return np.linalg.norm(self.rates[:, 1:], axis=1)


def push(
    assemblage: SpaceAssemblage,
    equilibrium: SpaceEquilibrium,
    gravity: FloatArray,
    stiffness: FloatArray,
    work: Work,
    report: Callable[[str], None] = lambda _: None,
) -> Push:
    """Push a wall from its gravity forces (p, 3) in N until its forces stand still, or no work is left.

    Never raises: says in `converged` whether it has arrived.
    """
    started = thread_time()
    springs = springs_of(assemblage, equilibrium, stiffness)
    begun = work.done
    rest, used = _newton(springs, gravity / equilibrium.weight_scale, 0.0, None, NEWTON_STEPS**2, NEWTON_BALANCE)
    work.done += used
    h, failures, lost, flow = FIRST_STEP, 0, 0, np.inf
    last, velocities, path = rest, np.zeros_like(springs.dead), [0.0]
    blocks = len(equilibrium.free_blocks)
    leaping = blocks > LEAPING_BLOCKS
    most = LEAPS_LOST if leaping else FAILURES
    while failures < most and last.multiplier < HELD_BY and work.left > 0:
        begin = replace(last, displacements=h * velocities)
        taken = _leap(springs, begin, h, flow) if leaping else _step(springs, begin, h, flow, 0.1 * BALANCE * blocks)
        work.done += taken.factorisations
        if not taken.good and not leaping and (lost := lost + 1) > PATIENCE:
            taken = _leap(springs, begin, h, flow)
            work.done += taken.factorisations
        if not taken.good:
            h, failures = 0.25 * h, failures + 1
            continue
        last, velocities, flow, failures = taken.pushed, taken.pushed.displacements / h, taken.flow, 0
        path.append(last.multiplier * equilibrium.weight_scale / equilibrium.live_total)
        report(f"λ {path[-1]:.4f}, {work.done - begun} factorisations, flow error {flow:.0e}")
        if flow <= FLOW and last.error <= BALANCE * blocks:
            break
        h *= taken.growth
    spent = work.done - begun, thread_time() - started
    return _unscaled(equilibrium, last.forces, velocities, flow, *spent, path)


def settled(
    assemblage: SpaceAssemblage, equilibrium: SpaceEquilibrium, gravity: FloatArray, stiffness: FloatArray
) -> tuple[FloatArray, FloatArray | None]:
    """Return the forces (p, 3) in N of a wall that comes to rest under its dead load on elastic joints that carried
    nothing before, and None; of one that goes down, `gravity` and its motion (m, 6). Where Newton's method loses its
    way in elastic motions there are `gravity` and None.

    Forces that balance the dead load, `gravity` (p, 3) in N, may be a prestress that nothing makes: a lintel that
    friction holds between two piers, or stacks beside each other that settle differently; those of least energy have
    joints that dilate. They are taken away step by step, and the wall moves into the joints, or down: farther than a
    tower of all its blocks settles, n^2 / 2 mean weights over mean stiffnesses for n blocks on one spring each.
    """
    springs = springs_of(assemblage, equilibrium, stiffness)
    prestress = gravity / equilibrium.weight_scale
    rest, _ = _newton(springs, prestress, 0.0, None, NEWTON_STEPS**2, NEWTON_BALANCE)
    left, step = 1.0, 1.0
    while left > 0.0:
        least = max(left - step, 0.0)
        tried, _ = _newton(springs, least * prestress, 0.0, rest.displacements, 2 * NEWTON_STEPS, NEWTON_BALANCE)
        if tried.error < NEWTON_BALANCE:
            left, rest, step = least, tried, 2.0 * step
        elif step > PRESTRESS_STEP:
            step *= 0.25
        else:
            moved = (tried.displacements - rest.displacements) / (left - least)
            settles = np.abs(moved).max() <= 0.5 * len(equilibrium.free_blocks) ** 2
            return gravity, None if settles else (moved * equilibrium.row_scale).reshape(-1, 6)
    return equilibrium.weight_scale * rest.forces, None


def _unscaled(
    equilibrium: SpaceEquilibrium,
    forces: FloatArray,
    velocities: FloatArray,
    flow: float,
    factorisations: int,
    seconds: float,
    path: list[float],
) -> Push:
    """Return the end of a push in N, and in m/s and rad/s at unit power of the live load."""
    physical = velocities * equilibrium.row_scale / equilibrium.live_total
    power = float(equilibrium.live_load @ physical) or 1.0
    unscaled = (physical / power).reshape(-1, 6)
    return Push(
        load_multiplier=path[-1],
        forces=equilibrium.weight_scale * forces,
        velocities=unscaled,
        rates=equilibrium.rates(unscaled),
        flow=flow,
        factorisations=factorisations,
        seconds=seconds,
        converged=bool(flow <= FLOW),
        path=tuple(path),
    )


@dataclass(frozen=True, eq=False, slots=True)
class _Taken:
    """A step: where it led, its flow error, whether it may be kept, how much longer the next one is, what it cost."""

    pushed: SpringForces
    flow: float
    good: bool
    growth: float
    factorisations: int


def _step(springs: Springs, begin: SpringForces, h: float, flow: float, balance: float) -> _Taken:
    """Take a step of length h by Newton's method; flow: the flow error of the last one, balance: of the end."""
    tolerance = min(balance, NEWTON_BALANCE) if flow < NEAR * FLOW else NEWTON_BALANCE
    pushed, steps = _newton(springs, begin.forces, begin.multiplier, begin.displacements, NEWTON_STEPS, tolerance, h)
    growth = 3.0 if steps <= 4 else 1.5 if steps <= 7 else 1.0 if steps <= 11 else 0.6
    reached = flow_error(springs, pushed, pushed.displacements / h)
    return _Taken(pushed, reached, pushed.error < 10.0 * NEWTON_BALANCE and reached < RUNAWAY, growth, steps)


def _leap(springs: Springs, begin: SpringForces, h: float, flow: float) -> _Taken:
    """Take a step of length h by the interior-point method; it may leave less than what is missing already."""
    goal = FLOW_ERROR_LEFT * min(flow, 1.0)
    pushed, left, steps = interior_step(springs, begin.forces, begin.multiplier, begin.displacements, h, goal)
    reached = flow_error(springs, pushed, pushed.displacements / h)
    good = pushed.error < 10.0 * NEWTON_BALANCE and left < 1.0 and max(left, reached) < flow
    return _Taken(pushed, reached, good, LEAP, steps)


def _newton(
    springs: Springs,
    before: FloatArray,
    multiplier: float,
    displacements: FloatArray | None,
    most: int,
    tolerance: float,
    h: float | None = None,
) -> tuple[SpringForces, int]:
    """Return the step to live displacement h from forces `before` (p, 3), and the Newton steps taken, `most` at most.

    multiplier and displacements are where to begin (None: at rest). Without h there is no live load.
    """
    if displacements is None:
        displacements = np.zeros_like(springs.dead)
    pushed = displaced(springs, before, multiplier, displacements)
    first = pushed.error
    for taken in range(1, most + 1):
        try:
            solve = springs.contacts.factorised(springs.stiffness, pushed.tangent)
        except RuntimeError:  # singular to rounding
            return pushed, taken
        change, more = solve(pushed.unbalanced), 0.0
        if h is not None:
            along = solve(springs.live)
            more = float((h - springs.live @ (pushed.displacements + change)) / (springs.live @ along))
            change = change + more * along
        there = h is None or abs(springs.live @ pushed.displacements - h) <= 1e-9 * h
        pushed = _best(springs, before, pushed, change, more, 1 + HALVINGS if there else 1)
        if not tolerance <= pushed.error < ASTRAY * max(first, 1.0):
            return pushed, taken
    return pushed, most


def _best(
    springs: Springs, before: FloatArray, pushed: SpringForces, change: FloatArray, more: float, most: int
) -> SpringForces:
    """Return the first of the halved Newton steps that leaves clearly less out of balance, else the best of them."""
    out_of_balance, tried = np.linalg.norm(pushed.unbalanced), list[SpringForces]()
    for part in 0.5 ** np.arange(most):
        tried.append(displaced(springs, before, pushed.multiplier + part * more, pushed.displacements + part * change))
        if np.linalg.norm(tried[-1].unbalanced) < (1.0 - 0.1 * part) * out_of_balance:
            return tried[-1]
    return min(tried, key=lambda end: float(np.linalg.norm(end.unbalanced)))
