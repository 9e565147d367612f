"""Whether a wall in space stands under its dead load: joint forces that carry it, and rest without a prestress."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.errors import CaseError
from orchestrator.limit_analysis.paper.linear_program import InfeasibleError
from orchestrator.space.conic_program import gravity_forces, missing_support
from orchestrator.space.contacts import SpaceAssemblage
from orchestrator.space.elastic_joints import going_down
from orchestrator.space.equilibrium import SpaceEquilibrium

LISTED = 10
"""blocks that a message names"""


def listed(ids: tuple[int, ...]) -> str:
    """Return the first LISTED ids in words."""
    return ", ".join(map(str, ids[:LISTED])) + ", ..." * (len(ids) > LISTED)


def forces_under_gravity(
    assemblage: SpaceAssemblage, equilibrium: SpaceEquilibrium, stiffness: FloatArray
) -> FloatArray:
    """Return the forces of the wall under its dead load. Raises CaseError naming the blocks that would fall."""
    try:
        return gravity_forces(equilibrium, stiffness)
    except InfeasibleError:
        _, motion = missing_support(equilibrium)
    ids = _fastest(assemblage, equilibrium, motion)
    would = f"block{'s' * (len(ids) > 1)} {listed(ids)} would move"
    if _stands_unloaded(assemblage, equilibrium, stiffness):
        problem = f"the wall stands under its own weight, but not under this dead load too: {would}"
        raise CaseError("load.dead", problem, "lower the load, turn it, or support these blocks")
    problem = f"the wall cannot stand under its own weight: {would}"
    raise CaseError(f"block {ids[0]}", problem, "support them, raise the friction, or correct the joints")


def _stands_unloaded(assemblage: SpaceAssemblage, equilibrium: SpaceEquilibrium, stiffness: FloatArray) -> bool:
    """Return whether joint forces carry the blocks' own weight, where that is not all of the dead load."""
    wall, weight = assemblage.wall, np.zeros((len(equilibrium.free_blocks), 6))
    weight[:, :3] = -np.outer(wall.weights[equilibrium.free_blocks], wall.up)
    if np.array_equal(weight.ravel(), equilibrium.dead_load):
        return False
    try:
        gravity_forces(replace(equilibrium, dead_load=weight.ravel()), stiffness)
    except InfeasibleError:
        return False
    return True


def falling_blocks(
    assemblage: SpaceAssemblage, equilibrium: SpaceEquilibrium, gravity: FloatArray, stiffness: FloatArray
) -> tuple[int, ...]:
    """Return the ids of the blocks that go down under the dead load where the wall does not come to rest."""
    motion = going_down(assemblage, equilibrium, gravity, stiffness)
    return () if motion is None else _fastest(assemblage, equilibrium, motion)


def _fastest(assemblage: SpaceAssemblage, equilibrium: SpaceEquilibrium, motion: FloatArray) -> tuple[int, ...]:
    """Return the ids of the free blocks that have a tenth of the largest velocity of a motion (m, 6), or more."""
    speed = np.linalg.norm(motion[:, :3], axis=1)
    return tuple(assemblage.wall.blocks[k].id for k in equilibrium.free_blocks[speed > 0.1 * speed.max()])
