"""Elastic response spectra, on the ground and at a height z of a building. SI units, a_g in m/s2.

    on the ground   S_e = a_g S (1 + T / T_B (eta F_0 - 1)) up to T_B, a_g S eta F_0 up to T_C, times T_C / T up
                    to T_D, times T_C T_D / T^2 beyond; F_0 = 2.5 in EN 1998-1
                    eta = sqrt(10 / (5 + damping in %)) >= 0.55
    at height z     a_Z = S_e(T_1, xi_1) gamma_1 psi_1(z) sqrt(1 + 0.0004 xi_1^2), xi_1 in %; gamma_1 = 3 n / (2 n + 1),
                    psi_1 = z / H; S_eZ = A a_Z between 0.8 T_1 and 1.1 T_1, falling off on both sides; A = 1.1 eta /
                    sqrt(xi_1), xi_1 as part of 1

S includes the topographic factor S_T (EN 1998-5 Annex A; NTC 2018, Table 3.2.V).

Clauses: EN 1998-1 3.2.2.2; NTC 2018 3.2.3.2.1; Circolare 7/2019 C7.2.3, [C7.2.5] to [C7.2.10], first mode only.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sqrt

from orchestrator.assessment.seismic.settings import LimitStateSettings, SeismicSettings, refuse_building
from orchestrator.basis.errors import CaseError
from orchestrator.masonry.wall import GRAVITY

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
PLATEAU_BEGINS = 0.8
"""a of [C7.2.6], part of T_1"""
PLATEAU_ENDS = 1.1
"""b of [C7.2.6], part of T_1"""


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
        return self.peak_acceleration * shape

    def displacement(self, period: float) -> float:
        """Return S_De(T) = S_e(T) (T / 2 pi)^2 in m (EN 1998-1 Eq. 3.7; NTC 2018 Eq. 3.2.10)."""
        return self.acceleration(period) * (period / (2.0 * pi)) ** 2

    @property
    def peak_acceleration(self) -> float:
        """a_g S, m/s2: what a rigid body on the ground feels."""
        return self.ground_acceleration * self.soil_factor


@dataclass(frozen=True, slots=True)
class FloorSpectrum:
    """Spectrum at a height of a building, of its first mode (C7.2.3).

    ground: the spectrum below, with the damping of what stands up there; of_building: that with the building's
    damping. period T_1 s, damping xi_1 as part of 1, share gamma_1 psi_1(z).
    """

    ground: Spectrum
    of_building: Spectrum
    period: float
    damping: float
    share: float

    @property
    def peak_acceleration(self) -> float:
        """a_Z in m/s2 [C7.2.7], [C7.2.8]; not below a_g S, which is safe near the ground where one mode says 0."""
        percent = 100.0 * self.damping
        here = self.of_building.acceleration(self.period) * self.share * sqrt(1.0 + 0.0004 * percent**2)
        return max(here, self.ground.peak_acceleration)

    def acceleration(self, period: float) -> float:
        """Return S_eZ(T) in m/s2 [C7.2.6]; beyond T_1 not below that of the ground [C7.2.5]."""
        amplified = 1.1 / sqrt(self.damping) * self.ground.damping_factor
        begins, ends = PLATEAU_BEGINS * self.period, PLATEAU_ENDS * self.period
        away = 0.0
        if period < begins:
            away = (1.0 - period / begins) ** 1.6
        elif period >= ends:
            away = (period / ends - 1.0) ** 1.2
        here = amplified * self.peak_acceleration / (1.0 + (amplified - 1.0) * away)
        return max(here, self.ground.acceleration(period)) if period > self.period else here

    def displacement(self, period: float) -> float:
        """Return S_eZ(T) (T / 2 pi)^2 in m; beyond 1.1 T_1 not below what it is there [C8.7.1.12]."""
        here = self.acceleration(period) * (period / (2.0 * pi)) ** 2
        ends = PLATEAU_ENDS * self.period
        if period <= ends:
            return here
        return max(here, self.acceleration(self.period) * (ends / (2.0 * pi)) ** 2)


def damping_factor(damping: float) -> float:
    """Return eta of a part of critical damping (EN 1998-1 Eq. 3.6; NTC 2018 Eq. 3.2.4)."""
    return max(sqrt(10.0 / (5.0 + 100.0 * damping)), 0.55)


def spectrum_of(
    settings: SeismicSettings, state: LimitStateSettings, ground_acceleration: float, damping: float
) -> Spectrum:
    """Return the spectrum of a limit state at a ground acceleration (m/s2). Raises CaseError for a missing setting."""
    eta = damping_factor(damping)
    if settings.spectrum == "ntc2018":
        if state.reference_period is None:
            raise _missing(settings, "reference_period")
        assert state.amplification is not None, "limit_states fills it in"
        share = ground_acceleration / GRAVITY
        first, slope, least, most = NTC_SOIL[settings.ground]
        soil = min(max(first - slope * state.amplification * share, least), most) * settings.topography
        factor, power = NTC_PERIOD[settings.ground]
        period = factor * state.reference_period**-power * state.reference_period
        longest = 4.0 * share + 1.6
        return Spectrum(ground_acceleration, soil, period / 3.0, period, longest, state.amplification, eta)
    if settings.spectrum == "parameters":
        parameters = [getattr(settings, name) for name in ("soil_factor", "period_b", "period_c", "period_d")]
        for name, value in zip(("soil_factor", "period_b", "period_c", "period_d"), parameters, strict=True):
            if value is None:
                raise _missing(settings, name)
        soil, *periods = parameters
        if periods != sorted(periods):
            raise CaseError("seismic.period_c", "the periods do not rise", "give period_b <= period_c <= period_d")
    else:
        soil, *periods = EC8_GROUND[settings.spectrum][settings.ground]
        soil *= settings.topography
    return Spectrum(ground_acceleration, soil, periods[0], periods[1], periods[2], 2.5, eta)


def spectrum_at_height(
    settings: SeismicSettings, state: LimitStateSettings, ground_acceleration: float, damping: float
) -> Spectrum | FloorSpectrum:
    """Return the spectrum where the wall stands: on the ground, or at mechanism_height (C7.2.3). Raises CaseError."""
    ground = spectrum_of(settings, state, ground_acceleration, damping)
    if settings.mechanism_height == 0.0:
        return ground
    refuse_building(settings)
    assert settings.building_height is not None
    assert settings.building_period is not None
    assert settings.storeys is not None
    participation = 3.0 * settings.storeys / (2.0 * settings.storeys + 1.0)
    return FloorSpectrum(
        ground=ground,
        of_building=spectrum_of(settings, state, ground_acceleration, settings.building_damping),
        period=settings.building_period,
        damping=settings.building_damping,
        share=participation * settings.mechanism_height / settings.building_height,
    )


def _missing(settings: SeismicSettings, name: str) -> CaseError:
    example = "1.2" if name == "soil_factor" else '"0.4 s"'
    problem = f"is missing for the spectrum {settings.spectrum!r}"
    return CaseError(f"seismic.{name}", problem, f"give it, as in {example}")
