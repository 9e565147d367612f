"""Macroblocks without tolerances: the fewest bodies that, as rigid bodies, keep the multiplier of micro limit analysis.

Two neighbouring bodies that lock together while they move keep their momentum and lose kinetic energy (a perfectly
plastic collision): nothing if they moved as one body already. Joining again and again the two neighbours that lose
least leads from every stone to one body. Of these partitions the one with fewest bodies is taken whose load multiplier
(limit_analysis.merged_blocks) stays within a margin of micro limit analysis; then bodies that the multiplier does not
need are joined, one pair after the other, as long as it stays within. One body is never taken: it can only slide or
overturn on its support.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np

from orchestrator.joints import Assemblage
from orchestrator.limit_analysis import LimitAnalysis, LimitAnalysisSettings, Loads, Mechanism
from orchestrator.limit_analysis.equilibrium import block_areas, block_centroids, block_weights
from orchestrator.limit_analysis.merged_blocks import merged_multiplier
from orchestrator.limit_analysis.state import FlowRule
from orchestrator.macroblocks import MacroblockSettings, Partition, merged, partition_of
from orchestrator.masonry.wall import FloatArray, IntArray

QUICK_SEEDS = (1e-1, 1e-2, 1e-3)
QUICK_TOLERANCE = 1e-4
QUICK_ITERATIONS = 40
"""Of the sequence of Eq. (2) while partitions are tried. On those of 26 partitions of benchmarks 1 and 2 where both the
quick and the full sequence found a multiplier (about 20), they agree within 0.2 %, in a third of the time."""


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
    spin = reduced * float(arm[0] * apart[1] - arm[1] * apart[0])
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
    gyration = np.array([_polar_moment(b.polygon - c) for b, c in zip(wall.blocks, centres, strict=True)])
    inertia = weights * gyration / block_areas(wall)
    return [
        Motion(float(m), float(j), centre, velocity[:2], float(velocity[2]))
        for m, j, centre, velocity in zip(weights, inertia, centres, mechanism.velocities, strict=True)
    ]


def _polar_moment(polygon: FloatArray) -> float:
    """Return the polar second moment of area (m4) of a polygon (n, 2) about the origin."""
    following = np.roll(polygon, -1, axis=0)
    cross = polygon[:, 0] * following[:, 1] - following[:, 0] * polygon[:, 1]
    squares = np.sum(polygon**2 + polygon * following + following**2, axis=1)
    return float(cross @ squares) / 12.0


def hierarchy(assemblage: Assemblage, mechanism: Mechanism) -> list[IntArray]:
    """Return the group of every block (n,), first every stone its own, then with two groups joined each time."""
    group = np.arange(len(assemblage.wall.blocks))
    groups = [group]
    for kept, joined in _joined_in_order(assemblage, mechanism):
        group = np.where(group == joined, kept, group)
        groups.append(group)
    return groups


def _joined_in_order(assemblage: Assemblage, mechanism: Mechanism) -> Iterator[tuple[int, int]]:
    """Yield (new group, old group) twice a join: numbers of groups are those of one of their blocks."""
    motions = dict(enumerate(motion_of_blocks(assemblage, mechanism)))
    neighbours = _neighbours(assemblage)
    version = dict.fromkeys(motions, 0)
    queue = [_priced(motions, version, i, j) for i, others in neighbours.items() for j in others if i < j]
    heapq.heapify(queue)
    while queue:
        _, i, j, seen = heapq.heappop(queue)
        if i not in motions or j not in motions or seen != (version[i], version[j]):
            continue
        motions[i] = locked(motions[i], motions.pop(j))[0]
        version[i] += 1
        neighbours[i] = (neighbours[i] | neighbours.pop(j)) - {i, j}
        for other in neighbours[i]:
            neighbours[other] = neighbours[other] - {j} | {i}
            heapq.heappush(queue, _priced(motions, version, min(i, other), max(i, other)))
        yield i, j


def _priced(
    motions: dict[int, Motion], version: dict[int, int], i: int, j: int
) -> tuple[float, int, int, tuple[int, int]]:
    """Return the loss of joining i and j, with what tells later whether either has changed."""
    return locked(motions[i], motions[j])[1], i, j, (version[i], version[j])


def _neighbours(assemblage: Assemblage) -> dict[int, set[int]]:
    """Return for every free block the free blocks that it shares a joint with."""
    found: dict[int, set[int]] = {k: set() for k, block in enumerate(assemblage.wall.blocks) if not block.fixed}
    for i, j in zip(assemblage.block_i.tolist(), assemblage.block_j.tolist(), strict=True):
        if i in found and j in found:
            found[i].add(j)
            found[j].add(i)
    return found


def macroblocks_of(
    assemblage: Assemblage,
    analysis: LimitAnalysis,
    criteria: MacroblockSettings,
    settings: LimitAnalysisSettings,
    loads: Loads | None = None,
) -> Partition:
    """Return the partition that [macroblocks] asks for: `chosen`, or `merged` (which may raise CaseError)."""
    if criteria.choose == "automatic":
        return chosen(assemblage, analysis, settings, criteria.margin, loads)
    return merged(assemblage, analysis.headline.mechanism, criteria)


def chosen(
    assemblage: Assemblage,
    analysis: LimitAnalysis,
    settings: LimitAnalysisSettings,
    margin: float,
    loads: Loads | None = None,
) -> Partition:
    """Return the partition whose multiplier is within `margin` (a part of micro-LA's) with the fewest bodies found.

    Every stone stays a body where nothing coarser does; a wall of one block is one body. Non-associative states are not
    unique: where the sequence settles on one below the margin, the dilation shift may find the one that was looked for
    (a slender wall of 50 stones as 2 bodies: 0.3570 and 0.3779, every stone 0.3779).
    """
    micro = analysis.headline
    quick = replace(
        settings, seed_cohesions=QUICK_SEEDS, tolerance=QUICK_TOLERANCE, maximum_iterations=QUICK_ITERATIONS
    )

    def multiplier(partition: Partition) -> float | None:
        def by(rule: FlowRule) -> float | None:
            return merged_multiplier(assemblage, partition.body_of_block, analysis.load_direction, rule, quick, loads)

        found = by(micro.flow_rule)
        if micro.flow_rule == "sequence" and found is not None and found < (1.0 - margin) * micro.load_multiplier:
            return max(found, by("dilation_shift") or found)
        return found

    def keeps(partition: Partition) -> bool:
        found = multiplier(partition) if partition.count > 1 else None
        return found is not None and abs(found - micro.load_multiplier) <= margin * micro.load_multiplier

    partition = _coarsest([partition_of(assemblage, g) for g in hierarchy(assemblage, micro.mechanism)][::-1], keeps)
    partition = _joined_while(keeps, partition, assemblage, micro.mechanism)
    found = multiplier(partition)
    words = f"{found:.4f}" if found is not None else "not found"
    said = (
        f"chosen automatically: multiplier as rigid bodies {words}, within {margin:.3g} of {micro.load_multiplier:.4f}"
    )
    return replace(partition, remarks=(said, *partition.remarks))


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
    keeps: Callable[[Partition], bool], partition: Partition, assemblage: Assemblage, mechanism: Mechanism
) -> Partition:
    """Join pairs of neighbouring bodies, those that lose least energy first, each tried once, while `keeps` holds."""
    group = partition.body_of_block
    for i, j in _pairs_by_loss(partition, assemblage, mechanism):
        kept, joined = group[i], group[j]
        coarser = partition_of(assemblage, np.where(group == joined, kept, group))
        if kept != joined and keeps(coarser):
            partition, group = coarser, np.where(group == joined, kept, group)
    return partition


def _pairs_by_loss(partition: Partition, assemblage: Assemblage, mechanism: Mechanism) -> list[tuple[int, int]]:
    """Return the joints (as pairs of blocks) between neighbouring bodies, one a pair of bodies, least loss first."""
    body, blocks = partition.body_of_block, motion_of_blocks(assemblage, mechanism)
    motions = [
        reduce(lambda one, other: locked(one, other)[0], (blocks[k] for k in np.flatnonzero(body == number)))
        for number in range(partition.count)
    ]
    joints: dict[tuple[int, int], tuple[int, int]] = {}
    for i, j in zip(assemblage.block_i.tolist(), assemblage.block_j.tolist(), strict=True):
        first, second = sorted((int(body[i]), int(body[j])))
        if first != second and second < partition.count:
            joints[first, second] = (i, j)
    return [joints[pair] for pair in sorted(joints, key=lambda pair: locked(motions[pair[0]], motions[pair[1]])[1])]
