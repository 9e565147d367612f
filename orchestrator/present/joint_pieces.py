"""What pictures and page show of bodies and joints: outlines, pieces of joints and their state (no matplotlib here)."""

from __future__ import annotations

import numpy as np

from orchestrator.basis.arrays import FloatArray, IntArray
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.pushover.contact.contact_search import contacts_of_interfaces
from orchestrator.pushover.contact.faces import find_touching
from orchestrator.pushover.increments import ContactStatus, Increment
from orchestrator.pushover.meshing import BodyMeshes
from orchestrator.storage import ContactPlaces

HAIRLINE = 1e-5
"""m; a joint that is open by less is drawn thin: it is a crack in the model, none that anybody finds on the wall"""
THIN = 3
"""status of such a joint in pictures, after those of ContactStatus"""
NO_STATE = 4
"""status of a joint with a stone that has fallen: it is not drawn"""
DAMAGED = 0.01
"""degree of damage from which a bonded joint is shown as damaged; loading alone leaves less"""


def shown_status(increment: Increment) -> IntArray:
    """Return the status (c,) of the contacts as pictures show it: ContactStatus, or THIN."""
    thin = (increment.status == ContactStatus.OPEN) & (increment.gap < HAIRLINE)
    return np.where(thin, THIN, increment.status)


def status_of_pieces(bodies: Bodies, contacts: ContactPlaces, contact: IntArray, increment: Increment) -> IntArray:
    """Return the shown status (p,) of pieces of joints by the `contact` (p,) of each, NO_STATE where a side fell."""
    fallen = np.append(increment.fallen, np.zeros(len(bodies.bodies) - bodies.moving, bool))
    joint = contacts.interface[contact]
    gone = fallen[bodies.interfaces.i[joint]] | fallen[bodies.interfaces.j[joint]]
    return np.where(gone, NO_STATE, shown_status(increment)[contact])


def shown_displacement(meshes: BodyMeshes, increment: Increment) -> FloatArray:
    """Return the displacements (m, 2) of the nodes in m as they are shown: what has fallen is drawn where it stood."""
    here = ~increment.fallen[meshes.body_of_node]
    return np.where(here[:, None], increment.displacement[: len(meshes.nodes), :2], 0.0)


def front_loops(meshes: BodyMeshes, body: int) -> list[list[int]]:
    """Return the outlines of a body's face at z = 0, holes included, as node numbers."""
    triangles = meshes.side_triangles[meshes.body_of_side == body]
    edges = np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    front = meshes.nodes[:, 2] <= 1e-9 * float(np.ptp(meshes.nodes[:, 2]))
    return closed_loops(edges[front[edges].all(axis=1)])


def closed_loops(edges: IntArray) -> list[list[int]]:
    """Return the node numbers of the loops that directed edges (e, 2) form; every node has as many in as out."""
    following: dict[int, list[int]] = {}
    for start, end in edges.tolist():
        following.setdefault(start, []).append(end)
    loops = []
    while following:
        first = next(iter(following))
        loop, node = [first], _leave(following, first)
        while node != first:
            loop.append(node)
            node = _leave(following, node)
        loops.append(loop)
    return loops


def _leave(following: dict[int, list[int]], node: int) -> int:
    """Take one edge out of `node` and return where it leads."""
    ends = following[node]
    end = ends.pop()
    if not ends:
        del following[node]
    return end


def shares_of_interface(along: FloatArray) -> tuple[IntArray, FloatArray]:
    """Share an interface among its contacts at `along` (c,), 0 at its start, 1 at its end.

    Returns the contacts (d,) to use, one per position, in order, and the borders (d + 1,): contact a covers
    borders[a] to borders[a + 1], the border between two lies midway.
    """
    order = np.argsort(along, kind="stable")
    distinct = order[np.append(True, np.diff(along[order]) > 1e-6)]
    middle = 0.5 * (along[distinct][1:] + along[distinct][:-1])
    return distinct, np.concatenate([[0.0], middle, [1.0]])


def interface_pieces(
    bodies: Bodies, meshes: BodyMeshes, contacts: ContactPlaces
) -> tuple[IntArray, IntArray, IntArray]:
    """Return the pieces (p,) that draw all interfaces: the contact of each, and its neighbours before and after.

    A piece reaches from midway to the neighbour before to midway to the one after; at the end of an interface the
    neighbour is the contact itself.
    """
    pieces: list[tuple[int, int, int]] = []
    points = meshes.nodes[contacts.slave_node, :2]
    touching, sides = find_touching(bodies, meshes)
    rows = contacts_of_interfaces(touching, sides, contacts.slave_node, contacts.interface)
    starts, tangents, lengths = bodies.interfaces.start, bodies.interfaces.tangent, bodies.interfaces.length
    for here, start, tangent, length in zip(rows, starts, tangents, lengths, strict=True):
        along = (points[here] - start) @ tangent / length
        row = here[shares_of_interface(along)[0]].tolist()
        pieces.extend(zip(row, [row[0], *row[:-1]], [*row[1:], row[-1]], strict=True))
    contact, before, after = np.array(pieces, dtype=np.int64).reshape(-1, 3).T
    return contact, before, after
