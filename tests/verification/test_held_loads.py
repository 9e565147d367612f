"""A load held above a peak is held until the wall rests, or has moved far: a motion that takes long is no fall. What a
wall bears, and how it falls, is that of its rest and of all this motion.

The other road: rigid blocks that are followed in large displacements, where a wall bears less than as it was drawn.
"""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator import (
    JointSettings,
    LoadSettings,
    SteppingSettings,
    analyse,
    find_joints,
    loads_on,
    one_body_per_block,
    push,
)
from orchestrator.masonry.patterns import ArchedOpening, ArchedWall, IrregularCourses, Rubble, arched_wall, rubble

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


def test_rubble_that_lets_go_bears_what_it_rests_under():
    """It rests up to 0.426 as drawn, and a state to which it moves from there has 0.380, which was the answer; micro-FE
    bears 0.411 to 0.415, from which no headline is to be 3 % off."""
    wall = rubble(Rubble(2.6, 2.2, stone=0.3343056105572368, flatness=1.8135930633772337, seed=4))
    assemblage = find_joints(wall, JointSettings())
    found = analyse(assemblage)
    stones = push(assemblage, found, one_body_per_block(assemblage), stepping=SteppingSettings(final_drop=0.05))
    assert stones.summary.valid
    assert found.headline.load_multiplier == pytest.approx(stones.capacity.peak_multiplier, rel=0.03)


def test_stones_that_come_loose_as_rubble_lets_go_are_not_the_wall():
    """Three stones, 2.6 % of the weight, fall at 0.236, and the state that the wall moves to was its answer; then two
    more. Micro-FE loses stones one by one, too, and bears 0.391 (run 87 of docs/studies/macroblock_peaks.csv)."""
    wall = rubble(Rubble(2.6, 2.2, stone=0.29381643514719435, flatness=1.611925043776006, seed=6))
    found = analyse(find_joints(wall, JointSettings()), loads=loads_on(wall, LoadSettings("-x")))
    left = found.headline.horizontal_load / found.horizontal_load
    assert len(found.local_failures) == 2
    assert left * found.headline.load_multiplier == pytest.approx(0.391, rel=0.015)


def test_an_arcade_falls_as_a_whole():
    """Three stones of its first pier, that fall back when all of it already falls, were its mechanism, 3 % of its
    weight. In finite elements all piers lean."""
    openings = tuple(ArchedOpening(0.7 + 1.9 * k, 1.9 + 1.9 * k, 0.0, 1.5, depth=0.3, voussoirs=9) for k in range(3))
    courses = IrregularCourses(6.4, 3.0, widths=(0.3, 0.5), heights=(0.2, 0.3), seed=4)
    found = analyse(find_joints(arched_wall(ArchedWall(courses, openings)), JointSettings()))
    fast = np.abs(found.headline.mechanism.velocities).max(axis=1)
    weights = -found.loads.dead[:, 1]
    assert weights[fast > 0.1 * fast.max()].sum() > 0.5 * weights.sum()
