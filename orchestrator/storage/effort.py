"""What a pushover cost, and what fell in it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
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
    (energies.py), over stored energy plus friction at the end plus the largest work of the live load: on a
    block that rocks dead and live work cancel, and stored energy measures nothing. events: local failures, in order.
    """

    steps: int
    moving_steps: int
    newton_iterations: int
    rescues: dict[str, int]
    energy_error: float
    events: tuple[Event, ...]


def with_energy_errors(increments: Iterable[Increment]) -> Iterator[tuple[Increment, float]]:
    """Yield increments, in order, each with the `energy_error` of a curve that ends with it."""
    imbalance = driven = 0.0
    for one in increments:
        driven = max(driven, abs(one.live_work))
        imbalance = float(np.maximum(imbalance, abs(one.energy_error)))  # max() would lose a nan
        measure = one.internal_energy + one.dissipated_energy + driven
        yield one, imbalance / measure if measure else 0.0


def effort_of(increments: Iterable[Increment], names: Sequence[str], weight: FloatArray) -> Effort:
    """Fold increments, one at a time, into their effort; names and dead load (b,) in N of the bodies."""
    steps = moving = iterations = 0
    error = 0.0
    rescues: Counter[str] = Counter()
    events: list[Event] = []
    static, rested = (0.0, 0.0), 0
    fallen = np.zeros(len(weight), bool)
    for increment, error_so_far in with_energy_errors(increments):
        steps, moving = steps + 1, moving + increment.moving
        iterations, error = iterations + increment.all_iterations, error_so_far
        rescues.update(attempt.action for attempt in increment.attempts)
        if (gone := np.flatnonzero(increment.fallen & ~fallen)).size:
            share = float(weight[gone].sum() / weight.sum())
            bodies, under_gravity = tuple(names[body] for body in gone), increment.phase == "gravity"
            events.append(Event(bodies, share, *static, increment.number, under_gravity))
        fallen = increment.fallen
        if not increment.moving:
            static, rested = (increment.load_multiplier, increment.base_shear), increment.number
    events = [event for event in events if event.increment <= rested]  # after the others the wall did not go on
    return Effort(steps, moving, iterations, dict(rescues), error, tuple(events))
