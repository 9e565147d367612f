"""Bodies and their meshes -> the contact model: matrices, loads, contacts, and where the answer is read."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sparse

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray
from orchestrator.loads.block_loads import horizontal
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.pushover.contact.cohesion import Bond
from orchestrator.pushover.contact.contact_search import Contacts
from orchestrator.pushover.contact.contact_tracking import Tracking, track
from orchestrator.pushover.contact.frames import Frames, fit_frames
from orchestrator.pushover.contact.mortar import Mortar
from orchestrator.pushover.front import FrontNodes, front_nodes
from orchestrator.pushover.joints_in_front import joints_in_front
from orchestrator.pushover.meshing import BodyMeshes, triangle_areas
from orchestrator.pushover.settings import ContactSettings, ElasticSettings
from orchestrator.pushover.solids.elastic_constants import ElasticConstants, constants_of, slip_tolerance_of
from orchestrator.pushover.solids.elasticity import assemble, gravity_and_lateral_loads
from orchestrator.pushover.solids.nodal_loads import NodalLoads, own_weight
from orchestrator.pushover.solids.tie_bars import TieBars


@dataclass(frozen=True, eq=False)
class ContactModel:
    """All that an increment needs; the same on every rank. n = 3 x (nodes in front + curved edges), c contacts.

    front: the nodes that are unknowns, of all those of `meshes` (front.py).
    stiffness, mass (n, n) in N/m, kg; stiffness_magnitude: |K| entry by entry. body (n / 3,) of each node and edge.
    gravity, lateral (n,) in N: all dead load, and the live load for load multiplier 1. weight: all dead load in N;
    horizontal_load: horizontal part of the live load in N, what base shears are read against.
    normal_rows B_n (c, n), tangential_rows B_t (2 c, n). forward (2,): horizontal unit vector along the live load.
    rigid (n,) in m: displacement that causes no stress; gap_offset (c,) in m: gap = B_n u + gap_offset; both zero while
    the wall is undeformed. rows (c,): numbers of these contacts among all `possible` ones. heirs (h, 2): of those that
    gave way, and of what carries for them (contact_tracking.py). support_side (c,): 1 where the master is a support, -1
    where the slave is one, else 0. tracking: None for small displacements.
    bond: strengths of all `possible` contacts, or None; mortar: their stiffness and what crushes them, or None; ties or
    None.
    body_mass, body_weight, body_live (b,): of the moving bodies, kg, N (dead load included) and N (magnitude of the
    live load for load multiplier 1). fallen (b,): those taken out.
    mean_row, top_row (n,): mean displacement along the live load, weighted by it (its work over its size), and mean
    horizontal displacement of the top edge.
    contact_stiffness in N/m scales multipliers to displacements
    (active set and conditioning only; converged results do not depend on it).
    """

    meshes: BodyMeshes
    front: FrontNodes
    contacts: Contacts
    stiffness: sparse.bsr_matrix
    stiffness_magnitude: sparse.bsr_matrix
    mass: sparse.csr_matrix
    body: IntArray
    gravity: FloatArray
    lateral: FloatArray
    weight: float
    horizontal_load: float
    normal_rows: sparse.csr_matrix
    tangential_rows: sparse.csr_matrix
    forward: FloatArray
    mean_row: FloatArray
    top_row: FloatArray
    support_side: IntArray
    contact_stiffness: float
    slip_tolerance: float
    rigid: FloatArray
    gap_offset: FloatArray
    overlap: FloatArray
    rows: IntArray
    heirs: IntArray
    bodies: int
    body_names: tuple[str, ...]
    elastic: ElasticConstants
    tracking: Tracking | None
    body_mass: FloatArray
    body_weight: FloatArray
    body_live: FloatArray
    fallen: BoolArray
    bond: Bond | None = None
    mortar: Mortar | None = None
    ties: TieBars | None = None

    @cached_property
    def normal_columns(self) -> sparse.csc_matrix:
        """B_n^T (n, c): making it takes longer than a product with it."""
        return self.normal_rows.T

    @cached_property
    def tangential_columns(self) -> sparse.csc_matrix:
        """B_t^T (n, 2 c)."""
        return self.tangential_rows.T

    @cached_property
    def contact_rows(self) -> sparse.csr_matrix:
        """B (3 c, n): normal row and both tangential rows of each contact in turn."""
        return self.contacts.rows((0, 1, 2), len(self.body))

    @cached_property
    def contact_columns(self) -> sparse.csc_matrix:
        """B^T (n, 3 c)."""
        return self.contact_rows.T

    @property
    def height(self) -> float:
        """Height of what moves, m."""
        return float(np.ptp(self.meshes.nodes[:, 1]))

    @cached_property
    def possible(self) -> Contacts:
        """All contacts that have a place in an Increment's arrays, with the numbers of nodes in `meshes`."""
        return (self.tracking.possible if self.tracking else self.contacts).renumbered(self.front.number)

    @property
    def joint_contacts(self) -> Contacts:
        """Contacts of the joints in the undeformed wall: the first that have a place in an Increment's arrays."""
        return self.tracking.possible.chosen(np.arange(self.tracking.touching)) if self.tracking else self.contacts

    def on_its_contacts(self, values: FloatArray) -> FloatArray:
        """Return the part (c, ...) of `values` (possible, ...); what a contact that has gone carried is handed over."""
        moved, (old, new) = values.copy(), self.heirs.T
        np.add.at(moved, new, values[old])
        moved[old] = 0.0
        return moved[self.rows]

    @property
    def pairs(self) -> tuple[IntArray, IntArray]:
        """Slave's and master's body of each of the possible contacts."""
        return self.possible.slave_body, self.possible.master_body

    @property
    def unknowns(self) -> int:
        """Displacements, multipliers and the load multiplier."""
        return len(self.gravity) + len(self.contacts) + 1


def build_model(
    bodies: Bodies,
    meshes: BodyMeshes,
    elastic: ElasticSettings,
    contact: ContactSettings,
    large_displacement: bool = False,
    loads: NodalLoads | None = None,
    ties: TieBars | None = None,
    halves: bool = True,
) -> ContactModel:
    """Assemble matrices and loads with dolfinx and search the contacts, those that sliding may bring too.

    Without `loads` the wall carries its weight, and the live load is the weight turned to +x. halves: front.py.
    """
    constants = constants_of(bodies, elastic)
    elasticity = assemble(meshes, constants, elastic.element_order)
    front = front_nodes(meshes, len(elasticity.body), halves)
    stiffness = front.folded(elasticity.stiffness).tobsr((3, 3))
    mass, body = front.folded(elasticity.mass), elasticity.body[front.number]
    loads = loads or own_weight(meshes, np.array([1.0, 0.0]))
    dead, live, weight = _loads(elasticity.mass, meshes, loads)
    gravity, lateral = front.of_front(dead), front.of_front(live)
    forward = horizontal(loads.direction)
    base_shear = _horizontal(lateral, front)
    contacts, tracking, bond, mortar = joints_in_front(bodies, meshes, front, contact, large_displacement)
    model = ContactModel(
        meshes=meshes,
        front=front,
        contacts=contacts,
        stiffness=stiffness,
        stiffness_magnitude=abs(stiffness),
        mass=mass,
        body=body,
        gravity=gravity,
        lateral=lateral,
        weight=weight,
        horizontal_load=base_shear,
        normal_rows=contacts.normal_rows(len(body)),
        tangential_rows=contacts.tangential_rows(len(body)),
        forward=forward,
        mean_row=lateral / (base_shear / loads.sideways),
        top_row=front.of_front(_padded(top_weights(meshes, forward), len(dead))),
        support_side=support_side(contacts, bodies.moving),
        contact_stiffness=elastic.elastic_modulus * bodies.thickness / 10,
        slip_tolerance=slip_tolerance_of(bodies, elastic, contact),
        rigid=np.zeros_like(gravity),
        gap_offset=np.zeros(len(contacts)),
        overlap=np.zeros(len(contacts)),
        rows=np.arange(len(contacts)),
        heirs=np.zeros((0, 2), np.int64),
        body_mass=_of_bodies(mass @ np.ones(len(gravity)), body, bodies.moving),
        body_weight=_of_bodies(-gravity, body, bodies.moving),
        body_live=np.hypot(_of_bodies(lateral, body, bodies.moving), _of_bodies(lateral, body, bodies.moving, 0)),
        fallen=np.zeros(bodies.moving, bool),
        bodies=bodies.moving,
        body_names=tuple(body.name for body in bodies.bodies),
        elastic=constants,
        tracking=tracking,
        bond=bond,
        mortar=mortar,
        ties=ties and ties.on_rows(front.row, len(body)),
    )
    return displaced(model, np.zeros_like(gravity))


def _of_bodies(values: FloatArray, body: IntArray, bodies: int, axis: int = 1) -> FloatArray:
    """Return the sum over each body (b,) of the parts of values (n,) along an axis, upright by default."""
    return np.bincount(body, values[axis::3], bodies).astype(float)


def _horizontal(lateral: FloatArray, front: FrontNodes) -> float:
    """Return the horizontal part of a live load (n,) in N."""
    return abs(float(lateral[: front.nodes.size : 3].sum()))


def driven_by(model: ContactModel, driven: BoolArray) -> ContactModel:
    """Return the model whose `mean_row` is the mean displacement along the live load of the bodies `driven` (b,)."""
    part = np.where(np.repeat(driven[model.body], 3), model.lateral, 0.0)
    across, upwards = (part[axis : model.front.nodes.size : 3] for axis in (0, 1))
    return replace(model, mean_row=part / np.hypot(across, upwards).sum())


def without(model: ContactModel, fallen: BoolArray) -> ContactModel:
    """Return the undeformed model without the weight, live load and contacts of the bodies `fallen` (b,).

    Their nodes stay among the unknowns, held by their mass alone, where they have come to.
    """
    here = np.repeat(~fallen[model.body], 3)
    top = model.top_row * here
    if not top.any():
        left = ~fallen[model.meshes.body_of_node]
        weights = _padded(top_weights(model.meshes, model.forward, left), 3 * len(model.front.row))
        top = model.front.of_front(weights)
    far = 0.0 if model.tracking else float(np.ptp(model.meshes.nodes[:, :2], axis=0).sum())
    return replace(
        model,
        gravity=model.gravity * here,
        lateral=model.lateral * here,
        horizontal_load=_horizontal(model.lateral * here, model.front),
        top_row=top / np.abs(top.sum()),
        gap_offset=model.gap_offset + far * touching(fallen, model.contacts),
        fallen=fallen,
        ties=model.ties and model.ties.without(fallen),
    )


def touching(bodies: BoolArray, contacts: Contacts) -> BoolArray:
    """Return which contacts (c,) have one of some bodies (b,) on either side."""
    there = np.append(bodies, np.zeros(max(contacts.master_body.max(), contacts.slave_body.max()) + 1, bool))
    return there[contacts.slave_body] | there[contacts.master_body]


def _loads(mass: sparse.csr_matrix, meshes: BodyMeshes, loads: NodalLoads) -> tuple[FloatArray, FloatArray, float]:
    """Return all dead load and the live load (n,) in N, and the size of the dead load."""
    gravity, turned = gravity_and_lateral_loads(mass, len(meshes.nodes))
    weight = float(np.abs(turned[: meshes.nodes.size].sum()))
    dead = np.kron(loads.dead, [0.0, -1.0, 0.0])
    live = np.kron(loads.live, [*loads.direction, 0.0])
    own = loads.direction[0] * turned - loads.direction[1] * gravity if loads.of_mass else np.zeros_like(turned)
    return (
        gravity + _padded(dead, len(gravity)),
        own + _padded(live, len(turned)),
        weight + float(loads.dead.sum()),
    )


def support_side(contacts: Contacts, moving: int) -> IntArray:
    """Return (c,): 1 where the master is a support, -1 where the slave is one, else 0."""
    return (contacts.master_body >= moving).astype(int) - (contacts.slave_body >= moving).astype(int)


def displaced(
    model: ContactModel,
    displacement: FloatArray,
    closed: FloatArray | None = None,
    known: BoolArray | None = None,
) -> ContactModel:
    """Return the model of the wall displaced by `displacement` (n,) in m: corotational bodies, contacts found anew.

    With R the rotation that fits a body's nodes best, its internal forces are R K R^T (u - (R X + t - X)). Mass and
    loads do not change. `model` is the undeformed one; without tracking it is returned as it is. closed (possible,): by
    how much mortar has closed, m. known (possible,): contacts that existed before (contact_tracking.py).
    """
    if model.tracking is None:
        return model
    nodal = displacement.reshape(-1, 3)
    possible, faces = model.tracking.possible, model.tracking.faces
    frames = fit_frames(model.front, nodal, max(possible.master_body.max(), faces.body.max()) + 1)
    gone = touching(model.fallen, possible)
    tracked = track(model.tracking, model.front, frames, nodal, gone, closed, known)
    normal_rows = tracked.contacts.normal_rows(len(nodal))
    return replace(
        model,
        contacts=tracked.contacts,
        stiffness=_turned(model.stiffness, frames.rotation[model.body]),
        normal_rows=normal_rows,
        tangential_rows=tracked.contacts.tangential_rows(len(nodal)),
        support_side=support_side(tracked.contacts, model.bodies),
        rigid=_padded(_rigid_displacement(model.front, frames), len(displacement)),
        gap_offset=tracked.gap - normal_rows @ displacement,
        overlap=-tracked.onto,
        rows=tracked.rows,
        heirs=tracked.heirs,
        ties=model.ties and model.ties.displaced(displacement),
    )


def _rigid_displacement(front: FrontNodes, frames: Frames) -> FloatArray:
    body, place = front.body_of_node, front.nodes[:, :2]
    moved = np.einsum("mij,mj->mi", frames.rotation[body], place) + frames.translation[body]
    return np.column_stack([moved - place, np.zeros(len(place))]).ravel()


def _padded(values: FloatArray, length: int) -> FloatArray:
    """Return values of nodes (3 nodes,) with zeros for the departures of edges."""
    return np.concatenate([values, np.zeros(length - len(values))])


def _turned(blocks: sparse.bsr_matrix, rotation: FloatArray) -> sparse.bsr_matrix:
    """Return R K R^T; rotation (n / 3, 2, 2), the same for all rows of a body. The pattern stays that of K."""
    node = np.repeat(np.arange(len(rotation)), np.diff(blocks.indptr))
    turned, (cosine, sine) = blocks.data, rotation[node, :, 0, None].transpose(1, 0, 2)
    for _ in range(2):  # the rows, then the columns
        x, y, z = turned.transpose(1, 0, 2)
        turned = np.stack([cosine * x - sine * y, sine * x + cosine * y, z], axis=2)
    return sparse.bsr_matrix((turned, blocks.indices, blocks.indptr), shape=blocks.shape)


def top_weights(meshes: BodyMeshes, forward: FloatArray, of: BoolArray | None = None) -> FloatArray:
    """Return (3 nodes,): weights of displacements whose sum is the mean along `forward` (2,) over the top surface.

    The surface is the set of side triangles at the largest y; where the top is a point or a slope, it is the highest
    nodes, with equal weights. of (nodes,): the nodes that count, by default all.
    """
    nodes, triangles = meshes.nodes, meshes.side_triangles
    counted = np.ones(len(nodes), bool) if of is None else of
    highest = counted & (nodes[:, 1] > nodes[counted, 1].max() - 1e-6 * np.ptp(nodes[:, 1]))
    top = triangles[highest[triangles].all(axis=1)]
    weights = np.zeros(len(nodes))
    if len(top):
        np.add.at(weights, top, triangle_areas(nodes, top)[:, None] / 3)
    else:
        weights[highest] = 1.0
    return np.kron(weights / weights.sum(), [*forward, 0.0])
