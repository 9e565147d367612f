"""The associative optimum of a wall in space, and the refusal of a load that nothing resists."""

from __future__ import annotations

from math import inf, isfinite

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.errors import CaseError
from orchestrator.limit_analysis.gravity import is_held
from orchestrator.limit_analysis.paper.linear_program import UnboundedError
from orchestrator.space.conic_program import TOLERANCE, ConicSolution, solve_associative
from orchestrator.space.equilibrium import SpaceEquilibrium

ROUGH = 1e-6
"""tolerance of a multiplier that is only compared with another one"""


class UnresistedError(CaseError):
    """No load in this direction, however large, moves the wall."""


def associative_optimum(
    equilibrium: SpaceEquilibrium, other_torsion: float = inf, tolerance: float = TOLERANCE
) -> ConicSolution:
    """Return the associative optimum. Raises UnresistedError for a load that nothing resists, but for rounding of its
    direction or the drawing; other_torsion: the multiplier with the other torsion, which the error then tells."""
    try:
        optimum = solve_associative(equilibrium, tolerance=tolerance)
    except UnboundedError:
        raise _unresisted(equilibrium, other_torsion) from None
    if is_held(equilibrium.live_load, optimum.velocities, dimension=3):
        raise _unresisted(equilibrium, other_torsion)
    return optimum


def moves(equilibrium: SpaceEquilibrium, velocities: FloatArray) -> bool:
    """Return whether a load moves a wall by a mechanism with velocities (n, 6) of all blocks, but for rounding of its
    direction or the drawing."""
    return not is_held(equilibrium.live_load, velocities[equilibrium.free_blocks], dimension=3)


def multiplier_or_held(equilibrium: SpaceEquilibrium) -> float:
    """Return the associative multiplier to ROUGH, infinite for a load that nothing resists."""
    try:
        return associative_optimum(equilibrium, tolerance=ROUGH).load_multiplier
    except UnresistedError:
        return inf


def _unresisted(equilibrium: SpaceEquilibrium, other_torsion: float) -> UnresistedError:
    remedy = "push in another direction, or free the blocks that hold it"
    if isfinite(other_torsion):
        twist = "as under uniform pressure" if equilibrium.torsion == "corners" else "by forces at their corners"
        remedy = f"set limit_analysis.torsion: joints that twist {twist} reach no more than λ = {other_torsion:.4f}"
    return UnresistedError("load.direction", "no load in this direction, however large, moves the wall", remedy)
