"""Ties in the finite elements: bars between two bodies, or a body and an anchor (numpy only).

A tie of stiffness k (E A over its length, N/m) has an elongation D, the change of the distance of its ends, of which r
costs no force (its rest), and pulls with

    N = k (D - r)    within 0 <= N <= strength    (-strength <= N where it pushes, too)

Where it yields r goes with D; where it is slack it does not. The pretension is what a tie has been tightened to when
the weight acts: under gravity its force is that share of it which acts of the weight, and r follows. Elongations count
from then on. A tie without pretension has been there from the beginning.

Its ends are points of tetrahedra, on several levels through the thickness. With d the direction from start to end on
the geometry of the increment, D = offset + d . (u_end - u_start), a row of G: what a tie adds to the forces is G^T N,
and k_t G^T G to the matrix, k_t = k where N is elastic and 0 where it is slack or yields.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sparse

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray, read_only
from orchestrator.basis.errors import CaseError
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.masonry.ties import ANCHOR, Tie
from orchestrator.masonry.wall import Wall
from orchestrator.pushover.meshing import BodyMeshes
from orchestrator.pushover.solids.nodal_loads import held_by, through_thickness


@dataclass(frozen=True, eq=False, slots=True)
class TieBars:
    """m ties. body (m, 2): of both ends, ANCHOR for none. apart (m, 2) in m: from start to end, undeformed.

    weights (m, nodes): of nodal displacements in that of the end less that of the start. stiffness (m,) in N/m;
    strength, lowest, pretension (m,) in N. rows (m, 3 nodes), offset (m,) in m: elongation = rows u + offset on this
    geometry; along (m, 2): direction from start to end on it.
    """

    body: IntArray
    apart: FloatArray
    weights: sparse.csr_matrix
    stiffness: FloatArray
    strength: FloatArray
    lowest: FloatArray
    pretension: FloatArray
    rows: sparse.csr_matrix
    offset: FloatArray
    along: FloatArray

    def __len__(self) -> int:
        return len(self.stiffness)

    def on_rows(self, row: IntArray, rows: int) -> TieBars:
        """Return the ties on `rows` rows of unknowns; row (m,): that of each node."""
        tie, node, weight = sparse.find(self.weights)
        weights = sparse.csr_matrix((weight, (tie, row[node])), (len(self), rows))
        return replace(self, weights=weights, rows=rows_along(weights, self.along))

    def displaced(self, displacement: FloatArray) -> TieBars:
        """Return the ties on the geometry of a displacement (3 nodes,) in m."""
        now = self.apart + self.weights @ displacement.reshape(-1, 3)[:, :2]
        length = np.linalg.norm(now, axis=1)
        along = now / length[:, None]
        rows = rows_along(self.weights, along)
        before = np.linalg.norm(self.apart, axis=1)
        return replace(self, rows=rows, offset=length - before - rows @ displacement, along=along)

    def without(self, fallen: BoolArray) -> TieBars:
        """Return the ties without force where a body (b,) has fallen."""
        gone = np.append(fallen, False)[np.where(self.body < len(fallen), self.body, ANCHOR)].any(axis=1)
        forces = ("stiffness", "strength", "lowest", "pretension")
        return replace(self, **{name: read_only(np.where(gone, 0.0, getattr(self, name))) for name in forces})

    def towards_anchors(self, force: FloatArray, forward: FloatArray) -> float:
        """Return the force along `forward` (2,) with which anchors pull at the wall when ties carry `force` (m,), N."""
        along = self.rows @ np.tile([*forward, 0.0], self.rows.shape[1] // 3)  # 0 between two bodies
        return -float(along @ force)


@dataclass(frozen=True, eq=False, slots=True)
class TieHistory:
    """rest (m,) in m of ties at the start of an increment; tightened (m,): their force in it in N, NaN where it follows
    from their elongation."""

    rest: FloatArray
    tightened: FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class TieResponse:
    """force (m,) in N, slope (m,) in N/m, rest (m,) in m at the end."""

    force: FloatArray
    slope: FloatArray
    rest: FloatArray


def tightened(ties: TieBars, rest: FloatArray, gravity_share: float | None) -> TieHistory:
    """Return the history with which an increment begins; gravity_share: of the weight at its end, None after it."""
    stretch = np.full(len(ties), np.nan)
    if gravity_share is not None:
        stretch = np.where(ties.pretension > 0.0, gravity_share * ties.pretension, stretch)
    return TieHistory(rest, stretch)


def tie_response(ties: TieBars, history: TieHistory, displacement: FloatArray) -> TieResponse:
    """Return what ties do at a displacement (3 nodes,) in m."""
    elongation = ties.rows @ displacement + ties.offset
    trial = ties.stiffness * (elongation - history.rest)
    tight = ~np.isnan(history.tightened)
    force = np.where(tight, history.tightened, np.minimum(np.maximum(trial, ties.lowest), ties.strength))
    elastic = ~tight & (trial >= ties.lowest) & (trial <= ties.strength)
    yields = (trial > ties.strength) | ((trial < ties.lowest) & (ties.lowest < 0.0))
    stretched = np.divide(force, ties.stiffness, out=np.zeros(len(force)), where=ties.stiffness > 0.0)
    rest = np.where(tight | yields, elongation - stretched, history.rest)
    return TieResponse(force, np.where(elastic, ties.stiffness, 0.0), rest)


def rows_along(weights: sparse.csr_matrix, direction: FloatArray) -> sparse.csr_matrix:
    """Return (m, 3 nodes): weights (m, nodes) times the component along direction (m, 2)."""
    tie, node = np.repeat(np.arange(weights.shape[0]), np.diff(weights.indptr)), weights.indices.astype(np.int64)
    value = weights.data[:, None] * direction[tie]
    column = 3 * node[:, None] + np.arange(2)
    shape = (weights.shape[0], 3 * weights.shape[1])
    return sparse.csr_matrix((value.ravel(), (np.repeat(tie, 2), column.ravel())), shape=shape)


def find_ties(wall: Wall, bodies: Bodies, meshes: BodyMeshes, ties: Sequence[Tie]) -> TieBars | None:
    """Return the ties on the nodes of the bodies, None where there are none. Raises CaseError (key only)."""
    if not ties:
        return None
    refuse_rigid(ties)
    body, ends = ends_of_ties(wall, bodies, meshes, ties)
    apart = np.array([tie.end for tie in ties], dtype=float) - np.array([tie.start for tie in ties], dtype=float)
    along = apart / np.linalg.norm(apart, axis=1)[:, None]
    spread, strength = (ends[1::2] - ends[::2]).tocsr(), np.array([tie.strength for tie in ties], dtype=float)
    return TieBars(
        body=read_only(body, np.int64),
        apart=read_only(apart),
        weights=spread,
        stiffness=read_only([tie.stiffness or 0.0 for tie in ties]),
        strength=read_only(strength),
        lowest=read_only(np.where([tie.pushes for tie in ties], -strength, 0.0)),
        pretension=read_only([tie.pretension for tie in ties]),
        rows=rows_along(spread, along),
        offset=read_only(np.zeros(len(ties))),
        along=read_only(along),
    )


def ends_of_ties(
    wall: Wall, bodies: Bodies, meshes: BodyMeshes, ties: Sequence[Tie]
) -> tuple[IntArray, sparse.csr_matrix]:
    """Return the body (m, 2) of both ends, ANCHOR for none, and the weights (2 m, nodes) of nodal displacements in
    those of the ends: start and end of the first tie, then of the next."""
    body_of_block = {int(block): body.number for body in bodies.bodies for block in body.blocks}
    place = wall.place_of
    body = np.full((len(ties), 2), ANCHOR)
    weights = sparse.lil_matrix((2 * len(ties), len(meshes.nodes)))
    for number, tie in enumerate(ties):
        for side, (block, point) in enumerate(zip(tie.blocks, (tie.start, tie.end), strict=False)):
            owner = body_of_block[place[block]]
            if owner >= bodies.moving:
                continue
            body[number, side] = owner
            points, share = through_thickness(np.array([point]), np.ones(1), bodies.thickness)
            node, weight = held_by(points, meshes, owner)
            for n, w in zip(node.ravel().tolist(), (share[:, None] * weight).ravel().tolist(), strict=True):
                weights[2 * number + side, n] += w
    return body, weights.tocsr()


def refuse_rigid(ties: Sequence[Tie]) -> None:
    """Raise CaseError (key only) for ties without stiffness."""
    for number, tie in enumerate(ties):
        if tie.stiffness is None:
            key, problem = f"reinforcement.ties.{number}.stiffness", "is missing: the finite elements know no rigid tie"
            raise CaseError(key, problem, 'give E A over the length, as in "8 kN/mm"')
