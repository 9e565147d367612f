"""Columns of drums, barrel vaults and domes of voussoirs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from annotated_types import Ge, Gt, Le

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.basis.checked import Checked
from orchestrator.basis.units import Unit
from orchestrator.geometry.polyhedra import Polyhedron, prism, reversed_faces, volume_of
from orchestrator.space.wall import UPRIGHT, SpaceBlock, SpaceWall

LEAST_CUT_STONE = 0.25
"""Part of a stone that is left at the end of a row at least."""
BOX_FACES = ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0))
"""corners of each face of a body of eight, all seen from outside or, of a mirrored body, all from inside"""


@dataclass(frozen=True, slots=True)
class VaultMaterial(Checked):
    """Of what a column or a vault is."""

    unit_weight: Annotated[float, Gt(0), Unit("N/m3")] = 20e3
    """of every stone"""
    friction: Annotated[float, Gt(0)] = 0.6
    """in every joint"""


@dataclass(frozen=True, slots=True)
class Column(Checked):
    """A column of drums on a plinth."""

    drums: Annotated[int, Ge(1), Le(1000)] = 6
    """how many"""
    sides: Annotated[int, Ge(3), Le(200)] = 16
    """of a drum's polygon"""
    diameter: Annotated[float, Gt(0), Unit("m")] = 1.0
    """between two opposite sides at the foot"""
    top_diameter: Annotated[float, Gt(0), Unit("m")] | None = None
    """the same at the top; left out: as at the foot"""
    drum_height: Annotated[float, Gt(0), Unit("m")] = 0.9
    """of each drum"""


@dataclass(frozen=True, slots=True)
class Barrel(Checked):
    """A barrel vault along y: voussoirs between two radial planes, staggered along the vault."""

    voussoirs: Annotated[int, Ge(2), Le(1000)] = 15
    """from springing to springing"""
    radius: Annotated[float, Gt(0), Unit("m")] = 2.0
    """of the inner side"""
    depth: Annotated[float, Gt(0), Unit("m")] = 0.4
    """of a voussoir along the radius"""
    length: Annotated[float, Gt(0), Unit("m")] = 2.0
    """of the vault"""
    stone: Annotated[float, Gt(0), Unit("m")] = 0.5
    """length of a voussoir along the vault; every other row begins with half of one"""
    opening_angle: Annotated[float, Gt(0), Le(math.pi), Unit("rad")] = math.pi
    """between the springings"""


@dataclass(frozen=True, slots=True)
class Dome(Checked):
    """A spherical dome with an eye at the top."""

    rings: Annotated[int, Ge(1), Le(500)] = 6
    """of voussoirs, from the springing to the eye"""
    segments: Annotated[int, Ge(4), Le(500)] = 16
    """voussoirs in a ring"""
    radius: Annotated[float, Gt(0), Unit("m")] = 4.0
    """of the inner side"""
    depth: Annotated[float, Gt(0), Unit("m")] = 0.5
    """of a voussoir along the radius"""
    springing: Annotated[float, Gt(0), Le(math.pi / 2), Unit("rad")] = math.pi / 2
    """angle of the springing from the top: 90 deg for a half sphere"""
    eye: Annotated[float, Gt(0), Unit("rad")] = 0.15
    """angle of the eye's edge from the top"""


def drum_column(column: Column, material: VaultMaterial) -> SpaceWall:
    """Drums with regular polygons for circles; they taper evenly."""
    count, h = column.drums, column.drum_height
    last = column.diameter if column.top_diameter is None else column.top_diameter
    angle = 2.0 * math.pi * (np.arange(column.sides) + 0.5) / column.sides
    circle = np.column_stack([np.cos(angle), np.sin(angle)]) / math.cos(math.pi / column.sides)

    def ring(level: int) -> FloatArray:
        radius = 0.5 * (column.diameter + (last - column.diameter) * level / count)
        return np.column_stack([radius * circle, np.full(column.sides, level * h)])

    side = 1.5 * column.diameter * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    plinth = prism(side, np.array([0.0, 0.0, -h]), np.diag([1.0, 1.0, h]))
    blocks = [SpaceBlock(0, plinth, fixed=True, unit_weight=material.unit_weight)]
    for k in range(count):
        body = _between(ring(k), ring(k + 1))
        blocks.append(SpaceBlock(k + 1, body, unit_weight=material.unit_weight))
    return SpaceWall("column of drums", tuple(blocks), material.friction, read_only(UPRIGHT))


def _between(bottom: FloatArray, top: FloatArray) -> Polyhedron:
    """Return the body between two rings (n, 3) of corners."""
    n = len(bottom)
    sides = [(k, (k + 1) % n, n + (k + 1) % n, n + k) for k in range(n)]
    body = Polyhedron(
        read_only(np.vstack([bottom, top])), (tuple(range(n))[::-1], tuple(range(n, 2 * n)), *map(tuple, sides))
    )
    return body if volume_of(body) > 0 else reversed_faces(body)


def barrel_vault(vault: Barrel, material: VaultMaterial) -> SpaceWall:
    """Rows of voussoirs between radial planes; below both springings a support."""
    start = 0.5 * (math.pi - vault.opening_angle)
    step = vault.opening_angle / vault.voussoirs
    blocks: list[SpaceBlock] = []
    for row in range(-1, vault.voussoirs + 1):
        fixed = row in (-1, vault.voussoirs)
        corners = [
            (radius * math.cos(angle), radius * math.sin(angle))
            for radius, angle in _quadrilateral(vault.radius, vault.depth, start + row * step, step)
        ]
        bonds = row % 2 and not fixed and vault.length > LEAST_CUT_STONE * vault.stone + 0.5 * vault.stone
        half = 0.5 * vault.stone if bonds else 0.0
        for y0, y1 in _cut(vault.length, vault.length if fixed else vault.stone, half):
            axes = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, y1 - y0, 0.0]])
            body = prism(np.array(corners), np.array([0.0, y0, 0.0]), axes)
            blocks.append(SpaceBlock(len(blocks), body, fixed, material.unit_weight))
    return SpaceWall("barrel vault", tuple(blocks), material.friction, read_only(UPRIGHT))


def _quadrilateral(radius: float, depth: float, start: float, step: float) -> Sequence[tuple[float, float]]:
    return (
        (radius, start), (radius + depth, start), (radius + depth, start + step), (radius, start + step),
    )  # fmt: skip


def _cut(length: float, stone: float, half: float) -> list[tuple[float, float]]:
    """Cut 0..length into stones, the first `half` long if that is given; the last one is at least LEAST_CUT_STONE."""
    cuts = [0.0] + [half] * bool(half)
    while cuts[-1] + 1.5 * stone < length + 1e-9 * stone:
        cuts.append(cuts[-1] + stone)
    if length - cuts[-1] > (1.0 + LEAST_CUT_STONE) * stone:
        cuts.append(cuts[-1] + stone)
    return [*zip(cuts, [*cuts[1:], length], strict=True)]


def dome(shape: Dome, material: VaultMaterial) -> SpaceWall:
    """Rings of voussoirs between meridians; all their faces are plane. A ring of supports lies below the springing."""
    edges = np.linspace(shape.springing, min(shape.eye, 0.9 * shape.springing), shape.rings + 1)
    levels = np.concatenate([[2.0 * edges[0] - edges[1]], edges])
    turn = 2.0 * math.pi * np.arange(shape.segments + 1) / shape.segments
    blocks: list[SpaceBlock] = []

    def corner(radius: float, level: int, segment: int) -> list[float]:
        theta, phi = levels[level], turn[segment]
        flat = radius * math.sin(theta)
        return [flat * math.cos(phi), flat * math.sin(phi), radius * math.cos(theta)]

    for level in range(shape.rings + 1):
        for k in range(shape.segments):
            corners = [
                corner(radius, at, segment)
                for radius in (shape.radius, shape.radius + shape.depth)
                for at, segment in ((level, k), (level, k + 1), (level + 1, k + 1), (level + 1, k))
            ]
            body = Polyhedron(read_only(corners), BOX_FACES)
            body = body if volume_of(body) > 0 else reversed_faces(body)
            blocks.append(SpaceBlock(len(blocks), body, level == 0, material.unit_weight))
    return SpaceWall("dome", tuple(blocks), material.friction, read_only(UPRIGHT))
