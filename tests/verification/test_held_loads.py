"""A load held above a peak is held until the wall rests, or has moved far: a motion that takes long is no fall.

The other road: rigid blocks that are followed in large displacements, where a wall bears less than as it was drawn.
"""

from __future__ import annotations

import pytest

from orchestrator import JointSettings, analyse, find_joints
from orchestrator.masonry.patterns import Rubble, rubble

pytestmark = pytest.mark.long


@pytest.mark.parametrize(
    ("seed", "stone", "flatness", "rests"),
    [(5, 0.32050029237453803, 2.1695289476837925, 0.358), (7, 0.3025095466604667, 2.276656561163491, 0.308)],
)
def test_rubble_that_moves_for_long_comes_to_rest(seed, stone, flatness, rests):
    """Of both kinds of joints one was left after 600 factorisations, at rest up to 0.335 and 0.243, where walls that
    have moved rest under 0.358 and 0.308."""
    wall = rubble(Rubble(2.6, 2.2, stone=stone, flatness=flatness, seed=seed))
    found = analyse(find_joints(wall, JointSettings()))
    low, _ = found.interval or (found.headline.load_multiplier,) * 2
    assert low > 0.99 * rests
