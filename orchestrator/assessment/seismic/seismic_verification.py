"""Verification of a run: every curve by N2, the mechanism by the kinematic approach, at every limit state asked for.

The drifts of piers are checked beside N2, by the same demand.

The record has one row per check: approach, limit state, demand and capacity with their unit, the ground acceleration
that just passes, their ratio, the clause, and remarks; or why nothing is verified. A ratio is never bare where what it
rests on is not what its formula was made for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from orchestrator.assessment.capacity import OUTSIDE, Bilinear, idealise
from orchestrator.assessment.seismic.control import ControlPoint, control_point
from orchestrator.assessment.seismic.drift import CLAUSES as DRIFT_CLAUSES
from orchestrator.assessment.seismic.drift import GIVEN, allowed_displacement, drift_at, drifting_piers, is_limited
from orchestrator.assessment.seismic.kinematic_checks import kinematic_checks
from orchestrator.assessment.seismic.local_mechanism import loads_in_mechanism
from orchestrator.assessment.seismic.n2 import (
    demand,
    displacement_at_force_ratio,
    displacement_of_curve,
    largest_ground_acceleration,
)
from orchestrator.assessment.seismic.observed import Observed, StoredPushover, observe
from orchestrator.assessment.seismic.settings import (
    LimitStateSettings,
    SeismicSettings,
    largest_force_ratio,
    limit_states,
    refuse_ties,
)
from orchestrator.assessment.seismic.spectrum import Spectrum, spectrum_of
from orchestrator.assessment.seismic.verification_record import in_its_unit
from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.errors import ResultError
from orchestrator.limit_analysis import LimitAnalysis, LimitAnalysisSettings
from orchestrator.loads import LoadSettings
from orchestrator.loads.dead_loads import not_accelerated
from orchestrator.masonry.joints import Assemblage

LABELS = {"macro": "macroblock FE", "micro": "micro-FE"}
TARGET_REACH = 1.5
"""part of the target displacement that the curve should reach: EN 1998-1 4.3.3.4.2.3"""
DUCTILE = 10.0
"""ductility and ratio above which equal energy and the ratio itself say little"""
SLIPPERY = 0.1
"""part of the elastic displacement made by the slip tolerance from which T* is said to be its work"""
TOO_STIFF = 0.05
"""part of the bodies' stiffness that is their elements' from which finer ones are asked for. Of five walls that it was
estimated for at 3, 6, 8, 14 and 21 % elements of a quarter of the size were 5, 16, 17, 33 and 31 % softer, as more of
their joints opened (a throw-away script)"""
CLAUSES = {
    "SLD": "Circ. 7/2019 C7.3.4.2, C7.8.1.5.4 (yield)",
    "SLV": "Circ. 7/2019 C7.3.4.2, C7.8.1.5.4 (3/4), C7.8.1.6",
    "SLC": "Circ. 7/2019 C7.3.4.2, C7.8.1.5.4 (80 %), C7.8.1.6",
    "DL": "EN 1998-1 Annex B, EN 1998-3 Annex C (yield)",
    "SD": "EN 1998-1 Annex B, EN 1998-3 Annex C (3/4)",
    "NC": "EN 1998-1 Annex B, EN 1998-3 Annex C (80 %)",
}
"""of N2, and in brackets what the displacement capacity is"""
INCLINED = "N2 takes horizontal forces: this live load is inclined, and what it presses or lifts changes the strength"
"""why the curve of such a load is not verified"""


def verify(
    settings: SeismicSettings,
    load: LoadSettings,
    limit_analysis: LimitAnalysisSettings,
    assemblage: Assemblage,
    analysis: LimitAnalysis,
    pushovers: Sequence[StoredPushover],
) -> tuple[dict[str, Any], dict[str, Observed]] | None:
    """Return the record `seismic` of the summary and what was observed of every curve, None where nothing is asked.

    Raises CaseError (key only), for a wall with ties too.
    """
    refuse_ties(settings, len(analysis.headline.tie_forces))
    states = limit_states(settings)
    if not states:
        return None
    point = control_point(settings, assemblage, load, analysis)
    observed, systems, checks, drifts = _of_curves(settings, states, load, assemblage, analysis, pushovers)
    kinematic, more = kinematic_checks(
        settings, states, loads_in_mechanism(assemblage, load, limit_analysis, analysis), analysis.loads.direction
    )
    rows = [*checks, *more, *(row for row in drifts if row)]
    for row in rows:
        if "refused" not in row:
            row["remarks"] += not_accelerated(assemblage.wall, load.dead)
    record = {
        "spectrum": {"kind": settings.spectrum, "ground": settings.ground, "damping": settings.damping},
        "limit_states": [_spectrum(settings, state) for state in states],
        "control_point": "; ".join(dict.fromkeys(system["control_point"] for system in systems)) or point.name,
        "systems": systems,
        "kinematic": kinematic,
        "checks": rows,
    }
    return record, observed


def _of_curves(
    settings: SeismicSettings,
    states: Sequence[LimitStateSettings],
    load: LoadSettings,
    assemblage: Assemblage,
    analysis: LimitAnalysis,
    pushovers: Sequence[StoredPushover],
) -> tuple[dict[str, Observed], list[dict[str, Any]], list[dict[str, Any]], list[dict[str, Any] | None]]:
    """Return what is observed of every curve that may be verified, its system, and the rows of N2 and of drifts."""
    observed: dict[str, Observed] = {}
    systems: list[dict[str, Any]] = []
    checks: list[dict[str, Any]] = []
    drifts: list[dict[str, Any] | None] = []
    for pushover in pushovers:
        label = LABELS[pushover.name]
        try:
            point, seen, line = _idealised(pushover, settings, assemblage, load, analysis)
        except ResultError as error:
            refused = {"limit_state": "all", "refused": error.detail}
            checks.append({"approach": f"N2, {label}"} | refused)
            if any(is_limited(state.name, settings) for state in states):
                drifts.append({"approach": f"drift, {label}"} | refused)
            continue
        observed[pushover.name] = seen
        systems.append(_system(pushover.name, point, seen, line))
        shear = pushover.curve.base_shear_N
        checks += [n2_check(f"N2, {label}", settings, state, shear, seen, line) for state in states]
        drifts += [_drift(label, settings, state, seen, line) for state in states]
    return observed, systems, checks, drifts


def _idealised(
    pushover: StoredPushover,
    settings: SeismicSettings,
    assemblage: Assemblage,
    load: LoadSettings,
    analysis: LimitAnalysis,
) -> tuple[ControlPoint, Observed, Bilinear]:
    """Return the control point of a curve, what is observed of it, and its bilinear. Raises ResultError for a curve
    that may not be verified."""
    if load.inclination:
        raise ResultError("verification", INCLINED)
    if pushover.refused:
        raise ResultError("verification", pushover.refused)
    fallen = pushover.fallen
    point = control_point(settings, assemblage, load, analysis, fallen)
    drifting = drifting_piers(assemblage, point.blocks, analysis.loads, fallen)
    seen = observe(pushover, assemblage.wall, load, point, drifting)
    return point, seen, idealise(pushover.curve.base_shear_N, seen.displacement)


def _spectrum(settings: SeismicSettings, state: LimitStateSettings) -> dict[str, Any]:
    spectrum = spectrum_of(settings, state, state.peak_ground_acceleration, settings.damping)
    symbols = ("ag_m_per_s2", "S", "TB_s", "TC_s", "TD_s", "F0", "eta")
    return {"limit_state": state.name, **dict(zip(symbols, asdict(spectrum).values(), strict=True))}


def _system(name: str, point: ControlPoint, seen: Observed, line: Bilinear) -> dict[str, Any]:
    """Return what the equivalent system of one curve is: in the axes of the curve (V, d), and starred (F*, d*)."""
    system = seen.system
    return {
        "model": name,
        "control_point": point.name,
        "share_of_fastest": seen.share_of_fastest,
        "gamma": system.gamma,
        "equivalent_mass_kg": system.mass,
        "whole_mass_kg": system.whole_mass,
        "effective_mass": system.effective_mass,
        "force_share": system.force_share,
        "stiffness_N_per_m": line.stiffness,
        "yield_base_shear_N": line.yield_force,
        "yield_control_displacement_m": line.yield_displacement,
        "ultimate_control_displacement_m": line.ultimate_displacement,
        "dropped": line.dropped,
        "yield_force_N": line.yield_force * system.force_share,
        "yield_displacement_m": line.yield_displacement / system.gamma,
        "ultimate_displacement_m": line.ultimate_displacement / system.gamma,
        "ductility": line.ultimate_displacement / line.yield_displacement,
        "slip_tolerance_share": seen.slip_share,
        "excess_stiffness_share": seen.too_stiff,
    }


def n2_check(
    approach: str,
    settings: SeismicSettings,
    state: LimitStateSettings,
    base_shear: FloatArray,
    seen: Observed,
    line: Bilinear,
) -> dict[str, Any]:
    """Return the N2 check of one curve at one limit state, in displacements of the equivalent system."""
    system, asked = seen.system, state.peak_ground_acceleration
    at_peak = float(seen.displacement[int(np.argmax(base_shear))])
    of_curve = displacement_of_curve(state.name, line, at_peak) / system.gamma
    largest = largest_force_ratio(settings, state.name)

    def spectrum(ground: float) -> Spectrum:
        return spectrum_of(settings, state, ground, settings.damping)

    def capacity(ground: float) -> float:
        return min(of_curve, displacement_at_force_ratio(largest, spectrum(ground), line, system))

    ground = largest_ground_acceleration(lambda a: demand(spectrum(a), line, system).displacement <= capacity(a))
    displacement = demand(spectrum(asked), line, system)
    row = {
        "approach": approach,
        "limit_state": state.name,
        "ag_m_per_s2": asked,
        "demand": displacement.displacement,
        "capacity": capacity(asked),
        "unit": "m",
        "capacity_ag_m_per_s2": ground,
        "safety_ratio": ground / asked,
        "period_s": displacement.period,
        "force_ratio": displacement.force_ratio,
        "largest_force_ratio": None if largest == np.inf else largest,
        "clause": CLAUSES[state.name],
    }
    remarks = _remarks_of_n2(settings, state, seen, line, row, of_curve)
    return row | {"remarks": [*remarks, *_cautions(seen, line, row)]}


def _remarks_of_n2(
    settings: SeismicSettings,
    state: LimitStateSettings,
    seen: Observed,
    line: Bilinear,
    row: dict[str, Any],
    of_curve: float,
) -> list[str]:
    """Return what must be said beside a row of N2; of_curve: displacement capacity of the curve, d* in m."""
    largest, ratio = largest_force_ratio(settings, state.name), row["force_ratio"]
    target = TARGET_REACH * row["demand"] * seen.system.gamma
    remarks = {
        f"q* ≤ {largest:g} governs the capacity: the curve goes further": row["capacity"] < of_curve,
        f"q* = {ratio:.3g} is above {largest:g}": ratio > largest,
        "the base shear has not dropped by 20 %: the end of the curve stands for it, a lower bound": (
            not line.dropped and state.name not in ("SLD", "DL")
        ),
        f"the curve ends at {in_its_unit(seen.displacement[-1], 'm')}, short of {TARGET_REACH:.0%} of the target "
        f"displacement, {in_its_unit(target, 'm')} (EN 1998-1 4.3.3.4.2.3)": bool(seen.displacement[-1] < target),
        "the spectrum is that on the ground, not at mechanism_height": settings.mechanism_height > 0.0,
    }
    return [said for said, holds in remarks.items() if holds]


def _drift(
    label: str, settings: SeismicSettings, state: LimitStateSettings, seen: Observed, line: Bilinear
) -> dict[str, Any] | None:
    """Return the check of drifts at one limit state: the pier that has its largest drift first, and its drift under the
    demand of N2; None where the code names no limit."""
    allowed = allowed_displacement(seen.drifts, seen.displacement, state.name, settings)
    if allowed is None:
        return None
    system = seen.system

    def moved(ground: float) -> float:
        displacement = demand(spectrum_of(settings, state, ground, settings.damping), line, system)
        return displacement.displacement * system.gamma

    asked, pier = state.peak_ground_acceleration, seen.drifts.piers[allowed.pier]
    ground = largest_ground_acceleration(lambda a: moved(a) <= allowed.displacement)
    remarks = {
        f"{pier.name} governs the drift, by {allowed.rule}: {pier.height:.3g} m high, {pier.width:.3g} m wide": True,
        f"no pier reaches its limit, here {allowed.limit:.2%}: the end of the curve stands for it, a lower bound": (
            not allowed.reached
        ),
    }
    return {
        "approach": f"drift, {label}",
        "limit_state": state.name,
        "ag_m_per_s2": asked,
        "demand": drift_at(seen.drifts, seen.displacement, allowed.pier, moved(asked)),
        "capacity": allowed.limit if allowed.reached else float(seen.drifts.drift[-1, allowed.pier]),
        "unit": "drift",
        "capacity_ag_m_per_s2": ground,
        "safety_ratio": ground / asked,
        "clause": DRIFT_CLAUSES[state.name] if settings.largest_drift is None else GIVEN,
        "remarks": [said for said, holds in remarks.items() if holds],
    }


def _cautions(seen: Observed, line: Bilinear, row: dict[str, Any]) -> list[str]:
    """Return what must be said of a ratio that rests on more than its formulas were made for."""
    ductility = line.ultimate_displacement / line.yield_displacement
    said = {
        f"{seen.slip_share:.0%} of the elastic displacement is the slip tolerance of the contact law: "
        f"T* = {row['period_s']:.3g} s is made by it, not by masonry": seen.slip_share > SLIPPERY,
        f"elements make stones {seen.too_stiff:.0%} too stiff, and the wall more, by the jumps of stress between them: "
        "with half the mesh.size T* and the demand grow": seen.too_stiff > TOO_STIFF,
        f"ductility above {DUCTILE:g}: equal energy, from which the demand comes, was not made for it": (
            ductility > DUCTILE
        ),
        f"a ratio above {DUCTILE:g} says that this check does not govern, not how strong the wall is": (
            row["safety_ratio"] > DUCTILE
        ),
        f"the control point moves {seen.share_of_fastest:.0%} of the fastest stone: it is outside the mechanism": (
            seen.share_of_fastest < OUTSIDE
        ),
    }
    return [text for text, holds in said.items() if holds]
