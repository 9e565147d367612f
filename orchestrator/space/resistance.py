"""The associative optimum of a wall in space, and the refusal of a load that nothing resists."""

from __future__ import annotations

from orchestrator.basis.errors import CaseError
from orchestrator.limit_analysis.gravity import is_held
from orchestrator.limit_analysis.paper.linear_program import UnboundedError
from orchestrator.space.conic_program import ConicSolution, solve_associative
from orchestrator.space.equilibrium import SpaceEquilibrium


class UnresistedError(CaseError):
    """No load in this direction, however large, moves the wall."""


def associative_optimum(equilibrium: SpaceEquilibrium) -> ConicSolution:
    """Return the associative optimum. Raises UnresistedError for a load that nothing resists, but for rounding of its
    direction or the drawing."""
    try:
        optimum = solve_associative(equilibrium)
    except UnboundedError:
        raise _unresisted() from None
    if is_held(equilibrium.live_load, optimum.velocities, dimension=3):
        raise _unresisted()
    return optimum


def _unresisted() -> UnresistedError:
    remedy = "push in another direction, or free the blocks that hold it"
    return UnresistedError("load.direction", "no load in this direction, however large, moves the wall", remedy)
