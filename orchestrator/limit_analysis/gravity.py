"""What is asked of every wall first: whether it stands under its dead load, and whether a live load brings it down."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from orchestrator.basis.arrays import FloatArray, IntArray, read_only
from orchestrator.basis.errors import CaseError, FallsError
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
from orchestrator.masonry.block_properties import ELASTIC_MODULUS, block_weights
from orchestrator.masonry.joints import Assemblage

GRAVITY_TOLERANCE = 1e-6
"""missing force, in mean block weights, that passes in the gravity check as rounding of the drawing (polygons rounded
to 1e-6 m). What the solver leaves is far less at any size: see `solve_gravity_lp`"""
HELD_WORK = 1e-6
"""work of the live load in the mechanism, over that of forces and moments of its size along the mechanism, up to which
it is none but for rounding of the direction or the drawing: the load is held, and its multiplier is of rounding"""
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
    """Raise FallsError naming the blocks that fall when no joint forces carry the dead load alone."""
    missing, falling = falling_blocks(problem)
    if not missing:
        return
    alone, stands_alone = of_weight_alone(problem), False
    if alone is not problem:
        of_weight = falling_blocks(alone)
        stands_alone = not of_weight[0]
        missing, falling = (missing, falling) if stands_alone else of_weight
    ids = sorted(problem.assemblage.wall.blocks[i].id for i in falling)
    raise falls(ids, missing, stands_alone, "lower or move", bool(problem.friction.crushes.any()))


def refuse_the_verge(live_load: float, least: float, ids: Sequence[int] = ()) -> None:
    """Raise FallsError where all the live load (N) that a wall bears may be rounding of the drawing, or is none.

    least: what it has to be more than, N. ids: of the blocks that move then, where they are known.
    """
    if live_load > least:
        return
    why = "it bears a live load of less than a millionth of a block's weight"
    if ids:
        why = f"{_named(ids)} would move under next to no live load"
    text = f"is on the verge of collapse under its dead load: {why}"
    raise FallsError("wall", text, "give blocks more bearing, or check friction and which blocks are fixed")


def of_weight_alone(problem: Problem) -> Problem:
    """Return a problem with the blocks' own weight as its dead load; itself, where that is all of it."""
    equilibrium = problem.equilibrium
    weight = np.zeros((len(equilibrium.free_blocks), 3))
    weight[:, 1] = -block_weights(problem.assemblage.wall)[equilibrium.free_blocks]
    if np.array_equal(weight.ravel(), equilibrium.dead_load):
        return problem
    return replace(problem, equilibrium=replace(equilibrium, dead_load=read_only(weight.ravel())))


def falls(ids: Sequence[int], missing: float, stands_alone: bool, ways: str, crushes: bool = False) -> FallsError:
    """Return what is said of a wall, in the plane or in space, that does not stand.

    ids: of the blocks that move; missing: the force that would hold them, in mean block weights. stands_alone: whether
    the wall stands under the blocks' own weight, and not under what else is its dead load; ways: what can be done to
    that. crushes: whether joints do.
    """
    would = f"{_named(ids)} would move, unless held by a force of {missing:.2g} times the mean weight of a block"
    crush = "whether joints crush (compressive_strength)"
    if stands_alone:
        problem = f"the wall stands under its own weight, but not under this dead load too: {would}"
        remedy = f"{ways} the load, support these blocks, or check friction" + f" and {crush}" * crushes
        return FallsError("load.dead", problem, remedy)
    remedy = "support these blocks, give them more bearing, or check friction" + f", {crush}" * crushes
    return FallsError("wall", f"cannot stand under its own weight: {would}", f"{remedy} and which blocks are fixed")


def _named(ids: Sequence[int]) -> str:
    """Return the first NAMED_BLOCKS blocks in words."""
    more = f" and {len(ids) - NAMED_BLOCKS} more" * (len(ids) > NAMED_BLOCKS)
    return f"block{'s' * (len(ids) > 1)} {', '.join(map(str, ids[:NAMED_BLOCKS]))}{more}"


def associative_optimum(problem: Problem) -> LimitSolution:
    """Solve Eq. (1), turning what cannot be solved because of the wall into a CaseError."""
    try:
        optimum = solve_limit_lp(problem.equilibrium, problem.friction)
    except UnboundedError as error:
        raise _unresisted() from error
    except InfeasibleError as error:
        text = "cannot stand under its dead load: it lacks less than a millionth of a block's weight"
        raise FallsError("wall", text, "the drawing is on the verge of collapse; give blocks more bearing") from error
    if is_held(problem.equilibrium.live_load, optimum.velocities, dimension=2):
        raise _unresisted()
    return optimum


def _unresisted() -> CaseError:
    text = (
        "no live load in this direction brings it down while sliding dilates: the load presses it together, or blocks "
    )
    return CaseError("wall", f"{text}are wedged between supports", "check which blocks are fixed, or reverse the load")


def is_held(live_load: FloatArray, velocities: FloatArray, dimension: int) -> bool:
    """Return whether a live load does no work in a mechanism, up to HELD_WORK.

    Both have forces or velocities of every free block, and its moments or rates of rotation after them, in the plane
    (dimension 2) or in space (3).
    """
    load, motion = (all_blocks.reshape(-1, 3 * (dimension - 1)) for all_blocks in (live_load, velocities))
    at_most = sum(
        np.linalg.norm(load[:, part], axis=1) @ np.linalg.norm(motion[:, part], axis=1)
        for part in (slice(dimension), slice(dimension, None))
    )
    return bool(abs(float(np.sum(load * motion))) <= HELD_WORK * at_most)


def problem_of(assemblage: Assemblage, loads: Loads | None = None, elastic_modulus: float = ELASTIC_MODULUS) -> Problem:
    """Return what all linear programs of a wall share; without `loads` dead and live load are every block's weight."""
    return Problem(assemblage, assemble_equilibrium(assemblage, loads), coulomb(assemblage), elastic_modulus)


def refuse_what_cannot_be_analysed(assemblage: Assemblage, loads: Loads) -> LimitSolution:
    """Raise the CaseError that `analyse` would raise for this wall; return the associative optimum."""
    problem = problem_of(assemblage, loads)
    return side_by_side(lambda: refuse_what_falls(problem), lambda: associative_optimum(problem))[1]
