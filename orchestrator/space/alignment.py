"""Corners of a drawing in space that are meant to lie in one plane, put there.

Stones of a course have their beds in common, and a facade its two faces. Where a drawing has their corners a hair apart
rigid blocks cannot move as stones do, which give way by far more: a row that turns about its edges has to slide, and
friction holds it or drags it along. An L-shaped wall of stones of 0.2 m that was turned and rounded to 0.1 mm lost 8 %
of what it bears (tests/verification/test_drawn_in_space.py).

The axes are up, and pairs at right angles to it and to each other that upright faces look along: those of the largest
face, then those of the largest of the faces that are left. A face looks along an axis whose corners lie no farther
apart along it than twice what faces may gape by; others slope, and stay. The corners of the faces that look along an
axis lie at levels. Levels that follow each other within what faces may gape by are one, unless a chain of them gets
twice as long: then nobody knows which are meant to be the same, and they stay. So does a block that would be none.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from orchestrator.basis.arrays import FloatArray, IntArray, read_only
from orchestrator.geometry.polyhedra import area_vector, flaw_of, tangents_of, volume_of
from orchestrator.space.wall import SpaceBlock, SpaceWall

ALONG = 0.9995
"""Cosine of the angle to an axis up to which a small face may look along it: 1.8 degrees."""
SAME = 1e-9
"""Part of a block's size below which levels are the same, and corners stay as they are."""
ROUNDINGS = 16.0
"""Last digits of the largest coordinate below which they do as well: far from the origin these are more."""
PASSES = 50
"""Axes that are not at right angles move corners off each other's levels, by half at 45 degrees: passes at most."""


def aligned(wall: SpaceWall, gap: float) -> SpaceWall:
    """Return the wall with corners at common levels, itself where no corner is moved.

    gap: what faces may gape by, as a part of a block's size: cube root of its volume, or its extent along an axis.
    """
    shapes = [block.shape for block in wall.blocks]
    begins = np.cumsum([0, *(len(shape.vertices) for shape in shapes)])
    drawn = np.concatenate([shape.vertices for shape in shapes])
    faces = [begins[k] + np.array(face) for k, shape in enumerate(shapes) for face in shape.faces]
    size, counts = np.cbrt([volume_of(shape) for shape in shapes]), np.diff(begins)
    most = 2.0 * gap * np.repeat(size, [len(shape.faces) for shape in shapes])
    corners, sizes = drawn.copy(), np.repeat(size, counts)
    still = SAME * sizes + ROUNDINGS * np.spacing(np.abs(drawn).max())
    axes = list[tuple[FloatArray, IntArray, FloatArray]]()
    for axis, looking in axes_of(drawn, faces, most, wall.up):
        levels, there = drawn @ axis, np.unique(np.concatenate([faces[k] for k in looking]))
        extent = np.maximum.reduceat(levels, begins[:-1]) - np.minimum.reduceat(levels, begins[:-1])
        axes.append((axis, there, gap * np.minimum(sizes, np.repeat(extent, counts))[there]))
    for _ in range(PASSES):
        before = corners.copy()
        for axis, there, apart in axes:
            levels = corners[there] @ axis
            corners[there] += (common(levels, apart) - levels)[:, None] * axis
        if (np.abs(corners - before).max(axis=1) <= still).all():
            break
    if (np.abs(corners - drawn).max(axis=1) <= still).all():
        return wall
    moved = zip(wall.blocks, size, np.split(corners, begins[1:-1]), strict=True)
    return replace(wall, blocks=tuple(_with_corners(block, own, gap * length) for block, length, own in moved))


def moved_by(one: SpaceWall, other: SpaceWall) -> FloatArray:
    """Return how far a corner of each block (n,) of one wall lies from that of the other at most, m."""
    both = zip(one.blocks, other.blocks, strict=True)
    return np.array([np.linalg.norm(a.shape.vertices - b.shape.vertices, axis=1).max() for a, b in both])


def _with_corners(block: SpaceBlock, corners: FloatArray, off: float) -> SpaceBlock:
    """Return a block with other corners (v, 3), as it is where its faces (by `off` m) or its body are none then."""
    shape = replace(block.shape, vertices=read_only(corners))
    return block if flaw_of(shape, off) else replace(block, shape=shape)


def axes_of(
    corners: FloatArray, faces: list[IntArray], most: FloatArray, up: FloatArray
) -> Iterator[tuple[FloatArray, IntArray]]:
    """Yield the axes (3,) of a wall, each with the faces that look along it.

    faces: corner numbers of each; most (f,): how far apart along an axis the corners of a face that looks along it may
    lie, m.
    """
    areas = np.array([area_vector(corners[face]) for face in faces])
    frame, size = tangents_of(up), np.linalg.norm(areas, axis=1)

    def looking(axis: FloatArray, among: IntArray) -> IntArray:
        leans = among[np.abs(areas[among] @ axis) >= ALONG * size[among]]
        flat = [np.ptp(corners[faces[k]] @ axis) <= most[k] for k in leans]
        return leans[np.array(flat, dtype=bool)]

    if len(level := looking(up, np.arange(len(faces)))):
        yield up, level
    quarters = np.exp(4j * np.angle(areas @ frame.T @ np.array([1.0, 1j])))  # alike along all four axes of a pair
    left = (areas @ up) ** 2 <= (1.0 - ALONG**2) * size**2

    def pair(turned: complex) -> list[FloatArray]:
        angles = np.angle(turned) / 4.0 + np.array([0.0, np.pi / 2.0])
        return [np.cos(angle) * frame[0] + np.sin(angle) * frame[1] for angle in angles]

    while left.any():
        seed = int(np.argmax(np.where(left, size, -1.0)))
        own = pair(quarters[seed])
        among = np.flatnonzero(left & (np.cos(np.angle(quarters / quarters[seed]) / 4.0) >= ALONG))
        near = np.unique(np.concatenate([looking(axis, among) for axis in own]))
        mean = pair((size[near] * quarters[near]).sum())
        left[seed] = False
        for axis in mean if any(seed in looking(axis, near) for axis in mean) else own:
            if len(faces_there := looking(axis, near)):
                left[faces_there] = False
                yield axis, faces_there


def common(levels: FloatArray, apart: FloatArray) -> FloatArray:
    """Return levels (n,) with the mean of those that follow each other within what they may be apart (n,).

    Of equal levels it is the most that any may be.
    """
    order: IntArray = np.argsort(levels)
    same = np.concatenate([[0], np.cumsum(np.diff(levels[order]) > SAME * apart.min(initial=np.inf))])
    begins = np.flatnonzero(np.diff(same, prepend=-1))
    low, most = levels[order[begins]], np.maximum.reduceat(apart[order], begins)
    chains = np.concatenate([[0], np.cumsum(np.diff(low) > np.minimum(most[1:], most[:-1]))])[same]
    found = levels.copy()
    for chain in np.split(order, np.flatnonzero(np.diff(chains)) + 1):
        if np.ptp(levels[chain]) <= 2.0 * apart[chain].min():
            found[chain] = levels[chain].mean()
    return found
