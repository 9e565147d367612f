"""Joints of blocks that have moved: how they stand, and what has opened and slipped there, exactly.

At each end of a joint a corner of one block lies on an edge of the other. Opening and slip there are what that corner
has moved by in the frame of the edge, which turns with its block: they depend on where the blocks are and on nothing
that happened before. Their slopes with displacements are -B^T, with the forces of a point at the corner and along the
edge. Where corners of both blocks met, the one that has moved inwards along the other's edge counts: the other has left
it. Points between the ends of a joint are treated as corners of its block i, and are open once they have slid beyond
an end, off block j. Where blocks have slid off each other all points are open. A corner that met no corner is followed
as if the edge under it had no end, and contacts other than those that were drawn are not looked for. Source: rigid
bodies; corner on edge as in finite elements in contact (node to segment).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray
from orchestrator.geometry.rigid import cross
from orchestrator.limit_analysis.paper.equilibrium import Equilibrium
from orchestrator.masonry.block_properties import block_centroids, outlines_of
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.wall import Wall

CORNER = 1e-6
"""Part of a block length within which a point is a corner of a block."""


@dataclass(frozen=True, eq=False, slots=True)
class MovedJoints:
    """The c points of the joints between n blocks, and how far displacements (3m,) of the free ones are in m.

    i, j (c,): blocks on both sides; centre (n, 2), m; first_row (n,): of a block's displacements, -1 for supports.
    point (c, 2), m, and frame (c, 2, 2), along what normal force and shear act on i, as drawn. corner_of_i (c,):
    whether the point is a corner of i; corner_of_both (c,); inwards (c,): sign of the way along the joint into it.
    of_joint: points of each joint, from its start to its end. unit: metres of displacement 1; length: block length in m
    that rotations are multiplied by.
    """

    i: IntArray
    j: IntArray
    centre: FloatArray
    first_row: IntArray
    point: FloatArray
    frame: FloatArray
    corner_of_i: BoolArray
    corner_of_both: BoolArray
    inwards: FloatArray
    of_joint: int
    unit: float
    length: float

    def largest(self, displacements: FloatArray) -> float:
        """Return how far the fastest block moves or, times a block length, turns, in block lengths."""
        return float(np.abs(displacements).max()) * self.unit / self.length

    def at(self, displacements: FloatArray) -> tuple[sp.csc_matrix, FloatArray]:
        """Return B (3m, 2c) of blocks that have moved by displacements (3m,), and opening and slip (c, 2) there."""
        centre, place, frame, rates = self._placed(displacements)
        return self._matrix(centre, place, frame), rates

    def rates(self, displacements: FloatArray) -> FloatArray:
        """Return opening and slip (c, 2) of blocks that have moved by displacements (3m,)."""
        return self._placed(displacements)[-1]

    def _placed(self, displacements: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return where centres (n, 2) and corners (c, 2) are, frames (c, 2, 2), and opening and slip (c, 2)."""
        motion = np.zeros((len(self.centre), 3))
        motion[self.first_row >= 0] = self.unit * displacements.reshape(-1, 3)
        turn = motion[:, 2] / self.length
        turned = np.stack([np.cos(turn), -np.sin(turn), np.sin(turn), np.cos(turn)], axis=1).reshape(-1, 2, 2)
        centre = self.centre + motion[:, :2]
        on_i, on_j = (
            centre[body] + np.einsum("kde,ke->kd", turned[body], self.point - self.centre[body])
            for body in (self.i, self.j)
        )
        along_j = np.einsum("kde,ke->kd", turned[self.j], self.frame[:, 1])
        inside = self.inwards * ((on_i - on_j) * along_j).sum(axis=1) >= 0.0
        of_i = np.where(self.corner_of_both, inside, self.corner_of_i)
        frame = np.einsum("kde,kue->kud", turned[np.where(of_i, self.j, self.i)], self.frame)
        rates = np.einsum("kud,kd->ku", frame, on_j - on_i) / self.unit
        place = np.where(of_i[:, None], on_i, on_j)
        along = np.einsum("kd,kd->k", place, along_j).reshape(-1, self.of_joint)
        along *= self.inwards[:: self.of_joint, None]  # from start to end
        is_off = (along < along[:, :1]) | (along > along[:, -1:])
        rates[is_off.ravel(), 0] = self.length / self.unit
        return centre, place, frame, rates

    def _matrix(self, centre: FloatArray, place: FloatArray, frame: FloatArray) -> sp.csc_matrix:
        """Return B (3m, 2c) of forces along frames (c, 2, 2) at places (c, 2): zeros are kept, its pattern is one."""
        body = np.stack([self.i, self.j], axis=1)
        moment = cross((place[:, None] - centre[body])[:, None], frame[:, :, None]) / self.length
        forces = np.broadcast_to(frame[:, :, None], (*moment.shape, 2))
        entries = np.concatenate([forces, moment[..., None]], axis=-1) * np.array([1.0, -1.0])[:, None]
        rows = np.broadcast_to(self.first_row[body][:, None, :, None] + np.arange(3), entries.shape)
        moves = np.broadcast_to((self.first_row[body] >= 0)[:, None, :, None], entries.shape)
        starts = np.concatenate([[0], np.cumsum(moves.sum(axis=(2, 3)).ravel())])
        shape = 3 * np.count_nonzero(self.first_row >= 0), 2 * len(self.i)
        return sp.csc_matrix((entries[moves], rows[moves], starts), shape=shape)


def moved_joints(assemblage: Assemblage, equilibrium: Equilibrium, places: FloatArray, unit: float) -> MovedJoints:
    """Return the points of the joints of a wall: places (p,) between start and end of each; unit: metres of
    displacement 1."""
    wall, joints, length = assemblage.wall, assemblage.joints, equilibrium.block_length
    way = joints.end - joints.start
    point = (joints.start[:, None] + places[:, None] * way[:, None]).reshape(-1, 2)
    (_, normal), _, (_, shear) = joints.acting
    middle = np.tile((places > 0.0) & (places < 1.0), joints.count)
    i, j = np.repeat(joints.i, len(places)), np.repeat(joints.j, len(places))
    of_i, of_j = (_is_corner(wall, block, point, CORNER * length) for block in (i, j))
    first_row = np.full(equilibrium.blocks, -1)
    first_row[equilibrium.free_blocks] = 3 * np.arange(len(equilibrium.free_blocks))
    return MovedJoints(
        i=i,
        j=j,
        centre=block_centroids(wall),
        first_row=first_row,
        point=point,
        frame=np.repeat(np.stack([normal, shear], axis=1), len(places), axis=0),
        corner_of_i=of_i | middle | ~of_j,
        corner_of_both=of_i & of_j & ~middle,
        inwards=np.kron(np.sign((way * shear).sum(axis=1)), np.sign(0.5 - places)),
        of_joint=len(places),
        unit=unit,
        length=length,
    )


def _is_corner(wall: Wall, block: IntArray, point: FloatArray, near: float) -> BoolArray:
    """Return which points (c, 2) are corners of blocks (c,), within a distance in m; a vertex that its neighbours have
    on a straight line between them is none."""
    outlines = outlines_of(wall)
    vertex, after = outlines.corner, outlines.following
    following = vertex[after]
    before = np.empty_like(vertex)
    before[after] = vertex
    chord = following - before
    turns = np.abs(cross(vertex - before, chord)) > near * np.linalg.norm(chord, axis=1)
    last = np.append(outlines.first[1:], len(vertex))
    found = np.zeros(len(block), dtype=bool)
    for number in range(int((last - outlines.first).max())):
        corner = np.minimum(outlines.first[block] + number, last[block] - 1)
        found |= turns[corner] & (np.linalg.norm(vertex[corner] - point, axis=1) < near)
    return found
