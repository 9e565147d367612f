"""How far stones give way at their joints: a force spreads from a short joint into a stone that is wider.

A prism of length d and the joint's length L gives way by N d / (E t L), SPREAD times less where the last pressed end of
the joint carries all. From a joint that is short against the part W of the stone that belongs to it the force spreads
at 45 degrees until the strip is as wide, and goes on in that width: less again than

    d_e / SPREAD = L [ln(1 + 2 z / L) / 2 + (d - z) / W],    z = min(d, (W - L) / 2)

in the place of d / SPREAD. W is L times the width of the stone over its bedded width on that side; d is the distance of
the stone's centroid along the normal of the joint, or half of the stone's mean height there (area over width), if that
is more: the ledge of a keyed stone may be level with its centroid. Own estimate; 45 degrees are those of masonry under
concentrated loads. Two pinnings of 1/200 of the length of the stone on them bear 0.682 so, 0.561 as prisms, 0.699 in
finite elements of every stone, 0.7 if nothing gives way.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from orchestrator.basis.arrays import FloatArray, IntArray
from orchestrator.masonry.block_properties import block_areas, outlines_of
from orchestrator.masonry.interfaces import Interfaces
from orchestrator.masonry.wall import Wall

SPREAD = 2.5
"""Stiffness of stones over that of such prisms where the last pressed end of a joint carries all: in a stone its force
spreads. Measured by what deformation takes from the peak of micro-FE and of rigid blocks: 2.0 (wall 6 of Ferris and
Tin-Loi, 3.5 GPa), 2.9 and 3.1 (24 irregular stones, 0.35 and 0.035 GPa)."""


def stone_lengths(wall: Wall, joints: Interfaces, body: IntArray, centroids: FloatArray) -> FloatArray:
    """Return d_e (2, k) in m of the bodies on both sides of k joints between bodies.

    body (n,): which blocks are one body; centroids (n, 2): of each block's body.
    """
    sides = np.concatenate([body[joints.i], body[joints.j]])
    normal, length = np.vstack([joints.normal, -joints.normal]), np.tile(joints.length, 2)
    centre = np.vstack([centroids[joints.i], centroids[joints.j]])
    distance = np.abs(((centre - np.tile(joints.centroid, (2, 1))) * normal).sum(axis=1))
    width = _widths(wall, body, sides, normal)
    distance = np.maximum(distance, 0.5 * np.bincount(body, block_areas(wall))[sides] / width)
    part = length * np.maximum(width / _bedded(sides, normal, length), 1.0)
    spread = np.minimum(distance, 0.5 * (part - length))
    found = SPREAD * length * (0.5 * np.log1p(2.0 * spread / length) + (distance - spread) / part)
    return np.minimum(distance, found).reshape(2, -1)


def _widths(wall: Wall, body: IntArray, sides: IntArray, normal: FloatArray) -> FloatArray:
    """Return the widths (s,) of bodies `sides` (s,) along joints of normals (s, 2)."""
    outlines = outlines_of(wall)
    of_corner = body[outlines.block]
    order = np.argsort(of_corner, kind="stable")
    first = np.searchsorted(of_corner[order], np.arange(body.max() + 2))
    count = np.diff(first)[sides]
    begin = np.concatenate([[0], np.cumsum(count)[:-1]])
    corner = order[np.repeat(first[sides] - begin, count) + np.arange(count.sum())]
    tangent = np.repeat(np.column_stack([-normal[:, 1], normal[:, 0]]), count, axis=0)
    along = (outlines.corner[corner] * tangent).sum(axis=1)
    return np.asarray(np.maximum.reduceat(along, begin) - np.minimum.reduceat(along, begin))


def _bedded(sides: IntArray, normal: FloatArray, length: FloatArray) -> FloatArray:
    """Return the length (s,) over which a body's joints on the same side as each of its own are bedded, projected."""
    count = len(sides)
    of_body = sp.csr_matrix((np.ones(count), (np.arange(count), sides)))
    pairs = (of_body @ of_body.T).tocoo()
    facing = np.maximum((normal[pairs.row] * normal[pairs.col]).sum(axis=1), 0.0)
    return np.asarray(np.bincount(pairs.row, facing * length[pairs.col], count), dtype=float)
