"""Pictures of many runs: the small walls of a tolerance study on one sheet, curves of a study or of load cases."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path

from orchestrator.basis.arrays import FloatArray
from orchestrator.limit_analysis.paper.limit_state import LimitAnalysis, LimitState
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.macroblocks.criteria import Partition
from orchestrator.masonry.joints import Assemblage
from orchestrator.present.joint_pieces import shown_displacement
from orchestrator.present.plots.canvas import (
    BLUE,
    GREEN,
    INK,
    ORANGE,
    PURPLE,
    STONE,
    VERMILLION,
    draw_supports,
    label_of,
    stamp_not_valid,
)
from orchestrator.present.plots.pushover_pictures import (
    DRAWN_DISPLACEMENT,
    draw_limit_analysis,
    load_in_kilonewtons,
    outline,
    shown_from,
)
from orchestrator.present.plots.wall_pictures import body_colours, displaced_blocks
from orchestrator.present.plots.words import legend_below, write_legend, write_title
from orchestrator.pushover.increments import Increment, PushoverCurve
from orchestrator.pushover.meshing import BodyMeshes

CUT = 1.4
"""where the plot of curves ends, times the associative multiplier: few bodies can be far stronger than the wall"""
LARGEST_PANEL = (1.9, 2.5)
"""width and height of the largest small wall with its title, inches"""
SMALL = 16.0
"""points of what is stamped on a small wall"""
LOAD_CASES = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, INK)


@dataclass(frozen=True, eq=False, slots=True)
class SmallWall:
    """One small wall: displaced outlines (m), their colours, the supports (n, 2) in m, and whether it is a result."""

    title: str
    outlines: tuple[Path, ...]
    colours: tuple[str, ...]
    supports: tuple[FloatArray, ...]
    valid: bool = True


@dataclass(frozen=True, eq=False, slots=True)
class ModelCurve:
    """The curve of one model ("macro" or "micro") of a load case, and whether its result is valid."""

    load_case: str
    model: str
    valid: bool
    curve: PushoverCurve


def mechanism_panel(assemblage: Assemblage, state: LimitState) -> SmallWall:
    """Return the mechanism of micro-LA, every stone in one colour."""
    blocks = assemblage.wall.blocks
    free = [k for k, block in enumerate(blocks) if not block.fixed]
    moved = displaced_blocks(assemblage, state.mechanism, DRAWN_DISPLACEMENT)
    return SmallWall(
        f"micro-LA ({state.name})",
        tuple(_closed(moved[k]) for k in free),
        (STONE,) * len(free),
        tuple(block.polygon for block in blocks if block.fixed),
    )


def deformed_panel(
    assemblage: Assemblage, partition: Partition, bodies: Bodies, meshes: BodyMeshes, increment: Increment | None
) -> SmallWall:
    """Return the bodies, displaced as in `increment` (None: as they stand) times one factor, neighbours in colours."""
    moved = meshes.nodes[:, :2]
    if increment is not None:
        plane = shown_displacement(meshes, increment)
        factor = DRAWN_DISPLACEMENT * float(np.ptp(meshes.nodes[:, 1])) / float(np.linalg.norm(plane, axis=1).max())
        moved = moved + factor * plane
    every_stone = not len(partition.vanished_joints)
    fills = [STONE] * bodies.moving if every_stone else body_colours(assemblage, partition)
    return SmallWall(
        "",
        tuple(outline(meshes, number, moved) for number in range(bodies.moving)),
        tuple(fills),
        tuple(body.exterior for body in bodies.bodies[bodies.moving :]),
    )


def panels(sheet: Sequence[SmallWall], columns: int, name: str) -> Figure:
    """Draw small walls in rows of `columns`, all in one scale."""
    rows = -(-len(sheet) // columns)
    points = np.vstack([path.vertices for panel in sheet for path in panel.outlines])
    low, high = points.min(axis=0), points.max(axis=0)
    extent = high - low
    scale = min(LARGEST_PANEL[0] / extent[0], LARGEST_PANEL[1] / extent[1])
    size = (columns * max(1.3, scale * extent[0] + 0.2), rows * (scale * extent[1] + 0.6) + 0.5)
    figure = Figure(figsize=size, layout="constrained")
    figure.suptitle(name, fontsize=10, parse_math=False)
    for axes, panel in zip(figure.subplots(rows, columns, squeeze=False).flat, sheet, strict=False):
        _draw(axes, panel, low, high)
    return figure


def study_curves(
    models: Sequence[tuple[int, PushoverCurve]],
    micro: PushoverCurve | None,
    analysis: LimitAnalysis,
    name: str,
    not_valid: Sequence[str] = (),
) -> Figure:
    """Draw base shear against control displacement: models (number of bodies, curve), micro-FE, and micro-LA.

    Displacements are relative to the state under gravity. not_valid: the runs whose curve is not, and why.
    """
    figure = Figure(figsize=(7.5, 5.2), layout="constrained")
    axes = figure.add_subplot()
    counts = [count for count, _ in models] or [1]
    norm = LogNorm(max(1, min(counts)), max(2, *counts))
    colours = colormaps["viridis_r"]
    for count, curve in sorted(models, key=lambda model: model[0]):
        axes.plot(*_shear_against_displacement(curve), color=colours(norm(count)), linewidth=1.2)
    if micro is not None:
        axes.plot(
            *_shear_against_displacement(micro), color="black", linewidth=2.2, label="micro-FE (every stone)", zorder=5
        )
    draw_limit_analysis(axes, analysis)
    axes.set_xlabel("control displacement (mm)")
    axes.set_ylabel("base shear (kN)")
    drawn = [curve for _, curve in models] + ([] if micro is None else [micro])
    axes.set_xlim(left=min(map(shown_from, drawn), default=0.0))
    largest = CUT * analysis.bound.load_multiplier * load_in_kilonewtons(analysis)
    cut = axes.get_ylim()[1] > largest
    axes.set_ylim(0.0, min(axes.get_ylim()[1], largest))
    axes.grid(color="#dddddd", linewidth=0.6)
    said = [f"(cut at {CUT:g} times the associative multiplier)"] if cut else []
    write_title(axes, "\n".join([*said, *(f"NOT VALID: {reason}" for reason in not_valid)]), name)
    if not_valid:
        stamp_not_valid(axes)
    bar = figure.colorbar(ScalarMappable(norm, colours), ax=axes, label="bodies of the macroblock FE")
    bar.set_ticks(sorted(set(counts)), labels=[str(count) for count in sorted(set(counts))], fontsize=7)
    bar.minorticks_off()
    write_legend(figure, 2)
    return figure


def load_case_curves(lines: Sequence[ModelCurve], name: str) -> Figure:
    """Draw base shear against control displacement of load cases, each along its own load: macroblocks solid, micro-FE
    dashed, both in the load case's colour. Displacements are relative to the state under gravity."""
    figure = Figure(figsize=(7.0, 5.2), layout="constrained")
    axes = figure.add_subplot()
    names = list(dict.fromkeys(line.load_case for line in lines))
    colours = dict(zip(names, LOAD_CASES * len(names), strict=False))
    for line in lines:
        style = {"macro": "-", "micro": "--"}[line.model]
        said = f"{label_of(line.load_case)}, {line.model} FE" + ", NOT VALID" * (not line.valid)
        axes.plot(
            *_shear_against_displacement(line.curve), style, color=colours[line.load_case], linewidth=1.8, label=said
        )
    axes.set_xlabel("control displacement along the load (mm)")
    axes.set_ylabel("base shear (kN)")
    axes.set_xlim(left=min((shown_from(line.curve) for line in lines), default=0.0))
    axes.set_ylim(bottom=0.0)
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    write_title(axes, f"Pushover under {len(names)} load cases", name)
    legend_below(axes, 2)
    return figure


def _draw(axes: Axes, panel: SmallWall, low: FloatArray, high: FloatArray) -> None:
    margin = 0.03 * float(np.max(high - low))
    axes.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin), aspect="equal")
    axes.set_axis_off()
    axes.set_title(panel.title, fontsize=7, parse_math=False)
    for path, colour in zip(panel.outlines, panel.colours, strict=True):
        axes.add_patch(PathPatch(path, facecolor=colour, edgecolor="#555555", linewidth=0.3))
    draw_supports(axes, panel.supports)
    if not panel.valid:
        stamp_not_valid(axes, SMALL)


def _closed(polygon: FloatArray) -> Path:
    return Path(np.vstack([polygon, polygon[:1]]), closed=True)


def _shear_against_displacement(curve: PushoverCurve) -> tuple[FloatArray, FloatArray]:
    """Return control displacement (mm) and base shear (kN)."""
    moved = curve.control_displacement_m - curve.control_displacement_m[0]
    return 1e3 * moved, curve.base_shear_N / 1e3
