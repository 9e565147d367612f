"""Walls that are others than were drawn when they bear most: a gap has closed, or stones have fallen."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator import (
    JointSettings,
    LimitAnalysisSettings,
    SteppingSettings,
    analyse,
    find_joints,
    one_body_per_block,
    push,
    push_and_refine,
)
from orchestrator.limit_analysis.search.what_is_left import bound_of_what_is_left
from orchestrator.macroblocks.automatic import macroblocks_of
from orchestrator.masonry.wall import Block, Wall
from tests.support.walls import of_file, rectangle

FRICTION = 0.6
GROUND = Block(0, rectangle(0.0, -0.2, 3.0, 0.2), True, 20e3)


def pushed(*blocks, **stepping):
    assemblage = find_joints(Wall("moved", blocks, 0.3, FRICTION), JointSettings())
    analysis = analyse(assemblage)
    settings = SteppingSettings(**stepping)
    return analysis, push(assemblage, analysis, one_body_per_block(assemblage), stepping=settings).summary


@pytest.mark.parametrize("gap", [0.001, 0.003])
def test_a_stone_that_slides_against_a_support_is_held(gap):
    """It slides at its coefficient of friction; once it leans on the fixed stone no load brings it down."""
    stone = Block(1, rectangle(0.5, 0.0, 0.5, 0.5), False, 20e3)
    stop = Block(2, rectangle(1.0 + gap, 0.0, 0.6, 1.0), True, 20e3)
    analysis, found = pushed(GROUND, stone, stop)
    assert analysis.headline.load_multiplier == pytest.approx(FRICTION, rel=1e-6)
    assert found.held
    assert not found.peak_reached
    assert found.valid
    assert found.steps < 150
    assert found.displacement_at_peak == pytest.approx(gap, rel=0.01)


def test_a_stone_that_leans_on_its_neighbour_needs_it():
    """b x h, it overturns at b / h as drawn; turned by the gap over its height it would bear tan(alpha - theta) alone.
    Both slide at the coefficient of friction at most."""
    width, height, gap = 0.2, 0.8, 0.005
    stone = Block(1, rectangle(0.5, 0.0, width, height), False, 20e3)
    other = Block(2, rectangle(0.5 + width + gap, 0.0, 0.895, height), False, 20e3)
    analysis, found = pushed(GROUND, stone, other)
    alone = np.tan(np.arctan(width / height) - np.arcsin(gap / height))
    assert analysis.headline.load_multiplier == pytest.approx(width / height, rel=1e-6)
    assert 2.0 * width / height < found.peak_multiplier < FRICTION
    assert found.at_peak.drawn_contacts == pytest.approx(alone, rel=0.01)
    assert not found.held


def test_the_bound_of_what_is_left_is_that_of_the_wall_without_the_stones():
    """A pin of 1 : 3 on a block that slides at 0.6; without the block nothing is left but the ground."""
    block = Block(1, rectangle(0.5, 0.0, 2.0, 1.0), False, 20e3)
    pin = Block(2, rectangle(1.4, 1.0, 0.1, 0.3), False, 20e3)
    assemblage = find_joints(Wall("pin", (GROUND, block, pin), 0.3, FRICTION), JointSettings())
    analysis = analyse(assemblage)
    assert bound_of_what_is_left(assemblage, analysis.loads, np.array([True, True, True])) == pytest.approx(1 / 3)
    assert bound_of_what_is_left(assemblage, analysis.loads, np.array([True, True, False])) == pytest.approx(FRICTION)


def test_what_falls_before_the_wall_rests_again_is_one_failure():
    """Two stones at the end of a course, 3.4 and 1.7 % of the wall, fall one after the other under one load: that is
    the wall's failure, for rigid stones, every stone and macroblocks alike, and no two local ones."""
    assemblage = of_file("running_bond_on_a_slope")
    analysis = analyse(assemblage)
    assert analysis.local_failures == ()
    found = push(assemblage, analysis, one_body_per_block(assemblage))
    assert found.summary.peak_multiplier == pytest.approx(analysis.headline.load_multiplier, rel=5e-3)
    assert found.summary.peak_reached
    assert found.summary.events == ()


def test_no_more_than_half_of_a_wall_falls_in_local_failures():
    """Three pins on a low block, 24 % of the wall each, with a share of 30 %: two may fall, the third is the wall."""
    pins = [(0.1, 0.2), (0.2, 0.25), (0.3, 0.3)]
    blocks = [GROUND, Block(1, rectangle(0.5, 0.0, 2.0, 0.045), False, 20e3)]
    for number, (place, slenderness) in enumerate(pins):
        height = (0.08 / slenderness) ** 0.5
        blocks.append(Block(2 + number, rectangle(0.5 + 6 * place, 0.045, slenderness * height, height), False, 20e3))
    assemblage = find_joints(Wall("pins", tuple(blocks), 0.3, FRICTION), JointSettings())
    analysis = analyse(assemblage, LimitAnalysisSettings(local_share=0.3))
    stepping = SteppingSettings(local_share=0.3)
    found = push(assemblage, analysis, one_body_per_block(assemblage), stepping=stepping)
    static = found.curve.static
    assert [failure.multipliers[0] for failure in analysis.local_failures] == pytest.approx([0.2, 0.25], rel=0.01)
    assert [event.load_multiplier for event in found.summary.events] == pytest.approx([0.2, 0.25], rel=0.01)
    assert analysis.headline.load_multiplier == pytest.approx(0.3, rel=1e-3)
    assert static.load_multiplier.max() == pytest.approx(0.3, rel=0.01), "and of less than half no more is asked"


def test_macroblocks_of_round_stones_are_refined_until_they_bear_what_the_stones_bear():
    """3, 6 and 12 bodies bear the same, 39 % more than rigid stones."""
    assemblage = of_file("round_stones_between_leaves")
    analysis = analyse(assemblage)
    coarse = macroblocks_of(assemblage, analysis)
    _, done = push_and_refine(
        assemblage, analysis, coarse, lambda bodies, suffices: push(assemblage, analysis, bodies, suffices=suffices)
    )
    assert done.capacity.peak_multiplier == pytest.approx(analysis.headline.load_multiplier, rel=0.02)
