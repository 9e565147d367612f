"""Picture of what was given: numbered blocks by material, supports, loads, classes of joints, control line."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from orchestrator.basis.printed import printed
from orchestrator.loads.block_loads import LoadSettings, height_of_live_load
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.ties import Tie
from orchestrator.present.plots.canvas import BLUE, GREEN, INK, ORANGE, PURPLE, draw_segments, label_of
from orchestrator.present.plots.load_arrows import (
    LENGTH,
    draw_dead_load,
    draw_live_loads,
    draw_load,
    live_load_arrows,
    load_arrow,
    load_label,
    size_of,
)
from orchestrator.present.plots.wall_pictures import draw_blocks, number_blocks, wall_canvas
from orchestrator.present.plots.words import legend_below
from orchestrator.present.weights import load_words, weight_words
from orchestrator.settings.inventory import load_sums

CLASSES = (BLUE, ORANGE, PURPLE, GREEN)
DASHES = ("-", (0, (4, 1.5)), (0, (1.5, 1.5)), (0, (6, 1.5, 1.5, 1.5)))
"""classes beyond the number of colours differ by their dashes"""
LONGEST = 100
"""letters of the name of a class of joints: two materials and all their values"""


def given(
    assemblage: Assemblage, load: LoadSettings, class_of_joint: Sequence[str], ties: Sequence[Tie] = ()
) -> Figure:
    """Draw what an analysis is given. class_of_joint (k,): the class of each joint in words, drawn where there are
    several; none: all joints alike."""
    wall = assemblage.wall
    free = np.vstack([block.polygon for block in wall.blocks if not block.fixed])
    arrow = load_arrow(free, load.vector, height_of_live_load(wall, load))
    above = free.max(axis=0) + [0.0, 2 * LENGTH * size_of(wall) * bool(load.dead)]
    ends = [point for tie in ties for point in (tie.start, tie.end)]
    sums = load_sums(wall, load)
    name = load_words(load.distribution, sums)
    beside = np.vstack([arrow, above, *ends, *live_load_arrows(wall, load)])
    shown = np.vstack([beside, *(block.polygon for block in wall.blocks)])
    figure, axes = wall_canvas(wall, np.vstack([beside, load_label(shown, arrow, name)]), weight_words(sums))
    draw_blocks(axes, wall)
    _draw_classes(axes, assemblage, class_of_joint)
    for one, extra in zip(load.dead, sums.extra, strict=True):
        total = f"dead load, {extra.name}: {printed('weight', extra.resultant)} kN"
        draw_dead_load(axes, wall, [one]).set_label(total + ", with its mass" * extra.inertia)
    top = free[:, 1].max()
    line = np.array([[[free[:, 0].min(), top], [free[:, 0].max(), top]]])
    draw_segments(axes, line, "black", 2.5, "height of the control displacement").set_linestyle([(0, (0.1, 2.0))])
    for strength in sorted({tie.strength for tie in ties}):
        bars = [np.array([tie.start, tie.end]) for tie in ties if tie.strength == strength]
        draw_segments(axes, bars, INK, 2.0, f"tie, {printed('force', strength)} kN")
    draw_live_loads(axes, wall, load)
    draw_load(axes, arrow, name)
    number_blocks(axes, wall)
    legend_below(axes, 3)
    return figure


def _draw_classes(axes: Axes, assemblage: Assemblage, class_of_joint: Sequence[str]) -> None:
    """Draw the joints in a colour for each class; of one class all are plain."""
    classes = list(dict.fromkeys(class_of_joint))
    if len(classes) < 2:
        return
    segments = np.stack([assemblage.joints.start, assemblage.joints.end], axis=1)
    for number, one in enumerate(classes):
        of_class = [k for k, name in enumerate(class_of_joint) if name == one]
        drawn = draw_segments(axes, segments[of_class], CLASSES[number % len(CLASSES)], 1.6, label_of(one, LONGEST))
        drawn.set_linestyle([DASHES[number // len(CLASSES) % len(DASHES)]])
