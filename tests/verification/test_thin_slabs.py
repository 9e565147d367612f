"""Long thin slabs on one another slide at the coefficient of friction, however thin they are.

The bottom of a slab and the top of the one below are nearly on one line, for slabs so long, but back to back: taken for
faces that touch, a slab of 10 m and 0.2 m had no equilibrium.
"""

from __future__ import annotations

import pytest

from orchestrator import analyse, find_joints, one_body_per_block, push
from orchestrator.masonry.joints import JointSettings
from orchestrator.masonry.wall import Block, Wall
from tests.support.pushover_chain import rectangle


@pytest.mark.parametrize(("length", "thick", "slabs"), [(10.0, 0.2, 2), (4.0, 0.05, 4), (20.0, 0.1, 3)])
def test_a_pile_of_slabs_slides(length, thick, slabs):
    piled = (Block(n + 1, rectangle(0.0, n * thick, length, thick), False, 20e3) for n in range(slabs))
    wall = Wall("pile", (Block(0, rectangle(-1.0, -0.3, length + 2.0, 0.3), True, 20e3), *piled), 0.4, 0.4)
    assemblage = find_joints(wall, JointSettings())
    pushed = push(assemblage, analyse(assemblage), one_body_per_block(assemblage))
    assert pushed.summary.valid
    assert pushed.capacity.peak_multiplier == pytest.approx(0.4, rel=2e-3)
