"""Is this a non-associative limit state? Checked from geometry, forces and velocities alone: no matrix, no solver.

Every joint force is applied to its two blocks at its place, every rate is taken from the blocks' velocities at both
ends of the joint; loads and strengths are the only things shared with the programs that found the state.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.geometry.rigid import cross, velocity_of_points
from orchestrator.limit_analysis.paper.equilibrium import Equilibrium
from orchestrator.limit_analysis.paper.limit_state import LimitState
from orchestrator.limit_analysis.paper.mechanism import CLOSED
from orchestrator.limit_analysis.paper.yield_conditions import YieldConditions
from orchestrator.masonry.block_properties import block_centroids
from orchestrator.masonry.joints import Assemblage

LIMITS = {
    "equilibrium": 1e-8,
    "yield_excess": 1e-8,
    "flow": 1e-6,
    "dilation": 1e-4,
    "backward": 1e-8,
    "interpenetration": 1e-8,
    "power": 1e-6,
}
"""Largest values that pass, for every rule alike. Flow and power are the relative error of lambda that a state may
have. Dilation follows from flow: an end that carries N opens by at most flow x live power / N (see CLOSED)."""


@dataclass(frozen=True, slots=True)
class Validation:
    """What a state does wrong; 0 is perfect.

    equilibrium: largest unbalanced force (moments over a block length) over the total weight. yield_excess: tension,
    crushing or shear beyond the strength, in mean block weights. dilation: largest opening or closing at a joint's end
    that carries load, over the largest displacement. interpenetration: largest closing of ends that do not stand open,
    over the same.
    Relative to the live load's power: flow = sum of N |opening| and of (strength - |shear|) |slip|, what is done by
    joints that open while loaded or slide before they must; backward: power that friction gives instead of takes;
    power: live + dead power less dissipation.
    """

    equilibrium: float
    yield_excess: float
    flow: float
    dilation: float
    backward: float
    interpenetration: float
    power: float

    @property
    def complaints(self) -> tuple[str, ...]:
        """What is wrong, in words; empty for a valid state."""
        return beyond(self, LIMITS)


def beyond(measured: object, limits: Mapping[str, float]) -> tuple[str, ...]:
    """Return which attributes of `measured` are above their limit, in words."""
    named = ((name, getattr(measured, name), limit) for name, limit in limits.items())
    return tuple(f"{name} {value:.1e} > {limit:.0e}" for name, value, limit in named if value > limit)


def validate(
    assemblage: Assemblage, equilibrium: Equilibrium, strength: YieldConditions, state: LimitState
) -> Validation:
    """Check a non-associative state under the loads of `equilibrium` and Coulomb's law `strength` in the joints."""
    forces, multiplier = state.joint_forces, state.load_multiplier
    velocities = state.mechanism.velocities
    opening, slip = rates_at_joints(assemblage, velocities)
    largest = state.mechanism.largest_displacement
    normal, shear = forces[:, :2], forces[:, 2]
    limit = strength.slope * normal.sum(axis=1) + strength.cohesion
    u = velocities[equilibrium.free_blocks].ravel()
    live = max(abs(float(multiplier * (equilibrium.live_load @ u))), float(np.finfo(float).tiny))
    loads = multiplier * equilibrium.live_load + equilibrium.dead_load
    unbalanced = block_forces(assemblage, forces)[equilibrium.free_blocks].ravel() + loads
    spare = np.maximum(limit - np.abs(shear), 0.0)
    hard = ~strength.crushes  # a joint that crushes turns about a point inside: only its power can be checked
    stand_open = np.zeros(opening.shape, dtype=bool) if state.open_ends is None else state.open_ends
    drawn = hard[:, None] & ~stand_open
    pressed = np.maximum(normal + 0.5 * strength.tension[:, None], 0.0)
    done = np.sum((pressed * np.abs(opening))[hard]) + np.sum(spare * np.abs(slip))
    closed = (pressed > CLOSED * equilibrium.unit_force) & hard[:, None]
    dissipated = strength.dissipation(forces, np.column_stack([opening, slip]), np.zeros_like(slip))
    return Validation(
        equilibrium=float(np.abs(equilibrium.row_scale * unbalanced).max() / equilibrium.total_weight),
        yield_excess=strength.excess(forces) / equilibrium.unit_force,
        flow=float(done / live),
        dilation=float(np.abs(opening[closed]).max(initial=0.0) / largest),
        backward=float((shear * slip).max(initial=0.0) / live),
        interpenetration=float((-opening[drawn]).max(initial=0.0) / largest),
        power=float(abs(loads @ u - dissipated) / live),
    )


def block_forces(assemblage: Assemblage, forces: FloatArray) -> FloatArray:
    """Resultants (n, 3) in N and N m about the centroids of what joint forces (k, 3) do to the blocks."""
    wall_forces, joints = np.zeros((len(assemblage.wall.blocks), 3)), assemblage.joints
    centroids = block_centroids(assemblage.wall)
    acting = (
        (joints.start, forces[:, :1] * joints.normal),
        (joints.end, forces[:, 1:2] * joints.normal),
        (joints.centroid, forces[:, 2:] * joints.tangent),
    )
    for block, sign in ((joints.j, 1.0), (joints.i, -1.0)):
        for point, force in acting:
            moment = cross(point - centroids[block], force)
            np.add.at(wall_forces, block, sign * np.column_stack([force, moment]))
    return wall_forces


def rates_at_joints(assemblage: Assemblage, velocities: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Openings (k, 2) at start and end and slips (k,) in m/s of blocks that move with velocities (n, 3)."""
    joints, centroids = assemblage.joints, block_centroids(assemblage.wall)
    sides = [
        [velocity_of_points(velocities[block], point - centroids[block]) for block in (joints.j, joints.i)]
        for point in (joints.start, joints.end)
    ]
    apart = [of_j - of_i for of_j, of_i in sides]
    opening = np.column_stack([np.sum(rate * joints.normal, axis=1) for rate in apart])
    return opening, np.sum(apart[0] * joints.tangent, axis=1)
