"""Weights in words: of the blocks, with floors or another extra dead load, and which of them λ multiplies.

Floors are extra dead loads that λ multiplies (`inertia`); a force on a stone that has no mass is not called one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from orchestrator.basis.printed import printed
from orchestrator.limit_analysis import LimitAnalysis
from orchestrator.loads.block_loads import Distribution
from orchestrator.settings.inventory import LoadSums
from orchestrator.storage.summary import WallSummary

ROUNDING = 1e-6
"""part by which weights differ that are the same"""


@dataclass(frozen=True, slots=True)
class Sums:
    """Weight of the blocks, all vertical load, and the horizontal load at λ = 1, N."""

    weight: float
    vertical_load: float
    horizontal_load: float


Weighed: TypeAlias = LimitAnalysis | LoadSums | Sums | WallSummary
"""what has these sums"""


def multiplier_words(sums: Weighed) -> str:
    """Return what λ is and the weights, in one line."""
    return f"λ = base shear / {multiplied(sums)}; {weight_words(sums)}"


def weight_words(sums: Weighed) -> str:
    """Return the weight of the blocks, with what lies on them, and the base shear at λ = 1 where it is neither the one
    nor the other: loads without mass, an inclined live load, given forces; of an upright live load its size."""
    said = f"weight {printed('weight', sums.weight)} kN"
    if carried := carried_words(sums):
        blocks, whole = printed("weight", sums.weight), printed("weight", sums.vertical_load)
        said = f"weight of the blocks {blocks} kN, with {carried} {whole} kN"
    if (upright := upright_load(sums)) is not None:
        said += f", live load {printed('weight', abs(upright))} kN {way_of(upright)} at λ = 1"
    elif not _same(sums.horizontal_load, sums.vertical_load):
        said += f", base shear {printed('weight', sums.horizontal_load)} kN at λ = 1"
    return said


def multiplied(sums: Weighed) -> str:
    """Return what base shear is a multiple of: a weight, with floors or of the blocks, or the horizontal live load."""
    if _same(sums.horizontal_load, sums.vertical_load):
        return f"weight with {carried}" if (carried := carried_words(sums)) else "weight"
    return "weight of the blocks" if _same(sums.horizontal_load, sums.weight) else "horizontal live load"


def upright_load(sums: Weighed) -> float | None:
    """Return the vertical live load at λ = 1 in N, upwards, where none of it is horizontal and the sums tell it."""
    return sums.upright_load if isinstance(sums, LimitAnalysis | LoadSums) else None


def way_of(force: float) -> str:
    """Return which way a vertical force points that is positive upwards."""
    return "upwards" if force > 0.0 else "downwards"


def applied_words(load_multiplier: float, horizontal_load: float, upright_load: float | None) -> str:
    """Return what is applied at a multiplier: a base shear or, where there is none, the upright live load; both loads
    in N, at a multiplier of 1."""
    return " ".join(applied(load_multiplier, horizontal_load, upright_load))


def applied(load_multiplier: float, horizontal_load: float, upright_load: float | None) -> tuple[str, str]:
    """Return the same as its name and its size."""
    if upright_load is None:
        return "base shear", f"{printed('force', load_multiplier * horizontal_load)} kN"
    return "live load", f"{printed('force', load_multiplier * abs(upright_load))} kN {way_of(upright_load)}"


def load_words(distribution: Distribution, sums: Weighed) -> str:
    """Return the live load as an arrow names it, as in "λ × weight with floors × height"."""
    what = multiplied(sums)
    if distribution == "per_block" or "weight" not in what:
        return "λ × live load"
    return f"λ × {what}" + " × height" * (distribution == "mass_height")


def carried_words(sums: Weighed) -> str:
    """Return what the wall carries beside its blocks: "floors" where the live load acts on them, too, or ""."""
    if _same(sums.vertical_load, sums.weight):
        return ""
    return "floors" if _same(sums.horizontal_load, sums.vertical_load) else "extra dead load"


def _same(one: float, other: float) -> bool:
    return abs(one - other) <= ROUNDING * abs(other)
