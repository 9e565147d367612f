"""The corner of one body against a face of another that neither of its own faces is nearly parallel to (numpy only).

Such a corner, of a body A, is out of the other body, B, as long as it is in front of the face. Beyond an end of it is

    a notch     where A touches nothing on the side of the face, and the next face of B rises, or a third body on which
                A was drawn fills the room between. A's corner can only come to the face, and does so at once. None is
                where A's corner was drawn in that end, and A's other face and B's next one lie on one line, along which
                they may slide past each other
    a free end  A may slide past the end. Where the two bodies go into each other at B's corner there, they have two
                ways out: over the face, or over its rival, which is A's corner over B's next face, or B's over A's

Of two rivals only the one with the larger gap is any. (So it is of two faces on one line, `FacePairs`, that have gone
into each other at the corners where both end: with both ways forbidden at once the corners would be pinned to each
other.) Where corners touch in one point as they were drawn, both ways are open, and there is no contact before they
have gone into each other a little. So it is later too, for corners that lie on a joint: had they a contact from in
front, a semicircular arch of docs/studies/path.py would bear 5 % less, and two walls find no further state. Where both
stand on the third body and each might come to a face of the other, the one with the larger angle does: it has the
flatter way.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray, read_only
from orchestrator.geometry.rigid import cross
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.pushover.contact.faces import STRAIGHT, Faces
from orchestrator.pushover.contact.frames import Frames

AT_END = 1e-4
"""part of the shorter of two faces: a corner of one as near to an end of the other was drawn in that"""


@dataclass(frozen=True, eq=False, slots=True)
class CornerPairs:
    """p pairs: slave (p,), the face that ends in the corner, and master (p,), the face that it may come to.

    at_once (p,): whether there is a notch at an end of the master, or the corner is a tip that lies on no joint. At
    both ends of the master (p, 2): notch, whether one is there, and rises, whether it is one of the master's own body;
    rival_vertex and rival_face, the corner and the face that are the rival at a free end.
    """

    slave: IntArray
    master: IntArray
    at_once: BoolArray
    notch: BoolArray
    rises: BoolArray
    rival_vertex: IntArray
    rival_face: IntArray

    def __len__(self) -> int:
        return len(self.slave)

    def within(
        self, pair: IntArray, inside: FloatArray, height: FloatArray, reach: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return how far corners are within both ends of their masters in effect, and within the free ends (c, 2), m.

        pair (c,): which each is of; inside (c, 2): how far within both ends it is, height (c,) over the face, reach
        (c,): how far from a face contacts are, all in m. Past a notch a corner is in reach as long as it is in front.
        """
        rises, notch = self.rises[pair], self.notch[pair]
        past = np.where(notch & (rises | (height > 0.0)[:, None]), reach[:, None], 0.0)
        return inside + past, np.where(notch, np.inf, inside)

    def rival_height(self, faces: Faces, frames: Frames) -> FloatArray:
        """Return the height in m (p,) of the rival that is the higher one, bodies as rigid ones; -inf without any."""
        height = _heights(faces, frames, self.rival_vertex, self.rival_face)
        return np.where(self.notch | self.rises, -np.inf, height).max(axis=1)


@dataclass(frozen=True, eq=False, slots=True)
class FacePairs:
    """p pairs of faces that lie nearly on one line, and the corners in which both end.

    vertex (p, 2, 2): at either end the corner of the slave and of the master; own_face: the other body's face of the
    pair, rival_face: the one next to it; is_way: whether all of the corner's body is in front of that.
    """

    vertex: IntArray
    own_face: IntArray
    rival_face: IntArray
    is_way: BoolArray

    def __len__(self) -> int:
        return len(self.vertex)

    def are_out(self, faces: Faces, frames: Frames) -> BoolArray:
        """Return which pairs (p,) are the way out at both ends, bodies as rigid ones."""
        own = _heights(faces, frames, self.vertex, self.own_face).max(axis=2)
        rival = np.where(self.is_way, _heights(faces, frames, self.vertex, self.rival_face), -np.inf).max(axis=2)
        return (own >= rival).all(axis=1)


def face_pairs(faces: Faces, slave: IntArray, master: IntArray, turned: float) -> FacePairs:
    """Return the ends of pairs of faces (p,), (p,): outlines run round, so both begin at one, and stop at the other.

    There is another way only where both bodies bend outwards by more than `turned` (rad).
    """
    arriving = faces.of_edge[faces.before[faces.begin]]  # face that ends where each begins
    both = np.column_stack([slave, master])
    vertex = np.stack([faces.begin[both], faces.stop[both]], axis=1)
    beside = np.stack([arriving[both], np.argsort(arriving)[both]], axis=1)
    own, into = np.stack([both, both], axis=1), np.array([1.0, -1.0])[:, None, None]
    sides = np.stack([into * faces.tangent[own], -into * faces.tangent[beside]], axis=3)
    bend = (_dot(faces.normal[beside], sides[..., 0, :]) < -np.sin(turned)).all(axis=2)
    clear = _in_front(sides, faces.normal[beside[..., ::-1]]) > -np.sin(turned)
    return FacePairs(
        vertex=read_only(vertex, np.int64),
        own_face=read_only(own[..., ::-1], np.int64),
        rival_face=read_only(beside[..., ::-1], np.int64),
        is_way=read_only(clear & bend[..., None], np.bool_),
    )


def _heights(faces: Faces, frames: Frames, vertex: IntArray, face: IntArray) -> FloatArray:
    """Return the heights in m (...) of vertices (...) over faces (...) of other bodies, bodies as rigid ones."""
    body = np.searchsorted(faces.first_edge, vertex, "right") - 1  # vertices are numbered as edges are
    now = np.einsum("...ij,...j->...i", frames.rotation[body], faces.vertex[vertex]) + frames.translation[body]
    other = faces.body[face]
    home = np.einsum("...ji,...j->...i", frames.rotation[other], now - frames.translation[other])
    return _dot(home - faces.start[face], faces.normal[face])


def corner_pairs(bodies: Bodies, faces: Faces, turned: float) -> CornerPairs:
    """Return the corners and faces of two bodies that may meet at an angle of more than `turned` (rad).

    All of the body at its corner is in front of the face, which is less far than it and both faces of the corner are
    long. Two supports have none, and tips more acute than `turned`: the needle between two stones that they are of
    bears on these.
    """
    arriving = faces.of_edge[faces.before[faces.begin]]  # face that ends where each begins
    following = np.argsort(arriving)
    sides = np.stack([faces.tangent, -faces.tangent[arriving]], axis=1)
    bend = np.arctan2(cross(faces.tangent[arriving], faces.tangent), _dot(faces.tangent[arriving], faces.tangent))
    corner, face = _near(faces, np.minimum(faces.length, faces.length[arriving]))
    one, other = faces.body[corner], faces.body[face]
    keep = (
        (one != other)
        & (np.minimum(one, other) < bodies.moving)
        & (bend[corner] > 0.0)
        & (bend[corner] < np.pi - turned)
    )
    keep &= _in_front(sides[corner], faces.normal[face]) > np.sin(turned)
    corner, face = corner[keep], face[keep]
    ends, beyond = np.column_stack([face, following[face]]), np.column_stack([arriving[face], following[face]])
    along = _dot(sides[corner], faces.tangent[face][:, None])
    back = np.column_stack([along.argmin(axis=1), along.argmax(axis=1)])  # the corner's side that is nearer to each end
    on_joint = _on_joints(bodies, faces)[np.column_stack([faces.begin, faces.before[faces.begin]])][corner]
    filled, blocked = (np.take_along_axis(on_joint, side, 1) for side in (back, 1 - back))
    own = np.take_along_axis(np.column_stack([corner, arriving[corner]]), 1 - back, 1)
    over_next = _in_front(sides[corner][:, None], faces.normal[beyond]) > -np.sin(turned)
    comes_to_own = _in_front(sides[ends], faces.normal[own]) > np.sin(turned)
    leads = ~comes_to_own | (bend[ends] > bend[corner][:, None] + STRAIGHT)
    to_ends = faces.start[corner][:, None] - np.stack([faces.start[face], faces.end[face]], axis=1)
    shorter = np.minimum(faces.length[face], np.minimum(faces.length, faces.length[arriving])[corner])
    slides_by = np.linalg.norm(to_ends, axis=2) < AT_END * shorter[:, None]
    slides_by &= _dot(faces.normal[own], faces.normal[beyond]) < -np.cos(turned)
    rises = bend[ends] <= 0.0
    notch = (rises | (filled & leads & ~slides_by)) & ~blocked
    return CornerPairs(
        slave=read_only(arriving[corner], np.int64),
        master=read_only(face, np.int64),
        at_once=read_only(notch.any(axis=1) | ~on_joint.any(axis=1), np.bool_),
        notch=read_only(notch, np.bool_),
        rises=read_only(rises, np.bool_),
        rival_vertex=read_only(np.where(over_next, faces.begin[corner][:, None], faces.begin[ends]), np.int64),
        rival_face=read_only(np.where(over_next, beyond, own), np.int64),
    )


def _near(faces: Faces, reach: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the corners (p,), where faces of these numbers begin, and faces (p,) less far from each other than `reach`
    (f,) of the corner and the face's length, in m."""
    lines = shapely.linestrings(np.stack([faces.start, faces.end], axis=1))
    points = shapely.points(faces.start)
    corner, face = shapely.STRtree(lines).query(points, predicate="dwithin", distance=reach)
    near = shapely.distance(points[corner], lines[face]) < faces.length[face]
    return corner[near], face[near]


def _in_front(sides: FloatArray, normal: FloatArray) -> FloatArray:
    """Return the smaller component (...) of two unit vectors (..., 2, 2) along a normal (..., 2)."""
    return _dot(sides, normal[..., None, :]).min(axis=-1)


def _dot(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the scalar products (...) of vectors (..., 2)."""
    products: FloatArray = (first * second).sum(axis=-1)
    return products


def _on_joints(bodies: Bodies, faces: Faces) -> BoolArray:
    """Return which ring edges (e,) are joints."""
    touched = np.zeros(len(faces.of_edge), bool)
    for body, edge in ((bodies.interfaces.i, bodies.edge_i), (bodies.interfaces.j, bodies.edge_j)):
        touched[faces.first_edge[body] + edge] = True
    return touched
