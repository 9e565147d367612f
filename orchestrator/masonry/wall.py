"""Blocks and the wall they form (all SI: N, m)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import numpy.typing as npt
import shapely
from annotated_types import Ge, Le

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.basis.errors import CaseError, require_kinds
from orchestrator.basis.printed import as_place, millimetres
from orchestrator.basis.units import Unit
from orchestrator.geometry.ring_geometry import clicked_once, depth_of_overlap, where_it_meets_itself

GRAVITY = 9.81
"""Standard acceleration of gravity used to turn unit weight into density, m/s2."""

LARGEST_COORDINATE = 1e7
"""largest coordinate, m: a double is exact to 2e-9 m there (UTM reaches it), ten times as far no longer to 1e-8"""


LARGEST_COUNT = 100_000
"""blocks of one drawing, or of one pattern"""
LARGEST_TOLERANCE = 0.05
"""m: the largest gap or overlap that may be taken for an error of a drawing"""
LARGEST_MORTAR = 0.1
"""m: the widest mortar joint that may be drawn as a gap"""
ROUNDING = 2.5e-5
"""part of a stone's size (root of the median area) over which outlines are joined: the rounding of a drawing, 0.01 mm
on a stone of 0.4 m"""
DRAWN_TWICE = 0.9
"""part of the smaller of two blocks that they share where one block was drawn twice"""
PLAUSIBLE = (0.1, 200.0)
"""m: a wall that is smaller or larger is probably drawn in another unit (the tallest of masonry has 169 m)"""
EXTREMES = (1e-9, 1e9)
"""thickness, friction and unit weight (SI) that are computed with: products of others overflow or vanish"""
Friction = Annotated[float, Ge(EXTREMES[0]), Le(EXTREMES[1])]
"""a coefficient of friction, wherever it is given"""
Thickness = Annotated[float, Ge(EXTREMES[0]), Le(EXTREMES[1]), Unit("m")]
"""a thickness that replaces the block file's"""
UnitWeight = Annotated[float, Ge(EXTREMES[0]), Le(EXTREMES[1]), Unit("N/m3")]
"""a unit weight that replaces the block file's"""


@dataclass(frozen=True, eq=False, slots=True)
class Block:
    """One stone: `polygon` (n, 2) in m, counter-clockwise, not closed; `unit_weight` in N/m3; `fixed` for supports.

    `material` is a name that block and joint classes refer to. None: thickness (m) and friction are the wall's,
    elastic_modulus (Pa) and poisson_ratio those of the case."""

    id: int
    polygon: FloatArray
    fixed: bool
    unit_weight: float
    material: str = ""
    thickness: float | None = None
    friction: float | None = None
    elastic_modulus: float | None = None
    poisson_ratio: float | None = None

    def __post_init__(self) -> None:
        polygon = self.polygon
        if isinstance(polygon, np.ndarray) and polygon.flags.writeable:  # what is no array `check_wall` refuses
            object.__setattr__(self, "polygon", read_only(polygon, polygon.dtype))


@dataclass(frozen=True, slots=True)
class MortarGap:
    """The joint between blocks `i` < `j` (ids) was drawn as a gap of this thickness (m)."""

    i: int
    j: int
    thickness: float


@dataclass(frozen=True, eq=False, slots=True)
class Wall:
    """Blocks, with the thickness (m) and the coefficient of friction of all that have none of their own, and the
    thickness of mortar joints where it is known. remarks: what is to be said of outlines as they were read."""

    name: str
    blocks: tuple[Block, ...]
    thickness: float
    friction: float
    mortar: tuple[MortarGap, ...] = ()
    remarks: tuple[str, ...] = ()

    @property
    def place_of(self) -> dict[int, int]:
        """Position in `blocks` of every block by its id."""
        return {block.id: position for position, block in enumerate(self.blocks)}


def check_wall(wall: Wall, tolerance: float | None = None) -> None:
    """Raise CaseError for a wall that is not one: shapes, supports, material (`check_blocks`), overlaps.

    Two blocks overlap when they share more than a strip of width `tolerance` (m; None: `rounding_of` the wall) along
    the shorter outline; less is the rounding of a drawing.
    """
    require_kinds("write check_wall(read_blocks(path))", wall=(wall, Wall))
    check_blocks(wall, tolerance)
    refuse_overlaps(wall, rounding_of(wall) if tolerance is None else tolerance)


def rounding_of(wall: Wall) -> float:
    """Return over what distance (m) the wall's outlines are joined unless told otherwise: ROUNDING of a stone."""
    area = shapely.area(shapes(wall))
    free = area[[not block.fixed for block in wall.blocks]]
    return ROUNDING * float(np.sqrt(np.median(free if len(free) else area)))


def check_blocks(wall: Wall, tolerance: float | None) -> None:
    """Raise CaseError for blocks without a shape, thinner than twice the `tolerance` (m; None: `rounding_of` the wall),
    without weight or support."""
    if not wall.blocks:
        raise CaseError("blocks", "there are none", "list the blocks, each with id and polygon, and a support")
    for key, value in (("thickness", wall.thickness), ("friction", wall.friction)):
        if not 0 < value < np.inf:
            raise CaseError(key, f"{value:g} is not a positive number", "give a value above 0")
        refuse_extreme(key, value)
    _refuse_doubled_ids(wall)
    for block in wall.blocks:
        _check_place(block)
    outlines = shapes(wall)
    tolerance = rounding_of(wall) if tolerance is None else tolerance
    simple, length = shapely.is_valid(outlines), shapely.length(outlines)
    area = shapely.area(np.where(simple, outlines, shapely.convex_hull(outlines)))
    for block, *of_block in zip(wall.blocks, simple.tolist(), area.tolist(), length.tolist(), strict=True):
        _check_block(block, tolerance, *of_block)
    for block, forward in zip(wall.blocks, shapely.is_ccw(shapely.get_exterior_ring(outlines)), strict=True):
        if not forward:
            raise CaseError(f"block {block.id}", "its polygon runs clockwise", "list its corners the other way round")
    if not any(block.fixed for block in wall.blocks):
        raise CaseError("blocks", "no block is a support", 'mark the ground as a block with "fixed": true')
    if all(block.fixed for block in wall.blocks):
        raise CaseError("blocks", "every block is a support", 'leave "fixed" out of the blocks of the wall')


def refuse_extreme(key: str, value: float) -> None:
    """Raise CaseError for a thickness, a friction or a unit weight (SI) outside EXTREMES."""
    if not EXTREMES[0] <= value <= EXTREMES[1]:
        of_friction = key.endswith("friction")  # a number without a unit
        problem = f"{value:g} is outside {EXTREMES[0]:g} to {EXTREMES[1]:g}{' (SI)' * (not of_friction)}"
        raise CaseError(key, problem, "give the tangent of an angle" if of_friction else "is its unit right?")


def _refuse_doubled_ids(wall: Wall) -> None:
    seen: set[int] = set()
    for block in wall.blocks:
        if block.id in seen:
            raise CaseError(f"block {block.id}", "two blocks have this id", "give every block its own id")
        seen.add(block.id)


def _check_place(block: Block) -> None:
    key = f"block {block.id}"
    if not isinstance(block.polygon, np.ndarray) or block.polygon.ndim != 2 or block.polygon.shape[1] != 2:
        raise CaseError(key, "its polygon is no array (n, 2)", "give x and y of every corner, in m")
    if len(block.polygon) < 3:
        raise CaseError(key, f"its polygon has {len(block.polygon)} corners", "give at least three")
    if not np.isfinite(block.polygon).all():
        raise CaseError(key, "a coordinate is not a finite number", "give finite coordinates")
    if np.abs(block.polygon).max() > LARGEST_COORDINATE:
        problem = f"lies {np.abs(block.polygon).max():.3g} m from the origin, where numbers are too coarse for joints"
        raise CaseError(key, problem, "subtract a common offset from all coordinates")


def _check_block(block: Block, tolerance: float, simple: bool, area: float, length: float) -> None:
    """Raise CaseError for a block whose outline has this area (m2; of its convex hull if it is not `simple`, as it
    crosses itself) and length (m)."""
    key = f"block {block.id}"
    if area <= 1e-12 * length**2:
        raise CaseError(key, "its polygon has no area", "give at least three corners that are not on one line")
    if not simple:
        remedy = f"list the corners once, in order round the block{_clicked_twice(block.polygon)}"
        at = where_it_meets_itself(block.polygon)
        raise CaseError(key, f"its polygon crosses or touches itself{f' at {as_place(*at)} m' if at else ''}", remedy)
    if area <= tolerance * length:
        problem = f"its polygon is thinner than {2 * tolerance:.3g} m, twice the tolerance of the joints"
        raise CaseError(key, problem, "correct it, or lower joints.tolerance")
    for name in ("unit_weight", "thickness", "friction", "elastic_modulus"):
        value = getattr(block, name)
        if value is not None and not 0 < value < np.inf:
            raise CaseError(key, f"{name} {value:g} is not a positive number", "give a value above 0")
    if block.poisson_ratio is not None and not 0 <= block.poisson_ratio < 0.5:
        raise CaseError(key, f"poisson_ratio {block.poisson_ratio:g} is not from 0 to below 0.5", "correct it")
    refuse_extreme(key, block.unit_weight)
    if block.friction is not None:
        refuse_extreme(f"{key}.friction", block.friction)


def _clicked_twice(polygon: FloatArray) -> str:
    """Return, of an outline that crosses itself, that two of its corners may be one, where that is all."""
    nearest = float(np.linalg.norm(polygon - np.roll(polygon, 1, axis=0), axis=1).min())
    tolerance = np.ceil(1e3 * nearest) / 1e3
    if tolerance > LARGEST_TOLERANCE or not shapely.Polygon(clicked_once(polygon, tolerance)).is_valid:
        return ""
    of_import = f'import the file with --tolerance "{1e3 * tolerance:g} mm"'
    return f"; corners that lie {millimetres(nearest)} apart may be one: {of_import}"


def refuse_overlaps(wall: Wall, tolerance: float) -> None:
    """Raise CaseError for blocks that share more than a strip of width `tolerance` (m) along the shorter outline."""
    outlines = shapes(wall)
    i, j = shapely.STRtree(outlines).query(outlines, predicate="intersects")
    i, j = i[i < j], j[i < j]
    common = shapely.area(shapely.intersection(outlines[i], outlines[j]))
    length = shapely.length(outlines)
    overlaps = np.flatnonzero(common > tolerance * np.minimum(length[i], length[j]))
    if len(overlaps):
        first = min(overlaps, key=lambda pair: (i[pair], j[pair]))
        one, other = wall.blocks[i[first]], wall.blocks[j[first]]
        depth = depth_of_overlap(outlines[i[first]].intersection(outlines[j[first]]))
        problem = f"overlaps block {other.id} by {common[first]:.3g} m2, {millimetres(depth)} deep"
        twice = common[first] > DRAWN_TWICE * min(outlines[i[first]].area, outlines[j[first]].area)
        remedy = "drawn twice? remove one of them" if twice else "correct one of them"
        if not twice and (wider := np.ceil(1.2e3 * depth) / 1e3) <= LARGEST_TOLERANCE:
            remedy += f', or import the file with --tolerance "{1e3 * wider:g} mm" if it is an error'
        raise CaseError(f"block {one.id}", problem, remedy)


def doubted_size(wall: Wall) -> str:
    """Return what is said of a wall whose size speaks for another unit; nothing of others."""
    size = size_of(wall)
    return "" if PLAUSIBLE[0] <= size <= PLAUSIBLE[1] else f"the wall measures {size:.4g} m: is the unit right?"


def size_of(wall: Wall) -> float:
    """Return the larger of length and height of a wall with its supports, m."""
    return float(np.ptp(np.vstack([block.polygon for block in wall.blocks]), axis=0).max())


def shapes(wall: Wall) -> npt.NDArray[np.object_]:
    """Return the blocks as shapely polygons (n,)."""
    counts = [len(block.polygon) for block in wall.blocks]
    corners = np.concatenate([block.polygon for block in wall.blocks])
    corners[np.abs(corners) < np.finfo(float).tiny] = 0.0  # GEOS finds overlaps of subnormal ones
    return shapely.polygons(shapely.linearrings(corners, indices=np.repeat(np.arange(len(counts)), counts)))
