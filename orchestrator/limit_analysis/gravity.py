"""What is asked of every wall first: whether it stands under its dead load, and whether a live load brings it down."""

from __future__ import annotations

import numpy as np

from orchestrator.basis.arrays import IntArray
from orchestrator.basis.errors import CaseError
from orchestrator.limit_analysis.paper.equilibrium import assemble_equilibrium
from orchestrator.limit_analysis.paper.linear_program import (
    InfeasibleError,
    LimitSolution,
    UnboundedError,
    solve_gravity_lp,
    solve_limit_lp,
)
from orchestrator.limit_analysis.paper.yield_conditions import coulomb
from orchestrator.limit_analysis.problem import Problem
from orchestrator.limit_analysis.side_by_side import side_by_side
from orchestrator.loads.block_loads import Loads
from orchestrator.masonry.joints import Assemblage

GRAVITY_TOLERANCE = 1e-6
"""missing force, in mean block weights, that passes in the gravity check as rounding of the drawing (polygons rounded
to 1e-6 m). What the solver leaves is far less at any size: see `solve_gravity_lp`"""
FALLING_VELOCITY = 1e-3
"""velocity of a falling block, part of the bound that the gravity check sets to all"""
NAMED_BLOCKS = 8
"""how many falling blocks an error message names"""


def falling_blocks(problem: Problem) -> tuple[float, IntArray]:
    """Return the force that is missing to carry the dead load, in mean block weights, and the blocks that fall."""
    equilibrium = problem.equilibrium
    missing, velocities = solve_gravity_lp(equilibrium, problem.friction)
    if missing <= GRAVITY_TOLERANCE:
        return 0.0, np.zeros(0, np.int64)
    moves = np.abs(velocities / equilibrium.row_scale).reshape(-1, 3).max(axis=1) > FALLING_VELOCITY
    return missing, equilibrium.free_blocks[moves]


def refuse_what_falls(problem: Problem) -> None:
    """Raise CaseError naming the blocks that fall when no joint forces carry the dead load alone."""
    missing, falling = falling_blocks(problem)
    if not missing:
        return
    numbers = [str(number) for number in sorted(problem.assemblage.wall.blocks[i].id for i in falling)]
    named = ", ".join(numbers[:NAMED_BLOCKS])
    more = f" and {len(numbers) - NAMED_BLOCKS} more" if len(numbers) > NAMED_BLOCKS else ""
    crushes = ", whether its joints crush (compressive_strength)" * bool(problem.friction.crushes.any())
    raise CaseError(
        "wall",
        f"cannot stand under its own weight: blocks {named}{more} move, unless held by a force of {missing:.2g} times "
        "the mean weight of a block",
        f"support these blocks, give them more bearing, or check friction{crushes} and which blocks are fixed",
    )


def associative_optimum(problem: Problem) -> LimitSolution:
    """Solve Eq. (1), turning what cannot be solved because of the wall into a CaseError."""
    try:
        return solve_limit_lp(problem.equilibrium, problem.friction)
    except UnboundedError as error:
        text = "no live load in this direction brings it down while sliding dilates: blocks are wedged between supports"
        raise CaseError("wall", text, "check which blocks are fixed, or reverse the load") from error
    except InfeasibleError as error:
        text = "cannot stand under its own weight: it lacks less than a millionth of a block's weight"
        raise CaseError("wall", text, "the drawing is on the verge of collapse; give blocks more bearing") from error


def problem_of(assemblage: Assemblage, loads: Loads | None = None) -> Problem:
    """Return what all linear programs of a wall share; without `loads` dead and live load are every block's weight."""
    equilibrium = assemble_equilibrium(assemblage, loads)
    return Problem(assemblage, equilibrium, coulomb(assemblage))


def refuse_what_cannot_be_analysed(assemblage: Assemblage, loads: Loads) -> LimitSolution:
    """Raise the CaseError that `analyse` would raise for this wall; return the associative optimum."""
    problem = problem_of(assemblage, loads)
    return side_by_side(lambda: refuse_what_falls(problem), lambda: associative_optimum(problem))[1]
