"""Parts of a wall: what moves in a state, what it has of the loads, and what stands without the others."""

from __future__ import annotations

import numpy as np

from orchestrator.basis.arrays import BoolArray
from orchestrator.limit_analysis.gravity import falling_blocks, problem_of
from orchestrator.limit_analysis.paper.limit_state import LimitState
from orchestrator.limit_analysis.problem import Problem
from orchestrator.limit_analysis.search.what_is_left import part_of
from orchestrator.loads.block_loads import Loads
from orchestrator.loads.local_part import Shares, sizes, taking_part

MECHANISM_VELOCITY = 1e-3
"""Part of the largest velocity above which a stone belongs to a mechanism."""


def moving_share(
    problem: Problem, loads: Loads, state: LimitState, left: BoolArray
) -> tuple[BoolArray, Shares, Shares]:
    """Return the blocks left (n,) that move in a state, their shares of the loads, and those of what is not left."""
    moving = left & moves(problem, state)
    return moving, shares_of(problem, loads, moving), shares_of(problem, loads, ~left)


def shares_of(problem: Problem, loads: Loads, chosen: BoolArray) -> Shares:
    """Return the shares of the loads that chosen blocks (n,) have, supports none."""
    free = np.array([not block.fixed for block in problem.assemblage.wall.blocks])
    if not (chosen & free).any():
        return Shares()
    dead, live = np.where(free, -loads.dead[:, 1], 0.0), np.where(free, sizes(loads.live), 0.0)
    return taking_part(dead, live, (chosen & free).astype(float))


def ids_of(problem: Problem, chosen: BoolArray) -> tuple[int, ...]:
    """Return the ids of chosen blocks (n,), sorted."""
    return tuple(sorted(problem.assemblage.wall.blocks[i].id for i in np.flatnonzero(chosen)))


def moves(problem: Problem, state: LimitState) -> BoolArray:
    """Return the stones (n,) that belong to the mechanism of a state."""
    length = problem.equilibrium.block_length
    speed = np.abs(state.mechanism.velocities * [1.0, 1.0, length]).max(axis=1)
    moving: BoolArray = speed > MECHANISM_VELOCITY * speed.max()
    return moving


def standing_of(problem: Problem, loads: Loads, left: BoolArray) -> tuple[Problem, BoolArray] | None:
    """Return the problem of the blocks left (n,) less those that fall without the others, and which blocks those are.

    None where all of them fall, or all that carry live load.
    """
    if left.all():
        return problem, left
    free = np.array([not block.fixed for block in problem.assemblage.wall.blocks])
    while loads.live[left & free].any():
        part = problem_of(part_of(problem.assemblage, left), loads.of_blocks(left), problem.elastic_modulus)
        missing, falling = falling_blocks(part)
        if not missing:
            return part, left
        falls = np.zeros_like(left)
        falls[np.flatnonzero(left)[falling]] = True
        left = left & ~falls
    return None
