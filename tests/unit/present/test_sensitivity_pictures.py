"""Tornado and fragility: what is drawn can be read."""

from __future__ import annotations

from itertools import combinations

import pytest

from orchestrator.present import plots


@pytest.mark.parametrize(("low", "high"), [(3.893, 3.816), (4.05, 4.03), (3.9, 4.0), (4.0, 4.0)])
def test_both_ends_of_a_range_are_seen_and_named_on_whichever_side_they_lie(low, high):
    bar = {"name": "unit_weight", "low": 18e3, "high": 22e3, "at_low": low, "at_high": high}
    figure = plots.tornado([bar | {"kind_low": "checks", "kind_high": "checks"}], 3.942, "load multiplier", "wall")
    figure.canvas.draw()
    texts = [text.get_window_extent() for text in figure.axes[0].texts]
    assert len(texts) == 2
    assert not any(one.overlaps(other) for one, other in combinations(texts, 2))
    bars = [patch.get_window_extent().shrunk(1.0, 0.9) for patch in figure.axes[0].patches]
    assert not any(one.overlaps(other) for one, other in combinations(bars, 2))
