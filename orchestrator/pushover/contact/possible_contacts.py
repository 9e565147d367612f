"""Contacts that are possible while bodies move, listed once from the outlines of the undeformed bodies (set-up only).

Two faces of two bodies that look at each other, lie nearly on one line, and overlap or are less than a face apart, give

    primary contacts    every node of the slave's face against the master's face
    corner contacts     the end nodes of the master's face against the slave's face (a support's end is a fixed point)

A corner and a face of two bodies that may meet at an angle have a contact besides (corners.py).

contact_tracking.py says which of them exist in a displaced wall.
"""

from __future__ import annotations

from collections import defaultdict

import numpy as np
import numpy.typing as npt
import shapely

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray, read_only
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.pushover.contact.contact_search import Contacts
from orchestrator.pushover.contact.contact_tracking import ANGLED, DEEPEST, SUPPORT_POINT, Tracking
from orchestrator.pushover.contact.corners import corner_pairs, face_pairs
from orchestrator.pushover.contact.faces import Faces, find_faces, sides_of_edges, sides_of_faces, touching_faces
from orchestrator.pushover.contact.one_place import TURNED
from orchestrator.pushover.meshing import BodyMeshes

OFFSET = 0.05
"""share of the shorter face by which the lines of such faces may lie apart; beyond, nothing may be in between"""
SIGHTS = (0.25, 0.5, 0.75)
"""where two faces look at each other, as shares of what is opposite; one that is free is enough"""
BETWEEN = (0.1, 0.9)
"""part of the way from one to the other in which nothing may be: the two themselves end it"""
FAR = 1e6
"""what a joint across a contact is farther away than any along it, in lengths of joints"""


def find_possible_contacts(bodies: Bodies, meshes: BodyMeshes, touching: Contacts) -> Tracking:
    """Return the contacts `touching` in the undeformed wall and all that sliding along their lines may bring."""
    faces = find_faces(bodies)
    surface = _Surface(bodies, meshes, faces)
    rows: list[dict[str, npt.NDArray]] = []
    pairs = surface.slave_and_master_faces()
    for number, (slave, master) in enumerate(pairs):
        rows.append(surface.contacts(slave, surface.nodes[slave], master, 0, number))
        for corner, vertex in ((1, faces.begin[master]), (2, faces.stop[master])):
            rows.append(surface.contacts(master, surface.nodes_at(master, vertex), slave, corner, number))
    corners = corner_pairs(bodies, faces, TURNED)
    both = list(zip(corners.slave.tolist(), corners.master.tolist(), strict=True))
    for number, (slave, master) in enumerate(both, len(pairs)):
        nodes = surface.nodes_at(slave, faces.stop[slave])
        rows.append(surface.contacts(slave, nodes, master, ANGLED, number))
    columns = {name: np.concatenate([row[name] for row in rows]) for name in rows[0]}
    known = surface.rows_of(columns, pairs, touching)
    order = np.concatenate([known, np.setdiff1d(np.arange(len(columns["pair"])), known)])
    columns = {name: values[order] for name, values in columns.items()}
    interface = surface.nearest_interface(columns)
    interface[: len(touching)] = touching.interface
    friction = _friction(bodies, columns, interface)
    friction[: len(touching)] = touching.friction
    possible = _unconnected(columns, interface, friction)
    rest = np.einsum("ci,ci->c", possible.point[:, :2] - faces.start[columns["master_face"]], possible.normal)
    rest[len(touching) :] = 0.0
    triangle, first_triangle, triangles = surface.triangle_table(columns["master_face"])
    slave_of_pair, master_of_pair = np.array(pairs + both, np.int64).T
    return Tracking(
        faces=faces,
        slave_of_pair=read_only(slave_of_pair, np.int64),
        master_of_pair=read_only(master_of_pair, np.int64),
        size_of_pair=read_only(_sizes(bodies, faces.body[slave_of_pair], faces.body[master_of_pair])),
        face_pairs=face_pairs(faces, slave_of_pair[: len(pairs)], master_of_pair[: len(pairs)], TURNED),
        corner_pairs=corners,
        possible=possible,
        touching=len(touching),
        **{n: read_only(columns[n], np.int64) for n in ("pair", "master_face", "corner")},
        triangle=read_only(triangle, np.int64),
        corners=read_only(meshes.nodes[triangle]),
        first_triangle=read_only(first_triangle, np.int64),
        triangles=read_only(triangles, np.int64),
        level=read_only(columns["level"], np.int64),
        rest=read_only(rest),
        end_node=read_only(surface.end_nodes(), np.int64),
    )


def _unconnected(columns: dict[str, npt.NDArray], interface: IntArray, friction: FloatArray) -> Contacts:
    """Return contacts by their columns, of no node of the master yet."""
    return Contacts(
        **{name: read_only(columns[name], np.int64) for name in ("slave_node", "slave_body", "master_body")},
        interface=read_only(interface, np.int64),
        master_nodes=read_only(np.zeros((len(interface), 3)), np.int64),
        weights=read_only(np.zeros((len(interface), 3))),
        **{name: read_only(columns[name]) for name in ("normal", "tangent", "point")},
        friction=read_only(friction),
        moving=True,
    )


def _friction(bodies: Bodies, columns: dict[str, npt.NDArray], interface: IntArray) -> FloatArray:
    """Return the coefficients of friction (c,): of the interface of the same two bodies, else the lowest of any that
    either of them has, supports aside."""
    joints, pair = bodies.interfaces, np.column_stack([columns["slave_body"], columns["master_body"]])
    lowest = np.full(len(bodies.bodies), np.inf)
    for ends in (joints.i, joints.j):
        np.minimum.at(lowest, ends, joints.friction)
    lowest[bodies.moving :] = np.inf
    own = np.sort(pair, axis=1) == np.sort(np.column_stack([joints.i, joints.j])[interface], axis=1)
    return np.where(own.all(axis=1), joints.friction[interface], lowest[pair].min(axis=1))


def _sizes(bodies: Bodies, first: IntArray, second: IntArray) -> FloatArray:
    """Return the square root of the smaller moving body's area of each pair of bodies (p,), in m."""
    size = np.array([body.area**0.5 if body.number < bodies.moving else np.inf for body in bodies.bodies])
    return np.minimum(size[first], size[second])


def _facing(bodies: Bodies, faces: Faces) -> list[tuple[int, int]]:
    """Return pairs of faces that look at each other, less than the shorter one apart: nearly on one line, or opposite
    with nothing in between.

    The bottom of a thin slab and the top of the slab below it are nearly on one line, too, but back to back.
    """
    moving = bodies.moving
    lines = shapely.linestrings(np.stack([faces.start, faces.end], axis=1))
    first, second = shapely.STRtree(lines).query(lines, predicate="dwithin", distance=faces.length)
    keep = (first < second) & (faces.body[first] != faces.body[second])
    keep &= (faces.body[first] < moving) | (faces.body[second] < moving)
    keep &= np.einsum("ki,ki->k", faces.normal[first], faces.normal[second]) < -np.cos(TURNED)
    first, second = first[keep], second[keep]
    one_way, other_way = _along(faces, first, second), _along(faces, second, first)
    apart, in_front = np.maximum(one_way, other_way)
    offset = np.maximum(np.abs(one_way[1]), np.abs(other_way[1]))
    shorter = np.minimum(faces.length[first], faces.length[second])
    on_one_line = (offset < OFFSET * shorter) & (apart < shorter)
    opposite = ~on_one_line & (apart < 0.0) & (offset < shorter) & (in_front > 0.0)
    opposite[opposite] = _see_each_other(bodies, faces, first[opposite], second[opposite])
    keep = on_one_line | opposite
    keep &= in_front > DEEPEST * _sizes(bodies, faces.body[first], faces.body[second])
    return list(zip(first[keep].tolist(), second[keep].tolist(), strict=True))


def _see_each_other(bodies: Bodies, faces: Faces, first: IntArray, second: IntArray) -> BoolArray:
    """Return whether no body is between opposite faces (p,), at one of SIGHTS at least."""
    along, height = _ends_in_frame(faces, first, second)
    along = np.sort(along, axis=0).clip(0.0, faces.length[first])
    place = along[0] + np.array(SIGHTS)[:, None] * (along[1] - along[0])
    foot = faces.start[first] + place[:, :, None] * faces.tangent[first]
    way = height.mean(axis=0)[:, None] * faces.normal[first]
    sights = shapely.linestrings(np.stack([foot + part * way for part in BETWEEN], axis=2)).ravel()
    outlines = [shapely.Polygon(body.exterior, body.holes) for body in bodies.bodies]
    blocked = shapely.STRtree(outlines).query(sights, predicate="intersects")[0]
    return ~np.isin(np.arange(len(sights)), blocked).reshape(len(SIGHTS), -1).all(axis=0)


def _ends_in_frame(faces: Faces, first: IntArray, second: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return where both ends of second faces are (2, p) in m, along first ones from their starts and in front."""
    from_start = np.stack([faces.start[second] - faces.start[first], faces.end[second] - faces.start[first]])
    along, height = (np.einsum("aki,ki->ak", from_start, axis[first]) for axis in (faces.tangent, faces.normal))
    return along, height


def _along(faces: Faces, first: IntArray, second: IntArray) -> FloatArray:
    """Return (2, p) in m: how far second faces lie from first ones along them (negative: overlap), and how far in front
    of them (negative: behind)."""
    along, height = _ends_in_frame(faces, first, second)
    apart = np.maximum(along.min(axis=0) - faces.length[first], -along.max(axis=0))
    crossing = height[0] * height[1] < 0.0
    nearest = np.where(np.abs(height[0]) < np.abs(height[1]), *height)
    return np.stack([apart, np.where(crossing, 0.0, nearest)])


class _Surface:
    """Nodes and triangles of each face, and the rows of possible contacts made of them (set-up only)."""

    def __init__(self, bodies: Bodies, meshes: BodyMeshes, faces: Faces) -> None:
        self.bodies, self.meshes, self.faces = bodies, meshes, faces
        self.triangles = sides_of_faces(faces, meshes)
        self.nodes = [np.unique(triangles) for triangles in self.triangles]
        sides = sides_of_edges(faces, meshes)
        of_edge = [np.unique(triangles) for triangles in sides]
        self.nodes_of_vertex = [np.intersect1d(of_edge[k], of_edge[other]) for k, other in enumerate(faces.before)]
        self.touching = touching_faces(bodies, faces, sides)
        self.heights, self.level = np.unique(np.round(meshes.nodes[:, 2], 9), return_inverse=True)

    def slave_and_master_faces(self) -> list[tuple[int, int]]:
        """Return all pairs of faces, the slave's first: as in the two bodies' interfaces, or that of more nodes."""
        touching, body = self.touching, self.faces.body
        known = np.column_stack([touching.slave, touching.master, touching.slave_face, touching.master_face]).tolist()
        slaves = {(slave, master, face) for slave, master, *both in known for face in both}
        touch = {(min(both), max(both)) for _, _, *both in known}
        pairs = []
        for pair in sorted(touch.union(_facing(self.bodies, self.faces))):
            one, other = sorted(pair, key=lambda face: int(body[face]))
            i, j = int(body[one]), int(body[other])
            is_slave, is_master = ({(*bodies, one), (*bodies, other)} & slaves for bodies in ((i, j), (j, i)))
            more = len(self.nodes[other]) > len(self.nodes[one])
            pairs.append((other, one) if is_master or (more and not is_slave) else (one, other))
        return pairs

    def nodes_at(self, face: int, vertex: int) -> IntArray:
        """Return the nodes of the face at one of its ends; a support has one fixed point per level of nodes."""
        if self.faces.body[face] >= self.bodies.moving:
            return np.full(len(self.heights), SUPPORT_POINT)
        return self.nodes_of_vertex[vertex]

    def end_nodes(self) -> IntArray:
        """Return the nodes (f, 2, levels) at both ends of each face, -1 of supports."""
        node_of_end = np.full((len(self.faces), 2, len(self.heights)), -1)
        for face, ends in enumerate(zip(self.faces.begin, self.faces.stop, strict=True)):
            for end, vertex in enumerate(ends):
                nodes = self.nodes_of_vertex[vertex]
                node_of_end[face, end, self.level[nodes]] = nodes
        return node_of_end

    def contacts(self, slave: int, nodes: IntArray, master: int, corner: int, pair: int) -> dict[str, npt.NDArray]:
        """Return the rows of `nodes` of the slave's face against the master's face."""
        count, faces = len(nodes), self.faces
        if count and nodes[0] == SUPPORT_POINT:
            vertex = faces.begin[slave] if corner == 1 else faces.stop[slave]
            level = np.arange(count)
            point = np.column_stack([np.tile(faces.vertex[vertex], (count, 1)), self.heights])
        else:
            level, point = self.level[nodes], self.meshes.nodes[nodes]
        return {
            "slave_node": nodes,
            "slave_body": np.full(count, faces.body[slave]),
            "master_body": np.full(count, faces.body[master]),
            "normal": np.tile(faces.normal[master], (count, 1)),
            "tangent": np.tile(faces.tangent[master], (count, 1)),
            "point": point,
            "level": level,
            "master_face": np.full(count, master),
            "corner": np.full(count, corner),
            "pair": np.full(count, pair),
        }

    def rows_of(self, columns: dict[str, npt.NDArray], pairs: list[tuple[int, int]], touching: Contacts) -> IntArray:
        """Return the primary row of each touching contact."""
        number_of = {pair: number for number, pair in enumerate(pairs)}
        known = zip(self.touching.slave_face.tolist(), self.touching.master_face.tolist(), strict=True)
        pair_of = np.array([number_of[pair] for pair in known])
        primary = np.flatnonzero(columns["corner"] == 0)
        nodes = len(self.meshes.nodes)
        keys = columns["pair"][primary] * nodes + columns["slave_node"][primary]
        wanted = pair_of[touching.interface] * nodes + touching.slave_node
        order = np.argsort(keys)
        return primary[order[np.searchsorted(keys, wanted, sorter=order)]]

    def nearest_interface(self, columns: dict[str, npt.NDArray]) -> IntArray:
        """Return for each row the interface whose middle is nearest, or of those between the same bodies, if any, the
        nearest that lies along the row's face; the least rough of several that are as near."""
        joints = self.bodies.interfaces
        points = shapely.points(columns["point"][:, :2])
        found = np.asarray(shapely.STRtree(shapely.points(joints.centroid)).nearest(points), np.int64)
        between: dict[tuple[int, int], list[int]] = defaultdict(list)
        for number in np.argsort(joints.friction, kind="stable").tolist():
            between[min(joints.i[number], joints.j[number]), max(joints.i[number], joints.j[number])].append(number)
        lines = shapely.linestrings(np.stack([joints.start, joints.end], axis=1))
        pair = np.sort(np.column_stack([columns["slave_body"], columns["master_body"]]), axis=1)
        kinds, kind = np.unique(pair, axis=0, return_inverse=True)
        rows_of = np.split(np.argsort(kind, kind="stable"), np.cumsum(np.bincount(kind))[:-1])
        for (i, j), rows in zip(kinds.tolist(), rows_of, strict=True):
            if numbers := between.get((i, j)):
                apart = shapely.distance(points[rows, None], lines[numbers])
                along = np.abs(columns["normal"][rows] @ joints.normal[numbers].T) > np.cos(TURNED)
                size = float(joints.length[numbers].sum())
                found[rows] = np.array(numbers)[(np.round(apart / size, 9) + np.where(along, 0.0, FAR)).argmin(axis=1)]
        return found

    def triangle_table(self, master_face: IntArray) -> tuple[IntArray, IntArray, IntArray]:
        """Return all faces' triangles (t, 3), and for each row where those of its master's face begin and how many."""
        count = np.array([len(triangles) for triangles in self.triangles])
        begin = np.cumsum(count) - count
        return np.concatenate(self.triangles), begin[master_face], count[master_face]
