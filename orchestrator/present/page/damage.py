"""Damage sequence: which joint opens or slides first, cracks or breaks if bonded, at which load and displacement."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from orchestrator.basis.arrays import FloatArray
from orchestrator.present.joint_pieces import DAMAGED
from orchestrator.pushover.increments import Increment
from orchestrator.storage import ContactPlaces

Kind = Literal["opens", "slides", "cracks", "breaks"]
BROKEN = 1.0 - 1e-9
"""degree of damage from which a joint counts as broken"""


@dataclass(frozen=True, slots=True)
class Damage:
    """What happens to a joint for the first time: `interface` and `step` are numbers.

    `at_end`: opening or slip of the same joint in m, or its degree of damage (0 to 1), at the end of the curve;
    `at_least`: it opened that far, and farther, where its faces had no contact any more.
    """

    interface: int
    kind: Kind
    step: int
    load_multiplier: float
    base_shear: float
    control_displacement: float
    at_end: float
    at_least: bool


def damage_sequence(increments: Iterable[Increment], contacts: ContactPlaces, limit: float) -> list[Damage]:
    """Return every joint's first opening and first sliding by more than `limit` (m) since gravity, in order of load.

    increments: the state under gravity, then the lateral ones. A joint opens where its widest contact does; it slides
    where a contact that stays closed slips. The degree of damage of a bonded joint is the mean of its contacts: it
    cracks beyond DAMAGED, and breaks when all have lost tension and cohesion. Displacements are relative to the state
    under gravity.
    """
    beyond = {"opens": limit, "slides": limit, "cracks": DAMAGED, "breaks": BROKEN}
    states = iter(increments)
    gravity = next(states)
    gap = gravity.gap[: len(contacts.interface)]
    apart: set[int] = set()
    first: dict[tuple[int, Kind], tuple[Increment, float]] = {}
    last: dict[tuple[int, Kind], float] = {}
    for state in states:
        gap = _last_known(gap, state)
        for kind, values in _since(gravity, gap, state, contacts).items():
            for interface in np.flatnonzero(values > beyond[kind]).tolist():
                first.setdefault((interface, kind), (state, float(values[interface])))
            last |= {(interface, kind): float(values[interface]) for interface, k in first if k == kind}
        apart = set(contacts.interface[np.isnan(state.gap[: len(gap)]) & (gap > limit)].tolist())
    ordered = sorted(first.items(), key=lambda item: (item[1][0].number, -item[1][1]))
    return [
        Damage(
            interface, kind, state.number, state.load_multiplier, state.base_shear,
            state.control_displacement - gravity.control_displacement, last[interface, kind],
            kind == "opens" and interface in apart,
        )
        for (interface, kind), (state, _) in ordered
    ]  # fmt: skip


def _last_known(gap: FloatArray, state: Increment) -> FloatArray:
    """Return the gaps (c,) of a state in m, and those before where contacts have gone, as they do far apart."""
    now = state.gap[: len(gap)]
    return np.where(np.isnan(now), gap, now)


def _since(gravity: Increment, gap: FloatArray, state: Increment, contacts: ContactPlaces) -> dict[Kind, FloatArray]:
    """Return the growth of opening and of slip (interfaces,) in m, and the degree of damage, of both its kinds."""
    count = len(contacts.interface)
    opening = _grown(gravity.gap[:count], gap)
    slip = _grown(gravity.slip[:count], state.slip[:count])
    degree = _mean(state.damage[:count], contacts.interface)
    return {
        "opens": _largest(opening, contacts.interface),
        "slides": _largest(slip, contacts.interface),
        "cracks": degree,
        "breaks": degree,
    }


def _grown(before: FloatArray, now: FloatArray) -> FloatArray:
    """Return now - before; a contact that was not there (nan) says nothing."""
    return np.nan_to_num(now - before)


def _largest(values: FloatArray, group: npt.NDArray[np.int64]) -> FloatArray:
    largest = np.zeros(int(group.max(initial=-1)) + 1)
    np.maximum.at(largest, group, values)
    return largest


def _mean(values: FloatArray, group: npt.NDArray[np.int64]) -> FloatArray:
    return np.bincount(group, values) / np.maximum(np.bincount(group), 1)
