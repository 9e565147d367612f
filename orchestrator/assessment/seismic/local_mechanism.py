"""The mechanism of micro limit analysis, verified by the kinematic approach (kinematic.py has its formulas).

It rests on the lowest non-associative state found, that of stones which come loose before the wall fails included,
under a horizontal load proportional to mass; another load is analysed anew for that one, because alpha_0 is a part of g
only there. EN 1998-3 has no such approach: with a spectrum
of EN 1998-1 its DL, SD and NC are taken as SLD, SLV and SLC of Circolare 7/2019, and the rows say so.

Bond (cohesion and tensile strength of joints) bears until it opens: the mechanism starts (SLD) at alpha_0 with it. What
rocks has opened its joints, and a bond that has opened bears nothing. So q at SLV, d_0* and a(d) are of the wall in
which the joints that open or slip in the mechanism have neither cohesion nor tensile strength, analysed anew; joints
that stay closed keep theirs.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import inf
from typing import Any

import numpy as np

from orchestrator.assessment.seismic.kinematic import (
    DAMPING,
    LOW_PARTICIPATION,
    Kinematics,
    Moving,
    activation_acceleration,
    kinematics,
    participation_used,
    rocking_displacement,
    rocking_period,
)
from orchestrator.assessment.seismic.n2 import largest_ground_acceleration
from orchestrator.assessment.seismic.settings import LIKE, LimitStateName, LimitStateSettings, SeismicSettings
from orchestrator.assessment.seismic.spectrum import FloorSpectrum, Spectrum, spectrum_at_height
from orchestrator.basis.arrays import FloatArray, IntArray, read_only
from orchestrator.basis.errors import CaseError, ConvergenceError
from orchestrator.basis.printed import printed
from orchestrator.geometry.rigid import velocity_of_points
from orchestrator.limit_analysis import LimitAnalysis, LimitAnalysisSettings, LimitState, Mechanism, analyse
from orchestrator.loads import LoadSettings, loads_on
from orchestrator.loads.block_loads import extra_dead_loads, live_loads
from orchestrator.macroblocks.criteria import MacroblockSettings, merged
from orchestrator.masonry.block_properties import block_centroids
from orchestrator.masonry.joints import Assemblage

AS_ONE = MacroblockSettings(choose="tolerances", evaluate_at="ends", tol_n=1e-3, tol_s=1e-3, tol_d=inf)
"""neighbours move as one where their joint opens and slips by less than this part of the largest displacement"""
UPPER_BOUND = (
    "no non-associative state was found: the associative multiplier is an upper bound, and walls that fall under their "
    "own weight can have one"
)
NOT_TURNING = "the multiplier of this mechanism does not fall to zero by turning: it slides, and has no d0*"
SEVERAL_TURNS = (
    "its bodies turn by different angles, so that their centres of rotation move: d0* of such a mechanism is not known"
)
OPENED = "once its bond has opened"
"""how a refusal begins of a wall of which no more is known than where it starts to move"""
CHECKS = {"SLD": ("activation",), "SLV": ("linear", "non-linear"), "SLC": ("non-linear",)}
"""of the kinematic approach, at the limit states of Circolare 7/2019"""
SLIDING = 0.1
"""part of the live load's power taken by friction above which d_0* is called an upper bound"""
STRONGER = 10.0
"""ratio above which it says only that the check does not govern"""


@dataclass(frozen=True, eq=False, slots=True)
class InMechanism:
    """A mechanism with what moves in it: all masses the live load acts on, all dead loads; remarks say what was done.

    state: what it is the mechanism of, in words. opened: the mechanism once the bond that it opens is gone, or why
    there is none to rest on; None where it opens no bond.
    """

    state: str
    kinematics: Kinematics
    remarks: tuple[str, ...]
    opened: InMechanism | str | None = None


def safest_state(analysis: LimitAnalysis) -> LimitState | None:
    """Return the lowest non-associative state, None where there is none.

    Stones that come loose before the wall fails are such a state: what they fall on is not asked. So is a last rest
    that no limit state closed, lest a higher state found elsewhere stands for a wall of which that is not known.
    """
    others = [state for state in (analysis.lowest, analysis.sequence) if state is not None and state.converged]
    states = [failure.state for failure in analysis.local_failures] + [*filter(None, [analysis.path]), *others]
    return min(states, key=lambda state: state.load_multiplier, default=None)


def loads_in_mechanism(
    assemblage: Assemblage, load: LoadSettings, settings: LimitAnalysisSettings, analysis: LimitAnalysis
) -> InMechanism | str:
    """Return the lowest state's mechanism with its masses, analysed anew where the load is not horizontal and
    proportional to mass; or why there is none to rest on."""
    by_mass = replace(load, distribution="mass", inclination=0.0, live=(), cases=())
    remarks: tuple[str, ...] = ()
    if (load.distribution, load.inclination) != ("mass", 0.0):
        try:
            by_mass_on = loads_on(assemblage.wall, by_mass)
            analysis = analyse(assemblage, settings, by_mass_on, analysis.elastic_modulus)
        except (CaseError, ConvergenceError) as error:
            return f"under a horizontal load proportional to mass: {error}"
        remarks = ("analysed for a horizontal load proportional to mass, not for the load of this case",)
    state = safest_state(analysis)
    if state is None:
        return UPPER_BOUND
    found = _mechanism_of(assemblage, by_mass, state, remarks + said_of(state, analysis))
    return replace(found, opened=_opened(assemblage, by_mass, settings, analysis, remarks))


def _opened(
    assemblage: Assemblage,
    by_mass: LoadSettings,
    settings: LimitAnalysisSettings,
    analysis: LimitAnalysis,
    remarks: tuple[str, ...],
) -> InMechanism | str | None:
    """Return the mechanism of a wall once the bond that it opens is gone, or why there is none; None if it opens none.

    The wall without it may fail another way, and open more: it is analysed until its mechanism opens no bond.
    """
    start = state = safest_state(analysis)
    while state is not None and (parted := with_bond_opened(assemblage, state.mechanism)) is not None:
        assemblage = parted
        try:
            analysis = analyse(parted, settings, loads_on(parted.wall, by_mass), analysis.elastic_modulus)
        except CaseError as error:
            return f"{OPENED}: {error.problem}"
        except ConvergenceError as error:
            return f"{OPENED}: {error}"
        state = safest_state(analysis)
    if state is start:
        return None
    if state is None or start is None:
        return f"{OPENED}: {UPPER_BOUND}"
    then, first = (printed("multiplier", one.load_multiplier) for one in (state, start))
    said = f"a bond that has opened bears nothing: alpha_0 = {then} then, {first} to open it"
    return _mechanism_of(assemblage, by_mass, state, (*remarks, *said_of(state, analysis), said))


def _mechanism_of(
    assemblage: Assemblage, load: LoadSettings, state: LimitState, remarks: tuple[str, ...]
) -> InMechanism:
    """Return the mechanism of a state under a load proportional to mass."""
    masses, dead = moving_loads(assemblage, load, state.mechanism)
    stones = np.concatenate([block.polygon for block in assemblage.wall.blocks if not block.fixed])
    reach = float(np.hypot(*np.ptp(stones, axis=0)))
    return InMechanism(state.name, kinematics(state.load_multiplier, masses, dead, load.vector, reach), remarks)


def with_bond_opened(assemblage: Assemblage, mechanism: Mechanism) -> Assemblage | None:
    """Return the wall in which joints that open or slip in a mechanism have neither cohesion nor tensile strength, None
    where none of them had any."""
    joints, body = assemblage.joints, merged(assemblage, mechanism, AS_ONE).body_of_block
    parts = (body[joints.i] != body[joints.j]) & ((joints.cohesion > 0.0) | (joints.tensile_strength > 0.0))
    if not parts.any():
        return None
    cohesion, tension = (read_only(np.where(parts, 0.0, one)) for one in (joints.cohesion, joints.tensile_strength))
    return replace(assemblage, joints=replace(joints, cohesion=cohesion, tensile_strength=tension))


def said_of(state: LimitState, analysis: LimitAnalysis) -> tuple[str, ...]:
    """Return what must be said beside a mechanism that is not simply that of the wall's limit state."""
    local = next((failure for failure in analysis.local_failures if failure.state is state), None)
    if local is not None:
        stones = ", ".join(map(str, local.stones))
        share = f"{100 * local.share:.2g} % of the dead load"
        return (f"a local failure: stones {stones} ({share}) move, not the wall",)
    if state.converged:
        return ()
    if state.flow_rule == "large_displacements":
        return ("alpha_0 is the peak in large displacements: it lies below the collapse state of the wall as drawn",)
    return ("alpha_0 is the last load at which the wall rests: no limit state was closed",)


def moving_loads(assemblage: Assemblage, load: LoadSettings, mechanism: Mechanism) -> tuple[Moving, Moving]:
    """Return the masses that a load proportional to mass acts on, and all dead loads, with their velocities.

    Stones that move as one are one body; the floors that one body carries are another one, at their own place (the Q_k
    of C8.7.1.2.1.1 beside its P_k).
    """
    wall = assemblage.wall
    live, extra = live_loads(wall, load), extra_dead_loads(wall, load.dead)
    stones = sum(not block.fixed for block in wall.blocks)
    body = merged(assemblage, mechanism, AS_ONE).body_of_block
    number = body[live.block] + np.where(np.arange(len(live.block)) < stones, 0, body.max() + 1)
    own, velocity = slice(0, stones), partial(_velocity_at, assemblage, mechanism)
    masses = Moving(live.size, velocity(live.block, live.point), number)
    block, point = np.append(live.block[own], extra.block), np.vstack([live.point[own], extra.point])
    return masses, Moving(np.append(live.size[own], extra.size), velocity(block, point), body[block])


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
        return _spectrum(settings, state, ground, settings.damping).peak_acceleration / divided

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
        return period, lambda ground: _spectrum(settings, state, ground, damping).displacement(period)

    def capacity(start: float) -> float:
        needed = at_displacement(start)[1]
        return largest_ground_acceleration(lambda ground: needed(ground) <= allowed)

    asked = state.peak_ground_acceleration
    start = _start_that_counts(has, acceleration, capacity)
    ground = capacity(start)
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
        lambda ground: _spectrum(settings, state, ground, settings.damping).peak_acceleration <= onset
    )
    said = []
    if starts > ground:
        allows = f"C8.7.1.2.1.8 allows ratio {printed('ratio', starts / state.peak_ground_acceleration)}"
        said.append(f"it starts to move at a_g = {printed('acceleration', starts)} m/s2 only: {allows}")
    if has.friction_share > SLIDING:
        share = f"friction or crushing of joints takes {has.friction_share:.0%} of the live load's power"
        said.append(f"{share}, and is taken to do so to the end: d0* is an upper bound")
    return said


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


def _spectrum(
    settings: SeismicSettings, state: LimitStateSettings, ground: float, damping: float
) -> Spectrum | FloorSpectrum:
    return spectrum_at_height(settings, state, ground, damping)


def _velocity_at(assemblage: Assemblage, mechanism: Mechanism, block: IntArray, point: FloatArray) -> FloatArray:
    """Return the velocities (p, 3) of points (p, 2) of blocks (p,)."""
    of_block = mechanism.velocities[block]
    arm = point - block_centroids(assemblage.wall)[block]
    return np.column_stack([velocity_of_points(of_block, arm), of_block[:, 2]])
