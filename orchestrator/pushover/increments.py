"""What the pushover yields: converged increments and the curve folded from them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from enum import IntEnum
from typing import Literal

import numpy as np

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray, read_only
from orchestrator.basis.printed import counted
from orchestrator.pushover.settings import SteppingSettings

Phase = Literal["gravity", "load", "displacement"]
"""what is prescribed: the share of the weight, the load multiplier, the mean displacement of the driven bodies"""
RESTED = "moved until it rested"
"""what an attempt says that was followed by motion to a state of rest"""
GAVE_WAY = "moved, bearing less on the way, until it rested"
"""the same of a wall that has borne less than before on that motion: then there was no rest"""


class ContactStatus(IntEnum):
    """State of one contact (stored as a small integer, named everywhere else)."""

    OPEN = 0
    STICK = 1
    SLIP = 2


@dataclass(frozen=True, slots=True)
class Attempt:
    """One failed try inside an increment: why it failed, what was tried (its size), what was done about it."""

    cause: str
    tried: float
    action: str
    iterations: int


@dataclass(frozen=True, eq=False, slots=True)
class Increment:
    """One converged increment of the pushover: everything needed to go on from it.

    displacement, change (m, 3): of the nodes in m, and what the increment adds; then those of curved edges
    (elasticity.py). The path itself knows those of the nodes in front only (front.py).
    normal_force (c,): contact multipliers, N, >= 0 but for bonded joints in tension. damage (c,): 0 to 1, of those.
    closing (c,): by what mortar has crushed, m. tie_force (m,) in N, tie_rest (m,) in m: of ties, pull positive, and
    what of their elongation costs no force.
    elastic_slip (c, 2): in-plane and out-of-plane part, m. slip (c,): accumulated plastic slip, m.
    gap (c,): m, negative in mortar, NaN where a possible contact does not exist. overlap (c,): m, what its gap was
    short of (or beyond) closure when sliding made the contact, taken as closed. status (c,): ContactStatus.
    base_shear: horizontal reaction of the supports against the load, N. horizontal_load: what a load multiplier of 1
    puts on the bodies that have not fallen, N.
    control_displacement: mean displacement of the top along the load, m; under_gravity: that of the wall without live
    load. mean_displacement: mean displacement of the driven bodies along the live load, weighted by it, m. Energies in
    J, work and dissipation accumulated (energies.py); live_work: of the live load alone.
    largest_base_shear: of the static increments up to here, N. out_of_balance: largest force on a body that does not
    belong to equilibrium (proximal, viscous), over its weight; moving: it is above what counts as static.
    driven, fallen (b,): bodies whose mean displacement is prescribed, and those that have been taken out. gone (b,) in
    m: how far bodies have moved since the wall was static.
    time: s; under gravity the share of the weight that acts. step: size of the next increment and of this one in the
    unit of the phase; in motion the length of the next step in m, and 0. attempts: the journal of failed tries before
    this increment.
    """

    number: int
    phase: Phase
    time: float
    load_multiplier: float
    displacement: FloatArray
    change: FloatArray
    normal_force: FloatArray
    elastic_slip: FloatArray
    slip: FloatArray
    damage: FloatArray
    closing: FloatArray
    tie_force: FloatArray
    tie_rest: FloatArray
    gap: FloatArray
    overlap: FloatArray
    status: IntArray
    base_shear: float
    horizontal_load: float
    control_displacement: float
    under_gravity: float
    mean_displacement: float
    internal_energy: float
    dissipated_energy: float
    external_work: float
    other_work: float
    live_work: float
    lost_in_motion: float
    energy_error: float
    largest_base_shear: float
    out_of_balance: float
    moving: bool
    driven: BoolArray
    fallen: BoolArray
    gone: FloatArray
    equilibrium_residual: float
    iterations: int
    step: tuple[float, ...]
    attempts: tuple[Attempt, ...] = ()

    def __str__(self) -> str:
        moved, shear = (round(1e3 * self.control_displacement, 2) + 0.0, round(1e-3 * self.base_shear, 3) + 0.0)
        bears = f"{shear:.3f} kN (λ {self.load_multiplier:.4f})"
        return f"increment {self.number} {self.phase}: {moved:.2f} mm, {bears}, {counted(self.iterations, 'iteration')}"

    @property
    def pushed(self) -> float:
        """Mean displacement of the top along the load since gravity, m."""
        return self.control_displacement - self.under_gravity

    @property
    def all_iterations(self) -> int:
        """Newton iterations of the increment and of all attempts before it."""
        return self.iterations + sum(attempt.iterations for attempt in self.attempts)


@dataclass(frozen=True, eq=False, slots=True)
class PushoverCurve:
    """Arrays (s,) of equal length over the stored increments of the lateral phases, first row the state under gravity.

    Field names and units are the columns of curve.csv. moving: 1 where the wall moves, 0 where it is static.
    """

    step: IntArray
    time_s: FloatArray
    load_multiplier: FloatArray
    base_shear_N: FloatArray
    horizontal_load_N: FloatArray
    control_displacement_m: FloatArray
    internal_energy_J: FloatArray
    dissipated_energy_J: FloatArray
    open_contacts: IntArray
    sticking_contacts: IntArray
    slipping_contacts: IntArray
    newton_iterations: IntArray
    out_of_balance: FloatArray
    moving: IntArray
    fallen_bodies: IntArray
    stopped_because: str

    @property
    def static(self) -> PushoverCurve:
        """The rows in which the wall is static: those that may give a peak."""
        return self._rows(self.moving == 0)

    def up_to(self, number: int, stopped_because: str) -> PushoverCurve:
        """Return the curve that ends with increment `number`, and why it does."""
        return replace(self._rows(self.step <= number), stopped_because=stopped_because)

    def _rows(self, rows: BoolArray) -> PushoverCurve:
        return replace(self, **{name: getattr(self, name)[rows] for name in COLUMNS})

    @classmethod
    def from_increments(cls, increments: Iterable[Increment], stopped_because: str) -> PushoverCurve:
        """Fold the last gravity increment and all lateral ones into a curve, one in memory at a time."""
        gravity: list[tuple[float, ...]] = []
        lateral: list[tuple[float, ...]] = []
        for increment in increments:
            if increment.phase == "gravity":
                gravity = [_row(increment)]
            else:
                lateral.append(_row(increment))
        columns = np.array(gravity + lateral, dtype=float).reshape(-1, len(COLUMNS)).T
        arrays = {
            name: read_only(column, np.int64 if name in WHOLE_NUMBERS else np.float64)
            for name, column in zip(COLUMNS, columns, strict=True)
        }
        return cls(**arrays, stopped_because=stopped_because)


COLUMNS = tuple(field.name for field in fields(PushoverCurve) if field.name != "stopped_because")
"""of a curve, in order"""
WHOLE_NUMBERS = (
    "step", "open_contacts", "sticking_contacts", "slipping_contacts", "newton_iterations", "moving", "fallen_bodies",
)  # fmt: skip
"""columns of a curve that count"""


def _row(increment: Increment) -> tuple[float, ...]:
    """Return one row of a curve, in the order of its columns."""
    counted = np.bincount(increment.status[~np.isnan(increment.gap)], minlength=len(ContactStatus))
    return (
        increment.number,
        0.0 if increment.phase == "gravity" else increment.time,
        increment.load_multiplier,
        increment.base_shear,
        increment.horizontal_load,
        increment.control_displacement,
        increment.internal_energy,
        increment.dissipated_energy,
        counted[ContactStatus.OPEN],
        counted[ContactStatus.STICK],
        counted[ContactStatus.SLIP],
        increment.iterations,
        increment.out_of_balance,
        increment.moving,
        increment.fallen.sum(),
    )


def end_of_curve(state: Increment, stepping: SteppingSettings, height: float) -> str | None:
    """Return why the curve ends with this increment: displacement, drop of the base shear, or number; else None.

    height: of what moves, m.
    """
    if state.number >= stepping.largest_increments:
        return f"{stepping.largest_increments} increments done"
    if state.moving:
        return None
    end = stepping.end_of(height)
    if abs(state.pushed) >= end * (1 - 1e-3):
        return f"final displacement of {1e3 * end:.4g} mm reached"
    dropped = state.base_shear < (1 - stepping.final_drop) * state.largest_base_shear
    if state.phase == "displacement" and dropped:
        return f"base shear {100 * stepping.final_drop:g} % below its peak"
    return None
