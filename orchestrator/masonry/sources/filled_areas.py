"""Outlines of filled areas (hatches, solids, faces) -> those that are the only drawing of a stone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.printed import counted

COVERED = 0.5
"""part of an area from which on outlines that are drawn too are what it is on: it decorates them"""
SAME_AREA = 0.9
"""part of two areas together that they share at least where both fill one stone"""


@dataclass(frozen=True, eq=False, slots=True)
class Filled:
    """The outline of a filled area on a layer: points (n, 2), the first repeated at the end; the number of the `entity`
    it is from, and whether it came with curves."""

    layer: str
    points: FloatArray
    entity: int
    curved: bool


def only_drawings(areas: Sequence[Filled], outlines: Sequence[FloatArray], role: str) -> tuple[list[Filled], list[str]]:
    """Return the areas that are stones (or what else their `role` is), and remarks.

    outlines (n, 2): what is drawn with lines. An area on one of them, a second one on the same stone, and the hole in
    another of the same entity are none.
    """
    if not areas:
        return [], []
    shapes = shapely.make_valid(np.array([shapely.Polygon(area.points) for area in areas]))
    drawn = shapely.union_all(shapely.make_valid(np.array([shapely.Polygon(outline) for outline in outlines])))
    size = shapely.area(shapes)
    inside = shapely.area(shapely.intersection(shapes, drawn)) > COVERED * size
    around = {k: other for k, other in _pairs(shapes, "covered_by") if areas[k].entity == areas[other].entity}
    around = {k: other for k, other in around.items() if size[other] > size[k]}
    left_out = {*np.flatnonzero(inside | (size == 0.0)).tolist()} | {*around}
    for k, other in sorted(_pairs(shapes, "intersects")):
        shared = shapely.intersection(shapes[k], shapes[other]).area
        if k < other and not {k, other} & left_out and shared > SAME_AREA * (size[k] + size[other] - shared):
            left_out.add(other)
    kept = [k for k in range(len(areas)) if k not in left_out]
    holes = sum(other in kept for other in around.values())
    said = [f"{role}: {counted(len(kept), 'outline')} of hatches, solids or faces, where none is drawn"] if kept else []
    said += [f"{role}: WARNING: {counted(holes, 'hole')} in hatches filled"] if holes else []
    beside = len(areas) - len(kept) - len(around)
    said += [f"{role}: {counted(beside, 'filled area')} passed over, on outlines that are drawn"] if beside else []
    return [areas[k] for k in kept], said


def _pairs(shapes: np.ndarray, predicate: str) -> list[tuple[int, int]]:
    """Return the positions of different shapes that are so to each other."""
    first, second = shapely.STRtree(shapes).query(shapes, predicate=predicate)
    return [(k, other) for k, other in zip(first.tolist(), second.tolist(), strict=True) if k != other]
