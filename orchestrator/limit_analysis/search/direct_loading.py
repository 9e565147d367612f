"""How far a wall rests on the way to a state that is known, asked from gravity in a few large steps.

The state itself depends on small steps in its third or fourth digit; whether there is a rest one per cent below it does
not.
"""

from __future__ import annotations

import numpy as np

from orchestrator.basis.arrays import read_only
from orchestrator.limit_analysis.paper.limit_state import LimitState
from orchestrator.limit_analysis.problem import Problem
from orchestrator.limit_analysis.search.elastic_contact import Position, elastic_wall, joint_forces
from orchestrator.limit_analysis.search.loading_path import LoadPath
from orchestrator.limit_analysis.search.overdamped import Overdamped

TOWARDS = (0.5, 0.9, 1.0)
"""Loads at which a rest is asked for, parts of the last."""
DRAG = 1e-5
"""Drag of these few steps."""
PATIENCE = 800
"""Their factorisations at most."""
BUDGET = 350_000
"""Factorisations times blocks that are spent on the way to a state that is known: about what the state itself took
(997 blocks, 3.5 s)."""
WORTH = 80
"""Fewest factorisations that lead anywhere: gravity and one load."""


def as_far_as(problem: Problem, multiplier: float, state: LimitState) -> LoadPath:
    """Return the rests towards a state that is known already, up to a multiplier just below it, as far as BUDGET goes.

    With no rest at all, not even under the dead load, where that would be a handful of steps only.
    """
    loading = Overdamped(
        elastic_wall(problem.assemblage, problem.equilibrium, problem.friction, elastic_modulus=problem.elastic_modulus)
    )
    loading.most, scale = BUDGET // len(problem.equilibrium.free_blocks), loading.wall.problem.per_multiplier
    rests = _rests(loading, multiplier) if loading.most >= WORTH else []
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
        forces=tuple(
            read_only(problem.equilibrium.unit_force * joint_forces(loading.wall.points, position.forces))
            for position in rests
        ),
        state=state,
        factorisations=loading.spent,
        seconds=0.0,
        not_at_rest=float(asked[len(rests)]) if lost else np.inf,
        given_up=not lost and len(rests) < len(asked),
    )


def _rests(loading: Overdamped, multiplier: float) -> list[Position]:
    """Return the positions of rest under the dead load and at parts of a multiplier, up to the first without."""
    scale = loading.wall.problem.per_multiplier
    stands = loading.gravity()
    rests = [stands.position] if stands.rests else []
    for part in TOWARDS if rests else ():
        found = loading.rest(rests[-1], scale * part * multiplier, DRAG, PATIENCE)
        if not found.rests:
            break
        rests.append(found.position)
        if part == TOWARDS[0]:
            loading.elastic = loading.moved(found.position) / (scale * part * multiplier)
    return rests
