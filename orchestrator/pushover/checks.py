"""Separate "it ran" from "it is valid": what every finished curve must satisfy."""

from __future__ import annotations

import numpy as np

from orchestrator.errors import ResultError
from orchestrator.pushover.state import PushoverCurve

EQUILIBRIUM = 1e-3
"""largest |multiplier x horizontal load - base shear| / horizontal load along the curve"""
KINETIC = 0.05
"""largest kinetic / internal energy before the peak"""
ENERGY = 0.01
"""largest imbalance of work and energies / (stored energy + friction)"""
PENETRATION = 1e-9
"""largest penetration, m"""


def equilibrium_error(curve: PushoverCurve, horizontal_load: float) -> float:
    """Return the largest |multiplier - base shear / horizontal load|: what inertia carries instead of the supports.

    horizontal_load: that of a load multiplier of 1, N (by default the weight).
    """
    return float(np.max(np.abs(curve.load_multiplier - curve.base_shear_N / horizontal_load)))


def kinetic_share(curve: PushoverCurve) -> float:
    """Return the largest kinetic / internal energy of the lateral rows up to the peak."""
    before = slice(1, int(np.argmax(curve.base_shear_N)) + 1)
    kinetic, internal = curve.kinetic_energy_J[before], curve.internal_energy_J[before]
    with np.errstate(divide="ignore"):
        return float(np.max(kinetic / internal, where=~(kinetic <= 0.0), initial=0.0))  # nan stays nan


def check(curve: PushoverCurve, max_penetration: float, energy_error: float, horizontal_load: float) -> None:
    """Raise ResultError if the curve is not quasi-static, not in balance, or its bodies penetrate each other.

    max_penetration in m over all increments; energy_error: share of the energies; horizontal_load in N. The error names
    every check that failed; a value that is not a number fails.
    """
    found = {
        "equilibrium": (equilibrium_error(curve, horizontal_load), EQUILIBRIUM, "of the load is carried by inertia"),
        "kinetic energy": (kinetic_share(curve), KINETIC, "of the internal energy before the peak"),
        "penetration": (max_penetration, PENETRATION, "m"),
        "energy balance": (energy_error, ENERGY, "of stored energy and friction is missing"),
    }
    failed = {
        name: f"{value:.2e} {meaning}; at most {bound:g} is acceptable"
        for name, (value, bound, meaning) in found.items()
        if not value <= bound
    }
    if failed:
        first, *others = failed
        raise ResultError(first, ", and ".join([failed[first], *(f"{name}: {failed[name]}" for name in others)]))
