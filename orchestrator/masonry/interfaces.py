"""Interfaces: where two blocks, or two bodies, touch; in the plane (d = 2) and in space (d = 3) alike.

Each lies in one plane, with a frame (n, t) and contact points: forces at these make up what any distribution of
pressure can (Livesley 1992). In the plane they are the two ends: `start` -> `end` runs along the counter-clockwise
outline of i, so t = (end - start)/length, and n = (t_y, -t_x) is the outward normal of i. In space they are the corners
of a polygon's convex hull, and n, t1, t2 are right-handed.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace

import numpy as np

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray, frozen, read_only
from orchestrator.basis.graphs import connected_groups

STRENGTHS = ("cohesion", "tensile_strength", "compressive_strength", "normal_stiffness", "shear_stiffness")
"""what interfaces have per area"""
SOFTENING = 2e-4
"""opening or slip at which tension and cohesion of joints have gone where nothing else is known, m"""


@dataclass(frozen=True, eq=False, slots=True)
class Interfaces:
    """k interfaces and their p contact points.

    i, j (k,): blocks (positions in `wall.blocks`, not ids) or bodies on both sides. normal (k, d) from i to j; tangents
    (k, d - 1, d); area (k,) in m2; centroid (k, d) in m; friction (k,). point (p, d) in m, interface by interface;
    joint (p,): the interface of each. cohesion, tensile_strength, compressive_strength (inf: no crushing) (k,) in N/m2,
    normal_stiffness, shear_stiffness (inf: rigid) (k,) in N/m3, capacity (k,) in N, the largest normal force (finite
    for ties in space): one number stands for all. outlines: of the interfaces in space (v, 3); holes: of each, the
    outlines (v, 3) of what it leaves out.
    """

    i: IntArray
    j: IntArray
    normal: FloatArray
    tangents: FloatArray
    area: FloatArray
    centroid: FloatArray
    friction: FloatArray
    point: FloatArray
    joint: IntArray
    cohesion: FloatArray = field(default_factory=lambda: read_only(0.0))
    tensile_strength: FloatArray = field(default_factory=lambda: read_only(0.0))
    compressive_strength: FloatArray = field(default_factory=lambda: read_only(np.inf))
    normal_stiffness: FloatArray = field(default_factory=lambda: read_only(np.inf))
    shear_stiffness: FloatArray = field(default_factory=lambda: read_only(np.inf))
    capacity: FloatArray = field(default_factory=lambda: read_only(np.inf))
    outlines: tuple[FloatArray, ...] = ()
    holes: tuple[tuple[FloatArray, ...], ...] = ()

    def __post_init__(self) -> None:
        for name in (*STRENGTHS, "capacity"):
            object.__setattr__(self, name, read_only(np.broadcast_to(getattr(self, name), self.friction.shape)))

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self.i)

    @property
    def is_tie(self) -> BoolArray:
        """Which of them are ties in space (k,)."""
        return frozen(np.isfinite(self.capacity))

    @property
    def start(self) -> FloatArray:
        """Where those in the plane begin (k, 2), m."""
        return self.point[0::2]

    @property
    def end(self) -> FloatArray:
        """Where those in the plane end (k, 2), m."""
        return self.point[1::2]

    @property
    def tangent(self) -> FloatArray:
        """Unit tangents (k, 2) of those in the plane, from start to end."""
        return self.tangents[:, 0]

    @property
    def length(self) -> FloatArray:
        """Lengths (k,) in m of those in the plane."""
        return frozen(np.linalg.norm(self.end - self.start, axis=1))

    @property
    def pairs(self) -> list[tuple[int, int]]:
        """i and j of each."""
        return list(zip(self.i.tolist(), self.j.tolist(), strict=True))

    @property
    def acting(self) -> tuple[tuple[FloatArray, FloatArray], ...]:
        """Where, and along what (k, 2), the normal forces at start and end and the shear of those in the plane act."""
        return (self.start, self.normal), (self.end, self.normal), (self.centroid, self.tangent)

    def corners(self, number: int) -> FloatArray:
        """Contact points (v, d) of one of them."""
        return self.point[np.searchsorted(self.joint, number) : np.searchsorted(self.joint, number, side="right")]

    def part(self, which: BoolArray | IntArray) -> Interfaces:
        """Return some of them, or all in another order."""
        number = np.full(self.count, -1)
        number[which] = np.arange(len(self.i[which]))
        of_point = number[self.joint]
        points = np.argsort(of_point, kind="stable")[np.count_nonzero(of_point < 0) :]
        chosen = {name: read_only(getattr(self, name)[which], getattr(self, name).dtype) for name in PER_INTERFACE}
        return replace(
            self,
            **chosen,
            point=read_only(self.point[points]),
            joint=read_only(of_point[points], np.int64),
            outlines=tuple(self.outlines[k] for k in np.arange(self.count)[which]) if self.outlines else (),
            holes=tuple(self.holes[k] for k in np.arange(self.count)[which]) if self.holes else (),
        )

    def and_also(self, others: Interfaces) -> Interfaces:
        """Return these and others after them."""
        parts = {name: (getattr(self, name), getattr(others, name)) for name in (*PER_INTERFACE, "point")}
        return Interfaces(
            **{name: read_only(np.concatenate(part), part[0].dtype) for name, part in parts.items()},
            joint=read_only(np.concatenate([self.joint, self.count + others.joint]), np.int64),
            outlines=(*self.outlines, *others.outlines),
            holes=(*self.holes, *others.holes),
        )

    def groups(self, blocks: int) -> IntArray:
        """Return for each of so many blocks (n,) the number of the group that interfaces connect it to."""
        return connected_groups(blocks, self.i, self.j)


PER_INTERFACE = tuple(one.name for one in fields(Interfaces) if one.name not in ("point", "joint", "outlines", "holes"))


def straight_interfaces(
    i: IntArray, j: IntArray, start: FloatArray, end: FloatArray, width: FloatArray | float, friction: FloatArray
) -> Interfaces:
    """Return interfaces of the plane from start to end (k, 2), m, over a width (k,) out of it, m."""
    length = np.linalg.norm(end - start, axis=1)
    tangent = (end - start) / length[:, None]
    return Interfaces(
        i=read_only(i, np.int64),
        j=read_only(j, np.int64),
        normal=read_only(np.column_stack([tangent[:, 1], -tangent[:, 0]])),
        tangents=read_only(tangent[:, None]),
        area=read_only(length * width),
        centroid=read_only(0.5 * (start + end)),
        friction=read_only(friction),
        point=read_only(np.stack([start, end], axis=1).reshape(-1, 2)),
        joint=read_only(np.repeat(np.arange(len(i)), 2), np.int64),
    )
