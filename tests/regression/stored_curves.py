"""Compare the curves of a run with stored ones.

The stored curves (tests/regression/BENCHMARK/*.csv, made by `make reference`, with the case that made them beside) are
this program's own: they show that a change of the code changed a result. That the result is right is the business of
tests/verification. Tolerances: peak 1 %, initial stiffness 2 %, area under the curve 2 %, which is what a change of the
load steps or of the mesh generator's version moves and a change of the mechanics exceeds.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy.integrate import trapezoid

from orchestrator.assessment.capacity import initial_stiffness

OVERLAYS = Path(__file__).parents[2] / "build" / "regression"


def compare(benchmark: str, folder: Path, model: str) -> None:
    """Compare the curve of a model in a run folder with the stored one; print their figures, draw them together."""
    stored = columns(Path(__file__).parent / benchmark / f"{model}.csv")
    found = columns(folder / model / "curve.csv")
    figures = {name: (figure(stored), figure(found)) for name, figure in FIGURES.items()}
    draw(stored, found, OVERLAYS / f"{benchmark}_{model}.png")
    said = "; ".join(f"{name}: stored {before:.6g}, now {now:.6g}" for name, (before, now) in figures.items())
    print(f"{model}: {said}")
    for name, (before, now) in figures.items():
        assert now == pytest.approx(before, rel=TOLERANCE[name]), f"{model} {said}; overlay in build/regression"


def columns(path):
    table = np.genfromtxt(path, delimiter=",", names=True)
    assert table.size > 20
    displacement = table["control_displacement_m"] - table["control_displacement_m"][0]
    return displacement, table["base_shear_N"]


def peak(curve):
    return curve[1].max()


def stiffness(curve):
    return initial_stiffness(curve[1], curve[0])


def area(curve):
    """Area under the curve up to 20 mm, J."""
    displacement = np.linspace(0.0, 0.02, 2001)
    return trapezoid(np.interp(displacement, *curve), displacement)


FIGURES = {"peak in N": peak, "initial stiffness in N/m": stiffness, "area to 20 mm in J": area}
TOLERANCE = {"peak in N": 0.01, "initial stiffness in N/m": 0.02, "area to 20 mm in J": 0.02}


def draw(stored, found, path):
    figure = Figure(layout="constrained")
    axes = figure.add_subplot(xlabel="control displacement (mm)", ylabel="base shear (kN)")
    for label, (displacement, shear), style in (("stored", stored, "k-"), ("now", found, "r--")):
        axes.plot(1e3 * displacement, shear / 1e3, style, label=label)
    axes.legend()
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)
