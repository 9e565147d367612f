"""How the multiplier of a mechanism falls as rigid blocks begin to move in it, without following them.

Blocks that turn by their rates of rotation w, exactly, while their centroids go on straight, part or meet at their
joints by g d^2 / 2 (moved_joints.py). What keeps pressed joints closed moves the blocks by as much, and the loads do
the work of the joint forces q in g. With the moments Q w^2 that loads have on blocks that turn, the derivative of the
virtual work of the mechanism is

    dlambda / dd = -(q . g + Q . w^2) / (work of the live load)

for rates per unit of the motion d. Forces are those of the beginning: what sliding joints bear more or less as the wall
moves is left out, and so are joints that leave the mechanism. Second-order work; own combination. Of a block on its
toe it is exact: -(1 + lambda^2) over the height of its centroid.
"""

from __future__ import annotations

import numpy as np

from orchestrator.limit_analysis.paper.equilibrium import assemble_equilibrium
from orchestrator.limit_analysis.paper.limit_state import LimitState
from orchestrator.limit_analysis.search.moved_joints import moved_joints
from orchestrator.loads.block_loads import Loads
from orchestrator.masonry.joints import Assemblage

DIFFERENCED = 1e-4
"""fastest motion, block lengths (turns times one), over which second differences are taken"""


def softening_slope(assemblage: Assemblage, loads: Loads, state: LimitState) -> float:
    """Return by how much the multiplier of a limit state changes per m of motion along the live load (1/m).

    Negative where it falls. The motion is that of the points of the live load, weighted by it. Forces of the state
    beyond the joints of the assemblage are not looked at.
    """
    equilibrium = assemble_equilibrium(assemblage, loads)
    velocities = state.mechanism.velocities
    rates = velocities[equilibrium.free_blocks] * state.live_total / (loads.live * velocities).sum()
    motion = (rates * [1.0, 1.0, equilibrium.block_length]).ravel()
    step = DIFFERENCED * equilibrium.block_length / np.abs(motion).max()
    joints = moved_joints(assemblage, equilibrium, np.array([0.0, 1.0]), 1.0)
    beginning, once, twice = (joints.rates(times * step * motion) for times in (0.0, 1.0, 2.0))
    parted = ((twice - 2.0 * once + beginning) / step**2).reshape(-1, 2, 2)  # joint, end, opening and slip
    normal, shear = np.split(state.joint_forces[: assemblage.joints.count], [2], axis=1)
    share = np.abs(normal) / np.maximum(np.abs(normal).sum(axis=1, keepdims=True), 1e-300)
    of_joints = (normal * parted[:, :, 0]).sum() + (shear * share * parted[:, :, 1]).sum()
    turned = loads.moments_turned[equilibrium.free_blocks] @ [1.0, state.load_multiplier]
    return -float(of_joints + turned @ rates[:, 2] ** 2) / state.live_total
