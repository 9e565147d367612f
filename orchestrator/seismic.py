"""Seismic verification of a pushover curve (N2) and of a rocking mechanism (kinematic approach). All SI, ag in m/s2.

Clauses: EN 1998-1 3.2.2.2 (spectrum), Annex B (N2); NTC 2018 3.2.3.2.1 (spectrum); Circolare 7/2019 C7.3.4.2 (N2),
C7.8.1.6 (bilinear, see capacity.py), C8.7.1.2 (linear and non-linear kinematic approach). docs/seismic.md has an
example by hand.

    elastic spectrum      S_e = a_g S (1 + T / T_B (eta F_0 - 1)) up to T_B, a_g S eta F_0 up to T_C, times T_C / T up
                          to T_D, times T_C T_D / T^2 beyond; F_0 = 2.5 in EN 1998-1
                          eta = sqrt(10 / (5 + damping in %)) >= 0.55
    equivalent system     m* = sum(m phi), Gamma = m* / sum(m phi^2), d* = d / Gamma (B.2), F* = sum(F phi): the virtual
                          work of the load F. It is the clause's V / Gamma where F = m phi, as the clause has it (B.1)
    kinematic             M* = (sum P delta)^2 / (g sum P delta^2), e* = g M* / sum P, a_0* = alpha_0 g / (e* FC)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, pi, sqrt
from typing import Annotated, Literal

import numpy as np
from annotated_types import Ge, Gt, Le
from scipy import sparse

from orchestrator.capacity import Bilinear
from orchestrator.errors import CaseError
from orchestrator.masonry.wall import GRAVITY, FloatArray
from orchestrator.units import Unit

EC8_GROUND = {
    "ec8_type1": {
        "A": (1.0, 0.15, 0.4, 2.0), "B": (1.2, 0.15, 0.5, 2.0), "C": (1.15, 0.2, 0.6, 2.0),
        "D": (1.35, 0.2, 0.8, 2.0), "E": (1.4, 0.15, 0.5, 2.0),
    },
    "ec8_type2": {
        "A": (1.0, 0.05, 0.25, 1.2), "B": (1.35, 0.05, 0.25, 1.2), "C": (1.5, 0.1, 0.25, 1.2),
        "D": (1.8, 0.1, 0.3, 1.2), "E": (1.6, 0.05, 0.25, 1.2),
    },
}  # fmt: skip
"""S, T_B, T_C, T_D (s): EN 1998-1, Tables 3.2 and 3.3"""
NTC_SOIL = {
    "A": (1.0, 0.0, 1.0, 1.0), "B": (1.4, 0.4, 1.0, 1.2), "C": (1.7, 0.6, 1.0, 1.5),
    "D": (2.4, 1.5, 0.9, 1.8), "E": (2.0, 1.1, 1.0, 1.6),
}  # fmt: skip
"""S_S = first - second x F_0 a_g / g, between third and fourth: NTC 2018, Table 3.2.IV"""
NTC_PERIOD = {"A": (1.0, 0.0), "B": (1.1, 0.2), "C": (1.05, 0.33), "D": (1.25, 0.5), "E": (1.15, 0.4)}
"""C_C = first x T_C*^(-second): NTC 2018, Table 3.2.IV"""
ULTIMATE = 0.4
"""d_u* / d_0*, and d_s* / d_u*"""
MOVING = 1e-3
"""blocks slower than this part of the fastest do not belong to the mechanism"""
STEP, LEAST, MOST = 1.01, 1e-3, 1e3
"""search for the capacity: factor between two ground accelerations, first and last, m/s2"""


@dataclass(frozen=True, slots=True)
class SeismicSettings:
    """Seismic verification of the curves and of the mechanism. Without peak_ground_acceleration there is none."""

    peak_ground_acceleration: Annotated[float, Unit("m/s2"), Gt(0), Le(50)] | None = None
    """a_g on rock; left out: no verification"""
    spectrum: Literal["ec8_type1", "ec8_type2", "ntc2018", "parameters"] = "ec8_type1"
    """EN 1998-1 3.2.2.2, NTC 2018 3.2.3.2.1, or EN 1998-1 with soil_factor and the three periods below"""
    ground: Literal["A", "B", "C", "D", "E"] = "A"
    """ground type (EN 1998-1) or subsoil category (NTC 2018)"""
    amplification: Annotated[float, Ge(1), Le(5)] = 2.5
    """F_0; NTC 2018 only, EN 1998-1 has 2.5"""
    reference_period: Annotated[float, Unit("s"), Gt(0), Le(5)] | None = None
    """T_C*; NTC 2018 needs it"""
    topography: Annotated[float, Ge(1), Le(2)] = 1.0
    """S_T; NTC 2018 only"""
    soil_factor: Annotated[float, Gt(0), Le(5)] | None = None
    """S of "parameters" """
    period_b: Annotated[float, Unit("s"), Gt(0), Le(10)] | None = None
    """T_B of "parameters" """
    period_c: Annotated[float, Unit("s"), Gt(0), Le(10)] | None = None
    """T_C of "parameters" """
    period_d: Annotated[float, Unit("s"), Gt(0), Le(10)] | None = None
    """T_D of "parameters" """
    damping: Annotated[float, Gt(0), Le(0.5)] = 0.05
    """part of critical damping"""
    largest_force_ratio: Annotated[float, Ge(1)] = inf
    """largest elastic over yield force q*; "none": no limit (NTC 2018 asks 3 at SLV, 4 at SLC of masonry)"""
    confidence_factor: Annotated[float, Ge(1), Le(2)] = 1.35
    """FC of the kinematic approach (NTC 2018 C8.5.4)"""
    behaviour_factor: Annotated[float, Ge(1), Le(4)] = 2.0
    """q of the linear kinematic approach (NTC 2018 C8.7.1.2)"""


@dataclass(frozen=True, slots=True)
class Spectrum:
    """Elastic response spectrum: ground_acceleration m/s2, soil_factor S, periods s, amplification F_0, damping eta."""

    ground_acceleration: float
    soil_factor: float
    period_b: float
    period_c: float
    period_d: float
    amplification: float
    damping_factor: float

    def acceleration(self, period: float) -> float:
        """Return S_e(T) in m/s2 (EN 1998-1 Eq. 3.2 to 3.5; NTC 2018 Eq. 3.2.2)."""
        plateau = self.damping_factor * self.amplification
        if period < self.period_b:
            shape = 1.0 + period / self.period_b * (plateau - 1.0)
        elif period <= self.period_c:
            shape = plateau
        elif period <= self.period_d:
            shape = plateau * self.period_c / period
        else:
            shape = plateau * self.period_c * self.period_d / period**2
        return self.ground_acceleration * self.soil_factor * shape

    def displacement(self, period: float) -> float:
        """Return S_De(T) = S_e(T) (T / 2 pi)^2 in m (EN 1998-1 Eq. 3.7; NTC 2018 Eq. 3.2.10)."""
        return self.acceleration(period) * (period / (2.0 * pi)) ** 2


@dataclass(frozen=True, slots=True)
class EquivalentSystem:
    """One degree of freedom for a wall: Gamma, m* kg, mass of the wall kg, and force_share F*/V."""

    gamma: float
    mass: float
    whole_mass: float
    force_share: float

    @property
    def effective_mass(self) -> float:
        """Gamma m* over the mass of the wall, 0 to 1; 1 where the wall moves as one."""
        return self.gamma * self.mass / self.whole_mass


@dataclass(frozen=True, slots=True)
class Demand:
    """N2: period s of the equivalent system, force_ratio q*, displacement d_t* m."""

    period: float
    force_ratio: float
    displacement: float


@dataclass(frozen=True, slots=True)
class Kinematics:
    """Kinematic approach: participation e*, spectral acceleration a_0* m/s2 (FC included), d_0* m where it rocks."""

    participation: float
    acceleration: float
    displacement: float | None


def spectrum_of(settings: SeismicSettings, ground_acceleration: float) -> Spectrum:
    """Return the spectrum at a ground acceleration (m/s2). Raises CaseError for a setting that is missing."""
    eta = max(sqrt(10.0 / (5.0 + 100.0 * settings.damping)), 0.55)
    if settings.spectrum == "ntc2018":
        reference = _given(settings, "reference_period")
        share = ground_acceleration / GRAVITY
        first, slope, least, most = NTC_SOIL[settings.ground]
        soil = min(max(first - slope * settings.amplification * share, least), most) * settings.topography
        factor, power = NTC_PERIOD[settings.ground]
        period = factor * reference**-power * reference
        longest = 4.0 * share + 1.6
        return Spectrum(ground_acceleration, soil, period / 3.0, period, longest, settings.amplification, eta)
    if settings.spectrum == "parameters":
        soil, *periods = [_given(settings, name) for name in ("soil_factor", "period_b", "period_c", "period_d")]
        if periods != sorted(periods):
            raise CaseError("seismic.period_c", "the periods do not rise", "give period_b <= period_c <= period_d")
    else:
        soil, *periods = EC8_GROUND[settings.spectrum][settings.ground]
    return Spectrum(ground_acceleration, soil, periods[0], periods[1], periods[2], 2.5, eta)


def equivalent_system(
    mass: FloatArray | sparse.csr_matrix, shape: FloatArray, load: FloatArray, ground: FloatArray
) -> EquivalentSystem:
    """Return the equivalent system of a wall with mass matrix (n, n) in kg under horizontal loads (n,), any unit.

    shape (n,): horizontal displacement along the load over that of the control point. ground (n,): the shape of a wall
    that moves with the ground, 1 for every mass. With u = shape x d, the virtual work of inertia, load and ground
    motion along `shape` is m* (d / Gamma)'' + sum(load shape) = -m* a_g.
    """
    participating, whole = float(shape @ (mass @ ground)), float(ground @ (mass @ ground))
    gamma = participating / float(shape @ (mass @ shape))
    return EquivalentSystem(gamma, participating, whole, float(load @ shape) / float(load @ ground))


def demand(spectrum: Spectrum, bilinear: Bilinear, system: EquivalentSystem) -> Demand:
    """Return the N2 demand on the equivalent system (EN 1998-1 B.5; C7.3.4.2).

    T* < T_C and F_y*/m* < S_e: d_t* = d_et*/q (1 + (q - 1) T_C/T*) >= d_et*; else d_t* = d_et*.
    """
    force, displacement = bilinear.yield_force * system.force_share, bilinear.yield_displacement / system.gamma
    period = 2.0 * pi * sqrt(system.mass * displacement / force)
    ratio = spectrum.acceleration(period) * system.mass / force
    elastic = spectrum.displacement(period)
    if period >= spectrum.period_c or ratio <= 1.0:
        return Demand(period, ratio, elastic)
    return Demand(period, ratio, max(elastic / ratio * (1.0 + (ratio - 1.0) * spectrum.period_c / period), elastic))


def kinematics(
    multiplier: float, weight: FloatArray, velocities: FloatArray, load_direction: int, confidence: float
) -> Kinematics:
    """Return the capacity of a mechanism (C8.7.1.2): weight (n,) in N, velocities (n, 3) as in Mechanism.

    Its finite displacement: every block turns about its centre of rotation, so its velocity turns with it; what
    friction dissipates stays. d_0* is where the multiplier is zero, sum(P delta d) / sum(P delta) with d the blocks'
    displacements there (d_k sum P delta^2 / (delta_k sum P delta) of the clause, where d is proportional to delta).
    """
    speed = np.hypot(velocities[:, 0], velocities[:, 1])
    moving = speed > MOVING * speed.max()
    P, (u, v, w) = weight[moving], velocities[moving].T
    delta = load_direction * u
    mass = (P @ delta) ** 2 / (GRAVITY * (P @ delta**2))
    share = GRAVITY * mass / P.sum()
    dissipated = multiplier * (P @ delta) - P @ v

    def left(time: float) -> float:
        return float(dissipated + P @ (v * np.cos(w * time) + u * np.sin(w * time)))

    time = _first_zero(left, 0.5 * pi / max(float(np.abs(w).max()), 1e-300))
    displacement = None
    if time is not None:
        angle = w * time
        moved = time * (u * np.sinc(angle / pi) - v * np.sin(0.5 * angle) * np.sinc(0.5 * angle / pi))
        displacement = float(P @ (delta * load_direction * moved) / (P @ delta))
    return Kinematics(share, multiplier * GRAVITY / (share * confidence), displacement)


def secant_period(found: Kinematics) -> tuple[float, float, float]:
    """Return d_u* = 0.4 d_0*, d_s* = 0.4 d_u* (m) and T_s = 2 pi sqrt(d_s*/a_s*) (s) of a mechanism that rocks.

    The capacity curve is a* = a_0* (1 - d*/d_0*).
    """
    assert found.displacement is not None
    ultimate = ULTIMATE * found.displacement
    secant = ULTIMATE * ultimate
    at_secant = found.acceleration * (1.0 - secant / found.displacement)
    return ultimate, secant, 2.0 * pi * sqrt(secant / at_secant)


def largest_ground_acceleration(passes: Callable[[float], bool]) -> float:
    """Return the largest a_g (m/s2) up to which everything `passes`; 0 or the end of the search where it never changes.

    The soil factor of NTC 2018 falls with a_g: demand need not rise throughout, so the first failure counts.
    """
    low = LEAST
    if not passes(low):
        return 0.0
    while passes(low * STEP):
        low *= STEP
        if low > MOST:
            return MOST
    high = low * STEP
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if passes(middle) else (low, middle)
    return low


def _first_zero(function: Callable[[float], float], end: float) -> float | None:
    """Return the first zero up to `end` of a function that is positive at 0, None where there is none."""
    times = np.linspace(0.0, end, 2001)
    below = next((k for k, time in enumerate(times) if function(float(time)) <= 0.0), None)
    if not below:
        return None
    low, high = float(times[below - 1]), float(times[below])
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if function(middle) > 0.0 else (low, middle)
    return 0.5 * (low + high)


def _given(settings: SeismicSettings, name: str) -> float:
    value = getattr(settings, name)
    if value is None:
        raise CaseError(f"seismic.{name}", f"is missing for the spectrum {settings.spectrum!r}", "give it, as in 0.4 s")
    return float(value)
