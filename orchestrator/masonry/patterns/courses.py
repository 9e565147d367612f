"""Masonry without a drawing: running bond, and irregular courses drawn from ranges."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from orchestrator.basis.arrays import read_only
from orchestrator.basis.checked import Checked
from orchestrator.basis.errors import CaseError
from orchestrator.masonry.patterns.quantities import (
    Length,
    LengthOrNone,
    Number,
    Rectangle,
    Seed,
    UnitWeight,
    refuse_reversed,
    refuse_swapped_edges,
    refuse_too_many,
)
from orchestrator.masonry.wall import Block, Friction, Wall

COURSES_DRAWN_WHOLE = 2000
"""tries to draw a course as a whole until one keeps the overlap; long ones hardly ever do"""
COURSES_DRAWN_BY_JOINTS = 200
"""tries after these to draw it joint by joint"""


@dataclass(frozen=True, slots=True)
class RunningBond(Checked):
    """What `running_bond` takes."""

    blocks_per_course: Number
    courses: Number
    block_length: Length
    block_height: Length
    thickness: Length
    unit_weight: UnitWeight
    friction: Friction

    def __post_init__(self) -> None:
        Checked.__post_init__(self)
        refuse_too_many(self.blocks_per_course * self.courses, "RunningBond.courses")


def running_bond(
    blocks_per_course: int,
    courses: int,
    block_length: float = 0.4,
    block_height: float = 0.175,
    thickness: float = 0.1,
    unit_weight: float = 25e3,
    friction: float = 0.65,
) -> Wall:
    """Return a wall of whole blocks, every second course with half blocks at both ends, on one wider support.

    The lowest course is a whole one (wall 1 of Ferris and Tin-Loi, of the same size, begins with the halved one and
    is weaker: associative multiplier 0.6429 against 0.6500 here). Lengths in m, unit weight in N/m3.
    Blocks are numbered from 1, course by course from the left; the support is 0.
    """
    bond = RunningBond(blocks_per_course, courses, block_length, block_height, thickness, unit_weight, friction)
    length = bond.blocks_per_course * bond.block_length
    whole = np.arange(bond.blocks_per_course + 1) * bond.block_length
    halved = np.concatenate([[0.0], whole[:-1] + bond.block_length / 2, [length]])
    rectangles = [(-0.2, length + 0.2, -bond.block_height, 0.0)]
    for course in range(bond.courses):
        ends = halved if course % 2 else whole
        level = course * bond.block_height
        rectangles += [(left, right, level, level + bond.block_height) for left, right in pairwise(ends)]
    name = f"running bond {bond.blocks_per_course} x {bond.courses}"
    return _wall(name, rectangles, bond.thickness, bond.unit_weight, bond.friction)


@dataclass(frozen=True, slots=True)
class IrregularCourses(Checked):
    """Coursed rectangular masonry of irregular stones with an exact outline; lengths in m, unit weight in N/m3.

    Widths and heights are drawn from their ranges (least, largest); heights are then stretched so that courses end at
    the outline and at the openings. Head joints keep `overlap` from those of the course below. openings: (left, right,
    bottom, top) each, with a lintel of one course that bears on `bearing` at both sides. Where a jamb or a lintel
    leaves less than a stone, a stone may be down to half the least or up to one and a half of the largest width.
    """

    length: Length
    height: Length
    thickness: Length = 0.3
    widths: tuple[Length, Length] = (0.12, 0.26)
    heights: tuple[Length, Length] = (0.09, 0.13)
    overlap: LengthOrNone = 0.03
    openings: tuple[Rectangle, ...] = ()
    bearing: LengthOrNone = 0.15
    unit_weight: UnitWeight = 19.4e3
    friction: Friction = 0.75
    seed: Seed = 0

    def __post_init__(self) -> None:
        Checked.__post_init__(self)
        for key in ("widths", "heights"):
            refuse_reversed(getattr(self, key), f"IrregularCourses.{key}")
        refuse_swapped_edges(self.openings, "IrregularCourses.openings")
        blocks = 2.0 * self.length / sum(self.widths) * (2.0 * self.height / sum(self.heights))
        refuse_too_many(blocks, "IrregularCourses.widths")


def irregular_courses(pattern: IrregularCourses) -> Wall:
    """Return the wall of `pattern` on one wider support; the same seed gives the same wall.

    Raises CaseError where no stones fit (an opening too near another, a range too narrow for the overlap).
    """
    random = np.random.default_rng(pattern.seed)
    rectangles = [(-0.2, pattern.length + 0.2, -pattern.heights[1], 0.0)]
    below: list[float] = []
    for bottom, top in pairwise(bed_joints(pattern, random)):
        stones = [
            (left - pattern.bearing, right + pattern.bearing)
            for left, right, _, head in pattern.openings
            if abs(head - bottom) < 1e-9
        ]
        taken = stones + [(left, right) for left, right, sill, head in pattern.openings if sill < bottom + 1e-9 < head]
        for start, end in free(sorted(taken), pattern.length):
            stones += course(start, end, below, pattern, random)
        rectangles += [(left, right, bottom, top) for left, right in sorted(stones)]
        ends = {round(x, 9) for stone in stones for x in stone}
        below = sorted(x for x in ends if 1e-9 < x < pattern.length - 1e-9)
    return _wall(
        f"irregular courses {pattern.seed}", rectangles, pattern.thickness, pattern.unit_weight, pattern.friction
    )


def bed_joints(pattern: IrregularCourses, random: np.random.Generator, others: Iterable[float] = ()) -> list[float]:
    """Return the heights of the bed joints, from 0 to the top: openings begin and end at one, and `others` are some."""
    fixed = sorted({0.0, pattern.height, *others, *(y for _, _, *ends in pattern.openings for y in ends)})
    levels = [0.0]
    for bottom, top in pairwise(fixed):
        courses = max(1, round((top - bottom) / (0.5 * sum(pattern.heights))))
        drawn = random.uniform(*pattern.heights, courses)
        levels += list(bottom + np.cumsum(drawn) * (top - bottom) / drawn.sum())
        levels[-1] = top
    return levels


def free(taken: list[tuple[float, float]], length: float) -> list[tuple[float, float]]:
    """Return what lintels and openings leave of a course, left to right."""
    edges = [0.0, *(x for stone in taken for x in stone), length]
    pieces = list(zip(edges[::2], edges[1::2], strict=True))
    if any(end < start - 1e-9 for start, end in pieces):
        raise CaseError("openings", "an opening or its lintel leaves the wall or meets another", "move them apart")
    return [(start, end) for start, end in pieces if end - start > 1e-9]


def course(
    start: float, end: float, below: list[float], pattern: IrregularCourses, random: np.random.Generator
) -> list[tuple[float, float]]:
    """Return stones (left, right) from `start` to `end`, head joints away from those `below`."""
    least, largest = pattern.widths

    def away(x: float) -> bool:
        return all(abs(x - y) >= pattern.overlap for y in below)

    for draws in COURSES_DRAWN_WHOLE * [1] + COURSES_DRAWN_BY_JOINTS * [50]:
        joints = [start]
        while end - joints[-1] > largest:
            rest = end - joints[-1]
            for _ in range(draws):
                x = joints[-1] + min(random.uniform(least, largest), max(rest - 0.5 * least, 0.5 * rest))
                if away(x):
                    break
            joints.append(x)
        joints.append(end)
        narrow = len(joints) > 2 and np.diff(joints).min() < 0.5 * least - 1e-9
        if not narrow and all(away(x) for x in joints[1:-1]):
            return list(pairwise(joints))
    raise CaseError("overlap", f"no stones of these widths fit from {start:g} to {end:g} m", "lower it or widen widths")


def _wall(name: str, rectangles: list[Rectangle], thickness: float, unit_weight: float, friction: float) -> Wall:
    blocks = tuple(
        Block(number, _rectangle(*sides), fixed=number == 0, unit_weight=unit_weight)
        for number, sides in enumerate(rectangles)
    )
    return Wall(name, blocks, thickness, friction)


def _rectangle(left: float, right: float, bottom: float, top: float) -> np.ndarray:
    return read_only([[left, bottom], [right, bottom], [right, top], [left, top]])
