"""Picture of a seismic verification: spectra, capacity spectra and curves with their bilinears, demand and capacity."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from orchestrator.assessment.seismic.spectrum import Spectrum
from orchestrator.basis.arrays import FloatArray
from orchestrator.present.plots.canvas import BLUE, GREEN, INK, ORANGE, PURPLE, VERMILLION
from orchestrator.present.plots.words import write_legend

MODELS = {"macro": (BLUE, "macroblock FE"), "micro": (VERMILLION, "micro-FE")}
STATES = (INK, GREEN, PURPLE, ORANGE)
PERIODS = np.linspace(0.0, 2.5, 501)
LONG_PERIODS = np.linspace(0.0, 8.0, 2001)
"""s, of the spectra over displacement"""


def verification(record: Mapping[str, Any], curves: Mapping[str, tuple[FloatArray, FloatArray]]) -> Figure:
    """Draw the verification `record` (summary.json, `seismic`) of `curves`: model -> displacement m, base shear N.

    Left the elastic spectra, in the middle acceleration over displacement of the equivalent systems, right base shear
    over displacement of the control point. Circles are demands, squares capacities, at every limit state.
    """
    figure = Figure(figsize=(9.0, 3.9), layout="constrained")
    spectra, adrs, shear = figure.subplots(1, 3)
    elastic = {state["limit_state"]: _spectrum(state) for state in record["limit_states"]}
    for (name, spectrum), colour in zip(elastic.items(), STATES * 2, strict=False):
        spectra.plot(PERIODS, [spectrum.acceleration(t) for t in PERIODS], color=colour, linewidth=1.4, label=name)
        over = [(1e3 * spectrum.displacement(t), spectrum.acceleration(t)) for t in LONG_PERIODS]
        adrs.plot(*zip(*over, strict=True), color=colour, linewidth=1.2)
    reach = 0.0
    for system in record["systems"]:
        reach = max(reach, _draw_system(adrs, shear, record, system, *curves[system["model"]]))
    if not record["systems"]:
        for axes in (adrs, shear):
            axes.text(0.5, 0.5, "no curve is verified", transform=axes.transAxes, ha="center", color=VERMILLION)
    spectra.set(xlabel="period T (s)", ylabel="spectral acceleration (m/s²)", title="Elastic spectra", xlim=(0.0, 2.5))
    adrs.set(xlabel="displacement d* (mm)", ylabel="acceleration F*/m* (m/s²)", title="Equivalent systems")
    shear.set(xlabel="control displacement d (mm)", ylabel="base shear V (kN)", title="Curves and bilinears")
    if reach:
        adrs.set_xlim(0.0, 1.15 * reach)
    for axes in (spectra, adrs, shear):
        axes.set_ylim(bottom=0.0)
        axes.grid(color="#dddddd", linewidth=0.6)
        axes.title.set_fontsize(10)
    for marker, said in (("o", "demand"), ("s", "capacity")):
        shear.plot([], [], marker, color="white", markeredgecolor=INK, label=said)
    labels = [label for axes in (spectra, adrs, shear) for label in axes.get_legend_handles_labels()[1]]
    write_legend(figure, min(len(labels), 5))
    return figure


def _draw_system(
    adrs: Axes,
    shear: Axes,
    record: Mapping[str, Any],
    system: Mapping[str, Any],
    displacement: FloatArray,
    base_shear: FloatArray,
) -> float:
    """Draw one curve, its bilinear, demands and capacities in both axes; return the displacement d* reached, mm."""
    colour, label = MODELS[system["model"]]
    gamma, to_acceleration = system["gamma"], system["force_share"] / system["equivalent_mass_kg"]
    yields, ends = system["yield_control_displacement_m"], system["ultimate_control_displacement_m"]
    corners, force = 1e3 * np.array([0.0, yields, ends]), np.array([0.0, 1.0, 1.0]) * system["yield_base_shear_N"]
    moved = 1e3 * displacement
    for axes, length, strength in ((adrs, 1.0 / gamma, to_acceleration), (shear, 1.0, 1e-3)):
        names = (label, f"{label}, bilinear") if axes is shear else ("_", "_")  # the legend shows them once
        axes.plot(length * moved, strength * base_shear, color=colour, linewidth=1.0, alpha=0.6, label=names[0])
        axes.plot(length * corners, strength * force, "--", color=colour, linewidth=1.6, label=names[1])
    reach = float(max(corners[-1], moved.max())) / gamma
    states = [state["limit_state"] for state in record["limit_states"]]
    for row in record["checks"]:
        if row["approach"] != f"N2, {label}" or "refused" in row:
            continue
        edge = STATES[states.index(row["limit_state"]) % len(STATES)]
        for key, marker in (("demand", "o"), ("capacity", "s")):
            place = 1e3 * row[key]
            height = float(np.interp(place * gamma, corners, force))
            style = {
                "color": "white",
                "markeredgecolor": edge,
                "markeredgewidth": 1.6,
                "markersize": 6,
                "zorder": 5,
                "clip_on": False,
            }
            adrs.plot(place, to_acceleration * height, marker, **style)  # type: ignore[arg-type]
            shear.plot(gamma * place, 1e-3 * height, marker, **style)  # type: ignore[arg-type]
            reach = max(reach, place)
    return reach


def _spectrum(state: Mapping[str, Any]) -> Spectrum:
    names = ("ag_m_per_s2", "S", "TB_s", "TC_s", "TD_s", "F0", "eta")
    return Spectrum(*(state[name] for name in names))
