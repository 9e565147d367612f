"""Which bodies lose least when they lock together: the order in which blocks are joined.

Two neighbouring bodies that lock together while they move keep their momentum and lose kinetic energy (a perfectly
plastic collision): nothing if they moved as one body already.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np

from orchestrator.basis.arrays import FloatArray, IntArray
from orchestrator.geometry.rigid import cross, polar_moment
from orchestrator.limit_analysis import Mechanism
from orchestrator.limit_analysis.paper.equilibrium import block_areas, block_centroids, block_weights
from orchestrator.macroblocks.criteria import Partition
from orchestrator.masonry.joints import Assemblage

DECIMALS = 12
"""of a loss, of a mechanism's energy, and of a mass, of the wall's: what is less is rounding, and must not choose"""
PLACES = 6
"""decimals of a coordinate, over the size of a mean stone, to which blocks stand beside or above each other"""


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


def hierarchy(
    assemblage: Assemblage, mechanisms: Sequence[Mechanism], within: IntArray | None = None
) -> list[IntArray]:
    """Return the group of every block (n,), first every stone its own, then with two groups joined each time.

    within (n,): bodies across which nothing is joined: they are the last groups. None: all free blocks are one.
    """
    group = np.arange(len(assemblage.wall.blocks))
    groups = [group]
    within = np.zeros_like(group) if within is None else within
    for kept, joined in _joined_in_order(assemblage, mechanisms, within):
        group = np.where(group == joined, kept, group)
        groups.append(group)
    return groups


Motions = tuple[Motion, ...]
"""of one body, in every mechanism that is to remain possible"""


def _motions_of_blocks(assemblage: Assemblage, mechanisms: Sequence[Mechanism]) -> list[Motions]:
    """Return the motions of every block, every mechanism with the kinetic energy and all blocks with the mass 1."""
    motions = []
    for mechanism in mechanisms:
        blocks = motion_of_blocks(assemblage, mechanism)
        total = sum(block.mass for block in blocks)
        scale = np.sqrt(total / sum(block.energy for block in blocks))
        motions.append(
            [
                Motion(m.mass / total, m.inertia / total, m.centre, scale * m.velocity, scale * m.rotation)
                for m in blocks
            ]
        )
    return list(zip(*motions, strict=True))


def _together(first: Motions, second: Motions) -> Motions:
    return tuple(locked(one, other)[0] for one, other in zip(first, second, strict=True))


def _price(first: Motions, second: Motions) -> tuple[float, float]:
    """Return the kinetic energy that locking costs, all mechanisms together, and the mass that is then one body: of
    bodies that lose alike the lightest are joined first, so that those that are divided come apart in halves."""
    loss = sum(locked(one, other)[1] for one, other in zip(first, second, strict=True))
    return round(loss, DECIMALS), round(first[0].mass + second[0].mass, DECIMALS)


def _joined_in_order(
    assemblage: Assemblage, mechanisms: Sequence[Mechanism], within: IntArray
) -> Iterator[tuple[int, int]]:
    """Yield (new group, old group) twice a join: numbers of groups are those of one of their blocks.

    Of joins that cost alike, where blocks stand decides, not their numbers.
    """
    block = _by_place(assemblage, mechanisms)
    rank, blocks = np.argsort(block), _motions_of_blocks(assemblage, mechanisms)
    motions = {place: blocks[k] for place, k in enumerate(block)}
    neighbours = _neighbours(assemblage, within, rank)
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
        yield int(block[i]), int(block[j])


def _by_place(assemblage: Assemblage, mechanisms: Sequence[Mechanism]) -> IntArray:
    """Return the blocks (n,) from below, those of one height along the motion: the same however they are numbered, and
    in a mirror."""
    wall = assemblage.wall
    towards = sum(float(np.sign(block_weights(wall) @ mechanism.velocities[:, 0])) for mechanism in mechanisms)
    centres = block_centroids(wall) / np.sqrt(block_areas(wall).mean())
    along, height = np.round((centres - centres.min(axis=0)).T, PLACES)
    return np.lexsort([along if towards >= 0.0 else -along, height])


def _priced(
    motions: dict[int, Motions], version: dict[int, int], i: int, j: int
) -> tuple[tuple[float, float], int, int, tuple[int, int]]:
    """Return the price of joining i and j, with what tells later whether either has changed."""
    return _price(motions[i], motions[j]), i, j, (version[i], version[j])


def _neighbours(assemblage: Assemblage, within: IntArray, rank: IntArray) -> dict[int, set[int]]:
    """Return for every free block the free blocks of the same body that it shares a joint with, all by rank."""
    free = [not block.fixed for block in assemblage.wall.blocks]
    neighbours: dict[int, set[int]] = {int(place): set() for place in rank[free]}
    for i, j in assemblage.joints.pairs:
        if free[i] and free[j] and within[i] == within[j]:
            neighbours[int(rank[i])].add(int(rank[j]))
            neighbours[int(rank[j])].add(int(rank[i]))
    return neighbours


def pairs_by_loss(
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
    rank = np.argsort(_by_place(assemblage, mechanisms))
    first_of = [int(rank[body == number].min()) for number in range(partition.count)]

    def order(pair: tuple[int, int]) -> tuple[tuple[float, float], list[int]]:
        return _price(motions[pair[0]], motions[pair[1]]), sorted(first_of[number] for number in pair)

    return [joints[pair] for pair in sorted(joints, key=order)]
