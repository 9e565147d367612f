"""Macroblocks without tolerances: the fewest bodies that, as rigid bodies, keep the states of micro limit analysis.

Two neighbouring bodies that lock together while they move keep their momentum and lose kinetic energy (a perfectly
plastic collision): nothing if they moved as one body already. Joining again and again the two neighbours that lose
least leads from every stone to one body. Of these partitions the one with fewest bodies is taken that still has a limit
state within a margin of micro limit analysis; then bodies that are not needed for it are joined, one pair after the
other. One body is never taken: it can only slide or overturn on its support.

Non-associative states are not unique, and bodies that can take fewer motions than the stones may meet another. Two
are therefore kept, each by its own mechanism: the headline and the paper's. With the headline alone 3 bodies for 71
stones (random 7 of docs/studies) bear 18 % more than these in finite elements; the lowest found too asks for 43 bodies
instead of 9 on benchmark 2.
States are looked for on the bodies by a descent from the slips they had (lower_states), which costs a few milliseconds.
Stones that come loose before stay bodies of their own; bodies are chosen for the wall without them.
"""

from __future__ import annotations

import heapq
import logging
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np

from orchestrator.basis.arrays import FloatArray, IntArray
from orchestrator.basis.errors import ConvergenceError
from orchestrator.geometry.rigid import cross, polar_moment
from orchestrator.limit_analysis import LimitAnalysis, LimitState, Mechanism
from orchestrator.limit_analysis.paper.equilibrium import block_areas, block_centroids, block_weights
from orchestrator.limit_analysis.paper.limit_state import of_first_joints
from orchestrator.limit_analysis.paper.linear_program import solve_limit_lp
from orchestrator.limit_analysis.search.loading import joints_left, part_of
from orchestrator.limit_analysis.search.lower_states import POWER_LEFT, TwoPrograms, descent
from orchestrator.macroblocks.criteria import TOLERANCES, MacroblockSettings, Partition, merged, partition_of
from orchestrator.macroblocks.merged_blocks import merged_problem
from orchestrator.masonry.joints import Assemblage

logger = logging.getLogger(__name__)

ANOTHER = 1e-4
"""Part of the multiplier by which another state differs at least."""


@dataclass(frozen=True, eq=False, slots=True)
class Motion:
    """A rigid body in motion: mass (any unit), polar inertia (mass x m2), centre (2,) m, velocity (2,), rotation."""

    mass: float
    inertia: float
    centre: FloatArray
    velocity: FloatArray
    rotation: float

    @property
    def energy(self) -> float:
        """Kinetic energy."""
        return 0.5 * (self.mass * float(self.velocity @ self.velocity) + self.inertia * self.rotation**2)


def locked(first: Motion, second: Motion) -> tuple[Motion, float]:
    """Return the motion of both as one body, with their momentum, and the kinetic energy that is lost."""
    mass = first.mass + second.mass
    reduced = first.mass * second.mass / mass
    arm, apart = second.centre - first.centre, second.velocity - first.velocity
    inertia = first.inertia + second.inertia + reduced * float(arm @ arm)
    spin = reduced * float(cross(arm, apart))
    together = Motion(
        mass=mass,
        inertia=inertia,
        centre=(first.mass * first.centre + second.mass * second.centre) / mass,
        velocity=(first.mass * first.velocity + second.mass * second.velocity) / mass,
        rotation=(first.inertia * first.rotation + second.inertia * second.rotation + spin) / inertia,
    )
    return together, first.energy + second.energy - together.energy


def motion_of_blocks(assemblage: Assemblage, mechanism: Mechanism) -> list[Motion]:
    """Return the motion of every block, weights standing for masses."""
    wall = assemblage.wall
    weights, centres = block_weights(wall), block_centroids(wall)
    gyration = np.array([polar_moment(b.polygon - c) for b, c in zip(wall.blocks, centres, strict=True)])
    inertia = weights * gyration / block_areas(wall)
    return [
        Motion(float(m), float(j), centre, velocity[:2], float(velocity[2]))
        for m, j, centre, velocity in zip(weights, inertia, centres, mechanism.velocities, strict=True)
    ]


def hierarchy(assemblage: Assemblage, mechanisms: Sequence[Mechanism]) -> list[IntArray]:
    """Return the group of every block (n,), first every stone its own, then with two groups joined each time."""
    group = np.arange(len(assemblage.wall.blocks))
    groups = [group]
    for kept, joined in _joined_in_order(assemblage, mechanisms):
        group = np.where(group == joined, kept, group)
        groups.append(group)
    return groups


Motions = tuple[Motion, ...]
"""of one body, in every mechanism that is to remain possible"""


def _motions_of_blocks(assemblage: Assemblage, mechanisms: Sequence[Mechanism]) -> list[Motions]:
    """Return the motions of every block, every mechanism with the kinetic energy 1."""
    found = []
    for mechanism in mechanisms:
        blocks = motion_of_blocks(assemblage, mechanism)
        scale = 1.0 / np.sqrt(sum(block.energy for block in blocks))
        found.append([replace(m, velocity=scale * m.velocity, rotation=scale * m.rotation) for m in blocks])
    return list(zip(*found, strict=True))


def _together(first: Motions, second: Motions) -> Motions:
    return tuple(locked(one, other)[0] for one, other in zip(first, second, strict=True))


def _loss(first: Motions, second: Motions) -> float:
    """Return the kinetic energy that locking costs, all mechanisms together."""
    return sum(locked(one, other)[1] for one, other in zip(first, second, strict=True))


def _joined_in_order(assemblage: Assemblage, mechanisms: Sequence[Mechanism]) -> Iterator[tuple[int, int]]:
    """Yield (new group, old group) twice a join: numbers of groups are those of one of their blocks."""
    motions = dict(enumerate(_motions_of_blocks(assemblage, mechanisms)))
    neighbours = _neighbours(assemblage)
    version = dict.fromkeys(motions, 0)
    queue = [_priced(motions, version, i, j) for i, others in neighbours.items() for j in others if i < j]
    heapq.heapify(queue)
    while queue:
        _, i, j, seen = heapq.heappop(queue)
        if i not in motions or j not in motions or seen != (version[i], version[j]):
            continue
        motions[i] = _together(motions[i], motions.pop(j))
        version[i] += 1
        neighbours[i] = (neighbours[i] | neighbours.pop(j)) - {i, j}
        for other in neighbours[i]:
            neighbours[other] = neighbours[other] - {j} | {i}
            heapq.heappush(queue, _priced(motions, version, min(i, other), max(i, other)))
        yield i, j


def _priced(
    motions: dict[int, Motions], version: dict[int, int], i: int, j: int
) -> tuple[float, int, int, tuple[int, int]]:
    """Return the loss of joining i and j, with what tells later whether either has changed."""
    return _loss(motions[i], motions[j]), i, j, (version[i], version[j])


def _neighbours(assemblage: Assemblage) -> dict[int, set[int]]:
    """Return for every free block the free blocks that it shares a joint with."""
    found: dict[int, set[int]] = {k: set() for k, block in enumerate(assemblage.wall.blocks) if not block.fixed}
    for i, j in assemblage.joints.pairs:
        if i in found and j in found:
            found[i].add(j)
            found[j].add(i)
    return found


def macroblocks_of(
    assemblage: Assemblage,
    analysis: LimitAnalysis,
    criteria: MacroblockSettings | None = None,
    tied: Assemblage | None = None,
) -> Partition:
    """Return macroblocks by the criteria's tolerances (`merged`, which may raise CaseError) where they say so or one is
    not the default; else, without criteria too, those that are `chosen` under the loads of the analysis.

    tied: with ties after the joints of `assemblage`, where the analysis has them: they hold bodies, and join none.
    """
    criteria = criteria or MacroblockSettings()
    given = any(getattr(criteria, name) != getattr(MacroblockSettings(), name) for name in TOLERANCES)
    if criteria.choose == "tolerances" or given:
        of_joints = of_first_joints(analysis, assemblage.joints.count)
        return merged(assemblage, of_joints.headline.mechanism, criteria)
    return chosen(assemblage, analysis, criteria.margin, tied)


def states_to_keep(analysis: LimitAnalysis) -> list[LimitState]:
    """Return the headline and, where it is another state, the paper's: bodies may meet either."""
    headline, paper = analysis.headline, analysis.sequence
    if paper is None or abs(paper.load_multiplier - headline.load_multiplier) <= ANOTHER * headline.load_multiplier:
        return [headline]
    return [headline, paper]


def chosen(
    assemblage: Assemblage,
    analysis: LimitAnalysis,
    margin: float,
    tied: Assemblage | None = None,
) -> Partition:
    """Return the partition with the fewest bodies found that keeps the states of micro-LA within `margin`, part of it.

    tied: as in `macroblocks_of`. Every stone stays a body where nothing coarser does; a wall of one block is one body.
    """
    tied = tied or assemblage
    if analysis.local_failures:
        return _chosen_without_loose_stones(assemblage, analysis, margin, tied)
    states = states_to_keep(analysis)
    mechanisms = [state.mechanism for state in states]

    def kept(partition: Partition) -> list[float]:
        """Return the multipliers found for the states, as far as the first that is lost."""
        found = []
        logger.info("macroblocks: trying %d bodies", partition.count)
        for state in states:
            multiplier = kept_multiplier(tied, analysis, state, partition, margin)
            if multiplier is None:
                break
            found.append(multiplier)
        return found

    def keeps(partition: Partition) -> bool:
        return partition.count > 1 and len(kept(partition)) == len(states)

    partition = partition_of(assemblage, np.arange(len(assemblage.wall.blocks)))
    if keeps(partition):  # else no state was closed that any bodies could keep
        partition = _coarsest([partition_of(assemblage, g) for g in hierarchy(assemblage, mechanisms)][::-1], keeps)
        partition = _joined_while(keeps, partition, assemblage, mechanisms)
    words = " and ".join(
        f"{found:.4f} (every stone {state.load_multiplier:.4f})"
        for found, state in zip(kept(partition), states, strict=False)
    )
    said = f"chosen automatically: multiplier as rigid bodies {words or 'not found'}, margin {margin:.3g}"
    stones = sum(not block.fixed for block in assemblage.wall.blocks)
    little = f"{partition.count} macroblocks of {stones} stones save little: run --model micro has every stone"
    return replace(partition, remarks=(said, *[little] * (2 * partition.count > stones > 2), *partition.remarks))


def _chosen_without_loose_stones(
    assemblage: Assemblage, analysis: LimitAnalysis, margin: float, tied: Assemblage
) -> Partition:
    """Return the partition chosen for the wall without the stones of local failures: these stay bodies of their own.

    The paper's state is that of the wall as drawn, and is not kept.
    """
    loose = {stone for failure in analysis.local_failures for stone in failure.stones}
    left = np.array([block.id not in loose for block in assemblage.wall.blocks])
    joints = joints_left(tied, left)
    state = analysis.headline
    mechanism = replace(
        state.mechanism,
        velocities=state.mechanism.velocities[left],
        opening=state.mechanism.opening[joints],
        slip=state.mechanism.slip[joints],
    )
    of_left = replace(state, joint_forces=state.joint_forces[joints], mechanism=mechanism)
    part = chosen(
        part_of(assemblage, left),
        replace(analysis, loads=analysis.loads.of_blocks(left), path=of_left, sequence=None, local_failures=()),
        margin,
        part_of(tied, left),
    )
    group = len(left) + np.arange(len(left))
    group[left] = part.body_of_block
    partition = partition_of(assemblage, group)
    said = f"{len(loose)} stones that come loose before the wall fails stay bodies of their own"
    return replace(partition, remarks=(*part.remarks, said))


def kept_multiplier(
    assemblage: Assemblage,
    analysis: LimitAnalysis,
    state: LimitState,
    partition: Partition,
    margin: float,
) -> float | None:
    """Return the multiplier within `margin` of a state of micro-LA that the bodies have as rigid ones, None if none.

    Non-associative states are not unique. That of micro-LA is one of the bodies where its forces between them have a
    mechanism (they balance on any bodies); else one near it is reached by a descent from the slips it had.
    """
    equilibrium, friction = merged_problem(assemblage, partition.body_of_block, analysis.loads)
    micro = state.load_multiplier
    try:
        if state.flow_rule == "associative":
            found = [solve_limit_lp(equilibrium, friction).load_multiplier]
        else:
            remains = partition.body_of_block[assemblage.joints.i] != partition.body_of_block[assemblage.joints.j]
            programs, normal = TwoPrograms(equilibrium, friction), state.joint_forces[remains, :2].sum(axis=1)
            if abs(programs.mechanism(normal).load_multiplier - state.load_multiplier) <= POWER_LEFT * micro:
                return micro
            turns = descent(programs, state.mechanism.slip[remains])
            found = [turn.forces.load_multiplier for turn in turns if turn.balances]
    except ConvergenceError:
        return None
    nearest = min(found, key=lambda multiplier: abs(multiplier - micro), default=np.inf)
    return nearest if abs(nearest - micro) <= margin * micro else None


def _coarsest(coarse_to_fine: Sequence[Partition], keeps: Callable[[Partition], bool]) -> Partition:
    """Return the first that keeps the multiplier, looked for in steps of a quarter and then by halving.

    The multiplier hardly ever grows from coarse to fine (the associative one never does), so that halving finds it.
    """
    last = len(coarse_to_fine) - 1
    low, high = 0, min(1, last)
    while high < last and not keeps(coarse_to_fine[high]):
        low, high = high, min(high + 1 + high // 4, last)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if keeps(coarse_to_fine[middle]) else (middle, high)
    return coarse_to_fine[high]


def _joined_while(
    keeps: Callable[[Partition], bool], partition: Partition, assemblage: Assemblage, mechanisms: Sequence[Mechanism]
) -> Partition:
    """Join pairs of neighbouring bodies, those that lose least energy first, each tried once, while `keeps` holds."""
    group = partition.body_of_block
    for i, j in _pairs_by_loss(partition, assemblage, mechanisms):
        kept, joined = group[i], group[j]
        coarser = partition_of(assemblage, np.where(group == joined, kept, group))
        if kept != joined and keeps(coarser):
            partition, group = coarser, np.where(group == joined, kept, group)
    return partition


def _pairs_by_loss(
    partition: Partition, assemblage: Assemblage, mechanisms: Sequence[Mechanism]
) -> list[tuple[int, int]]:
    """Return the joints (as pairs of blocks) between neighbouring bodies, one a pair of bodies, least loss first."""
    body, blocks = partition.body_of_block, _motions_of_blocks(assemblage, mechanisms)
    motions = [
        reduce(_together, (blocks[k] for k in np.flatnonzero(body == number))) for number in range(partition.count)
    ]
    joints: dict[tuple[int, int], tuple[int, int]] = {}
    for i, j in assemblage.joints.pairs:
        first, second = sorted((int(body[i]), int(body[j])))
        if first != second and second < partition.count:
            joints[first, second] = (i, j)
    return [joints[pair] for pair in sorted(joints, key=lambda pair: _loss(motions[pair[0]], motions[pair[1]]))]
