"""Arches: of openings in a wall, and bare ones on piers.

The intrados and the extrados of a voussoir are one straight chord each, so the ring is a polygon inscribed in both
circles: the opening is smaller than the round one, and a thin ring of few voussoirs thinner than its depth.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated

import numpy as np
import shapely
from annotated_types import Ge

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.basis.checked import Checked
from orchestrator.basis.errors import CaseError
from orchestrator.masonry.patterns.quantities import (
    Length,
    LengthOrNone,
    Number,
    Place,
    UnitWeight,
)
from orchestrator.masonry.wall import Block, Friction, Wall


@dataclass(frozen=True, slots=True)
class ArchedOpening(Checked):
    """An opening under an arch of an odd number of voussoirs with radial joints; lengths in m.

    From `sill` up to `springing` it is a rectangle. `rise` of the intrados above the springing: half the span (left
    out) is a semicircle, less a segmental arch on inclined skewbacks; 0 is a flat arch, level below and above, whose
    joints meet in the third corner of the equilateral triangle under its intrados. `depth` is that of the ring.
    """

    left: Place
    right: Place
    sill: Place
    springing: Place
    rise: LengthOrNone | None = None
    depth: Length = 0.25
    voussoirs: Number = 9

    def __post_init__(self) -> None:
        Checked.__post_init__(self)
        if self.left >= self.right or self.sill > self.springing:
            given = f"({self.left:g}, {self.right:g}, {self.sill:g}, {self.springing:g}) m has no area"
            raise CaseError("ArchedOpening", given, "give left, right, sill and springing")
        half = 0.5 * (self.right - self.left)
        if not self.voussoirs % 2:
            raise CaseError("voussoirs", f"{self.voussoirs} have no keystone", "give an odd number")
        if self.rise is not None and not 0 <= self.rise <= half:
            raise CaseError("rise", f"{self.rise:g} m is not from 0 to half the span, {half:g} m", "correct it")

    def rings(self) -> tuple[FloatArray, FloatArray]:
        """Return the ends of the radial joints (voussoirs + 1, 2) at intrados and extrados, from the left."""
        middle, half = 0.5 * (self.left + self.right), 0.5 * (self.right - self.left)
        if self.rise == 0:
            inner = np.column_stack(
                [np.linspace(self.left, self.right, self.voussoirs + 1), np.full(self.voussoirs + 1, self.springing)]
            )
            below = half * np.sqrt(3.0)
            focus = np.array([middle, self.springing - below])
            return inner, focus + (inner - focus) * (1.0 + self.depth / below)
        rise = half if self.rise is None else self.rise
        radius = 0.5 * (half**2 / rise + rise)
        inner, outer = ring(radius, self.depth, 2 * np.arctan2(rise, half), self.voussoirs)
        centre = np.array([middle, self.springing + rise - radius])
        inner, outer = centre + inner, centre + outer
        inner[[0, -1]] = [self.left, self.springing], [self.right, self.springing]
        return inner, outer

    def void(self) -> shapely.Polygon:
        """Return the outline of what is open."""
        inner, _ = self.rings()
        return shapely.Polygon([*inner, (self.right, self.sill), (self.left, self.sill)])

    def stones(self) -> list[shapely.Polygon]:
        """Return the outlines of the voussoirs, from the left."""
        return [shapely.Polygon(quadrangle) for quadrangle in quadrangles(*self.rings())]


def ring(radius: float, depth: float, half_angle: float, voussoirs: int) -> tuple[FloatArray, FloatArray]:
    """Return the ends of the radial joints (voussoirs + 1, 2) of a ring about the origin, from the left.

    radius (m) is that of the intrados; half_angle (rad) that of the arch, from the crown to either springing.
    """
    angle = np.linspace(-half_angle, half_angle, voussoirs + 1)
    outwards = np.column_stack([np.sin(angle), np.cos(angle)])
    return radius * outwards, (radius + depth) * outwards


def quadrangles(inner: FloatArray, outer: FloatArray) -> Iterator[FloatArray]:
    """Yield the corners (4, 2) of every voussoir, counter-clockwise."""
    for (a, b), (c, d) in zip(pairwise(inner), pairwise(outer), strict=True):
        yield np.array([a, b, d, c])


@dataclass(frozen=True, slots=True)
class Arch(Checked):
    """A semicircular or segmental arch of equal voussoirs on two rectangular piers; lengths in m, unit weight in N/m3.

    radius is that of the middle of the ring, angle (rad) what the arch embraces. Piers of `courses` stones each are
    flush with the intrados at the springing; without any the arch springs from its supports.
    """

    voussoirs: Number
    radius: Length
    depth: Length
    angle: float = np.pi
    courses: Annotated[int, Ge(0)] = 0
    pier_width: LengthOrNone = 0.0
    pier_height: LengthOrNone = 0.0
    thickness: Length = 1.0
    unit_weight: UnitWeight = 20e3
    friction: Friction = 0.7

    def __post_init__(self) -> None:
        Checked.__post_init__(self)
        if self.depth >= 2 * self.radius:
            raise CaseError("Arch.depth", f"{self.depth:g} m is not below twice the radius", "radius is of the middle")
        if not 0 < self.angle <= np.pi:
            raise CaseError("angle", f"{self.angle:g} rad is not from 0 to half a turn", "correct it")
        if self.courses and not self.pier_height > 0:
            raise CaseError("pier_height", f"{self.pier_height:g} m is not a height of piers", "give it, or no courses")


def arch_on_piers(pattern: Arch) -> Wall:
    """Return the arch, centred at x = 0 on ground at y = 0 (without piers: its circles centred there).

    Blocks 0 (left) and 1 are supports; then come the left pier from below, the right one, the voussoirs from the left.
    A pier ends at the springing of the intrados; its uppermost stone goes on to that of the extrados, as its skewback.
    """
    inner, outer = ring(pattern.radius - 0.5 * pattern.depth, pattern.depth, 0.5 * pattern.angle, pattern.voussoirs)
    lift = np.array([0.0, pattern.pier_height - inner[0, 1] if pattern.courses else 0.0])
    inner, outer = inner + lift, outer + lift
    left = _pier(inner[0], outer[0], pattern) if pattern.courses else [_abutment(inner[0], outer[0])]
    right = [stone[::-1] * [-1.0, 1.0] for stone in left]
    stones = [left[0], right[0], *left[1:], *right[1:], *quadrangles(inner, outer)]
    blocks = tuple(
        Block(number, read_only(corners), fixed=number < 2, unit_weight=pattern.unit_weight)
        for number, corners in enumerate(stones)
    )
    return Wall(f"arch of {pattern.voussoirs}", blocks, pattern.thickness, pattern.friction)


def _pier(inner: FloatArray, outer: FloatArray, pattern: Arch) -> list[FloatArray]:
    """Return the support and the stones of the left pier, from below, for a skewback from `inner` to `outer` (2,)."""
    right, left = inner[0], inner[0] - pattern.pier_width
    if outer[0] < left - 1e-9 * pattern.depth:
        problem = f"{pattern.pier_width:g} m is less than the springing of the arch needs"
        raise CaseError("pier_width", problem, f"give at least {inner[0] - outer[0]:.4g} m")
    margin = 0.5 * pattern.pier_width
    levels = np.linspace(0.0, inner[1], pattern.courses + 1)
    stones = [_rectangle(left - margin, right + margin, -margin, 0.0)]
    stones += [_rectangle(left, right, bottom, top) for bottom, top in pairwise(levels)]
    head = [(left, outer[1])] if outer[0] > left + 1e-9 * pattern.depth else []
    return [*stones[:-1], np.array([*stones[-1][:2], inner, outer, *head])]


def _abutment(inner: FloatArray, outer: FloatArray) -> FloatArray:
    """Return the square behind the left springing joint from `inner` to `outer` (2,)."""
    behind = np.array([inner[1] - outer[1], outer[0] - inner[0]])
    return np.array([inner, outer, outer + behind, inner + behind])


def _rectangle(left: float, right: float, bottom: float, top: float) -> FloatArray:
    return np.array([[left, bottom], [right, bottom], [right, top], [left, top]])
