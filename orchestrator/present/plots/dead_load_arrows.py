"""Arrows of extra dead loads: floors and other loads beside the blocks' own weight, where they lie or have moved to."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from orchestrator.basis.arrays import FloatArray
from orchestrator.loads.dead_loads import DeadLoad, extra_dead_loads
from orchestrator.masonry.wall import Wall
from orchestrator.present.plots.canvas import VERMILLION

LENGTH = 0.035
"""of the arrows, part of the wall's larger side"""
APART = 0.02
"""distance of the arrows of a line load, part of the wall's larger side"""


def draw_dead_load(
    axes: Axes,
    wall: Wall,
    loads: Sequence[DeadLoad],
    moved: Callable[[int, FloatArray], FloatArray] = lambda block, points: points,
) -> LineCollection:
    """Draw extra dead loads: arrows onto the tops they lie on, or one onto the centroid of each block; return them.

    moved: where points (p, 2) in m of the block at a position are drawn.
    """
    size = size_of(wall)
    placed = extra_dead_loads(wall, tuple(loads))
    points = np.vstack(
        [
            moved(k, _along(edges, APART * size) if kind == "top" else at[None])
            for k, at, kind, edges in zip(placed.block.tolist(), placed.point, placed.spread, placed.edges, strict=True)
        ]
    )
    arrows = np.stack([points + [0.0, LENGTH * size], points], axis=1)
    head = 0.25 * LENGTH * size
    barbs = [np.stack([points + [side * head, 1.6 * head], points], axis=1) for side in (-0.6, 0.6)]
    drawn = LineCollection(list(np.concatenate([arrows, *barbs])), colors=VERMILLION, linewidths=0.9, zorder=4)
    axes.add_collection(drawn, autolim=False)
    return drawn


def size_of(wall: Wall) -> float:
    """Return the larger side, in m, of the blocks that can move."""
    return float(np.ptp(np.vstack([block.polygon for block in wall.blocks if not block.fixed]), axis=0).max())


def _along(edges: FloatArray, apart: float) -> FloatArray:
    """Return points (p, 2) on edges (e, 2, 2), about `apart` (m) apart."""
    points = []
    for start, end in edges:
        many = max(1, round(float(abs(end[0] - start[0])) / apart))
        share = (np.arange(many) + 0.5) / many
        points.append(start + share[:, None] * (end - start))
    return np.vstack(points)
