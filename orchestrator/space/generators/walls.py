"""Facades with openings and lintels, gables, buttresses with set-backs, and walls of two leaves with headers."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated

import numpy as np
import shapely
from annotated_types import Ge, Gt, Le

from orchestrator.basis.arrays import read_only
from orchestrator.basis.checked import Checked
from orchestrator.basis.errors import CaseError
from orchestrator.geometry.polyhedra import prism
from orchestrator.space.generators.shapes import (
    ALONG_X,
    SHORTEST_CUT_STONE,
    Plan,
    Run,
    Stones,
    beside_web,
    bonded,
    ground,
    of_courses,
    runs,
)
from orchestrator.space.wall import UPRIGHT, SpaceBlock, SpaceWall

SAME_CORNER = 1e-9
"""part of a stone within which two corners of a cut stone are one"""


@dataclass(frozen=True, slots=True)
class Openings(Checked):
    """Openings in a facade, evenly spaced; sizes in stones and courses."""

    openings: Annotated[int, Ge(0), Le(1000)] = 1
    """how many, side by side"""
    width: Annotated[float, Gt(0)] = 2.0
    """of each, in stones"""
    sill: Annotated[int, Ge(0)] = 2
    """courses under an opening: 0 for a door"""
    tall: Annotated[int, Ge(1)] = 4
    """height of an opening in courses; the lintel lies on the course above it"""
    bearing: Annotated[float, Gt(0)] = 0.5
    """of the lintel on both sides, in stones"""


@dataclass(frozen=True, slots=True)
class Gable(Checked):
    """A triangular wall."""

    width: Annotated[float, Gt(0)] = 20.0
    """of its foot, in stones"""
    courses: Annotated[int, Ge(1), Le(10_000)] = 15
    """up to its top"""


@dataclass(frozen=True, slots=True)
class Setbacks(Checked):
    """How a buttress behind a T-shaped wall grows shorter with height."""

    set_back: Annotated[int, Ge(1)] = 4
    """courses after which the buttress is half a stone shorter"""


@dataclass(frozen=True, slots=True)
class Leaves(Checked):
    """A wall of two leaves; `thickness` of the stones is that of one leaf."""

    facade: Annotated[int, Ge(1), Le(10_000)] = 4
    """length, in stones"""
    courses: Annotated[int, Ge(1), Le(10_000)] = 12
    """how many"""
    headers: tuple[int, ...] = ()
    """courses, from 1 at the foot, whose stones go through both leaves"""
    headers_every: Annotated[int, Ge(0)] = 0
    """besides, every so manieth course; 0: none"""


def wall_with_openings(plan: Plan, openings: Openings, stones: Stones) -> SpaceWall:
    """A facade with openings under lintels, and returns behind both ends (none where `returns` is 0)."""
    length, t, end = stones.length, stones.thickness, plan.facade * stones.length
    back, wide = t + plan.returns * length, openings.width * length
    pier = (end - openings.openings * wide) / (openings.openings + 1)
    if pier < (openings.bearing + SHORTEST_CUT_STONE) * length + t or openings.sill + openings.tall >= plan.courses:
        remedy = "make them narrower or fewer, or the wall longer and higher"
        raise CaseError("wall.openings", "they leave no piers between them or no course above them", remedy)
    left = [pier + k * (pier + wide) for k in range(openings.openings)]
    reach, lintel = openings.bearing * length, openings.sill + openings.tall
    bond = bonded(end, stones) if plan.returns else (runs(0.0, end, length), runs(0.0, end, length, 0.5 * length))
    behind = bonded(back, stones, False)
    plans: list[list[Run]] = []
    for course in range(plan.courses):
        along = bond[course % 2]
        cuts = [x for x, _ in along[:1]] + [x for _, x in along]
        holes: list[tuple[float, float]] = []
        if openings.sill <= course < lintel:
            holes = [(x, x + wide) for x in left]
        elif course == lintel:
            holes = [(x - reach, x + wide + reach) for x in left]
        facade = _around(cuts, holes, length) if along else []
        if course == lintel:
            facade += holes
        sides = [0.0, end - t] if plan.returns else []
        returns = [(x, x + t, a, b) for x in sides for a, b in behind[1 - course % 2]]
        plans.append([(a, b, 0.0, t) for a, b in facade] + returns)
    return of_courses("facade with openings", plans, stones)


def _around(cuts: list[float], holes: list[tuple[float, float]], length: float) -> list[tuple[float, float]]:
    """Return the stones between cuts outside the holes; cuts that would leave slivers beside a hole or end are left."""
    ends = [cuts[0], cuts[-1], *(x for hole in holes for x in hole)]
    inner = [x for x in cuts[1:-1] if min(abs(x - end) for end in ends) > SHORTEST_CUT_STONE * length]
    places = sorted({*ends, *inner})
    stones = []
    for a, b in pairwise(places):
        if b - a > 1e-9 * length and not any(x0 <= 0.5 * (a + b) <= x1 for x0, x1 in holes):
            stones.append((a, b))
    return stones


def gable(shape: Gable, stones: Stones) -> SpaceWall:
    """A triangle in running bond, its stones cut along the slopes; slivers at the slopes are part of their
    neighbours."""
    length, t, h = stones.length, stones.thickness, stones.height
    wide, high = shape.width * length, shape.courses * h
    slopes = shapely.Polygon([(0.0, 0.0), (wide, 0.0), (0.5 * wide, high)])
    axes = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, t, 0.0]])
    blocks = [ground([(0.0, wide, 0.0, t)], stones)]
    for course in range(shape.courses):
        inset = 0.5 * wide * course / shape.courses
        cuts = np.arange(-1.0 + 0.5 * (course % 2), shape.width + 1.5) * length
        top = inset + 0.5 * wide / shape.courses
        inner = [x for x in cuts if top + SHORTEST_CUT_STONE * length < x < wide - top - SHORTEST_CUT_STONE * length]
        places = [inset, *inner, wide - inset]
        for a, b in pairwise(places):
            within = shapely.box(a, course * h, b, (course + 1) * h)
            stone = shapely.intersection(slopes, within, grid_size=SAME_CORNER * min(length, h))
            corners = shapely.get_coordinates(shapely.normalize(stone).simplify(SAME_CORNER * length))[:-1]
            body = prism(corners, np.zeros(3), axes)
            blocks.append(SpaceBlock(len(blocks), body, unit_weight=stones.unit_weight, along=ALONG_X))
    return SpaceWall("gable", tuple(blocks), stones.friction, read_only(UPRIGHT))


def buttressed_wall(plan: Plan, setbacks: Setbacks, stones: Stones) -> SpaceWall:
    """A facade with a buttress behind its middle, bonded with it, that grows shorter by half a stone now and then."""
    length, t, end = stones.length, stones.thickness, plan.facade * stones.length
    left, right, first = beside_web(end, stones)
    over, under = (runs(0.0, end, length, one) for one in (first, 1.5 * length - first))
    beside = _around([0.0, *(x for _, x in under)], [(left, right)], length)
    plans: list[list[Run]] = []
    for course in range(plan.courses):
        shorter = 0.5 * length * (course // setbacks.set_back)
        back = max(t + plan.returns * length - shorter, t + 0.5 * length)
        facade, pier = (
            (beside, bonded(back, stones, False)[0]) if course % 2 else (over, bonded(back, stones, False)[1])
        )
        plans.append([(a, b, 0.0, t) for a, b in facade] + [(left, right, a, b) for a, b in pier])
    return of_courses("wall with a buttress", plans, stones)


def two_leaf_wall(leaves: Leaves, stones: Stones) -> SpaceWall:
    """Two leaves side by side, whose collar joint has friction as the others; headers go through both."""
    length, t, end = stones.length, stones.thickness, leaves.facade * stones.length
    plans: list[list[Run]] = []
    for course in range(1, leaves.courses + 1):
        through = course in leaves.headers or (leaves.headers_every and course % leaves.headers_every == 0)
        half = 0.5 * length if course % 2 == 0 and leaves.facade > 1 else 0.0
        along = runs(0.0, end, length, half)
        depths = [(0.0, 2.0 * t)] if through else [(0.0, t), (t, 2.0 * t)]
        plans.append([(a, b, y0, y1) for y0, y1 in depths for a, b in along])
    return of_courses("wall of two leaves", plans, stones)
