"""What pictures and page show of bodies and joints: outlines, pieces of joints and their state (no matplotlib here)."""

from __future__ import annotations

import numpy as np

from orchestrator.basis.arrays import FloatArray, IntArray
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.pushover.increments import ContactStatus, Increment
from orchestrator.pushover.meshing import BodyMeshes

ON_JOINT = 1e-4
"""distance within which a contact lies on an interface, part of the wall's largest dimension"""
HAIRLINE = 1e-5
"""m; a joint that is open by less is drawn thin: it is a crack in the model, none that anybody finds on the wall"""
THIN = 3
"""status of such a joint in pictures, after those of ContactStatus"""
DAMAGED = 0.01
"""degree of damage from which a bonded joint is shown as damaged; loading alone leaves less"""


def shown_status(increment: Increment) -> IntArray:
    """Return the status (c,) of the contacts as pictures show it: ContactStatus, or THIN."""
    thin = (increment.status == ContactStatus.OPEN) & (increment.gap < HAIRLINE)
    return np.where(thin, THIN, increment.status)


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


def nodes_of_contacts(meshes: BodyMeshes, points: FloatArray, body: IntArray) -> IntArray:
    """Return the node (c,) of the given body (c,) nearest to each point (c, 2)."""
    from scipy.spatial import cKDTree  # 0.1 s that commands without pictures need not wait for

    apart = 10.0 * float(np.ptp(meshes.nodes, axis=0).max())  # a third coordinate that keeps bodies apart
    tree = cKDTree(np.column_stack([meshes.nodes[:, :2], apart * meshes.body_of_node]))
    return tree.query(np.column_stack([points, apart * body]))[1]


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
    bodies: Bodies, points: FloatArray, body_slave: IntArray, body_master: IntArray
) -> tuple[IntArray, IntArray, IntArray]:
    """Return the pieces (p,) that draw all interfaces: the contact of each, and its neighbours before and after.

    A piece reaches from midway to the neighbour before to midway to the one after; at the end of an interface the
    neighbour is the contact itself. points (c, 2): undeformed contacts in m.
    """
    pieces: list[tuple[int, int, int]] = []
    pairs = np.sort(np.column_stack([body_slave, body_master]), axis=1)
    tolerance = ON_JOINT * float(np.ptp(points, axis=0).max())
    for i, j, start, end in zip(bodies.body_i, bodies.body_j, bodies.start, bodies.end, strict=True):
        candidates = np.flatnonzero((pairs == sorted((i, j))).all(axis=1))
        chosen, along = _on_segment(points, candidates, start, end, tolerance)
        if chosen.size < 2:
            continue
        row = chosen[shares_of_interface(along)[0]].tolist()
        pieces.extend(zip(row, [row[0], *row[:-1]], [*row[1:], row[-1]], strict=True))
    contact, before, after = np.array(pieces, dtype=np.int64).reshape(-1, 3).T
    return contact, before, after


def _on_segment(
    points: FloatArray, candidates: IntArray, start: FloatArray, end: FloatArray, tolerance: float
) -> tuple[IntArray, FloatArray]:
    """Return those candidates (numbers of points) that lie on a segment, and where along it, 0 to 1."""
    chord = end - start
    offset = points[candidates] - start
    along = offset @ chord / (chord @ chord)
    away = np.abs(offset @ np.array([chord[1], -chord[0]])) / np.linalg.norm(chord)
    slack = tolerance / float(np.linalg.norm(chord))
    on = (away <= tolerance) & (along >= -slack) & (along <= 1.0 + slack)
    return candidates[on], np.clip(along[on], 0.0, 1.0)
