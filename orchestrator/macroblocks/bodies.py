"""Bodies: the outlines of a partition, with holes, and what remains of the joints between them.

A body's outline is what the edges of its blocks leave of each other in the planar map: an edge with the body on both
sides cancels. An edge that is a joint with another body stays an edge of both, so that both have a vertex where the
joint ends: without these vertices a wall of one element per stone loses 39 % of its capacity.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import shapely

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray, read_only
from orchestrator.basis.errors import CaseError
from orchestrator.geometry.planar_map import NO_BLOCK, PlanarMap
from orchestrator.geometry.rigid import cross, polygon_area
from orchestrator.macroblocks.criteria import Partition, refuse_other_partition
from orchestrator.masonry import pressed_edges
from orchestrator.masonry.block_properties import ELASTIC_MODULUS, block_areas, thinner
from orchestrator.masonry.interfaces import SOFTENING, STRENGTHS, Interfaces
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.wall import Block, Wall

NEAR_A_TOE = 2.0
"""a joint has a toe where the resultant of its pressure lies within so many times the distance from its end at which
it has one: other states than the one that forces are known of may press there"""
LEANS = 0.05
"""part of its width over which a column that leans has to be pressed for its bed to have a toe: 7 % of what it bears as
drawn are lost to that; less is a toe where the mechanism turns about it (turning_joints.py)"""
STRAIGHT_HEIGHT = 1e-4
"""height of a vertex over the chord of its neighbours, part of the shorter edge, below which the outline goes straight
on (1e-4 of a stone of 0.4 m is 40 micrometres: the rounding of a drawing)"""


@dataclass(frozen=True, slots=True)
class Part:
    """Blocks of a body with the same elastic constants: the share of the body's volume they fill (its area times the
    wall's thickness, so thinner blocks fill less than they show), modulus in Pa and ratio, None: those of the case."""

    share: float
    elastic_modulus: float | None
    poisson_ratio: float | None


@dataclass(frozen=True, eq=False, slots=True)
class Body:
    """One region of the wall. exterior (n, 2) counter-clockwise, holes (m, 2) clockwise, not closed, in m.

    Edge k of the outline runs from vertex k to the next one; the edges of the holes are numbered on from there.
    """

    number: int
    name: str
    exterior: FloatArray
    holes: tuple[FloatArray, ...]
    fixed: bool
    unit_weight: float
    """weight of its blocks over its area times the wall's thickness, N/m3"""
    blocks: IntArray
    parts: tuple[Part, ...] = (Part(1.0, None, None),)

    @property
    def area(self) -> float:
        """Area without the holes, m2."""
        return float(shapely.Polygon(self.exterior, self.holes).area)


@dataclass(frozen=True, eq=False, slots=True)
class Bodies:
    """Bodies of one thickness (m), moving ones first, and their k interfaces.

    Area and strengths of the interfaces are those of the wall's thickness (strengths less than the joint's own where a
    thinner block meets it). joint (k,): the joint of the assemblage each comes from; edge_i, edge_j (k,): the edge of
    the outline of each body that it is. mean_stone: root of a moving block's area, in m, in the mean over the wall's
    area, so that small stones count little: the same whatever bodies they make. bond_toe (k,): length in m over which
    each is pressed at one end when it has cracked from the other and bears most, 0 without bond. toe (k, 2): length in
    m over which each is pressed so, crushes, presses soft mortar, or has a column lean on it at its start and at its
    end, 0 where it does not; column (k,): width in m of what leans there, inf where nothing does. Both are None where
    no forces say so. hinge (k, 2): length in m over which each is pressed at its start and at its end as stones turn
    about it, 0 where nothing says so.
    """

    bodies: tuple[Body, ...]
    moving: int
    thickness: float
    interfaces: Interfaces
    joint: IntArray
    edge_i: IntArray
    edge_j: IntArray
    mean_stone: float
    bond_toe: FloatArray
    hinge: FloatArray
    toe: FloatArray | None = None
    column: FloatArray | None = None


def materials_of(bodies: Bodies, wall: Wall) -> tuple[str, ...]:
    """Return the material of each moving body: "several" where its blocks differ, "unnamed" where it has no name."""
    materials = [{wall.blocks[block].material or "unnamed" for block in body.blocks} for body in bodies.bodies]
    return tuple(min(names) if len(names) == 1 else "several" for names in materials[: bodies.moving])


def make_bodies(
    assemblage: Assemblage,
    partition: Partition,
    forces: FloatArray | None = None,
    elastic_modulus: float = ELASTIC_MODULUS,
    softening: float = SOFTENING,
    hinges: FloatArray | None = None,
) -> Bodies:
    """Return the outlines of all bodies and the joints that remain between them.

    forces (joints, 3) in N: of a limit state (`LimitState.joint_forces`), which say where joints crush or crack.
    elastic_modulus: of stones that have none of their own, Pa; softening: opening at which bonds have gone, m; hinges
    (joints, 2): of limit analysis (`pressed_at_hinges`), m. Raises CaseError for a partition of another wall, and for
    an assemblage with ties among its joints.
    """
    refuse_other_partition(assemblage, partition)
    body_i, body_j = (partition.body_of_block[side] for side in (assemblage.joints.i, assemblage.joints.j))
    joint = np.flatnonzero(body_i != body_j)
    outlines, edge = assemblage.outlines, assemblage.edge
    if outlines is None or edge is None:
        problem = "has joints that are no edges of its blocks, as ties are: no finite elements are made of it"
        remedy = "give what find_joints returns; finite elements with ties: `run`, with [[reinforcement.ties]]"
        raise CaseError("assemblage", problem, remedy)
    is_interface = np.zeros(len(outlines.left), bool)
    is_interface[edge[joint]] = True
    rings = _rings(outlines, partition.body_of_block, is_interface)
    place = [{part: k for k, part in enumerate(p for ring in of_body for p in ring.edge)} for of_body in rings]
    wall, between = assemblage.wall, assemblage.joints.part(joint)
    share = thinner(wall, between.i, between.j) / wall.thickness
    strengths: dict[str, Any] = {name: read_only(getattr(between, name) * share) for name in STRENGTHS}
    area = read_only(between.length * wall.thickness)
    i, j = (read_only(side[joint], np.int64) for side in (body_i, body_j))
    interfaces = replace(between, i=i, j=j, area=area, **strengths)
    compliant = pressed_edges.compliances(wall, between, elastic_modulus)
    bond_toe = pressed_edges.under_bond(between, compliant, softening)
    turns = np.zeros((len(joint), 2)) if hinges is None else hinges[joint]
    toe, column = None, None
    if forces is not None:
        normal = np.maximum(forces[: assemblage.joints.count, :2], 0.0).sum(axis=1)
        columns = pressed_edges.columns_on(wall, assemblage.joints, normal)
        soft = columns.height[joint] * compliant.sum(axis=1) * between.length / between.area
        toe, column = _toes(forces[joint], interfaces, wall, bond_toe, soft, columns.width[joint])
    return Bodies(
        bodies=tuple(_body(number, assemblage, partition, of_body) for number, of_body in enumerate(rings)),
        moving=partition.count,
        thickness=wall.thickness,
        interfaces=interfaces,
        joint=read_only(joint, np.int64),
        edge_i=read_only([place[b][e] for b, e in zip(i, edge[joint].tolist(), strict=True)], np.int64),
        edge_j=read_only([place[b][e] for b, e in zip(j, edge[joint].tolist(), strict=True)], np.int64),
        mean_stone=_mean_stone(wall),
        bond_toe=read_only(bond_toe),
        hinge=read_only(turns),
        toe=toe,
        column=column,
    )


def _mean_stone(wall: Wall) -> float:
    area = block_areas(wall)[[not block.fixed for block in wall.blocks]]
    return float(area @ np.sqrt(area) / area.sum())


def _toes(
    forces: FloatArray, interfaces: Interfaces, wall: Wall, bond_toe: FloatArray, soft: FloatArray, width: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return over what length (k, 2) in m joints under `forces` (k, 3) are pressed at their start and at their end, and
    the width (k,) of columns that lean on them, inf where none does; soft, width (k,): of columns there, soft as
    `under_column` has it, 0 where none is.

    Where a joint crushes, a normal force N takes x = N / (f_c t), with its resultant at x / 2 from the end. Mortar of
    stiffness k under what leans, h high, is pressed over x = (6 N h / (k t))^(1/3) when that bears most, with the
    resultant at x / 3: leaning takes as much as the resultant's distance from the end (Winkler's bed without tension).
    A bond that has all its strength pulls at both ends alike, and what is pressed bears it too (pressed_edges.py).
    """
    pulled = 0.5 * interfaces.tensile_strength * interfaces.area
    normal = np.maximum(forces[:, :2] + pulled[:, None], 0.0)
    top = max(block.polygon[:, 1].max() for block in wall.blocks if not block.fixed)
    total = normal.sum(axis=1, keepdims=True)
    high = np.maximum(top - 0.5 * (interfaces.start + interfaces.end)[:, 1:], 0.0)
    crushed = total / (interfaces.compressive_strength * wall.thickness)[:, None]
    pressed = np.cbrt(6.0 * total * high / (interfaces.normal_stiffness * wall.thickness)[:, None])
    distance = interfaces.length[:, None] * normal[:, ::-1] / np.where(total > 0.0, total, 1.0)
    leaning = pressed_edges.under_column(total, soft[:, None])
    leaning = np.where(leaning > LEANS * width[:, None], np.minimum(leaning, interfaces.length[:, None]), 0.0)
    lengths = (1 / 2, crushed), (1 / 3, pressed), (1 / 3, bond_toe[:, None]), (1 / 3, leaning)
    toes = [np.where(distance <= NEAR_A_TOE * part * x, x, 0.0) for part, x in lengths]
    toes[-1] = toes[-1].max(axis=1, keepdims=True) + np.zeros_like(distance)  # under its dead load it may lean back
    return read_only(np.max(toes, axis=0)), read_only(np.where(toes[-1].any(axis=1), width, np.inf))


def glued(assemblage: Assemblage, blocks: IntArray) -> Wall:
    """Return the wall in which each of `blocks` is one with the neighbour that it has the longest joints with, of those
    that are not loose themselves if there is one; a block that only supports touch stays. Raises CaseError where a body
    with a hole would come of it.
    """
    wall, joints = assemblage.wall, assemblage.joints
    group = np.arange(len(wall.blocks))
    fixed = np.array([block.fixed for block in wall.blocks])
    for block in blocks.tolist():
        mine = (joints.i == block) | (joints.j == block)
        other = np.where(joints.i == block, joints.j, joints.i)
        mine &= ~fixed[other] & (group[other] != group[block])
        firm = mine & ~np.isin(other, blocks)
        mine = firm if firm.any() else mine
        if mine.any():
            together = np.bincount(other[mine], joints.length[mine])
            group[group == group[block]] = group[int(np.argmax(together))]
    assert assemblage.outlines is not None, "an assemblage without its planar map has no bodies"
    numbers = np.unique(group, return_inverse=True)[1]
    rings = _rings(assemblage.outlines, numbers, np.zeros(len(assemblage.outlines.left), bool))
    kept = np.unique(numbers)
    keep = [int(np.flatnonzero((numbers == k) & (group == np.arange(len(group))))[0]) for k in kept]
    if any(len(rings[k]) > 1 for k in kept):
        raise CaseError("--loose", "a loose stone would close a ring round others", "use --loose drop")
    united = [replace(wall.blocks[b], polygon=read_only(rings[k][0].points)) for k, b in zip(kept, keep, strict=True)]
    ids = {block.id for block in united}
    return replace(wall, blocks=tuple(united), mortar=tuple(m for m in wall.mortar if {m.i, m.j} <= ids))


@dataclass(frozen=True, eq=False, slots=True)
class _Ring:
    """A closed outline: points (n, 2) in m, the body on their left; the edge of the planar map that begins at each."""

    points: FloatArray
    edge: tuple[int, ...]


def _rings(outlines: PlanarMap, body_of_block: IntArray, is_interface: BoolArray) -> list[list[_Ring]]:
    """Return the rings of every body, the exterior first."""
    left = body_of_block[outlines.left]
    right = np.where(outlines.right == NO_BLOCK, NO_BLOCK, body_of_block[outlines.right])
    edge = np.arange(len(left))
    sides = [(edge, left, outlines.start, outlines.end), (edge, right, outlines.end, outlines.start)]
    keep = [(left != right), (left != right) & (right != NO_BLOCK)]
    number, body, start, end = (
        np.concatenate([side[k][kept] for side, kept in zip(sides, keep, strict=True)]) for k in range(4)
    )
    blocks = (np.flatnonzero(body_of_block == b)[0] for b in range(int(body_of_block.max()) + 1))
    rings = []
    for b, block in enumerate(blocks):
        rows = np.flatnonzero(body == b)
        loops = _loops(outlines.vertex, start[rows], end[rows])
        rings.append(
            _exterior_first(
                [
                    _simplified(outlines, number[rows[loop]], start[rows[loop]], is_interface, outlines.ring(block))
                    for loop in loops
                ]
            )
        )
    return rings


def _loops(vertex: FloatArray, start: IntArray, end: IntArray) -> list[list[int]]:
    """Return the directed edges start -> end (r,) as closed loops of their numbers.

    Where a body touches itself in a point, the loop goes on along the same void, the first edge counter-clockwise from
    the one it came by: a hole that is closed by that point stays a hole.
    """
    leaving: dict[int, list[int]] = {}
    for k, v in enumerate(start.tolist()):
        leaving.setdefault(v, []).append(k)
    loops, left = [], set(range(len(start)))
    while left:
        loop = [min(left)]
        while True:
            left.discard(loop[-1])
            here = int(end[loop[-1]])
            ways = [k for k in leaving[here] if k in left or k == loop[0]]
            following = ways[0] if len(ways) == 1 else min(ways, key=partial(_turn, vertex, start, end, loop[-1]))
            if following == loop[0]:
                break
            loop.append(following)
        loops.append(loop)
    return loops


def _turn(vertex: FloatArray, start: IntArray, end: IntArray, coming: int, leaving: int) -> float:
    """Return the angle (0, 2 pi] counter-clockwise from the edge `coming`, seen backwards, to the edge `leaving`."""
    back, on = vertex[start[coming]] - vertex[end[coming]], vertex[end[leaving]] - vertex[start[leaving]]
    angle = float(np.arctan2(cross(back, on), back @ on))
    return angle if angle > 0 else angle + 2 * np.pi


def _simplified(
    outlines: PlanarMap, edge: IntArray, start: IntArray, is_interface: BoolArray, first_block: IntArray
) -> _Ring:
    """Return the ring without vertices where it goes straight on and no joint ends; it begins at a corner of the first
    block (vertices `first_block` of its outline) if it has one."""
    points = outlines.vertex[start]
    before, after = np.roll(points, 1, axis=0), np.roll(points, -1, axis=0)
    chord, arm = after - before, points - before
    height = np.abs(cross(chord, arm)) / np.linalg.norm(chord, axis=1)
    shorter = np.minimum(np.linalg.norm(arm, axis=1), np.linalg.norm(after - points, axis=1))
    corner = ~(height < STRAIGHT_HEIGHT * shorter)  # also where the neighbours coincide (a spike would be a corner)
    joint = is_interface[edge]
    kept = np.flatnonzero(corner | joint | np.roll(joint, 1))
    on_ring = {int(start[k]): n for n, k in enumerate(kept)}
    begin = next((on_ring[v] for v in first_block.tolist() if v in on_ring), 0)
    kept = np.roll(kept, -begin)
    return _Ring(points[kept], tuple(edge[kept].tolist()))


def _exterior_first(rings: list[_Ring]) -> list[_Ring]:
    return sorted(rings, key=lambda ring: -polygon_area(ring.points))


def _body(number: int, assemblage: Assemblage, partition: Partition, rings: list[_Ring]) -> Body:
    wall, blocks = assemblage.wall, np.flatnonzero(partition.body_of_block == number)
    stones = [wall.blocks[k] for k in blocks]
    areas = [polygon_area(stone.polygon) for stone in stones]
    thinner = [1.0 if stone.thickness is None else stone.thickness / wall.thickness for stone in stones]
    volumes = [area * part for area, part in zip(areas, thinner, strict=True)]
    return Body(
        number=number,
        name=_name(wall, blocks),
        exterior=read_only(rings[0].points),
        holes=tuple(read_only(ring.points) for ring in rings[1:]),
        fixed=stones[0].fixed,
        unit_weight=float(np.dot(volumes, [stone.unit_weight for stone in stones]) / sum(areas)),
        blocks=read_only(blocks, np.int64),
        parts=_parts(stones, volumes, sum(areas)),
    )


def _parts(stones: list[Block], volumes: list[float], whole: float) -> tuple[Part, ...]:
    """Return the parts of a body whose stones fill `volumes` of its `whole` one: exactly 1 where they are all alike."""
    filled: dict[tuple[float | None, float | None], float] = {}
    for stone, volume in zip(stones, volumes, strict=True):
        constants = (stone.elastic_modulus, stone.poisson_ratio)
        filled[constants] = filled.get(constants, 0.0) + volume
    return tuple(Part(volume / whole, *constants) for constants, volume in filled.items())


def _name(wall: Wall, blocks: IntArray) -> str:
    """Return what messages call the body."""
    first = wall.blocks[blocks[0]]
    if first.fixed:
        return "the support"
    return f"block {first.id}" if len(blocks) == 1 else f"the macroblock of block {first.id}"
