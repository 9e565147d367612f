"""How a wall's capacity depends on what is not known well: ranges, one at a time and all together, and fragility.

one at a time     every range at its low and at its high end, all else as the case has it: a tornado
all together      Latin hypercube: n samples, in each range one in each of n strata of equal probability, uniform;
                  McKay, Beckman and Conover 1979
fragility         P(capacity <= x): the i-th smallest of n capacities stands at (i - 1/2)/n
lognormal fit     median exp(mean ln c), dispersion beta = root mean square of ln c about it: the largest likelihood
                  for exact capacities; distance: the largest of the fit from the points (Kolmogorov, Smirnov)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from math import erf, exp, log, sqrt
from typing import Annotated, Literal

import numpy as np
from annotated_types import Ge, Gt, Le, MaxLen

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.checked import Checked
from orchestrator.basis.errors import CaseError
from orchestrator.basis.units import Unit
from orchestrator.masonry.wall import Friction, Thickness, UnitWeight

Analysis = Literal["limit", "macro", "micro"]
NOT_A_RANGE = ("samples", "seed", "analysis")


UNITS = {
    "unit_weight": (1e-3, "kN/m³"), "thickness": (1e3, "mm"), "cohesion": (1e-3, "kPa"),
    "tensile_strength": (1e-3, "kPa"), "compressive_strength": (1e-6, "MPa"), "friction": (1.0, ""),
}  # fmt: skip
"""factor and unit in which a range is shown"""


ALIKE = 1e-4
"""part by which capacities differ that are one answer"""


@dataclass(frozen=True, slots=True)
class SensitivitySettings(Checked):
    """The ranges of `sensitivity`, each [low, high]; what is left out stays as the case has it."""

    friction: Annotated[tuple[Friction, ...], MaxLen(2)] = ()
    """coefficient of friction of every joint"""
    unit_weight: Annotated[tuple[UnitWeight, ...], MaxLen(2)] = ()
    """of every block"""
    thickness: Annotated[tuple[Thickness, ...], MaxLen(2)] = ()
    """of the wall, for blocks without one of their own"""
    cohesion: Annotated[tuple[Annotated[float, Ge(0), Unit("Pa")], ...], MaxLen(2)] = ()
    """of every joint"""
    tensile_strength: Annotated[tuple[Annotated[float, Ge(0), Unit("Pa")], ...], MaxLen(2)] = ()
    """of every joint"""
    compressive_strength: Annotated[tuple[Annotated[float, Gt(0), Unit("Pa")], ...], MaxLen(2)] = ()
    """of every joint"""
    samples: Annotated[int, Ge(0), Le(100_000)] = 100
    """samples of the Latin hypercube; 0: the tornado alone"""
    seed: Annotated[int, Ge(0)] = 1
    """of the samples: the same seed gives the same ones"""
    analysis: Analysis = "limit"
    """what gives the capacity: limit analysis, or a pushover of macroblocks or of every stone"""


@dataclass(frozen=True, slots=True)
class SensitivityPoint:
    """A value (SI) of each range that this point changes, and what it is called."""

    name: str
    values: tuple[tuple[str, float], ...]


def ranges(settings: SensitivitySettings) -> dict[str, tuple[float, float]]:
    """Return low and high of every range given. Raises CaseError (key only) for none, or one that is no range."""
    limits = given_ranges(settings)
    if not limits:
        raise CaseError("sensitivity", "has no range", "give one, as in friction = [0.5, 0.7]")
    return limits


def given_ranges(settings: SensitivitySettings) -> dict[str, tuple[float, float]]:
    """Return low and high of every range given, if any is. Raises CaseError (key only) for one that is no range."""
    limits: dict[str, tuple[float, float]] = {}
    for field in fields(settings):
        ends = getattr(settings, field.name)
        if field.name in NOT_A_RANGE or ends == ():
            continue
        if len(ends) != 2 or not ends[0] < ends[1]:
            raise CaseError(
                f"sensitivity.{field.name}", f"{list(ends)} is no range", "write [low, high], low below high"
            )
        limits[field.name] = (ends[0], ends[1])
    return limits


def one_at_a_time(limits: Mapping[str, tuple[float, float]]) -> tuple[SensitivityPoint, ...]:
    """Return the case as it is, and every range at its ends."""
    ends = (
        SensitivityPoint(f"{name} {end}", ((name, value),))
        for name, pair in limits.items()
        for end, value in zip(("low", "high"), pair, strict=True)
    )
    return (SensitivityPoint("as given", ()), *ends)


def latin_hypercube(limits: Mapping[str, tuple[float, float]], samples: int, seed: int) -> tuple[SensitivityPoint, ...]:
    """Return samples of all ranges together, uniform in each."""
    if samples == 0:
        return ()
    low, high = np.array(list(limits.values())).T
    from scipy.stats import qmc  # takes as long to import as all else that a case file needs

    drawn = qmc.scale(qmc.LatinHypercube(len(limits), seed=seed).random(samples), low, high)
    digits = len(str(samples))
    return tuple(
        SensitivityPoint(f"sample {number:0{digits}d}", tuple(zip(limits, row.tolist(), strict=True)))
        for number, row in enumerate(drawn, 1)
    )


@dataclass(frozen=True, slots=True)
class Lognormal:
    """Median in the unit of the capacities, dispersion beta, and the largest distance of the fit from the points."""

    median: float
    beta: float
    distance: float

    def probability(self, value: float) -> float:
        """Return P(capacity <= value)."""
        if value <= 0.0:
            return 0.0
        return 0.5 * (1.0 + erf(log(value / self.median) / (self.beta * sqrt(2.0))))


def fragility(capacities: Sequence[float]) -> tuple[FloatArray, FloatArray]:
    """Return the capacities in order and the probability at each of them."""
    ordered = np.sort(np.asarray(capacities, dtype=float))
    return ordered, (np.arange(len(ordered)) + 0.5) / max(len(ordered), 1)


def lognormal(capacities: Sequence[float]) -> Lognormal | None:
    """Return the fit; None where a capacity is 0 (the wall does not stand), or all are one answer."""
    ordered, probability = fragility(capacities)
    if len(ordered) < 2 or ordered[0] <= 0.0 or ordered[-1] - ordered[0] <= ALIKE * ordered[-1]:
        return None
    logarithm = np.log(ordered)
    fit = Lognormal(exp(float(logarithm.mean())), float(logarithm.std()), 0.0)
    distance = max(abs(fit.probability(x) - p) for x, p in zip(ordered.tolist(), probability.tolist(), strict=True))
    return Lognormal(fit.median, fit.beta, distance + 0.5 / len(ordered))


def value_of_range(name: str, value: float) -> str:
    """Return a value of a range with its unit."""
    factor, unit = UNITS[name]
    return f"{factor * value:.4g} {unit}".rstrip()
