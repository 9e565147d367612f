"""Is this a limit state without dilation? Checked from geometry, forces and velocities alone: no matrix, no solver.

Every force is applied to its two blocks at its point (shear, under uniform torsion, nearer to the joint's centroid),
every rate is taken from the blocks' velocities there; only loads, friction and torsion factors are shared with the
programs that found the state. What has to hold at every point (Signorini, Coulomb):

    N >= 0,  v_N >= 0,  N v_N = 0,   |T| <= mu N,   T = -mu N v_T / |v_T| where it slides
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.limit_analysis.validation import beyond
from orchestrator.space.contacts import SpaceAssemblage
from orchestrator.space.equilibrium import Torsion, torsion_factors
from orchestrator.space.loads import SpaceLoads
from orchestrator.space.mechanism import corner_speeds, relative_velocities

LIMITS = {
    "equilibrium": 1e-8,
    "yield_excess": 1e-7,
    "flow": 1e-6,
    "interpenetration": 1e-6,
    "power": 1e-6,
}
"""Largest values that pass, whatever found the state; flow and power as in the plane."""


@dataclass(frozen=True, slots=True)
class Validation:
    """What a state does wrong; 0 is perfect.

    equilibrium: largest force out of balance (moments over a block's length) over the total weight. yield_excess:
    tension, or shear beyond friction, in mean block weights. interpenetration: largest closing of a point over the
    largest velocity of a block's corner. Relative to the live load's power: flow, what is done by points that open
    while loaded, or slide before they must or not against their shear; power, live + dead power less friction's.
    """

    equilibrium: float
    yield_excess: float
    flow: float
    interpenetration: float
    power: float

    @property
    def complaints(self) -> tuple[str, ...]:
        """What is wrong, in words; empty for a valid state."""
        return beyond(self, LIMITS)


def validate(
    assemblage: SpaceAssemblage,
    loads: SpaceLoads,
    multiplier: float,
    forces: FloatArray,
    velocities: FloatArray,
    torsion: Torsion = "corners",
) -> Validation:
    """Check forces (p, 3) in N (normal, two shears, on block j) with velocities (n, 6) of all blocks at unit live-load
    power, supports at rest."""
    wall, joints, of = assemblage.wall, assemblage.joints, assemblage.joints.joint
    sheared_at = joints.point
    if torsion == "uniform":
        factor = torsion_factors(joints)[of, None]
        sheared_at = (1.0 - factor) * joints.centroid[of] + factor * joints.point
    normal = joints.normal[of]
    pressure, shear = forces[:, :1] * normal, np.einsum("pk,pki->pi", forces[:, 1:], joints.tangents[of])
    opening = np.einsum("pi,pi->p", relative_velocities(assemblage, velocities, joints.point), normal)
    slip = relative_velocities(assemblage, velocities, sheared_at)
    slip -= np.einsum("pi,pi->p", slip, normal)[:, None] * normal
    limit = joints.friction[of] * np.maximum(forces[:, 0], 0.0)
    sliding, sheared = np.linalg.norm(slip, axis=1), np.linalg.norm(shear, axis=1)
    free = ~wall.fixed
    capacity = joints.capacity[of]
    yields = (forces[:, 0] > (1.0 - 1e-6) * capacity) & (opening < 0)  # a tie at its strength may lengthen
    live_power = float(np.sum(loads.live[free] * velocities[free]))
    dead_power = float(np.sum(loads.dead[free] * velocities[free]))
    dissipated = float(-np.einsum("pi,pi->p", shear, slip).sum() - (forces[:, 0] * opening)[yields].sum())
    scale = max(abs(multiplier), 1e-6) * abs(live_power)
    beyond_yield = (-forces[:, 0], sheared - limit, forces[:, 0] - capacity)
    misdirected = np.maximum(limit * sliding + np.einsum("pi,pi->p", shear, slip), 0.0)
    return Validation(
        equilibrium=_out_of_balance(assemblage, loads, multiplier, ((pressure, joints.point), (shear, sheared_at))),
        yield_excess=max(float(excess.max(initial=0.0)) for excess in beyond_yield) / float(wall.weights[free].mean()),
        flow=float(np.abs(forces[:, 0] * opening)[~yields].sum() + misdirected.sum()) / scale,
        interpenetration=float(-opening[~yields].min(initial=0.0)) / float(corner_speeds(assemblage, velocities).max()),
        power=abs(multiplier * live_power + dead_power - dissipated) / scale,
    )


def _out_of_balance(
    assemblage: SpaceAssemblage,
    loads: SpaceLoads,
    multiplier: float,
    forces: tuple[tuple[FloatArray, FloatArray], ...],
) -> float:
    """Return the largest force, or moment over a block's size, that is missing on a free block, over the total
    weight. forces: pairs of forces (p, 3) in N and where they act (p, 3)."""
    wall, joints = assemblage.wall, assemblage.joints
    centroids = wall.centroids
    total = loads.dead + multiplier * loads.live
    for sign, block in ((-1.0, joints.i[joints.joint]), (1.0, joints.j[joints.joint])):
        for force, place in forces:
            moment = np.cross(place - centroids[block], force)
            np.add.at(total, block, sign * np.hstack([force, moment]))
    free = ~wall.fixed
    sizes = np.array([block.shape.size for block in wall.blocks])[free]
    missing = max(np.abs(total[free, :3]).max(), (np.abs(total[free, 3:]) / sizes[:, None]).max())
    return float(missing / wall.weights[free].sum())
