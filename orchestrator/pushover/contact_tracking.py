"""Contacts of bodies that have moved: which of the possible contacts exist, where, and in which direction (numpy only).

Possible contacts are listed once, from the outlines of the undeformed bodies. A face is a maximal straight piece of an
outline. Two faces that run along one line with opposite normals, overlap or are less than a face apart, give

    primary contacts    every node of the slave's face against the master's face
    corner contacts     the end nodes of the master's face against the slave's face (a support's end is a fixed point)

In a displaced wall every body has a frame of its own, the rotation and translation that fit its nodes best. A slave
point is pulled back into its master's frame, where face and triangles are those of the undeformed body. A primary
contact exists while its point lies within the master's face; when the slave slides over the end of the face, the
corner contact there takes over, and when it reaches another face along the line, the contacts with that one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import shapely

from orchestrator.bodies import Bodies
from orchestrator.errors import CaseError
from orchestrator.masonry.wall import FloatArray, IntArray, read_only
from orchestrator.meshing import BodyMeshes
from orchestrator.pushover.contact_search import (
    TOLERANCE,
    Contacts,
    barycentric,
    nodes_on,
    slave_and_master,
    triangles_on,
)

END = 1e-3
"""a slave node may lie so far beyond the end of a face, m"""
COVER = 2e-3
"""an enabled primary contact within this distance of a face's end stands for the corner contact there, m"""
REACH = 0.02
"""wider gaps cannot close within an increment, m"""
DEEPEST = -2e-3
"""a point that lies deeper in a body than this belongs to another of its faces, m"""
OUTSIDE = 1e-2
"""a point may lie outside its triangle by this barycentric weight: the connection stays while a node slides a little"""
SUPPORT_POINT = -1
"""slave node of a corner contact whose corner belongs to a support"""


@dataclass(frozen=True, eq=False, slots=True)
class Frames:
    """Rigid motion of each body that fits its nodes best: x = R X + t in the wall's plane.

    angle (b,) in rad, counter-clockwise; rotation (b, 2, 2); translation (b, 2) in m; supports included, at rest.
    """

    angle: FloatArray
    rotation: FloatArray
    translation: FloatArray


def fit_frames(meshes: BodyMeshes, displacement: FloatArray, bodies: int) -> Frames:
    """Return the frames of `bodies` bodies (the moving ones first); displacement (>= m, 3) in m, nodes first."""
    body, reference = meshes.body_of_node, meshes.nodes[:, :2]
    moved = reference + displacement[: len(reference), :2]
    count = np.maximum(np.bincount(body, minlength=bodies), 1.0)

    def mean(values: FloatArray) -> FloatArray:
        return np.stack([np.bincount(body, values[:, k], bodies) for k in range(2)], axis=1) / count[:, None]

    old, new = mean(reference), mean(moved)
    arm, turned = reference - old[body], moved - new[body]
    sine = np.bincount(body, arm[:, 0] * turned[:, 1] - arm[:, 1] * turned[:, 0], bodies)
    cosine = np.bincount(body, np.sum(arm * turned, axis=1), bodies)
    angle = np.arctan2(sine, cosine)
    rotation = np.stack(
        [np.stack([np.cos(angle), -np.sin(angle)], -1), np.stack([np.sin(angle), np.cos(angle)], -1)], 1
    )
    return Frames(angle, rotation, new - np.einsum("bij,bj->bi", rotation, old))


@dataclass(frozen=True, eq=False, slots=True)
class Faces:
    """f maximal straight pieces of the outlines: body (f,), start, end (f, 2) in m, counter-clockwise."""

    body: IntArray
    start: FloatArray
    end: FloatArray

    @property
    def length(self) -> FloatArray:
        """(f,) in m."""
        return np.linalg.norm(self.end - self.start, axis=1)

    @property
    def tangent(self) -> FloatArray:
        """(f, 2), from start to end."""
        return (self.end - self.start) / self.length[:, None]

    @property
    def normal(self) -> FloatArray:
        """(f, 2), outward."""
        tangent = self.tangent
        return np.column_stack([tangent[:, 1], -tangent[:, 0]])


def find_faces(bodies: Bodies) -> Faces:
    """Return the faces of all bodies, collinear edges merged."""
    rows = [
        (body.number, a, b) for body in bodies.bodies for ring in (body.exterior, *body.holes) for a, b in _sides(ring)
    ]
    return Faces(
        read_only([row[0] for row in rows], np.int64), read_only([r[1] for r in rows]), read_only([r[2] for r in rows])
    )


def _sides(ring: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
    """Return start and end of each straight piece of a closed ring (n, 2)."""
    before, after = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    height = np.abs(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]) / np.linalg.norm(before + after, axis=1)
    corners = ring[~(height < TOLERANCE)]
    return list(zip(corners, np.roll(corners, -1, axis=0), strict=True))


@dataclass(frozen=True, eq=False, slots=True)
class Tracking:
    """Everything about possible contacts that does not change.

    possible: all of them, undeformed, those that touch there first (`touching` of them). For each: pair (c,) of
    faces, slave_face, master_face (c,), corner (c,): 0 primary, 1 or 2 the corner at the start or end of the pair's
    master face, level (c,): number of its z. first_triangle, triangles (c,): the master's triangles on its face as a
    range of rows of `triangle` (t, 3), none for a support. stand_in, stand_in_of (d,): corner contacts and the primary
    ones that touch at the same point in the undeformed wall.
    """

    faces: Faces
    possible: Contacts
    touching: int
    pair: IntArray
    slave_face: IntArray
    master_face: IntArray
    corner: IntArray
    triangle: IntArray
    first_triangle: IntArray
    triangles: IntArray
    level: IntArray
    stand_in: IntArray
    stand_in_of: IntArray

    def handed_over(self, rows: IntArray, values: FloatArray) -> FloatArray:
        """Return `values` (possible, ...) with those of contacts that are not in `rows` moved to their stand-ins there.

        A corner contact and the primary contact of the node that touched that corner stand in for each other.
        """
        exists = np.zeros(len(values), bool)
        exists[rows] = True
        moved = values.copy()
        for old, new in ((self.stand_in_of, self.stand_in), (self.stand_in, self.stand_in_of)):
            change = ~exists[old] & exists[new]
            moved[new[change]] += values[old[change]]
            moved[old[change]] = 0.0
        return moved


def find_possible_contacts(bodies: Bodies, meshes: BodyMeshes, touching: Contacts) -> Tracking:
    """Return the contacts `touching` in the undeformed wall and all that sliding along their lines may bring."""
    faces = find_faces(bodies)
    surface = _Surface(bodies, meshes, faces)
    rows: list[dict[str, npt.NDArray]] = []
    for number, (slave, master) in enumerate(surface.slave_and_master_faces(touching)):
        rows.append(surface.contacts(slave, surface.nodes[slave], master, 0, number))
        for corner, point in ((1, faces.start[master]), (2, faces.end[master])):
            rows.append(surface.contacts(master, surface.nodes_at(master, point), slave, corner, number))
    columns = {name: np.concatenate([row[name] for row in rows]) for name in rows[0]}
    known = surface.rows_of(columns, touching)
    order = np.concatenate([known, np.setdiff1d(np.arange(len(columns["pair"])), known)])
    columns = {name: values[order] for name, values in columns.items()}
    interface = surface.nearest_interface(columns)
    interface[: len(touching)] = touching.interface
    possible = Contacts(
        slave_node=read_only(columns["slave_node"], np.int64),
        slave_body=read_only(columns["slave_body"], np.int64),
        master_body=read_only(columns["master_body"], np.int64),
        interface=read_only(interface, np.int64),
        master_nodes=read_only(np.zeros((len(order), 3)), np.int64),
        weights=read_only(np.zeros((len(order), 3))),
        normal=read_only(columns["normal"]),
        tangent=read_only(columns["tangent"]),
        friction=read_only(bodies.friction[interface]),
        point=read_only(columns["point"]),
        moving=True,
    )
    triangle, first_triangle, triangles = surface.triangle_table(columns["master_face"])
    return Tracking(
        faces=faces,
        possible=possible,
        touching=len(touching),
        **{n: read_only(columns[n], np.int64) for n in ("pair", "slave_face", "master_face", "corner")},
        triangle=read_only(triangle, np.int64),
        first_triangle=read_only(first_triangle, np.int64),
        triangles=read_only(triangles, np.int64),
        level=read_only(np.unique(np.round(columns["point"][:, 2], 6), return_inverse=True)[1], np.int64),
        **_stand_ins(columns),
    )


def _stand_ins(columns: dict[str, npt.NDArray]) -> dict[str, IntArray]:
    """Return corner contacts and the primary contact of the same pair at the same point."""
    places = zip(columns["pair"].tolist(), np.round(columns["point"], 4).tolist(), strict=True)
    keys = [(pair, *place) for pair, place in places]
    primary = columns["corner"] == 0
    found = {key: row for row, key in enumerate(keys) if primary[row]}
    both = [(row, found[key]) for row, key in enumerate(keys) if not primary[row] and key in found]
    corner, of = np.reshape(both, (-1, 2)).astype(np.int64).T
    return {"stand_in": read_only(corner, np.int64), "stand_in_of": read_only(of, np.int64)}


def _facing(faces: Faces, moving: int) -> list[tuple[int, int]]:
    """Return pairs of faces of two bodies on one line, normals opposite, less than the shorter face apart."""
    lines = shapely.linestrings(np.stack([faces.start, faces.end], axis=1))
    first, second = shapely.STRtree(lines).query(lines, predicate="dwithin", distance=faces.length)
    length, normal = faces.length, faces.normal
    keep = (first < second) & (faces.body[first] != faces.body[second])
    keep &= (faces.body[first] < moving) | (faces.body[second] < moving)
    keep &= np.einsum("ki,ki->k", normal[first], normal[second]) < -1 + 1e-6
    first, second = first[keep], second[keep]
    offset = np.stack([faces.start[second] - faces.start[first], faces.end[second] - faces.start[first]])
    distance = np.abs(np.einsum("aki,ki->ak", offset, normal[first])).max(axis=0)
    along = np.einsum("aki,ki->ak", offset, faces.tangent[first])
    apart = np.maximum(along.min(axis=0) - length[first], -along.max(axis=0))
    keep = (distance < TOLERANCE) & (apart < np.minimum(length[first], length[second]))
    return sorted(zip(first[keep].tolist(), second[keep].tolist(), strict=True))


class _Surface:
    """Nodes and triangles of each face, and the rows of possible contacts made of them (set-up only)."""

    def __init__(self, bodies: Bodies, meshes: BodyMeshes, faces: Faces) -> None:
        self.bodies, self.meshes, self.faces = bodies, meshes, faces
        self.normal, self.tangent = faces.normal, faces.tangent
        by_body = [meshes.side_triangles[meshes.body_of_side == b] for b in range(bodies.moving)]
        self.triangles: list[IntArray] = []
        self.nodes: list[IntArray] = []
        self.levels = np.unique(np.round(meshes.nodes[:, 2], 9))
        none = np.zeros((0, 3), np.int64)
        for body, start, end in zip(faces.body, faces.start, faces.end, strict=True):
            moves = body < bodies.moving
            self.triangles.append(triangles_on(start, end, by_body[body], meshes.nodes) if moves else none)
            candidates = np.unique(by_body[body]) if moves else none.ravel()
            self.nodes.append(nodes_on(start, end, candidates, meshes.nodes))

    def slave_and_master_faces(self, touching: Contacts) -> list[tuple[int, int]]:
        """Return all pairs of facing faces, the slave's first: as in the contacts that touch, or by their rule."""
        known = set(_keys(touching.slave_body, touching.master_body, touching.normal))
        normal = self.normal
        pairs = []
        for first, second in _facing(self.faces, self.bodies.moving):
            both = [(first, second), (second, first)]
            bodies = [(int(self.faces.body[slave]), int(self.faces.body[master])) for slave, master in both]
            keys = [_key(*body, normal[master]) for body, (_, master) in zip(bodies, both, strict=True)]
            found = [pair for pair, key in zip(both, keys, strict=True) if key in known]
            if not found:
                face = {body: k for (body, _), (k, _) in zip(bodies, both, strict=True)}
                nodes = {body: self.nodes[k] for body, k in face.items() if body < self.bodies.moving}
                body_i, body_j = sorted(face)
                slave, master = slave_and_master(body_i, body_j, nodes)
                found = [(face[slave], face[master])]
            pairs += found
        return pairs

    def nodes_at(self, face: int, point: FloatArray) -> IntArray:
        """Return the nodes of the face at one of its ends; a support has one fixed point per level of nodes."""
        if self.faces.body[face] >= self.bodies.moving:
            return np.full(len(self.levels), SUPPORT_POINT)
        nodes = self.nodes[face]
        return nodes[np.linalg.norm(self.meshes.nodes[nodes, :2] - point, axis=1) < TOLERANCE]

    def contacts(self, slave: int, nodes: IntArray, master: int, corner: int, pair: int) -> dict[str, npt.NDArray]:
        """Return the rows of `nodes` of the slave's face against the master's face."""
        count = len(nodes)
        faces = self.faces
        if count and nodes[0] == SUPPORT_POINT:
            place = faces.start[slave] if corner == 1 else faces.end[slave]
            point = np.column_stack([np.tile(place, (count, 1)), self.levels])
        else:
            point = self.meshes.nodes[nodes]
        return {
            "slave_node": nodes,
            "slave_body": np.full(count, faces.body[slave]),
            "master_body": np.full(count, faces.body[master]),
            "normal": np.tile(self.normal[master], (count, 1)),
            "tangent": np.tile(self.tangent[master], (count, 1)),
            "point": point,
            "slave_face": np.full(count, slave),
            "master_face": np.full(count, master),
            "corner": np.full(count, corner),
            "pair": np.full(count, pair),
        }

    def rows_of(self, columns: dict[str, npt.NDArray], touching: Contacts) -> IntArray:
        """Return the primary row of each touching contact."""
        primary = columns["corner"] == 0
        keys = _keys(columns["slave_node"], columns["master_body"], columns["normal"])
        found = {key: row for row, key in enumerate(keys) if primary[row]}
        wanted = _keys(touching.slave_node, touching.master_body, touching.normal)
        missing = [row for row, key in enumerate(wanted) if key not in found]
        if missing:
            x, y, _ = touching.point[missing[0]]
            problem = f"corners near ({x:.4f}, {y:.4f}) m miss each other by about the tolerance of joints"
            raise CaseError("blocks", problem, "let them meet exactly, or lie at least 0.1 mm apart")
        return np.array([found[key] for key in wanted], np.int64)

    def nearest_interface(self, columns: dict[str, npt.NDArray]) -> IntArray:
        """Return for each row the interface whose middle is nearest, one between the same bodies if there is one."""
        bodies = self.bodies
        middle = 0.5 * (bodies.start + bodies.end)
        pair = np.sort(np.column_stack([columns["slave_body"], columns["master_body"]]), axis=1)
        known = np.sort(np.column_stack([bodies.body_i, bodies.body_j]), axis=1)
        nearest = shapely.STRtree(shapely.points(middle)).nearest(shapely.points(columns["point"][:, :2]))
        by_pair: dict[tuple[int, int], int] = {}
        for number, (i, j) in enumerate(known.tolist()):
            by_pair.setdefault((i, j), number)
        return np.array([by_pair.get((i, j), n) for (i, j), n in zip(pair.tolist(), nearest.tolist(), strict=True)])

    def triangle_table(self, master_face: IntArray) -> tuple[IntArray, IntArray, IntArray]:
        """Return all faces' triangles (t, 3), and for each row where those of its master's face begin and how many."""
        count = np.array([len(triangles) for triangles in self.triangles])
        begin = np.cumsum(count) - count
        return np.concatenate(self.triangles), begin[master_face], count[master_face]


def _keys(node: IntArray, body: IntArray, normal: FloatArray) -> list[tuple[int, ...]]:
    return [_key(*row) for row in zip(node.tolist(), body.tolist(), normal, strict=True)]


def _key(node: int, body: int, normal: FloatArray) -> tuple[int, ...]:
    return node, body, *np.round(normal * 1e6).astype(int).tolist()


@dataclass(frozen=True, eq=False, slots=True)
class Tracked:
    """The contacts that exist in a displaced wall: rows (c,) of the possible ones, and their gaps (c,) in m."""

    rows: IntArray
    contacts: Contacts
    gap: FloatArray


def track(tracking: Tracking, meshes: BodyMeshes, frames: Frames, displacement: FloatArray) -> Tracked:
    """Return the contacts of the wall displaced by `displacement` (>= m, 3) in m.

    Bodies turn in the wall's plane only, so that equilibrium out of it is that of the undeformed wall: points keep
    their z. (A slave's z taken with its displacement, its master's without, once made a leaning wall sway for ever.)
    """
    possible, faces = tracking.possible, tracking.faces
    moved = meshes.nodes + displacement[: len(meshes.nodes)] * [1.0, 1.0, 0.0]
    on_support = possible.slave_node == SUPPORT_POINT
    point = np.where(on_support[:, None], possible.point, moved[possible.slave_node])
    home = _pulled_back(point, frames, possible.master_body)
    face = tracking.master_face
    position = np.einsum("ci,ci->c", home[:, :2] - faces.start[face], faces.tangent[face])
    height = np.einsum("ci,ci->c", home[:, :2] - faces.start[face], faces.normal[face])
    near = (height < REACH) & (height > DEEPEST)
    exists = near & _within(tracking, frames, position)
    rows = np.flatnonzero(exists)
    master_nodes, weights = _project(tracking, meshes, home[rows], rows)
    turn = frames.rotation[possible.master_body[rows]]
    normal = np.einsum("cij,cj->ci", turn, possible.normal[rows])
    on_master = np.einsum("cj,cji->ci", weights, moved[master_nodes])
    fixed = ~weights.any(axis=1)
    gap = np.where(fixed, height[rows], np.einsum("ci,ci->c", normal, (point[rows] - on_master)[:, :2]))
    contacts = Contacts(
        slave_node=possible.slave_node[rows],
        slave_body=possible.slave_body[rows],
        master_body=possible.master_body[rows],
        interface=possible.interface[rows],
        master_nodes=master_nodes,
        weights=weights,
        normal=normal,
        tangent=np.einsum("cij,cj->ci", turn, possible.tangent[rows]),
        friction=possible.friction[rows],
        point=point[rows],
        moving=True,
    )
    return Tracked(rows, contacts, gap)


def _pulled_back(point: FloatArray, frames: Frames, body: IntArray) -> FloatArray:
    """Return points (c, 3) in the undeformed frames of the bodies (c,)."""
    plane = np.einsum("cji,cj->ci", frames.rotation[body], point[:, :2] - frames.translation[body])
    return np.column_stack([plane, point[:, 2]])


def _within(tracking: Tracking, frames: Frames, position: FloatArray) -> npt.NDArray[np.bool_]:
    """Return which possible contacts lie within their master's face, corners only where no primary contact is near."""
    length = tracking.faces.length[tracking.master_face]
    primary = tracking.corner == 0
    inside = (position >= -END) & (position <= length + END) & (_overlap(tracking, frames) > END)
    place = tracking.pair, tracking.level
    covered = np.zeros((int(tracking.pair.max()) + 1, int(tracking.level.max()) + 1, 3), bool)
    for corner, distance in ((1, position), (2, length - position)):
        close = primary & inside & (np.abs(distance) <= COVER)
        covered[tracking.pair[close], tracking.level[close], corner] = True
    strictly = (position > END) & (position < length - END)
    return np.where(primary, inside, strictly & ~covered[*place, tracking.corner])


def _overlap(tracking: Tracking, frames: Frames) -> FloatArray:
    """Return by how much (m) the slave's face of each possible contact overlaps the master's."""
    faces, slave, master = tracking.faces, tracking.slave_face, tracking.master_face
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


def _project(tracking: Tracking, meshes: BodyMeshes, home: FloatArray, rows: IntArray) -> tuple[IntArray, FloatArray]:
    """Return master nodes and weights (c, 3): the first triangle that nearly holds the point, else the nearest one."""
    count = tracking.triangles[rows]
    tangent = tracking.faces.tangent[tracking.master_face[rows]]
    nodes = np.zeros((len(rows), 3), np.int64)
    weights = np.zeros((len(rows), 3))
    best = np.full(len(rows), -np.inf)
    for k in range(int(count.max(initial=0))):
        open_ = np.flatnonzero((count > k) & (best < -OUTSIDE))
        triangle = tracking.triangle[tracking.first_triangle[rows[open_]] + k]
        corners = meshes.nodes[triangle]
        flat = np.stack([np.einsum("cai,ci->ca", corners[..., :2], tangent[open_]), corners[..., 2]], axis=-1)
        target = np.stack([np.einsum("ci,ci->c", home[open_, :2], tangent[open_]), home[open_, 2]], axis=-1)
        found = barycentric(flat, target)
        better = found.min(axis=1) > best[open_]
        chosen = open_[better]
        nodes[chosen], weights[chosen], best[chosen] = triangle[better], found[better], found[better].min(axis=1)
    return nodes, weights
