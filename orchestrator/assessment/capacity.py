"""Capacity: the figures that a pushover curve is read for.

Displacements are relative to the state under gravity (the curve's first row). With V the base shear, d the control
displacement, H the horizontal live load and lambda its multiplier:

    peak                  V_p = max V up to the final displacement (first row that reaches it)
    initial stiffness     k = sum(V d) / sum(d d), the least-squares line through the origin, over the leading lateral
                          rows with V - V_gravity <= 10 % of the peak, but at least the first two; none where the
                          line falls: what moves against the load says nothing of the wall's stiffness
    equilibrium residual  max |lambda H - V| / V_p over all rows

Rows in which the wall moves are left out: only the static ones count.

Bilinear idealisation (Circolare 7/2019, masonry):

    elastic branch        secant through the first point at 60 % of the peak (C7.3.4.2)
    ultimate              where the base shear has first dropped by 20 % past the peak (C7.8.1.5.4), else the end
    plastic branch        horizontal; equal areas under curve and bilinear up to the ultimate displacement
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.errors import NO_CONTACT, ResultError
from orchestrator.pushover.increments import PushoverCurve
from orchestrator.pushover.path.curve_checks import equilibrium_error

STIFFNESS_FRACTION = 0.1
"""part of the peak base shear (above the gravity row) that counts as the initial branch"""
STIFFNESS_ROWS = 2
"""lateral rows that the initial branch has at least"""
SECANT = 0.6
"""part of the peak base shear that the elastic branch of the bilinear goes through"""
STRENGTH_DROP = 0.2
"""part of the peak base shear by which it has dropped at the ultimate displacement of the bilinear"""
FALLEN = 0.01
"""part of its peak by which the base shear has fallen where the peak is behind"""
AGAINST = "the control displacement does not go along the live load"
"""why a curve has no bilinear idealisation though its base shear rises"""
OUTSIDE = 0.2
"""motion of a control point over that of the fastest stone below which it is outside the mechanism"""
STILL = 1e-9
"""the same from which on what it moves is rounding: a top that supports hold"""
FLAT_LENGTH_RATIO = 1.5
"""a curve this many times as long as where it first came within FALLEN of its peak has been flat: that is its peak"""


@dataclass(frozen=True, slots=True)
class Capacity:
    """peak_base_shear N, displacement_at_peak and final_displacement m, initial_stiffness N/m: None where the control
    displacement goes against the live load at first, or is rounding: it is 0 in all rows then.

    displacement_at_peak: of the row with the largest base shear, which rounding chooses on a plateau. Where a share of
    the peak is first reached is no better known: a facade and its mirror image were 10 % apart either way.

    peak_reached: whether the curve shows that its peak is one (`peak_reached`); else the wall carries at least as much.
    """

    peak_base_shear: float
    peak_multiplier: float
    displacement_at_peak: float
    final_displacement: float
    initial_stiffness: float | None
    equilibrium_residual: float
    peak_reached: bool


def find_capacity(curve: PushoverCurve) -> Capacity:
    """Return the capacity from the static rows of a curve.

    Raises ResultError for a curve without lateral rows, with values that are not finite, or that does not move.
    """
    whole, curve = curve, curve.static
    _require_usable(curve)
    displacement = curve.control_displacement_m - curve.control_displacement_m[0]
    peak = int(np.argmax(curve.base_shear_N))
    slope = initial_stiffness(curve.base_shear_N, displacement)
    return Capacity(
        peak_base_shear=float(curve.base_shear_N[peak]),
        peak_multiplier=float(curve.load_multiplier[peak]),
        displacement_at_peak=float(displacement[peak]),
        final_displacement=float(displacement[-1]),
        initial_stiffness=slope if slope > 0.0 else None,
        equilibrium_residual=equilibrium_error(curve),
        peak_reached=peak_reached(whole),
    )


def peak_reached(curve: PushoverCurve) -> bool:
    """Return whether the largest base shear of a curve is its peak, and not just where the curve was cut off.

    It is where the base shear has fallen by FALLEN of it in a later row, where the curve goes on to FLAT_LENGTH_RATIO
    times the displacement at which it first came that close to it, or where the wall fell in the motion with which the
    curve ends: it found no rest under a load above its last one.
    """
    if has_fallen(curve) or (curve.moving[-1] and curve.stopped_because.endswith(NO_CONTACT)):
        return True
    curve = curve.static
    shear, moved = curve.base_shear_N, curve.control_displacement_m - curve.control_displacement_m[0]
    first = float(moved[int(np.argmax(shear >= (1.0 - FALLEN) * shear.max()))])
    return bool(first > 0.0 and moved[-1] >= FLAT_LENGTH_RATIO * first)


def has_fallen(curve: PushoverCurve) -> bool:
    """Return whether the base shear of a curve has fallen by FALLEN of its largest in a later row."""
    shear = curve.static.base_shear_N
    peak = int(np.argmax(shear))
    return bool(np.any(shear[peak:] <= (1.0 - FALLEN) * float(shear[peak])))


@dataclass(frozen=True, slots=True)
class Bilinear:
    """Elastic, perfectly plastic: stiffness N/m, yield_force N, yield_displacement and ultimate_displacement m.

    dropped: whether the base shear has dropped before the end of the curve; if not, the wall may well go further.
    """

    stiffness: float
    yield_force: float
    yield_displacement: float
    ultimate_displacement: float
    dropped: bool


def idealise(base_shear: FloatArray, displacement: FloatArray) -> Bilinear:
    """Return the bilinear idealisation of a curve: base_shear (s,) in N, displacement (s,) in m, row 0 = gravity.

    Equal areas: with A the area under the curve up to d_u and k the stiffness, F_y = k (d_u - sqrt(d_u^2 - 2 A / k)).
    Raises ResultError for a curve that encloses more than its secant allows (it starts too steeply, ends too early), or
    that goes or ends against the load.
    """
    moved = displacement - displacement[0]
    peak = int(np.argmax(base_shear))
    fallen = np.flatnonzero(base_shear[peak:] <= (1.0 - STRENGTH_DROP) * base_shear[peak])
    force = np.array(base_shear)
    if fallen.size:
        last = peak + int(fallen[0])
        left = (1.0 - STRENGTH_DROP) * force[peak]
        part = (force[last - 1] - left) / (force[last - 1] - force[last])
        moved = np.append(moved[:last], moved[last - 1] + part * (moved[last] - moved[last - 1]))
        force = np.append(force[:last], left)
    above = int(np.argmax(force >= SECANT * force.max()))
    if above == 0:
        raise ResultError("bilinear idealisation", "the curve does not rise from the state under gravity")
    if not min(moved[above], moved[-1]) > 0.0:
        raise ResultError("bilinear idealisation", AGAINST)
    part = (SECANT * force.max() - force[above - 1]) / (force[above] - force[above - 1])
    at_secant = float(moved[above - 1] + part * (moved[above] - moved[above - 1]))
    stiffness = SECANT * float(force.max()) / at_secant
    ultimate, area = float(moved[-1]), float(0.5 * (force[1:] + force[:-1]) @ np.diff(moved))
    radicand = ultimate**2 - 2.0 * area / stiffness
    if radicand < 0.0:
        raise ResultError("bilinear idealisation", "the curve ends before the areas can be made equal")
    yield_displacement = ultimate - float(np.sqrt(radicand))
    return Bilinear(stiffness, stiffness * yield_displacement, yield_displacement, ultimate, bool(fallen.size))


def initial_stiffness(base_shear: FloatArray, displacement: FloatArray) -> float:
    """Return the slope of the initial branch in N/m; base_shear (s,) in N, displacement (s,) in m, row 0 = gravity."""
    shear, moved = (base_shear - base_shear[0])[1:], (displacement - displacement[0])[1:]
    beyond = np.flatnonzero(shear > STIFFNESS_FRACTION * shear.max())
    rows = max(STIFFNESS_ROWS, int(beyond[0]) if beyond.size else len(shear))
    square = float(moved[:rows] @ moved[:rows])
    if square == 0.0:
        raise ResultError("initial stiffness", "the control displacement is zero in the first lateral increments")
    return float(shear[:rows] @ moved[:rows]) / square


def _require_usable(curve: PushoverCurve) -> None:
    if len(curve.base_shear_N) < 2:
        raise ResultError("capacity curve", f"no lateral increment was stored (stopped: {curve.stopped_because})")
    for name in ("load_multiplier", "base_shear_N", "control_displacement_m", "internal_energy_J"):
        wrong = np.flatnonzero(~np.isfinite(getattr(curve, name)))
        if wrong.size:
            raise ResultError("capacity curve", f"{name} is not finite in step {curve.step[wrong[0]]}")
