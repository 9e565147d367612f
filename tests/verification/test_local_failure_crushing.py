"""Local failures of walls whose joints crush, and of walls with ties; what is said of stones that move alone."""

from __future__ import annotations

import pytest

from orchestrator.limit_analysis import analyse
from orchestrator.masonry.joints import JointClass, JointSettings, find_joints
from orchestrator.masonry.ties import Tie, with_ties
from orchestrator.masonry.wall import Block, Wall
from tests.support.pushover_chain import rectangle


@pytest.mark.parametrize("tied", [False, True])
@pytest.mark.parametrize("width", [0.06, 0.2])
def test_local_failures_are_taken_away_where_joints_crush_or_ties_hold(width, tied):
    """A pin of 0.06 m x 0.125 m overturns at 0.48, on a block that slides at
    0.7 without it; one as high and three times as wide stays on it. A tie that hangs slack changes nothing."""
    blocks = (Block(0, rectangle(0, -0.2, 0.9, 0.2), True, 20e3), Block(1, rectangle(0, 0, 0.9, 1.0), False, 20e3))
    blocks += (Block(2, rectangle(0.3, 1.0, width, 0.125), False, 20e3),)
    joints = JointSettings() if tied else JointSettings(classes=(JointClass(compressive_strength=5e9),))
    assemblage = find_joints(Wall("pin", blocks, 0.3, 0.7), joints)
    if tied:
        assemblage = with_ties(assemblage, [Tie(blocks=(1,), start=(0.9, 0.5), end=(3.0, 0.5), strength=1e4)])
    found = analyse(assemblage)
    if width > 0.125 * 0.7:
        assert not found.local_failures
    else:
        (failure,) = found.local_failures
        assert failure.stones == (2,)
        assert failure.multipliers == pytest.approx((0.48, 0.48), rel=1e-4)
    assert found.headline.load_multiplier == pytest.approx(0.7, rel=1e-4)
    assert found.headline.converged
    assert found.headline.mechanism.velocities[2].any() != bool(found.local_failures)
    assert any("come" in remark and "loose" in remark for remark in found.remarks) == bool(found.local_failures)


def test_where_what_is_left_is_held_it_is_said_that_only_few_stones_move():
    """Without the pin of 0.06 m x 0.125 m no load moves the block, which stands in a socket as high as itself."""
    outline = (
        (-0.5, -0.2, 1.7, 0.2),
        (-0.5, 0, 0.5, 1.0),
        (0.7, 0, 0.5, 1.0),
        (0, 0, 0.7, 1.0),
        (0.3, 1.0, 0.06, 0.125),
    )
    blocks = tuple(Block(n, rectangle(*one), n < 3, 20e3) for n, one in enumerate(outline))
    joints = JointSettings(classes=(JointClass(compressive_strength=5e9),))
    found = analyse(find_joints(Wall("socket", blocks, 0.3, 0.8), joints))
    assert found.headline.load_multiplier == pytest.approx(0.48, rel=1e-4)
    assert not found.local_failures
    assert any(remark.startswith("WARNING: only stones 4 (") for remark in found.remarks)


def test_a_paper_s_value_that_is_the_pin_s_is_said_to_be_none_of_the_wall():
    blocks = (
        Block(0, rectangle(-9, -0.5, 27, 0.5), True, 25e3),
        Block(1, rectangle(0, 0, 9, 4), False, 25e3),
        Block(2, rectangle(4.25, 4, 0.5, 1.5), False, 25e3),
    )
    analysis = analyse(find_joints(Wall("pin", blocks, 0.3, 0.7), JointSettings()))
    assert analysis.sequence.load_multiplier == pytest.approx(1 / 3, rel=1e-6)
    assert analysis.headline.load_multiplier == pytest.approx(0.7, rel=1e-6)
    said = "the paper's value is none of the wall: only 2 % of the dead load moves at it (stones 2)"
    assert said in analysis.remarks


def test_a_pin_that_counts_as_nothing_is_known_of_the_wall_without_it_is_told():
    """The block below is held by supports on both sides: what is left has no multiplier."""
    blocks = (
        Block(0, rectangle(-2, -0.5, 20, 0.5), True, 25e3),
        Block(1, rectangle(0, 0, 9, 4), False, 25e3),
        Block(2, rectangle(4.25, 4, 0.5, 1.5), False, 25e3),
        Block(3, rectangle(9, 0, 1, 3), True, 25e3),
        Block(4, rectangle(-1, 0, 1, 3), True, 25e3),
    )
    analysis = analyse(find_joints(Wall("held", blocks, 0.3, 0.7), JointSettings()))
    assert analysis.headline.load_multiplier == pytest.approx(1 / 3, rel=1e-6)
    assert any("only stones 2 (2 % of the dead load) move at the multiplier that counts" in r for r in analysis.remarks)
    assert not any("none of the wall" in remark for remark in analysis.remarks)
