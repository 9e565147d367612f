"""Whether a wall stands while its ties are tightened, by which its collapse multiplier does not change (ties.py)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from orchestrator.basis.arrays import read_only
from orchestrator.basis.errors import CaseError
from orchestrator.basis.printed import counted
from orchestrator.geometry.rigid import cross
from orchestrator.limit_analysis.gravity import falling_blocks, problem_of
from orchestrator.loads.block_loads import Loads
from orchestrator.masonry.block_properties import block_centroids
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.ties import ANCHOR, Tie, ends_of, with_ties


def refuse_what_pretension_moves(
    assemblage: Assemblage, loads: Loads, ties: Sequence[Tie], settling: int | None = None
) -> None:
    """Raise CaseError (key only) for a wall that stands with its ties, but not while they pull with their pretension.

    A tie that is tightened may pull more, and does not push. settling: of `with_ties`.
    """
    tied = with_ties(assemblage, [replace(tie, pushes=tie.pushes and not tie.pretension) for tie in ties], settling)
    if not any(tie.pretension for tie in ties) or len(falling_blocks(problem_of(tied, loads))[1]):
        return
    moved = falling_blocks(problem_of(tied, tightened(tied, loads, ties)))[1]
    if len(moved):
        first, more = tied.wall.blocks[moved[0]].id, f" and {counted(len(moved) - 1, 'more block')}" * (len(moved) > 1)
        problem = f"their pretension moves block {first}{more}, before there is any live load"
        raise CaseError("reinforcement.ties", problem, "lower pretension, or tie what it pulls to something else")


def tightened(tied: Assemblage, loads: Loads, ties: Sequence[Tie]) -> Loads:
    """Return the loads with the pretension of ties, which pulls both ends of each to each other, as dead load."""
    dead, centroids = loads.dead.copy(), block_centroids(tied.wall)
    for tie, blocks in zip(ties, ends_of(tied.wall, ties).tolist(), strict=True):
        start, end = np.array(tie.start), np.array(tie.end)
        pull = tie.pretension * (end - start) / np.linalg.norm(end - start)
        for block, point, force in zip(blocks, (start, end), (pull, -pull), strict=True):
            if block != ANCHOR:
                dead[block] += [*force, cross(point - centroids[block], force)]
    return replace(loads, dead=read_only(dead))
