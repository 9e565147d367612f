"""Holes of the size of a stone or two between stones: left out, or a small opening; said without judging."""

from __future__ import annotations

import numpy as np
import shapely

from orchestrator.basis.printed import as_place, counted, few
from orchestrator.masonry.wall import Wall, shapes

SIZES = (0.25, 2.2)
"""times the median and the largest area of the stones between which a hole is of the size of a stone or two; doors and
windows are larger, what is left between stones that do not fit is smaller"""
CRACK = 1e-3
"""part of a stone's size (root of the median area): joints that are open by less enclose a hole all the same"""


def said_holes(wall: Wall) -> list[str]:
    """Return a remark on holes of the size of a stone or two, with place and size of the first, or none."""
    outlines = shapes(wall)
    area = shapely.area(outlines)[[not block.fixed for block in wall.blocks]]
    if not len(area):
        return []
    median, largest = float(np.median(area)), float(area.max())
    crack = 0.5 * CRACK * np.sqrt(median)
    together = shapely.union_all(shapely.buffer(outlines, crack, join_style="mitre"))
    rings = [shapely.Polygon(ring) for part in shapely.get_parts(together) for ring in part.interiors]
    whole = shapely.buffer(rings, crack, join_style="mitre")
    holes = [hole for hole in whole if SIZES[0] * median < hole.area < SIZES[1] * largest]
    named = [_place(hole) for hole in sorted(holes, key=lambda hole: hole.bounds[1::-1])]
    said = f"{counted(len(holes), 'hole')} of the size of a stone or two between stones: {few(named)}"
    return [said] if holes else []


def _place(hole: shapely.Polygon) -> str:
    left, bottom, right, top = hole.bounds
    return f"{right - left:.3g} m x {top - bottom:.3g} m at {as_place(hole.centroid.x, hole.centroid.y)} m"
