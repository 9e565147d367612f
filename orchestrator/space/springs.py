"""Rigid blocks on springs at the contact points: forces after a displacement, and what is out of balance.

    trial    t = q_before - k B^T u                           (k: stiffness of a point's springs, u: displacements)
    normal   N = max(0, t_N),    shear   T = t_T / |t_T| min(|t_T|, mu N)      (what opens or slides forgets its trial)
    balance  B q + lambda f_L + f_D = 0,    f_L . u = h

max(0, t) is smoothed to P(t) = (t + sqrt(t^2 + 4 m^2)) / 2, the shear to |T| = P(t + mu N) - P(t - mu N) - mu N; a
state no longer feels it when h has grown (N x opening = m^2 k / h). Source of the smoothing: Chen and Harker 1993.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.limit_analysis.search.elastic_contact import LEAST_STIFFNESS
from orchestrator.space.contacts import SpaceAssemblage
from orchestrator.space.equilibrium import SpaceEquilibrium
from orchestrator.space.stiffness import ContactStiffness

SPRING_SMOOTHING = 1e-9
"""m in mean block weights, at mean depth and for four points a joint."""


@dataclass(frozen=True, eq=False, slots=True)
class Springs:
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
class SpringForces:
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


def joint_stiffness(assemblage: SpaceAssemblage, power: float = 2.0) -> FloatArray:
    """Return the stiffness (p,) of every contact point, in m2: its part of its joint's area, so that it does not matter
    into how many stones a wall is cut, times the joint's depth below the wall's top over the mean depth, to a power (0:
    all depths alike). A tie is as stiff as the mean of the joints' points."""
    wall, joints = assemblage.wall, assemblage.joints
    top = max(float((b.shape.vertices @ wall.up).max()) for b in wall.blocks if not b.fixed)
    depth = np.maximum(top - joints.centroid @ wall.up, 0.0)
    depth += 0.01 * depth.mean()
    area, touches = joints.area / np.bincount(joints.joint), joints.area > 0.0
    area = np.where(touches, area, area[touches].mean())
    return (area * (depth / depth.mean()) ** power)[joints.joint]


def springs_of(assemblage: SpaceAssemblage, equilibrium: SpaceEquilibrium, stiffness: FloatArray) -> Springs:
    """Return the scaled problem of a wall with springs of stiffness (p,), of which only ratios matter."""
    scale = equilibrium.row_scale
    return Springs(
        contacts=ContactStiffness(assemblage, equilibrium),
        friction=equilibrium.friction,
        capacity=equilibrium.capacity / equilibrium.weight_scale,
        stiffness=stiffness / stiffness.mean(),
        smoothing=SPRING_SMOOTHING * np.sqrt(stiffness / stiffness.mean()),
        dead=scale * equilibrium.dead_load / equilibrium.weight_scale,
        live=scale * equilibrium.live_load / equilibrium.live_total,
    )


def displaced(springs: Springs, before: FloatArray, multiplier: float, displacements: FloatArray) -> SpringForces:
    """Return the forces after displacements (6m,) from forces `before` (p, 3)."""
    trial = before - springs.stiffness[:, None] * springs.contacts.rates(displacements)
    forces, tangent = returned(trial, springs.friction, springs.smoothing, springs.capacity)
    unbalanced = springs.contacts.sums(forces) + multiplier * springs.live + springs.dead
    return SpringForces(multiplier, displacements, forces, tangent, unbalanced)


def returned(
    trial: FloatArray, friction: FloatArray, smoothing: FloatArray, capacity: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return forces (p, 3) in Coulomb's cone, normal ones up to the capacity (p,), from trials (p, 3), smoothed by
    (p,), and their derivative (p, 3, 3)."""
    normal, d_normal = positive(trial[:, 0], smoothing)
    d_normal = np.where(normal < capacity, d_normal, 0.0)
    normal = np.minimum(normal, capacity)
    size = np.linalg.norm(trial[:, 1:], axis=1)
    limit = friction * normal
    above, d_above = positive(size + limit, smoothing)
    below, d_below = positive(size - limit, smoothing)
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


def positive(trial: FloatArray, smoothing: FloatArray) -> tuple[FloatArray, FloatArray]:
    """max(0, t), smoothed, and its slope; without cancellation for t < 0."""
    root = np.sqrt(trial**2 + 4.0 * smoothing**2)
    larger = 0.5 * (np.abs(trial) + root)
    return np.where(trial > 0, larger, smoothing**2 / larger), 0.5 * (1.0 + trial / root)


def flow_error(springs: Springs, pushed: SpringForces, velocities: FloatArray) -> float:
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
