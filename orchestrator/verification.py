"""Verification of a run against its spectrum: every curve by N2, the mechanism by the kinematic approach -> summary."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from orchestrator.capacity import SECANT, idealise
from orchestrator.errors import ResultError
from orchestrator.joints import Assemblage
from orchestrator.limit_analysis import LimitAnalysis
from orchestrator.masonry.geometry import block_weights
from orchestrator.masonry.wall import FloatArray
from orchestrator.pushover.state import Increment, PushoverCurve
from orchestrator.seismic import (
    EquivalentSystem,
    SeismicSettings,
    demand,
    equivalent_system,
    kinematics,
    largest_ground_acceleration,
    secant_period,
    spectrum_of,
)

if TYPE_CHECKING:
    from orchestrator.pushover.model import ContactModel


def elastic_step(curve: PushoverCurve) -> int:
    """Return the increment whose shape the equivalent system has: the first at SECANT of the peak, as the bilinear."""
    above = int(np.argmax(curve.base_shear_N >= SECANT * curve.base_shear_N.max()))
    return int(curve.step[max(above, 1)])  # row 0 has not moved


def equivalent_system_of(model: ContactModel, gravity: Increment, state: Increment) -> EquivalentSystem:
    """Return the equivalent system of a pushover that moves as `state` does since `gravity`.

    Masses and the horizontal part of the live load are those of the finite elements, by node.
    """
    moved = (state.displacement - gravity.displacement).ravel()
    along = model.direction * np.tile([1.0, 0.0, 0.0], len(moved) // 3)
    ground = np.where(np.arange(len(moved)) < model.meshes.nodes.size, np.abs(along), 0.0)  # edges do not depart
    return equivalent_system(model.mass, along * moved / float(model.top_row @ moved), along * model.lateral, ground)


def verify(
    settings: SeismicSettings,
    assemblage: Assemblage,
    analysis: LimitAnalysis,
    curves: Mapping[str, tuple[PushoverCurve, EquivalentSystem]],
) -> dict[str, Any] | None:
    """Return the record `seismic` of the summary, None where no verification is asked for. Raises CaseError."""
    asked = settings.peak_ground_acceleration
    if asked is None:
        return None
    wall = assemblage.wall
    free = np.array([not block.fixed for block in wall.blocks])
    weight = block_weights(wall)
    spectrum = spectrum_of(settings, asked)
    symbols = ("ag_m_per_s2", "S", "TB_s", "TC_s", "TD_s", "F0", "eta")
    return {
        "spectrum": {
            "kind": settings.spectrum,
            "ground": settings.ground,
            **dict(zip(symbols, asdict(spectrum).values(), strict=True)),
        },
        "pushover": [_pushover(name, settings, asked, *curve) for name, curve in curves.items()],
        "kinematic": _kinematic(settings, asked, weight[free], free, analysis),
    }


def _pushover(
    name: str, settings: SeismicSettings, asked: float, curve: PushoverCurve, system: EquivalentSystem
) -> dict[str, Any]:
    """Return the N2 verification of one curve."""
    try:
        line = idealise(curve.base_shear_N, curve.control_displacement_m)
    except ResultError as error:
        return {"model": name, "remark": str(error)}
    found = demand(spectrum_of(settings, asked), line, system)
    ultimate = line.ultimate_displacement / system.gamma

    def passes(ground: float) -> bool:
        needed = demand(spectrum_of(settings, ground), line, system)
        return needed.displacement <= ultimate and needed.force_ratio <= settings.largest_force_ratio

    capacity = largest_ground_acceleration(passes)
    dropped = "" if line.dropped else "the curve ends before the base shear drops: the capacity is a lower bound"
    return {
        "model": name,
        "gamma": system.gamma,
        "equivalent_mass_kg": system.mass,
        "effective_mass": system.effective_mass,
        "force_share": system.force_share,
        "stiffness_N_per_m": line.stiffness,
        "yield_force_N": line.yield_force * system.force_share,
        "yield_displacement_m": line.yield_displacement / system.gamma,
        "period_s": found.period,
        "force_ratio": found.force_ratio,
        "demand_m": found.displacement,
        "capacity_m": ultimate,
        "capacity_ag_m_per_s2": capacity,
        "safety_ratio": capacity / asked,
        "remark": dropped,
    }


def _kinematic(
    settings: SeismicSettings, asked: float, weight: FloatArray, free: np.ndarray, analysis: LimitAnalysis
) -> dict[str, Any]:
    """Return the linear and (for a mechanism that rocks) the non-linear kinematic approach of the headline state."""
    state = analysis.headline
    velocities = state.mechanism.velocities[free]
    found = kinematics(state.load_multiplier, weight, velocities, analysis.load_direction, settings.confidence_factor)
    linear = spectrum_of(settings, asked)

    def linear_demand(ground: float) -> float:
        return ground * spectrum_of(settings, ground).soil_factor / settings.behaviour_factor

    capacity = largest_ground_acceleration(lambda ground: linear_demand(ground) <= found.acceleration)
    record: dict[str, Any] = {
        "alpha0": state.load_multiplier,
        "e_star": found.participation,
        "a0_star_m_per_s2": found.acceleration,
        "linear": {
            "demand_m_per_s2": linear_demand(asked),
            "capacity_ag_m_per_s2": capacity,
            "safety_ratio": capacity / asked,
        },
        "nonlinear": None,
    }
    if found.displacement is not None:
        ultimate, secant, period = secant_period(found)
        capacity = largest_ground_acceleration(
            lambda ground: spectrum_of(settings, ground).displacement(period) <= ultimate
        )
        record["nonlinear"] = {
            "d0_star_m": found.displacement,
            "du_star_m": ultimate,
            "ds_star_m": secant,
            "Ts_s": period,
            "demand_m": linear.displacement(period),
            "capacity_ag_m_per_s2": capacity,
            "safety_ratio": capacity / asked,
        }
    return record
