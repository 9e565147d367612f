"""Stress in the elements and forces in the contacts of a displaced wall, for pictures (numpy only).

    sigma = 2 mu eps + lambda tr(eps) I         eps: mean strain of the element, in the frame of its body
    principal stresses: eigenvalues of sigma;   von Mises: sqrt(3/2 s : s), s = sigma - tr(sigma)/3 I
    pressure = normal force of a contact / area of the joint's triangles that its slave node stands for
    force on the slave = lambda n - tau, tau from what is stored of a state (contact_law.py): limit x q / tolerance

With barycentric functions L_i of an element, grad u = sum_i u_i grad L_i, plus for 10-node tetrahedra the departures a
of the curved edges, 4 L_i L_j a, whose mean gradient is a (grad L_i + grad L_j).
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.pushover.contact.cohesion import shear_limit
from orchestrator.pushover.contact.contact_law import tolerances
from orchestrator.pushover.contact.contact_search import contacts_of_interfaces
from orchestrator.pushover.contact.faces import find_faces, find_touching, tributary
from orchestrator.pushover.contact.frames import fit_frames
from orchestrator.pushover.increments import Increment
from orchestrator.pushover.meshing import BodyMeshes
from orchestrator.pushover.solids.edges import TETRAHEDRON_EDGES, edges_of, on_outline
from orchestrator.pushover.solids.elastic_constants import ElasticConstants

if TYPE_CHECKING:
    from orchestrator.pushover.model import ContactModel


def element_stress(
    meshes: BodyMeshes,
    elastic: ElasticConstants,
    displacement: FloatArray,
    large_displacement: bool,
    slopes: FloatArray | None = None,
) -> FloatArray:
    """Return stress tensors (t, 3, 3) in Pa over the wall's thickness, tension positive.

    displacement (n, 3) in m: nodes, then curved edges. In large displacements the axes are those of each body, which
    turn with it. slopes (t, 4, 3): the `barycentric_slopes` of the elements, where they are known.
    """
    local = _without_rigid_motion(meshes, displacement) if large_displacement else displacement
    cells = meshes.tetrahedra
    if slopes is None:
        slopes = barycentric_slopes(meshes.nodes[cells])
    gradient = np.einsum("tia,tib->tab", local[cells], slopes)
    if len(displacement) > len(meshes.nodes):
        pairs = slopes[:, TETRAHEDRON_EDGES].sum(axis=2)
        gradient += np.einsum("tea,teb->tab", _departures(meshes, local), pairs)
    strain = 0.5 * (gradient + gradient.transpose(0, 2, 1))
    modulus, ratio = (
        of_body[meshes.body_of_tetrahedron] for of_body in (elastic.elastic_modulus, elastic.poisson_ratio)
    )
    volumetric = modulus * ratio / ((1 + ratio) * (1 - 2 * ratio)) * np.trace(strain, axis1=1, axis2=2)
    return (modulus / (1 + ratio))[:, None, None] * strain + volumetric[:, None, None] * np.eye(3)


def in_fixed_axes(meshes: BodyMeshes, stress: FloatArray, displacement: FloatArray) -> FloatArray:
    """Return stress tensors (t, 3, 3), given in axes that turn with their bodies, in the axes x, y, z of the wall."""
    turn = np.tile(np.eye(3), (len(meshes.unit_weight), 1, 1))
    turn[:, :2, :2] = fit_frames(meshes, displacement, len(turn)).rotation
    turn = turn[meshes.body_of_tetrahedron]
    return turn @ stress @ turn.transpose(0, 2, 1)


def contact_forces(model: ContactModel, increment: Increment) -> FloatArray:
    """Return the forces (c, 3) in N on the slaves of all possible contacts; the masters have them with the other sign.

    A contact in front has the force of its image, too (front.py): what they have across the wall cancels. While the
    wall moves, what viscous joints add is left out, and friction is that of these normal forces, not of those before.
    """
    possible, force = model.possible, increment.normal_force
    bond = model.bond and replace(model.bond, damage=increment.damage)
    limit, _ = shear_limit(force, possible.friction, bond)
    shear_stiffness = None if model.mortar is None else model.mortar.shear_stiffness
    tolerance, _ = tolerances(limit, model.slip_tolerance, shear_stiffness)
    traction = (limit / tolerance)[:, None] * increment.elastic_slip
    normal, tangent = possible.normal, possible.tangent
    if model.tracking is not None:
        bodies = int(possible.master_body.max()) + 1
        turn = fit_frames(model.meshes, increment.displacement, bodies).rotation[possible.master_body]
        normal, tangent = (np.einsum("cij,cj->ci", turn, one) for one in (normal, tangent))
    across = np.zeros(len(force)) if model.front.halves else -traction[:, 1]
    return np.column_stack([force[:, None] * normal - traction[:, :1] * tangent, across])


def barycentric_slopes(corners: FloatArray) -> FloatArray:
    """Return the gradients (t, 4, 3) in 1/m of the barycentric functions of tetrahedra with corners (t, 4, 3)."""
    inverse = np.linalg.inv(corners[:, 1:] - corners[:, :1]).transpose(0, 2, 1)
    return np.concatenate([-inverse.sum(axis=1, keepdims=True), inverse], axis=1)


def von_mises(stress: FloatArray) -> FloatArray:
    """Return (t,) of stress tensors (t, 3, 3)."""
    deviator = stress - np.trace(stress, axis1=1, axis2=2)[:, None, None] / 3 * np.eye(3)
    return np.sqrt(1.5 * np.sum(deviator**2, axis=(1, 2)))


def slave_areas(model: ContactModel, bodies: Bodies) -> FloatArray:
    """Return the area (c,) in m2 that the slave node of each possible contact stands for, its image included: in all
    joints that it touches in, or in that a contact of later belongs to; 0 for contacts of a corner."""
    contacts, meshes, faces = model.possible, model.meshes, find_faces(bodies)
    touching, sides = find_touching(bodies, meshes)
    areas = np.zeros(len(contacts))

    def of_nodes(edge: int) -> FloatArray:
        nodes, shares = tributary(sides[edge], meshes.nodes)
        every = np.zeros(len(meshes.nodes))
        every[nodes] = shares
        return model.front.summed(every)

    for number in np.unique(contacts.interface):
        for body, edge in (
            (bodies.interfaces.i[number], bodies.edge_i[number]),
            (bodies.interfaces.j[number], bodies.edge_j[number]),
        ):
            here = (contacts.interface == number) & (contacts.slave_body == body) & (contacts.slave_node >= 0)
            areas[here] = of_nodes(faces.first_edge[body] + edge)[contacts.slave_node[here]]
    drawn = contacts.chosen(np.arange(len(model.joint_contacts)))
    areas[: len(drawn)] = 0.0
    for edge, rows in zip(
        touching.slave_edge, contacts_of_interfaces(touching, sides, drawn.slave_node, drawn.interface), strict=True
    ):
        areas[rows] += of_nodes(edge)[drawn.slave_node[rows]]
    return areas


def _without_rigid_motion(meshes: BodyMeshes, displacement: FloatArray) -> FloatArray:
    """Return displacements (n, 3) in the frames of the bodies: R^T (x - t) - X for nodes, R^T a for edges."""
    frames = fit_frames(meshes, displacement, int(meshes.body_of_node[-1]) + 1)
    count = len(meshes.nodes)
    node = meshes.body_of_node
    local = displacement.copy()
    moved = meshes.nodes[:, :2] + displacement[:count, :2] - frames.translation[node]
    local[:count, :2] = np.einsum("mji,mj->mi", frames.rotation[node], moved) - meshes.nodes[:, :2]
    if len(displacement) > count:
        edges = edges_of(meshes.tetrahedra)
        edge = node[edges[~on_outline(edges, meshes), 0]]
        local[count:, :2] = np.einsum("mji,mj->mi", frames.rotation[edge], displacement[count:, :2])
    return local


def _departures(meshes: BodyMeshes, displacement: FloatArray) -> FloatArray:
    """Return (t, 6, 3): departure of each edge of each element from the mean of its ends; 0 on the outline."""
    edges = edges_of(meshes.tetrahedra)
    of_edge = np.zeros((len(edges), 3))
    of_edge[~on_outline(edges, meshes)] = displacement[len(meshes.nodes) :]
    pairs = np.sort(meshes.tetrahedra[:, TETRAHEDRON_EDGES], axis=2)
    width = [len(meshes.nodes), 1]
    return of_edge[np.searchsorted(edges @ width, pairs @ width)]
