"""What a pushover cost, and what fell in it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.pushover.increments import Increment


@dataclass(frozen=True, slots=True)
class Event:
    """Bodies that fell while the wall went on: their names, share of the dead load, load multiplier and base shear (N)
    of the last static state before, and in which increment they had left their neighbours; under_gravity: they did
    before any live load acted."""

    bodies: tuple[str, ...]
    dead_load_share: float
    load_multiplier: float
    base_shear: float
    increment: int
    under_gravity: bool = False


@dataclass(frozen=True, slots=True)
class Effort:
    """What a pushover cost: folded from all its increments, gravity included.

    newton_iterations counts those of failed attempts too; moving_steps: increments in which the wall moves. rescues:
    what was done about failed attempts, and how often. energy_error: the largest imbalance of work and energies
    (increment_record.py), over stored energy plus friction at the end plus the largest work of the live load: on a
    block that rocks dead and live work cancel, and stored energy measures nothing. events: local failures, in order.
    """

    steps: int
    moving_steps: int
    newton_iterations: int
    rescues: dict[str, int]
    energy_error: float
    events: tuple[Event, ...]


def effort_of(increments: Iterable[Increment], names: Sequence[str], weight: FloatArray) -> Effort:
    """Fold increments, one at a time, into their effort; names and dead load (b,) in N of the bodies."""
    steps = moving = iterations = 0
    imbalance = turned_over = driven = 0.0
    rescues: Counter[str] = Counter()
    events: list[Event] = []
    static, rested = (0.0, 0.0), 0
    fallen = np.zeros(len(weight), bool)
    for increment in increments:
        steps, moving = steps + 1, moving + increment.moving
        iterations += increment.all_iterations
        rescues.update(attempt.action for attempt in increment.attempts)
        turned_over = increment.internal_energy + increment.dissipated_energy
        driven = max(driven, abs(increment.live_work))
        imbalance = float(np.maximum(imbalance, abs(increment.energy_error)))  # max() would lose a nan
        if (gone := np.flatnonzero(increment.fallen & ~fallen)).size:
            share = float(weight[gone].sum() / weight.sum())
            bodies, under_gravity = tuple(names[body] for body in gone), increment.phase == "gravity"
            events.append(Event(bodies, share, *static, increment.number, under_gravity))
        fallen = increment.fallen
        if not increment.moving:
            static, rested = (increment.load_multiplier, increment.base_shear), increment.number
    events = [event for event in events if event.increment <= rested]  # after the others the wall did not go on
    measure = turned_over + driven
    error = imbalance / measure if measure else 0.0
    return Effort(steps, moving, iterations, dict(rescues), error, tuple(events))
