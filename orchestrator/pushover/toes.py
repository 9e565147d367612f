"""Element lengths along a joint that is pressed at its toe only (numpy only).

A toe of length x that crushes carries f_c t x, its resultant at x / 2 from the edge (elsewhere at x / 3). Nodes
that stand for elements of length h take the resultant nearer to the edge, by up to

    h^2 / (4 x)    where h <= x,        and by 0.29 h or x / 2, whichever is less, where h > x

(half an element of the first node acts at the edge itself, and so does, at its node, the part of the last one that the
toe fills). So h = 2 (offset L x)^(1/2) keeps it within a share `offset` of the joint's length L.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from itertools import chain

import numpy as np

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray
from orchestrator.macroblocks.bodies import Bodies

OFFSET = 0.005
"""share of a joint's length by which the resultant of a toe may lie off, where nothing else is said"""
SHORTEST = 0.0125
"""elements are no shorter than this share of the joint and of the root of the body's area: two points of contact nearer
than 0.8 % of the latter are one (one_place.COVER)"""
FINE = 1.5
"""elements are short over so many lengths of a toe that grows with its force: at the peak that is not quite the force
it was found from"""
FINE_OF_BOND = 0.5
"""over so many of a toe that does not, at a bond that has cracked or an end that stones turn about"""
GROWTH = 0.7
"""by which elements grow over the distance from there: each is about twice as long as the one before"""
ACROSS = 4.0
"""elements across a column that leans: of fewer it bends too little"""
ALONG = 8.0
"""widths of a column from its bed over which it has them"""
WIDE = 2.0
"""widths of a column up to which a body bends with it: bodies of many stones do not, of which it is a part or which it
stands on"""
SAMPLES = 500
"""points of an edge at which the lengths along it are added up"""


@dataclass(frozen=True, eq=False, slots=True)
class Toes:
    """Ends (q, 2) of joints that are pressed there only, how long elements are there (q,), and over which distance (q,)
    from the end, all in m; column (q,): width of what leans on it, and bends, inf where none does; bodies (q, 2): on
    both sides of the joint; bends (q, 2): which of them are no wider than WIDE of that column, and bend with it."""

    end: FloatArray
    element: FloatArray
    over: FloatArray
    column: FloatArray
    bodies: IntArray
    bends: BoolArray

    def of(self, *bodies: int) -> Toes:
        """Return those of joints of any of these bodies, columns where any of these bends."""
        mine = np.isin(self.bodies, bodies)
        here, bends = mine.any(axis=1), (mine & self.bends).any(axis=1)
        found = Toes(*(getattr(self, field.name)[here] for field in fields(self)))
        return replace(found, column=np.where(bends[here], found.column, np.inf))

    def wanted(self, distance: FloatArray) -> FloatArray:
        """Return how long elements (..., q) may be at a distance (..., q) from each."""
        near = self.element + GROWTH * np.maximum(distance - self.over, 0.0)
        return np.minimum(near, self.column / ACROSS + GROWTH * np.maximum(distance - ALONG * self.column, 0.0))


def element_ends(bodies: Bodies, size: float, offset: float) -> dict[tuple[int, int], FloatArray]:
    """Return where elements end within the edges of bodies at joints that have a toe, by body and edge of its outline,
    as shares of the edge (0 and 1 left out); size: largest element, m; offset: of the resultant, as a share of the
    joint. Both bodies at a joint have the same."""
    if not bodies.hinge.any() and (bodies.toe is None or not bodies.toe.any()):
        return {}
    joints, places = bodies.interfaces, dict[tuple[int, int], FloatArray]()
    beyond = dict(zip(zip(joints.i, bodies.edge_i, strict=True), joints.j, strict=True))
    beyond |= dict(zip(zip(joints.j, bodies.edge_j, strict=True), joints.i, strict=True))
    toes = _toes(bodies, size, offset)
    for body in bodies.bodies[: bodies.moving]:
        rings = (body.exterior, *body.holes)
        edges = chain.from_iterable(zip(ring, np.roll(ring, -1, axis=0), strict=True) for ring in rings)
        for edge, (start, end) in enumerate(edges):
            ends = graded(start, end, toes.of(body.number, beyond.get((body.number, edge), body.number)), size)
            if len(ends):
                places[body.number, edge] = ends
    return places


def bent_by_columns(bodies: Bodies, size: float, offset: float) -> dict[int, list[FloatArray]]:
    """Return the circles (x, y, radius) in m about toes within which bodies bend, by body: columns that lean on a toe,
    and what is as narrow under them."""
    bent = dict[int, list[FloatArray]]()
    if bodies.column is None:
        return bent
    toes = _toes(bodies, size, offset)
    for toe, side in zip(*np.nonzero(toes.bends), strict=True):
        circle = np.append(toes.end[toe], ALONG * toes.column[toe])
        bent.setdefault(int(toes.bodies[toe, side]), []).append(circle)
    return bent


def _toes(bodies: Bodies, size: float, offset: float) -> Toes:
    """Return the toes of joints whose elements have to be shorter than `size`."""
    toe = bodies.hinge if bodies.toe is None else np.maximum(bodies.toe, bodies.hinge)
    joints, root = bodies.interfaces, np.sqrt([body.area for body in bodies.bodies])
    root[bodies.moving :] = np.inf
    least = SHORTEST * np.maximum(joints.length, np.minimum(root[joints.i], root[joints.j]))
    element = np.maximum(2.0 * np.sqrt(offset * joints.length[:, None] * toe), least[:, None])
    here = (0.5 * toe > offset * joints.length[:, None]) & (element < size)
    ends = np.stack([joints.start, joints.end], axis=1)
    over = np.where(toe > np.maximum(bodies.bond_toe[:, None], bodies.hinge), FINE, FINE_OF_BOND) * toe
    column = np.zeros_like(toe) + (np.inf if bodies.column is None else bodies.column[:, None])
    sides = np.stack([joints.i, joints.j], axis=1)[:, None] + np.zeros_like(toe, int)[:, :, None]
    wide = np.array([np.ptp(body.exterior[:, 0]) for body in bodies.bodies])
    bends = np.isfinite(column[here])[:, None] & (wide[sides[here]] <= WIDE * column[here][:, None])
    return Toes(ends[here], element[here], over[here], column[here], sides[here], bends)


def graded(start: FloatArray, end: FloatArray, toes: Toes, size: float) -> FloatArray:
    """Return where elements end within an edge from start to end (m,), as shares of its length.

    Empty where elements of `size` are short enough.
    """
    if not len(toes.element):
        return np.empty(0)
    at, length = np.linspace(0.0, 1.0, SAMPLES + 1), float(np.linalg.norm(end - start))
    place = start + at[:, None] * (end - start)
    wanted = toes.wanted(np.linalg.norm(place[:, None] - toes.end, axis=2)).min(axis=1, initial=size)
    per_length = 1.0 / wanted
    count = np.concatenate([[0.0], np.cumsum(0.5 * (per_length[1:] + per_length[:-1]))]) * length / SAMPLES
    elements = int(np.ceil(count[-1] - 1e-6))
    if wanted.min() >= size or elements <= np.ceil(length / size - 1e-6):
        return np.empty(0)
    ends: FloatArray = np.interp(np.arange(1, elements) * count[-1] / elements, count, at)
    return ends
