"""Contacts of the same bodies at one place, of which only the deepest is any (numpy only).

Two contacts a little apart, on faces turned against each other a little, hold bodies as a wedge of some hundredths of a
radian does, which with friction may have no state. Two that say the same have no unique forces.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray

COVER = 7.56e-3
"""contacts no farther apart than this, over the root of the smaller body's area, are at one place"""
TURNED = 0.1
"""rad; faces may be turned so far towards each other for one to slide onto the other (drawings are healed, arches have
facets), and count as nearly parallel"""

PARALLEL = 1e-3
"""rad; by so little faces may differ in slope to count as parallel, and which of them bears changes nothing"""


@dataclass(frozen=True, eq=False, slots=True)
class PlacedContacts:
    """c contacts in a displaced wall.

    point (c, 3) in m; size (c,) in m: root of the smaller body's area; slave_body, master_body, master_face (c,);
    normal (c, 2) in the undeformed wall; level (c,): number of the z; angled (c,): of corners at an angle (corners.py).
    """

    point: FloatArray
    size: FloatArray
    slave_body: IntArray
    master_body: IntArray
    master_face: IntArray
    normal: FloatArray
    level: IntArray
    angled: BoolArray


def at_one_place(contacts: PlacedContacts) -> tuple[IntArray, IntArray]:
    """Return pairs (p,), (p,) of contacts at one place.

    A corner of each body, a node against two faces of one body that meet at a kink, a node against one face in two
    pairs of faces. Different nodes of one body are different places, and so are faces that were not nearly parallel in
    the undeformed wall. So are corners of two bodies on a face of a third, unless one came to it at an angle and they
    touch each other there: where they stick to each other both say the same.
    """
    point, size, slave, face = contacts.point, contacts.size, contacts.slave_body, contacts.master_face
    one, other = cKDTree(point).query_pairs(COVER * size.max(initial=0.0), output_type="ndarray").T
    distance = np.linalg.norm(point[one] - point[other], axis=1)
    near = distance <= COVER * np.minimum(size[one], size[other])
    near &= contacts.level[one] == contacts.level[other]
    one, other, distance = one[near], other[near], distance[near]
    bodies = np.sort(np.column_stack([slave, contacts.master_body]), axis=1)
    same = (bodies[one] == bodies[other]).all(axis=1)
    same &= (slave[one] != slave[other]) | (distance == 0.0)
    same &= np.abs(np.einsum("pi,pi->p", contacts.normal[one], contacts.normal[other])) > np.cos(TURNED)
    for pair in np.flatnonzero((face[one] == face[other]) & (contacts.angled[one] != contacts.angled[other])):
        beside = np.append(other[one == one[pair]], one[other == one[pair]])
        both = np.sort([slave[one[pair]], slave[other[pair]]])
        same[pair] |= (bodies[beside] == both).all(axis=1).any()
    return one[same], other[same]


def at_a_tip(contacts: PlacedContacts, one: IntArray, other: IntArray) -> BoolArray:
    """Return which contacts (c,) are at one place with one whose face differs in slope; one, other (p,): pairs there.

    Where a wedge runs out between them, two bodies touch with corners whose faces are at its angle; so do a node and
    the two faces of a kink.
    """
    parallel = np.abs(np.einsum("pi,pi->p", contacts.normal[one], contacts.normal[other])) > np.cos(PARALLEL)
    found = np.zeros(len(contacts.point), bool)
    found[np.concatenate([one[~parallel], other[~parallel]])] = True
    return found


def deepest(rank: IntArray, gives_way: BoolArray, one: IntArray, other: IntArray) -> tuple[IntArray, IntArray]:
    """Return which contacts (s,) stay, of all at one place the first by rank (c,), and which of them take over (h, 2).

    gives_way (c,): they do in any case. one, other (p,): pairs at one place.
    """
    winner, loser = np.where(rank[one] < rank[other], [one, other], [other, one])
    stays, heirs = ~gives_way, [np.zeros((0, 2), np.int64)]
    while len(winner):
        leads = stays.copy()
        leads[loser] = False
        settled = leads[winner]
        heirs.append(np.column_stack([loser, winner])[settled])
        stays[loser[settled]] = False
        left = stays[winner] & ~settled
        winner, loser = winner[left], loser[left]
    pairs = np.concatenate(heirs)
    pairs = pairs[np.lexsort((rank[pairs[:, 1]], pairs[:, 0]))]
    return np.flatnonzero(stays), pairs[np.unique(pairs[:, 0], return_index=True)[1]]
