"""Rubble: polygonal stones of chosen size and flatness, the cells of jittered points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import shapely
from annotated_types import Gt

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.checked import Checked
from orchestrator.masonry.patterns.quantities import (
    Length,
    LengthOrNone,
    Rectangle,
    Seed,
    UnitWeight,
    refuse_swapped_edges,
    refuse_too_many,
)
from orchestrator.masonry.patterns.tiling import wall_of_tiles
from orchestrator.masonry.wall import Friction, Wall

JITTER = 0.35
"""of the distance between points: how far each is moved at most along both axes"""
RELAXATIONS = 3
"""times that points are moved to the centroids of their cells (Lloyd); with two, corners of stones are as sharp as 4
degrees beside lintels, with three 11 degrees (40 walls)"""


@dataclass(frozen=True, slots=True)
class Rubble(Checked):
    """Rubble masonry with an exact outline; lengths in m, unit weight in N/m3.

    stone: mean distance of stones side by side; flatness: that over the distance of one above the other (stones reach
    up between those of the next row: the boxes round them are 0.89 times as flat). openings: (left, right, bottom, top)
    each, with a lintel stone / flatness high that bears on `bearing` at both sides.
    """

    length: Length
    height: Length
    stone: Length = 0.3
    flatness: Annotated[float, Gt(0)] = 1.6
    thickness: Length = 0.5
    openings: tuple[Rectangle, ...] = ()
    bearing: LengthOrNone = 0.2
    unit_weight: UnitWeight = 20e3
    friction: Friction = 0.65
    seed: Seed = 0

    def __post_init__(self) -> None:
        Checked.__post_init__(self)
        refuse_swapped_edges(self.openings, "Rubble.openings")
        refuse_too_many(self.length / self.stone * (self.height / self.stone) * self.flatness, "Rubble.stone")


def rubble(pattern: Rubble) -> Wall:
    """Return the wall of `pattern` on one wider support; the same seed gives the same wall.

    Raises CaseError where an opening or its lintel leaves the wall or meets another.
    """
    course = pattern.stone / pattern.flatness
    voids = [shapely.box(left, sill, right, head) for left, right, sill, head in pattern.openings]
    lintels = [
        shapely.box(left - pattern.bearing, head, right + pattern.bearing, head + course)
        for left, right, _, head in pattern.openings
        if head < pattern.height
    ]
    room = shapely.difference(
        shapely.box(0.0, 0.0, pattern.length, pattern.height), shapely.union_all([*voids, *lintels])
    )
    room = shapely.transform(room, lambda points: points * [1.0, pattern.flatness])
    cells = _cells(room, pattern.stone, np.random.default_rng(pattern.seed))
    cells = shapely.transform(cells, lambda points: points / [1.0, pattern.flatness])
    return wall_of_tiles(
        f"rubble {pattern.seed}",
        (pattern.length, pattern.height),
        voids,
        lintels,
        cells,
        course,
        thickness=pattern.thickness,
        unit_weight=pattern.unit_weight,
        friction=pattern.friction,
    )


def _cells(room: shapely.Polygon, size: float, random: np.random.Generator) -> np.ndarray:
    """Return the Voronoi cells in `room` of jittered points, relaxed, `size` apart."""
    points = _jittered(room.bounds, size, random)
    points = points[shapely.contains_xy(room, points)]
    for _ in range(RELAXATIONS):
        pieces = shapely.get_parts(_voronoi(points, room))
        pieces = pieces[shapely.area(pieces) > 0.25 * size**2]
        points = shapely.get_coordinates(shapely.centroid(pieces))
    return _voronoi(points, room)


def _voronoi(points: FloatArray, room: shapely.Polygon) -> np.ndarray:
    if len(points) < 2:
        return np.array([room])
    cells = shapely.get_parts(shapely.voronoi_polygons(shapely.multipoints(points), extend_to=room))
    return shapely.intersection(cells, room)


def _jittered(bounds: tuple[float, float, float, float], size: float, random: np.random.Generator) -> FloatArray:
    """Return points (n, 2) `size` apart in rows, every second row shifted by half of it, each moved at random."""
    left, bottom, right, top = bounds
    columns, rows = (max(1, round(extent / size)) for extent in (right - left, top - bottom))
    row, column = np.divmod(np.arange(rows * (columns + 1)), columns + 1)
    step = np.array([(right - left) / columns, (top - bottom) / rows])
    place = np.column_stack([column + 0.5 * (row % 2), row + 0.5]) + random.uniform(-JITTER, JITTER, (len(row), 2))
    return np.array([left, bottom]) + place * step
