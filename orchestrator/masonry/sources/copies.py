"""Outlines that were drawn twice, by two hands or one on the other -> each once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from scipy.spatial import cKDTree

from orchestrator.basis.arrays import FloatArray

ON_ONE_ANOTHER = 0.5
"""part of the smaller of two outlines that they share at least: thin stones side by side share none"""


def without_copies(outlines: Sequence[FloatArray], within: float) -> tuple[list[int], list[tuple[int, float]]]:
    """Return the positions of the outlines (n, 2) to keep, and those left out, which lie everywhere within `within` (m)
    of one that is kept, with that distance (m)."""
    polygons = np.array([shapely.Polygon(outline) for outline in outlines], dtype=object)
    if len(polygons) < 2:
        return list(range(len(polygons))), []
    pairs = cKDTree(shapely.bounds(polygons)).query_pairs(within, p=np.inf, output_type="ndarray")
    first, second = np.sort(pairs, axis=1).T
    area = shapely.area(polygons)
    common = shapely.area(shapely.intersection(polygons[first], polygons[second]))
    apart = shapely.hausdorff_distance(shapely.boundary(polygons[first]), shapely.boundary(polygons[second]))
    copies = (common > ON_ONE_ANOTHER * np.minimum(area[first], area[second])) & (apart <= within)
    left_out: dict[int, float] = {}
    for k in np.lexsort((second, first)):
        if copies[k] and int(first[k]) not in left_out:
            left_out.setdefault(int(second[k]), float(apart[k]))
    return [k for k in range(len(polygons)) if k not in left_out], sorted(left_out.items())
