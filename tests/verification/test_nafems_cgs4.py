"""NAFEMS contact benchmark CGS-4 (block sliding up a slope), in this program's terms.

A block on a plane with slope tan a = 0.1 is pushed horizontally by F; with weight G it starts to slide at

    F / G = (tan a + mu) / (1 - mu tan a),     0.412371 for mu = 0.3.

Also pushed downhill, where the sign of tan a changes. With mu <= tan a the block cannot stand on the slope before it is
pushed, and the chain refuses it; here its weight acts while its displacement is held.
"""

import numpy as np
import pytest

from orchestrator.masonry.wall import Block, Wall
from tests.support.pushover_chain import model_of, moved_to, run

SLOPE = 0.1


def wall_on_slope(friction):
    along = np.array([1.0, SLOPE]) / np.hypot(1.0, SLOPE)
    up = np.array([-along[1], along[0]])

    def rectangle(left, right, bottom, top):
        corners = ((left, bottom), (right, bottom), (right, top), (left, top))
        return np.array([s * along + h * up for s, h in corners])

    plane = Block(0, rectangle(-2.0, 3.0, -0.5, 0.0), True, 20e3)
    block = Block(1, rectangle(0.0, 1.0, 0.0, 0.3), False, 20e3)
    return Wall("block on a slope", (plane, block), 0.5, friction)


@pytest.mark.parametrize("friction", [0.15, 0.2, 0.3, 0.6])
@pytest.mark.parametrize("direction", [1, -1])
def test_sliding_starts_at_the_closed_form(friction, direction):
    tangent = direction * SLOPE
    result = run(model_of(wall_on_slope(friction), direction=direction), final_displacement=1e-3)
    assert result.peak == pytest.approx((tangent + friction) / (1 - friction * tangent), rel=1e-4)


@pytest.mark.parametrize("friction", [1e-9, 0.1, 0.2, 0.3])
def test_a_block_held_while_its_weight_acts_slides_at_the_closed_form(friction):
    path = moved_to(model_of(wall_on_slope(friction)), [0.0, 5e-5, 1e-4, 2e-4])
    for increment in path[2:]:
        assert increment.load_multiplier == pytest.approx((SLOPE + friction) / (1 - friction * SLOPE), rel=1e-3)


def test_the_figure_nafems_prints():
    assert run(model_of(wall_on_slope(0.3)), final_displacement=1e-3).peak == pytest.approx(0.412371, rel=1e-4)
