"""Kinematic approach: what a mechanism of rigid bodies withstands. SI units. Circolare 7/2019, C8.7.1.2.1.

    participation       e* = (sum W delta)^2 / (sum W  sum W delta^2), W = P + Q             [C8.7.1.5]
    acceleration        a_0* = alpha_0 g / (e* FC)                                           [C8.7.1.3]
    SLD                 a_Z <= a_0*; on the ground a_g S <= a_0*                             [C8.7.1.8]
    SLV, linear         a_Z / q <= a_0*                                                      C8.7.1.2.1.7
    SLV, SLC            d_SLV = 0.4 d_0*, d_SLC = 0.6 d_0*                                   C8.7.1.2.1.6
                        a(d) = a_0* (1 - d / d_0*)
                        T_SLV = 1.68 pi sqrt(d_SLV / a(d_SLV)), T_SLC = 1.56 pi sqrt(...)    [C8.7.1.10], [C8.7.1.11]
                        S_De(T, damping 8 %, 10 %) <= d                                      C8.7.1.2.1.8, [C8.7.1.12]

W are the weights of all masses that the live load acts on, delta their virtual horizontal displacements.

What lifts no weight counts with e* = 1, whatever the speeds of its bodies. Slabs that slide on each other are each at
the limit by itself, so that they may move as one at the same alpha_0, and of mechanisms with one alpha_0 that with the
largest e* starts first; of others, as those that turn about upright axes, it is on the safe side.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, pi, sqrt

import numpy as np

from orchestrator.assessment.seismic.settings import LimitStateName
from orchestrator.basis.arrays import FloatArray, IntArray
from orchestrator.masonry.wall import GRAVITY

MECHANISM_SPEED = 0.1
"""bodies slower than this part of the fastest do not belong to the mechanism"""
LOW_PARTICIPATION = 0.75
"""participation below which e* says more of slow bodies than of the mechanism"""
LIFTS = 0.01
"""net part of the live load's power that lifts weights up to which a mechanism lifts none"""
ONE_TURN = 0.01
"""rotation rates that differ by no more than this part of the largest are one; what is that slow, over the fastest,
rests"""
ULTIMATE: dict[LimitStateName, float] = {"SLV": 0.4, "SLC": 0.6}
"""part of d_0* that may be used: C8.7.1.2.1.6"""
PERIOD: dict[LimitStateName, float] = {"SLV": 1.68, "SLC": 1.56}
"""factor of pi sqrt(d / a): [C8.7.1.10], [C8.7.1.11]"""
DAMPING: dict[LimitStateName, float] = {"SLV": 0.08, "SLC": 0.10}
"""part of critical damping of a mechanism that rocks: C8.7.1.2.1.8"""


@dataclass(frozen=True, eq=False, slots=True)
class Moving:
    """Loads that move with a mechanism: weight (n,) in N, velocities (n, 3) of their points of attack (u, v, rotation
    rate, in any one scale), body (n,): what moves as one has one number."""

    weight: FloatArray
    velocities: FloatArray
    body: IntArray


@dataclass(frozen=True, slots=True)
class Kinematics:
    """What a mechanism has: alpha_0, participation e*, how many bodies move, d_0* in m where it rocks, and the part of
    the live load's power that friction takes (and crushing, where joints crush). one_turn: whether all that moves turns
    at one rate: d_0* of what does not is none of fixed centres of rotation, and not known."""

    multiplier: float
    participation: float
    bodies: int
    displacement: float | None
    friction_share: float
    one_turn: bool = True


def kinematics(multiplier: float, masses: Moving, dead: Moving, forward: FloatArray, reach: float = inf) -> Kinematics:
    """Return participation and finite displacement of a mechanism under a horizontal live load of all `masses`.

    dead: all weights, also those without mass, which do work only (P_k and Q_k of the clause are `masses`). forward
    (2,): unit vector of the live load. reach: size of the wall, m; what turns is in balance before it has gone so far,
    and what is not slides (its turn may be rounding).
    """
    weight, delta = as_bodies(masses.weight, masses.velocities[:, :2], masses.body, forward)
    live, friction = powers(multiplier, masses, dead, forward)
    balance = balance_displacement(friction, at_centroids(masses), dead)
    balance = None if balance is None or balance > reach else balance
    one_turn = turns_as_one(dead, reach)
    known = balance if one_turn else None
    share = participation_with(weight, delta, live - friction, live)
    return Kinematics(multiplier, share, len(weight), known, friction / live, one_turn)


def as_bodies(
    weight: FloatArray, velocity: FloatArray, body: IntArray, forward: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return weight (b,) in N and displacement along the load (b,) of the bodies that move, in the mechanism's scale.

    weight (n,), velocity (n, d), body (n,): of masses; forward (d,): of the load, in the plane or in space. Masses of
    one number are one body at their common centroid: the clause's sums run over bodies, and a rigid part has one
    participation however many stones it is made of. Bodies slower than MECHANISM_SPEED of the fastest are left out.
    """
    _, body = np.unique(body, return_inverse=True)
    total = np.bincount(body, weight)
    mean = np.column_stack([np.bincount(body, weight * one) / total for one in velocity.T])
    speed = np.linalg.norm(mean, axis=1)
    moving = speed > MECHANISM_SPEED * speed.max()
    return total[moving], mean[moving] @ forward


def at_centroids(masses: Moving) -> Moving:
    """Return the masses of each body as one at their centroid, as `as_bodies` takes them: d_0* of a rigid part is one,
    too, however many stones it is made of."""
    number, body = np.unique(masses.body, return_inverse=True)
    total = np.bincount(body, masses.weight)
    mean = [np.bincount(body, masses.weight * one) / total for one in masses.velocities.T]
    return Moving(total.astype(float), np.column_stack(mean), number)


def participation(weight: FloatArray, delta: FloatArray) -> float:
    """Return e* of weights (b,) with virtual displacements delta (b,) along the load [C8.7.1.5]."""
    return float((weight @ delta) ** 2 / (weight.sum() * (weight @ delta**2)))


def participation_with(weight: FloatArray, delta: FloatArray, lifting: float, live: float) -> float:
    """Return e* of bodies of which a part of the live load's power lifts weights, net (lifting, live: in one unit)."""
    return participation(weight, delta) if lifting > LIFTS * live else 1.0


def participation_used(found: float) -> float:
    """Return the e* that a_0* is divided by: a low one would raise it for bodies that hardly move, and counts as 1."""
    return found if found >= LOW_PARTICIPATION else 1.0


def activation_acceleration(multiplier: float, share: float, confidence: float) -> float:
    """Return a_0* in m/s2 of alpha_0, e* and FC [C8.7.1.3]."""
    return multiplier * GRAVITY / (share * confidence)


def rocking_displacement(state: LimitStateName, balance: float) -> float:
    """Return d_SLV or d_SLC in m of d_0* (C8.7.1.2.1.6), connected elements aside."""
    return ULTIMATE[state] * balance


def rocking_period(state: LimitStateName, displacement: float, acceleration: float, balance: float) -> float:
    """Return T_SLV or T_SLC in s at a displacement m, of a_0* m/s2 and d_0* m [C8.7.1.10], [C8.7.1.11]."""
    at_displacement = acceleration * (1.0 - displacement / balance)
    return PERIOD[state] * pi * sqrt(displacement / at_displacement)


def powers(multiplier: float, masses: Moving, dead: Moving, forward: FloatArray) -> tuple[float, float]:
    """Return the power of the live load at alpha_0, and what joints dissipate of it: the rest lifts weights."""
    live = multiplier * float(masses.weight @ (masses.velocities[:, :2] @ forward))
    return live, live - float(dead.weight @ dead.velocities[:, 1])


def turns_as_one(dead: Moving, reach: float) -> bool:
    """Return whether all weights that move turn at one rate, or none turns by which `reach` (m) would move.

    Bodies that turn at different rates turn about each other, and their centres of rotation move.
    """
    u, v, w = dead.velocities.T
    speed = np.hypot(u, v)
    rates = w[speed > ONE_TURN * speed.max()]
    return bool(np.ptp(rates) <= ONE_TURN * max(np.abs(rates).max(), speed.max() / reach))


def balance_displacement(friction: float, masses: Moving, dead: Moving) -> float | None:
    """Return d_0* in m, where the multiplier has fallen to zero, or None where it does not by turning [C8.7.1.4].

    friction: what it (and crushing) dissipates, in the units of weight x velocity, to the end; bond that has opened
    dissipates nothing, and is none of it. Every body turns about a fixed centre of rotation (`turns_as_one`), so the
    velocity of a point turns with it. d_0* = sum(W delta d) / sum(W delta) with d the displacements there: d_C sum(W
    delta^2) / (delta_C sum(W delta)) of the clause, where d is proportional to delta.
    """
    u, v, w = dead.velocities.T

    def left(time: float) -> float:
        return float(friction + dead.weight @ (v * np.cos(w * time) + u * np.sin(w * time)))

    time = _first_zero(left, 0.5 * pi / max(float(np.abs(w).max()), 1e-300))
    if time is None:
        return None
    u, v, w = masses.velocities.T
    angle = w * time
    moved = time * (u * np.sinc(angle / pi) - v * np.sin(0.5 * angle) * np.sinc(0.5 * angle / pi))
    work = masses.weight * u
    return float(abs(work @ moved / work.sum()))


def _first_zero(function: Callable[[float], float], end: float) -> float | None:
    """Return the first zero up to `end` of a function that is positive at 0, None where there is none."""
    from scipy.optimize import brentq

    times = np.linspace(0.0, end, 2001)
    below = next((k for k, time in enumerate(times) if function(float(time)) <= 0.0), None)
    return float(brentq(function, times[below - 1], times[below])) if below else None
