"""Piers and spandrels: the parts of a wall beside and between its openings, and the joints that cut through them.

    opening   what the stones leave free within the rectangle around them, away from its sides and top, and larger than
              a mean stone
    storey    openings that stand beside each other over half the height of the lower one or more
    pier      solid between the openings of a storey, over the height that all of them share
    spandrel  solid above or below an opening, along the vertical line through its middle

A section follows joints: it parts the free blocks whose centroids lie beyond a line from all others. What crosses it is
then in exact balance with the loads beyond, whatever the bond.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from orchestrator.basis.arrays import FloatArray, IntArray, read_only
from orchestrator.masonry.block_properties import block_areas, block_centroids
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.wall import Wall

SHARED = 0.5
"""part of the lower one's height over which two openings of a storey stand beside each other"""
DRAWN_OPEN = 1e-3
"""part of a stone's size below which what is free between stones is no opening but a joint drawn open, and of a wall's
below which what is solid is the rounding of an edge"""


@dataclass(frozen=True, slots=True)
class Opening:
    """The rectangle around an opening, m."""

    left: float
    right: float
    bottom: float
    top: float

    @property
    def middle(self) -> tuple[float, float]:
        """x and y of its middle, m."""
        return 0.5 * (self.left + self.right), 0.5 * (self.bottom + self.top)


@dataclass(frozen=True, slots=True)
class Panel:
    """A pier, `horizontal` False, or a spandrel: the rectangle left, right, bottom, top in m, and where it is cut."""

    name: str
    horizontal: bool
    left: float
    right: float
    bottom: float
    top: float

    @property
    def depth(self) -> float:
        """Size along its sections, m: width of a pier, height of a spandrel."""
        return self.top - self.bottom if self.horizontal else self.right - self.left


@dataclass(frozen=True, eq=False, slots=True)
class Section:
    """The joints (s,) that cut a panel at `at` (x of a spandrel, y of a pier, m); sign (s,) is +1 where block i is the
    lower or left one, else -1; lower, the positions of the blocks on that side; centre (2,): middle of the section."""

    panel: Panel
    at: float
    joints: IntArray
    sign: FloatArray
    lower: IntArray
    centre: FloatArray


def openings(wall: Wall) -> tuple[Opening, ...]:
    """Return the openings of a wall, from below and from the left."""
    stones = [shapely.Polygon(block.polygon) for block in wall.blocks]
    free = [not block.fixed for block in wall.blocks]
    areas = block_areas(wall)[free]
    gap = DRAWN_OPEN * float(np.sqrt(areas.mean()))
    left, bottom, right, top = shapely.total_bounds([stone for stone, moves in zip(stones, free, strict=True) if moves])
    left_free = shapely.box(left, bottom, right, top).difference(shapely.union_all(shapely.buffer(stones, gap)))
    holes = []
    for part in shapely.get_parts(shapely.multipolygons(shapely.get_parts(left_free))):
        x0, y0, x1, y1 = part.bounds
        if part.area > areas.mean() and min(x0 - left, right - x1, top - y1) > 2.0 * gap:
            holes.append(Opening(x0 - gap, x1 + gap, y0 - gap if y0 > bottom else y0, y1 + gap))
    return tuple(sorted(holes, key=lambda o: (round(o.middle[1] / gap), o.left)))


def storeys(holes: Sequence[Opening]) -> list[list[Opening]]:
    """Return openings storey by storey, from below."""
    rows: list[list[Opening]] = []
    for opening in sorted(holes, key=lambda o: o.middle[1]):
        row = rows[-1] if rows else []
        bottom, top = _shared_height([*row, opening])
        lowest = min(o.top - o.bottom for o in [*row, opening])
        if row and top - bottom >= SHARED * lowest:
            row.append(opening)
        else:
            rows.append([opening])
    return [sorted(row, key=lambda o: o.left) for row in rows]


def _shared_height(row: Sequence[Opening]) -> tuple[float, float]:
    return max(o.bottom for o in row), min(o.top for o in row)


def piers(wall: Wall) -> tuple[Panel, ...]:
    """Return the piers of every storey, from below and from the left; none for a wall without openings."""
    solid, panels = _solid(wall), []
    for number, row in enumerate(storeys(openings(wall)), 1):
        bottom, top = _shared_height(row)
        for place, (left, right) in enumerate(_pieces(solid, 1, 0.5 * (bottom + top)), 1):
            panels.append(Panel(f"pier {number}.{place}", False, left, right, bottom, top))
    return tuple(panels)


def spandrels(wall: Wall) -> tuple[Panel, ...]:
    """Return the spandrels above and below every opening, storey by storey; each part of the wall once."""
    solid, panels, seen = _solid(wall), [], set()
    for number, row in enumerate(storeys(openings(wall)), 1):
        for place, opening in enumerate(row, 1):
            for bottom, top in _pieces(solid, 0, opening.middle[0]):
                where = "above" if bottom >= opening.middle[1] else "below"
                beside = (
                    bottom <= opening.top + DRAWN_OPEN * (top - bottom) if where == "above" else top >= opening.bottom
                )
                key = (round(opening.middle[0], 3), round(bottom, 3))
                if beside and key not in seen:
                    seen.add(key)
                    name = f"spandrel {where} {number}.{place}"
                    panels.append(Panel(name, True, opening.left, opening.right, bottom, top))
    return tuple(panels)


def _solid(wall: Wall) -> shapely.Geometry:
    """Return the free stones as one shape."""
    stones = [shapely.Polygon(block.polygon) for block in wall.blocks if not block.fixed]
    gap = DRAWN_OPEN * float(np.sqrt(shapely.area(stones).mean()))
    closed = shapely.union_all(shapely.buffer(stones, gap, join_style="mitre"))
    return shapely.make_valid(shapely.buffer(closed, -gap, join_style="mitre"))  # mitres may cross at a sharp corner


def _pieces(solid: shapely.Geometry, axis: int, at: float) -> list[tuple[float, float]]:
    """Return from where to where a line (y = at for axis 1, x = at for axis 0) runs through solid, m."""
    bounds = solid.bounds
    along = 1 - axis
    ends = [[0.0, 0.0], [0.0, 0.0]]
    for point, end in zip(ends, (bounds[along], bounds[2 + along]), strict=True):
        point[axis], point[along] = at, end
    parts = shapely.get_parts(solid.intersection(shapely.LineString(ends)))
    shortest = DRAWN_OPEN * (bounds[2 + along] - bounds[along])
    return sorted((part.bounds[along], part.bounds[2 + along]) for part in parts if part.length > shortest)


def cut(assemblage: Assemblage, panels: Sequence[Panel], at: float) -> tuple[Section, ...]:
    """Return the sections at `at` of panels of one row: all piers of a storey, or all spandrels over each other.

    Every joint that the cut opens belongs to the panel it is nearest to: together they carry all that crosses.
    """
    axis = 0 if panels[0].horizontal else 1
    wall = assemblage.wall
    beyond = block_centroids(wall)[:, axis] > at
    free = np.array([not block.fixed for block in wall.blocks])
    beyond &= free
    first, second = beyond[assemblage.joints.i], beyond[assemblage.joints.j]
    crossing = first != second
    if axis == 0:  # a support carries what reaches it: it is on neither side of a vertical cut
        crossing &= free[assemblage.joints.i] & free[assemblage.joints.j]
    joints = np.flatnonzero(crossing)
    along = assemblage.joints.centroid[joints, 1 - axis]
    ends = [(p.bottom, p.top) if p.horizontal else (p.left, p.right) for p in panels]
    distance = np.array([np.maximum(np.maximum(low - along, along - high), 0.0) for low, high in ends])
    owner = distance.argmin(axis=0) if len(joints) else np.zeros(0, dtype=np.int64)
    sections = []
    for number, (panel, (low, high)) in enumerate(zip(panels, ends, strict=True)):
        own = joints[owner == number]
        sign = np.where(second[own], 1.0, -1.0)
        lower = np.unique(np.where(second[own], assemblage.joints.i[own], assemblage.joints.j[own]))
        centre = np.array([at, at])
        centre[1 - axis] = 0.5 * (low + high)
        sections.append(Section(panel, at, own, read_only(sign), lower, read_only(centre)))
    return tuple(sections)


def rows(panels: Sequence[Panel]) -> list[list[Panel]]:
    """Return panels that one cut goes through: piers of one storey, spandrels over each other."""
    in_one_cut: dict[tuple[float, float], list[Panel]] = {}
    for panel in panels:
        key = (panel.left, panel.right) if panel.horizontal else (panel.bottom, panel.top)
        in_one_cut.setdefault(key, []).append(panel)
    return list(in_one_cut.values())
