"""The mechanism of micro limit analysis, verified by the kinematic approach (kinematic.py has its formulas).

EN 1998-3 has no such approach: with a spectrum of EN 1998-1 its DL, SD and NC are taken as SLD, SLV and SLC of
Circolare 7/2019, and the rows say so. SLD is verified at the start of the mechanism as the wall stands, SLV and SLC
once the bond that it opens has gone (local_mechanism.py).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from orchestrator.assessment.seismic.kinematic import (
    DAMPING,
    LOW_PARTICIPATION,
    Kinematics,
    activation_acceleration,
    participation_used,
    rocking_displacement,
    rocking_period,
)
from orchestrator.assessment.seismic.local_mechanism import InMechanism
from orchestrator.assessment.seismic.n2 import largest_ground_acceleration
from orchestrator.assessment.seismic.settings import LIKE, LimitStateName, LimitStateSettings, SeismicSettings
from orchestrator.assessment.seismic.spectrum import spectrum_at_height
from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.printed import printed

NOT_TURNING = "the multiplier of this mechanism does not fall to zero by turning: it slides, and has no d0*"
SEVERAL_TURNS = (
    "its bodies turn by different angles, so that their centres of rotation move: d0* of such a mechanism is not known"
)
CHECKS = {"SLD": ("activation",), "SLV": ("linear", "non-linear"), "SLC": ("non-linear",)}
"""of the kinematic approach, at the limit states of Circolare 7/2019"""
LOWEST_ALONE = (
    "of the mechanism that starts first alone: what is narrower, as a pinnacle on a pier, starts later and may still "
    "overturn before"
)
"""what is said of displacements that pass: those of no other mechanism are looked at"""
SLIDING = 0.1
"""part of the live load's power taken by friction above which d_0* is an upper bound, and a check that passes by it is
not made. Of a block that slides and rocks at the same multiplier, b/h = mu, it was twice that of rocking alone"""
STRONGER = 10.0
"""ratio above which it says only that the check does not govern"""


def kinematic_checks(
    settings: SeismicSettings, states: Sequence[LimitStateSettings], mechanism: InMechanism | str, direction: FloatArray
) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """Return what the mechanism has, for the summary, and its rows: linear and non-linear at every limit state."""
    if isinstance(mechanism, str):
        return {"refused": mechanism}, [{"approach": "kinematic approach", "limit_state": "all", "refused": mechanism}]
    has, rocks = mechanism.kinematics, mechanism.opened or mechanism
    after = None if isinstance(rocks, str) else rocks.kinematics
    used = participation_used(has.participation)
    onset = activation_acceleration(has.multiplier, used, settings.confidence_factor)
    record = {
        "state": mechanism.state,
        "direction": 1 if direction[0] > 0 else -1,
        "alpha0": has.multiplier,
        "FC": settings.confidence_factor,
        "bodies": has.bodies,
        "e_star": has.participation,
        "e_star_used": used,
        "a0_star_m_per_s2": onset,
        "alpha0_opened": after and after.multiplier,
        "d0_star_m": after and after.displacement,
        "friction_share": after and after.friction_share,
        "z_m": settings.mechanism_height,
        "remarks": list(mechanism.remarks),
    }
    rows = []
    for state in states:
        like = LIKE.get(state.name, state.name)
        rests_on = mechanism if like == "SLD" else rocks
        if isinstance(rests_on, str):
            rows += [_about(check, state) | {"refused": rests_on} for check in CHECKS[like]]
            continue
        for check in CHECKS[like]:
            made = _nonlinear if check == "non-linear" else _linear
            row = made(settings, state, like, rests_on.kinematics, onset)
            rows.append(row | {"remarks": [*rests_on.remarks, *row.get("remarks", ())]})
    return record, rows


def _about(check: str, state: LimitStateSettings) -> dict[str, Any]:
    return {"approach": f"kinematic, {check}", "limit_state": state.name}


def _linear(
    settings: SeismicSettings, state: LimitStateSettings, like: LimitStateName, has: Kinematics, _: float
) -> dict[str, Any]:
    """Return the check of SLD [C8.7.1.8], or of SLV with q (C8.7.1.2.1.7) of what rocks."""
    acceleration = activation_acceleration(has.multiplier, has.participation, settings.confidence_factor)
    divided = 1.0 if like == "SLD" else settings.behaviour_factor

    def needed(ground: float) -> float:
        return spectrum_at_height(settings, state, ground, settings.damping).peak_acceleration / divided

    def capacity(offered: float) -> float:
        return largest_ground_acceleration(lambda ground: needed(ground) <= offered)

    asked = state.peak_ground_acceleration
    start = _start_that_counts(has, acceleration, capacity)
    ground, without = capacity(start), capacity(acceleration * has.participation) / asked
    clause = "[C8.7.1.8]" if like == "SLD" else f"C8.7.1.2.1.7, q = {divided:g}"
    row = _about("activation" if like == "SLD" else "linear", state) | {
        "ag_m_per_s2": asked,
        "demand": needed(asked),
        "capacity": start,
        "unit": "m/s2",
        "capacity_ag_m_per_s2": ground,
        "safety_ratio": ground / asked,
        "safety_ratio_without_e_star": without,
        "clause": f"Circ. 7/2019 {clause}",
    }
    return row | {"remarks": _cautions(state, has, row, start / acceleration)}


def _start_that_counts(has: Kinematics, acceleration: float, capacity: Callable[[float], float]) -> float:
    """Return the acceleration at which the mechanism starts: a_0*, or with e* = 1 where e* is low and that is worse."""
    if has.participation >= LOW_PARTICIPATION:
        return acceleration
    return min((acceleration * has.participation, acceleration), key=capacity)


def _nonlinear(
    settings: SeismicSettings, state: LimitStateSettings, like: LimitStateName, has: Kinematics, onset: float
) -> dict[str, Any]:
    """Return the check of displacements at SLV or SLC (C8.7.1.2.1.8) of what rocks; onset: m/s2 at which it starts to.

    The clause lets a_g of SLD, at which the mechanism starts, be taken where it is higher: said, not used."""
    about = _about("non-linear", state)
    acceleration = activation_acceleration(has.multiplier, has.participation, settings.confidence_factor)
    if has.displacement is None:
        return about | {"refused": NOT_TURNING if has.one_turn else SEVERAL_TURNS}
    balance = has.displacement
    allowed = rocking_displacement(like, balance)
    damping = DAMPING[like]

    def at_displacement(start: float) -> tuple[float, Callable[[float], float]]:
        period = rocking_period(like, allowed, start, balance)
        return period, lambda ground: spectrum_at_height(settings, state, ground, damping).displacement(period)

    def capacity(start: float) -> float:
        needed = at_displacement(start)[1]
        return largest_ground_acceleration(lambda ground: needed(ground) <= allowed)

    asked = state.peak_ground_acceleration
    start = _start_that_counts(has, acceleration, capacity)
    ground = capacity(start)
    if has.friction_share > SLIDING and ground >= asked:
        return about | {"refused": f"{_taken(has)}: d0* is an upper bound, and what passes by it is not verified"}
    period, needed = at_displacement(start)
    without = capacity(acceleration * has.participation) / asked
    row = about | {
        "ag_m_per_s2": asked,
        "demand": needed(asked),
        "capacity": allowed,
        "unit": "m",
        "capacity_ag_m_per_s2": ground,
        "safety_ratio": ground / asked,
        "safety_ratio_without_e_star": without,
        "period_s": period,
        "damping": damping,
        "clause": f"Circ. 7/2019 C8.7.1.2.1.6, .8, [C8.7.1.1{'0' if like == 'SLV' else '1'}]",
    }
    said = _remarks_of_nonlinear(settings, state, has, onset, ground)
    return row | {"remarks": [*said, *_cautions(state, has, row, start / acceleration)]}


def _remarks_of_nonlinear(
    settings: SeismicSettings, state: LimitStateSettings, has: Kinematics, onset: float, ground: float
) -> list[str]:
    """Return what must be said of a mechanism that starts at an acceleration and passes a ground acceleration."""
    starts = largest_ground_acceleration(
        lambda ground: spectrum_at_height(settings, state, ground, settings.damping).peak_acceleration <= onset
    )
    said = []
    if starts > ground:
        allows = f"C8.7.1.2.1.8 allows ratio {printed('ratio', starts / state.peak_ground_acceleration)}"
        said.append(f"it starts to move at a_g = {printed('acceleration', starts)} m/s2 only: {allows}")
    if has.friction_share > SLIDING:
        said.append(f"{_taken(has)}, and is taken to do so to the end: d0* is an upper bound")
    if ground >= state.peak_ground_acceleration:
        said.append(LOWEST_ALONE)
    return said


def _taken(has: Kinematics) -> str:
    return f"friction or crushing of joints takes {has.friction_share:.0%} of the live load's power"


def _cautions(state: LimitStateSettings, has: Kinematics, row: dict[str, Any], share: float) -> list[str]:
    """Return what must be said beside a row of the kinematic approach; share: of a_0* that it was made with."""
    used = "e* = 1" if share < 1.0 else "e*, the lower one"
    bodies = f"{has.bodies} bod{'y' if has.bodies == 1 else 'ies'}"
    said = {
        f"e* = {has.participation:.3g} of {bodies} is below {LOW_PARTICIPATION:g}: slow bodies count in it, "
        f"the check is that of {used}": has.participation < LOW_PARTICIPATION,
        f"a ratio above {STRONGER:g} says that this check does not govern, not how strong the wall is": (
            row["safety_ratio"] > STRONGER
        ),
        f"EN 1998-3 has no kinematic approach: {state.name} as {LIKE.get(state.name)} of Circolare 7/2019": (
            state.name in LIKE
        ),
    }
    return [text for text, holds in said.items() if holds]
