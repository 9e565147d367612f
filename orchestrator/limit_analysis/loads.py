"""Loads on the blocks: what stands still (dead) and what lambda multiplies (live), as forces at their centroids.

    dead    weight and extra dead loads, vertical
    live    masses x direction, where a mass is a block's weight at its centroid, or an extra dead load with `inertia`
            where it stands; "mass_height" multiplies by the height above the base, scaled to the same resultant;
            "per_block" are given forces at the centroids of the blocks named

The direction is +x or -x, turned upwards by `inclination`. Only the part along x changes sign with the direction: a
wall's mirror image under the opposite load has the same answer.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Annotated, Literal

import numpy as np
import numpy.typing as npt
from annotated_types import Ge, Gt, Le, MinLen

from orchestrator.errors import CaseError
from orchestrator.masonry.geometry import block_centroids, block_weights
from orchestrator.masonry.wall import FloatArray, IntArray, Wall, read_only
from orchestrator.units import Unit

STEEP = 1e-9
"""Edges whose outward normal points up by less than this (as a part of 1) are not the top of a block."""


AT_LEVEL = 2e-3
"""m by which the top of a block may be off the level of a floor"""


@dataclass(frozen=True, slots=True)
class DeadLoad:
    """Extra dead load on blocks, downwards: a force on each, or a line load on their tops (one of the two).

    The blocks are named, or those whose tops lie at a level: a floor that rests on a course."""

    blocks: tuple[int, ...] = ()
    """ids of the blocks"""
    force: Annotated[float, Unit("N"), Gt(0)] | None = None
    """on each block, at its centroid"""
    line_load: Annotated[float, Unit("N/m"), Gt(0)] | None = None
    """on all edges that face upwards, per metre of horizontal projection, over the wall's whole thickness"""
    inertia: bool = False
    """whether the live load acts on its mass too, where it stands"""
    level: Annotated[float, Unit("m")] | None = None
    """height of the blocks' tops (y), instead of `blocks`"""


@dataclass(frozen=True, slots=True)
class LiveLoad:
    """Live load given per block, for distribution = "per_block"."""

    blocks: Annotated[tuple[int, ...], MinLen(1)]
    """ids of the blocks"""
    force: Annotated[float, Unit("N"), Gt(0)]
    """on each block at its centroid, in the direction of the live load, at a load multiplier of 1"""


Direction = Literal["+x", "-x"]
Distribution = Literal["mass", "mass_height", "per_block"]


@dataclass(frozen=True, slots=True)
class LoadCase:
    """One of several load cases of a wall; what is left out is that of [load]."""

    name: Annotated[str, MinLen(1)]
    """in tables and pictures, and of the load case's folder in the run folder"""
    direction: Direction | None = None
    """the live load pushes to the right or to the left"""
    inclination: Annotated[float, Unit("rad"), Ge(-math.pi / 2), Le(math.pi / 2)] | None = None
    """angle of the live load above the horizontal"""
    distribution: Distribution | None = None
    """proportional to mass, to mass x height above the base, or as given in `live`"""
    live: tuple[LiveLoad, ...] = ()
    """forces on named blocks, instead of those of [load]"""
    dead: tuple[DeadLoad, ...] = ()
    """extra dead loads, besides those of [load]"""


@dataclass(frozen=True, slots=True)
class LoadSettings:
    """Direction and distribution of the live load; extra dead loads; several load cases."""

    direction: Direction = "+x"
    """the live load pushes to the right or to the left"""
    inclination: Annotated[float, Unit("rad"), Ge(-math.pi / 2), Le(math.pi / 2)] = 0.0
    """angle of the live load above the horizontal: "-90 deg" points down"""
    distribution: Distribution = "mass"
    """proportional to mass, to mass x height above the base, or as given in [[load.live]]"""
    live: tuple[LiveLoad, ...] = ()
    """forces on named blocks, each a table [[load.live]] with `blocks` and `force`; for "per_block" only"""
    dead: tuple[DeadLoad, ...] = ()
    """besides weight, each a table [[load.dead]] with `blocks` or `level`, `force` or `line_load`, `inertia`"""
    cases: tuple[LoadCase, ...] = ()
    """load cases that are run one after the other into folders of their names, each a table [[load.cases]] with `name`
    and what differs from [load]; none: [load] itself is the only one"""

    @property
    def sign(self) -> int:
        """+1 or -1."""
        return 1 if self.direction == "+x" else -1

    @property
    def name(self) -> str:
        """What lambda multiplies, in a few words."""
        return {"mass": "weight", "mass_height": "weight × height", "per_block": "live load"}[self.distribution]

    @property
    def beyond_default(self) -> str:
        """Return the first key that makes the loads more than a horizontal one proportional to mass, or ""."""
        default = LoadSettings()
        keys = ("dead", "distribution", "inclination", "live")
        return next((f"load.{key}" for key in keys if getattr(self, key) != getattr(default, key)), "")


NOT_A_FOLDER = ("figures", "macro", "micro", "runs")
"""names that the run folder uses itself"""


def load_cases(settings: LoadSettings) -> dict[str, LoadSettings]:
    """Return the loads of every load case by its name; {"": settings} where there are none. Raises CaseError."""
    if not settings.cases:
        return {"": settings}
    found: dict[str, LoadSettings] = {}
    for number, given in enumerate(settings.cases):
        key = f"load.cases.{number}.name"
        if given.name in NOT_A_FOLDER or not re.fullmatch(r"[\w+-]([\w+. -]{0,98}[\w+-])?", given.name):
            remedy = "use letters, digits, + - _ . and spaces, at most 100, and no name of the run folder's own"
            raise CaseError(key, f"{given.name!r} cannot name a folder", remedy)
        if given.name.casefold() in {name.casefold() for name in found}:
            raise CaseError(key, f"{given.name!r} is the name of another one", "give every load case its own name")
        changed = {
            name: value
            for name in ("direction", "inclination", "distribution", "live")
            if (value := getattr(given, name)) not in (None, ())
        }
        found[given.name] = replace(settings, cases=(), dead=(*settings.dead, *given.dead), **changed)
    return found


@dataclass(frozen=True, eq=False, slots=True)
class Loads:
    """Force (N) and moment about the centroid (N m, counter-clockwise) on each of n blocks, supports included.

    dead (n, 3): all dead load. along_x, upright (n, 3): the parts of the live load for +x that come from its horizontal
    and from its vertical component.
    """

    dead: FloatArray
    along_x: FloatArray
    upright: FloatArray

    def live(self, direction: int) -> FloatArray:
        """Live load (n, 3) at a load multiplier of 1, for direction +1 or -1."""
        return direction * self.along_x + self.upright


@dataclass(frozen=True, eq=False, slots=True)
class Placed:
    """Sizes (N) of p loads: block (p,), point (p, 2) in m through which the resultant goes, on_top (p,): whether the
    load is spread over the edges of the block that face upwards, else over its volume."""

    block: IntArray
    point: FloatArray
    on_top: npt.NDArray[np.bool_]
    size: FloatArray


def loads_on(wall: Wall, settings: LoadSettings | None = None) -> Loads:
    """Return the loads on a wall: by default its weight, and the same forces along x. Raises CaseError."""
    settings = settings or LoadSettings()
    live = live_loads(wall, settings)
    horizontal, vertical = live.size * math.cos(settings.inclination), live.size * math.sin(settings.inclination)
    nothing = np.zeros_like(live.size)
    return Loads(
        dead=read_only(_dead(wall, settings)),
        along_x=read_only(_on_blocks(wall, live.block, live.point, np.column_stack([horizontal, nothing]))),
        upright=read_only(_on_blocks(wall, live.block, live.point, np.column_stack([nothing, vertical]))),
    )


def live_loads(wall: Wall, settings: LoadSettings) -> Placed:
    """Return the live load at a load multiplier of 1, in its direction: first that of the free blocks' own masses, in
    order (not for "per_block"). Raises CaseError."""
    refuse_contradictions(wall, settings)
    if settings.distribution == "per_block":
        given = [(position, load.force) for load in settings.live for position in _positions(wall, load.blocks)]
        block, size = np.array([position for position, _ in given]), np.array([force for _, force in given])
        return Placed(block, block_centroids(wall)[block], np.zeros(len(block), bool), size)
    masses = _masses(wall, settings)
    if settings.distribution == "mass":
        return masses
    free = np.vstack([b.polygon for b in wall.blocks if not b.fixed])
    moment_of_height = masses.size * (masses.point[:, 1] - free[:, 1].min())
    return replace(masses, size=moment_of_height * masses.size.sum() / moment_of_height.sum())


def extra_dead_loads(wall: Wall, loads: tuple[DeadLoad, ...]) -> Placed:
    """Return the extra dead loads, downwards, one after the other."""
    each = list(_extra(wall, loads))
    return Placed(
        block=np.array([block for block, _, _, _ in each], dtype=np.int64),
        point=np.array([point for _, point, _, _ in each]).reshape(-1, 2),
        on_top=np.array([on_top for _, _, on_top, _ in each], dtype=bool),
        size=np.array([weight for _, _, _, weight in each], dtype=float),
    )


def refuse_contradictions(wall: Wall, settings: LoadSettings) -> None:
    """Raise CaseError for settings that contradict each other or name blocks that cannot be loaded."""
    if (settings.distribution == "per_block") != bool(settings.live):
        remedy = 'give [[load.live]] together with distribution = "per_block", or neither'
        raise CaseError("load.live", f'{len(settings.live)} given for "{settings.distribution}"', remedy)
    for number, load in enumerate(settings.dead):
        for one, other in (("force", "line_load"), ("level", "blocks")):
            if (getattr(load, one) in (None, ())) == (getattr(load, other) in (None, ())):
                raise CaseError(f"load.dead.{number}", f"needs one of {one} and {other}", "give one of the two")
        if load.level is not None and not _at_level(wall, load.level):
            tops = sorted({round(float(b.polygon[:, 1].max()), 3) for b in wall.blocks if not b.fixed})
            listed = ", ".join(f"{top:g}" for top in tops[:20])
            problem = f"no block has its top at {load.level:g} m"
            raise CaseError(f"load.dead.{number}.level", problem, f"tops are at {listed}{', ...' * (len(tops) > 20)} m")
    free = {block.id: not block.fixed for block in wall.blocks}
    named = {f"load.live.{number}": load.blocks for number, load in enumerate(settings.live)}
    named |= {f"load.dead.{number}": load.blocks for number, load in enumerate(settings.dead)}
    for key, ids in named.items():
        for wanted in ids:
            if not free.get(wanted, False):
                problem = f"block {wanted} is a support" if wanted in free else f"there is no block {wanted}"
                raise CaseError(f"{key}.blocks", problem, "name blocks of the wall that can move")


def _at_level(wall: Wall, level: float) -> list[int]:
    """Return the positions of the free blocks all of whose edges that face upwards lie at a level (m)."""
    return [
        k
        for k, block in enumerate(wall.blocks)
        if not block.fixed and np.abs(block.polygon[_upper_corners(block.polygon), 1] - level).max() < AT_LEVEL
    ]


def _upper_corners(polygon: FloatArray) -> npt.NDArray[np.bool_]:
    """Return which corners of a counter-clockwise polygon are ends of edges that face upwards."""
    run = np.roll(polygon, -1, axis=0) - polygon
    above = -run[:, 0] > STEEP * np.linalg.norm(run, axis=1)
    return above | np.roll(above, 1)


def top_of(polygon: FloatArray) -> tuple[float, FloatArray]:
    """Return horizontal width (m) and middle (2,) of the edges of a counter-clockwise polygon that face upwards."""
    start, end = upper_edges(polygon).transpose(1, 0, 2)
    width = start[:, 0] - end[:, 0]
    return float(width.sum()), np.average(0.5 * (start + end), axis=0, weights=width)


def upper_edges(polygon: FloatArray) -> FloatArray:
    """Return the edges (e, 2, 2) in m of a counter-clockwise polygon that face upwards: they run towards -x."""
    start, end = polygon, np.roll(polygon, -1, axis=0)
    above = start[:, 0] - end[:, 0] > STEEP * np.linalg.norm(end - start, axis=1)
    return np.stack([start[above], end[above]], axis=1)


def _extra(wall: Wall, loads: tuple[DeadLoad, ...]) -> Iterator[tuple[int, FloatArray, bool, float]]:
    """Yield block position, point of attack (2,) in m, whether it is on top, and weight in N of every extra load."""
    centroids = block_centroids(wall)
    for load in loads:
        named = _positions(wall, load.blocks) if load.level is None else _at_level(wall, load.level)
        for position in named:
            if load.line_load is not None:
                width, middle = top_of(wall.blocks[position].polygon)
                yield position, middle, True, load.line_load * width
            else:
                assert load.force is not None
                yield position, centroids[position], False, load.force


def _masses(wall: Wall, settings: LoadSettings) -> Placed:
    """Return the weights of all masses that the live load acts on, those of the free blocks first."""
    free = np.flatnonzero([not block.fixed for block in wall.blocks])
    extra = extra_dead_loads(wall, tuple(load for load in settings.dead if load.inertia))
    return Placed(
        block=np.concatenate([free, extra.block]),
        point=np.vstack([block_centroids(wall)[free], extra.point]),
        on_top=np.concatenate([np.zeros(len(free), bool), extra.on_top]),
        size=np.concatenate([block_weights(wall)[free], extra.size]),
    )


def _dead(wall: Wall, settings: LoadSettings) -> FloatArray:
    """Return weight and extra dead loads (n, 3)."""
    nothing = np.zeros(len(wall.blocks))
    total = np.column_stack([nothing, -block_weights(wall), nothing])
    for block, point, _, weight in _extra(wall, settings.dead):
        total += _on_blocks(wall, np.array([block]), point[None], np.array([[0.0, -weight]]))
    return total


def _on_blocks(wall: Wall, block: IntArray, point: FloatArray, force: FloatArray) -> FloatArray:
    """Sum forces (p, 2) at points (p, 2) into force and moment about the centroid of each block, (n, 3)."""
    arm = point - block_centroids(wall)[block]
    moment = arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]
    total = np.zeros((len(wall.blocks), 3))
    np.add.at(total, block, np.column_stack([force, moment]))
    return total


def _positions(wall: Wall, ids: tuple[int, ...]) -> list[int]:
    place = {block.id: position for position, block in enumerate(wall.blocks)}
    return [place[wanted] for wanted in ids]
