"""Node-to-surface contacts: which slave node faces which master triangle, in the undeformed wall (numpy only).

For a contact with slave node s, master nodes j with barycentric weights w_j, unit normal n (of the master, pointing to
the slave), in-plane tangent t and z:

    g = n . (u_s - sum_j w_j u_j)                 gap (joints touch by definition: no initial gap)
    slip = (t, z) . (u_s - sum_j w_j u_j)

The slave is the side with more nodes on the joint. Supports are masters without degrees of freedom. A node at a
T-junction has one contact with each master. Contacts are unique in (slave node, master body, normal): two collinear
joints between the same bodies meet in a node, and two identical rows would make the system singular.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy.sparse as sparse

from orchestrator.bodies import Bodies
from orchestrator.masonry.wall import FloatArray, IntArray, read_only
from orchestrator.meshing import BodyMeshes

TOLERANCE = 2e-5
"""distance within which a node lies on a joint, m (drawings are rounded; joints.py accepts 1e-5 m)"""


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

    def rows(self, direction: FloatArray, nodes: int) -> sparse.csr_matrix:
        """Return (c, 3 nodes): the slave's displacement relative to the master along `direction` (c, 2) or (c, 1).

        Two components are x and y, one is z. Zeros are stored where contacts move, so that the pattern
        stays; entries of a support never.
        """
        count, components = len(self), direction.shape[1]
        node = np.column_stack([np.maximum(self.slave_node, 0), self.master_nodes])
        weight = np.column_stack([self.slave_node >= 0, -self.weights])
        value = weight[:, :, None] * direction[:, None, :]
        column = 3 * node[:, :, None] + (np.arange(2) if components == 2 else np.array([2]))
        row = np.broadcast_to(np.arange(count)[:, None, None], value.shape)
        keep = value != 0.0
        if self.moving:
            real = np.column_stack([self.slave_node >= 0, *[self.weights.any(axis=1)] * 3])
            keep = np.broadcast_to(real[:, :, None], value.shape)
        return sparse.csr_matrix((value[keep], (row[keep], column[keep])), shape=(count, 3 * nodes))

    def normal_rows(self, nodes: int) -> sparse.csr_matrix:
        """Return B_n (c, 3 nodes): gap = B_n u."""
        return self.rows(self.normal, nodes)

    def tangential_rows(self, nodes: int) -> sparse.csr_matrix:
        """Return B_t (2 c, 3 nodes), rows interleaved: in-plane and out-of-plane slip of each contact."""
        in_plane = self.rows(self.tangent, nodes)
        out_of_plane = self.rows(np.ones((len(self), 1)), nodes)
        order = np.arange(2 * len(self)).reshape(2, -1).T.ravel()
        return sparse.vstack([in_plane, out_of_plane], format="csr")[order]


def find_contacts(bodies: Bodies, meshes: BodyMeshes) -> Contacts:
    """Return the contacts of all interfaces. Raises AssertionError if a slave node faces no master triangle."""
    surface_nodes = [np.unique(meshes.side_triangles[meshes.body_of_side == b]) for b in range(bodies.moving)]
    surfaces = [meshes.side_triangles[meshes.body_of_side == b] for b in range(bodies.moving)]
    parts = [_of_interface(k, bodies, meshes.nodes, surface_nodes, surfaces) for k in range(len(bodies.body_i))]
    columns = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    first = _first_of_each(columns)
    return Contacts(**{name: read_only(values[first], values.dtype) for name, values in columns.items()}, moving=False)


def _of_interface(
    number: int, bodies: Bodies, nodes: FloatArray, surface_nodes: list[IntArray], surfaces: list[IntArray]
) -> dict[str, npt.NDArray]:
    start, end = bodies.start[number], bodies.end[number]
    body_i, body_j = int(bodies.body_i[number]), int(bodies.body_j[number])
    tangent = (end - start) / np.linalg.norm(end - start)
    outward_of_i = np.array([tangent[1], -tangent[0]])
    on_joint = {b: nodes_on(start, end, surface_nodes[b], nodes) for b in (body_i, body_j) if b < bodies.moving}
    slave, master = slave_and_master(body_i, body_j, on_joint)
    slave_nodes = on_joint[slave]
    if master < bodies.moving:
        triangles = triangles_on(start, end, surfaces[master], nodes)
        master_nodes, weights = _project(nodes[slave_nodes], nodes, triangles, tangent)
    else:
        master_nodes, weights = np.zeros((len(slave_nodes), 3), np.int64), np.zeros((len(slave_nodes), 3))
    count = len(slave_nodes)
    return {
        "slave_node": slave_nodes,
        "slave_body": np.full(count, slave),
        "master_body": np.full(count, master),
        "interface": np.full(count, number),
        "master_nodes": master_nodes,
        "weights": weights,
        "normal": np.tile(outward_of_i if master == body_i else -outward_of_i, (count, 1)),
        "tangent": np.tile(tangent, (count, 1)),
        "friction": np.full(count, bodies.friction[number]),
        "point": nodes[slave_nodes],
    }


def slave_and_master(body_i: int, body_j: int, on_joint: dict[int, IntArray]) -> tuple[int, int]:
    """Return the two bodies, first the one with more nodes on the joint; a support is never a slave."""
    if body_j not in on_joint:
        return body_i, body_j
    if body_i not in on_joint or len(on_joint[body_j]) > len(on_joint[body_i]):
        return body_j, body_i
    return body_i, body_j


def distance_and_position(start: FloatArray, end: FloatArray, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return distance from the line and position along it, both in m, of points (..., >= 2)."""
    length = np.linalg.norm(end - start)
    tangent = (end - start) / length
    offset = points[..., :2] - start
    return np.abs(offset @ np.array([tangent[1], -tangent[0]])), offset @ tangent


def nodes_on(start: FloatArray, end: FloatArray, candidates: IntArray, nodes: FloatArray) -> IntArray:
    """Return those of the `candidates` (node numbers) that lie on the segment start -> end, ends included."""
    distance, position = distance_and_position(start, end, nodes[candidates])
    length = np.linalg.norm(end - start)
    on = (distance < TOLERANCE) & (position > -TOLERANCE) & (position < length + TOLERANCE)
    return candidates[on]


def triangles_on(start: FloatArray, end: FloatArray, triangles: IntArray, nodes: FloatArray) -> IntArray:
    """Return those of the `triangles` (t, 3) that lie on the segment start -> end."""
    distance, position = distance_and_position(start, end, nodes[triangles])
    centre = position.mean(axis=1)
    length = np.linalg.norm(end - start)
    return triangles[(distance < TOLERANCE).all(axis=1) & (centre > 0) & (centre < length)]


def _project(
    points: FloatArray, nodes: FloatArray, triangles: IntArray, tangent: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Return for points (p, 3) the triangle each falls in (p, 3) and its barycentric weights (p, 3)."""
    assert len(triangles), "an interface has no master triangle: joint ends are not imprinted"
    flat = np.stack([nodes[..., :2] @ tangent, nodes[..., 2]], axis=-1)
    target = np.stack([points[:, :2] @ tangent, points[:, 2]], axis=-1)
    weights = barycentric(flat[triangles], target[:, None])
    best = weights.min(axis=2).argmax(axis=1)
    chosen = weights[np.arange(len(points)), best]
    assert chosen.min() > -1e-3, "a slave node lies outside the master's surface: joint ends are not imprinted"
    chosen = np.where(chosen < 1e-9, 0.0, chosen)
    return triangles[best], chosen / chosen.sum(axis=1, keepdims=True)


def barycentric(corners: FloatArray, points: FloatArray) -> FloatArray:
    """Return weights (..., 3) of points (..., 2) in triangles with corners (..., 3, 2)."""
    a, b, c = (corners[..., k, :] for k in range(3))
    doubled = _cross(b - a, c - a)
    return np.stack([_cross(q - points, r - points) / doubled for q, r in ((b, c), (c, a), (a, b))], axis=-1)


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _first_of_each(columns: dict[str, npt.NDArray]) -> IntArray:
    """Return positions of the first contact of each (slave node, master body, normal), in ascending order."""
    key = np.column_stack(
        [columns["slave_node"], columns["master_body"], np.round(columns["normal"] * 1e6).astype(np.int64)]
    )
    return np.sort(np.unique(key, axis=0, return_index=True)[1])
