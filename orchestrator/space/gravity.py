"""Whether a wall in space stands under its dead load: joint forces that carry it, and rest without a prestress."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.limit_analysis.gravity import falls
from orchestrator.limit_analysis.paper.linear_program import InfeasibleError
from orchestrator.space.conic_program import gravity_forces, missing_support
from orchestrator.space.contacts import SpaceAssemblage
from orchestrator.space.elastic_joints import settled
from orchestrator.space.equilibrium import SpaceEquilibrium

LISTED = 10
"""blocks that a message names"""


def listed(ids: tuple[int, ...]) -> str:
    """Return the first LISTED ids in words."""
    return ", ".join(map(str, ids[:LISTED])) + ", ..." * (len(ids) > LISTED)


def forces_under_gravity(
    assemblage: SpaceAssemblage, equilibrium: SpaceEquilibrium, stiffness: FloatArray
) -> FloatArray:
    """Return the forces of the wall under its dead load. Raises FallsError naming the blocks that would fall."""
    try:
        return gravity_forces(equilibrium, stiffness)
    except InfeasibleError:
        alone = _of_weight_alone(assemblage, equilibrium)
    stands_alone = alone is not equilibrium and _stands(alone, stiffness)
    missing, motion = missing_support(equilibrium if stands_alone else alone)
    raise falls(fastest(assemblage, equilibrium, motion), missing, stands_alone, "lower, move or turn")


def _of_weight_alone(assemblage: SpaceAssemblage, equilibrium: SpaceEquilibrium) -> SpaceEquilibrium:
    """Return the equilibrium with the blocks' own weight as the dead load; itself, where that is all of it."""
    wall, weight = assemblage.wall, np.zeros((len(equilibrium.free_blocks), 6))
    weight[:, :3] = -np.outer(wall.weights[equilibrium.free_blocks], wall.up)
    if np.array_equal(weight.ravel(), equilibrium.dead_load):
        return equilibrium
    return replace(equilibrium, dead_load=read_only(weight.ravel()))


def _stands(equilibrium: SpaceEquilibrium, stiffness: FloatArray) -> bool:
    """Return whether joint forces carry the dead load."""
    try:
        gravity_forces(equilibrium, stiffness)
    except InfeasibleError:
        return False
    return True


def at_rest(
    assemblage: SpaceAssemblage, equilibrium: SpaceEquilibrium, gravity: FloatArray, stiffness: FloatArray
) -> tuple[FloatArray, tuple[int, ...]]:
    """Return the forces (p, 3) in N under the dead load from which a wall is pushed, without a prestress where it rests
    without, and the ids of the blocks that go down where it does not come to rest."""
    forces, motion = settled(assemblage, equilibrium, gravity, stiffness)
    return forces, () if motion is None else fastest(assemblage, equilibrium, motion)


def fastest(assemblage: SpaceAssemblage, equilibrium: SpaceEquilibrium, motion: FloatArray) -> tuple[int, ...]:
    """Return the ids of the free blocks that have a tenth of the largest velocity of a motion (m, 6), or more."""
    speed = np.linalg.norm(motion[:, :3], axis=1)
    return tuple(assemblage.wall.blocks[k].id for k in equilibrium.free_blocks[speed > 0.1 * speed.max()])
