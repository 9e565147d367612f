"""Mortar: joints that close and shear elastically, and crush (numpy only).

A contact that stands for the area A of a joint with normal stiffness k_n (N/m3) and compressive strength f_c (Pa)
closes by lambda / (k_n A) under its normal force lambda, and for good by w where it crushes. What is left of its gap g
is

    G = g + lambda / (k_n A) + w,    0 <= lambda <= f_c A,    lambda > 0: G = 0,    w grows: lambda = f_c A

so that G takes the place of the gap in Newton's method, with a third state besides open and closed. The force of a
crushing contact is given, its closing is what is sought: w_n + max(-G, 0). Without mortar k_n and f_c are infinite.
Shear: contact_law.py. Contacts that sliding brings have the stiffness and strength of a joint of the same bodies that
lies along them, if there is one (possible_contacts.py).

Stiffness is spread over the nodes of a joint so that it resists displacement and rotation as a continuous one does:
its moments are exact from three nodes along the joint on. With two nodes all of it sits at the ends, which makes the
joint three times too stiff in rotation. Strength is spread by tributary areas (alike in front and at the back): the
resultant of a toe is known to a quarter of an element's length.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray, read_only
from orchestrator.basis.errors import CaseError
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.masonry.joints import Assemblage
from orchestrator.pushover.contact.contact_search import Contacts, contacts_of_interfaces
from orchestrator.pushover.contact.contact_tracking import ANGLED, Tracking
from orchestrator.pushover.contact.faces import Touching, find_touching, sides_of_faces, tributary
from orchestrator.pushover.increments import Increment
from orchestrator.pushover.meshing import BodyMeshes

IN_STRENGTH = ((0, 0), (1, 0), (0, 1), (1, 1))
"""powers along and across the joint of the moments that strength has exactly: front and back get alike"""
IN_STIFFNESS = (*IN_STRENGTH, (2, 0))
"""those that stiffness has exactly"""
DETERMINED = 1e-9
"""smallest over largest eigenvalue of moments from which weights of the nodes can bring area and moments"""


@dataclass(frozen=True, eq=False, slots=True)
class Mortar:
    """Mortar of c contacts: compliance (c,) in m/N (0: rigid), shear_stiffness (c,) in N/m and strength (c,) in N
    (infinite: rigid, no crushing). At the start of the increment: closing w (c,) in m, and which crush (c,)."""

    compliance: FloatArray
    shear_stiffness: FloatArray
    strength: FloatArray
    closing: FloatArray
    crushed: BoolArray

    def at(self, rows: IntArray, closing: FloatArray, normal_force: FloatArray) -> Mortar:
        """Return the mortar of the contacts `rows`, with their history; both arrays (possible,), in m and N."""
        return Mortar(
            compliance=self.compliance[rows],
            shear_stiffness=self.shear_stiffness[rows],
            strength=self.strength[rows],
            closing=closing[rows],
            crushed=(normal_force >= self.strength)[rows],
        )

    def summed(self, kept: IntArray, image: IntArray) -> Mortar:
        """Return the mortar of the contacts `kept` (k,); image (c,): which of them each adds its own to."""

        def added(values: FloatArray) -> FloatArray:
            return np.bincount(image, values, len(kept)).astype(float)

        with np.errstate(divide="ignore"):
            stiffness = added(1.0 / self.compliance)
        return Mortar(
            compliance=1.0 / stiffness,
            shear_stiffness=added(self.shear_stiffness),
            strength=added(self.strength),
            closing=self.closing[kept],
            crushed=self.crushed[kept],
        )

    def closed_by(self, normal_force: FloatArray) -> FloatArray:
        """Return by how much contacts (c,) are closed beyond touching, elastically and for good, m."""
        return self.closing + self.compliance * np.maximum(normal_force, 0.0)

    def opened(self, gap: FloatArray, normal_force: FloatArray) -> FloatArray:
        """Return what mortar leaves of gaps (c,) in m under normal forces (c,) in N, positive in compression."""
        return gap + self.compliance * normal_force + self.closing


def refuse_bonded_mortar(assemblage: Assemblage, softening: float) -> None:
    """Raise CaseError (key only) for bonded joints whose mortar has no answer: softening in m."""
    joints = assemblage.joints
    bonded = (joints.cohesion > 0.0) | (joints.tensile_strength > 0.0)
    if count := np.count_nonzero(bonded & np.isfinite(joints.shear_stiffness)):
        problem = f"{count} joints have a shear stiffness and cohesion or tension: not yet in the FE pushover"
        raise CaseError("joints.classes", problem, "leave one of the two out")
    least = float(np.max(joints.tensile_strength / joints.normal_stiffness, initial=0.0))
    if least >= softening:
        problem = f"{softening:g} m is less than what mortar opens by under its tension, {least:.3g} m: it would snap"
        raise CaseError("contact.softening_displacement", problem, "give more, or a larger normal stiffness")


def find_mortar(
    bodies: Bodies, meshes: BodyMeshes, contacts: Contacts, possible: Contacts, tracking: Tracking | None
) -> Mortar | None:
    """Return the mortar of all possible contacts, of which `contacts` come first and touch; None without any."""
    joints = bodies.interfaces
    normal, shear, strength = joints.normal_stiffness, joints.shear_stiffness, joints.compressive_strength
    if np.isinf(normal).all() and np.isinf(shear).all() and np.isinf(strength).all():
        return None
    touching, sides = find_touching(bodies, meshes)
    of_contact = np.zeros((len(possible), 3))
    rows = contacts_of_interfaces(touching, sides, contacts.slave_node, contacts.interface)
    for number, values in enumerate(zip(normal, shear, strength, strict=True)):
        side = sides[touching.slave_edge[number]]
        nodes, areas = tributary(side, meshes.nodes)
        of_contact[rows[number]] += _areas(areas, side, nodes, meshes, touching, number) * values
    if tracking is not None:
        later = np.arange(len(contacts), len(possible))
        area = _areas_of_nodes(meshes, possible, tracking)[later]
        which = possible.interface[later]
        of_contact[later] = area[:, None] * np.column_stack([normal[which], shear[which], strength[which]])
    stiffness, in_shear, force = of_contact.T
    nothing = np.zeros(len(possible))
    return Mortar(
        compliance=read_only(1.0 / stiffness),
        shear_stiffness=read_only(in_shear),
        strength=read_only(force),
        closing=read_only(nothing),
        crushed=read_only(nothing, np.bool_),
    )


def _areas(
    tributaries: FloatArray, triangles: IntArray, nodes: IntArray, meshes: BodyMeshes, touching: Touching, number: int
) -> FloatArray:
    """Return the areas (s, 3) in m2 that nodes stand for in normal stiffness, shear stiffness and strength."""
    place = np.column_stack([meshes.nodes[:, :2] @ touching.tangent[number], meshes.nodes[:, 2]])
    strong = with_moments(tributaries, place[nodes], place[triangles], IN_STRENGTH)
    stiff = with_moments(strong, place[nodes], place[triangles], IN_STIFFNESS)
    return np.column_stack([stiff, stiff, strong])


def with_moments(
    areas: FloatArray, nodes: FloatArray, triangles: FloatArray, powers: tuple[tuple[int, int], ...]
) -> FloatArray:
    """Return areas (s,) in m2 of nodes (s, 2) whose moments are those of the triangles (t, 3, 2), in m.

    powers: of the moments, along and across. The areas given are multiplied by the polynomial with these powers that
    brings the moments; where none does with areas above 0, they are returned as they are.
    """
    low, size = triangles.min(axis=(0, 1)), np.ptp(triangles, axis=(0, 1))
    edges = triangles[:, 1:] - triangles[:, :1]
    whole = 0.5 * np.abs(edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0])
    corners = (triangles - low) / size - 0.5
    middles = 0.5 * (corners + np.roll(corners, 1, axis=1))  # three points that are exact for a quadratic
    moments = np.array([whole @ np.prod(middles**power, axis=2).mean(axis=1) for power in powers])
    terms = np.column_stack([np.prod(((nodes - low) / size - 0.5) ** power, axis=1) for power in powers])
    matrix = terms.T @ (areas[:, None] * terms)
    values = np.linalg.eigvalsh(matrix)
    if values[0] < DETERMINED * values[-1]:
        return areas
    corrected: FloatArray = areas * (terms @ np.linalg.solve(matrix, moments))
    return corrected if corrected.min() > 0.0 else areas


def _areas_of_nodes(meshes: BodyMeshes, possible: Contacts, tracking: Tracking) -> FloatArray:
    """Return the area (possible,) in m2 of its face that a slave node stands for; for a support's corner, the mean of
    the nodes of the face it meets."""
    slave = tracking.slave_of_pair[tracking.pair]
    master = tracking.master_of_pair[tracking.pair]
    own = np.where((tracking.corner == 0) | (tracking.corner == ANGLED), slave, master)
    shares = np.zeros(len(possible))
    for face, triangles in enumerate(sides_of_faces(tracking.faces, meshes)):
        if not len(triangles):
            continue
        nodes, areas = tributary(triangles, meshes.nodes)
        here = np.flatnonzero((own == face) & (possible.slave_node >= 0))
        shares[here] = areas[np.searchsorted(nodes, possible.slave_node[here])]
        shares[(tracking.master_face == face) & (possible.slave_node < 0)] = areas.mean()
    return shares


def largest_closing(mortar: Mortar | None, state: Increment) -> float:
    """Return the largest depth in m by which mortar has closed, elastically and for good."""
    if mortar is None:
        return 0.0
    return float(np.max(state.closing + mortar.compliance * np.maximum(state.normal_force, 0.0), initial=0.0))


def coarse_toes(bodies: Bodies, contacts: Contacts, state: Increment, moment: float) -> float:
    """Return the moment that toes carry too much as their elements are too long, over the `moment` of the live load
    about the wall's base in N m; 0 where no joint crushes.

    With a normal force N the toe of a joint that is open somewhere takes x = N / (f_c t), and its resultant is at x / 2
    from the edge or farther. Nodes that stand for too long a piece of the joint take it nearer (toes.py). This is what
    a peak is too high by where all these joints turn as fast as the wall.
    """
    beyond, joints = 0.0, bodies.interfaces
    for joint in np.flatnonzero(np.isfinite(joints.compressive_strength)):
        here = np.flatnonzero(contacts.interface == joint)
        force = np.maximum(state.normal_force[here], 0.0)
        if not force.any() or force.all():
            continue
        total, length = float(force.sum()), joints.length[joint]
        along = (contacts.point[here, :2] - joints.start[joint]) @ joints.tangent[joint]
        resultant = float(force @ along / total)
        toe = total / (joints.compressive_strength[joint] * bodies.thickness)
        beyond += total * max(0.5 * toe - min(resultant, length - resultant), 0.0)
    return float(beyond / moment) if beyond else 0.0
