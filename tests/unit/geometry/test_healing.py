"""Healing of drawn outlines."""

import numpy as np
import pytest
import shapely

from orchestrator.geometry.healing import heal


@pytest.mark.parametrize("times", [2, 3])
@pytest.mark.parametrize("apart", [0.0, 1e-12, 1e-10, 1e-6])
def test_a_corner_that_is_drawn_several_times_stays(apart, times):
    """Without a corner that is drawn twice, 1e-12 m apart, a rectangle became a triangle."""
    repeated = [(1.0 - k * apart, 0.5) for k in range(times)]
    lower, upper = [(0.0, 0.0), (1.0, 0.0), *repeated, (0.0, 0.5)], [(0.0, 0.5), (1.0, 0.5), (1.0, 1.0), (0.0, 1.0)]
    healed, _ = heal([np.array(lower), np.array(upper)], 1e-3)
    assert [shapely.Polygon(one).area for one in healed] == pytest.approx([0.5, 0.5], abs=1e-9)
