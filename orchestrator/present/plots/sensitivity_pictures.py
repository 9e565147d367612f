"""Pictures of a sensitivity study: tornado, and fragility points with their lognormal fit."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from orchestrator.assessment.sensitivity import ALIKE, Lognormal, value_of_range
from orchestrator.basis.arrays import FloatArray
from orchestrator.present.plots.canvas import BLUE, INK, ORANGE, VERMILLION
from orchestrator.present.plots.words import legend_below, write_title

NARROW = 0.05
"""part of the capacity that the axis of a tornado shows to both sides at least"""
LABEL_MARGIN = 0.25
"""part of the longest bar that is left for labels beside it"""


def tornado(bars: Sequence[Mapping[str, Any]], base: float | None, quantity: str, name: str) -> Figure:
    """Draw a bar for every range from its capacity at the low end to that at the high end, the longest on top.

    The low end is the upper half of a bar and the high end the lower half: both may lie on one side of the base.
    bars: name, low, high (SI), at_low, at_high, kind_low, kind_high; base: the capacity of the case as given. An end
    without a capacity that can be compared has its kind of answer written beside the bar.
    """
    figure = Figure(figsize=(7.0, 1.9 + 0.55 * len(bars)), layout="constrained")
    axes = figure.add_subplot()
    for place, bar in enumerate(reversed(bars)):
        for end, colour, height in (("low", BLUE, place + 0.16), ("high", ORANGE, place - 0.16)):
            value = bar[f"at_{end}"]
            if value is None or base is None:
                _write_kind(axes, place, bar, end, base)
                continue
            axes.barh(height, value - base, left=base, height=0.32, color=colour, edgecolor=INK, linewidth=0.6)
            left = value < base - ALIKE * base or (value <= base + ALIKE * base and end == "low")
            offset, align = (-4, "right") if left else (4, "left")
            said = value_of_range(bar["name"], bar[end])
            axes.annotate(
                said, (value, height), (offset, 0), textcoords="offset points", ha=align, va="center", fontsize=8
            )
    if base is not None:
        axes.axvline(base, color=INK, linewidth=1.0)
    axes.set_yticks(range(len(bars)), [bar["name"].replace("_", " ") for bar in reversed(bars)])
    axes.set_ylim(-0.5, len(bars) - 0.5)
    axes.set_xlabel(quantity)
    axes.ticklabel_format(axis="x", useOffset=False)
    if base:
        ends = [bar[key] for bar in bars for key in ("at_low", "at_high") if bar[key] is not None]
        low, high = min([*ends, (1.0 - NARROW) * base]), max([*ends, (1.0 + NARROW) * base])
        room = LABEL_MARGIN * (high - low)
        axes.set_xlim(low - room, high + room)
    axes.grid(axis="x", color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    said = "as given: no answer" if base is None else f"as given: {base:.4g}"
    write_title(axes, f"One range at a time, low and high end; {said}", name)
    return figure


def _write_kind(axes: Axes, place: int, bar: Mapping[str, Any], end: str, base: float | None) -> None:
    """Write which kind of answer an end has, on the side of the picture where the other end has no bar."""
    other = bar["at_low" if end == "high" else "at_high"]
    right = end == "high" if other is None or base is None else other <= base
    said = f"{value_of_range(bar['name'], bar[end])}:\n{textwrap.fill(bar[f'kind_{end}'], 22)}"
    axes.text(
        0.98 if right else 0.02, place, said, ha="right" if right else "left", va="center", fontsize=8,
        transform=axes.get_yaxis_transform(),
    )  # fmt: skip


def fragility_curve(
    capacities: FloatArray,
    probability: FloatArray,
    fit: Lognormal | None,
    quantity: str,
    demands: Sequence[float],
    name: str,
) -> Figure:
    """Draw the probability (n,) that a capacity (n,) is not above a value, its fit, and the values asked for."""
    figure = Figure(figsize=(7.0, 4.8), layout="constrained")
    axes = figure.add_subplot()
    axes.plot(capacities, probability, "o", color=BLUE, markersize=3.5, label=f"{len(capacities)} samples")
    low, high = float(capacities[0]), float(capacities[-1])
    reach = max([high, *demands])
    margin = 0.08 * (reach - min(low, *demands, reach)) or 0.1 * reach
    values = np.linspace(max(0.0, min([low, *demands]) - margin), reach + margin, 400)
    if fit is not None:
        said = f"lognormal: median {fit.median:.4g}, β = {fit.beta:.3f} (off by up to {fit.distance:.2f})"
        axes.plot(values, [fit.probability(x) for x in values], color=VERMILLION, linewidth=1.6, label=said)
    for number, demand in enumerate(demands):
        axes.axvline(demand, color=INK, linewidth=1.0, linestyle="--", label="asked for" if number == 0 else "_")
    axes.set(xlabel=quantity, ylabel="probability of not passing", ylim=(-0.02, 1.02), xlim=(values[0], values[-1]))
    axes.grid(color="#dddddd", linewidth=0.6)
    write_title(axes, "Fragility by Latin hypercube", name)
    legend_below(axes, 2)
    return figure
