"""Healing of drawn outlines."""

import numpy as np
import pytest
import shapely

from orchestrator.geometry.healing import heal


@pytest.mark.parametrize("times", [2, 3])
@pytest.mark.parametrize("apart", [0.0, 1e-12, 1e-10, 3e-9, 1e-8, 1e-6])
@pytest.mark.parametrize("out", [0.5, 0.04])
def test_a_corner_that_is_drawn_several_times_stays(out, apart, times):
    """Without a corner that is drawn twice, 1e-12 m apart, a rectangle became a triangle; it stands `out` of the line
    between its neighbours, at an angle of 90 degrees or of 170."""
    repeated = [(0.5 - k * apart, 0.5 + out) for k in range(times)]
    lower, upper = [(0.0, 0.0), (1.0, 0.0), (1.0, 0.5), (0.0, 0.5)], [(0.0, 0.5), (1.0, 0.5), *repeated]
    healed, _ = heal([np.array(lower), np.array(upper)], 1e-3)
    assert [shapely.Polygon(one).area for one in healed] == pytest.approx([0.5, 0.5 * out], abs=1e-6)
