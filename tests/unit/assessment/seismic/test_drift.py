"""Which piers rock and which slide: blocks on the ground, whose limit analysis says so."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator import LoadSettings, analyse, find_joints, loads_on
from orchestrator.assessment.seismic.drift import drifting_piers, largest_drift
from orchestrator.assessment.seismic.settings import SeismicSettings
from orchestrator.masonry.joints import JointSettings
from orchestrator.masonry.wall import Block, Wall
from tests.support.limit_analysis_cases import FLOOR, box


@pytest.mark.parametrize("direction", ["+x", "-x"])
@pytest.mark.parametrize("distribution", ["mass", "mass_height"])
@pytest.mark.parametrize("width", [0.5, 0.7, 0.9, 1.1, 1.3])
def test_a_block_that_limit_analysis_lets_slide_is_none_that_rocks(width, distribution, direction):
    """Two stones, 1 m high: by mass they rock at b / h, by mass x height at less, and slide together at 0.6."""
    stones = [Block(k + 1, np.array(box(0.0, 0.5 * k, width, 0.5)), False, 20e3) for k in (0, 1)]
    wall = Wall("block", (Block(0, np.array(FLOOR), True, 20e3), *stones), 1.0, 0.6)
    assemblage, load = find_joints(wall, JointSettings()), LoadSettings(direction, distribution=distribution)
    analysis = analyse(assemblage, loads=loads_on(wall, load))
    (pier,) = drifting_piers(assemblage, (2,), analysis.loads)
    slides = np.isclose(analysis.associative.load_multiplier, 0.6) or (distribution == "mass_height" and width > 0.8)
    rule = largest_drift(pier, "SLC", SeismicSettings())
    assert rule is not None
    assert rule[1] == ("shear" if slides else "flexure")
