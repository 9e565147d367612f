"""Coursed walls with arched openings, stone lintels and quoins; a facade of them."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely

from orchestrator.basis.checked import Checked
from orchestrator.masonry.patterns.arches import ArchedOpening
from orchestrator.masonry.patterns.courses import IrregularCourses, bed_joints, course, free
from orchestrator.masonry.patterns.quantities import Length, Rectangle
from orchestrator.masonry.patterns.tiling import wall_of_tiles
from orchestrator.masonry.wall import Wall

Span = tuple[float, float]
"""left, right in m"""


@dataclass(frozen=True, slots=True)
class ArchedWall(Checked):
    """A coursed wall (`courses`, whose own openings have stone lintels) with openings under arches; lengths in m.

    quoins: lengths of the large stones that alternate from course to course at both ends of the wall, and with
    `quoins_at_jambs` beside all openings, where the wall is wide enough.
    """

    courses: IrregularCourses
    arches: tuple[ArchedOpening, ...] = ()
    quoins: tuple[Length, Length] | None = None
    quoins_at_jambs: bool = False


def arched_wall(pattern: ArchedWall) -> Wall:
    """Return the wall of `pattern` on one wider support; the same seed gives the same wall.

    Courses begin at sills, springings and on keystones. Stones are cut by the chords of the extrados; too small a piece
    becomes part of its neighbour. Raises CaseError where no stones fit or an opening leaves the wall or meets another.
    """
    courses = pattern.courses
    random = np.random.default_rng(courses.seed)
    levels = bed_joints(courses, random, _levels_of(pattern))
    voids = [shapely.box(left, sill, right, head) for left, right, sill, head in courses.openings]
    lintels = [_lintel(courses, opening, levels) for opening in courses.openings if opening[3] < courses.height]
    voussoirs = [stone for arch in pattern.arches for stone in arch.stones()]
    voids += [arch.void() for arch in pattern.arches]
    whole = [*voids[: len(courses.openings)], *lintels]
    whole += [shapely.union_all([arch.void(), *arch.stones()]) for arch in pattern.arches]
    rough: list[shapely.Polygon] = []
    below: list[float] = []
    spans = [_taken(whole, bottom, top) for bottom, top in pairwise(levels)]
    for number, (taken, above) in enumerate(zip(spans, [*spans[1:], []], strict=True)):
        bottom, top = levels[number : number + 2]
        near = [*below, *(x for span in above for x in span)]
        stones = [
            stone
            for start, end in free(taken, courses.length)
            for stone in _row(start, end, near, number, pattern, random)
        ]
        axis = {x: 0.5 * (left + right) for left, right in taken for x in (left, right)}
        rough += [shapely.box(axis.get(left, left), bottom, axis.get(right, right), top) for left, right in stones]
        below = sorted({x for stone in stones for x in stone if 1e-9 < x < courses.length - 1e-9})
    return wall_of_tiles(
        f"arched wall {courses.seed}",
        (courses.length, courses.height),
        voids,
        lintels + voussoirs,
        rough,
        0.5 * sum(courses.heights),
        thickness=courses.thickness,
        unit_weight=courses.unit_weight,
        friction=courses.friction,
    )


def _levels_of(pattern: ArchedWall) -> list[float]:
    """Return sills, springings and tops of keystones, of the latter those a least course away from other levels."""
    levels = [y for arch in pattern.arches for y in (arch.sill, arch.springing)]
    ends = [0.0, pattern.courses.height, *(y for _, _, *ends in pattern.courses.openings for y in ends)]
    for arch in pattern.arches:
        crown = float(arch.rings()[1][:, 1].max())
        if all(abs(crown - y) >= pattern.courses.heights[0] for y in [*levels, *ends]):
            levels.append(crown)
    return levels


def _lintel(courses: IrregularCourses, opening: Rectangle, levels: list[float]) -> shapely.Polygon:
    left, right, _, head = opening
    top = min(y for y in levels if y > head + 1e-9)
    return shapely.box(left - courses.bearing, head, right + courses.bearing, top)


def _taken(whole: list[shapely.Polygon], bottom: float, top: float) -> list[Span]:
    """Return what openings, their arches and lintels take of a course halfway up, left to right."""
    middle = 0.5 * (bottom + top)
    line = shapely.LineString([(-1e6, middle), (1e6, middle)])
    spans = [shapely.intersection(shape, line).bounds for shape in whole if shapely.intersects(shape, line)]
    return sorted((left, right) for left, _, right, _ in spans)


def _row(
    start: float, end: float, near: list[float], number: int, pattern: ArchedWall, random: np.random.Generator
) -> list[Span]:
    """Return stones (left, right) from `start` to `end` of a course with quoins, head joints away from `near`."""
    courses = pattern.courses

    def quoin(x: float, inwards: int) -> float:
        """Return the length of the quoin at `x`, the other one where its joint would run on from one `near`."""
        if pattern.quoins is None or not (pattern.quoins_at_jambs or x in (0.0, courses.length)):
            return 0.0
        turns = (pattern.quoins[number % 2], pattern.quoins[1 - number % 2])
        away = (each for each in turns if all(abs(x + inwards * each - y) >= courses.overlap for y in near))
        return next(away, 0.0)

    first, last = quoin(start, 1), quoin(end, -1)
    if end - start - first - last < courses.widths[0]:
        return course(start, end, near, courses, random)
    ends = [(start, start + first)] * (first > 0) + [(end - last, end)] * (last > 0)
    return sorted(ends + course(start + first, end - last, near, courses, random))


ARCHED_FACADE = ArchedWall(
    IrregularCourses(
        length=6.0,
        height=6.5,
        thickness=0.5,
        widths=(0.4, 0.74),
        heights=(0.27, 0.38),
        overlap=0.08,
        openings=((4.4, 5.1, 1.0, 2.2),),
        bearing=0.25,
        unit_weight=20e3,
        friction=0.7,
        seed=0,
    ),
    arches=(
        ArchedOpening(2.35, 3.65, 0.0, 1.9, depth=0.3, voussoirs=11),
        ArchedOpening(0.85, 1.65, 3.7, 4.9, rise=0.2, depth=0.3, voussoirs=7),
        ArchedOpening(2.6, 3.4, 3.7, 4.9, rise=0.2, depth=0.3, voussoirs=7),
        ArchedOpening(4.35, 5.15, 3.7, 4.9, rise=0.2, depth=0.3, voussoirs=7),
    ),
    quoins=(0.7, 0.45),
)
"""A front of two storeys: an arched door, a window with a lintel, windows with segmental arches, quoins."""
