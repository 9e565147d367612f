"""Rigid blocks on elastic joints without tension and with Coulomb friction: forces of a position, and their slopes.

A joint touches in points (joint_points.py), three of them where stones give way. (With all of it at the ends a joint is
three times too stiff, and a column at the edge of a wall leans on its neighbours although in finite elements it has
come away from them.) At each point

    normal   n = max(0, T - k_n gap) - T         gap = opening since the joints were drawn
    shear    s = s_0 - k_t (slip - slip_0), cut to |s| <= mu n + c     from the last position (slip_0, s_0); no dilation

A tie is a point that slides along its line: its pull, less what lies midway between all that it bears, is a shear with
cohesion and no friction. It is as stiff as a mean joint, begins without force, and shortens for good where it is slack.

Gaps are remembered, slips are forgotten once they are made: that is what tells this law from one that is plastic in
both. max(0, t) is smoothed to (t + sqrt(t^2 + 4 m^2))/2, m = JOINT_SMOOTHING block weights: Newton's method needs
slopes, and where a point has opened its force m^2/(k gap) is soon nothing. The k_n of a joint are E t L/d in all, d the
distance between the centroids along its normal, less where the joint is short against the stones beside it
(stone_compliance.py; a support is rigid and counts for nothing). Only ratios of stiffnesses
matter to a limit state: they are such that their mean is 2. How far blocks move in m depends on E: `unit` says it, and
joints of blocks that have moved stand where moved_joints.py says. A state that is a property of the wall is the same
with both STIFFNESSES. Sources: Lourenço and Rots 1997 (stiffness of a joint that stands for the stones beside it); Chen
and Harker 1993 (smoothing).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray
from orchestrator.limit_analysis.paper.equilibrium import Equilibrium
from orchestrator.limit_analysis.paper.yield_conditions import YieldConditions
from orchestrator.limit_analysis.search.joint_points import OF_MORTAR, OF_STONES, JointPoints
from orchestrator.limit_analysis.search.moved_joints import MovedJoints, moved_joints
from orchestrator.limit_analysis.search.moved_loads import LinearLoads, MovedLoads, moved_loads
from orchestrator.limit_analysis.search.scaled_problem import ScaledProblem, scaled_problem
from orchestrator.limit_analysis.search.stone_compliance import SPREAD, stone_lengths
from orchestrator.limit_analysis.search.wall_stiffness import POINT_ENTRIES, WallStiffness, point_products
from orchestrator.masonry.block_properties import ELASTIC_MODULUS, block_centroids, block_moduli, block_weights
from orchestrator.masonry.joints import Assemblage

JOINT_SMOOTHING = 1e-4
"""m in mean block weights."""
Stiffness = tuple[bool, float]
"""Whether k_n falls with the distance d between centroids (else it only grows with the length), and k_t over k_n."""
STIFFNESSES: tuple[Stiffness, Stiffness] = ((True, 0.4), (False, 1.0))
"""Stones as soft as their joints (0.4: an elastic solid with a Poisson ratio of 0.25), and joints between hard ones."""
LEAST_STIFFNESS = 1e-8
"""Part of its stiffness that an open point has in the matrix: a block that hangs free for a moment is held."""


@dataclass(frozen=True, eq=False, slots=True)
class ElasticWall:
    """A wall in the units of `ScaledProblem`, of the c points of its k joints, joint by joint (`points`).

    stiffness (c, 2): normal, and along the joint. tension (c,): tensile strength, mean block weights. unit: metres of
    displacement 1. loads: those of `problem`, and how they change about where a wall is linearised. to_joints (3k, 2c):
    from forces of points to those of joints, to which what ties carry midway (k, 3) is added. joints,
    moved_loads: how they are where blocks have moved; None: as in `problem`, wherever blocks are. offset (c, 2): rates
    without displacements, of a wall linearised about some.
    """

    problem: ScaledProblem
    stiffness: FloatArray
    tension: FloatArray
    unit: float
    loads: LinearLoads
    points: JointPoints
    to_joints: sp.csr_matrix
    midway: FloatArray
    joints: MovedJoints | None = None
    moved_loads: MovedLoads | None = None
    offset: FloatArray | float = 0.0

    def rates(self, displacements: FloatArray) -> FloatArray:
        """Opening and slip (c, 2) of blocks that have moved by displacements (3m,), with joints as in `problem`."""
        return self.offset - (self.problem.B_T @ displacements).reshape(-1, 2)

    def at(self, displacements: FloatArray) -> ElasticWall:
        """Return a wall with joints that move, linearised about displacements (3m,), under the loads it has there."""
        assert self.joints is not None
        assert self.moved_loads is not None
        B, rates = self.joints.at(displacements)
        loads, stiffness = self.moved_loads.linearised(displacements), self.problem.stiffness.of(B)
        problem = replace(self.problem, B=B, B_T=B.T, dead=loads.dead, live=loads.live, stiffness=stiffness)
        return replace(self, problem=problem, loads=loads, offset=rates + (B.T @ displacements).reshape(-1, 2))

    def strength(self, normal: FloatArray) -> FloatArray:
        """Largest shear (c,) of points that carry normal forces (c,)."""
        return self.problem.friction * normal + self.problem.cohesion

    def flow_error(self, forces: FloatArray, rates: FloatArray, live_power: float) -> float:
        """What points do that open while loaded or slide before they must, over lambda times the live load's power.

        forces and rates (c, 2): 0 for a limit state, and then the relative error that its multiplier may have.
        """
        spare = np.maximum(self.strength(forces[:, 0]) - np.abs(forces[:, 1]), 0.0)
        done = (forces[:, 0] + self.tension) @ np.abs(rates[:, 0]) + spare @ np.abs(rates[:, 1])
        return float(done / max(abs(live_power), 1e-300, 1e-300 * done))


def joint_forces(wall: ElasticWall, forces: FloatArray) -> FloatArray:
    """Return the forces (k, 3) of joints, normal ones at both ends and the shear, from those of points (c, 2)."""
    return (wall.to_joints @ forces.ravel()).reshape(-1, 3) + wall.midway


def joint_stiffness(wall: ElasticWall) -> FloatArray:
    """Return the stiffness (k, 3) of joints as if all of it sat at their ends."""
    return wall.stiffness.reshape(-1, 2 * len(wall.points.places)) @ wall.points.joint_of_points.T


def open_ends(wall: ElasticWall, rates: FloatArray) -> BoolArray:
    """Return which ends (k, 2) of joints stand open, from the rates (c, 2) since they were drawn."""
    opened = (wall.stiffness[:, 0] * rates[:, 0] > JOINT_SMOOTHING).reshape(-1, len(wall.points.places))
    return opened[:, [0, -1]]


@dataclass(frozen=True, eq=False, slots=True)
class Position:
    """Where the blocks are and what they carry: displacements (3m,), points' forces and rates since drawing (c, 2).

    tangent (c, 3): stiffness of the points as the step that led there left it.
    """

    displacements: FloatArray
    forces: FloatArray
    rates: FloatArray
    tangent: FloatArray

    def goes_on(self, rates: FloatArray) -> FloatArray:
        """Return forces (c, 2) at other rates (c, 2) if no point opens, closes, sticks or slides on the way."""
        return self.forces - point_products(self.tangent, rates - self.rates)


def elastic_wall(
    assemblage: Assemblage,
    equilibrium: Equilibrium,
    coulomb: YieldConditions,
    stiffness: Stiffness = STIFFNESSES[0],
    body_of_block: IntArray | None = None,
    elastic_modulus: float = ELASTIC_MODULUS,
    points: JointPoints = OF_STONES,
    spread: float = 1.0,
) -> ElasticWall:
    """Return the wall with the stiffness of every joint, or of those between bodies of several blocks.

    body_of_block (n,): which blocks are one body, as equilibrium and Coulomb's law (k joints) have them.
    elastic_modulus: of stones that have none of their own, Pa. spread: how many times stiffer than prisms stones are.
    """
    wall, joints, centroids = assemblage.wall, assemblage.joints, block_centroids(assemblage.wall)
    if body_of_block is not None:
        joints = joints.part(body_of_block[joints.i] != body_of_block[joints.j])
        weights = block_weights(wall)
        moment = np.column_stack([np.bincount(body_of_block, weights * x) for x in centroids.T])
        centroids = (moment / np.bincount(body_of_block, weights)[:, None])[body_of_block]
    free, modulus = np.array([not block.fixed for block in wall.blocks]), block_moduli(wall, elastic_modulus)
    bodies = np.arange(len(wall.blocks)) if body_of_block is None else body_of_block
    lengths = stone_lengths(wall, joints, bodies, centroids)
    compliance = sum(
        free[block] * length / modulus[block] for block, length in zip((joints.i, joints.j), lengths, strict=True)
    )
    by_distance, tangential = stiffness
    ties = coulomb.are_ties
    physical = joints.area / (compliance / spread + 1.0 / joints.normal_stiffness)
    normal = physical if by_distance else joints.area
    normal = np.kron(np.where(ties, 2.0, 2.0 * normal / normal[~ties].mean()), points.areas)
    problem, to_joints, midway = of_points(
        scaled_problem(equilibrium, coulomb), points, coulomb, equilibrium.unit_force
    )
    return ElasticWall(
        problem=problem,
        stiffness=np.column_stack([normal, tangential * normal]),
        tension=np.kron(np.where(ties, 0.0, coulomb.tension / equilibrium.unit_force), points.areas),
        unit=2.0 * equilibrium.unit_force / float(physical[~ties].mean()),
        loads=LinearLoads(problem.dead, problem.live),
        points=points,
        to_joints=to_joints,
        midway=midway,
    )


def moving_wall(
    assemblage: Assemblage,
    equilibrium: Equilibrium,
    coulomb: YieldConditions,
    stiffness: Stiffness = STIFFNESSES[0],
    elastic_modulus: float = ELASTIC_MODULUS,
) -> ElasticWall:
    """Return the wall with joints and loads that are where the stones have moved, SPREAD times stiffer than prisms;
    joints of mortar are as stiff as it."""
    points = OF_MORTAR if np.isfinite(assemblage.joints.normal_stiffness).any() else OF_STONES
    wall = elastic_wall(assemblage, equilibrium, coulomb, stiffness, None, elastic_modulus, points, SPREAD)
    joints = moved_joints(assemblage, equilibrium, points.places, wall.unit)
    B, _ = joints.at(np.zeros(wall.problem.B.shape[0]))
    problem = replace(wall.problem, B=B, B_T=B.T, stiffness=WallStiffness(B, POINT_ENTRIES))
    return replace(wall, problem=problem, joints=joints, moved_loads=moved_loads(problem, equilibrium, joints.unit))


def of_points(
    problem: ScaledProblem, points: JointPoints, coulomb: YieldConditions, unit_force: float
) -> tuple[ScaledProblem, sp.csr_matrix, FloatArray]:
    """Return a problem of joints as that of their points, and to_joints and midway of `ElasticWall`."""
    ties, of_tie = coulomb.are_ties, np.zeros((3, 2 * len(points.places)))
    of_tie[:2, 1::2] = -0.5
    of_all = ((~ties, points.joint_of_points), (ties, of_tie))
    to_joints = sum(sp.kron(sp.diags(which.astype(float)), forces, format="csr") for which, forces in of_all)
    pulls, pushes = (np.where(ties, strength, 0.0) / unit_force for strength in (coulomb.tension, coulomb.crushing))
    midway = np.outer(0.25 * (pushes - pulls), [1.0, 1.0, 0.0])
    B = (problem.B @ to_joints).tocsr()
    found = replace(
        problem,
        B=B,
        B_T=B.T.tocsr(),
        dead=problem.dead - problem.B @ midway.ravel(),
        friction=np.repeat(problem.friction, len(points.places)),
        cohesion=np.kron(problem.cohesion + 0.5 * (pulls + pushes), points.areas),
        stiffness=WallStiffness(B, POINT_ENTRIES),
    )
    return found, to_joints, midway


def undeformed(wall: ElasticWall) -> Position:
    """Return the position in which the wall was drawn, without forces."""
    nothing, slack = np.zeros_like(wall.stiffness), np.kron(wall.midway.sum(axis=1), wall.points.areas)
    pressed, stick = wall.stiffness.T
    tangent = np.column_stack([pressed, np.zeros_like(pressed), stick])
    forces = np.column_stack([nothing[:, 0], slack])
    return Position(np.zeros(wall.problem.B.shape[0]), forces, nothing, tangent)


def tried(wall: ElasticWall, before: Position, displacements: FloatArray) -> Position:
    """Return forces and tangent after displacements (3m,) that were reached from the position `before`."""
    rates = wall.rates(displacements)
    (k_n, k_t), (opening, slip) = wall.stiffness.T, rates.T
    normal, d_normal = positive(wall.tension - k_n * opening)
    normal = normal - wall.tension
    limit = wall.strength(normal)
    trial = before.forces[:, 1] - k_t * (slip - before.rates[:, 1])
    above, d_above = positive(trial + limit)
    below, d_below = positive(trial - limit)
    pressed, stick = k_n * np.maximum(d_normal, LEAST_STIFFNESS), k_t * np.maximum(d_above - d_below, LEAST_STIFFNESS)
    slide = wall.problem.friction * (d_above + d_below - 1.0)
    tangent = np.column_stack([pressed, slide * pressed, stick])
    return Position(displacements, np.column_stack([normal, above - below - limit]), rates, tangent)


def positive(trial: FloatArray, smoothing: float = JOINT_SMOOTHING) -> tuple[FloatArray, FloatArray]:
    """max(0, t), smoothed, and its slope; without cancellation for t < 0."""
    root = np.sqrt(trial**2 + 4.0 * smoothing**2)
    larger = 0.5 * (np.abs(trial) + root)
    return np.where(trial > 0, larger, smoothing**2 / larger), 0.5 * (1.0 + trial / root)
