"""Element lengths along a joint that is pressed at its toe only, as it crushes or its mortar is soft (numpy only).

A toe of length x that crushes carries f_c t x, its resultant at x / 2 from the edge (on soft mortar at x / 3). Nodes
that stand for elements of length h take the resultant nearer to the edge, by up to

    h^2 / (4 x)    where h <= x,        and by 0.29 h or x / 2, whichever is less, where h > x

(half an element of the first node acts at the edge itself, and so does, at its node, the part of the last one that the
toe fills). So h = 2 (offset L x)^(1/2) keeps it within a share `offset` of the joint's length L.
"""

from __future__ import annotations

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.macroblocks.bodies import Bodies

SHORTEST = 0.0125
"""elements are no shorter than this share of the joint and of the root of the body's area: two points of contact nearer
than 0.8 % of the latter are one (one_place.COVER)"""
FINE = 1.5
"""elements are short over so many lengths of the toe: the forces at the peak are not quite those it was found from"""
GROWTH = 0.7
"""by which elements grow over the distance from there: each is about twice as long as the one before"""
SAMPLES = 2000
"""points at which the lengths along a joint are added up"""


def element_ends(bodies: Bodies, size: float, offset: float) -> dict[tuple[int, int], FloatArray]:
    """Return where elements end within the joints that have a toe, by body and edge of its outline, as shares of the
    edge (0 and 1 left out); size: largest element, m; offset: of the resultant, as a share of the joint."""
    toe, joints = bodies.toe, bodies.interfaces
    if toe is None or not toe.any():
        return {}
    root = np.sqrt([body.area for body in bodies.bodies])
    places: dict[tuple[int, int], FloatArray] = {}
    for k in np.flatnonzero(toe.any(axis=1)):
        i, j = int(joints.i[k]), int(joints.j[k])
        length = float(joints.length[k])
        least = SHORTEST * max(length, min(root[body] for body in (i, j) if body < bodies.moving))
        ends = graded(length, toe[k], size, least, offset)
        if len(ends):
            places[i, int(bodies.edge_i[k])] = ends
            places[j, int(bodies.edge_j[k])] = 1.0 - ends[::-1]
    return places


def graded(length: float, toe: FloatArray, size: float, least: float, offset: float) -> FloatArray:
    """Return where elements end within a joint (m,), as shares of its length; toe (2,): at its start and its end, m.

    Empty where elements of `size` are short enough. All lengths in m.
    """
    at = np.linspace(0.0, length, SAMPLES + 1)
    wanted = np.full_like(at, size)
    for x, distance in ((toe[0], at), (toe[1], length - at)):
        if 0.5 * x > offset * length:
            short = max(2.0 * np.sqrt(offset * length * x), least)
            wanted = np.minimum(wanted, short + GROWTH * np.maximum(distance - FINE * x, 0.0))
    per_length = 1.0 / wanted
    count = np.concatenate([[0.0], np.cumsum(0.5 * (per_length[1:] + per_length[:-1])) * length / SAMPLES])
    elements = int(np.ceil(count[-1] - 1e-6))
    if wanted.min() >= size or elements <= np.ceil(length / size - 1e-6):
        return np.empty(0)
    ends: FloatArray = np.interp(np.arange(1, elements) * count[-1] / elements, count, at) / length
    return ends
