"""Whether a wall rests at a multiplier, asked from gravity in a few large steps: the path to a state is not walked.

The state itself depends on the path's small steps in its third or fourth digit; whether there is a rest one per cent
below it, and none one per cent above, does not.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from orchestrator.basis.arrays import read_only
from orchestrator.limit_analysis.paper.limit_state import LimitState
from orchestrator.limit_analysis.problem import Problem
from orchestrator.limit_analysis.search.elastic_contact import ElasticWall, Position, elastic_wall, joint_forces
from orchestrator.limit_analysis.search.loading_path import LoadPath
from orchestrator.limit_analysis.search.overdamped import REST_BUDGET, Overdamped

PARTS, TOWARDS, DRAG, PATIENCE = (0.25, 0.5, 0.75, 1.0), (0.5, 0.9, 1.0), 1e-5, 2 * REST_BUDGET
"""Loads at which a rest is asked for, parts of the last: with joints of another stiffness, and towards a state that is
known; the drag of these few steps, and their factorisations at most."""
BUDGET, WORTH = 350_000, 80
"""Factorisations times blocks that are spent on the way to a state that is known: about what the state itself took
(997 blocks, 3.5 s); and fewest factorisations that lead anywhere, gravity and one load."""


def agrees(wall: ElasticWall, low: float, high: float) -> bool:
    """Whether a wall rests at a multiplier, loaded up to it in PARTS of it, and no longer at a higher one.

    On doubt the answer is no.
    """
    loading = Overdamped(wall)
    rests = _rests(loading, low, PARTS) if low > 0 else []
    if len(rests) <= len(PARTS):
        return False
    scale = loading.wall.problem.per_multiplier
    return not loading.rest(rests[-1], scale * high, DRAG, PATIENCE).rests


def as_far_as(problem: Problem, multiplier: float, state: LimitState) -> LoadPath:
    """Return the rests towards a state that is known already, up to a multiplier just below it, as far as BUDGET goes.

    With no rest at all, not even under the dead load, where that would be a handful of steps only.
    """
    loading = Overdamped(elastic_wall(problem.assemblage, problem.equilibrium, problem.friction))
    loading.most, scale = BUDGET // len(problem.equilibrium.free_blocks), loading.wall.problem.per_multiplier
    rests = _rests(loading, multiplier, TOWARDS) if loading.most >= WORTH else []
    asked = multiplier * np.append(0.0, TOWARDS)
    reached = asked[: max(len(rests), 1)]
    moved = [
        loading.moved(position) / (scale * loading.elastic * load)
        for load, position in zip(reached[1:], rests[1:], strict=True)
    ]
    lost = 0 < len(rests) < len(asked) and not loading.is_spent
    return LoadPath(
        multipliers=read_only(reached),
        displacements=read_only([1.0, *moved]),
        forces=tuple(read_only(problem.equilibrium.mean_weight * joint_forces(position.forces)) for position in rests),
        state=state,
        factorisations=loading.spent,
        seconds=0.0,
        not_at_rest=float(asked[len(rests)]) if lost else np.inf,
        given_up=not lost and len(rests) < len(asked),
    )


def _rests(loading: Overdamped, multiplier: float, parts: Sequence[float]) -> list[Position]:
    """Return the positions of rest under the dead load and at parts of a multiplier, up to the first without."""
    scale = loading.wall.problem.per_multiplier
    stands = loading.gravity()
    rests = [stands.position] if stands.rests else []
    for part in parts if rests else ():
        found = loading.rest(rests[-1], scale * part * multiplier, DRAG, PATIENCE)
        if not found.rests:
            break
        rests.append(found.position)
        if part == parts[0]:
            loading.elastic = loading.moved(found.position) / (scale * part * multiplier)
    return rests
