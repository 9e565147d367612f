"""Walls of stones whose plan is straight, L, U, T or a box, with corners that interlock.

Stones are l x t x h; the courses run in turn: in even courses the facade (along x, from y = 0 to t) runs through, in
odd courses the returns do. What is left at the end of a run is a cut stone. Lengths and heights in numbers of stones,
so that a wall has no joint over a joint but where `straight_joints` asks for it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated

import numpy as np
from annotated_types import Ge, Gt, Le

from orchestrator.basis.arrays import read_only
from orchestrator.basis.checked import Checked
from orchestrator.basis.units import Unit
from orchestrator.geometry.polyhedra import box
from orchestrator.space.wall import UPRIGHT, SpaceBlock, SpaceWall

Run = tuple[float, float, float, float]
"""a stone in plan: x0, x1, y0, y1 in m"""


@dataclass(frozen=True, slots=True)
class Stones(Checked):
    """The stones of a wall made by a generator, and of what they are."""

    length: Annotated[float, Gt(0), Unit("m")] = 0.2
    """of a stone, along the wall"""
    thickness: Annotated[float, Gt(0), Unit("m")] = 0.1
    """of a stone, and of the wall"""
    height: Annotated[float, Gt(0), Unit("m")] = 0.1
    """of a course"""
    unit_weight: Annotated[float, Gt(0), Unit("N/m3")] = 20e3
    """of every stone"""
    friction: Annotated[float, Gt(0)] = 0.6
    """in every joint, the base too"""


@dataclass(frozen=True, slots=True)
class Plan(Checked):
    """Size of a wall in stones."""

    facade: Annotated[int, Ge(1), Le(10_000)] = 4
    """length of the facade, in stones"""
    returns: Annotated[int, Ge(0), Le(10_000)] = 2
    """length of the returns behind the facade, in stones"""
    courses: Annotated[int, Ge(1), Le(10_000)] = 8
    """how many courses"""


def runs(start: float, end: float, length: float, first: float = 0.0) -> list[tuple[float, float]]:
    """Cut start..end into stones of `length` from the start, the first one `first` long if that is given."""
    cuts = [start]
    if first:
        cuts.append(start + first)
    while cuts[-1] + length < end - 1e-9 * length:
        cuts.append(cuts[-1] + length)
    return list(pairwise([*cuts, end]))


def of_courses(name: str, plans: list[list[Run]], stones: Stones) -> SpaceWall:
    """Return a wall from the plan of every course, on a base as deep as three courses that reaches beyond it."""
    blocks: list[SpaceBlock] = []
    for course, plan in enumerate(plans):
        low, high = course * stones.height, (course + 1) * stones.height
        for x0, x1, y0, y1 in plan:
            shape = box((x0, y0, low), (x1, y1, high))
            blocks.append(SpaceBlock(len(blocks) + 1, shape, unit_weight=stones.unit_weight))
    return SpaceWall(name, (ground(plans[0], stones), *blocks), stones.friction, read_only(UPRIGHT))


def ground(plan: list[Run], stones: Stones) -> SpaceBlock:
    """Return the support under a plan, which reaches two stones beyond it."""
    x0, x1, y0, y1 = np.array(plan).T
    margin, depth = 2.0 * stones.length, 2.0 * stones.height
    low = (float(x0.min()) - margin, float(y0.min()) - margin, -depth)
    shape = box(low, (float(x1.max()) + margin, float(y1.max()) + margin, 0.0))
    return SpaceBlock(0, shape, fixed=True, unit_weight=stones.unit_weight)


def straight_wall(plan: Plan, stones: Stones) -> SpaceWall:
    """Running bond with half stones at the ends of odd courses."""
    length, t, end = stones.length, stones.thickness, plan.facade * stones.length
    even = [(a, b, 0.0, t) for a, b in runs(0.0, end, length)]
    odd = [(a, b, 0.0, t) for a, b in runs(0.0, end, length, 0.5 * length)]
    return of_courses("straight wall", [odd if k % 2 else even for k in range(plan.courses)], stones)


def u_wall(plan: Plan, stones: Stones) -> SpaceWall:
    """A facade with a return at both ends, which run along +y."""
    return of_courses("U-shaped wall", list(_facade_with_returns(plan, stones, (True, True))), stones)


def l_wall(plan: Plan, stones: Stones) -> SpaceWall:
    """A facade with a return at its left end; the right end is free."""
    return of_courses("L-shaped wall", list(_facade_with_returns(plan, stones, (True, False))), stones)


def _facade_with_returns(plan: Plan, stones: Stones, at: tuple[bool, bool]) -> Iterator[list[Run]]:
    """Yield the plan of every course; `at`: whether there is a return at the left and at the right end."""
    length, t = stones.length, stones.thickness
    end, back = plan.facade * length, t + plan.returns * length
    sides = [(0.0, t)] * at[0] + [(end - t, end)] * at[1]
    for course in range(plan.courses):
        if course % 2 == 0:
            yield [(a, b, 0.0, t) for a, b in runs(0.0, end, length)] + [
                (x0, x1, a, b) for x0, x1 in sides for a, b in runs(t, back, length)
            ]
        else:
            yield [(a, b, 0.0, t) for a, b in runs(t * at[0], end - t * at[1], length)] + [
                (x0, x1, a, b) for x0, x1 in sides for a, b in runs(0.0, back, length)
            ]


def t_wall(plan: Plan, stones: Stones, straight_joints: bool = False) -> SpaceWall:
    """A facade with one return behind its middle. straight_joints: leave out the half stones at the facade's ends, so
    that a joint runs straight up one stone from each end."""
    length, t, end = stones.length, stones.thickness, plan.facade * stones.length
    left, right, back = 0.5 * (end - t), 0.5 * (end + t), t + plan.returns * length
    half = 0.0 if straight_joints else 0.5 * length
    facade = runs(0.0, left, length, half)
    other = [(end - b, end - a) for a, b in _from_web(end - right, length, half)]
    even = [(a, b, 0.0, t) for a, b in runs(0.0, end, length)] + [(left, right, a, b) for a, b in runs(t, back, length)]
    odd = [(a, b, 0.0, t) for a, b in (*facade, *other)] + [(left, right, a, b) for a, b in runs(0.0, back, length)]
    return of_courses("T-shaped wall", [odd if k % 2 else even for k in range(plan.courses)], stones)


def _from_web(width: float, length: float, half: float) -> list[tuple[float, float]]:
    """Stones of a facade's right part, from its free end: a half stone there, whole ones from the web."""
    cuts = [width]
    while cuts[-1] - length > half + 1e-9 * length:
        cuts.append(cuts[-1] - length)
    return list(pairwise(sorted([0.0, *([half] if half else []), *cuts])))


def box_wall(plan: Plan, stones: Stones) -> SpaceWall:
    """Four walls: `facade` stones by `returns` stones and two thicknesses."""
    length, t = stones.length, stones.thickness
    end, back = plan.facade * length, 2.0 * t + plan.returns * length
    even = [(a, b, y, y + t) for y in (0.0, back - t) for a, b in runs(0.0, end, length)]
    even += [(x, x + t, a, b) for x in (0.0, end - t) for a, b in runs(t, back - t, length)]
    odd = [(x, x + t, a, b) for x in (0.0, end - t) for a, b in runs(0.0, back, length)]
    odd += [(a, b, y, y + t) for y in (0.0, back - t) for a, b in runs(t, end - t, length)]
    return of_courses("box of four walls", [odd if k % 2 else even for k in range(plan.courses)], stones)
