"""A drawing of a wall, in whatever file -> Wall: support, openings, healing, numbers.

A drawing knows shapes only; thickness, unit weight and friction are given with it (`Material`).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np
import shapely
from annotated_types import Ge, Gt, Le

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.basis.checked import Checked
from orchestrator.basis.errors import CaseError
from orchestrator.basis.printed import as_place, counted, millimetres
from orchestrator.basis.units import Unit
from orchestrator.geometry.healing import closed_gaps, heal
from orchestrator.geometry.planar_map import OverlapError
from orchestrator.geometry.ring_geometry import where_it_meets_itself, without_spikes
from orchestrator.masonry.sources.copies import once
from orchestrator.masonry.sources.doubtful_stones import IMPLAUSIBLE_SLENDERNESS, doubtful_stones, slenderness
from orchestrator.masonry.sources.mended_outlines import mended, said_of_spikes
from orchestrator.masonry.sources.said_of_healing import ThinStoneError, folded, said_of_healing, thin_stone
from orchestrator.masonry.wall import (
    LARGEST_COUNT,
    LARGEST_MORTAR,
    LARGEST_TOLERANCE,
    PLAUSIBLE,
    Block,
    Friction,
    MortarGap,
    Wall,
    check_blocks,
    check_wall,
    doubted_size,
    refuse_overlaps,
    shapes,
    size_of,
)

WIDER = (2.0, 4.0, 8.0)
"""times the tolerance that are tried on a drawing that is no wall with it"""
FAR_FROM_ORIGIN = 1e4
"""m from the origin beyond which a drawing is moved to it: rounding grows with the coordinates"""
COURSE = 0.05
"""of a stone's size: lower edges that differ by less are one course where blocks are numbered"""
CORNERS_APART = 1.5
"""distance of two corners that belong together, over the width of the mortar joint between them: 2 to the power of 1/2
across the crossing of two joints, more beside an acute corner"""


@dataclass(frozen=True, slots=True)
class Material(Checked):
    """What a drawing does not say."""

    thickness: Annotated[float, Gt(0), Unit("m")]
    """of the whole wall"""
    unit_weight: Annotated[float, Gt(0), Unit("N/m3")] = 20e3
    """of every block"""
    friction: Friction = 0.6
    """coefficient of friction of every joint"""


@dataclass(frozen=True, slots=True)
class HealingSettings(Checked):
    """How far a drawing may be wrong, and the support it may lack."""

    tolerance: Annotated[float, Gt(0), Le(LARGEST_TOLERANCE), Unit("m")] = 1e-3
    """largest gap or overlap that is closed; also how near two ends of lines must be to meet"""
    ground: Annotated[float, Gt(0), Unit("m")] | None = None
    """puts a support under the wall that reaches this far beyond it on both sides; none: supports are drawn"""
    mortar: Annotated[float, Ge(0), Le(LARGEST_MORTAR), Unit("m")] = 0.0
    """widest mortar joint that is drawn as a gap: closed to its middle, its thickness kept with the wall"""


@dataclass(frozen=True, eq=False, slots=True)
class Drawing:
    """Outlines (n, 2) in m, in any order and orientation: stones, supports, openings; `remarks` about the reading;
    `materials` of the stones, none where the drawing does not tell any; `error` in m: over what distance its lines had
    to be joined to close outlines; `curved`: it has arcs, which came as chords."""

    stones: tuple[FloatArray, ...]
    supports: tuple[FloatArray, ...] = ()
    openings: tuple[FloatArray, ...] = ()
    remarks: tuple[str, ...] = field(default=())
    materials: tuple[str, ...] = ()
    error: float = 0.0
    curved: bool = False


class RefusedWallError(CaseError):
    """A drawing that is no wall: `wall` holds its outlines as drawn, `remarks` what reading it told."""

    def __init__(self, key: str, problem: str, remedy: str, wall: Wall, remarks: tuple[str, ...] = ()) -> None:
        super().__init__(key, problem, remedy)
        self.wall, self.remarks = wall, remarks


def wall_of(drawing: Drawing, name: str, material: Material, settings: HealingSettings) -> tuple[Wall, list[str]]:
    """Return the checked wall and remarks: what was left out, moved, healed, and what was not.

    Blocks are numbered from 0: supports, then stones, from below and from the left. Raises
    CaseError for a drawing without blocks or supports and for blocks that overlap by more than the tolerance.
    """
    drawing, slips = _mended(drawing, settings.tolerance)
    _refuse_sizes(drawing)
    drawing, copies = _drawn_once(drawing, settings.tolerance)
    kept, left_out = _outside_openings(drawing)
    stones = [drawing.stones[k] for k in kept]
    supports = list(drawing.supports)
    if settings.ground is not None:
        if supports:
            raise CaseError("--ground", "the drawing has supports of its own", "leave it out, or --supports none")
        supports.append(_ground(np.vstack(stones), settings.ground))
    if not supports:
        raise _without_supports(drawing)
    order = _order(stones)
    outlines, moved = _near_origin([*(supports[k] for k in _order(supports)), *(stones[k] for k in order)])
    told = [drawing.materials[kept[k]] for k in order] if drawing.materials else [""] * len(order)
    blocks = tuple(
        Block(k, _counter_clockwise(outline), k < len(supports), material.unit_weight, name)
        for k, (outline, name) in enumerate(zip(outlines, [""] * len(supports) + told, strict=True))
    )
    drawn = Wall(name, blocks, material.thickness, material.friction)
    try:
        wall, said = closed(drawn, settings, drawing.error, drawing.curved)
    except RefusedWallError as error:
        raise RefusedWallError(error.key, error.problem, error.remedy, error.wall, drawing.remarks) from None
    return wall, [*said, *drawing.remarks, *slips, *copies, *left_out, *moved, *implausible(wall)]


def _without_supports(drawing: Drawing) -> CaseError:
    """Return the complaint about a drawing without supports, with what in it is hidden, or does not close."""
    hidden = [remark.removeprefix("WARNING: ") for remark in drawing.remarks if "passed over" in remark]
    hidden = [remark for remark in hidden if " hidden " in remark]
    remedy = "show what is hidden" if hidden else "draw them on their own layer"
    warned = [remark.partition("supports: WARNING: ")[2] for remark in drawing.remarks]
    lines = [*filter(None, warned)][:1]
    if lines and not hidden:
        remedy = "draw each as a closed outline"
    problem = "; ".join(["the drawing has none", *hidden, *lines])
    return CaseError("supports", problem, f'{remedy}, or give --ground "200 mm"')


def closed(
    drawn: Wall, settings: HealingSettings, known_error: float = 0.0, curved: bool = False
) -> tuple[Wall, list[str]]:
    """Return the checked wall with gaps and overlaps of its outlines closed, and remarks: what was not closed, and what
    was. known_error, curved: as of a Drawing. Raises CaseError with the place of a block."""
    within = max(settings.tolerance, CORNERS_APART * settings.mortar)
    blocks, told = list[Block](), list[str]()
    for block in drawn.blocks:
        polygon, spikes = without_spikes(block.polygon, settings.tolerance)
        told += said_of_spikes(f"the outline of block {block.id}", block.polygon, spikes)
        blocks.append(replace(block, polygon=read_only(polygon)))
    drawn = replace(drawn, blocks=tuple(blocks))
    try:
        check_blocks(drawn, 0.0)
        wall, said = _closed_within(drawn, within, bool(settings.mortar), known_error, curved)
        return wall, [*told, *said]
    except CaseError as error:
        located, wider = _located(error, drawn), None
        if not isinstance(error, ThinStoneError):
            wider = _tolerance_that_closes(drawn, within, bool(settings.mortar), known_error, curved)
        closes = "may close the wall: curves are read anew with it" if curved else "closes the wall"
        remedy = f'--tolerance "{1e3 * wider:g} mm" {closes}' if wider else located.remedy
        remedy = doubted_size(drawn) or remedy
        raise RefusedWallError(located.key, located.problem, remedy, drawn) from None


def _closed_within(
    drawn: Wall, within: float, has_mortar: bool, known_error: float, curved: bool
) -> tuple[Wall, list[str]]:
    """Return the checked wall with gaps and overlaps up to `within` (m) closed, and remarks. Raises CaseError."""
    refuse_overlaps(drawn, within)
    try:
        polygons, joined = heal([block.polygon for block in drawn.blocks], within, known_error, curved)
    except OverlapError as error:
        raise folded(drawn, error, within) from None
    blocks = tuple(replace(b, polygon=polygon) for b, polygon in zip(drawn.blocks, polygons, strict=True))
    wall = replace(drawn, blocks=blocks)
    if has_mortar:
        mortar = {(blocks[gap.i].id, blocks[gap.j].id): gap.width for gap in closed_gaps(joined) if gap.width > 0}
        mortar = {(known.i, known.j): known.thickness for known in drawn.mortar} | mortar
        wall = replace(wall, mortar=tuple(MortarGap(i, j, width) for (i, j), width in sorted(mortar.items())))
    _refuse_what_healing_spoilt(wall, drawn, within)
    return wall, said_of_healing(joined, wall, within)


def _tolerance_that_closes(
    drawn: Wall, within: float, has_mortar: bool, known_error: float, curved: bool
) -> float | None:
    """Return a larger tolerance (m) with which the drawing is a wall, the first without warnings if any is; or None."""
    if not shapely.is_valid(shapes(drawn)).all():  # no overlap of an outline that crosses itself is known
        return None
    closing = None
    for wider in (within * factor for factor in WIDER if within * factor <= LARGEST_TOLERANCE):
        try:
            _, said = _closed_within(drawn, wider, has_mortar, known_error, curved)
        except CaseError:
            continue
        closing = closing or wider
        if not any("WARNING" in remark for remark in said):
            return wider
    return closing


def _refuse_what_healing_spoilt(wall: Wall, drawn: Wall, within: float) -> None:
    """Raise CaseError for a healed wall that is none, though it was one as drawn."""
    try:
        check_wall(wall)
    except CaseError as error:
        named = (block for block in drawn.blocks if error.key == f"block {block.id}")
        if thin := next((thin_stone(block, within) for block in named), None):
            raise thin from None
        problem = f"{error.problem} where gaps and overlaps up to {millimetres(within)} are closed"
        raise CaseError(error.key, problem, "correct the corners there") from None


def _located(error: CaseError, wall: Wall) -> CaseError:
    """Return the complaint about a block with its place: its number is nowhere to be seen yet."""
    for block in wall.blocks:
        if error.key == f"block {block.id}":
            x, y = block.polygon.mean(axis=0)
            return CaseError(f"{error.key} at {as_place(x, y)} m", error.problem, error.remedy)
    return error


def _refuse_sizes(drawing: Drawing) -> None:
    if not drawing.stones:
        warned = "; ".join(remark.partition("WARNING: ")[2] for remark in drawing.remarks if "WARNING" in remark)
        raise CaseError("blocks", "the drawing has none", warned or "draw every block as a closed outline")
    if len(drawing.stones) + len(drawing.supports) + len(drawing.openings) > LARGEST_COUNT:
        raise CaseError("blocks", f"more than {LARGEST_COUNT}", "import the wall in parts")
    for outline in (*drawing.stones, *drawing.supports, *drawing.openings):
        if not (np.abs(outline) < 1e9).all():
            raise CaseError("blocks", "a coordinate is not a number below 1e9 m", "correct the drawing or its unit")
        if len(outline) < 3 or not shapely.Polygon(outline).is_valid or shapely.Polygon(outline).area == 0.0:
            key = f"outline at {as_place(*outline[0])} m"
            at = where_it_meets_itself(outline) if len(outline) > 2 else None
            problem = f"it crosses or touches itself at {as_place(*at)} m" if at else "it has no area"
            raise CaseError(key, problem, "draw its corners in order")


def _mended(drawing: Drawing, tolerance: float) -> tuple[Drawing, list[str]]:
    """Return the drawing with outlines mended that cross themselves by a slip of the hand within the tolerance (m)."""
    drawn = (*drawing.stones, *drawing.supports, *drawing.openings)
    if not all((np.abs(outline) < 1e9).all() for outline in drawn):
        return drawing, []
    outlines, said = mended(drawn, tolerance)
    ends = np.cumsum([len(drawing.stones), len(drawing.supports)])
    stones, supports, openings = outlines[: ends[0]], outlines[ends[0] : ends[1]], outlines[ends[1] :]
    return replace(drawing, stones=tuple(stones), supports=tuple(supports), openings=tuple(openings)), said


def _drawn_once(drawing: Drawing, tolerance: float) -> tuple[Drawing, list[str]]:
    """Return the drawing without outlines that are copies of others within the tolerance (m), and remarks."""
    of_blocks, said = once("blocks", drawing.stones, tolerance)
    of_supports, more = once("supports", drawing.supports, tolerance)
    stones = tuple(drawing.stones[k] for k in of_blocks)
    materials = tuple(drawing.materials[k] for k in of_blocks) if drawing.materials else ()
    supports = tuple(drawing.supports[k] for k in of_supports)
    return replace(drawing, stones=stones, materials=materials, supports=supports), [*said, *more]


def _outside_openings(drawing: Drawing) -> tuple[list[int], list[str]]:
    """Return which stones lie outside every opening; one that lies half in is drawn wrong (CaseError)."""
    if not drawing.openings:
        return list(range(len(drawing.stones))), []
    void = shapely.union_all([shapely.Polygon(outline) for outline in drawing.openings])
    polygons = [shapely.Polygon(outline) for outline in drawing.stones]
    part = [void.intersection(polygon).area / polygon.area for polygon in polygons]
    for polygon, inside in zip(polygons, part, strict=True):
        if 0.1 < inside < 0.9:
            x, y = polygon.centroid.x, polygon.centroid.y
            raise CaseError(f"block at {as_place(x, y)} m", f"lies by {inside:.0%} in an opening", "cut it there")
    kept = [k for k, inside in enumerate(part) if inside < 0.5]
    left_out = len(drawing.stones) - len(kept)
    if not kept:
        raise CaseError("openings", "every block lies in one", "is an outline of the wall drawn on their layer?")
    return kept, [f"{counted(left_out, 'outline')} inside openings left out"] if left_out else []


def _ground(corners: FloatArray, beyond: float) -> FloatArray:
    left, right, top = corners[:, 0].min() - beyond, corners[:, 0].max() + beyond, corners[:, 1].min()
    return np.array([[left, top - beyond], [right, top - beyond], [right, top], [left, top]])


def _order(outlines: list[FloatArray]) -> list[int]:
    """Return the order by courses from below (lower edges that differ by less than COURSE of a stone are one course),
    left to right."""
    if not outlines:
        return []
    lower = np.array([outline[:, 1].min() for outline in outlines])
    size = float(np.median(np.sqrt([shapely.Polygon(outline).area for outline in outlines])))
    order = np.argsort(lower, kind="stable")
    course = np.empty(len(outlines))
    course[order] = np.cumsum(np.diff(lower[order], prepend=lower[order[:1]]) > COURSE * size)
    return np.lexsort((np.array([o[:, 0].min() for o in outlines]), course)).tolist()


def _near_origin(outlines: list[FloatArray]) -> tuple[list[FloatArray], list[str]]:
    corners = np.vstack(outlines)
    if np.abs(corners).max() < FAR_FROM_ORIGIN:
        return outlines, []
    origin = np.floor(corners.min(axis=0))
    return [outline - origin for outline in outlines], [f"moved by ({-origin[0]:.0f}, {-origin[1]:.0f}) m"]


def implausible(wall: Wall) -> list[str]:
    """Return warnings for a wall whose size speaks for another unit than the file's, for slivers between stones, and
    for stones that may be two."""
    warnings = [
        f"WARNING: block {block.id} is {ratio:.0f} times as long as wide: it may fall out of the wall, which ends "
        "the curve; if it is an error of the drawing, unite it with its neighbour"
        for block in wall.blocks
        if not block.fixed and (ratio := slenderness(shapely.Polygon(block.polygon))) > IMPLAUSIBLE_SLENDERNESS
    ]
    doubt = doubted_size(wall)
    return [*warnings, *doubtful_stones(wall), *([f"WARNING: {doubt}"] if doubt else [])]


def refuse_implausible_size(wall: Wall) -> None:
    """Raise CaseError for a wall that no stone would carry: its pushover could only end under its own weight."""
    if (size := size_of(wall)) > PLAUSIBLE[1]:
        problem = f"the wall measures {size:.4g} m; none above {PLAUSIBLE[1]:g} m is pushed over"
        raise CaseError("units.length", problem, "state the unit that the coordinates are in (mm, cm, m)")


def _counter_clockwise(outline: FloatArray) -> FloatArray:
    return read_only(outline if shapely.LinearRing(outline).is_ccw else outline[::-1])
