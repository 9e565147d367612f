"""Closed outlines on layers that were not chosen, beside the stones: they may be stones, and are told."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

import numpy as np
import shapely

from orchestrator.basis.printed import counted
from orchestrator.masonry.sources.closed_outlines import Layers, OnLayer
from orchestrator.masonry.sources.drawing import Drawing

IN_STONES = 0.1
"""part of its area, or of all stones', that an outline has in common with them from which on it is drawn over or round
them"""


def said_of_other_layers(others: Iterable[OnLayer], drawing: Drawing, layers: Layers, tolerance: float) -> list[str]:
    """Return one remark for each layer with closed outlines (n, 2), the first point repeated, that no role has and that
    lie beside the outlines of a drawing, no farther away than the tolerance (m)."""
    outlines = (*drawing.stones, *drawing.supports, *drawing.openings)
    read = [shapely.Polygon(outline) for outline in outlines if len(outline) > 2]
    wall = shapely.union_all(shapely.make_valid(read))
    shapely.prepare(wall)
    beside = Counter[str]()
    for name, outline in others:
        is_closed = len(outline) > 3 and bool(np.linalg.norm(outline[0] - outline[-1]) <= tolerance)
        shape = shapely.Polygon(outline) if is_closed and np.isfinite(outline).all() else shapely.Polygon()
        if shape.is_valid and shape.area and shapely.dwithin(wall, shape, tolerance):
            beside[name] += shape.intersection(wall).area < IN_STONES * min(shape.area, wall.area)
    return [
        f"{counted(number, 'closed outline')} beside the stones left out, on {name!r}, which is not chosen: if stones, "
        f'add --blocks "{layers.blocks},{name}"'
        for name, number in sorted(beside.items())
        if number
    ]
