"""N2: from a pushover curve to demand and capacity of a system with one degree of freedom. SI units.

    equivalent system   m* = sum(m phi), Gamma = m* / sum(m phi^2), d* = d / Gamma (B.2), F* = sum(F phi): the virtual
                        work of the load F. It is the clause's V / Gamma where F = m phi, as the clause has it (B.1)
    period              T* = 2 pi sqrt(m* d_y* / F_y*)
    force ratio         q* = S_e(T*) m* / F_y*
    demand              T* < T_C and q* > 1: d_t* = d_et*/q* (1 + (q* - 1) T_C/T*) >= d_et*;
                        else d_t* = d_et* = S_De(T*)

Clauses: EN 1998-1 Annex B; Circolare 7/2019 C7.3.4.2 [C7.3.6] to [C7.3.8], C7.8.1.5.4, C7.8.1.6.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, pi, sqrt

from scipy import sparse

from orchestrator.assessment.capacity import Bilinear
from orchestrator.assessment.seismic.settings import LimitStateName
from orchestrator.assessment.seismic.spectrum import Spectrum
from orchestrator.basis.arrays import FloatArray

SIGNIFICANT = 0.75
"""displacement at SLV over that at SLC (C7.8.1.5.4), at SD over that at NC (EN 1998-3 Annex C)"""
STEP = 1.01
"""factor between two ground accelerations of the search for a capacity"""
LEAST = 1e-3
"""m/s2; the first ground acceleration of that search"""
MOST = 1e3
"""m/s2; the last one, a hundred times gravity: a capacity beyond it has no meaning"""


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


def period(bilinear: Bilinear, system: EquivalentSystem) -> float:
    """Return T* in s (EN 1998-1 B.4; [C7.3.6])."""
    force, displacement = bilinear.yield_force * system.force_share, bilinear.yield_displacement / system.gamma
    return 2.0 * pi * sqrt(system.mass * displacement / force)


def demand(spectrum: Spectrum, bilinear: Bilinear, system: EquivalentSystem) -> Demand:
    """Return the N2 demand on the equivalent system (EN 1998-1 B.5; [C7.3.7], [C7.3.8])."""
    natural = period(bilinear, system)
    ratio = spectrum.acceleration(natural) * system.mass / (bilinear.yield_force * system.force_share)
    elastic = spectrum.displacement(natural)
    if natural >= spectrum.period_c or ratio <= 1.0:
        return Demand(natural, ratio, elastic)
    return Demand(natural, ratio, max(elastic / ratio * (1.0 + (ratio - 1.0) * spectrum.period_c / natural), elastic))


def displacement_of_curve(state: LimitStateName, bilinear: Bilinear, at_peak: float) -> float:
    """Return the displacement capacity (m, of the control point) that a curve has at a limit state.

    SLC and NC where the base shear has dropped by 20 %, SLV and SD three quarters of that, DL at the yield point of the
    bilinear (EN 1998-3 Annex C), and SLD there or at the peak (at_peak m), whichever is first (C7.8.1.5.4; the peak is
    that of all piers together, as joints have no shear strength of piers).
    """
    ultimate = bilinear.ultimate_displacement
    yielding = min(bilinear.yield_displacement, ultimate)
    return {
        "SLC": ultimate, "NC": ultimate, "SLV": SIGNIFICANT * ultimate, "SD": SIGNIFICANT * ultimate,
        "SLD": min(yielding, at_peak), "DL": yielding,
    }[state]  # fmt: skip


def displacement_at_force_ratio(
    largest: float, spectrum: Spectrum, bilinear: Bilinear, system: EquivalentSystem
) -> float:
    """Return d* in m at which q* has its largest value, which the capacity may not exceed (C7.8.1.6); inf for none."""
    if largest == inf:
        return inf
    natural, yields = period(bilinear, system), bilinear.yield_displacement / system.gamma
    if natural >= spectrum.period_c:
        return yields * largest
    return yields * max(1.0 + (largest - 1.0) * spectrum.period_c / natural, largest)


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
