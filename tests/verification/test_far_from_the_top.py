"""A stone slides farther than a curve goes while the top of the wall stands: what it meets there is no strength."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from orchestrator import SteppingSettings, one_body_per_block, push
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


def pushed(gap, end=0.04, **options):
    wall, stepping = before_a_tower(gap), SteppingSettings(final_displacement=end, **options)
    return push(wall, analyse(wall), one_body_per_block(wall), stepping=stepping).summary


@pytest.mark.parametrize(("gap", "end"), [(0.041, 0.04), (0.065, 0.04), (0.4, 0.04), (0.0396, 0.03), (0.0396, 0.02)])
def test_a_stone_that_slides_farther_than_the_curve_goes_bears_what_it_slid_at(gap, end):
    """The top does not move. The stone slid on at 0.3, met the tower, and the two counted with what overturns them."""
    found = pushed(gap, end)
    assert found.peak_multiplier == pytest.approx(SLIDES, rel=0.01)
    assert found.valid
    assert found.peak_reached
    assert found.stopped_because.startswith(f"what moves has gone {1e3 * end:g} mm, the final displacement")


def test_what_it_meets_before_is_borne_by_both():
    """After 10 mm, at 0.54: the stone of W' pushes the foot of the tower of W by N, with 0.3 N down its face, b = 0.6 m
    from the edge it turns about. N = lambda W' - 0.3 (W' - 0.3 N), and lambda W h/2 = W b/2 + 0.3 N b."""
    light, heavy = 0.7 * 0.5, 0.6 * 1.2  # weights, over 6 kN/m2
    per_load = light / (1.0 - SLIDES**2)  # N over lambda - 0.3
    turns = (0.5 - SLIDES * SLIDES * per_load / heavy) / (1.0 - SLIDES * per_load / heavy)
    assert pushed(0.01).peak_multiplier == pytest.approx(turns, rel=0.03)


def test_how_far_a_stone_went_before_it_found_rest_is_told_where_the_top_stands():
    """30 mm of the 40 of the curve, beyond what it slides at; by the top it had not moved at all."""
    found = pushed(0.03)
    assert found.snap.load_multiplier == pytest.approx(SLIDES, rel=0.01)
    assert found.snap.moved == pytest.approx(0.03, rel=0.05)
    assert found.snap.share is None


def test_a_top_that_a_support_holds_has_no_stiffness():
    """A corner against a support. It had 1e29 N/m and more, or moved against the load, both by rounding."""
    wall = before_a_tower(0.4).wall
    support = Block(3, rectangle(2.6, 0.0, 0.4, 1.6), True, 20e3, friction=STANDS)
    corner = Block(4, np.array([[2.2, 0.0], [2.6, 0.0], [2.6, 1.5]]), False, 20e3, friction=STANDS)
    assemblage = find_joints(replace(wall, blocks=(*wall.blocks, support, corner)), JointSettings())
    found = push(assemblage, analyse(assemblage), one_body_per_block(assemblage)).summary
    assert found.peak_multiplier == pytest.approx(SLIDES, rel=0.01)
    assert (found.initial_stiffness, found.displacement_at_peak, found.control_share) == (None, 0.0, 0.0)
