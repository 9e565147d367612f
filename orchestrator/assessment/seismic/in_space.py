"""Start of a mechanism of blocks in space by the kinematic approach (kinematic.py has its formulas)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from orchestrator.assessment.seismic.kinematic import (
    activation_acceleration,
    as_bodies,
    participation_used,
    participation_with,
)
from orchestrator.assessment.seismic.local_mechanism import UPPER_BOUND
from orchestrator.basis.arrays import FloatArray
from orchestrator.geometry.rigid import velocity_of_points
from orchestrator.loads.dead_loads import no_mass_words
from orchestrator.space.found import SpaceAnalysis
from orchestrator.space.loads import SpaceLoadSettings, direction_of, masses_on, placed_dead_loads
from orchestrator.space.mechanism import mechanism_of
from orchestrator.space.states import SpaceState
from orchestrator.space.wall import SpaceWall

HORIZONTAL = 1e-9
"""cosine between a load and the vertical up to which it is horizontal but for rounding"""
BOUND_ONLY = "no state without dilation was looked for (limit_analysis.states): the associative multiplier is a bound"
HEADLINE_ONLY = "only the headline was looked for (limit_analysis.states): a lower state may have another mechanism"


@dataclass(frozen=True, slots=True)
class StartsAt:
    """The multiplier of the lowest state found, its participation e*, that which a_0* is divided by, and a_0* in m/s2
    for a confidence factor of 1."""

    multiplier: float
    participation: float
    used: float
    acceleration: float


def is_part_of_gravity(wall: SpaceWall, load: SpaceLoadSettings) -> bool:
    """Return whether a live load is horizontal and proportional to mass: no other's multiplier is a part of g."""
    return load.distribution == "mass" and abs(float(direction_of(load, wall.up) @ wall.up)) <= HORIZONTAL


def starts_at(load: SpaceLoadSettings, analysis: SpaceAnalysis) -> StartsAt | str:
    """Return where the mechanism of the lowest state found starts, under a load that is part of gravity; or why no
    mechanism is known that may be relied on."""
    lowest = analysis.lowest
    if analysis.looked_for != "range":
        return HEADLINE_ONLY if analysis.looked_for == "headline" else BOUND_ONLY
    if lowest is None:
        return UPPER_BOUND
    found = participation_in_space(analysis, load, lowest)
    used = participation_used(found)
    acceleration = activation_acceleration(lowest.load_multiplier, used, 1.0)
    return StartsAt(lowest.load_multiplier, found, used, acceleration)


def not_accelerated_in_space(wall: SpaceWall, load: SpaceLoadSettings) -> list[str]:
    """Return the warning of dead loads, thrusts along the ground aside, whose mass an earthquake does not
    accelerate."""
    weights = dict[str, float]()
    for number, one in enumerate(load.dead):
        force = np.sum([force for _, _, force, _ in placed_dead_loads(wall, replace(load, dead=(one,)))], axis=0)
        down = -float(force @ wall.up)
        if not one.inertia and down > HORIZONTAL * np.linalg.norm(force):
            weights[f"load.dead.{number}"] = down
    return no_mass_words(sum(weights.values()), list(weights))


def participation_in_space(analysis: SpaceAnalysis, load: SpaceLoadSettings, state: SpaceState) -> float:
    """Return e* [C8.7.1.5] of the mechanism of a state under a load that is part of gravity.

    Blocks that move as one are one body; what rests on one body is another one, at its own place (the Q_k of
    C8.7.1.2.1.1 beside its P_k).
    """
    wall, velocities = analysis.assemblage.wall, state.velocities
    mechanism = mechanism_of(analysis.assemblage, velocities)
    direction, masses = direction_of(load, wall.up), masses_on(wall, load)
    body = mechanism.body[masses.block]
    number = np.where(masses.own, body, body + mechanism.body.max() + 1)
    moved = velocity_of_points(velocities[masses.block], masses.point - wall.centroids[masses.block])
    weight, delta = as_bodies(masses.weight, moved, number, direction)
    live = state.load_multiplier * float(np.sum(analysis.loads.live * velocities))
    return participation_with(weight, delta, lifting(wall, load, velocities), live)


def lifting(wall: SpaceWall, load: SpaceLoadSettings, velocities: FloatArray) -> float:
    """Return the power (W) that lifts weights and dead loads of blocks with velocities (n, 6).

    The part of a thrust that is along the ground lifts nothing.
    """
    power = float(wall.weights @ (velocities[:, :3] @ wall.up))
    for block, point, force, _ in placed_dead_loads(wall, load):
        moved = velocity_of_points(velocities[block], point - wall.centroids[block])
        power -= float((force @ wall.up) * (moved @ wall.up))
    return power
