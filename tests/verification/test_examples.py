"""The examples of docs/examples do what their first lines say."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"


def test_benchmark1():
    """Published: 0.34782 and 0.29631 (meshes/ferris_tinloi_wall6.json names the source)."""
    analysis, capacity = runpy.run_path(str(EXAMPLES / "benchmark1.py"))["main"]()
    assert analysis.associative.load_multiplier == pytest.approx(0.34782, abs=2e-5)
    assert analysis.headline.load_multiplier == pytest.approx(0.2963, abs=1e-3)
    assert capacity.peak_multiplier == pytest.approx(analysis.headline.load_multiplier, rel=0.01)
    assert capacity.equilibrium_residual < 1e-3


def test_benchmark2():
    """Fewer macroblocks are stiffer: more load at the same displacement."""
    curves = runpy.run_path(str(EXAMPLES / "benchmark2.py"))["main"]()
    few, many = sorted(curves)
    assert few < many
    assert curves[few].load_multiplier[-1] > curves[many].load_multiplier[-1]
    for curve in curves.values():  # the last increment begins before the top has moved by 1 mm, and ends beyond
        assert curve.control_displacement_m[-2] < 1e-3 * (1 - 1e-3) <= curve.control_displacement_m[-1]
