"""Bodies: the outlines of a partition, with holes, and what remains of the joints between them.

Both sides of a joint must have a vertex where the joint ends, or a slave node there finds no master node: without these
imprinted vertices a wall of one element per stone loses 39 % of its capacity.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import shapely

from orchestrator.joints import Assemblage
from orchestrator.macroblocks import Partition
from orchestrator.masonry.wall import Block, FloatArray, IntArray, Wall, read_only

TOLERANCE = 2e-5
"""distance within which a point lies on an outline, m (twice what joints accept: drawings are rounded)"""


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

    Every end of a joint that lies on the outline is a vertex of it (imprinted), on both sides of the joint.
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
    """Bodies of one thickness (m), moving ones first, and their k interfaces, each a straight segment.

    body_i, body_j (k,), start, end (k, 2) in m (convention of joints.py: start -> end is counter-clockwise round i, the
    normal points from i to j), friction (k,), joint (k,): the joint of the assemblage it comes from; cohesion,
    tensile_strength (k,) in N/m2 of the wall's thickness (less than the joint's own where a thinner block meets it),
    where one number stands for all.
    """

    bodies: tuple[Body, ...]
    moving: int
    thickness: float
    body_i: IntArray
    body_j: IntArray
    start: FloatArray
    end: FloatArray
    friction: FloatArray
    joint: IntArray
    cohesion: FloatArray = field(default_factory=lambda: read_only(0.0))
    tensile_strength: FloatArray = field(default_factory=lambda: read_only(0.0))

    def __post_init__(self) -> None:
        for name in ("cohesion", "tensile_strength"):
            each = np.broadcast_to(getattr(self, name), self.friction.shape)
            object.__setattr__(self, name, read_only(each))


def make_bodies(assemblage: Assemblage, partition: Partition) -> Bodies:
    """Return the outlines of all bodies and the joints that remain between them."""
    body_i, body_j = partition.body_of_block[assemblage.block_i], partition.body_of_block[assemblage.block_j]
    joint = np.flatnonzero(body_i != body_j)
    ends = np.concatenate([assemblage.start[joint], assemblage.end[joint]])
    owner = np.column_stack([np.tile(body_i[joint], 2), np.tile(body_j[joint], 2)])
    bodies = tuple(
        _body(
            number, assemblage.wall, np.flatnonzero(partition.body_of_block == number), ends[(owner == number).any(1)]
        )
        for number in range(int(partition.body_of_block.max()) + 1)
    )
    share = assemblage.width / assemblage.wall.thickness
    return Bodies(
        bodies=bodies,
        moving=partition.count,
        thickness=assemblage.wall.thickness,
        body_i=read_only(body_i[joint], np.int64),
        body_j=read_only(body_j[joint], np.int64),
        start=read_only(assemblage.start[joint]),
        end=read_only(assemblage.end[joint]),
        friction=read_only(assemblage.friction[joint]),
        joint=read_only(joint, np.int64),
        cohesion=read_only(assemblage.cohesion[joint] * share[joint]),
        tensile_strength=read_only(assemblage.tensile_strength[joint] * share[joint]),
    )


def _body(number: int, wall: Wall, blocks: IntArray, joint_ends: FloatArray) -> Body:
    """Return the union of `blocks` with `joint_ends` (p, 2) imprinted."""
    stones = [wall.blocks[k] for k in blocks]
    areas = [shapely.Polygon(stone.polygon).area for stone in stones]
    thinner = [1.0 if stone.thickness is None else stone.thickness / wall.thickness for stone in stones]
    volumes = [area * part for area, part in zip(areas, thinner, strict=True)]
    outline = _union([stone.polygon for stone in stones])
    rings = [_with_vertices(np.array(ring.coords)[:-1], joint_ends) for ring in (outline.exterior, *outline.interiors)]
    area = shapely.Polygon(rings[0], rings[1:]).area
    assert abs(area - sum(areas)) < 1e-6 * area + TOLERANCE * outline.length, f"body {number} lost area"
    return Body(
        number=number,
        name=_name(wall, blocks),
        exterior=read_only(_oriented(rings[0], counter_clockwise=True)),
        holes=tuple(read_only(_oriented(ring, counter_clockwise=False)) for ring in rings[1:]),
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


def _union(polygons: list[FloatArray]) -> shapely.Polygon:
    """Return the union as one polygon; gaps of rounding size between stones are closed.

    A body that touches itself in a point round an opening keeps that opening as a hole. Blocks of one body share a
    joint, so their union is always one piece.
    """
    if len(polygons) == 1:
        return shapely.Polygon(polygons[0])
    union = shapely.union_all([shapely.Polygon(polygon) for polygon in polygons], grid_size=1e-9)
    if union.geom_type == "Polygon" and all(shapely.Polygon(hole).area > TOLERANCE**2 for hole in union.interiors):
        return union
    grown = shapely.union_all([shapely.Polygon(p).buffer(TOLERANCE, join_style="mitre") for p in polygons])
    closed = grown.buffer(-TOLERANCE, join_style="mitre")
    assert closed.geom_type == "Polygon", "blocks of one body do not share a joint"
    return closed


def _with_vertices(ring: FloatArray, points: FloatArray) -> FloatArray:
    """Return the ring (n, 2) with those `points` (p, 2) that lie on it as vertices, and no other collinear vertices."""
    pieces = [
        np.vstack([start, _between(start, end, points)]) for start, end in zip(ring, np.roll(ring, -1, 0), strict=True)
    ]
    vertices = np.concatenate(pieces)
    wanted = _distances(vertices, points).min(axis=1, initial=np.inf) < TOLERANCE
    return vertices[wanted | _is_corner(vertices)]


def _between(start: FloatArray, end: FloatArray, points: FloatArray) -> FloatArray:
    """Return the points (m, 2) on the open edge start -> end, in order, each once."""
    length = np.linalg.norm(end - start)
    tangent = (end - start) / length
    position = (points - start) @ tangent
    distance = np.abs((points - start) @ np.array([tangent[1], -tangent[0]]))
    on = (distance < TOLERANCE) & (position > TOLERANCE) & (position < length - TOLERANCE)
    places = np.sort(position[on])
    places = places[np.diff(places, prepend=-np.inf) > TOLERANCE]
    return start + places[:, None] * tangent


def _is_corner(vertices: FloatArray) -> np.ndarray:
    """Return where the outline turns by more than rounding: distance of a vertex from the chord of its neighbours."""
    before, after = np.roll(vertices, 1, axis=0), np.roll(vertices, -1, axis=0)
    chord, arm = after - before, vertices - before
    height = np.abs(chord[:, 0] * arm[:, 1] - chord[:, 1] * arm[:, 0]) / np.linalg.norm(chord, axis=1)
    return ~(height < TOLERANCE)  # also true where the neighbours coincide (a spike would be a corner)


def _distances(first: FloatArray, second: FloatArray) -> FloatArray:
    return np.linalg.norm(first[:, None] - second[None], axis=2)


def _oriented(ring: FloatArray, counter_clockwise: bool) -> FloatArray:
    return ring if shapely.LinearRing(ring).is_ccw == counter_clockwise else ring[::-1]
