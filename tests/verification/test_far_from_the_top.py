"""A stone slides farther than a curve goes while the top of the wall stands: what it meets there is no strength."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from orchestrator import one_body_per_block, push
from orchestrator.assessment.capacity import WENT_FAR
from orchestrator.limit_analysis import analyse
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.wall import Block, Wall
from tests.support.walls import rectangle

SLIDES, STANDS = 0.3, 0.9
"""coefficients of friction of the stone and of the tower"""


def before_a_tower(gap):
    """A stone of a third of the weight, and a tower of 0.6 x 1.2 m in its way, which overturns at 0.5."""
    blocks = (
        Block(0, rectangle(-1.0, -0.2, 4.0, 0.2), True, 20e3, friction=STANDS),
        Block(1, rectangle(0.0, 0.0, 0.7, 0.5), False, 20e3, friction=SLIDES),
        Block(2, rectangle(0.7 + gap, 0.0, 0.6, 1.2), False, 20e3, friction=STANDS),
    )
    return find_joints(Wall("tower", blocks, 0.3, STANDS), JointSettings())


@pytest.mark.parametrize("gap", [0.1, 0.4])
def test_a_stone_that_slides_farther_than_the_curve_goes_bears_what_it_slid_at(gap):
    """The curve ends at 40 mm of the top, which does not move. It slid on at 0.3, met the tower, and the two counted
    with what overturns them."""
    wall = before_a_tower(gap)
    pushed = push(wall, analyse(wall), one_body_per_block(wall))
    assert pushed.summary.peak_multiplier == pytest.approx(SLIDES, rel=0.01)
    assert pushed.summary.valid
    assert pushed.summary.peak_reached
    assert pushed.summary.stopped_because == WENT_FAR.format("40")


def test_what_it_meets_before_is_borne_by_both():
    """After 10 mm: both overturn, or slide, together."""
    wall = before_a_tower(0.01)
    assert push(wall, analyse(wall), one_body_per_block(wall)).summary.peak_multiplier > 1.2 * SLIDES


def test_a_top_that_a_support_holds_has_no_stiffness():
    """A corner against a support. It had 1e29 N/m and more, or moved against the load, both by rounding."""
    wall = before_a_tower(0.4).wall
    support = Block(3, rectangle(2.6, 0.0, 0.4, 1.6), True, 20e3, friction=STANDS)
    corner = Block(4, np.array([[2.2, 0.0], [2.6, 0.0], [2.6, 1.5]]), False, 20e3, friction=STANDS)
    assemblage = find_joints(replace(wall, blocks=(*wall.blocks, support, corner)), JointSettings())
    found = push(assemblage, analyse(assemblage), one_body_per_block(assemblage)).summary
    assert found.peak_multiplier == pytest.approx(SLIDES, rel=0.01)
    assert (found.initial_stiffness, found.displacement_at_peak, found.control_share) == (None, 0.0, 0.0)
