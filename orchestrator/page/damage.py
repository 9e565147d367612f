"""Damage sequence: which joint opens or slides first, at which load and displacement."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from orchestrator.masonry.wall import FloatArray
from orchestrator.pushover.state import Increment
from orchestrator.results import ContactPlaces

Kind = Literal["opens", "slides"]


@dataclass(frozen=True, slots=True)
class Damage:
    """A joint's first opening or sliding beyond the limit: `interface` and `step` are numbers.

    `at_end`: opening or slip of the same joint at the end of the curve, m.
    """

    interface: int
    kind: Kind
    step: int
    load_multiplier: float
    base_shear: float
    control_displacement: float
    at_end: float


def damage_sequence(increments: Iterable[Increment], contacts: ContactPlaces, limit: float) -> list[Damage]:
    """Return every joint's first opening and first sliding by more than `limit` (m) since gravity, in order of load.

    increments: the state under gravity, then the lateral ones. A joint opens where its widest contact does; it slides
    where a contact that stays closed slips. Displacements are relative to the state under gravity.
    """
    states = iter(increments)
    gravity = next(states)
    found: dict[tuple[int, Kind], tuple[Increment, float]] = {}
    last: dict[tuple[int, Kind], float] = {}
    for state in states:
        for kind, values in _since(gravity, state, contacts).items():
            for interface in np.flatnonzero(values > limit).tolist():
                found.setdefault((interface, kind), (state, float(values[interface])))
            last |= {(interface, kind): float(values[interface]) for interface, k in found if k == kind}
    ordered = sorted(found.items(), key=lambda item: (item[1][0].number, -item[1][1]))
    return [
        Damage(
            interface, kind, state.number, state.load_multiplier, state.base_shear,
            state.control_displacement - gravity.control_displacement, last[interface, kind],
        )
        for (interface, kind), (state, _) in ordered
    ]  # fmt: skip


def _since(gravity: Increment, state: Increment, contacts: ContactPlaces) -> dict[Kind, FloatArray]:
    """Return the growth of opening and of slip (interfaces,) in m."""
    count = len(contacts.interface)
    opening = _grown(gravity.gap[:count], state.gap[:count])
    slip = _grown(gravity.slip[:count], state.slip[:count])
    return {"opens": _largest(opening, contacts.interface), "slides": _largest(slip, contacts.interface)}


def _grown(before: FloatArray, now: FloatArray) -> FloatArray:
    """Return now - before; where a contact has gone (nan) it says nothing."""
    return np.nan_to_num(now - before)


def _largest(values: FloatArray, group: npt.NDArray[np.int64]) -> FloatArray:
    largest = np.zeros(int(group.max(initial=-1)) + 1)
    np.maximum.at(largest, group, values)
    return largest
