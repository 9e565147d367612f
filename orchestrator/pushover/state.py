"""What the pushover yields: converged increments and the curve folded from them."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Literal

import numpy as np

from orchestrator.masonry.wall import FloatArray, IntArray, read_only

Phase = Literal["gravity", "ramp", "displacement"]


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

    displacement, velocity (m, 3): nodal, m and m/s. normal_force (c,): contact multipliers, N, >= 0.
    elastic_slip (c, 2): in-plane and out-of-plane part, m. slip (c,): accumulated plastic slip, m.
    gap (c,): m. status (c,): ContactStatus. base_shear: horizontal reaction of the supports against the load, N.
    control_displacement: mean displacement of the top along the load, m. mean_displacement: mass-weighted mean
    displacement along the load, m. Energies in J.
    step: what the stepping needs to continue (size of the next increment in its own unit, and dt_p, both settings of
    the phase); attempts: the journal of failed tries before this increment.
    """

    number: int
    phase: Phase
    time: float
    load_multiplier: float
    displacement: FloatArray
    velocity: FloatArray
    normal_force: FloatArray
    elastic_slip: FloatArray
    slip: FloatArray
    gap: FloatArray
    status: IntArray
    base_shear: float
    control_displacement: float
    mean_displacement: float
    kinetic_energy: float
    internal_energy: float
    dissipated_energy: float
    external_work: float
    equilibrium_residual: float
    iterations: int
    step: tuple[float, ...]
    attempts: tuple[Attempt, ...] = ()


@dataclass(frozen=True, eq=False, slots=True)
class PushoverCurve:
    """Arrays (s,) of equal length over the stored increments of the lateral phases, first row the state under gravity.

    Field names and units are the columns of curve.csv.
    """

    step: IntArray
    time_s: FloatArray
    load_multiplier: FloatArray
    base_shear_N: FloatArray
    control_displacement_m: FloatArray
    kinetic_energy_J: FloatArray
    internal_energy_J: FloatArray
    dissipated_energy_J: FloatArray
    open_contacts: IntArray
    sticking_contacts: IntArray
    slipping_contacts: IntArray
    newton_iterations: IntArray
    stopped_because: str

    @classmethod
    def from_increments(cls, increments: list[Increment], stopped_because: str) -> PushoverCurve:
        """Fold the last gravity increment and all lateral ones into a curve."""
        rows = [i for i in increments if i.phase != "gravity"]
        rows = [i for i in increments if i.phase == "gravity"][-1:] + rows

        def counted(status: ContactStatus) -> IntArray:
            return read_only([int(np.sum(i.status == status)) for i in rows], np.int64)

        return cls(
            step=read_only([i.number for i in rows], np.int64),
            time_s=read_only([i.time for i in rows]),
            load_multiplier=read_only([i.load_multiplier for i in rows]),
            base_shear_N=read_only([i.base_shear for i in rows]),
            control_displacement_m=read_only([i.control_displacement for i in rows]),
            kinetic_energy_J=read_only([i.kinetic_energy for i in rows]),
            internal_energy_J=read_only([i.internal_energy for i in rows]),
            dissipated_energy_J=read_only([i.dissipated_energy for i in rows]),
            open_contacts=counted(ContactStatus.OPEN),
            sticking_contacts=counted(ContactStatus.STICK),
            slipping_contacts=counted(ContactStatus.SLIP),
            newton_iterations=read_only([i.iterations for i in rows], np.int64),
            stopped_because=stopped_because,
        )
