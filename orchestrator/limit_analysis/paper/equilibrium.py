"""Equilibrium of rigid blocks in the plane, the equality rows of Eq. (1).

    B q - lambda f_L = f_D          3 rows a free block: x, y (N), moment about its centroid (N m); supports have none
    q = (n_start, n_end, s) a joint: normal forces at both ends of the joint (compression positive), shear, in N
    f_D, f_L = dead and live load at the centroids (loads/); by default weight, and weight turned into the horizontal

B q are the forces that blocks exert on their joints, which is why loads stand on the right: block i of a joint pushes
with n along the joint's normal (it points from i to j) and with s along its tangent; block j the other way round.
The transpose gives the rates that accompany block velocities u: -B^T u = (opening at start, at end, slip) of a joint,
with power f . u = q . B^T u (virtual work). Source: Szabó, Funari, Lourenço 2023, Eq. (1); docs/theory.md.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from orchestrator.basis.arrays import FloatArray, IntArray, read_only
from orchestrator.geometry.rigid import cross
from orchestrator.loads.block_loads import Loads, loads_on
from orchestrator.masonry.block_properties import block_areas, block_centroids, block_weights
from orchestrator.masonry.joints import Assemblage

SMALL = 1e-2
"""Part of the mean block weight: what is less is measured by itself, as rounding and smoothness are parts of units."""


@dataclass(frozen=True, eq=False, slots=True)
class Equilibrium:
    """The terms of Eq. (1) for m free blocks and k joints, in N and N m.

    matrix (3m, 3k); dead_load, live_load (3m,); free_blocks (m,): their numbers in the wall, in ascending order.
    block_length (m) and unit_force (N), the mean weight of the free blocks, are what lengths and forces are measured
    by; total_weight: of the free blocks, N. moments_turned (m, 2): those of dead and live load on blocks turned by a
    right angle, as of `Loads`; None of what is not followed where blocks have turned.
    """

    matrix: sp.csc_matrix
    dead_load: FloatArray
    live_load: FloatArray
    free_blocks: IntArray
    blocks: int
    block_length: float
    unit_force: float
    total_weight: float
    moments_turned: FloatArray | None = None

    def measured_by_load(self, multiplier: float) -> Equilibrium:
        """Return the same with forces measured by the live load at a multiplier where that is SMALL: joints are smooth
        by a part of the unit, which would be more than one small stone is pushed with."""
        load = multiplier * self.live_total
        return replace(self, unit_force=load) if load < SMALL * self.unit_force else self

    @property
    def dead_total(self) -> float:
        """All dead load on the free blocks, N."""
        return -float(self.dead_load.reshape(-1, 3)[:, 1].sum())

    @property
    def live_total(self) -> float:
        """Sum of the magnitudes of the live forces at a load multiplier of 1, N."""
        return float(np.hypot(*self.live_load.reshape(-1, 3)[:, :2].T).sum())

    @property
    def base_shear(self) -> float:
        """Horizontal resultant of the live load at a load multiplier of 1, N: positive along x."""
        return float(self.live_load.reshape(-1, 3)[:, 0].sum())

    @property
    def live_load_is_turned_dead_load(self) -> bool:
        """Whether every block's live load is its dead load turned by a right angle, as on a tilting table: its forces,
        and their moments about the centroid, which the dead load has on a block that is turned."""
        dead, live = (load.reshape(-1, 3) for load in (self.dead_load, self.live_load))
        sense, none = np.sign(self.base_shear), np.zeros(len(dead))
        moments = none if self.moments_turned is None else self.moments_turned[:, 0]
        turned = np.column_stack([-sense * dead[:, 1], none, -sense * moments])
        unit = self.unit_force * np.array([1.0, 1.0, self.block_length])
        return bool(np.allclose(live / unit, turned / unit, rtol=1e-12, atol=1e-12))

    @property
    def row_scale(self) -> FloatArray:
        """Factors (3m,) that turn rows in N and N m into rows in N: moments are divided by a block length."""
        return np.tile([1.0, 1.0, 1.0 / self.block_length], len(self.free_blocks))

    def joint_rates(self, velocities: FloatArray) -> FloatArray:
        """Rates (k, 3) in m/s that go with free-block velocities (3m,): opening at start and end, slip of j on i."""
        return -(self.matrix.T @ velocities).reshape(-1, 3)

    def of_all_blocks(self, velocities: FloatArray) -> FloatArray:
        """Velocities (n, 3) of all blocks from those of the free ones (3m,): supports rest."""
        everyone = np.zeros((self.blocks, 3))
        everyone[self.free_blocks] = velocities.reshape(-1, 3)
        return everyone

    def residual(self, joint_forces: FloatArray, load_multiplier: float) -> float:
        """Largest unbalanced force (moments over a block length) of forces (k, 3) in N, over the total weight."""
        q = joint_forces.ravel()
        unbalanced = self.matrix @ q - load_multiplier * self.live_load - self.dead_load
        return float(np.max(np.abs(self.row_scale * unbalanced)) / self.total_weight)


def assemble_equilibrium(assemblage: Assemblage, loads: Loads | None = None) -> Equilibrium:
    """Assemble Eq. (1); without `loads`: the weight of every block, and the same forces along +x."""
    wall = assemblage.wall
    loads = loads or loads_on(wall)
    free = np.flatnonzero([not block.fixed for block in wall.blocks])
    return Equilibrium(
        matrix=equilibrium_matrix(assemblage, free),
        dead_load=read_only(loads.dead[free].ravel()),
        live_load=read_only(loads.live[free].ravel()),
        free_blocks=read_only(free, np.int64),
        blocks=len(wall.blocks),
        block_length=float(np.sqrt(np.mean(block_areas(wall)[free]))),
        unit_force=float(np.mean(block_weights(wall)[free])),
        total_weight=float(np.sum(block_weights(wall)[free])),
        moments_turned=read_only(loads.moments_turned[free]),
    )


def equilibrium_matrix(assemblage: Assemblage, free: IntArray) -> sp.csc_matrix:
    """B (3m, 3k): what a unit of each joint unknown contributes to the rows of the two blocks beside it."""
    joints = assemblage.joints
    number = np.arange(joints.count)
    centroids = block_centroids(assemblage.wall)
    first_row = np.full(len(assemblage.wall.blocks), -1)
    first_row[free] = 3 * np.arange(len(free))
    rows, columns, entries = [], [], []
    for block, sign in ((joints.i, 1.0), (joints.j, -1.0)):
        moves = first_row[block] >= 0
        for unknown, (point, direction) in enumerate(joints.acting):
            moment = cross(point - centroids[block], direction)
            for row, value in enumerate((direction[:, 0], direction[:, 1], moment)):
                rows.append(first_row[block][moves] + row)
                columns.append(3 * number[moves] + unknown)
                entries.append(sign * value[moves])
    place = (np.concatenate(rows), np.concatenate(columns))
    B = sp.csc_matrix((np.concatenate(entries), place), shape=(3 * len(free), 3 * joints.count))
    B.eliminate_zeros()
    return B
