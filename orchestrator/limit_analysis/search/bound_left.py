"""The associative multiplier of what stones leave of a wall when they have fallen."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from orchestrator.basis.errors import CaseError, ConvergenceError
from orchestrator.limit_analysis.gravity import associative_optimum
from orchestrator.limit_analysis.paper.equilibrium import assemble_equilibrium
from orchestrator.limit_analysis.paper.yield_conditions import coulomb
from orchestrator.limit_analysis.problem import Problem
from orchestrator.limit_analysis.search.loading import part_of
from orchestrator.loads.block_loads import Loads
from orchestrator.masonry.joints import Assemblage


def bound_of_what_is_left(assemblage: Assemblage, loads: Loads, left: npt.NDArray[np.bool_]) -> float | None:
    """Return the associative multiplier of the blocks that are left (n,), where they were drawn, under their own loads.

    None where nothing bounds it, or it is not found: what is left is wedged between supports, or does not stand.
    """
    part = part_of(assemblage, left)
    equilibrium = assemble_equilibrium(part, loads.of_blocks(left))
    problem = Problem(part, equilibrium, coulomb(part))
    try:
        return associative_optimum(problem).load_multiplier
    except (CaseError, ConvergenceError):
        return None
