"""Where an increment is expected to end: every body goes on with its last motion.

A straight line stretches a body that turns by theta in an increment by theta^2 (it follows the tangent of a circle): at
5e-3 rad stresses of 90 kPa in a stone of 3.5 GPa, several weights of a wall, from which Newton would have to begin.
"""

from __future__ import annotations

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.pushover.contact.frames import fit_frames
from orchestrator.pushover.model import ContactModel


def carried_on(model: ContactModel, displacement: FloatArray, last_change: FloatArray, share: float) -> FloatArray:
    """Return the displacement (n,) after `share` times the last change (n,), in m, which ended with `displacement`.

    The last motion of a body in the wall's plane is x -> R(a) x + t and a change of its strain that turns with it.
    `share` times that is a turn by share x a about the same point: x -> R(share a) x + s R((share - 1) a / 2) t, with
    s = sin(share a / 2) / sin(a / 2), share for a = 0 (sum of a geometric series). In small displacements (no tracking)
    every node moves on straight, and out of the plane in any case.
    """
    now, change = displacement.reshape(-1, 3), last_change.reshape(-1, 3)
    predicted = now + share * change
    if model.tracking is None:
        return predicted.ravel()
    old, new = (fit_frames(model.front, u, model.bodies) for u in (now - change, now))
    angle = new.angle - old.angle
    shift = new.translation - _turned(old.translation, angle)
    series = share * np.sinc(0.5 * share * angle / np.pi) / np.sinc(0.5 * angle / np.pi)
    going_on = series[:, None] * _turned(shift, 0.5 * (share - 1) * angle)
    home = np.zeros((len(now), 2))  # departures of curved edges are vectors: they turn, and have no place
    home[: len(model.front.nodes)] = model.front.nodes[:, :2]
    placed = np.arange(len(now))[:, None] < len(model.front.nodes)
    point, before = home + now[:, :2], home + (now - change)[:, :2]
    strain = point - _turned(before, angle[model.body]) - shift[model.body] * placed
    turned = _turned(point + share * strain, share * angle[model.body])
    predicted[:, :2] = turned + going_on[model.body] * placed - home
    return predicted.ravel()


def _turned(points: FloatArray, angle: FloatArray) -> FloatArray:
    """Return points (k, 2) turned by angle (k,).

    Not with complex numbers: whether NumPy rounds their products once or twice depends on where small arrays lie in
    memory, and equal ranks would come to unequal numbers.
    """
    cosine, sine = np.cos(angle), np.sin(angle)
    x, y = points[:, 0], points[:, 1]
    return np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=1)
