"""Extra dead loads: what they are, and where on the blocks they stand.

A line load lies on the edges that face upwards: all of them, those at a level, or their part between two x. Its
resultant on a block goes through the middle of what it covers, and is line_load x horizontal width. A force acts at the
centroid, or where it is told.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
import shapely
from annotated_types import Gt

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray, read_only
from orchestrator.basis.checked import Checked
from orchestrator.basis.errors import CaseError
from orchestrator.basis.units import Unit
from orchestrator.masonry.block_properties import block_centroids
from orchestrator.masonry.ties import ON_OUTLINE
from orchestrator.masonry.wall import Wall

STEEP = 1e-9
"""Edges whose outward normal points up by less than this (as a part of 1) are not the top of a block."""
AT_LEVEL = 1e-2
"""part of a block's height by which a part of its top may be off the level of a floor"""
BESIDE = 0.01
"""part of a stretch that may lie before or behind all tops"""
NO_EDGES = read_only(np.zeros((0, 2, 2)))
"""of what does not lie on a top"""

Spread = Literal["volume", "top", "point"]


@dataclass(frozen=True, slots=True)
class DeadLoad(Checked):
    """Extra dead load on blocks, downwards: a force, or a line load on their tops (one of the two).

    The blocks are named, or those with a part of their top at a level: a floor that rests on a course."""

    blocks: tuple[int, ...] = ()
    """ids of the blocks"""
    force: Annotated[float, Gt(0), Unit("N")] | None = None
    """on each block, at its centroid or, of one block, `at` a point"""
    line_load: Annotated[float, Gt(0), Unit("N/m")] | None = None
    """on all edges that face upwards, of `level` on those that lie there, per metre of horizontal projection, over the
    whole thickness of the wall"""
    inertia: bool = False
    """whether the live load acts on its mass too, where it stands"""
    level: Annotated[float, Unit("m")] | None = None
    """height (y) of the blocks' tops, or of a step in them, instead of `blocks`"""
    stretch: tuple[Annotated[float, Unit("m")], ...] = ()
    """the line load lies between these two x only, as in ["1.2 m", "3.4 m"]; left out: on the whole tops"""
    at: tuple[Annotated[float, Unit("m")], ...] = ()
    """x and y of the point where the force acts on the block named, as in ["1.2 m", "2.8 m"]; left out: its centroid"""


@dataclass(frozen=True, eq=False, slots=True)
class PlacedLoads:
    """Sizes (N) of p loads: block (p,), point (p, 2) in m through which the resultant goes, how each is spread: over
    the block's volume, over edges of its top (edges (p,) of (e, 2, 2) in m, none of others), or not at all."""

    block: IntArray
    point: FloatArray
    size: FloatArray
    spread: tuple[Spread, ...]
    edges: tuple[FloatArray, ...]

    def part(self, which: slice) -> PlacedLoads:
        """Return some of the loads."""
        return PlacedLoads(
            self.block[which], self.point[which], self.size[which], self.spread[which], self.edges[which]
        )


def over_volume(block: IntArray, point: FloatArray, size: FloatArray) -> PlacedLoads:
    """Return loads (p,) that are spread over the volume of their blocks; point (p, 2): the centroids."""
    spread: list[Spread] = ["volume"] * len(block)
    return PlacedLoads(block, point, size, tuple(spread), (NO_EDGES,) * len(block))


def joined(one: PlacedLoads, other: PlacedLoads) -> PlacedLoads:
    """Return the loads of both, one after the other."""
    return PlacedLoads(
        np.concatenate([one.block, other.block]),
        np.vstack([one.point, other.point]),
        np.concatenate([one.size, other.size]),
        one.spread + other.spread,
        one.edges + other.edges,
    )


def extra_dead_loads(wall: Wall, loads: tuple[DeadLoad, ...]) -> PlacedLoads:
    """Return the extra dead loads, downwards, one after the other."""
    each = [part for load in loads for part in _parts(wall, load)]
    return PlacedLoads(
        block=np.array([block for block, *_ in each], dtype=np.int64),
        point=np.array([point for _, point, *_ in each]).reshape(-1, 2),
        size=np.array([size for _, _, size, *_ in each], dtype=float),
        spread=tuple(spread for *_, spread, _ in each),
        edges=tuple(edges for *_, edges in each),
    )


def _parts(wall: Wall, load: DeadLoad) -> Iterator[tuple[int, FloatArray, float, Spread, FloatArray]]:
    """Yield block position, point (2,) in m, size in N, spread and edges of each block's part of a load."""
    centroids = block_centroids(wall)
    for position in loaded_blocks(wall, load):
        if load.line_load is None:
            assert load.force is not None
            spread: Spread = "point" if load.at else "volume"
            yield position, np.array(load.at) if load.at else centroids[position], load.force, spread, NO_EDGES
            continue
        edges = edges_under(wall.blocks[position].polygon, load)
        width, middle = middle_of(edges)
        if width > 0.0:
            yield position, middle, load.line_load * width, "top", edges


def edges_under(polygon: FloatArray, load: DeadLoad) -> FloatArray:
    """Return the edges (e, 2, 2) in m of a counter-clockwise polygon that a line load lies on."""
    edges = upper_edges(polygon)
    if load.level is not None:
        edges = edges[at_level(edges, polygon, load.level)]
    return between(edges, load.stretch) if load.stretch else edges


def loaded_blocks(wall: Wall, load: DeadLoad) -> list[int]:
    """Return the positions of the blocks that a load names, or that have a part of their top at its level."""
    if load.level is not None:
        return blocks_at_level(wall, load.level)
    place = wall.place_of
    return [place[wanted] for wanted in load.blocks]


def not_accelerated(wall: Wall, dead: Sequence[DeadLoad], key_in_file: Callable[[str], str] = str) -> list[str]:
    """Return a warning of dead loads whose mass an earthquake does not accelerate, as they are given; none if there are
    none. key_in_file: of a key of theirs, as in "load.dead.0", what the case file calls it."""
    keys = [key_in_file(f"load.dead.{number}") for number, load in enumerate(dead) if not load.inertia]
    force = extra_dead_loads(wall, tuple(load for load in dead if not load.inertia)).size.sum()
    return no_mass_words(float(force), keys)


def no_mass_words(force: float, keys: Sequence[str]) -> list[str]:
    """Return the warning of dead loads that weigh so much (N) and have no mass, by their keys; none if there are
    none."""
    if not keys:
        return []
    return [
        f"WARNING: {force / 1e3:.4g} kN of dead load have weight, but no mass in the seismic verification; if they "
        f"move with the wall, give inertia = true to {', '.join(keys)}"
    ]


def refuse_dead_load(wall: Wall, load: DeadLoad, key: str) -> None:
    """Raise CaseError for a load that contradicts itself or lies on nothing; the blocks it names are known to exist."""
    for one, other in (("force", "line_load"), ("level", "blocks")):
        if (getattr(load, one) in (None, ())) == (getattr(load, other) in (None, ())):
            raise CaseError(key, f"needs one of {one} and {other}", "give one of the two")
    if load.level is not None and not blocks_at_level(wall, load.level):
        tops = sorted({round(height, 3) for b in wall.blocks if not b.fixed for height in levels_of(b.polygon)})
        listed = ", ".join(f"{top:g}" for top in tops[:20])
        remedy = f"tops are at {listed}{', ...' * (len(tops) > 20)} m" if tops else "none is level; name `blocks`"
        raise CaseError(f"{key}.level", f"no block has its top, or a step in it, at {load.level:g} m", remedy)


def refuse_place(wall: Wall, load: DeadLoad, key: str) -> None:
    """Raise CaseError for a stretch or a point that does not go with its load, or lies beside its blocks."""
    if load.stretch:
        if load.line_load is None or len(load.stretch) != 2 or not load.stretch[0] < load.stretch[1]:
            remedy = 'give two x in ascending order with a line_load, as in ["1.2 m", "3.4 m"]'
            raise CaseError(f"{key}.stretch", f"{[*load.stretch]} is no stretch of a line load", remedy)
        low, high = load.stretch
        loaded = extra_dead_loads(wall, (load,)).edges
        if not loaded:
            raise CaseError(f"{key}.stretch", f"no top lies between x = {low:g} and {high:g} m", "correct it")
        first, last = (end(np.vstack(loaded)[..., 0]) for end in (np.min, np.max))
        if high - low - (last - first) > BESIDE * (high - low):
            problem = f"x = {low:g} to {high:g} m lies on tops from {first:g} to {last:g} m only"
            raise CaseError(f"{key}.stretch", problem, "give where the load lies on them, or none for whole tops")
    if load.at:
        if load.force is None or len(load.at) != 2 or len(load.blocks) != 1:
            remedy = 'give x and y with a force on one of the `blocks`, as in ["1.2 m", "2.8 m"]'
            raise CaseError(f"{key}.at", f"{[*load.at]} is no point of a force on one block", remedy)
        outline = shapely.Polygon(wall.blocks[loaded_blocks(wall, load)[0]].polygon)
        if shapely.distance(outline, shapely.Point(load.at)) > ON_OUTLINE * outline.length:
            x, y = load.at
            problem = f"({x:g}, {y:g}) m is not on block {load.blocks[0]}"
            raise CaseError(f"{key}.at", problem, "give a point of the block, or name another one")


def blocks_at_level(wall: Wall, level: float) -> list[int]:
    """Return the positions of the free blocks with an edge that faces upwards at a level (m)."""

    def reaches(polygon: FloatArray) -> bool:
        return bool(at_level(upper_edges(polygon), polygon, level).any())

    return [k for k, block in enumerate(wall.blocks) if not block.fixed and reaches(block.polygon)]


def at_level(edges: FloatArray, polygon: FloatArray, level: float) -> BoolArray:
    """Return which edges (e, 2, 2) of a polygon lie at a level (m), within AT_LEVEL of the polygon's height."""
    found: BoolArray = np.abs(edges[..., 1] - level).max(axis=1) < AT_LEVEL * np.ptp(polygon[:, 1])
    return found


def levels_of(polygon: FloatArray) -> list[float]:
    """Return the heights (m) of the edges of a polygon that face upwards and are level."""
    edges = upper_edges(polygon)
    heights: list[float] = edges[..., 1].mean(axis=1).tolist()
    return [height for edge, height in zip(edges, heights, strict=True) if at_level(edge[None], polygon, height).any()]


def top_of(polygon: FloatArray) -> tuple[float, FloatArray]:
    """Return horizontal width (m) and middle (2,) of the edges of a counter-clockwise polygon that face upwards."""
    return middle_of(upper_edges(polygon))


def middle_of(edges: FloatArray) -> tuple[float, FloatArray]:
    """Return horizontal width (m) and middle (2,) of edges (e, 2, 2) that run towards -x; 0 has no middle."""
    start, end = edges.transpose(1, 0, 2)
    width = start[:, 0] - end[:, 0]
    if not width.sum() > 0.0:
        return 0.0, np.full(2, np.nan)
    return float(width.sum()), np.average(0.5 * (start + end), axis=0, weights=width)


def upper_edges(polygon: FloatArray) -> FloatArray:
    """Return the edges (e, 2, 2) in m of a counter-clockwise polygon that face upwards, so that they run towards -x."""
    start, end = polygon, np.roll(polygon, -1, axis=0)
    above = start[:, 0] - end[:, 0] > STEEP * np.linalg.norm(end - start, axis=1)
    return np.stack([start[above], end[above]], axis=1)


def between(edges: FloatArray, stretch: tuple[float, ...]) -> FloatArray:
    """Return what of edges (e, 2, 2) lies between two x (m)."""
    start, end = edges.transpose(1, 0, 2)
    share = (np.clip([start[:, 0], end[:, 0]], stretch[0], stretch[1]) - start[:, 0]) / (end[:, 0] - start[:, 0])
    cut = start[None] + share[:, :, None] * (end - start)[None]
    return cut[:, share[0] < share[1]].transpose(1, 0, 2)
