"""Piers and spandrels: the parts of a wall beside and between its openings, and the joints that cut through them.

    opening   what the stones leave free within the rectangle around them, away from its sides and top, and larger than
              a mean stone
    storey    openings that stand beside each other over half the height of the lower one or more
    pier      solid between the openings of a storey, over the height that all of them share, and no opening of another
    spandrel  solid above or below an opening, along the vertical line through its middle

A section follows joints: it parts the free blocks whose centroids lie beyond a line from all others. What crosses it is
then in exact balance with the loads beyond, whatever the bond. A block whose centroid lies on the line is half beyond
it: the section is the mean of those before and behind the block, and the same in a mirror.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np
import shapely

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray, read_only
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
    """A pier, `horizontal` False, or a spandrel: the rectangle left, right, bottom, top in m; line (p, 2): from
    where to where the line through its middle that cuts it runs through solid, m, in the panel itself and in others."""

    name: str
    horizontal: bool
    left: float
    right: float
    bottom: float
    top: float
    line: tuple[tuple[float, float], ...]

    @property
    def ends(self) -> tuple[float, float]:
        """From where to where its sections run, m."""
        return (self.bottom, self.top) if self.horizontal else (self.left, self.right)

    def owns(self, along: FloatArray) -> BoolArray:
        """Return which points of its line, at `along` (s,) m, are nearer to it than to other solid."""
        distance = np.array([np.maximum(np.maximum(low - along, along - high), 0.0) for low, high in self.line])
        return np.asarray(distance.argmin(axis=0) == self.line.index(self.ends))

    @property
    def depth(self) -> float:
        """Size along its sections, m: width of a pier, height of a spandrel."""
        return self.top - self.bottom if self.horizontal else self.right - self.left


@dataclass(frozen=True, eq=False, slots=True)
class Section:
    """The joints (s,) that cut a panel at `at` (x of a spandrel, y of a pier, m); sign (s,) is +1 where block i is the
    lower or left one, else -1, and half of it beside a block that lies on the line; lower, the positions of the blocks
    on that side; centre (2,): middle of the section."""

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


def _height_of_piers(row: Sequence[Opening], others: Sequence[Opening]) -> tuple[float, float]:
    """Return the height that a storey's openings share, up to the sills and down to the heads of `others`."""
    bottom, top = _shared_height(row)
    middle = 0.5 * (bottom + top)
    sills = [one.bottom for one in others if one.bottom > middle]
    heads = [one.top for one in others if one.top < middle]
    return max([bottom, *heads]), min([top, *sills])


def piers(wall: Wall) -> tuple[Panel, ...]:
    """Return the piers of every storey, from below and from the left; none for a wall without openings."""
    solid, panels, rows = _solid(wall), [], storeys(openings(wall))
    for number, row in enumerate(rows, 1):
        bottom, top = _height_of_piers(row, [opening for other in rows if other is not row for opening in other])
        line = _pieces(solid, 1, 0.5 * (bottom + top))
        for place, (left, right) in enumerate(line, 1):
            panels.append(Panel(f"pier {number}.{place}", False, left, right, bottom, top, line))
    return tuple(panels)


def spandrels(wall: Wall) -> tuple[Panel, ...]:
    """Return the spandrels above and below every opening, storey by storey; each part of the wall once."""
    solid = _solid(wall)
    panels: list[Panel] = []
    for number, row in enumerate(storeys(openings(wall)), 1):
        for place, opening in enumerate(row, 1):
            line = _pieces(solid, 0, opening.middle[0])
            for bottom, top in line:
                where = "above" if bottom >= opening.middle[1] else "below"
                beside = (
                    bottom <= opening.top + DRAWN_OPEN * (top - bottom) if where == "above" else top >= opening.bottom
                )
                panel = Panel(
                    f"spandrel {where} {number}.{place}", True, opening.left, opening.right, bottom, top, line
                )
                if beside and not any(_is_same(panel, other) for other in panels):
                    panels.append(panel)
    return tuple(panels)


def _is_same(panel: Panel, other: Panel) -> bool:
    """Return whether two spandrels are one, between openings one above the other."""
    apart = np.subtract(
        (panel.left, panel.right, panel.bottom, panel.top), (other.left, other.right, other.bottom, other.top)
    )
    return float(np.abs(apart).max()) <= DRAWN_OPEN * panel.depth


def _solid(wall: Wall) -> shapely.Geometry:
    """Return the free stones as one shape."""
    stones = [shapely.Polygon(block.polygon) for block in wall.blocks if not block.fixed]
    gap = DRAWN_OPEN * float(np.sqrt(shapely.area(stones).mean()))
    closed = shapely.union_all(shapely.buffer(stones, gap, join_style="mitre"))
    return shapely.make_valid(shapely.buffer(closed, -gap, join_style="mitre"))  # mitres may cross at a sharp corner


def _pieces(solid: shapely.Geometry, axis: int, at: float) -> tuple[tuple[float, float], ...]:
    """Return from where to where a line (y = at for axis 1, x = at for axis 0) runs through solid, m."""
    bounds = solid.bounds
    along = 1 - axis
    ends = [[0.0, 0.0], [0.0, 0.0]]
    for point, end in zip(ends, (bounds[along], bounds[2 + along]), strict=True):
        point[axis], point[along] = at, end
    parts = shapely.get_parts(solid.intersection(shapely.LineString(ends)))
    shortest = DRAWN_OPEN * (bounds[2 + along] - bounds[along])
    return tuple(sorted((part.bounds[along], part.bounds[2 + along]) for part in parts if part.length > shortest))


def cut(assemblage: Assemblage, panel: Panel, at: float) -> Section:
    """Return the section of a panel at `at` m.

    Every joint that the cut opens belongs to the solid it is nearest to: that on the panel's line, together, carries
    all that crosses.
    """
    axis = 0 if panel.horizontal else 1
    wall = assemblage.wall
    free = np.array([not block.fixed for block in wall.blocks])
    beyond = np.where(free, beyond_line(wall, axis, at), 0.0)
    rise = beyond[assemblage.joints.j] - beyond[assemblage.joints.i]
    if panel.horizontal:  # a support carries what reaches it: it is on neither side of a vertical cut
        rise[~(free[assemblage.joints.i] & free[assemblage.joints.j])] = 0.0
    joints = np.flatnonzero(rise)
    own = joints[panel.owns(assemblage.joints.centroid[joints, 1 - axis])]
    centre = np.array([at, at])
    centre[1 - axis] = 0.5 * sum(panel.ends)
    lower = np.unique(np.where(rise[own] > 0.0, assemblage.joints.i[own], assemblage.joints.j[own]))
    return Section(panel, at, own, read_only(rise[own]), lower, read_only(centre))


def beyond_line(wall: Wall, axis: int, at: float) -> FloatArray:
    """Return 1 for blocks (n,) whose centroid is beyond a line at `at` m, 0 before it and 1/2 on it."""
    over, on = block_centroids(wall)[:, axis] - at, DRAWN_OPEN * np.sqrt(block_areas(wall))
    return np.asarray(0.5 * ((over > on).astype(float) + (over > -on)))


def in_storeys(panels: Sequence[Panel]) -> list[list[Panel]]:
    """Return piers storey by storey."""
    return [list(row) for _, row in groupby(panels, key=lambda pier: (pier.bottom, pier.top))]
