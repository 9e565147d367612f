"""Faces of bodies: maximal straight pieces of their outlines, each made of whole edges of a ring (numpy only).

Joints, triangles and contacts find each other by the numbers of these edges and faces, never by distance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray, read_only
from orchestrator.basis.graphs import connected_groups
from orchestrator.geometry.rigid import cross
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.pushover.meshing import BodyMeshes, triangle_areas

STRAIGHT = 0.01
"""rad; edges of a ring that follow each other are one face while their directions differ by less: a node between them
has one contact with the body then, not two that are nearly the same (1e-5 rad apart made the system singular)"""


@dataclass(frozen=True, eq=False, slots=True)
class Faces:
    """f faces of all bodies: body (f,), start, end (f, 2) in m, counter-clockwise; length (f,), tangent, normal (f, 2).

    The e ring edges of all bodies are numbered one body after the other, as bodies.py numbers those of each; vertex k
    is where edge k begins. vertex (e, 2) in m, before (e,): the edge that ends there. begin, stop (f,): vertices at the
    ends of each face; first_edge (bodies,): number of the first edge of each body; of_edge (e,): face of each edge.
    """

    body: IntArray
    begin: IntArray
    stop: IntArray
    vertex: FloatArray
    before: IntArray
    first_edge: IntArray
    of_edge: IntArray
    start: FloatArray
    end: FloatArray
    length: FloatArray
    tangent: FloatArray
    normal: FloatArray

    def __len__(self) -> int:
        return len(self.body)


def find_faces(bodies: Bodies) -> Faces:
    """Return the faces of all bodies, in the order of their rings."""
    rings = [(body.number, ring) for body in bodies.bodies for ring in (body.exterior, *body.holes)]
    parts: list[list[IntArray]] = []
    edges = faces = 0
    for owner, ring in rings:
        begins, number = _begins(ring), edges + np.arange(len(ring))
        corners = number[begins]
        of_edge = faces + (np.cumsum(begins) - 1) % len(corners)
        parts.append([np.full(len(corners), owner), corners, np.roll(corners, -1), np.roll(number, 1), of_edge])
        edges, faces = edges + len(ring), faces + len(corners)
    body, begin, stop, before, face = (read_only(np.concatenate(each), np.int64) for each in zip(*parts, strict=True))
    vertex = np.concatenate([ring for _, ring in rings])
    length = np.linalg.norm(vertex[stop] - vertex[begin], axis=1)
    tangent = (vertex[stop] - vertex[begin]) / length[:, None]
    of_body = np.bincount([owner for owner, _ in rings], [len(ring) for _, ring in rings])
    return Faces(
        body=body,
        begin=begin,
        stop=stop,
        vertex=read_only(vertex),
        before=before,
        first_edge=read_only(np.cumsum(of_body) - of_body, np.int64),
        of_edge=face,
        start=read_only(vertex[begin]),
        end=read_only(vertex[stop]),
        length=read_only(length),
        tangent=read_only(tangent),
        normal=read_only(np.column_stack([tangent[:, 1], -tangent[:, 0]])),
    )


def _begins(ring: FloatArray) -> BoolArray:
    """Return the vertices of a closed ring (n, 2) where a face begins.

    The sharpest corner is one; on from there, wherever the directions of a face's edges would differ by more than
    STRAIGHT.
    """
    along = np.roll(ring, -1, axis=0) - ring
    before = np.roll(along, 1, axis=0)
    turn = np.arctan2(cross(before, along), np.sum(before * along, axis=1))
    sharpest = int(np.abs(turn).argmax())
    begins = np.zeros(len(ring), bool)
    begins[sharpest] = True
    direction = lowest = highest = 0.0
    for vertex in (sharpest + np.arange(1, len(ring))) % len(ring):
        direction += float(turn[vertex])
        lowest, highest = min(lowest, direction), max(highest, direction)
        if highest - lowest > STRAIGHT:
            begins[vertex] = True
            direction = lowest = highest = 0.0
    return begins


def sides_of_edges(faces: Faces, meshes: BodyMeshes) -> list[IntArray]:
    """Return the side triangles (t, 3) of each edge of all bodies' rings, none for a body that has no mesh."""
    edge = faces.first_edge[meshes.body_of_side] + meshes.side_edge
    order = np.argsort(edge, kind="stable")
    borders = np.searchsorted(edge[order], np.arange(1, len(faces.of_edge)))
    return np.split(meshes.side_triangles[order], borders)


def sides_of_faces(faces: Faces, meshes: BodyMeshes) -> list[IntArray]:
    """Return the side triangles (t, 3) of each face, none for a body that has no mesh."""
    face = faces.of_edge[faces.first_edge[meshes.body_of_side] + meshes.side_edge]
    order = np.argsort(face, kind="stable")
    return np.split(meshes.side_triangles[order], np.searchsorted(face[order], np.arange(1, len(faces))))


@dataclass(frozen=True, eq=False, slots=True)
class Touching:
    """Both sides of the k interfaces.

    slave, master (k,): bodies; slave_edge, master_edge, slave_face, master_face (k,): numbers of edges and faces of all
    bodies; normal (k, 2) of the master, to the slave; tangent (k, 2).
    """

    slave: IntArray
    master: IntArray
    slave_edge: IntArray
    master_edge: IntArray
    slave_face: IntArray
    master_face: IntArray
    normal: FloatArray
    tangent: FloatArray


def find_touching(bodies: Bodies, meshes: BodyMeshes) -> tuple[Touching, list[IntArray]]:
    """Return both sides of all interfaces, and the side triangles of each edge (`sides_of_edges`)."""
    faces = find_faces(bodies)
    sides = sides_of_edges(faces, meshes)
    return touching_faces(bodies, faces, sides), sides


def touching_faces(bodies: Bodies, faces: Faces, sides: list[IntArray]) -> Touching:
    """Return both sides of all interfaces. The slave is the one with more triangles in `sides` (`sides_of_edges`), body
    i where both have as many, never a support.

    Interfaces of two bodies that share a face need the same slave, or a node between them has two contacts that are
    one: the first of them decides.
    """
    between = bodies.interfaces
    edge_i, edge_j = faces.first_edge[between.i] + bodies.edge_i, faces.first_edge[between.j] + bodies.edge_j
    first = _first_on_faces(np.stack([between.i, between.j]), faces.of_edge[np.stack([edge_i, edge_j])])
    count = np.array([len(side) for side in sides])
    finer_j = (between.i >= bodies.moving) | (count[edge_j] > count[edge_i])
    slave = np.where(finer_j, between.j, between.i)[first]
    i_is_slave = slave == between.i
    slave_edge, master_edge = np.where(i_is_slave, edge_i, edge_j), np.where(i_is_slave, edge_j, edge_i)
    return Touching(
        slave=slave,
        master=np.where(i_is_slave, between.j, between.i),
        slave_edge=slave_edge,
        master_edge=master_edge,
        slave_face=faces.of_edge[slave_edge],
        master_face=faces.of_edge[master_edge],
        normal=np.where(i_is_slave[:, None], -between.normal, between.normal),
        tangent=between.tangent,
    )


def _first_on_faces(body: IntArray, face: IntArray) -> IntArray:
    """Return the first interface (k,) of those between the same bodies (2, k) that shared faces (2, k) connect."""
    count = body.shape[1]
    pair = np.unique(np.sort(body, axis=0), axis=1, return_inverse=True)[1]
    _, node = np.unique(np.stack([np.tile(pair, 2), face.ravel()]), axis=1, return_inverse=True)
    size = count + int(node.max(initial=-1)) + 1
    group = connected_groups(size, np.tile(np.arange(count), 2), count + node)[:count]
    return np.unique(group, return_index=True)[1][np.unique(group, return_inverse=True)[1]]


def tributary(triangles: IntArray, nodes: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the nodes (s,) of the triangles (t, 3), in ascending order, and their shares (s,) of the area in m2."""
    used, place = np.unique(triangles, return_inverse=True)
    shares: FloatArray = np.bincount(place.ravel(), np.repeat(triangle_areas(nodes, triangles) / 3, 3)).astype(float)
    return used, shares
