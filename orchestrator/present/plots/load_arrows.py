"""Arrows of loads: live loads beside the wall and on blocks, extra dead loads where they lie or have moved to."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.printed import printed
from orchestrator.loads.block_loads import LoadSettings, live_loads
from orchestrator.loads.dead_loads import DeadLoad, extra_dead_loads
from orchestrator.masonry.wall import Wall
from orchestrator.present.plots.canvas import VERMILLION, text_ends

LENGTH = 0.035
"""of the arrows, part of the wall's larger side"""
APART = 0.02
"""distance of the arrows of a line load, part of the wall's larger side"""
LOAD_LABEL = 8.0
"""size of the name of a load, points"""
UPRIGHT = 0.05
"""slope of an arrow below which it is upright: its name is centred over it"""
ARROW = 0.12
"""length of the load arrow, part of the wall's largest dimension"""


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
    return _draw_arrows(axes, np.stack([points + [0.0, LENGTH * size], points], axis=1), size)


def live_load_arrows(wall: Wall, load: LoadSettings) -> FloatArray:
    """Return tails and tips (p, 2, 2) of live loads on named blocks, onto their centroids, as long as they are large.

    None (0, 2, 2) where the live load is one of masses.
    """
    if load.distribution != "per_block":
        return np.zeros((0, 2, 2))
    placed = live_loads(wall, load)
    shaft = np.outer(placed.size / np.abs(placed.size).max(), ARROW * size_of(wall) * load.vector)
    return np.stack([placed.point - shaft, placed.point], axis=1)


def draw_live_loads(axes: Axes, wall: Wall, load: LoadSettings) -> None:
    """Draw the live loads on named blocks, if there are any."""
    arrows = live_load_arrows(wall, load)
    if len(arrows):
        largest = printed("force", max(abs(one.force) for one in load.live))
        drawn = _draw_arrows(axes, arrows, size_of(wall))
        drawn.set_label(f"live load on blocks, largest {largest} kN at λ = 1")


def _draw_arrows(axes: Axes, arrows: FloatArray, size: float) -> LineCollection:
    """Draw thin arrows from tails to tips (p, 2, 2) in m on a wall of a size (m)."""
    tips, along = arrows[:, 1], arrows[:, 1] - arrows[:, 0]
    along = 0.25 * LENGTH * size * along / np.linalg.norm(along, axis=1)[:, None]
    across = along[:, ::-1] * [-1.0, 1.0]
    barbs = [np.stack([tips - 1.6 * along + side * across, tips], axis=1) for side in (-0.6, 0.6)]
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


def load_arrow(points: FloatArray, direction: FloatArray, height: float) -> FloatArray:
    """Return tail and tip (2, 2) of the load arrow: beside the wall (n, 2) the load pushes from, its middle at a height
    (m)."""
    low, high = points.min(axis=0), points.max(axis=0)
    size = float(np.max(high - low))
    side = low[0] if direction[0] > 0 else high[0]
    before = np.copysign(0.5 * ARROW + 0.02, direction[0]) * size
    middle = np.array([side - before, height])
    return middle + np.array([[-0.5], [0.5]]) * ARROW * size * direction


def settlement_arrow(support: FloatArray, wall: FloatArray, direction: FloatArray) -> FloatArray:
    """Return tail and tip (2, 2) of the arrow beside a `support` (n, 2) that gives way, away from the wall."""
    low, high, size = support.min(axis=0), support.max(axis=0), float(np.max(np.ptp(wall, axis=0)))
    outwards = 1.0 if support[:, 0].mean() >= wall[:, 0].mean() else -1.0
    side = high[0] if outwards > 0 else low[0]
    middle = np.array([side + outwards * (0.5 * ARROW + 0.02) * size, 0.5 * (low[1] + high[1])])
    return middle + np.array([[-0.5], [0.5]]) * ARROW * size * direction


def draw_load(axes: Axes, arrow: FloatArray, load_name: str) -> None:
    """Draw the live load as an arrow from tail to tip (2, 2) in m, with its name."""
    style = {"arrowstyle": "-|>,head_width=0.35,head_length=0.7", "color": VERMILLION, "linewidth": 2.5}
    tail, tip = arrow
    axes.annotate("", tip, tail, arrowprops=style, zorder=5)
    axes.annotate(
        load_name,
        tuple(_above(arrow)[0].tolist()),
        (0, 6),
        textcoords="offset points",
        ha={-1: "right", 0: "center", 1: "left"}[_above(arrow)[1]],
        color=VERMILLION,
        fontsize=LOAD_LABEL,
        zorder=5,
    )


def load_label(points: FloatArray, arrow: FloatArray, load_name: str) -> FloatArray:
    """Return the ends (2, 2) in m of what `draw_load` writes over an arrow, in a `wall_figure` of points (n, 2)."""
    return text_ends(points, *_above(arrow), load_name, LOAD_LABEL)


def _above(arrow: FloatArray) -> tuple[FloatArray, int]:
    """Return the point (2,) over an arrow (2, 2) at which its name stands, and the side to which it goes on: over the
    tip and away from the wall; 0: centred over an upright arrow."""
    (tail, _), (tip, _) = arrow
    outwards = int(np.sign(tail - tip)) if abs(tail - tip) > UPRIGHT * float(np.ptp(arrow, axis=0).max()) else 0
    return np.array([tip, arrow[:, 1].max()]), outwards
