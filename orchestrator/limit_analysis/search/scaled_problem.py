"""One wall's terms of Eq. (1) in numbers near 1, and what all its stiffness matrices have in common."""

from __future__ import annotations

from dataclasses import dataclass

import scipy.sparse as sp

from orchestrator.basis.arrays import FloatArray
from orchestrator.limit_analysis.paper.equilibrium import Equilibrium
from orchestrator.limit_analysis.paper.yield_conditions import YieldConditions
from orchestrator.limit_analysis.search.wall_stiffness import WallStiffness


@dataclass(frozen=True, eq=False, slots=True)
class ScaledProblem:
    """Forces over the mean block weight, moments over a block length, lambda times `per_multiplier`.

    live (3m,): the live load over the sum of its magnitudes. stiffness: what the matrices of all linear systems have in
    common.
    """

    B: sp.csr_matrix
    B_T: sp.csr_matrix
    dead: FloatArray
    live: FloatArray
    friction: FloatArray
    cohesion: FloatArray
    stiffness: WallStiffness
    per_multiplier: float
    """live load at a multiplier of 1, mean block weights"""


def scaled_problem(equilibrium: Equilibrium, coulomb: YieldConditions) -> ScaledProblem:
    """Scale the problem of a wall whose joints have friction and cohesion."""
    scale, w = equilibrium.row_scale, equilibrium.unit_force
    B = (sp.diags(scale) @ equilibrium.matrix).tocsr()
    return ScaledProblem(
        B=B,
        B_T=B.T.tocsr(),
        dead=scale * equilibrium.dead_load / w,
        live=scale * equilibrium.live_load / equilibrium.live_total,
        friction=coulomb.slope,
        cohesion=coulomb.cohesion / w,
        stiffness=WallStiffness(B),
        per_multiplier=equilibrium.live_total / w,
    )
