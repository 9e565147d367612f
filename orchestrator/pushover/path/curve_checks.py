"""Separate "it ran" from "it is valid": what every finished curve must satisfy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.basis.errors import ResultError
from orchestrator.basis.printed import as_place
from orchestrator.pushover.increments import PushoverCurve
from orchestrator.pushover.path.body_overlap import Misfit

EQUILIBRIUM = 1e-3
"""largest |multiplier x horizontal load - base shear| along the curve / its largest base shear"""
ENERGY = 0.01
"""largest imbalance of work and energies / (stored energy + friction + live load's work)"""
MISSING = "of stored energy, friction and the live load's work is missing"
OVERLAP = 5e-3
"""largest depth by which the displaced outlines of two bodies overlap, over the size of the smaller one"""
APART = OVERLAP
"""largest distance of the displaced outlines of two bodies that press each other, over the size of the smaller one"""
BEYOND = 5e-3
"""share by which the peak may exceed the associative multiplier, which no static state exceeds"""


def equilibrium_error(curve: PushoverCurve) -> float:
    """Return the largest |multiplier x horizontal load - base shear| of static rows, over the largest base shear."""
    static = curve.moving == 0
    missing = np.abs(curve.load_multiplier * curve.horizontal_load_N - curve.base_shear_N)[static]
    return float(np.max(missing) / np.max(np.abs(curve.base_shear_N[static])))


NONE = Misfit()
"""Bodies that neither overlap nor press each other from afar."""


@dataclass(frozen=True, slots=True)
class RowMisfits:
    """The worst overlap and the worst pressed gap of the displaced outlines in one row of a curve; moved: the row's
    control displacement since gravity, m."""

    number: int
    moved: float
    overlap: Misfit = NONE
    pressed_gap: Misfit = NONE

    @property
    def fits(self) -> bool:
        """Whether both are within their bounds; what is not a number is not."""
        return self.overlap.share <= OVERLAP and self.pressed_gap.share <= APART


def said_of(misfit: Misfit, verb: str) -> str:
    """Return in words which bodies do what where."""
    (one, other), (x, y) = misfit.names, misfit.place
    return f"{one} and {other} {verb} at {as_place(x, y)} m"


def check_curve(
    curve: PushoverCurve,
    misfits: RowMisfits | None,
    energy_error: float,
    highest: float | None,
) -> None:
    """Raise ResultError if the curve is not in balance, its bodies penetrate each other or press each other
    from afar, or its peak is not static.

    misfits: of the first row whose bodies do, None where none does; energy_error: share of the energies. highest: base
    shear in N that limit analysis says no static state exceeds, None where that does not hold. The error names every
    check that failed; a value that is not a number fails.
    """
    row = misfits or RowMisfits(0, 0.0)
    since = f"from {1e3 * row.moved:.4g} mm on"
    depth = f"to which {said_of(row.overlap, 'overlap')}, {since}"
    gap = f"across which {said_of(row.pressed_gap, 'press each other')}, {since}"
    static = curve.base_shear_N[curve.moving == 0]
    beyond = -1.0 if highest is None else float(static.max()) / highest - 1.0
    found = {
        "equilibrium": (equilibrium_error(curve), EQUILIBRIUM, "of the peak is missing at the supports"),
        "penetration": (row.overlap.share, OVERLAP, f"of the smaller body's size is the depth {depth}"),
        "touch": (row.pressed_gap.share, APART, f"of the smaller body's size is the gap {gap}"),
        "energy balance": (energy_error, ENERGY, MISSING),
        "static theorem": (beyond, BEYOND, "is what the peak is above the associative multiplier"),
    }
    failed = {
        name: f"{value:.2e} (at most {bound:g}) {meaning}"
        for name, (value, bound, meaning) in found.items()
        if not value <= bound
    }
    if failed:
        first, *others = failed
        raise ResultError(first, ", and ".join([failed[first], *(f"{name}: {failed[name]}" for name in others)]))
