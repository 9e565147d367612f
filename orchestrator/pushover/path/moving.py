"""Which bodies move: how far and by what angle, how much of the wall takes part, what has come off (numpy only)."""

from __future__ import annotations

import numpy as np

from orchestrator.basis.arrays import BoolArray, FloatArray
from orchestrator.basis.graphs import connected_groups
from orchestrator.loads.local_part import Shares, taking_part
from orchestrator.pushover.contact.frames import fit_frames
from orchestrator.pushover.model import ContactModel

TAKES_PART = 0.1
"""a body that moves by this share of what the moving part does belongs to it"""


def body_motion(model: ContactModel, change: FloatArray) -> FloatArray:
    """Return (b,) in m: how far each moving body goes in a change of displacement (n,), the root mean square of its
    nodes in the wall's plane."""
    body = model.front.body_of_node
    square = np.sum(change.reshape(-1, 3)[: len(body), :2] ** 2, axis=1)
    return np.sqrt(np.bincount(body, square, model.bodies) / np.bincount(body, minlength=model.bodies))


def body_size(model: ContactModel) -> FloatArray:
    """Return (b,) in m: the square root of the box round each moving body."""
    nodes, body = model.front.nodes, model.front.body_of_node
    low, high = np.full((model.bodies, 2), np.inf), np.full((model.bodies, 2), -np.inf)
    np.minimum.at(low, body, nodes[:, :2])
    np.maximum.at(high, body, nodes[:, :2])
    return np.sqrt(np.prod(high - low, axis=1))


def body_turn(model: ContactModel, first: FloatArray, second: FloatArray) -> FloatArray:
    """Return by what angle (b,) in rad each moving body turns between two displacements (n,); 0 without tracking."""
    if model.tracking is None:
        return np.zeros(model.bodies)
    angles = [fit_frames(model.front, u.reshape(-1, 3), model.bodies).angle for u in (first, second)]
    return np.asarray(np.abs(angles[1] - angles[0]), dtype=float)


def body_thrust(model: ContactModel, normal_force: FloatArray) -> FloatArray:
    """Return about what force (b,) in N goes through each moving body, of normal forces (c,) of the contacts."""
    at_nodes = (model.normal_columns @ np.abs(normal_force)).reshape(-1, 3)
    thrust = np.bincount(model.body, 0.5 * np.linalg.norm(at_nodes, axis=1), model.bodies)
    return np.asarray(thrust, dtype=float)


def participation(model: ContactModel, motion: FloatArray) -> Shares:
    """Return the shares of dead and live load that take part in a motion of the bodies (b,).

    Floors are in the loads of the bodies that they press on, as in the shares by which limit analysis tells local
    failures.
    """
    return taking_part(model.body_weight, model.body_live, motion)


def moving_part(model: ContactModel, motion: FloatArray) -> BoolArray:
    """Return the bodies (b,) that take part in a motion (b,): no slower than a tenth of its mean speed, by momentum."""
    mass = model.body_mass
    momentum = float(mass @ motion)
    mean = float(mass @ motion**2) / momentum if momentum > 0.0 else 0.0
    return motion >= TAKES_PART * mean


def without_hold(model: ContactModel, normal_force: FloatArray, fallen: BoolArray, tie_force: FloatArray) -> BoolArray:
    """Return the bodies (b,) not `fallen` that no chain of contact forces (possible contacts, N) and ties (m, N)
    connects to a support."""
    closed = normal_force != 0.0
    slave, master = (np.minimum(body[closed], model.bodies) for body in model.pairs)
    if model.ties is not None:
        ends = model.ties.body[tie_force != 0.0]
        one, other = np.where(ends < 0, model.bodies, ends).T  # an anchor holds as a support does
        slave, master = np.append(slave, one), np.append(master, other)
    part = connected_groups(model.bodies + 1, slave, master)  # all supports are one
    return (part[:-1] != part[-1]) & ~fallen
