"""Loads on blocks in space: dead (weight, forces, line loads, thrusts) and live (what lambda multiplies).

dead    weight along -up; extra dead loads, along -up or in a direction of their own (the thrust of a roof)
live    masses x direction; "mass_height" multiplies by the height above the base, scaled to the same resultant;
        "per_block" are given forces at the centroids of the blocks named
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import shapely
from annotated_types import Ge, Gt, Le

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray, read_only
from orchestrator.basis.checked import Checked
from orchestrator.basis.errors import CaseError
from orchestrator.basis.units import Unit
from orchestrator.geometry.polyhedra import FLAT, Polyhedron, centroid_of, face_normals
from orchestrator.loads.block_loads import Distribution, LiveLoad, if_upright, refuse_blocks_that_cannot_move
from orchestrator.loads.dead_loads import AT_LEVEL
from orchestrator.masonry.block_properties import refuse_beyond_weight
from orchestrator.space.wall import SpaceWall

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
UPWARD = 0.5
"""upward part of the normal of a face above which it is of the top"""
AHEAD = "+x"
"""direction of a live load that is given none"""
LEVEL_WITHIN = 1e-9
"""downward part of a unit vector up to which a force along it is a thrust and no weight"""
UPRIGHT_WITHIN = 1e-9
"""horizontal part of a unit vector below which it has no direction in plan"""


@dataclass(frozen=True, slots=True)
class SpaceDeadLoad(Checked):
    """Extra dead load on blocks: a force on each, or a line load along their tops (one of the two).

    The blocks are named, or those whose tops lie at a level: a floor that rests on a course."""

    blocks: tuple[int, ...] = ()
    """ids of the blocks"""
    force: Annotated[float, Gt(0), Unit("N")] | None = None
    """on each block, at the middle of its top"""
    line_load: Annotated[float, Gt(0), Unit("N/m")] | None = None
    """on each block's top, at its middle, per horizontal metre along the wall"""
    direction: tuple[float, ...] = ()
    """of the force; left out: downwards. A horizontal one is the thrust of a roof or a vault"""
    inertia: bool = False
    """whether the live load acts on its mass too, that of its downward part, where it stands"""
    level: Annotated[float, Unit("m")] | None = None
    """height of the blocks' tops, or of a step in them, instead of `blocks`"""


@dataclass(frozen=True, slots=True)
class SpaceLoadSettings(Checked):
    """Direction and distribution of the live load in space; extra dead loads."""

    direction: str | tuple[float, ...] | None = None
    """"+x", "-x", "+y", "-y", "+z", "-z", or a vector such as [0, -1, 0]; its length does not matter. Left out: +x"""
    angle: Annotated[float, Unit("rad")] | None = None
    """instead of `direction`: in plan, from the first horizontal axis to the second, as in "45 deg"; numbers are rad"""
    distribution: Distribution = "mass"
    """proportional to mass, to mass x height above the base, or as given in [[load.live]]"""
    live: tuple[LiveLoad, ...] = ()
    """forces on named blocks, each a table [[load.live]]; for "per_block" only"""
    dead: tuple[SpaceDeadLoad, ...] = ()
    """besides weight, each a table [[load.dead]]"""
    directions: Annotated[int, Ge(0), Le(360)] = 0
    """besides, so many directions in plan all round: table and polar plot of the multiplier"""


@dataclass(frozen=True, eq=False, slots=True)
class SpaceLoads:
    """dead, live (n, 6): force (N) and moment about the centroid (N m) on each block, live at a load multiplier of 1;
    direction (3,): unit vector of the live load."""

    dead: FloatArray
    live: FloatArray
    direction: FloatArray

    def base_shear(self, up: FloatArray) -> float:
        """Return the horizontal resultant of the live load at a load multiplier of 1, N; up (3,): of the wall."""
        resultant = self.live[:, :3].sum(axis=0)
        return float(np.linalg.norm(resultant - (resultant @ up) * up))

    def upright(self, up: FloatArray) -> float | None:
        """Return the vertical live load at a multiplier of 1 in N, upwards, where none of it is horizontal."""
        return if_upright(self.base_shear(up), float(self.live[:, :3].sum(axis=0) @ up))


@dataclass(frozen=True, eq=False, slots=True)
class SpaceMasses:
    """What has mass: block (k,) by position, point (k, 3) where it is, weight (k,) in N; own (k,): whether it is the
    block's own, not one that rests on it."""

    block: IntArray
    point: FloatArray
    weight: FloatArray
    own: BoolArray


def direction_of(settings: SpaceLoadSettings, up: FloatArray) -> FloatArray:
    """Return the unit vector (3,) of the live load. Raises CaseError."""
    if settings.angle is not None:
        first, second = plan_axes(up)
        return math.cos(settings.angle) * first + math.sin(settings.angle) * second
    return unit_vector(AHEAD if settings.direction is None else settings.direction, "load.direction")


def angles_of(direction: FloatArray, up: FloatArray) -> tuple[float | None, float]:
    """Return the angle of a unit vector (3,) in plan, from the first horizontal axis towards the second, None for an
    upright one, and above the horizontal; rad."""
    first, second = (float(direction @ axis) for axis in plan_axes(up))
    flat, rise = math.hypot(first, second), float(direction @ up)
    return (math.atan2(second, first) if flat > UPRIGHT_WITHIN else None), math.atan2(rise, flat)


def plan_axes(up: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return two horizontal unit vectors that make a right-handed frame with `up`: x and y where z is up, x and -z
    where y is."""
    least = np.eye(3)[int(np.abs(up[0]) > 0.9)]
    first = least - (least @ up) * up
    first /= np.linalg.norm(first)
    return first, np.cross(up, first)


def unit_vector(direction: str | Sequence[float], key: str) -> FloatArray:
    """Return a direction as unit vector (3,). Raises CaseError naming `key`."""
    remedy = 'write "+x", "-y", "+z" or a vector of three numbers, as in [0, -1, 0]'
    if isinstance(direction, str):
        sign, axis = {"+": 1.0, "-": -1.0}.get(direction[:1]), AXES.get(direction[1:])
        if sign is None or axis is None:
            raise CaseError(key, f"{direction!r} is no direction", remedy)
        return sign * np.array(axis)
    vector = np.array(direction, dtype=float)
    length = float(np.linalg.norm(vector))
    if vector.shape != (3,) or not 0 < length < np.inf:
        raise CaseError(key, f"{[*direction]} is no direction", remedy)
    return vector / length


def loads_on(wall: SpaceWall, settings: SpaceLoadSettings | None = None) -> SpaceLoads:
    """Return the loads on a wall: by default its weight, and the same forces along +x. Raises CaseError."""
    settings = settings or SpaceLoadSettings()
    _refuse_contradictions(wall, settings)
    direction, centroids = direction_of(settings, wall.up), wall.centroids
    dead, live = np.zeros((len(wall.blocks), 6)), np.zeros((len(wall.blocks), 6))
    dead[:, :3] = -np.outer(wall.weights, wall.up)
    for k, point, force, _ in placed_dead_loads(wall, settings):
        dead[k] += _wrench(force, point - centroids[k])
    acting = _acting(wall, settings)
    size = acting.weight
    if settings.distribution == "mass_height":
        base = min(float((b.shape.vertices @ wall.up).min()) for b in wall.blocks if not b.fixed)
        lever = size * (acting.point @ wall.up - base)
        size = lever * size.sum() / lever.sum()
    for k, point, force in zip(acting.block, acting.point, size, strict=True):
        live[k] += _wrench(force * direction, point - centroids[k])
    return SpaceLoads(read_only(dead), read_only(live), read_only(direction))


def masses_on(wall: SpaceWall, settings: SpaceLoadSettings) -> SpaceMasses:
    """Return the masses of the free blocks, and of the dead loads that have inertia, where these act: what is above
    weighs on a block by the downward part of its force, and leans on it by the rest, which has no mass."""
    free = np.flatnonzero(~wall.fixed)
    extra = [(k, point, -force @ wall.up) for k, point, force, inertia in placed_dead_loads(wall, settings) if inertia]
    return SpaceMasses(
        block=np.array([*free, *(k for k, _, _ in extra)], dtype=np.int64),
        point=np.vstack([wall.centroids[free], *(point for _, point, _ in extra)]),
        weight=np.array([*wall.weights[free], *(size for _, _, size in extra)]),
        own=np.arange(len(free) + len(extra)) < len(free),
    )


def _acting(wall: SpaceWall, settings: SpaceLoadSettings) -> SpaceMasses:
    """Return what the live load acts on: the masses, or the forces given at the centroids of blocks."""
    if settings.distribution != "per_block":
        return masses_on(wall, settings)
    place = wall.place_of
    given = [(place[wanted], one.force) for one in settings.live for wanted in one.blocks]
    block = np.array([k for k, _ in given], dtype=np.int64)
    weight = np.array([force for _, force in given])
    return SpaceMasses(block, wall.centroids[block], weight, np.zeros(len(given), dtype=bool))


def placed_dead_loads(
    wall: SpaceWall, settings: SpaceLoadSettings
) -> Iterator[tuple[int, FloatArray, FloatArray, bool]]:
    """Yield block, point, force (N) of every extra dead load, and whether it has inertia."""
    for number, load in enumerate(settings.dead):
        along = _along(wall, load, number)
        for k in _loaded(wall, load):
            point, length = top_of(wall, k, load.level)
            yield k, point, _size(load, length) * along, load.inertia


def _along(wall: SpaceWall, load: SpaceDeadLoad, number: int) -> FloatArray:
    """Return the unit vector (3,) of an extra dead load. Raises CaseError."""
    return unit_vector(load.direction, f"load.dead.{number}.direction") if load.direction else -wall.up


def _wrench(force: FloatArray, arm: FloatArray) -> FloatArray:
    return np.concatenate([force, np.cross(arm, force)])


def top_of(wall: SpaceWall, block: int, level: float | None = None) -> tuple[FloatArray, float]:
    """Return the middle (3,) of a block's top, by area, and the top's horizontal length (m) along the wall.

    The top is all of the surface that looks up in the plane of the highest such face, in however many faces it comes,
    or of the highest of those at a level (m), where there are such: a step in the top;
    a body that ends in an edge has its centroid and no length. Where the wall's direction is not known it is that of
    the long side of the smallest rectangle around the top.
    """
    shape, along = wall.blocks[block].shape, wall.blocks[block].along
    normals = face_normals(shape)
    rings = [shape.vertices[list(face)] for face in shape.faces]
    upward = [k for k in range(len(rings)) if normals[k] @ wall.up > UPWARD]
    if not upward:
        return centroid_of(shape), 0.0
    stepped = [] if level is None else [k for k in upward if _near(rings[k], level, wall.up, shape.vertices)]
    highest = max(stepped or upward, key=lambda k: float((rings[k] @ wall.up).mean()))
    normal, corner = normals[highest], rings[highest][0]
    in_plane = [rings[k] for k in upward if np.abs((rings[k] - corner) @ normal).max() <= FLAT * shape.size]
    axes = np.array(plan_axes(wall.up))
    plan = shapely.union_all([shapely.Polygon((ring - corner) @ axes.T) for ring in in_plane])
    flat = np.array(plan.centroid.coords[0]) @ axes
    point = corner + flat - (flat @ normal) / (wall.up @ normal) * wall.up
    if along is not None:
        return point, float(np.ptp(np.concatenate(in_plane) @ along))
    rectangle = shapely.get_coordinates(shapely.minimum_rotated_rectangle(plan))
    return point, float(np.linalg.norm(np.diff(rectangle, axis=0), axis=1).max())


def _loaded(wall: SpaceWall, load: SpaceDeadLoad) -> list[int]:
    if load.level is not None:
        return _at_level(wall, load.level)
    place = wall.place_of
    return [place[wanted] for wanted in load.blocks]


def _at_level(wall: SpaceWall, level: float) -> list[int]:
    """Return the positions of the free blocks whose highest point, or a face of whose top, is at a level (m)."""

    def reaches(shape: Polyhedron) -> bool:
        highest = shape.vertices[[np.argmax(shape.vertices @ wall.up)]]
        tops = [shape.vertices[list(shape.faces[k])] for k in np.flatnonzero(face_normals(shape) @ wall.up > UPWARD)]
        return any(_near(points, level, wall.up, shape.vertices) for points in (highest, *tops))

    return [k for k, block in enumerate(wall.blocks) if not block.fixed and reaches(block.shape)]


def _near(points: FloatArray, level: float, up: FloatArray, vertices: FloatArray) -> bool:
    """Whether points (p, 3) of a body are at a level (m), within AT_LEVEL of its height."""
    return bool(np.abs(points @ up - level).max() <= AT_LEVEL * np.ptp(vertices @ up))


def _refuse_contradictions(wall: SpaceWall, settings: SpaceLoadSettings) -> None:
    """Raise CaseError for settings that contradict each other or name blocks that cannot be loaded."""
    if settings.angle is not None and settings.direction is not None:
        raise CaseError("load.angle", "is given beside load.direction, which it stands for", "leave one of the two out")
    if (settings.distribution == "per_block") != bool(settings.live):
        remedy = 'give [[load.live]] together with distribution = "per_block", or neither'
        raise CaseError("load.live", f'{len(settings.live)} given for "{settings.distribution}"', remedy)
    for number, live in enumerate(settings.live):
        if not live.force > 0.0:
            problem = f"{live.force:g} N is not along load.direction"
            raise CaseError(f"load.live.{number}.force", problem, "give forces above zero for walls in space")
    for number, load in enumerate(settings.dead):
        for one, other in (("force", "line_load"), ("level", "blocks")):
            if (getattr(load, one) in (None, ())) == (getattr(load, other) in (None, ())):
                raise CaseError(f"load.dead.{number}", f"needs one of {one} and {other}", "give one of the two")
        if load.level is not None and not _at_level(wall, load.level):
            tops = sorted({round(float((b.shape.vertices @ wall.up).max()), 3) for b in wall.blocks if not b.fixed})
            listed = ", ".join(f"{top:g}" for top in tops[:20])
            problem = f"no block has its top at {load.level:g} m"
            raise CaseError(f"load.dead.{number}.level", problem, f"tops are at {listed}{', ...' * (len(tops) > 20)} m")
        if load.inertia and -_along(wall, load, number) @ wall.up <= LEVEL_WITHIN:
            along = ", ".join(f"{part:g}" for part in load.direction)
            problem = f"a load along [{along}] has no downward part, and so no weight and no mass"
            raise CaseError(f"load.dead.{number}.inertia", problem, "leave it out, or give the weight as a load apart")
    refuse_blocks_that_cannot_move({block.id: not block.fixed for block in wall.blocks}, settings.live, settings.dead)
    for number, load in enumerate(settings.dead):
        given = "force" if load.line_load is None else "line_load"
        largest = max(_size(load, top_of(wall, k, load.level)[1]) for k in _loaded(wall, load))
        refuse_beyond_weight(wall.weights[~wall.fixed], largest, f"load.dead.{number}.{given}")
    for number, live in enumerate(settings.live):
        refuse_beyond_weight(wall.weights[~wall.fixed], live.force, f"load.live.{number}.force")


def _size(load: SpaceDeadLoad, length: float) -> float:
    """Return the force in N of a load on a block whose top is `length` m long."""
    return load.force if load.force is not None else (load.line_load or 0.0) * length
