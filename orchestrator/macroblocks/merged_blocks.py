"""Limit analysis of macroblocks as rigid bodies: Eq. (1) with blocks held together.

Blocks of one body move as one, u_blocks = T u_bodies, with T the rigid motion of each block about its body's centre of
gravity. Equilibrium of the bodies is then T^T B q - lambda T^T f_L = T^T f_D, and joints inside a body are gone.
Fewer mechanisms are possible: the associative multiplier can only grow (kinematic theorem), by nothing if the blocks
moved as one already. How much it grows is what merging costs, for a few milliseconds and without any finite element.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
import scipy.sparse as sp

from orchestrator.basis.arrays import IntArray, read_only
from orchestrator.basis.errors import ConvergenceError
from orchestrator.limit_analysis.paper.equilibrium import Equilibrium, assemble_equilibrium, block_centroids
from orchestrator.limit_analysis.paper.linear_program import solve_limit_lp
from orchestrator.limit_analysis.paper.sequence import LimitAnalysisSettings, run_sequence
from orchestrator.limit_analysis.paper.yield_conditions import YieldConditions, coulomb
from orchestrator.loads.block_loads import Loads
from orchestrator.masonry.joints import Assemblage


def merged_multiplier(
    assemblage: Assemblage,
    body_of_block: IntArray,
    flow_rule: Literal["associative", "sequence"],
    loads: Loads | None = None,
) -> float | None:
    """Return the load multiplier of blocks held together, by the same rule as the micro analysis it is compared with.

    body_of_block (n,) as in Partition; supports are bodies of their own. None where no solution is found.
    """
    equilibrium, friction = merged_problem(assemblage, body_of_block, loads)
    try:
        optimum = solve_limit_lp(equilibrium, friction)
        if flow_rule == "associative":
            return optimum.load_multiplier
        return run_sequence(equilibrium, friction, optimum, LimitAnalysisSettings())[1].load_multiplier
    except ConvergenceError:
        return None


def merged_problem(
    assemblage: Assemblage, body_of_block: IntArray, loads: Loads | None = None
) -> tuple[Equilibrium, YieldConditions]:
    """Return equilibrium of the bodies and the strength of the joints that remain between them."""
    of_blocks = assemble_equilibrium(assemblage, loads)
    remains = body_of_block[assemblage.joints.i] != body_of_block[assemblage.joints.j]
    T = rigid_motion(assemblage, of_blocks, body_of_block)
    bodies = T.shape[1] // 3
    equilibrium = Equilibrium(
        matrix=(T.T @ of_blocks.matrix)[:, np.repeat(remains, 3)].tocsc(),
        dead_load=read_only(T.T @ of_blocks.dead_load),
        live_load=read_only(T.T @ of_blocks.live_load),
        free_blocks=read_only(np.arange(bodies), np.int64),
        blocks=bodies,
        block_length=of_blocks.block_length * float(np.sqrt(len(of_blocks.free_blocks) / bodies)),
        unit_force=of_blocks.total_weight / bodies,
        total_weight=of_blocks.total_weight,
    )
    return equilibrium, coulomb(assemblage).of_joints(remains)


def rigid_motion(assemblage: Assemblage, equilibrium: Equilibrium, body_of_block: IntArray) -> sp.csr_matrix:
    """T (3m, 3b): velocities of the m free blocks from those of b bodies about their centres of gravity."""
    free = equilibrium.free_blocks
    _, body = np.unique(body_of_block[free], return_inverse=True)
    weight = -equilibrium.dead_load[1::3]
    position = block_centroids(assemblage.wall)[free]
    total = np.bincount(body, weight)
    centre = np.column_stack([np.bincount(body, weight * x) / total for x in position.T])
    arm = position - centre[body]
    u, one = 3 * np.arange(len(free)), np.ones(len(free))
    rows = np.concatenate([u, u + 1, u + 2, u, u + 1])
    columns = np.concatenate([3 * body, 3 * body + 1, 3 * body + 2, 3 * body + 2, 3 * body + 2])
    entries = np.concatenate([one, one, one, -arm[:, 1], arm[:, 0]])
    return sp.csr_matrix((entries, (rows, columns)), shape=(3 * len(free), 3 * len(total)))
