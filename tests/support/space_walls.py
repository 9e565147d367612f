"""Blocks in space for the tests: a block on the ground in any position, plane walls as prisms, and one call to
analyse."""

from __future__ import annotations

import numpy as np

from orchestrator.basis.arrays import read_only
from orchestrator.geometry.polyhedra import Polyhedron, box, prism, rotation, volume_of
from orchestrator.space.conic_program import ConicSolution, solve_associative
from orchestrator.space.contacts import SpaceAssemblage, find_joints
from orchestrator.space.equilibrium import SpaceEquilibrium, equilibrium_of
from orchestrator.space.generators.shapes import Stones
from orchestrator.space.loads import SpaceLoads, SpaceLoadSettings, loads_on
from orchestrator.space.wall import UPRIGHT, SpaceBlock, SpaceWall

GROUND = box((-5.0, -5.0, -1.0), (5.0, 5.0, 0.0))
CUBE = box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
L_SHAPE = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]]


def wall_of(shapes: list[Polyhedron], friction: float, supports: int = 1, up=UPRIGHT) -> SpaceWall:
    """The first `supports` shapes stand still."""
    blocks = tuple(SpaceBlock(k, shape, fixed=k < supports) for k, shape in enumerate(shapes))
    return SpaceWall("test", blocks, friction, read_only(up))


def block_on_ground(x: float, y: float, h: float, friction: float) -> SpaceWall:
    return wall_of([GROUND, box((-x / 2, -y / 2, 0.0), (x / 2, y / 2, h))], friction)


def record(**changes) -> dict:
    """Return the block file of a prism of 2 x 0.1 x 0.6 m and a box of 0.5 x 0.5 x 0.2 m on it, in mm."""
    return {
        "units": {"length": "mm", "unit_weight": "kN/m3"}, "unit_weight": 20, "friction": 0.6,
        "blocks": [
            {"id": 0, "polygon": [[-500, -100], [1500, -100], [1500, 0], [-500, 0]], "thickness": 600, "fixed": True},
            {
                "id": 1, "vertices": (1e3 * CUBE.vertices * [0.5, 0.5, 0.2]).tolist(),
                "faces": [list(face) for face in CUBE.faces],
            },
        ],
    } | changes  # fmt: skip


def block_file_of(shapes: list[Polyhedron], friction: float = 0.6, **changes) -> dict:
    """Return the block file (m, 20 kN/m3) of shapes, of which the first stands still."""
    blocks = [
        {"id": k, "vertices": shape.vertices.tolist(), "faces": [list(face) for face in shape.faces]}
        for k, shape in enumerate(shapes)
    ]
    blocks[0]["fixed"] = True
    units = {"length": "m", "unit_weight": "kN/m3"}
    return {"units": units, "unit_weight": 20, "friction": friction, "blocks": blocks} | changes


def extruded(polygon, depth: float, start: float = 0.0) -> Polyhedron:
    """A polygon in the x-z plane, extruded along y."""
    axes = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, depth, 0.0]])
    return prism(np.array(polygon, dtype=float), np.array([0.0, start, 0.0]), axes)


def v_groove(half_angle: float, friction: float, length: float = 4.0) -> SpaceWall:
    """A prism along y in a groove whose sides make `half_angle` (rad) with the vertical."""
    s, c = np.sin(half_angle), np.cos(half_angle)
    left, right = [-s, c], [s, c]
    ground = [[0.0, 0.0], right, [2 * s, c], [2 * s, -0.5], [-2 * s, -0.5], [-2 * s, c], left]
    return wall_of([extruded(ground, length + 8.0, -4.0), extruded([[0.0, 0.0], right, left], length)], friction)


def turned(wall: SpaceWall, axis=(1.0, 2.0, 3.0), degrees: float = 37.0) -> tuple[SpaceWall, np.ndarray]:
    turn = rotation(axis, np.radians(degrees))
    return wall.moved(turn, np.array([0.3, -0.2, 0.7])), turn


def associative(wall: SpaceWall, direction, torsion="corners", **loads) -> ConicSolution:
    assemblage = find_joints(wall)
    return of_assemblage(assemblage, direction, torsion, **loads)


def of_assemblage(assemblage: SpaceAssemblage, direction, torsion="corners", **loads) -> ConicSolution:
    settings = SpaceLoadSettings(direction=direction, **loads)
    return solve_associative(equilibrium_of(assemblage, loads_on(assemblage.wall, settings), torsion))


class _Couple(SpaceEquilibrium):
    """The live load is a couple: its forces sum to nothing, so it is scaled by a moment instead."""

    @property
    def live_total(self) -> float:
        return float(np.abs(self.live_load).sum())


def twist(ratio: float, torsion: str) -> float:
    """The couple that twists a block of short side b and `ratio` times that on its bed, over mu N b."""
    short = 0.3
    return couple_that_twists(block_on_ground(ratio * short, short, 0.2, 0.4), torsion) / short


def couple_that_twists(wall: SpaceWall, torsion: str) -> float:
    """The couple about the vertical that twists the one free block of a wall, over mu N, m."""
    assemblage = find_joints(wall)
    (free,) = np.flatnonzero(~wall.fixed)
    loads, couple = loads_on(assemblage.wall), np.zeros((len(wall.blocks), 6))
    couple[free, 5] = 1.0
    equilibrium = equilibrium_of(assemblage, SpaceLoads(loads.dead, couple, loads.direction), torsion)
    fields = {name: getattr(equilibrium, name) for name in equilibrium.__dataclass_fields__}
    return solve_associative(_Couple(**fields)).load_multiplier / (wall.friction * wall.weights[free])


def hollow_pier(outer: float, inner: float, height: float = 0.5) -> Polyhedron:
    """A square pier with a square hole through it, sides in m, whose top is at zero: its top is four trapezia."""
    square = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    rings = [(outer, -height), (outer, 0.0), (inner, -height), (inner, 0.0)]
    vertices = np.vstack([np.column_stack([side * square, np.full(4, z)]) for side, z in rings])
    sides = [(k, (k + 1) % 4) for k in range(4)]
    around = [(k, n, n + 4, k + 4) for k, n in sides] + [(n + 8, k + 8, k + 12, n + 12) for k, n in sides]
    flat = [(k + 4, n + 4, n + 12, k + 12) for k, n in sides] + [(n, k, k + 8, n + 8) for k, n in sides]
    return Polyhedron(read_only(vertices), (*around, *flat))


WITHOUT_DILATION = [
    (block_on_ground(0.4, 0.2, 1.0, 0.7), "+x", 0.4),
    (block_on_ground(0.4, 0.2, 1.0, 0.7), (0.5, 0.75**0.5, 0.0), 0.230940),
    (block_on_ground(1.0, 0.7, 0.1, 0.53), (0.6, 0.8, 0.0), 0.53),
    (v_groove(np.radians(45), 0.5), "+y", 0.707107),
    (v_groove(np.radians(60), 0.5), "+y", 0.577350),
]
"""wall, direction and multiplier: overturning x / (h cos psi), sliding mu, a groove mu / sin b.

The associative multipliers of the grooves are 0.816497 and 0.603023.
"""


def between_floors(courses: int, stones: Stones, load: float, turning: bool) -> SpaceWall:
    """A wall one stone long between a ground and a slab of `load` times the wall's weight, for checks.

    The slab is guided by four walls without friction: it may rise, but not move sideways; `turning`: it stands on a
    narrow foot on the wall's axis, so that the wall's top turns freely, else it is wide and cannot turn.
    """
    length, t, h = stones.length, stones.thickness, stones.height
    blocks = [SpaceBlock(0, box((-length, -t, -h), (2 * length, 2 * t, 0.0)), fixed=True)]
    for k in range(courses):
        shape = box((0.0, 0.0, k * h), (length, t, (k + 1) * h))
        blocks.append(SpaceBlock(len(blocks), shape, unit_weight=stones.unit_weight))
    top, weight = courses * h, courses * length * t * h * stones.unit_weight
    foot, half = (1e-4 * t, 0.5 * t) if turning else (2.0 * t, 2.0 * t)
    outline = np.array([[-foot, 0.0], [foot, 0.0], [half, 0.5 * h], [half, h], [-half, h], [-half, 0.5 * h]])
    slab = prism(
        outline, np.array([0.0, 0.5 * t, top]), np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [length, 0.0, 0.0]])
    )
    blocks.append(SpaceBlock(len(blocks), slab, unit_weight=load * weight / volume_of(slab)))
    for y0, y1 in ((0.5 * t - half - h, 0.5 * t - half), (0.5 * t + half, 0.5 * t + half + h)):
        shape = box((-length, y0, top + 0.25 * h), (2 * length, y1, top + 5 * h))
        blocks.append(SpaceBlock(len(blocks), shape, fixed=True, friction=1e-8))
    return SpaceWall("wall between floors", tuple(blocks), stones.friction, read_only(UPRIGHT))


def cut_by_planes(seed: int, cuts: int) -> list[Polyhedron]:
    """A block of 1.2 x 0.35 x 1.2 m on the ground in the parts that planes cut it into, each through the largest part,
    level or upright but for a lean of 0.25 at random."""
    chance, parts = np.random.default_rng(seed), [box((0.0, 0.0, 0.0), (1.2, 0.35, 1.2))]
    for _ in range(cuts):
        part = parts.pop(int(np.argmax([volume_of(one) for one in parts])))
        extent = np.ptp(part.vertices, axis=0)
        normal = np.eye(3)[0 if extent[0] > extent[2] else 2] + chance.uniform(-0.25, 0.25, 3)
        parts += [behind(part, normal, level=normal @ part.vertices.mean(axis=0), side=side) for side in (1.0, -1.0)]
    return parts


def behind(body: Polyhedron, normal: np.ndarray, level: float, side: float) -> Polyhedron:
    """The part of a convex body in which side (normal . x - level) <= 0."""
    height, corners, faces = side * (body.vertices @ normal - level), list[np.ndarray](), list[tuple[int, ...]]()
    numbers = dict[tuple[int, int], int]()

    def number_of(one: int, other: int) -> int:
        """The corner where the plane cuts an edge, or that of the body where both are one."""
        key = (min(one, other), max(one, other))
        if key not in numbers:
            part = 0.0 if one == other else height[key[0]] / (height[key[0]] - height[key[1]])
            corners.append((1.0 - part) * body.vertices[key[0]] + part * body.vertices[key[1]])
            numbers[key] = len(corners) - 1
        return numbers[key]

    rim = dict[int, int]()
    for face in body.faces:
        ring, cut = [], dict[bool, int]()
        for one, other in zip(face, (*face[1:], face[0]), strict=True):
            if height[one] <= 0.0:
                ring.append(number_of(one, one))
            if (height[one] <= 0.0) is not (height[other] <= 0.0):
                ring.append(number_of(one, other))
                cut[bool(height[other] > 0.0)] = ring[-1]  # True: where the face leaves the part
        if len(ring) > 2:
            faces.append(tuple(ring))
        if cut:
            rim[cut[False]] = cut[True]
    start = next(iter(rim))
    lid = [start]
    while (following := rim[lid[-1]]) != start:
        lid.append(following)
    return Polyhedron(read_only(corners), (*faces, tuple(lid)))
