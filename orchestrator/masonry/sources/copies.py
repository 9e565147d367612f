"""Outlines that were drawn twice, by two hands or one on the other -> each once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np
import shapely
from scipy.spatial import cKDTree

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.printed import as_place, millimetres
from orchestrator.masonry.sources.said_of_healing import NOT_SEEN
from orchestrator.masonry.wall import Wall

ON_ONE_ANOTHER = 0.5
"""part of the smaller of two outlines that they share at least: thin stones side by side share none"""


def without_copies(outlines: Sequence[FloatArray], within: float) -> tuple[list[int], list[tuple[int, float]]]:
    """Return the positions of the outlines (n, 2) to keep, and those left out, which lie everywhere within `within` (m)
    of one that is kept, with that distance (m). Outlines that cross themselves are kept."""
    polygons = np.array([shapely.Polygon(outline) for outline in outlines], dtype=object)
    if len(polygons) < 2:
        return list(range(len(polygons))), []
    pairs = cKDTree(shapely.bounds(polygons)).query_pairs(within, p=np.inf, output_type="ndarray")
    pairs = pairs[shapely.is_valid(polygons)[pairs].all(axis=1)]
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


def once(role: str, outlines: Sequence[FloatArray], tolerance: float) -> tuple[list[int], list[str]]:
    """Return the positions of the outlines of a role to keep where some were drawn twice, and a remark on that."""
    kept, copies = without_copies(outlines, tolerance)
    if not copies:
        return kept, []
    x, y = outlines[copies[0][0]].mean(axis=0)
    apart = max(distance for _, distance in copies)
    off = f", up to {millimetres(apart)} apart" if apart > NOT_SEEN else ""
    outlined = "outlines" if len(copies) > 1 else "outline"
    return kept, [f"{role}: {len(copies)} {outlined} drawn twice{off}, kept once; at {as_place(x, y)} m"]


def drawn_once(wall: Wall, tolerance: float) -> tuple[Wall, list[str]]:
    """Return the wall without blocks that are copies of others within the tolerance (m), and remarks.

    A copy has everything but its number from another block, and no mortar by that number.
    """
    named = {block for joint in wall.mortar for block in (joint.i, joint.j)}
    alike = dict[tuple[Any, ...], list[int]]()
    for k, block in enumerate(wall.blocks):
        of_it = [getattr(block, one.name) for one in fields(block) if one.name not in ("id", "polygon")]
        alike.setdefault((*of_it, block.id if block.id in named else None), []).append(k)
    kept, said = list[int](), list[str]()
    for positions in alike.values():
        role = "supports" if wall.blocks[positions[0]].fixed else "blocks"
        of_these, more = once(role, [wall.blocks[k].polygon for k in positions], tolerance)
        kept += [positions[k] for k in of_these]
        said += more
    return replace(wall, blocks=tuple(wall.blocks[k] for k in sorted(kept))), said
