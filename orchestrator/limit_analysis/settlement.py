"""Settlement of a support as the live load: the mechanism in which it gives way, and what it still carries.

A support that may move along one direction d gets that one row in Eq. (1). With f_L = d there, lambda is minus the
reaction R with which it resists, so that the greatest lambda is the least reaction; in the mechanism (f_L . u = 1) the
support moves by d. Least energy of the dead load among all mechanisms compatible with the settlement is the dual of
this program: Heyman's least thrust where the supports of an arch spread. Source: Heyman 1966, The stone skeleton.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from orchestrator.basis.arrays import read_only
from orchestrator.basis.errors import CaseError
from orchestrator.basis.printed import few
from orchestrator.limit_analysis.gravity import GRAVITY_TOLERANCE
from orchestrator.limit_analysis.paper.equilibrium import Equilibrium, assemble_equilibrium, equilibrium_matrix
from orchestrator.limit_analysis.paper.limit_state import LimitState, LinearProgramRecord
from orchestrator.limit_analysis.paper.linear_program import solve_limit_lp
from orchestrator.limit_analysis.paper.yield_conditions import coulomb
from orchestrator.limit_analysis.problem import Problem
from orchestrator.loads.block_loads import Loads
from orchestrator.masonry.joints import Assemblage


def settlement_equilibrium(
    assemblage: Assemblage, support: int, angle: float, loads: Loads | None = None
) -> Equilibrium:
    """Return Eq. (1) for the support with the id `support` giving way at `angle` (rad from +x, counter-clockwise).

    Its multiplier is minus the reaction in N. The support counts as a free block that can move along d only.
    Raises CaseError when there is no such support.
    """
    position = next((n for n, b in enumerate(assemblage.wall.blocks) if b.id == support and b.fixed), None)
    if position is None:
        supports = few([block.id for block in assemblage.wall.blocks if block.fixed])
        raise CaseError("settlement.support", f"block {support} is not a support", f"supports are {supports}")
    standing = assemble_equilibrium(assemblage, loads)
    free = np.sort(np.append(standing.free_blocks, position))
    row = 3 * int(np.searchsorted(free, position))
    direction = np.array([np.cos(angle), np.sin(angle), 0.0])
    along = sp.identity(3 * len(free), format="lil")
    along[row : row + 3, row : row + 3] = np.outer(direction, direction)
    live = np.zeros(3 * len(free))
    live[row : row + 3] = direction
    dead = np.insert(standing.dead_load, row, np.zeros(3))
    return replace(
        standing,
        matrix=(along @ equilibrium_matrix(assemblage, free)).tocsc(),
        dead_load=read_only(dead),
        live_load=read_only(live),
        free_blocks=read_only(free, np.int64),
        moments_turned=None,
    )


def settle(assemblage: Assemblage, support: int, angle: float, loads: Loads | None = None) -> LimitState:
    """Return the associative state in which a support gives way (see `settlement_equilibrium`): multiplier -R in N.

    Raises CaseError for a support that is none, ConvergenceError when the wall cannot stand whatever the support does.
    """
    equilibrium = settlement_equilibrium(assemblage, support, angle, loads)
    problem = Problem(assemblage, equilibrium, coulomb(assemblage))
    solution = solve_limit_lp(problem.equilibrium, problem.friction)
    if abs(solution.load_multiplier) < GRAVITY_TOLERANCE * equilibrium.unit_force:  # the support is not needed
        solution = replace(solution, load_multiplier=0.0)
    d = problem.equilibrium.live_load
    u = np.where(
        np.repeat(d.reshape(-1, 3).any(axis=1), 3), d, solution.velocities
    )  # rows without forces tell no motion
    record = LinearProgramRecord(solution.load_multiplier, 0.0, solution.iterations, solution.seconds, solution.status)
    return problem.state("associative", problem.friction.slope, solution, replace(solution, velocities=u), (record,))
