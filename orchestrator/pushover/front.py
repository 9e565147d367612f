"""The nodes that are unknowns: those in front of the middle of the thickness, where what lies behind is their image.

A wall loaded in its plane is the same on both sides of the plane in the middle of its thickness, and so is its answer:
u_x and u_y alike, u_z opposite. Only such displacements u = P v are admitted, v those of the nodes in front, which
makes of stiffness, mass and forces

    K -> P^T K P        M -> P^T M P        f -> P^T f

all of the wall's energy and weight with half the unknowns. A contact in front carries the force of its image, too. (The
diagonals of tetrahedra are no mirror images: bodies would otherwise sway a little out of the plane, against friction.)
Middle nodes of 10-node tetrahedra have no images, and a mesh of them is taken whole.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from scipy.spatial import cKDTree

from orchestrator.basis.arrays import FloatArray, IntArray, read_only
from orchestrator.pushover.meshing import BodyMeshes

NEAR = 1e-6
"""distance over the thickness within which a node is the image of another"""


@dataclass(frozen=True, eq=False, slots=True)
class FrontNodes:
    """h of the m nodes of a mesh (curved edges follow them, where there are any).

    nodes (h, 3) in m, body_of_node (h,); number (h,): theirs in the mesh. row (m,): which of them, or of whose image,
    each node of the mesh is; side (m,): 1 in front, -1 behind, 0 in the middle.
    """

    nodes: FloatArray
    body_of_node: IntArray
    number: IntArray
    row: IntArray
    side: FloatArray

    @property
    def halves(self) -> bool:
        """Whether there are images at all."""
        return len(self.row) > len(self.number)

    def columns(self) -> sparse.csr_matrix:
        """Return P (3 m, 3 h)."""
        count, place = 3 * len(self.row), (3 * self.row[:, None] + np.arange(3)).ravel()
        value = np.column_stack([np.ones((len(self.row), 2)), self.side]).ravel()
        return sparse.csr_matrix((value, (np.arange(count), place)), shape=(count, 3 * len(self.number)))

    def folded(self, matrix: sparse.csr_matrix) -> sparse.csr_matrix:
        """Return P^T K P; nodes in the middle keep their own stiffness across, where nothing acts on them."""
        if not self.halves:
            return matrix
        columns = self.columns()
        across = np.where(self.side[self.number] == 0.0, matrix.diagonal()[3 * self.number + 2], 0.0)
        held = sparse.diags(np.kron(across, [0.0, 0.0, 1.0]))
        return (columns.T @ matrix @ columns + held).tocsr()

    def of_front(self, forces: FloatArray) -> FloatArray:
        """Return P^T f (3 h,) for forces (3 m,)."""
        return self.columns().T @ forces if self.halves else forces

    def of_all(self, displacement: FloatArray) -> FloatArray:
        """Return the displacements (m, 3) of all nodes for those of the ones in front (h, 3)."""
        if not self.halves:
            return displacement
        return displacement[self.row] * np.column_stack([np.ones((len(self.row), 2)), self.side])

    def summed(self, values: FloatArray) -> FloatArray:
        """Return the sum of values (m,) over each node and its image, (m,)."""
        if not self.halves:
            return values
        return np.bincount(self.row, values, len(self.number)).astype(float)[self.row]


def front_nodes(meshes: BodyMeshes, rows: int, halves: bool) -> FrontNodes:
    """Return the nodes in front of a mesh, all of them where there are curved edges, or if `halves` is False.

    rows: nodes and curved edges.
    """
    everything = np.arange(rows)
    whole = FrontNodes(meshes.nodes, meshes.body_of_node, everything, everything, np.ones(rows))
    if not halves or rows > len(meshes.nodes):
        return whole
    low, high = meshes.nodes[:, 2].min(), meshes.nodes[:, 2].max()
    thickness, apart = high - low, float(np.ptp(meshes.nodes, axis=0).max()) + high - low
    place = np.column_stack([meshes.nodes, apart * meshes.body_of_node])  # nodes of other bodies are far away
    distance, image = cKDTree(place).query(place * [1, 1, -1, 1] + [0, 0, low + high, 0])
    assert distance.max() <= NEAR * thickness, "every node of an extruded mesh has an image"
    height = meshes.nodes[:, 2] - 0.5 * (low + high)
    side = np.where(np.abs(height) < NEAR * thickness, 0.0, -np.sign(height))
    number = np.flatnonzero(side >= 0.0)
    row = np.zeros(rows, np.int64)
    row[number] = np.arange(len(number))
    row = np.where(side < 0.0, row[image], row)
    return FrontNodes(
        nodes=read_only(meshes.nodes[number]),
        body_of_node=read_only(meshes.body_of_node[number], np.int64),
        number=read_only(number, np.int64),
        row=read_only(row, np.int64),
        side=read_only(side),
    )
