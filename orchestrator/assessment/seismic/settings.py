"""What is asked of a seismic verification: limit states with their ground acceleration, spectrum, control point."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from math import inf
from typing import Annotated, Literal, get_args

from annotated_types import Ge, Gt, Le

from orchestrator.basis.checked import Checked
from orchestrator.basis.errors import CaseError
from orchestrator.basis.units import Unit

Spectra = Literal["ec8_type1", "ec8_type2", "ntc2018", "parameters"]
LimitStateName = Literal["DL", "SD", "NC", "SLD", "SLV", "SLC"]
EC8_STATES: tuple[LimitStateName, ...] = ("DL", "SD", "NC")
NTC_STATES: tuple[LimitStateName, ...] = ("SLD", "SLV", "SLC")
LIKE: dict[LimitStateName, LimitStateName] = dict(zip(EC8_STATES, NTC_STATES, strict=True))
"""the limit state of Circolare 7/2019 whose rules one of EN 1998-3 has, where EN 1998-3 has none of its own"""
FORCE_RATIO = {"SLV": 3.0, "SLC": 4.0}
"""largest q* of masonry: Circolare 7/2019, C7.8.1.6 (a recommendation for SLV)"""
OF_CODE = ("ground", "topography")
READS: dict[Spectra, tuple[str, ...]] = {
    "ec8_type1": OF_CODE, "ec8_type2": OF_CODE, "ntc2018": (*OF_CODE, "amplification", "reference_period"),
    "parameters": ("soil_factor", "period_b", "period_c", "period_d"),
}  # fmt: skip
"""of the settings that not every spectrum has, those that each reads"""
BUILDING = ("building_height", "building_period", "storeys")


@dataclass(frozen=True, slots=True)
class LimitStateSettings(Checked):
    """One more limit state that is verified, with its own demand."""

    name: LimitStateName
    """DL, SD or NC of EN 1998-3; SLD, SLV or SLC of NTC 2018"""
    peak_ground_acceleration: Annotated[float, Gt(0), Le(50), Unit("m/s2")]
    """a_g on rock for this limit state"""
    amplification: Annotated[float, Ge(1), Le(5)] | None = None
    """F_0 for this limit state; NTC 2018 only; left out: that of [seismic]"""
    reference_period: Annotated[float, Gt(0), Le(5), Unit("s")] | None = None
    """T_C* for this limit state; NTC 2018 only; left out: that of [seismic]"""


@dataclass(frozen=True, slots=True)
class SeismicSettings(Checked):
    """Seismic verification of the curves and of the mechanism. Without any ground acceleration there is none."""

    peak_ground_acceleration: Annotated[float, Gt(0), Le(50), Unit("m/s2")] | None = None
    """a_g on rock for `limit_state`; left out, here and in `limit_states`: no verification"""
    limit_state: LimitStateName | None = None
    """left out: SD (EN 1998-3), with ntc2018 SLV; the others are DL and NC, SLD and SLC"""
    limit_states: tuple[LimitStateSettings, ...] = ()
    """more limit states, each a table [[seismic.limit_states]] with `name` and `peak_ground_acceleration`"""
    spectrum: Spectra = "ec8_type1"
    """EN 1998-1 3.2.2.2, NTC 2018 3.2.3.2.1, or EN 1998-1 with soil_factor and the three periods below"""
    ground: Literal["A", "B", "C", "D", "E"] = "A"
    """ground type (EN 1998-1) or subsoil category (NTC 2018)"""
    amplification: Annotated[float, Ge(1), Le(5)] = 2.5
    """F_0; NTC 2018 only, EN 1998-1 has 2.5"""
    reference_period: Annotated[float, Gt(0), Le(5), Unit("s")] | None = None
    """T_C*; NTC 2018 needs it"""
    topography: Annotated[float, Ge(1), Le(2)] = 1.0
    """S_T, by which S is multiplied; NTC 2018 Table 3.2.V, EN 1998-5 Annex A; "parameters" has it in `soil_factor`"""
    soil_factor: Annotated[float, Gt(0), Le(5)] | None = None
    """S of "parameters" """
    period_b: Annotated[float, Gt(0), Le(10), Unit("s")] | None = None
    """T_B of "parameters" """
    period_c: Annotated[float, Gt(0), Le(10), Unit("s")] | None = None
    """T_C of "parameters" """
    period_d: Annotated[float, Gt(0), Le(10), Unit("s")] | None = None
    """T_D of "parameters" """
    damping: Annotated[float, Gt(0), Le(0.5)] = 0.05
    """part of critical damping, of the curves; a mechanism has 0.08 at SLV and 0.10 at SLC (C8.7.1.2.1.8)"""
    largest_force_ratio: Annotated[float, Ge(1), Unit("", may_be_infinite=True)] | None = None
    """largest elastic over yield force q* in all limit states; left out: 3 at SLV, 4 at SLC (C7.8.1.6), else none"""
    largest_drift: Annotated[float, Gt(0), Le(0.5)] | None = None
    """largest drift of a pier, part of its height, in all limit states; left out: that of the code"""
    confidence_factor: Annotated[float, Ge(1), Le(2)] = 1.35
    """FC of the kinematic approach: that of LC1, 1.35, where crushing is left out (C8.7.1.2.1.3)"""
    behaviour_factor: Annotated[float, Ge(1), Le(4)] = 2.0
    """q of the linear kinematic approach (C8.7.1.2.1.7)"""
    control_blocks: tuple[int, ...] = ()
    """ids of the blocks whose tops are the control point of N2; left out: roof or floor that moves most"""
    control_level: Annotated[float, Unit("m")] | None = None
    """height y of the blocks' tops that are the control point of N2, instead of `control_blocks`"""
    mechanism_height: Annotated[float, Ge(0), Unit("m")] = 0.0
    """z at which the wall stands in a building (C7.2.3); 0: on the ground. Above it needs the next three"""
    building_height: Annotated[float, Gt(0), Unit("m")] | None = None
    """H of the building the wall stands in"""
    building_period: Annotated[float, Gt(0), Le(10), Unit("s")] | None = None
    """T_1 of that building"""
    storeys: Annotated[int, Ge(1), Le(200)] | None = None
    """n of that building"""
    building_damping: Annotated[float, Gt(0), Le(0.5)] = 0.05
    """xi_1 of that building, part of critical damping"""


def refuse_ties(settings: SeismicSettings, ties: int) -> None:
    """Raise CaseError (key only) for a wall with ties that is to be verified: what a mechanism withstands ends where a
    tie breaks (C8.7.1.2.1.6), and no tie says where that is."""
    if ties and limit_states(settings):
        problem = "walls with ties are not verified, as it is not known at which elongation a tie breaks"
        raise CaseError("reinforcement.ties", problem, "leave out the ties, or [seismic]")


def limit_states(settings: SeismicSettings) -> tuple[LimitStateSettings, ...]:
    """Return every limit state that is verified, F_0 and T_C* filled in, mildest first. Raises CaseError (key only)."""
    known = known_states(settings.spectrum)
    refuse_unread(settings)
    asked = list(settings.limit_states)
    keys = [f"seismic.limit_states.{number}.name" for number in range(len(asked))]
    if settings.peak_ground_acceleration is not None:
        name = settings.limit_state or ("SLV" if settings.spectrum == "ntc2018" else "SD")
        asked.insert(0, LimitStateSettings(name, settings.peak_ground_acceleration))
        keys.insert(0, "seismic.limit_state")
    elif settings.limit_state is not None:
        remedy = 'give seismic.peak_ground_acceleration with it, as in "0.15 g"'
        raise CaseError("seismic.limit_state", f"{settings.limit_state} has no ground acceleration", remedy)
    seen: set[str] = set()
    for key, state in zip(keys, asked, strict=True):
        if state.name not in known:
            problem = f"{state.name} is no limit state of the spectrum {settings.spectrum!r}"
            raise CaseError(key, problem, f"use one of {', '.join(known)}")
        if state.name in seen:
            raise CaseError(key, f"{state.name} is given twice", "give every limit state one ground acceleration")
        seen.add(state.name)
    filled = (
        replace(
            state,
            amplification=state.amplification or settings.amplification,
            reference_period=state.reference_period or settings.reference_period,
        )
        for state in asked
    )
    return tuple(sorted(filled, key=lambda state: get_args(LimitStateName).index(state.name)))


def refuse_unread(settings: SeismicSettings) -> None:
    """Raise CaseError (key only) for a setting of another spectrum. Defaults are none: case.toml of a run has all."""
    default = SeismicSettings()
    given = [
        (f"seismic.{name}", name)
        for name in sorted(set().union(*READS.values()))
        if getattr(settings, name) != getattr(default, name)
    ] + [
        (f"seismic.limit_states.{number}.{name}", name)
        for number, state in enumerate(settings.limit_states)
        for name in ("amplification", "reference_period")
        if getattr(state, name) is not None
    ]
    for key, name in given:
        if name not in READS[settings.spectrum]:
            readers = " or ".join(repr(spectrum) for spectrum, names in READS.items() if name in names)
            remedy = f"leave it out, or give spectrum = {readers}, which reads it"
            raise CaseError(key, f"the spectrum {settings.spectrum!r} does not read it", remedy)


def without_verification(settings: SeismicSettings) -> list[str]:
    """Return a warning about settings of a verification that is not made, or none."""
    if settings.peak_ground_acceleration is not None or settings.limit_states:
        return []
    default = SeismicSettings()
    changed = (one.name for one in fields(default) if getattr(settings, one.name) != getattr(default, one.name))
    given = [f"seismic.{name}" for name in changed]
    if not given:
        return []
    return [
        f"WARNING: {', '.join(given)}: not read, as no verification is made without a ground acceleration; give "
        'seismic.peak_ground_acceleration, as in "0.15 g"'
    ]


def known_states(spectrum: Spectra) -> tuple[LimitStateName, ...]:
    """Return the limit states that go with a spectrum; "parameters" takes those of both codes."""
    return {"ntc2018": NTC_STATES, "parameters": EC8_STATES + NTC_STATES}.get(spectrum, EC8_STATES)


def largest_force_ratio(settings: SeismicSettings, state: LimitStateName) -> float:
    """Return the largest q* of a limit state: as asked, else of the code (C7.8.1.6), else inf."""
    asked = settings.largest_force_ratio
    return FORCE_RATIO.get(state, inf) if asked is None else asked


def refuse_building(settings: SeismicSettings) -> None:
    """Raise CaseError (key only) for a wall above the ground whose building is not described."""
    if settings.mechanism_height == 0.0:
        for name in (*BUILDING, "building_damping"):
            if getattr(settings, name) != getattr(SeismicSettings(), name):
                remedy = 'give seismic.mechanism_height with it, as in "6 m", or leave it out'
                raise CaseError(f"seismic.{name}", "is not read for a wall that stands on the ground", remedy)
        return
    for name in BUILDING:
        if getattr(settings, name) is None:
            problem = f"is missing for a wall at {settings.mechanism_height:g} m above the ground"
            example = {"building_height": '"9 m"', "building_period": '"0.3 s"', "storeys": "3"}[name]
            raise CaseError(f"seismic.{name}", problem, f"give it, as in {example}, or mechanism_height = 0")
    assert settings.building_height is not None
    if settings.mechanism_height > settings.building_height:
        problem = f"{settings.mechanism_height:g} m is above the building's height of {settings.building_height:g} m"
        raise CaseError("seismic.mechanism_height", problem, "give at most building_height")
