"""A loose stone slides off a wall at a small multiplier, and the wall bears what it bears without the stone."""

from __future__ import annotations

import pytest

from orchestrator import SteppingSettings, one_body_per_block, push
from orchestrator.limit_analysis import analyse
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.wall import Block, Wall
from tests.support.walls import rectangle


@pytest.mark.parametrize("large", [True, False])
@pytest.mark.parametrize("slides", [0.05, 0.007])
def test_the_peak_is_that_of_what_the_stone_left(slides, large):
    """Two stones of 0.6 m overturn together at 0.6 / 1.2. The load grew in steps of the multiplier of the stone: 2,000
    increments ended before the peak, and in small displacements what the wall bore was held against the stone's."""
    blocks = (
        Block(0, rectangle(-1.0, -1.0, 3.0, 1.0), True, 20e3),
        Block(1, rectangle(0.0, 0.0, 0.6, 0.6), False, 20e3),
        Block(2, rectangle(0.0, 0.6, 0.6, 0.6), False, 20e3),
        Block(3, rectangle(0.25, 1.2, 0.1, 0.05), False, 20e3, friction=slides),
    )
    wall = find_joints(Wall("loose", blocks, 0.3, 0.7), JointSettings())
    stepping = SteppingSettings(large_displacement=large)
    found = push(wall, analyse(wall), one_body_per_block(wall), stepping=stepping).summary
    assert found.peak_multiplier == pytest.approx(0.5, rel=0.005)
    assert found.peak_reached
    assert found.valid
