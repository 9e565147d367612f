"""The collapse mechanism: what the duals of Eq. (1) say about motion, and checks that tie motion to forces.

    velocity of a point x of block i     v_i + omega_i k x (x - centroid_i)
    opening = n . (v_j - v_i), slip = t . (v_j - v_i)       relative to the joint's normal n (i to j) and tangent t
    lambda f_L . u + f_D . u = sum_k (c + (mu - psi) N) |slip|        power balance; a sliding joint opens by psi |slip|
                             + sum_k max over N, M of -(n_start, n_end) . (opening - psi |slip|)    tension and crushing

psi is mu for the associative flow rule, 0 for a non-associative state. The falling lines of Eq. (2) have
psi = -alpha mu: the mechanism of the paper's sequence is that of its LAST linear program, so its sliding joints close
by alpha mu |slip| (0.65 % of the slip at alpha = 0.01 and mu = 0.65) instead of keeping their distance.

Noise, measured: joints that carry load inside their friction lines (0.001 block weights from every limit) should not
move; on the walls in tests/data they open or slip by less than 1e-10 of the largest displacement (associative and
sequence). See test_power_balance.
"""

from __future__ import annotations

import numpy as np

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.geometry.rigid import velocity_of_points
from orchestrator.limit_analysis.paper.equilibrium import Equilibrium
from orchestrator.limit_analysis.paper.limit_state import Mechanism
from orchestrator.limit_analysis.paper.yield_conditions import YieldConditions
from orchestrator.masonry.block_properties import block_centroids, outlines_of
from orchestrator.masonry.wall import Wall

CLOSED = 1e-4
"""A joint's end is closed when it carries more than this part of the mean block weight."""
NO_POWER = 1e-6
"""of a mean block's weight at the largest displacement: where live and dead load have less, both have none"""


def mechanism_from(wall: Wall, equilibrium: Equilibrium, velocities: FloatArray) -> Mechanism:
    """Return the mechanism of free-block velocities (3m,) in m/s and rad/s, scaled to unit live-load power."""
    return motion_of(wall, equilibrium, velocities / (equilibrium.live_load @ velocities))


def motion_of(wall: Wall, equilibrium: Equilibrium, velocities: FloatArray) -> Mechanism:
    """Return free-block velocities (3m,) in m/s and rad/s with what they open and slip."""
    rates, of_blocks = equilibrium.joint_rates(velocities), equilibrium.of_all_blocks(velocities)
    return Mechanism(
        velocities=read_only(of_blocks),
        opening=read_only(rates[:, :2]),
        slip=read_only(rates[:, 2]),
        largest_displacement=largest_corner_velocity(wall, of_blocks),
    )


def largest_corner_velocity(wall: Wall, velocities: FloatArray) -> float:
    """Largest velocity in m/s of any corner of the blocks, which move with velocities (n, 3)."""
    outlines = outlines_of(wall)
    arm = outlines.corner - block_centroids(wall)[outlines.block]
    return float(np.hypot(*velocity_of_points(velocities[outlines.block], arm).T).max())


def centres_of_rotation(
    velocities: FloatArray, centroids: FloatArray, resting: float = 1e-6, far: float = 1e6
) -> FloatArray:
    """Return the points (n, 2) in m that do not move: centroid + (-v, u)/omega of blocks with velocities (n, 3).

    A block at rest has no centre: (nan, nan). At rest means speed + |omega| L below `resting` times the largest such
    sum; L is the larger side of the box round the centroids (1 m if they coincide).
    A block in translation has its centre at infinity, normal to its motion: (-v, u) with infinite components, a
    component below 1e-9 of the speed giving the centroid's own coordinate instead (motion along x: (x, +-inf)). In
    translation means that the centre is further than `far` times L away. The sign is that of a vanishing
    counter-clockwise rotation, so blocks that translate alike have the same centre.
    """
    u, v, omega = velocities.T
    extent = float(np.ptp(centroids, axis=0).max()) or 1.0
    speed = np.hypot(u, v)
    motion = speed + np.abs(omega) * extent
    at_rest = (motion <= resting * motion.max()) | (motion == 0.0)
    translating = ~at_rest & (speed > far * extent * np.abs(omega))
    rotating = ~at_rest & ~translating
    sideways = np.column_stack([-v, u])
    centres = np.full_like(centroids, np.nan)
    centres[rotating] = centroids[rotating] + sideways[rotating] / omega[rotating, None]
    along = np.abs(sideways) > 1e-9 * speed[:, None]
    at_infinity = np.where(along, np.copysign(np.inf, sideways), centroids)
    centres[translating] = at_infinity[translating]
    return centres


def power_residual(
    equilibrium: Equilibrium,
    coulomb: YieldConditions,
    dilatancy: FloatArray,
    load_multiplier: float,
    joint_forces: FloatArray,
    mechanism: Mechanism,
) -> float:
    """|lambda f_L . u + f_D . u - dissipation in the joints| relative to the power of live or dead load, the larger.

    dilatancy (k,) is psi. 0 only if every force does the work its flow rule allows: joints that open carry nothing (or
    their tensile strength) where they open, joints that slide or crush carry all they can, against the motion.
    """
    u = mechanism.velocities[equilibrium.free_blocks].ravel()
    live, dead = load_multiplier * (equilibrium.live_load @ u), equilibrium.dead_load @ u
    rates = np.column_stack([mechanism.opening, mechanism.slip])
    dissipation = coulomb.dissipation(joint_forces, rates, dilatancy)
    none = NO_POWER * equilibrium.unit_force * mechanism.largest_displacement
    largest = max(abs(float(live)), abs(float(dead)), none)
    return abs(float(live + dead) - dissipation) / largest


def dilation(
    equilibrium: Equilibrium, coulomb: YieldConditions, joint_forces: FloatArray, mechanism: Mechanism
) -> float:
    """Largest |opening| at an end of a joint that carries load there, relative to the largest displacement.

    Joints that can crush are left out: they turn about a point inside.
    """
    closed = (joint_forces[:, :2] > CLOSED * equilibrium.unit_force) & ~coulomb.crushes[:, None]
    return float(np.max(np.abs(mechanism.opening[closed]), initial=0.0) / mechanism.largest_displacement)
