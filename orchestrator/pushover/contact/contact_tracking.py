"""Contacts of bodies that have moved: which of the possible contacts exist, where, and in which direction (numpy only).

possible_contacts.py lists the possible ones, primary and corner contacts of pairs of faces. In a displaced wall every
body has a frame of its own, the rotation and translation that fit its nodes best. A slave point is pulled back into its
master's frame, where face and triangles are those of the undeformed body. A primary contact exists while its point lies
within the master's face; when the slave slides over the end of the face, the corner contact there takes over, and when
it reaches another face along the line, the contacts with that one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray
from orchestrator.pushover.contact.contact_search import Contacts, barycentric
from orchestrator.pushover.contact.corners import CornerPairs, FacePairs
from orchestrator.pushover.contact.faces import Faces
from orchestrator.pushover.contact.frames import BodyNodes, Frames
from orchestrator.pushover.contact.one_place import COVER, PlacedContacts, at_a_tip, at_one_place, deepest

END = 1e-4
"""a point may lie so far beyond the end of a face; this, the next five and COVER of one_place.py are shares of the root
of the smaller body's area, which is 0.26 m for a stone of 0.4 m x 0.175 m. (What deforms must find its contact; corners
that catch on each other beyond their faces make a wall stronger: with 4e-3 one of irregular courses by 17 %.)"""
ONTO = 3.78e-3
"""overlap of their faces from which two bodies that were not in touch before have contacts: the edge of a real stone
carries nothing on a narrower strip (a voussoir on 0.1 mm of the next springer made a flat arch weaker by 10 %)"""
DEEPER = 1e-6
"""a contact that was there stays while no other point of its place lies deeper by more than this"""
BEYOND = 1e-7
"""at the tip of a wedge a point that lies so far beyond the end of its face gives way to one that is within its own"""
REACH = 0.075
"""wider gaps cannot close within an increment"""
DEEPEST = -7.5e-3
"""a point that lies deeper in a body than this belongs to another of its faces"""
ANGLED = 3
"""number of a corner, in `Tracking.corner`, whose faces are at an angle to the master's (corners.py)"""
SUPPORT_POINT = -1
"""slave node of a corner contact whose corner belongs to a support"""


@dataclass(frozen=True, eq=False, slots=True)
class Tracking:
    """Everything about possible contacts that does not change.

    slave_of_pair, master_of_pair (p,): faces of each pair, those of `face_pairs`, then those of `corner_pairs`;
    size_of_pair (p,) in m: what END and the like are shares of.
    possible: all contacts, undeformed, those that touch there first (`touching` of them). For each: pair (c,) of faces,
    master_face (c,), corner (c,): 0 primary, 1 or 2 the corner at the start or end of the pair's master face, ANGLED
    that at the end of its slave's face; level (c,): number of its z. first_triangle, triangles (c,): the master's
    triangles on its face as a range of rows of `triangle` (t, 3), with corners (t, 3, 3) in m; none for a support. rest
    (c,) in m: height over the straight face of points that touch the body in the undeformed wall, 0 for others.
    end_node (f, 2, levels): node at the start and at the end of each face at each z, -1 of supports.
    """

    faces: Faces
    slave_of_pair: IntArray
    master_of_pair: IntArray
    size_of_pair: FloatArray
    face_pairs: FacePairs
    corner_pairs: CornerPairs
    possible: Contacts
    touching: int
    pair: IntArray
    master_face: IntArray
    corner: IntArray
    triangle: IntArray
    corners: FloatArray
    first_triangle: IntArray
    triangles: IntArray
    level: IntArray
    rest: FloatArray
    end_node: IntArray

    def part(self, kept: IntArray, row: IntArray) -> Tracking:
        """Return that of the contacts `kept` (k,), nodes by their `row` (m,)."""
        of_each = ("pair", "master_face", "corner", "first_triangle", "triangles", "level", "rest")
        return replace(
            self,
            possible=self.possible.part(kept, row),
            touching=int(np.count_nonzero(kept < self.touching)),
            triangle=row[self.triangle],
            end_node=np.where(self.end_node < 0, -1, row[self.end_node]),
            **{name: getattr(self, name)[kept] for name in of_each},
        )


@dataclass(frozen=True, eq=False, slots=True)
class Tracked:
    """The contacts that exist in a displaced wall: rows (c,) of the possible ones, and their gaps (c,) in m.

    onto (c,) in m: how deep the points of new ones lie when they begin to bear. heirs (h, 2): rows of contacts that
    give way, and of those near them that take over what they carried.
    """

    rows: IntArray
    contacts: Contacts
    gap: FloatArray
    onto: FloatArray
    heirs: IntArray


def track(
    tracking: Tracking,
    of: BodyNodes,
    frames: Frames,
    displacement: FloatArray,
    gone: BoolArray,
    closed: FloatArray | None,
    known: BoolArray | None,
) -> Tracked:
    """Return the contacts of the wall displaced by `displacement` (>= m, 3) in m, but for those that are `gone` (c,).

    closed (c,): by how much mortar has closed, m; points of its two faces may lie that much deeper in the other body.
    known (c,): contacts that existed before, by default those of the undeformed wall; where the displacement is only
    expected, their points may lie at any depth. (A block that tips onto a slope would otherwise go through it.)

    Bodies turn in the wall's plane only, so that equilibrium out of it is that of the undeformed wall: points keep
    their z. (A slave's z taken with its displacement, its master's without, once made a leaning wall sway for ever.)
    """
    moved = of.nodes + displacement[: len(of.nodes)] * [1.0, 1.0, 0.0]
    if known is None:
        known = np.arange(len(tracking.pair)) < tracking.touching
    points = _points(tracking, of, frames, moved)
    near = _is_near(tracking, points, known, closed) & _overlaps(tracking, frames, known)
    is_out, onto = _ways_out(tracking, frames, points, known)
    rows = np.flatnonzero(near & is_out & ~gone)
    size = tracking.size_of_pair[tracking.pair[rows]]
    master_nodes, weights = _project(tracking, points.home[rows], rows, COVER * size)
    contacts = _turned(tracking.possible.chosen(rows), frames, points.point[rows], master_nodes, weights)
    on_master = np.einsum("cj,cji->ci", weights, moved[master_nodes])
    apart = np.einsum("ci,ci->c", contacts.normal, (contacts.point - on_master)[:, :2])
    gap = np.where(weights.any(axis=1), apart, points.height[rows])
    off = points.inside[rows] < -END * size
    placed = _placed(tracking, rows, contacts.point)
    one, other = at_one_place(placed)
    beyond = at_a_tip(placed, one, other) & (points.inside[rows] < -BEYOND * size)
    rank = np.argsort(np.lexsort((rows, gap - DEEPER * size * known[rows], beyond, off)))
    stays, heirs = deepest(rank, off, one, other)
    return Tracked(rows[stays], contacts.chosen(stays), gap[stays], onto[rows[stays]], rows[heirs])


def _placed(tracking: Tracking, rows: IntArray, point: FloatArray) -> PlacedContacts:
    """Return the contacts `rows` (c,) with their points (c, 3) in m."""
    possible = tracking.possible
    return PlacedContacts(
        point=point,
        size=tracking.size_of_pair[tracking.pair[rows]],
        slave_body=possible.slave_body[rows],
        master_body=possible.master_body[rows],
        master_face=tracking.master_face[rows],
        normal=possible.normal[rows],
        level=tracking.level[rows],
        angled=tracking.corner[rows] == ANGLED,
    )


@dataclass(frozen=True, eq=False, slots=True)
class _Points:
    """Where the points of all possible contacts are in a displaced wall.

    point, home (c, 3) in m: there, and in the undeformed frame of the master. height, inside (c,) in m: over the
    master's face, and how far within its nearer end; free (c,): within the nearer end that is no notch.
    """

    point: FloatArray
    home: FloatArray
    height: FloatArray
    inside: FloatArray
    free: FloatArray


def _points(tracking: Tracking, of: BodyNodes, frames: Frames, moved: FloatArray) -> _Points:
    """Return the points of all possible contacts of a wall with its nodes at `moved` (m, 3) in m."""
    possible, faces, face = tracking.possible, tracking.faces, tracking.master_face
    on_support = possible.slave_node == SUPPORT_POINT
    point = np.where(on_support[:, None], possible.point, moved[possible.slave_node])
    home = _pulled_back(point, frames, possible.master_body)
    position = np.einsum("ci,ci->c", home[:, :2] - faces.start[face], faces.tangent[face])
    height = np.einsum("ci,ci->c", home[:, :2] - faces.start[face], faces.normal[face]) - tracking.rest
    low, high = _shifted_ends(tracking, of, frames, moved)[face, :, tracking.level].T
    within = np.column_stack([position - low, faces.length[face] + high - position])
    rows, pair = _at_an_angle(tracking)
    free = within.copy()
    reach = REACH * tracking.size_of_pair[tracking.pair[rows]]
    within[rows], free[rows] = tracking.corner_pairs.within(pair, within[rows], height[rows], reach)
    return _Points(point, home, height, within.min(axis=1), free.min(axis=1))


def _at_an_angle(tracking: Tracking) -> tuple[IntArray, IntArray]:
    """Return the contacts (r,) of corners at an angle, and which of the corner pairs each is of."""
    rows = np.flatnonzero(tracking.corner == ANGLED)
    return rows, tracking.pair[rows] - (len(tracking.slave_of_pair) - len(tracking.corner_pairs))


def _is_near(tracking: Tracking, points: _Points, known: BoolArray, closed: FloatArray | None) -> BoolArray:
    """Return whether points (c,) are at the master's face: neither too far off, nor too deep, nor beyond its ends."""
    size = tracking.size_of_pair[tracking.pair]
    deepest = np.zeros(len(tracking.slave_of_pair))
    if closed is not None:
        np.maximum.at(deepest, tracking.pair, closed)
    lowest = np.where(tracking.corner == ANGLED, -REACH, DEEPEST) * size  # corners.py tells their faces apart
    near = (known | (points.height > lowest - deepest[tracking.pair])) & (points.height < REACH * size)
    return near & (points.inside >= -COVER * size)


def _overlaps(tracking: Tracking, frames: Frames, known: BoolArray) -> BoolArray:
    """Return whether the faces of contacts (c,) overlap far enough to touch."""
    least = np.where(_in_touch(tracking, known), END, ONTO) * tracking.size_of_pair
    return (_overlap(tracking, frames) > least)[tracking.pair] | (tracking.corner == ANGLED)


def _ways_out(tracking: Tracking, frames: Frames, points: _Points, known: BoolArray) -> tuple[BoolArray, FloatArray]:
    """Return which contacts (c,) are the way out of the master, those of corners at an angle from ONTO on, and how deep
    (c,) in m such a corner lies when it bears."""
    of_pair = np.ones(len(tracking.slave_of_pair), bool)
    of_pair[: len(tracking.face_pairs)] = tracking.face_pairs.are_out(tracking.faces, frames)
    out, (rows, pair) = of_pair[tracking.pair], _at_an_angle(tracking)
    size, height = tracking.size_of_pair[tracking.pair[rows]], points.height[rows]
    rival = tracking.corner_pairs.rival_height(tracking.faces, frames)[pair]
    from_in_front = (height > -END * size) & tracking.corner_pairs.at_once[pair]
    comes = np.where(from_in_front, points.free[rows], -height) > ONTO * size
    out[rows] = (height >= rival) & (known[rows] | comes)
    onto = np.zeros(len(out))
    onto[rows] = np.where(from_in_front, 0.0, ONTO * size)
    return out, onto


def _turned(
    contacts: Contacts, frames: Frames, point: FloatArray, master_nodes: IntArray, weights: FloatArray
) -> Contacts:
    """Return contacts at their points, with what their masters' nodes weigh, turned with their masters."""
    turn = frames.rotation[contacts.master_body]
    return replace(
        contacts,
        point=point,
        master_nodes=master_nodes,
        weights=weights,
        normal=np.einsum("cij,cj->ci", turn, contacts.normal),
        tangent=np.einsum("cij,cj->ci", turn, contacts.tangent),
        moving=True,
    )


def _pulled_back(point: FloatArray, frames: Frames, body: IntArray) -> FloatArray:
    """Return points (c, 3) in the undeformed frames of the bodies (c,)."""
    plane = np.einsum("cji,cj->ci", frames.rotation[body], point[:, :2] - frames.translation[body])
    return np.column_stack([plane, point[:, 2]])


def _shifted_ends(tracking: Tracking, of: BodyNodes, frames: Frames, moved: FloatArray) -> FloatArray:
    """Return (f, 2, levels) in m: how far the nodes at the ends of each face lie along it from where the frame says.

    Bodies deform, and turn about the vertical a little: front and back of a block then slide over an end one by one.
    """
    faces, node = tracking.faces, tracking.end_node
    body = np.broadcast_to(faces.body[:, None, None], node.shape)
    at_home = _pulled_back(moved[node.ravel()], frames, body.ravel()) - of.nodes[node.ravel()]
    along = np.einsum("feli,fi->fel", at_home[:, :2].reshape(*node.shape, 2), faces.tangent)
    return np.where(node < 0, 0.0, along)


def _in_touch(tracking: Tracking, known: BoolArray) -> BoolArray:
    """Return for each pair of faces (p,) whether their bodies have one of the contacts `known` (c,)."""
    body = tracking.faces.body
    slave, master = body[tracking.slave_of_pair], body[tracking.master_of_pair]
    number = np.minimum(slave, master) * (int(body.max()) + 1) + np.maximum(slave, master)
    return np.isin(number, number[tracking.pair[known]])


def _overlap(tracking: Tracking, frames: Frames) -> FloatArray:
    """Return by how much (m) the slave's face of each pair overlaps the master's, (p,)."""
    faces, slave, master = tracking.faces, tracking.slave_of_pair, tracking.master_of_pair
    body = faces.body[slave]
    ends = []
    for end in (faces.start[slave], faces.end[slave]):
        now = np.einsum("cij,cj->ci", frames.rotation[body], end) + frames.translation[body]
        home = np.einsum(
            "cji,cj->ci", frames.rotation[faces.body[master]], now - frames.translation[faces.body[master]]
        )
        ends.append(np.einsum("ci,ci->c", home - faces.start[master], faces.tangent[master]))
    low, high = np.minimum(*ends), np.maximum(*ends)
    return np.minimum(high, faces.length[master]) - np.maximum(low, 0.0)


def _project(tracking: Tracking, home: FloatArray, rows: IntArray, beyond: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return master nodes and weights (c, 3): the first triangle that holds the point, else the nearest one.

    A point may lie `beyond` (c,) in m outside its triangle along the face, so that the connection stays while a node
    slides a little: no farther than contacts at one place lie apart. (Three contacts of two straight edges depend on
    each other, and have no unique forces.)
    """
    nodes = np.zeros((len(rows), 3), np.int64)
    weights = np.zeros((len(rows), 3))
    connected = np.flatnonzero(tracking.triangles[rows])
    if not len(connected):
        return nodes, weights
    count = tracking.triangles[rows[connected]]
    first = np.cumsum(count) - count
    point = np.repeat(connected, count)  # each with every triangle of its master's face
    number = np.arange(len(point)) + np.repeat(tracking.first_triangle[rows[connected]] - first, count)
    tangent, corners = tracking.faces.tangent[tracking.master_face[rows[point]]], tracking.corners[number]
    flat = np.stack([np.einsum("cai,ci->ca", corners[..., :2], tangent), corners[..., 2]], axis=-1)
    target = np.stack([np.einsum("ci,ci->c", home[point, :2], tangent), home[point, 2]], axis=-1)
    coordinates = barycentric(flat, target)
    inside = coordinates.min(axis=1) * np.ptp(flat[..., 0], axis=1)
    holds = inside >= -beyond[point]
    rank = np.lexsort((np.where(holds, 0.0, -inside), ~holds, point))  # stable: the first that holds, else the nearest
    chosen = rank[first]
    nodes[connected], weights[connected] = tracking.triangle[number[chosen]], coordinates[chosen]
    return nodes, weights
