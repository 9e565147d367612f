"""Node-to-surface contacts: which slave node faces which master triangle, in the undeformed wall (numpy only).

For a contact with slave node s, master nodes j with barycentric weights w_j, unit normal n (of the master, pointing to
the slave), in-plane tangent t and z:

    g = n . (u_s - sum_j w_j u_j)                 gap (joints touch by definition: no initial gap)
    slip = (t, z) . (u_s - sum_j w_j u_j)

Nodes and triangles of an interface are those of the ring edges that it is on both sides (faces.py). Supports are
masters without degrees of freedom. A node at a T-junction has one contact with each master. Contacts are unique in
(slave node, master's face): two interfaces on one face meet in a node, and two rows alike would make the system
singular. Such a node has the mean friction of its interfaces, by its areas in them.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np
import numpy.typing as npt
import scipy.sparse as sparse

from orchestrator.basis.arrays import FloatArray, IntArray, read_only
from orchestrator.geometry.rigid import cross
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.pushover.contact.faces import Touching, find_touching, tributary
from orchestrator.pushover.meshing import BodyMeshes


@dataclass(frozen=True, eq=False, slots=True)
class Contacts:
    """c contacts, in the order of the interfaces.

    slave_node (c,), slave_body, master_body (c,), interface (c,): numbers. master_nodes (c, 3), weights (c, 3): zero
    weights where the master is a support, and slave node -1 where the slave is the corner of a support. normal, tangent
    (c, 2). friction (c,). point (c, 3) in m. moving: normals and weights follow the bodies (contact_tracking.py).
    """

    slave_node: IntArray
    slave_body: IntArray
    master_body: IntArray
    interface: IntArray
    master_nodes: IntArray
    weights: FloatArray
    normal: FloatArray
    tangent: FloatArray
    friction: FloatArray
    point: FloatArray
    moving: bool = False

    def __len__(self) -> int:
        return len(self.slave_node)

    def chosen(self, kept: IntArray) -> Contacts:
        """Return the contacts `kept` (k,)."""
        of_each = {field.name: getattr(self, field.name) for field in fields(self) if field.name != "moving"}
        return replace(self, **{name: values[kept] for name, values in of_each.items()})

    def part(self, kept: IntArray, row: IntArray) -> Contacts:
        """Return the contacts `kept` (k,), nodes by their `row` (m,)."""
        return self.chosen(kept).renumbered(row)

    def renumbered(self, row: IntArray) -> Contacts:
        """Return the contacts with other numbers of nodes, `row` (m,)."""
        slave = np.where(self.slave_node >= 0, row[self.slave_node], self.slave_node)
        return replace(self, slave_node=slave, master_nodes=row[self.master_nodes])

    def rows(self, axes: tuple[int, ...], nodes: int) -> sparse.csr_matrix:
        """Return (r c, 3 nodes), r rows a contact: the slave's displacement relative to the master along `axes`.

        Axes: 0 normal, 1 tangent, 2 across the wall. Zeros are stored where contacts move, so that the pattern stays;
        entries of a support never.
        """
        real = np.column_stack([self.slave_node >= 0, *[self.weights.any(axis=1)] * 3])
        node = np.column_stack([self.slave_node, self.master_nodes])
        order = np.argsort(np.where(real, node, np.iinfo(np.int64).max), axis=1)
        weight = np.column_stack([self.slave_node >= 0, -self.weights])
        real, node, weight = (np.take_along_axis(each, order, axis=1) for each in (real, node, weight))
        value = weight[:, None, :, None] * self.axes[:, axes, None, :]
        in_axes = np.array([[True, True, False], [True, True, False], [False, False, True]])[axes, None, :]
        keep = real[:, None, :, None] & in_axes if self.moving else value != 0.0
        column = np.broadcast_to(3 * node[:, None, :, None] + np.arange(3), value.shape)
        length = np.count_nonzero(keep, axis=(2, 3)).ravel()
        indptr = np.concatenate([[0], np.cumsum(length)])
        return sparse.csr_matrix((value[keep], column[keep], indptr), shape=(len(length), 3 * nodes))

    @property
    def axes(self) -> FloatArray:
        """(c, 3, 3): normal, tangent, and across the wall."""
        frames = np.zeros((len(self), 3, 3))
        frames[:, 0, :2], frames[:, 1, :2], frames[:, 2, 2] = self.normal, self.tangent, 1.0
        return frames

    def normal_rows(self, nodes: int) -> sparse.csr_matrix:
        """Return B_n (c, 3 nodes): gap = B_n u."""
        return self.rows((0,), nodes)

    def tangential_rows(self, nodes: int) -> sparse.csr_matrix:
        """Return B_t (2 c, 3 nodes), rows interleaved: in-plane and out-of-plane slip of each contact."""
        return self.rows((1, 2), nodes)


def find_contacts(bodies: Bodies, meshes: BodyMeshes) -> Contacts:
    """Return the contacts of all interfaces. Raises AssertionError if a slave node faces no master triangle."""
    touching, sides = find_touching(bodies, meshes)
    parts = [_of_interface(k, bodies, meshes.nodes, touching, sides) for k in range(bodies.interfaces.count)]
    columns = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    place = np.column_stack([columns["slave_node"], touching.master_face[columns["interface"]]])
    first = np.sort(np.unique(place, axis=0, return_index=True)[1])
    contacts = Contacts(**{n: read_only(values[first], values.dtype) for n, values in columns.items()}, moving=False)
    return replace(contacts, friction=_mean_friction(contacts, bodies, meshes, touching, sides))


def _mean_friction(
    contacts: Contacts, bodies: Bodies, meshes: BodyMeshes, touching: Touching, sides: list[IntArray]
) -> FloatArray:
    """Return the friction (c,) of contacts: where joints meet in a node, the mean by the areas that it has in each."""
    area, beyond = np.zeros(len(contacts)), np.zeros(len(contacts))
    rows = contacts_of_interfaces(touching, sides, contacts.slave_node, contacts.interface)
    for number, friction in enumerate(bodies.interfaces.friction):
        _, areas = tributary(sides[touching.slave_edge[number]], meshes.nodes)
        area[rows[number]] += areas
        beyond[rows[number]] += areas * (friction - contacts.friction[rows[number]])
    return read_only(contacts.friction + beyond / area)


def _of_interface(
    number: int, bodies: Bodies, nodes: FloatArray, touching: Touching, sides: list[IntArray]
) -> dict[str, npt.NDArray]:
    slave_nodes = np.unique(sides[touching.slave_edge[number]])
    count, master, tangent = len(slave_nodes), int(touching.master[number]), touching.tangent[number]
    if master < bodies.moving:
        triangles = sides[touching.master_edge[number]]
        master_nodes, weights = _project(nodes[slave_nodes], nodes, triangles, tangent)
    else:
        master_nodes, weights = np.zeros((count, 3), np.int64), np.zeros((count, 3))
    return {
        "slave_node": slave_nodes,
        "slave_body": np.full(count, touching.slave[number]),
        "master_body": np.full(count, master),
        "interface": np.full(count, number),
        "master_nodes": master_nodes,
        "weights": weights,
        "normal": np.tile(touching.normal[number], (count, 1)),
        "tangent": np.tile(tangent, (count, 1)),
        "friction": np.full(count, bodies.interfaces.friction[number]),
        "point": nodes[slave_nodes],
    }


def contacts_of_interfaces(
    touching: Touching, sides: list[IntArray], slave_node: IntArray, interface: IntArray
) -> list[IntArray]:
    """Return the contacts (s,) of each interface: one a node of its slave's edge, in ascending order (front.py: one of
    two images).

    Where interfaces end on one face of the master, the contact of their common node is one of both. sides: of
    `sides_of_edges`; slave_node, interface (c,): those of `find_contacts`.
    """
    places = zip(slave_node.tolist(), touching.master_face[interface].tolist(), strict=True)
    row = {place: number for number, place in enumerate(places)}
    both = zip(touching.slave_edge.tolist(), touching.master_face.tolist(), strict=True)
    nodes = ((np.unique(sides[edge]).tolist(), face) for edge, face in both)
    return [np.array([row[node, face] for node in of_edge if (node, face) in row], np.int64) for of_edge, face in nodes]


def _project(
    points: FloatArray, nodes: FloatArray, triangles: IntArray, tangent: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Return for points (p, 3) the triangle each falls in (p, 3) and its barycentric weights (p, 3)."""
    flat = np.stack([nodes[..., :2] @ tangent, nodes[..., 2]], axis=-1)
    target = np.stack([points[:, :2] @ tangent, points[:, 2]], axis=-1)
    weights = barycentric(flat[triangles], target[:, None])
    best = weights.min(axis=2).argmax(axis=1)
    chosen = weights[np.arange(len(points)), best]
    assert chosen.min() > -1e-3, "a slave node lies outside the master's surface: the edges of an interface differ"
    chosen = np.where(chosen < 1e-9, 0.0, chosen)
    return triangles[best], chosen / chosen.sum(axis=1, keepdims=True)


def barycentric(corners: FloatArray, points: FloatArray) -> FloatArray:
    """Return weights (..., 3) of points (..., 2) in triangles with corners (..., 3, 2)."""
    a, b, c = (corners[..., k, :] for k in range(3))
    doubled = cross(b - a, c - a)
    return np.stack([cross(q - points, r - points) / doubled for q, r in ((b, c), (c, a), (a, b))], axis=-1)
