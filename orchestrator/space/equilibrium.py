"""Equilibrium of blocks in space: B q + f_D + lambda f_L = 0, with q = (N, T1, T2) of every contact point.

The force of block i on block j at point p is N n + T1 t1 + T2 t2 (N > 0: compression, n from i to j). Column of point k
and direction d: + [d; (p_k - c_j) x d] in the rows of block j, - [d; (p_k - c_i) x d] in those of i. Transposed, B^T u
are opening and both slips of j relative to i. Supports have no rows.

torsion = "uniform" lets the tangential forces of a joint act at c + beta (p_k - c), with c the joint's centroid and
beta = 2 r / d, so that a joint under uniform pressure twists at mu N r instead of mu N d / 2 (`torsion_factors`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy.sparse as sp
from scipy.optimize import linprog

from orchestrator.basis.arrays import FloatArray, IntArray, read_only
from orchestrator.geometry.rigid import cross
from orchestrator.masonry.interfaces import Interfaces
from orchestrator.space.contacts import SpaceAssemblage
from orchestrator.space.loads import SpaceLoads

Torsion = Literal["corners", "uniform"]


@dataclass(frozen=True, eq=False, slots=True)
class SpaceEquilibrium:
    """B (6m, 3p), f_D and f_L (6m,) in N and N m; friction (p,) and capacity (p,) in N of the points; free_blocks (m,)
    as positions in the wall. row_scale (6m,): rows times this are forces, moments over a block's length.
    weight_scale (N): mean weight."""

    matrix: sp.csc_matrix
    dead_load: FloatArray
    live_load: FloatArray
    friction: FloatArray
    capacity: FloatArray
    free_blocks: IntArray
    row_scale: FloatArray
    weight_scale: float
    length: float
    torsion: Torsion = "corners"

    @property
    def live_total(self) -> float:
        """Sum of the live load's forces, N."""
        return float(np.linalg.norm(self.live_load.reshape(-1, 6)[:, :3], axis=1).sum())

    def rates(self, velocities: FloatArray) -> FloatArray:
        """Opening and both slips (p, 3) in m/s of blocks that move with velocities (m, 6)."""
        return (self.matrix.T @ velocities.ravel()).reshape(-1, 3)


def equilibrium_of(assemblage: SpaceAssemblage, loads: SpaceLoads, torsion: Torsion = "corners") -> SpaceEquilibrium:
    """Return the equilibrium equations of an assemblage under loads."""
    wall, joints = assemblage.wall, assemblage.joints
    free = np.flatnonzero(~wall.fixed)
    row = np.full(len(wall.blocks), -1)
    row[free] = np.arange(len(free))
    centroids, j = wall.centroids, joints.joint
    directions = np.concatenate([joints.normal[j][:, None], joints.tangents[j]], axis=1)  # (p, 3 of n t1 t2, 3)
    place = joints.centroid[j][:, None] + arms(joints, torsion)
    parts = []
    for sign, blocks in ((-1.0, joints.i), (1.0, joints.j)):
        block = blocks[j]
        moment = np.cross(place - centroids[block][:, None], directions)
        parts.append((row[block], sign * np.concatenate([directions, moment], axis=2)))  # (p, 3, 6)
    weights = wall.weights[free]
    length = float(np.cbrt(np.mean(weights / [wall.blocks[k].unit_weight for k in free])))
    return SpaceEquilibrium(
        matrix=_matrix(parts, len(free)),
        dead_load=read_only(loads.dead[free].ravel()),
        live_load=read_only(loads.live[free].ravel()),
        friction=read_only(joints.friction[j]),
        capacity=read_only(joints.capacity[j]),
        free_blocks=read_only(free, np.int64),
        row_scale=read_only(np.tile(np.repeat([1.0, 1.0 / length], 3), len(free))),
        weight_scale=float(weights.mean()),
        length=length,
        torsion=torsion,
    )


def arms(joints: Interfaces, torsion: Torsion) -> FloatArray:
    """Return where N, T1, T2 of every point act (p, 3, 3), from the centroid of its joint, m."""
    of = joints.joint
    arms_of_point = np.repeat((joints.point - joints.centroid[of])[:, None], 3, axis=1)
    if torsion == "uniform":
        arms_of_point[:, 1:] *= torsion_factors(joints)[of, None, None]
    return arms_of_point


def _matrix(parts: list[tuple[IntArray, FloatArray]], free: int) -> sp.csc_matrix:
    """Assemble B from (block row (p,), columns (p, 3, 6)) of both sides."""
    points = len(parts[0][0])
    rows, columns, values = [], [], []
    for block, entry in parts:
        keep = np.flatnonzero(block >= 0)
        rows.append(np.broadcast_to((6 * block[keep])[:, None, None] + np.arange(6), (len(keep), 3, 6)).ravel())
        columns.append(np.broadcast_to((3 * keep)[:, None, None] + np.arange(3)[:, None], (len(keep), 3, 6)).ravel())
        values.append(entry[keep].ravel())
    triplets = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return sp.coo_matrix(triplets, shape=(6 * free, 3 * points)).tocsc()


def torsion_factors(joints: Interfaces) -> FloatArray:
    """Return beta (k,) of every joint: the twist resistance under uniform pressure over that of forces at its corners.

    Uniform: mean distance of the area's points, holes left out, from the centroid (0.38260 of a square's side).
    Corners: the largest sum w_k |p_k - c| with sum w_k (p_k - c) = 0, sum w_k = 1 (half the diagonal of a rectangle).
    """
    factors = np.ones(joints.count)
    levers: dict[tuple[tuple[float, float], ...], float] = {}
    for k in np.flatnonzero(~joints.is_tie):

        def flat(points: FloatArray, joint: int = int(k)) -> FloatArray:
            return (points - joints.centroid[joint]) @ joints.tangents[joint].T

        corners = flat(joints.corners(k))
        distance = np.linalg.norm(corners, axis=1)
        shape = _shape(corners, distance)
        if shape not in levers:
            levers[shape] = _corner_lever(corners, distance) / float(distance.max())
        moment = _moment(flat(joints.outlines[k])) - sum(_moment(flat(hole)) for hole in joints.holes[k])
        factors[k] = min(1.0, moment / joints.area[k] / (levers[shape] * float(distance.max())))
    return factors


def _shape(corners: FloatArray, distance: FloatArray) -> tuple[tuple[float, float], ...]:
    """Return what tells a convex polygon (v, 2) about the origin from others, but for its size and how it is turned:
    the distances of its corners and the lengths of its sides over the largest distance, in their order."""
    sides = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
    own = [(one, side) for one, side in np.round(np.column_stack([distance, sides]) / distance.max(), 6).tolist()]
    return min(tuple(own[first:] + own[:first]) for first in range(len(own)))


def _corner_lever(corners: FloatArray, distance: FloatArray) -> float:
    """Return the largest mean distance of forces at the corners (v, 2) whose resultant goes through the centroid."""
    rows = np.vstack([corners.T / distance.max(), np.ones(len(corners))])
    program = linprog(-distance / distance.max(), A_eq=rows, b_eq=[0.0, 0.0, 1.0])
    return float(-program.fun * distance.max()) if program.success else float(distance.mean())


def _moment(outline: FloatArray) -> float:
    """Return the integral of the distance from the origin over a polygon (n, 2), m3: signed triangles from the origin
    to its edges.

    Over a triangle whose base lies at the distance h, from angle a to b off its foot: h^3/3 [G(tan b) - G(tan a)] with
    G(t) = (t sqrt(1 + t^2) + asinh t) / 2.
    """
    start, end = outline, np.roll(outline, -1, axis=0)
    whole = np.linalg.norm(end - start, axis=1) > 0
    start, end = start[whole], end[whole]
    run = end - start
    length = np.linalg.norm(run, axis=1)
    height = cross(start, end) / length
    near = np.abs(height) < 1e-12 * length.max()
    safe = np.where(near, 1.0, np.abs(height))
    first, last = np.einsum("ni,ni->n", start, run) / length / safe, np.einsum("ni,ni->n", end, run) / length / safe

    def integral(t: FloatArray) -> FloatArray:
        return 0.5 * (t * np.sqrt(1.0 + t**2) + np.arcsinh(t))

    parts = np.where(near, 0.0, np.sign(height) * safe**3 / 3.0 * (integral(last) - integral(first)))
    return abs(float(parts.sum()))
