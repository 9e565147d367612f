"""States without dilation in space as the end of a push: rigid blocks on springs at the contact points (docs/space.md).

    trial    t = q_before - k B^T u                           (k: stiffness of a point's springs, u: displacements)
    normal   N = max(0, t_N),    shear   T = t_T / |t_T| min(|t_T|, mu N)      (what opens or slides forgets its trial)
    balance  B q + lambda f_L + f_D = 0,    f_L . u = h

From the gravity state on, step after step of the live load's displacement h, each longer than the last. While h grows
the springs give way to ever less of the motion: in the end forces stand still and what moves is a mechanism that opens
only where there is no force and slides without dilation only where friction is at its limit. A step is one of the
proximal point method on forces. It is the plane's limit_analysis.elastic_joints with a cone for friction.

max(0, t) is smoothed to P(t) = (t + sqrt(t^2 + 4 m^2)) / 2, the shear to |T| = P(t + mu N) - P(t - mu N) - mu N; a
state no longer feels it when h has grown (N x opening = m^2 k / h). Springs are stiffer with depth below the top, as
the forces are larger there; k only says which of several states is reached.
Sources: Rockafellar 1976 (proximal point); Chen and Harker 1993 (smoothing); own combination.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from orchestrator.masonry.wall import FloatArray
from orchestrator.space.conic_program import ConicSolution
from orchestrator.space.contacts import SpaceAssemblage
from orchestrator.space.equilibrium import SpaceEquilibrium
from orchestrator.space.stiffness import ContactStiffness

SMOOTHING = 1e-9
"""m in mean block weights, at mean depth and for four points a joint."""
FIRST_STEP = 1.0
"""h: mean displacement along the live load, times stiffness of a spring at mean depth over the mean block weight."""
FLOW = 1e-7
"""Sum of what is done by points that open while loaded or slide before they must, over the live load's power, at which
the end is reached."""
BALANCE = 1e-7
"""Force out of balance, mean block weights, that ends Newton's method."""
TIGHT_BALANCE = 1e-11
"""The same for the state that is kept."""
ASTRAY = 100.0
"""Times the first force out of balance from which Newton's method is given up."""
RUNAWAY = 1e5
"""Flow error of a step in which a block flies off: it held by nothing, and the step is refused."""
NEWTON_STEPS, HALVINGS, FAILURES = 16, 6, 20
LEAST_STIFFNESS = 1e-8
"""Part of its spring's that an open point has in the matrix: a block that hangs free for a moment is held."""


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


@dataclass(frozen=True, eq=False, slots=True)
class _Springs:
    """The scaled problem: friction mu, capacity (ties), stiffness k and smoothing m of the points (p,), dead and live
    load (6m,)."""

    contacts: ContactStiffness
    friction: FloatArray
    capacity: FloatArray
    stiffness: FloatArray
    smoothing: FloatArray
    dead: FloatArray
    live: FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class _Pushed:
    """lambda and displacements u (6m,), scaled; forces q (p, 3); tangent (p, 3, 3) of forces to trials; what forces
    (6m,) are out of balance."""

    multiplier: float
    displacements: FloatArray
    forces: FloatArray
    tangent: FloatArray
    unbalanced: FloatArray

    @property
    def error(self) -> float:
        """Largest force out of balance, mean block weights."""
        return float(np.abs(self.unbalanced).max())


def depth_stiffness(assemblage: SpaceAssemblage, power: float = 2.0) -> FloatArray:
    """Return the stiffness (p,) of every contact point: depth of its joint below the wall's top over the mean depth, to
    a power (0: all alike)."""
    wall, joints = assemblage.wall, assemblage.joints
    top = max(float((b.shape.vertices @ wall.up).max()) for b in wall.blocks if not b.fixed)
    depth = np.maximum(top - joints.centroid @ wall.up, 0.0)
    depth += 0.01 * depth.mean()
    return ((depth / depth.mean()) ** power)[joints.joint]


def push(
    assemblage: SpaceAssemblage,
    equilibrium: SpaceEquilibrium,
    gravity: FloatArray,
    stiffness: FloatArray,
    budget: float = 60.0,
    report: Callable[[str], None] = lambda _: None,
) -> Push:
    """Push a wall from its gravity forces (p, 3) in N until its forces stand still, or for `budget` seconds.

    Never raises: says in `converged` whether it has arrived.
    """
    started = perf_counter()
    springs = _springs(assemblage, equilibrium, stiffness)
    forces = gravity / equilibrium.weight_scale
    last, used = _newton(springs, forces, 0.0, np.zeros_like(springs.dead), None, 60, BALANCE)
    h, failures, flow = FIRST_STEP, 0, np.inf
    velocities, path = np.zeros_like(springs.dead), [0.0]
    while failures < FAILURES and perf_counter() - started < budget:
        tolerance = TIGHT_BALANCE if flow < 1e3 * FLOW else BALANCE
        pushed, steps = _newton(springs, last.forces, last.multiplier, h * velocities, h, NEWTON_STEPS, tolerance)
        used += steps
        reached = _flow(springs, pushed, pushed.displacements / h)
        if not (pushed.error < 10.0 * BALANCE and reached < RUNAWAY):
            h, failures = 0.25 * h, failures + 1
            continue
        last, velocities, flow, failures = pushed, pushed.displacements / h, reached, 0
        path.append(last.multiplier * equilibrium.weight_scale / equilibrium.live_total)
        report(f"λ {path[-1]:.4f}, {used} factorisations, flow error {flow:.0e}")
        if flow <= FLOW and last.error <= 100 * TIGHT_BALANCE:
            break
        h *= 3.0 if steps <= 4 else 1.5 if steps <= 7 else 1.0 if steps <= 11 else 0.6
    physical = velocities * equilibrium.row_scale / equilibrium.live_total
    power = float(equilibrium.live_load @ physical) or 1.0
    unscaled = (physical / power).reshape(-1, 6)
    return Push(
        load_multiplier=path[-1],
        forces=equilibrium.weight_scale * last.forces,
        velocities=unscaled,
        rates=equilibrium.rates(unscaled),
        flow=flow,
        factorisations=used,
        seconds=perf_counter() - started,
        converged=bool(flow <= FLOW),
        path=tuple(path),
    )


def as_solution(pushed: Push) -> ConicSolution:
    """Return the end of a push as forces and mechanism of a state."""
    return ConicSolution(
        load_multiplier=pushed.load_multiplier,
        forces=pushed.forces,
        velocities=pushed.velocities,
        rates=pushed.rates,
        iterations=pushed.factorisations,
        seconds=pushed.seconds,
        status="Solved" if pushed.converged else "NotSettled",
    )


def _springs(assemblage: SpaceAssemblage, equilibrium: SpaceEquilibrium, stiffness: FloatArray) -> _Springs:
    scale = equilibrium.row_scale
    return _Springs(
        contacts=ContactStiffness(assemblage, equilibrium),
        friction=equilibrium.friction,
        capacity=equilibrium.capacity / equilibrium.weight_scale,
        stiffness=stiffness / stiffness.mean(),
        smoothing=SMOOTHING * np.sqrt(stiffness / stiffness.mean()),
        dead=scale * equilibrium.dead_load / equilibrium.weight_scale,
        live=scale * equilibrium.live_load / equilibrium.live_total,
    )


def _newton(
    springs: _Springs,
    before: FloatArray,
    multiplier: float,
    displacements: FloatArray,
    h: float | None,
    most: int,
    tolerance: float,
) -> tuple[_Pushed, int]:
    """Return the step to live displacement h from forces `before` (p, 3), and the Newton steps taken, `most` at most.

    multiplier and displacements are where to begin. Without h there is no live load.
    """
    pushed = _displaced(springs, before, multiplier, displacements)
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
    springs: _Springs, before: FloatArray, pushed: _Pushed, change: FloatArray, more: float, most: int
) -> _Pushed:
    """Return the first of the halved Newton steps that leaves clearly less out of balance, else the best of them."""
    out_of_balance, tried = np.linalg.norm(pushed.unbalanced), list[_Pushed]()
    for part in 0.5 ** np.arange(most):
        tried.append(_displaced(springs, before, pushed.multiplier + part * more, pushed.displacements + part * change))
        if np.linalg.norm(tried[-1].unbalanced) < (1.0 - 0.1 * part) * out_of_balance:
            return tried[-1]
    return min(tried, key=lambda end: float(np.linalg.norm(end.unbalanced)))


def _displaced(springs: _Springs, before: FloatArray, multiplier: float, displacements: FloatArray) -> _Pushed:
    """Return the forces after displacements (6m,) from forces `before` (p, 3)."""
    trial = before - springs.stiffness[:, None] * springs.contacts.rates(displacements)
    forces, tangent = returned(trial, springs.friction, springs.smoothing, springs.capacity)
    unbalanced = springs.contacts.sums(forces) + multiplier * springs.live + springs.dead
    return _Pushed(multiplier, displacements, forces, tangent, unbalanced)


def returned(
    trial: FloatArray, friction: FloatArray, smoothing: FloatArray, capacity: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return forces (p, 3) in Coulomb's cone, normal ones up to the capacity (p,), from trials (p, 3), smoothed by
    (p,), and their derivative (p, 3, 3)."""
    normal, d_normal = _positive(trial[:, 0], smoothing)
    d_normal = np.where(normal < capacity, d_normal, 0.0)
    normal = np.minimum(normal, capacity)
    size = np.linalg.norm(trial[:, 1:], axis=1)
    limit = friction * normal
    above, d_above = _positive(size + limit, smoothing)
    below, d_below = _positive(size - limit, smoothing)
    shear, d_size, d_limit = above - below - limit, d_above - d_below, d_above + d_below - 1.0
    small = size < 1e-9 * smoothing
    ratio = np.where(small, d_size, shear / np.where(small, 1.0, size))
    along = trial[:, 1:] / np.where(small, 1.0, size)[:, None]
    forces = np.column_stack([normal, ratio[:, None] * trial[:, 1:]])
    tangent = np.zeros((len(trial), 3, 3))
    tangent[:, 0, 0] = d_normal
    tangent[:, 1:, 0] = (friction * d_limit * d_normal)[:, None] * along
    tangent[:, 1:, 1:] = (d_size - ratio)[:, None, None] * along[:, :, None] * along[:, None, :]
    tangent[:, 1, 1] += ratio
    tangent[:, 2, 2] += ratio
    for k in range(3):
        tangent[:, k, k] += LEAST_STIFFNESS
    return forces, tangent


def _positive(trial: FloatArray, smoothing: FloatArray) -> tuple[FloatArray, FloatArray]:
    """max(0, t), smoothed, and its slope; without cancellation for t < 0."""
    root = np.sqrt(trial**2 + 4.0 * smoothing**2)
    larger = 0.5 * (np.abs(trial) + root)
    return np.where(trial > 0, larger, smoothing**2 / larger), 0.5 * (1.0 + trial / root)


def _flow(springs: _Springs, pushed: _Pushed, velocities: FloatArray) -> float:
    """What is done by points that open while loaded, or slide before they must or not along their shear, over the live
    load's power."""
    rates, forces = springs.contacts.rates(velocities), pushed.forces
    slip = np.linalg.norm(rates[:, 1:], axis=1)
    yields = (forces[:, 0] >= springs.capacity) & (rates[:, 0] < 0)
    done = np.abs(forces[:, 0] * rates[:, 0])[~yields].sum()
    done += np.maximum(
        springs.friction * forces[:, 0] * slip + np.einsum("pi,pi->p", forces[:, 1:], rates[:, 1:]), 0
    ).sum()
    return float(done / max(abs(pushed.multiplier), 1e-3))
