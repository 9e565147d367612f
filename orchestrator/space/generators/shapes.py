"""Walls of stones whose plan is straight, L, U, T or a box, with corners that interlock.

Stones are l x t x h; the courses run in turn: in even courses the facade (along x, from y = 0 to t) runs through, in
odd courses the returns do. Between corners stones are as near to l as makes a whole number of them; those of a course
that runs through lie over the joints of the others by half a stone, whatever t is, and are cut in the corners. So a
wall has no joint over a joint but where `straight_joints` asks for it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import ceil
from typing import Annotated

import numpy as np
from annotated_types import Ge, Gt, Le

from orchestrator.basis.arrays import read_only
from orchestrator.basis.checked import Checked
from orchestrator.basis.errors import CaseError
from orchestrator.basis.units import Unit
from orchestrator.geometry.polyhedra import box
from orchestrator.space.wall import UPRIGHT, SpaceBlock, SpaceWall

Run = tuple[float, float, float, float]
"""a stone in plan: x0, x1, y0, y1 in m"""
ALONG_X, ALONG_Y = read_only([1.0, 0.0, 0.0]), read_only([0.0, 1.0, 0.0])
"""directions of walls"""
SHORTEST_CUT_STONE = 0.3
"""part of a stone: a cut piece shorter than this is joined to its neighbour"""


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
    if 0.0 < first < end - start - 1e-9 * length:
        cuts.append(start + first)
    while cuts[-1] + length < end - 1e-9 * length:
        cuts.append(cuts[-1] + length)
    return list(pairwise([*cuts, end]))


def bonded(
    end: float, stones: Stones, both: bool = True
) -> tuple[list[tuple[float, float]], list[tuple[float, float]]]:
    """Return the stones of a wall 0..end in a course that runs through its corners, and in one between them.

    There is a corner at 0 and, for `both`, at the end; a free end has whole and half stones in turn. Raises CaseError
    for a facade with no room for a stone between its corners.
    """
    length, t, corners = stones.length, stones.thickness, 1 + both
    inner = end - corners * t
    if abs(inner) <= 1e-9 * length:
        return [(0.0, end)], []
    if inner < SHORTEST_CUT_STONE * length:
        raise _too_short(end, corners * t / length + SHORTEST_CUT_STONE, f"corners {t:.4g} m thick")
    halves = 1 if both else 2
    count = max(round(halves * inner / length), 1) / halves
    own = inner / count
    between = [t + k * own for k in range(ceil(count))]
    middles = (t + (k + 0.5) * own for k in range(-ceil(t / own), ceil(end / own)))
    through = [x for x in middles if SHORTEST_CUT_STONE * own < x < end - SHORTEST_CUT_STONE * own]
    return list(pairwise([0.0, *through, end])), list(pairwise([*between, end - (corners - 1) * t]))


def of_courses(name: str, plans: list[list[Run]], stones: Stones) -> SpaceWall:
    """Return a wall from the plan of every course, on a base as deep as three courses that reaches beyond it.

    Stones as thick along y as the wall are the facade's, along x; others that are so along x are a return's, along y.
    """
    blocks: list[SpaceBlock] = []
    for course, plan in enumerate(plans):
        low, high = course * stones.height, (course + 1) * stones.height
        for x0, x1, y0, y1 in plan:
            shape = box((x0, y0, low), (x1, y1, high))
            x_is_thickness, y_is_thickness = (abs(d - stones.thickness) < 1e-9 * d for d in (x1 - x0, y1 - y0))
            along = ALONG_Y if x_is_thickness and not y_is_thickness else ALONG_X
            blocks.append(SpaceBlock(len(blocks) + 1, shape, unit_weight=stones.unit_weight, along=along))
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
    t, end = stones.thickness, plan.facade * stones.length
    sides = [(0.0, t)] * at[0] + [(end - t, end)] * at[1]
    facade = bonded(end, stones, all(at))
    returns = bonded(t + plan.returns * stones.length, stones, False)
    for course in range(plan.courses):
        along, behind = facade[course % 2], returns[1 - course % 2]
        yield [(a, b, 0.0, t) for a, b in along] + [(x0, x1, a, b) for x0, x1 in sides for a, b in behind]


def t_wall(plan: Plan, stones: Stones, straight_joints: bool = False) -> SpaceWall:
    """A facade with one return behind its middle. straight_joints: leave out the half stones at the facade's ends, so
    that a joint runs straight up one stone from each end."""
    length, t, end = stones.length, stones.thickness, plan.facade * stones.length
    left, right, first = beside_web(end, stones)
    other_first = 0.0 if straight_joints else 1.5 * length - first
    facade = runs(0.0, left, length, other_first)
    other = [(end - b, end - a) for a, b in _from_web(end - right, length, other_first)]
    web = bonded(t + plan.returns * length, stones, False)
    even = [(a, b, 0.0, t) for a, b in runs(0.0, end, length, first)] + [(left, right, a, b) for a, b in web[1]]
    odd = [(a, b, 0.0, t) for a, b in (*facade, *other)] + [(left, right, a, b) for a, b in web[0]]
    return of_courses("T-shaped wall", [odd if k % 2 else even for k in range(plan.courses)], stones)


def beside_web(end: float, stones: Stones) -> tuple[float, float, float]:
    """Return where a web behind the middle of a facade 0..end begins and ends, and how long the first stone is of the
    courses that run over its joints: whole or half, whichever has joints farther from these. Raises CaseError."""
    length, t = stones.length, stones.thickness
    left = 0.5 * (end - t)
    if left < SHORTEST_CUT_STONE * length:
        raise _too_short(end, t / length + 2.0 * SHORTEST_CUT_STONE, f"a return {t:.4g} m thick")
    off = left % length
    whole = min(off, length - off) >= 0.25 * length * (1.0 - 1e-9)
    return left, left + t, length if whole else 0.5 * length


def _too_short(end: float, needed: float, beside: str) -> CaseError:
    """Return the refusal of a facade (m) that needs so many stones."""
    problem = f"{end:.4g} m leave no room for a stone beside {beside}"
    return CaseError("wall.facade", problem, f"give {ceil(needed)} stones or more, or make the wall thinner")


def _from_web(width: float, length: float, first: float) -> list[tuple[float, float]]:
    """Stones of a facade's right part, from its free end: `first` there (0: what is left), whole ones from the web."""
    cuts = [width]
    while cuts[-1] - length > first + 1e-9 * length:
        cuts.append(cuts[-1] - length)
    return list(pairwise(sorted([0.0, *([first] if 0.0 < first < width - 1e-9 * length else []), *cuts])))


def box_wall(plan: Plan, stones: Stones) -> SpaceWall:
    """Four walls: `facade` stones by `returns` stones and two thicknesses."""
    t, end = stones.thickness, plan.facade * stones.length
    back = 2.0 * t + plan.returns * stones.length
    facade, sides = bonded(end, stones), bonded(back, stones)
    plans: list[list[Run]] = []
    for course in range(plan.courses):
        along, across = facade[course % 2], sides[1 - course % 2]
        plans.append(
            [(a, b, y, y + t) for y in (0.0, back - t) for a, b in along]
            + [(x, x + t, a, b) for x in (0.0, end - t) for a, b in across]
        )
    return of_courses("box of four walls", plans, stones)
