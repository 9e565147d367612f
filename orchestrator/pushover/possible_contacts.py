"""Contacts that are possible while bodies move, listed once from the outlines of the undeformed bodies (set-up only).

A face is a maximal straight piece of an outline. Two faces that run along one line with opposite normals, overlap or
are less than a face apart, give

    primary contacts    every node of the slave's face against the master's face
    corner contacts     the end nodes of the master's face against the slave's face (a support's end is a fixed point)

contact_tracking.py says which of them exist in a displaced wall.
"""

from __future__ import annotations

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
    nodes_on,
    slave_and_master,
    triangles_on,
)
from orchestrator.pushover.contact_tracking import SUPPORT_POINT, Faces, Tracking


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


def find_possible_contacts(bodies: Bodies, meshes: BodyMeshes, touching: Contacts) -> Tracking:
    """Return the contacts `touching` in the undeformed wall and all that sliding along their lines may bring."""
    faces = find_faces(bodies)
    surface = _Surface(bodies, meshes, faces)
    rows: list[dict[str, npt.NDArray]] = []
    pairs = surface.slave_and_master_faces(touching)
    for number, (slave, master) in enumerate(pairs):
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
        slave_of_pair=read_only([slave for slave, _ in pairs], np.int64),
        master_of_pair=read_only([master for _, master in pairs], np.int64),
        possible=possible,
        touching=len(touching),
        **{n: read_only(columns[n], np.int64) for n in ("pair", "master_face", "corner")},
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
