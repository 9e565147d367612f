"""Loads on the blocks: what stands still (dead) and what lambda multiplies (live), as forces at their centroids.

    dead    weight and extra dead loads, vertical
    live    masses x direction, where a mass is a block's weight at its centroid, or an extra dead load with `inertia`
            where it stands; "mass_height" multiplies by the height above the base, scaled to the same resultant;
            "per_block" are given forces at the centroids of the blocks named, negative ones against the direction

The direction is +x or -x, turned upwards by `inclination`: a unit vector in the loads. A wall's mirror image under the
mirrored load has the same answer.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Literal, Protocol

import numpy as np
from annotated_types import Ge, Le, MinLen

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray, read_only
from orchestrator.basis.checked import Checked
from orchestrator.basis.errors import CaseError, require_kinds
from orchestrator.basis.units import Unit
from orchestrator.geometry.rigid import cross
from orchestrator.loads.dead_loads import (
    DeadLoad,
    PlacedLoads,
    extra_dead_loads,
    joined,
    over_volume,
    refuse_dead_load,
    refuse_place,
)
from orchestrator.masonry.block_properties import (
    block_centroids,
    block_weights,
    fingerprint_of_blocks,
    refuse_beyond_weight,
    weights_that_move,
)
from orchestrator.masonry.wall import Wall


@dataclass(frozen=True, slots=True)
class LiveLoad(Checked):
    """Live load given per block, for distribution = "per_block"."""

    blocks: Annotated[tuple[int, ...], MinLen(1)]
    """ids of the blocks"""
    force: Annotated[float, Unit("N")]
    """on each block at its centroid, in the direction of the live load (negative: against it), at a load multiplier
    of 1"""


Direction = Literal["+x", "-x"]
Distribution = Literal["mass", "mass_height", "per_block"]


@dataclass(frozen=True, slots=True)
class LoadCase(Checked):
    """One of several load cases of a wall; what is left out is that of [load]."""

    name: Annotated[str, MinLen(1)]
    """in tables and pictures, and of the load case's folder in the run folder"""
    direction: Direction | None = None
    """the live load pushes to the right or to the left"""
    inclination: Annotated[float, Ge(-math.pi / 2), Le(math.pi / 2), Unit("rad")] | None = None
    """angle of the live load above the horizontal"""
    distribution: Distribution | None = None
    """proportional to mass, to mass x height above the base, or as given in `live`"""
    live: tuple[LiveLoad, ...] = ()
    """forces on named blocks, instead of those of [load]; these go with "per_block" only"""
    dead: tuple[DeadLoad, ...] = ()
    """extra dead loads, besides those of [load]"""


@dataclass(frozen=True, slots=True)
class LoadSettings(Checked):
    """Direction and distribution of the live load; extra dead loads; several load cases."""

    direction: Direction = "+x"
    """the live load pushes to the right or to the left"""
    inclination: Annotated[float, Ge(-math.pi / 2), Le(math.pi / 2), Unit("rad")] = 0.0
    """angle of the live load above the horizontal: "-90 deg" points down"""
    distribution: Distribution = "mass"
    """proportional to mass, to mass x height above the base, or as given in [[load.live]]"""
    live: tuple[LiveLoad, ...] = ()
    """forces on named blocks, each a table [[load.live]] with `blocks` and `force`; for "per_block" only"""
    dead: tuple[DeadLoad, ...] = ()
    """besides weight, each a table [[load.dead]] with `blocks` or `level`, `force` (`at`) or `line_load` (`stretch`),
    `inertia`"""
    cases: tuple[LoadCase, ...] = ()
    """load cases that are run one after the other into folders of their names, each a table [[load.cases]] with `name`
    and what differs from [load]; none: [load] itself is the only one"""

    envelope: bool = False
    """whether +x and -x, each with mass and with mass x height, are load cases too, before those in `cases`"""

    @property
    def vector(self) -> FloatArray:
        """Unit vector (2,) of the live load."""
        forward = 1.0 if self.direction == "+x" else -1.0
        return np.array([forward * math.cos(self.inclination), math.sin(self.inclination)])

    @property
    def several(self) -> bool:
        """Whether there are load cases, of the envelope or in `cases`; else [load] itself is the only one."""
        return self.envelope or bool(self.cases)

    @property
    def beyond_default(self) -> str:
        """Return the first key that makes the loads more than a horizontal one proportional to mass, or ""."""
        default = LoadSettings()
        keys = ("dead", "distribution", "inclination", "live")
        return next((f"load.{key}" for key in keys if getattr(self, key) != getattr(default, key)), "")


@dataclass(frozen=True, eq=False, slots=True)
class Loads:
    """Force (N) and moment about the centroid (N m, counter-clockwise) on each of n blocks, supports included.

    dead (n, 3): all dead load; live (n, 3): at a load multiplier of 1; direction (2,): unit vector of the live load.
    blocks: which they are (`fingerprint_of_blocks`), "" where that is not known. turned (n, 2): the moments in N m of
    dead and of live load once a block has turned by a right angle, counter-clockwise. Forces keep their direction and
    their place on the block: after a turn t a moment M is M cos(t) + turned sin(t). None: all act beside the centroid,
    neither above nor below it, and turned is 0.
    """

    dead: FloatArray
    live: FloatArray
    direction: FloatArray
    blocks: str = ""
    turned: FloatArray | None = None

    def of_blocks(self, which: BoolArray | IntArray) -> Loads:
        """Return the loads on some of the blocks, or on all of them in another order."""
        dead, live = read_only(self.dead[which]), read_only(self.live[which])
        return replace(self, dead=dead, live=live, turned=read_only(self.moments_turned[which]), blocks="")

    @property
    def moments_turned(self) -> FloatArray:
        """Moments (n, 2) in N m after a right angle, zeros where they are not known."""
        return np.zeros((len(self.dead), 2)) if self.turned is None else self.turned


def horizontal(direction: FloatArray) -> FloatArray:
    """Return the unit vector (2,) along the horizontal part of a live load's direction (2,)."""
    return np.array([np.copysign(1.0, direction[0]), 0.0])


LEAST_RESULTANT = 0.1
"""sum of forces of both signs over that of their sizes, at least: checks of the base shear and the mean displacement
along the live load divide by the sum; at 1/3 they agree with closed forms to 0.1 % (test_loads_pushover.py)"""
UPRIGHT = 1e-6
"""horizontal over vertical resultant of a live load up to which it has no base shear to speak of"""


STEEPEST = math.pi / 4
"""largest angle in rad, to either side of the horizontal, of a live load that its base shear measures: the horizontal
part is not the smaller one. The base shear of a steeper one goes to zero with its horizontal part, however much the
wall bears"""


def is_measured_by_base_shear(inclination: float) -> bool:
    """Return whether base shears of a live load at an inclination in rad can be compared with those of others."""
    return abs(inclination) <= STEEPEST


def upright_resultant(live: FloatArray) -> float | None:
    """Return the vertical resultant in N, upwards, of a live load (n, 3) without a horizontal one; None of others."""
    sideways, upwards = (float(part) for part in live[:, :2].sum(axis=0))
    return if_upright(sideways, upwards)


def if_upright(sideways: float, upwards: float) -> float | None:
    """Return the upward part in N of a live load whose horizontal part is none to speak of; None of others."""
    return upwards if upwards and abs(sideways) <= UPRIGHT * abs(upwards) else None


def loads_on(wall: Wall, settings: LoadSettings | None = None) -> Loads:
    """Return the loads on a wall: by default its weight, and the same forces along x. Raises CaseError, also for
    settings of several load cases (`load_cases` has each by its name)."""
    settings = LoadSettings() if settings is None else settings
    remedy = "write loads_on(assemblage.wall, LoadSettings())"
    require_kinds(remedy, wall=(wall, Wall), settings=(settings, LoadSettings))
    live, extra = live_loads(wall, settings), extra_dead_loads(wall, settings.dead)
    parts = (np.outer(live.size, part) for part in np.diag(settings.vector))
    sideways, upwards = (_on_blocks(wall, live.block, live.point, part) for part in parts)
    downwards = np.column_stack([0.0 * extra.size, -extra.size])
    weight = np.column_stack([part * block_weights(wall) for part in (0.0, -1.0, 0.0)])
    turned = (
        _moments_turned(wall, placed.block, placed.point, force)
        for placed, force in ((extra, downwards), (live, np.outer(live.size, settings.vector)))
    )
    return Loads(
        dead=read_only(weight + _on_blocks(wall, extra.block, extra.point, downwards)),
        live=read_only(sideways + upwards),
        direction=read_only(settings.vector),
        blocks=fingerprint_of_blocks(wall),
        turned=read_only(np.column_stack(list(turned))),
    )


def refuse_other_loads(wall: Wall, loads: Loads) -> None:
    """Raise CaseError for loads of another wall, and for such as are no finite numbers."""
    shape = (len(wall.blocks), 3)
    other = loads.dead.shape != shape or loads.live.shape != shape
    if other or loads.blocks not in ("", fingerprint_of_blocks(wall)):
        problem = "are not those of this wall: other blocks, or other weights of them"
        raise CaseError("loads", problem, "make them by loads_on(assemblage.wall, load)")
    if not (np.isfinite(loads.dead).all() and np.isfinite(loads.live).all()):
        raise CaseError("loads", "are not finite", "give every block finite forces and moments")


def live_loads(wall: Wall, settings: LoadSettings) -> PlacedLoads:
    """Return the live load at a load multiplier of 1, in its direction: first that of the free blocks' own masses, in
    order (not for "per_block"). Raises CaseError."""
    refuse_contradictions(wall, settings)
    if settings.distribution == "per_block":
        forces = [(position, load.force) for load in settings.live for position in _positions(wall, load.blocks)]
        block, size = np.array([position for position, _ in forces]), np.array([force for _, force in forces])
        return over_volume(block, block_centroids(wall)[block], size)
    masses = _masses(wall, settings)
    if settings.distribution == "mass":
        return masses
    free = np.vstack([b.polygon for b in wall.blocks if not b.fixed])
    moment_of_height = masses.size * (masses.point[:, 1] - free[:, 1].min())
    return replace(masses, size=moment_of_height * masses.size.sum() / moment_of_height.sum())


def height_of_live_load(wall: Wall, settings: LoadSettings) -> float:
    """Return the height y in m of the resultant of a live load. Raises CaseError."""
    live = live_loads(wall, settings)
    return float(np.average(live.point[:, 1], weights=live.size))


def refuse_contradictions(wall: Wall, settings: LoadSettings) -> None:
    """Raise CaseError for settings of several load cases, that contradict each other, or name blocks that cannot be
    loaded."""
    if settings.several:
        key = "load.envelope" if settings.envelope else "load.cases"
        remedy = "take one after the other from load_cases(load).values()"
        raise CaseError(key, "makes load cases, where the loads of one are expected", remedy)
    if (settings.distribution == "per_block") != bool(settings.live):
        remedy = 'give `live` together with distribution = "per_block", or neither'
        raise CaseError("load.live", f'{len(settings.live)} given for "{settings.distribution}"', remedy)
    _refuse_no_resultant(settings.live)
    for number, load in enumerate(settings.dead):
        refuse_dead_load(wall, load, f"load.dead.{number}")
    refuse_blocks_that_cannot_move({block.id: not block.fixed for block in wall.blocks}, settings.live, settings.dead)
    weights = weights_that_move(wall)
    for number, load in enumerate(settings.dead):
        refuse_place(wall, load, f"load.dead.{number}")
        size = "force" if load.line_load is None else "line_load"
        largest = float(extra_dead_loads(wall, (load,)).size.max(initial=0.0))
        refuse_beyond_weight(weights, largest, f"load.dead.{number}.{size}")
    for number, live in enumerate(settings.live):
        refuse_beyond_weight(weights, abs(live.force), f"load.live.{number}.force")


def _refuse_no_resultant(live: Sequence[LiveLoad]) -> None:
    """Raise CaseError for a force that is none, and for forces that cancel out: the multiplier is one of their sum."""
    for number, load in enumerate(live):
        if load.force == 0.0:
            raise CaseError(f"load.live.{number}.force", "is zero", "give a force, or leave this one out")
    along = sum(len(load.blocks) * load.force for load in live)
    sizes = sum(len(load.blocks) * abs(load.force) for load in live)
    if live and along < LEAST_RESULTANT * sizes:
        problem = f"the forces add up to {along / 1e3:.4g} kN of {sizes / 1e3:.4g} kN along load.direction"
        remedy = (
            f"make their sum at least {LEAST_RESULTANT:.0%} of their sizes, as base shears are multiples of it; where "
            "it is negative turn load.direction and all signs"
        )
        raise CaseError("load.live", problem, remedy)


class _OnBlocks(Protocol):
    """A load on blocks by their ids."""

    @property
    def blocks(self) -> tuple[int, ...]:
        """() for what is not on named blocks."""


def refuse_blocks_that_cannot_move(
    free: Mapping[int, bool], live: Sequence[_OnBlocks], dead: Sequence[_OnBlocks]
) -> None:
    """Raise CaseError for loads that name supports, blocks that there are not, or one twice; free: whether a block can
    move, by its id."""
    named = {f"load.live.{number}": load.blocks for number, load in enumerate(live)}
    named |= {f"load.dead.{number}": load.blocks for number, load in enumerate(dead)}
    for key, ids in named.items():
        for wanted in ids:
            if not free.get(wanted, False):
                problem = f"block {wanted} is a support" if wanted in free else f"there is no block {wanted}"
                raise CaseError(f"{key}.blocks", problem, "name blocks of the wall that can move")
            if ids.count(wanted) > 1:
                raise CaseError(f"{key}.blocks", f"names block {wanted} twice", "name each block once")


def _masses(wall: Wall, settings: LoadSettings) -> PlacedLoads:
    """Return the weights of all masses that the live load acts on, those of the free blocks first."""
    free = np.flatnonzero([not block.fixed for block in wall.blocks])
    own = over_volume(free, block_centroids(wall)[free], block_weights(wall)[free])
    return joined(own, extra_dead_loads(wall, tuple(load for load in settings.dead if load.inertia)))


def _on_blocks(wall: Wall, block: IntArray, point: FloatArray, force: FloatArray) -> FloatArray:
    """Sum forces (p, 2) at points (p, 2) into force and moment about the centroid of each block, (n, 3)."""
    moment = cross(point - block_centroids(wall)[block], force)
    total = np.zeros((len(wall.blocks), 3))
    np.add.at(total, block, np.column_stack([force, moment]))
    return total


def _moments_turned(wall: Wall, block: IntArray, point: FloatArray, force: FloatArray) -> FloatArray:
    """Sum the moments of forces (p, 2) at points (p, 2) about the centroids of blocks turned by a right angle, (n,)."""
    arm = point - block_centroids(wall)[block]
    total = np.zeros(len(wall.blocks))
    np.add.at(total, block, cross(np.column_stack([-arm[:, 1], arm[:, 0]]), force))
    return total


def _positions(wall: Wall, ids: tuple[int, ...]) -> list[int]:
    place = wall.place_of
    return [place[wanted] for wanted in ids]
