"""Rigid blocks on elastic joints without tension and with Coulomb friction: forces of a position, and their slopes.

    normal   n = max(0, T/2 - k_n gap) - T/2     at both ends of a joint, gap = opening since the joints were drawn
    shear    s = s_0 - k_t (slip - slip_0), cut to |s| <= mu N + c     from the last position (slip_0, s_0); no dilation

Gaps are remembered, slips are forgotten once they are made: that is what tells this law from one that is plastic in
both. max(0, t) is smoothed to (t + sqrt(t^2 + 4 m^2))/2, m = JOINT_SMOOTHING block weights: Newton's method needs
slopes, and where an end has opened its force m^2/(k gap) is soon nothing. k_n = E t L/(2 d) at each end, d the distance
between the centroids across the joint (a support is rigid and counts for nothing). Only ratios of stiffnesses matter to
the multiplier, E is therefore such that the mean of k_n is 1. A state that is a property of the wall is the same with
both STIFFNESSES. Sources: Lourenço and Rots 1997 (stiffness of a joint that stands for the stones beside it); Chen and
Harker 1993 (smoothing).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.basis.arrays import FloatArray, IntArray
from orchestrator.limit_analysis.paper.equilibrium import Equilibrium
from orchestrator.limit_analysis.paper.yield_conditions import YieldConditions
from orchestrator.limit_analysis.search.scaled_problem import ScaledProblem, scaled_problem
from orchestrator.masonry.block_properties import block_centroids, block_weights
from orchestrator.masonry.joints import Assemblage

JOINT_SMOOTHING = 1e-4
"""m in mean block weights."""
Stiffness = tuple[bool, float]
"""Whether k_n falls with the distance d between centroids (else it only grows with the length), and k_t over k_n."""
STIFFNESSES: tuple[Stiffness, Stiffness] = ((True, 0.4), (False, 1.0))
"""Stones as soft as their joints (0.4: an elastic solid with a Poisson ratio of 0.25), and joints between hard ones."""
LEAST_DISTANCE = 0.1
"""Least d, in block lengths: a joint may pass through the centroid of an odd stone."""
LEAST_STIFFNESS = 1e-8
"""Part of its stiffness that an open joint has in the matrix: a block that hangs free for a moment is held."""


@dataclass(frozen=True, eq=False, slots=True)
class ElasticWall:
    """A wall in the units of `ScaledProblem` and the stiffness (k, 3) of its joints: both ends, and along the joint.

    tension (k, 1): tensile strength of each end, mean block weights.
    """

    problem: ScaledProblem
    stiffness: FloatArray
    tension: FloatArray

    def rates(self, displacements: FloatArray) -> FloatArray:
        """Openings at both ends and slip (k, 3) of blocks that have moved by displacements (3m,)."""
        return -(self.problem.B_T @ displacements).reshape(-1, 3)

    def strength(self, normal: FloatArray) -> FloatArray:
        """Largest shear (k,) of joints that carry normal forces (k, 2)."""
        return self.problem.friction * normal.sum(axis=1) + self.problem.cohesion

    def flow_error(self, forces: FloatArray, rates: FloatArray, live_power: float) -> float:
        """What joints do that open while loaded or slide before they must, over lambda times the live load's power.

        forces and rates (k, 3): 0 for a limit state, and then the relative error that its multiplier may have.
        """
        spare = np.maximum(self.strength(forces[:, :2]) - np.abs(forces[:, 2]), 0.0)
        done = np.sum((forces[:, :2] + self.tension) * np.abs(rates[:, :2])) + np.sum(spare * np.abs(rates[:, 2]))
        return float(done / max(abs(live_power), 1e-300))


@dataclass(frozen=True, eq=False, slots=True)
class Position:
    """Where the blocks are and what they carry: displacements (3m,), joint forces and rates since drawing (k, 3)."""

    displacements: FloatArray
    forces: FloatArray
    rates: FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class Trial:
    """Forces (k, 3) of a position that is tried, its rates (k, 3) and the joints' tangent stiffness (k, 5)."""

    displacements: FloatArray
    forces: FloatArray
    rates: FloatArray
    tangent: FloatArray

    @property
    def position(self) -> Position:
        """The position without its tangent."""
        return Position(self.displacements, self.forces, self.rates)


def elastic_wall(
    assemblage: Assemblage,
    equilibrium: Equilibrium,
    coulomb: YieldConditions,
    stiffness: Stiffness = STIFFNESSES[0],
    body_of_block: IntArray | None = None,
) -> ElasticWall:
    """Return the wall with the stiffness of every joint, or of those between bodies of several blocks.

    body_of_block (n,): which blocks are one body, as equilibrium and Coulomb's law (k joints) have them.
    """
    wall, joints, centroids = assemblage.wall, assemblage.joints, block_centroids(assemblage.wall)
    between = np.ones(joints.count, dtype=bool)
    if body_of_block is not None:
        between = body_of_block[joints.i] != body_of_block[joints.j]
        weights = block_weights(wall)
        moment = np.column_stack([np.bincount(body_of_block, weights * x) for x in centroids.T])
        centroids = (moment / np.bincount(body_of_block, weights)[:, None])[body_of_block]
    free = np.array([not block.fixed for block in wall.blocks])
    distance = sum(
        free[block] * np.linalg.norm(centroids[block] - joints.centroid[between], axis=1)
        for block in (joints.i[between], joints.j[between])
    )
    by_distance, tangential = stiffness
    normal = joints.area[between]
    if by_distance:
        normal = normal / np.maximum(distance, LEAST_DISTANCE * equilibrium.block_length)
    normal = normal / normal.mean()
    return ElasticWall(
        problem=scaled_problem(equilibrium, coulomb),
        stiffness=np.column_stack([normal, normal, tangential * normal]),
        tension=0.5 * coulomb.tension[:, None] / equilibrium.mean_weight,
    )


def undeformed(wall: ElasticWall) -> Position:
    """Return the position in which the wall was drawn, without forces."""
    nothing = np.zeros_like(wall.stiffness)
    return Position(np.zeros(wall.problem.B.shape[0]), nothing, nothing)


def tried(wall: ElasticWall, before: Position, displacements: FloatArray) -> Trial:
    """Return forces and tangent after displacements (3m,) that were reached from the position `before`."""
    rates = wall.rates(displacements)
    k = wall.stiffness
    normal, d_normal = positive(wall.tension - k[:, :2] * rates[:, :2])
    normal = normal - wall.tension
    limit = wall.strength(normal)
    trial = before.forces[:, 2] - k[:, 2] * (rates[:, 2] - before.rates[:, 2])
    above, d_above = positive(trial + limit)
    below, d_below = positive(trial - limit)
    start, end, stick = np.maximum(np.column_stack([d_normal, d_above - d_below]), LEAST_STIFFNESS).T
    slide = wall.problem.friction * (d_above + d_below - 1.0)
    tangent = k[:, [0, 1, 0, 1, 2]] * np.column_stack([start, end, slide * start, slide * end, stick])
    return Trial(displacements, np.column_stack([normal, above - below - limit]), rates, tangent)


def positive(trial: FloatArray, smoothing: float = JOINT_SMOOTHING) -> tuple[FloatArray, FloatArray]:
    """max(0, t), smoothed, and its slope; without cancellation for t < 0."""
    root = np.sqrt(trial**2 + 4.0 * smoothing**2)
    larger = 0.5 * (np.abs(trial) + root)
    return np.where(trial > 0, larger, smoothing**2 / larger), 0.5 * (1.0 + trial / root)
