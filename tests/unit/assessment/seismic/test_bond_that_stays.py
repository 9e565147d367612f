"""A mechanism that leaves bonds closed keeps them: what is above a dry joint moves alone on bonded stones."""

from __future__ import annotations

import pytest

from orchestrator.assessment.seismic.local_mechanism import loads_in_mechanism
from orchestrator.limit_analysis import LimitAnalysisSettings, analyse
from orchestrator.loads import LoadSettings
from orchestrator.masonry.joints import JointClass, JointSettings, find_joints
from orchestrator.masonry.wall import Block, Wall
from tests.support.walls import rectangle

BONDED, DRY = JointClass(cohesion=400e3, tensile_strength=100e3), JointClass(("any"), ("a", "b"), None, 0.0, 0.0)


def stacked(*stones):
    """The ground and stones (material, left edge, width, height) on one another."""
    blocks, level = [Block(0, rectangle(-0.2, -0.2, 2.0, 0.2), True, 20e3)], 0.0
    for number, (material, left, width, height) in enumerate(stones, start=1):
        blocks.append(Block(number, rectangle(left, level, width, height), False, 20e3, material))
        level += height
    return find_joints(Wall("stack", tuple(blocks), 0.5, 1.0), JointSettings(classes=(BONDED, DRY)))


@pytest.mark.parametrize(
    ("stones", "alpha_0"),
    [
        ((("a", 0.0, 0.6, 2.0), ("b", 0.2, 0.2, 0.6)), 0.2 / 0.6),
        ((("a", 0.0, 0.5, 1.0), ("b", 0.0, 0.5, 1.0), ("b", 0.0, 0.5, 1.0)), 0.5 / 2.0),
    ],
)
def test_what_is_bonded_to_the_ground_and_rests_keeps_its_bond(stones, alpha_0):
    """A pinnacle on a pier, and what is above a dry joint: b / h. The bond with the ground was taken away, and with it
    the pinnacle's mechanism: the pier's has a larger displacement, and what had 0.70 passed with 1.09."""
    assemblage = stacked(*stones)
    found = loads_in_mechanism(assemblage, LoadSettings(), LimitAnalysisSettings(), analyse(assemblage))
    assert found.kinematics.multiplier == pytest.approx(alpha_0, rel=1e-6)
    assert found.opened is None
