"""Bodies and their meshes -> the contact model: matrices, loads, contacts, and where the answer is read."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy.sparse as sparse
from mpi4py import MPI

from orchestrator.bodies import Bodies
from orchestrator.masonry.wall import FloatArray
from orchestrator.meshing import BodyMeshes
from orchestrator.pushover.contact_search import Contacts, find_contacts
from orchestrator.pushover.elasticity import assemble, gravity_and_lateral_loads
from orchestrator.pushover.settings import ContactSettings, ElasticSettings


@dataclass(frozen=True, eq=False, slots=True)
class ContactModel:
    """All that an increment needs; the same on every rank. n = 3 x nodes, c contacts.

    stiffness, mass (n, n) in N/m, kg; stiffness_magnitude: |K| entry by entry. gravity, lateral (n,) in N (lateral for
    load multiplier 1). weight in N.
    normal_rows B_n (c, n), tangential_rows B_t (2 c, n). direction: load along +x (1) or -x (-1).
    mean_row, top_row (n,): mass-weighted mean displacement and mean displacement of the top edge, along the load.
    on_support (c,): True where the master is a support. contact_stiffness in N/m scales multipliers to displacements
    (active set and conditioning only; converged results do not depend on it).
    """

    meshes: BodyMeshes
    contacts: Contacts
    stiffness: sparse.csr_matrix
    stiffness_magnitude: sparse.csr_matrix
    mass: sparse.csr_matrix
    gravity: FloatArray
    lateral: FloatArray
    weight: float
    normal_rows: sparse.csr_matrix
    tangential_rows: sparse.csr_matrix
    direction: int
    mean_row: FloatArray
    top_row: FloatArray
    on_support: npt.NDArray[np.bool_]
    contact_stiffness: float
    slip_tolerance: float

    @property
    def unknowns(self) -> int:
        """Displacements, multipliers and the load multiplier."""
        return len(self.gravity) + len(self.contacts) + 1


def build_model(
    bodies: Bodies,
    meshes: BodyMeshes,
    elastic: ElasticSettings,
    contact: ContactSettings,
    direction: int,
    comm: MPI.Comm,
) -> ContactModel:
    """Assemble matrices and loads with dolfinx on `comm` and search the contacts."""
    stiffness, mass = assemble(meshes, elastic, comm)
    gravity, lateral = gravity_and_lateral_loads(mass, direction)
    contacts = find_contacts(bodies, meshes)
    weight = float(np.abs(lateral.sum()))
    return ContactModel(
        meshes=meshes,
        contacts=contacts,
        stiffness=stiffness,
        stiffness_magnitude=abs(stiffness),
        mass=mass,
        gravity=gravity,
        lateral=lateral,
        weight=weight,
        normal_rows=contacts.normal_rows(len(meshes.nodes)),
        tangential_rows=contacts.tangential_rows(len(meshes.nodes)),
        direction=direction,
        mean_row=lateral / weight,
        top_row=direction * top_weights(meshes),
        on_support=contacts.master_body >= bodies.moving,
        contact_stiffness=elastic.elastic_modulus * bodies.thickness / 10,
        slip_tolerance=contact.slip_tolerance,
    )


def top_weights(meshes: BodyMeshes) -> FloatArray:
    """Return (3 nodes,): weights of the x displacements whose sum is the mean over the wall's top surface.

    The surface is the set of side triangles at the largest y; where the top is a point or a slope, it is the highest
    nodes, with equal weights.
    """
    nodes, triangles = meshes.nodes, meshes.side_triangles
    highest = nodes[:, 1] > nodes[:, 1].max() - 1e-6
    top = triangles[highest[triangles].all(axis=1)]
    weights = np.zeros(len(nodes))
    if len(top):
        edges = nodes[top[:, 1:]] - nodes[top[:, :1]]
        area = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
        np.add.at(weights, top, area[:, None] / 3)
    else:
        weights[highest] = 1.0
    return np.kron(weights / weights.sum(), [1.0, 0.0, 0.0])
