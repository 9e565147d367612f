"""How much too stiff elements are, by the jumps of stress between them (numpy only).

Stress is constant in a 4-node tetrahedron and jumps from one to the next, where that of a solid does not. Means at the
nodes of a body, weighted by volume, with linear functions between them, are nearer to it; the energy of what is left,

    sum over elements of  V / 20 (sum_i d_i : eps(d_i) + D : eps(D)),    d_i = mean at node i - sigma,  D = sum_i d_i

is about that by which the stress is wrong, and over that of the stress itself about how much too stiff the bodies are
under given loads (eps(d): the strain of stress d). O. C. Zienkiewicz and J. Z. Zhu, IJNME 24 (1987) 337-357.
"""

from __future__ import annotations

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.pushover.meshing import BodyMeshes
from orchestrator.pushover.solids.elastic_constants import ElasticConstants


def excess_stiffness(meshes: BodyMeshes, elastic: ElasticConstants, stress: FloatArray) -> float:
    """Return about how much too stiff bodies of 4-node tetrahedra are under loads that make stresses (t, 3, 3) in Pa,
    in the axes of each body: a part of their stiffness, 0 without stress."""
    cells, corners = meshes.tetrahedra, meshes.nodes[meshes.tetrahedra]
    volume = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6.0
    share = np.repeat(volume, 4)
    around = np.bincount(cells.ravel(), share, len(meshes.nodes))
    at_nodes = np.zeros((len(meshes.nodes), 3, 3))
    np.add.at(at_nodes, cells.ravel(), share[:, None, None] * np.repeat(stress, 4, axis=0))
    at_nodes /= np.where(around > 0.0, around, 1.0)[:, None, None]
    jumps = at_nodes[cells] - stress[:, None]

    def energy(of: FloatArray) -> FloatArray:
        """sigma : eps(sigma) (t, ...) of stresses (t, ..., 3, 3)."""
        modulus, ratio = (
            body[meshes.body_of_tetrahedron].reshape(-1, *[1] * (of.ndim - 3))
            for body in (elastic.elastic_modulus, elastic.poisson_ratio)
        )
        trace = np.trace(of, axis1=-2, axis2=-1)
        return np.asarray(((1.0 + ratio) * (of**2).sum(axis=(-2, -1)) - ratio * trace**2) / modulus)

    wrong = float(volume @ (energy(jumps).sum(axis=1) + energy(jumps.sum(axis=1)))) / 20.0
    stored = float(volume @ energy(stress))
    return wrong / stored if stored > 0.0 else 0.0
