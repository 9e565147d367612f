"""Floors and beams: blocks of their own with weight and bearing, let into a wall.

A floor is a box between two corners in plan, from its level upwards. What it shares with a stone is cut off the stone,
so that it bears on the course below, is held by the stones of its own courses and loaded by those above. For that every
stone it meets must lie between its underside and its top: a floor is as high as whole courses. Beams are floors that
are narrow. How much of its weight, and what horizontal force, a wall gets follows from equilibrium and friction.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import shapely
from annotated_types import Gt, MinLen

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.checked import Checked
from orchestrator.basis.errors import CaseError
from orchestrator.basis.units import Unit
from orchestrator.geometry.polyhedra import Polyhedron, prism, volume_of
from orchestrator.space.loads import plan_axes
from orchestrator.space.wall import SpaceBlock, SpaceWall

CUT_VOLUME_ROUNDING = 1e-6
"""Part of a stone's volume below which what is cut off, or left, is rounding."""
PLAN_GRID = 1e-9
"""Part of a stone's size in plan to which what is left of it is rounded: a floor that ends where the stone does, but
for rounding, leaves no spike."""


@dataclass(frozen=True, slots=True)
class Floor(Checked):
    """A slab or a beam."""

    level: Annotated[float, Unit("m")]
    """height of its underside: a bed joint"""
    thickness: Annotated[float, Gt(0), Unit("m")]
    """its height: a whole number of courses where it is let into the wall"""
    start: Annotated[tuple[Annotated[float, Unit("m")], ...], MinLen(2)]
    """one corner in plan, [x, y]"""
    end: Annotated[tuple[Annotated[float, Unit("m")], ...], MinLen(2)]
    """the opposite corner"""
    unit_weight: Annotated[float, Gt(0), Unit("N/m3")] = 25e3
    """with what lies on it, spread over its volume"""
    friction: Annotated[float, Gt(0)] | None = None
    """in its joints; left out: the wall's"""


@dataclass(frozen=True, slots=True)
class FloorSettings(Checked):
    """The floors of a wall."""

    floors: tuple[Floor, ...] = ()
    """each a table [[wall.floors]] with `level`, `thickness`, `start`, `end`, `unit_weight`, `friction`"""


def with_floors(wall: SpaceWall, floors: Sequence[Floor]) -> SpaceWall:
    """Return the wall with floors let in, numbered on from its largest id. Raises CaseError."""
    for number, floor in enumerate(floors):
        key = f"wall.floors.{number}"
        body = _body(wall, floor, key)
        blocks = [piece for block in wall.blocks for piece in _cut(wall, block, floor, key)]
        largest = max(block.id for block in wall.blocks)
        fresh = iter(range(largest + 1, largest + 2 + len(blocks)))
        seen: set[int] = set()
        for k, block in enumerate(blocks):
            if block.id in seen:  # the second piece of a stone
                blocks[k] = replace(block, id=next(fresh))
            seen.add(block.id)
        slab = SpaceBlock(next(fresh), body, False, floor.unit_weight, "floor", floor.friction)
        wall = replace(wall, blocks=(*blocks, slab))
    return wall


def _frame(wall: SpaceWall) -> FloatArray:
    """Return the directions (3, 3) of both axes in plan and upwards."""
    return np.array([*plan_axes(wall.up), wall.up])


def _body(wall: SpaceWall, floor: Floor, key: str) -> Polyhedron:
    if len(floor.start) != 2 or len(floor.end) != 2 or not all(np.subtract(floor.end, floor.start)):
        raise CaseError(f"{key}.end", "its two corners make no rectangle", "give two opposite corners [x, y] in plan")
    frame = _frame(wall)
    outline = np.array(_outline(floor).exterior.coords)[:-1]
    return prism(outline, floor.level * frame[2], frame * [[1.0], [1.0], [floor.thickness]])


def _outline(floor: Floor) -> shapely.Polygon:
    (x0, x1), (y0, y1) = (sorted(pair) for pair in zip(floor.start, floor.end, strict=True))
    return shapely.box(x0, y0, x1, y1)


def _cut(wall: SpaceWall, block: SpaceBlock, floor: Floor, key: str) -> Iterator[SpaceBlock]:
    """Yield what a floor leaves of a block: itself where they do not meet."""
    frame = _frame(wall)
    places = block.shape.vertices @ frame.T
    low, high = places[:, 2].min(), places[:, 2].max()
    slack = CUT_VOLUME_ROUNDING * (high - low)
    plan = shapely.MultiPoint(places[:, :2]).convex_hull
    shared = plan.intersection(_outline(floor)).area
    apart = high <= floor.level + slack or low >= floor.level + floor.thickness - slack
    if apart or shared <= CUT_VOLUME_ROUNDING * plan.area:
        yield block
        return
    upright = abs(plan.area * (high - low) - volume_of(block.shape)) <= CUT_VOLUME_ROUNDING * volume_of(block.shape)
    inside = low >= floor.level - slack and high <= floor.level + floor.thickness + slack
    if block.fixed or not upright or not inside:
        what = "support" if block.fixed else f"block {block.id}, which is not a whole course of upright sides"
        remedy = "put its level at a bed joint and make it as high as whole courses"
        raise CaseError(key, f"cuts into a {what}" if block.fixed else f"cuts into {what}", remedy)
    left = shapely.difference(plan, _outline(floor), grid_size=PLAN_GRID * np.sqrt(plan.area))
    for part in getattr(left, "geoms", [left]):
        if part.area > CUT_VOLUME_ROUNDING * plan.area:
            if part.interiors:
                problem = f"lies inside block {block.id}, which it would leave with a hole"
                raise CaseError(key, problem, "let it reach a side of the block")
            ring = np.array(shapely.geometry.polygon.orient(part).exterior.coords)[:-1]
            shape = prism(ring, low * frame[2], frame * [[1.0], [1.0], [high - low]])
            yield replace(block, shape=shape)
