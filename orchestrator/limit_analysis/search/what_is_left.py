"""A wall without stones that have fallen: its blocks and joints, its states as ones of the whole wall, its bound."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from orchestrator.basis.arrays import BoolArray, FloatArray, read_only
from orchestrator.basis.errors import CaseError, ConvergenceError
from orchestrator.limit_analysis.gravity import associative_optimum, problem_of
from orchestrator.limit_analysis.paper.limit_state import LimitState
from orchestrator.loads.block_loads import Loads
from orchestrator.masonry.joints import Assemblage

Scalar = TypeVar("Scalar", bound=np.generic)


def part_of(assemblage: Assemblage, left: BoolArray) -> Assemblage:
    """Return the assemblage of the blocks left (n,) and the joints between them."""
    joints, number = assemblage.joints.part(joints_left(assemblage, left)), np.cumsum(left) - 1
    blocks = tuple(b for b, k in zip(assemblage.wall.blocks, left, strict=True) if k)
    i, j = (read_only(number[side], np.int64) for side in (joints.i, joints.j))
    return Assemblage(replace(assemblage.wall, blocks=blocks), replace(joints, i=i, j=j))


def joints_left(assemblage: Assemblage, left: BoolArray) -> BoolArray:
    """Return the joints (k,) between blocks that are left (n,)."""
    joints: BoolArray = left[assemblage.joints.i] & left[assemblage.joints.j]
    return joints


def of_whole(state: LimitState, whole: Assemblage, left: BoolArray) -> LimitState:
    """Return a state of the blocks left (n,) with the arrays of the whole wall, zeros elsewhere."""
    if left.all():
        return state
    joints = joints_left(whole, left)

    def spread(values: npt.NDArray[Scalar], chosen: BoolArray) -> FloatArray:
        everywhere = np.zeros((len(chosen), *values.shape[1:]))
        everywhere[chosen] = values
        return read_only(everywhere)

    velocities = spread(state.mechanism.velocities, left)
    mechanism = replace(
        state.mechanism,
        velocities=velocities,
        opening=spread(state.mechanism.opening, joints),
        slip=spread(state.mechanism.slip, joints),
    )
    open_ends = None if state.open_ends is None else read_only(spread(state.open_ends, joints), np.bool_)
    return replace(state, mechanism=mechanism, joint_forces=spread(state.joint_forces, joints), open_ends=open_ends)


def bound_of_what_is_left(assemblage: Assemblage, loads: Loads, left: BoolArray) -> float | None:
    """Return the associative multiplier of the blocks that are left (n,), where they were drawn, under their own loads.

    None where nothing bounds it, or it is not found: what is left is wedged between supports, or does not stand.
    """
    problem = problem_of(part_of(assemblage, left), loads.of_blocks(left))
    try:
        return associative_optimum(problem).load_multiplier
    except (CaseError, ConvergenceError):
        return None
