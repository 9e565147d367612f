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


@pytest.mark.parametrize("between", [(0, 1.6), (1.2, 1.8)])
def test_a_post_of_one_stone_drifts_over_its_own_height(between):
    """Two posts 3 m high under a lintel, a parapet of 1.6 m between them, or a panel above a door of 1.2 m: the opening
    is above their middles, or below, and no joint cuts them."""
    outlines = [box(0, 0, 0.5, 3), box(2.5, 0, 0.5, 3), box(0.5, between[0], 2, between[1]), box(0, 3, 3, 0.4)]
    stones = [Block(k, np.array(outline), False, 20e3) for k, outline in enumerate(outlines, 1)]
    assemblage = find_joints(Wall("posts", (Block(0, np.array(FLOOR), True, 20e3), *stones), 0.3, 0.6), JointSettings())
    found = drifting_piers(assemblage, (4,), loads_on(assemblage.wall))
    assert [(pier.foot, pier.top, pier.height) for pier in found] == [((0,), (1,), 3.0), ((0,), (2,), 3.0)]


@pytest.mark.parametrize("direction", ["+x", "-x"])
@pytest.mark.parametrize(("distribution", "acts_at"), [("mass", 0.5), ("mass_height", 0.625)])
@pytest.mark.parametrize("width", [0.5, 0.7, 0.9, 1.1, 1.3])
def test_a_block_that_slides_before_it_rocks_is_none_that_rocks(width, distribution, acts_at, direction):
    """Two stones, 1 m high in all, slide when the load is 0.6 W, and rock when it is W b / 2 over the height at which
    it acts: 1/2 m by mass, (1/16 + 9/16) m by mass x height. Limit analysis says the same of a load by mass."""
    stones = [Block(k + 1, np.array(box(0.0, 0.5 * k, width, 0.5)), False, 20e3) for k in (0, 1)]
    wall = Wall("block", (Block(0, np.array(FLOOR), True, 20e3), *stones), 1.0, 0.6)
    assemblage, load = find_joints(wall, JointSettings()), LoadSettings(direction, distribution=distribution)
    analysis, rocks_at = analyse(assemblage, loads=loads_on(wall, load)), width / (2.0 * acts_at)
    if distribution == "mass":
        assert analysis.associative.load_multiplier == pytest.approx(min(rocks_at, 0.6), rel=1e-6)
    (pier,) = drifting_piers(assemblage, (2,), analysis.loads)
    rule = largest_drift(pier, "SLC", SeismicSettings())
    assert rule == ((0.005, "shear") if rocks_at > 0.6 else (0.010, "flexure"))
