"""Stones that nothing but a wedge holds: they go down under the dead load of a wall that is loaded from nothing."""

from __future__ import annotations

import numpy as np

from orchestrator.limit_analysis.gravity import problem_of
from orchestrator.limit_analysis.paper.sequence import LimitAnalysisSettings
from orchestrator.limit_analysis.problem import Problem
from orchestrator.limit_analysis.search.elastic_contact import STIFFNESSES
from orchestrator.limit_analysis.search.loading import has_path
from orchestrator.limit_analysis.search.loading_path import StateSearch, going_down
from orchestrator.limit_analysis.search.moving_parts import standing_of
from orchestrator.limit_analysis.standard_view import standard_view
from orchestrator.loads.block_loads import Loads
from orchestrator.masonry.block_properties import ELASTIC_MODULUS
from orchestrator.masonry.joints import Assemblage


def all_going_down(problem: Problem, loads: Loads) -> tuple[int, ...]:
    """Return the ids of the blocks that go down under the dead load, one after the other, until what is left rests with
    joints of either stiffness; loads: of the problem's assemblage."""
    blocks = problem.assemblage.wall.blocks
    left, ids = np.ones(len(blocks), dtype=bool), set[int]()
    while (standing := standing_of(problem, loads, left)) is not None:
        part, left = standing
        down, *others = (going_down(StateSearch(part, stiffness))[0] for stiffness in STIFFNESSES)
        if not (down and all(others)):
            break
        ids |= set(down)
        left = left & ~np.isin([block.id for block in blocks], down)
    return tuple(sorted(ids))


def stones_in_wedges(
    assemblage: Assemblage, loads: Loads, settings: LimitAnalysisSettings, elastic_modulus: float = ELASTIC_MODULUS
) -> tuple[int, ...]:
    """Return the same of a wall that `analyse` loads from gravity, none of another; elastic_modulus as there."""
    view = standard_view(assemblage, loads)
    problem = problem_of(view.assemblage, view.loads, elastic_modulus)
    if not has_path(problem.friction) or len(problem.equilibrium.free_blocks) > settings.path_blocks:
        return ()
    return all_going_down(problem, view.loads)
