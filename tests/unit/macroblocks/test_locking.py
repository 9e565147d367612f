"""Bodies that lock while they move: momentum, energy that is lost, and the order in which blocks are joined."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from orchestrator.limit_analysis import analyse
from orchestrator.macroblocks.criteria import one_body_per_block
from orchestrator.macroblocks.locking import Motion, hierarchy, locked, motion_of_blocks, pairs_by_loss
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.patterns import running_bond
from tests.support.walls import of_file


@pytest.fixture(scope="module")
def wall_1():
    assemblage = of_file("ferris_tinloi_wall1")
    return assemblage, analyse(assemblage)


def bar(position, velocity, rotation, mass=1.0, inertia=1.0):
    return Motion(mass, inertia, np.array(position, float), np.array(velocity, float), rotation)


def test_two_equal_balls_that_lock_lose_half_the_energy():
    """One at rest, one hitting it centrally: a perfectly plastic collision, v/2, half of m v^2/2 is lost."""
    together, lost = locked(bar([0, 0], [2, 0], 0.0), bar([1, 0], [0, 0], 0.0))
    assert together.velocity == pytest.approx([1, 0])
    assert lost == pytest.approx(0.5 * 0.5 * 2**2)


def test_locking_keeps_momentum_about_any_point():
    first, second = bar([0, 0], [1, 2], 0.3, 2.0, 0.7), bar([3, 1], [-1, 0.5], -0.4, 1.5, 0.2)
    together, lost = locked(first, second)

    def momentum(m):
        x, y = m.centre
        u, v = m.velocity
        return np.array([m.mass * u, m.mass * v, m.mass * (x * v - y * u) + m.inertia * m.rotation])

    assert momentum(together) == pytest.approx(momentum(first) + momentum(second))
    assert lost > 0


def test_what_moves_as_one_rigid_body_locks_without_loss():
    """Two parts of one body turning about the origin at 0.5 rad/s: velocity = 0.5 (-y, x)."""
    first, second = bar([2, 1], [-0.5, 1.0], 0.5, 3.0), bar([4, 0], [0.0, 2.0], 0.5)
    together, lost = locked(first, second)
    assert lost == pytest.approx(0, abs=1e-12)
    assert together.rotation == pytest.approx(0.5)


def test_inertia_of_a_rectangle_is_that_of_the_textbook(wall_1):
    """m (b^2 + h^2) / 12 about the centroid; whole blocks of wall 1 are 0.4 m x 0.175 m, of unit thickness here."""
    assemblage, analysis = wall_1
    motions = motion_of_blocks(assemblage, analysis.headline.mechanism)
    whole = [m for m, block in zip(motions, assemblage.wall.blocks, strict=True) if np.ptp(block.polygon[:, 0]) == 0.4]
    assert whole
    for motion in whole:
        assert motion.inertia == pytest.approx(motion.mass * (0.4**2 + 0.175**2) / 12)


@pytest.mark.parametrize("times", [1.1, np.sqrt(2.0), 7.0])
def test_rounding_does_not_choose_between_bodies_that_lose_alike(wall_1, times):
    """A mechanism has no measure: with heavier stones it had other macroblocks, as stones that move as one lose nothing
    but for rounding."""
    assemblage, analysis = wall_1
    slow, stones = analysis.headline.mechanism, one_body_per_block(assemblage)
    fast = replace(slow, velocities=times * slow.velocities)
    assert np.array_equal(hierarchy(assemblage, [fast]), hierarchy(assemblage, [slow]))
    assert pairs_by_loss(stones, assemblage, [fast]) == pairs_by_loss(stones, assemblage, [slow])


@pytest.mark.parametrize("mirror", [1, -1])
def test_numbers_of_stones_do_not_choose_between_bodies_that_lose_alike(mirror):
    """Stones of a running bond are alike, and those of one macroblock lose nothing to each other: of 66 stones, and of
    their mirror image, other bodies were finer ones than those of the macroblocks, in another numbering."""
    assemblage = find_joints(running_bond(6, 10), JointSettings())
    blocks, motion = assemblage.wall.blocks, analyse(assemblage).headline.mechanism
    shuffled = np.random.default_rng(1).permutation(len(blocks))
    seen = [replace(blocks[k], polygon=(blocks[k].polygon * [mirror, 1.0])[::mirror]) for k in shuffled]
    other = find_joints(replace(assemblage.wall, blocks=tuple(seen)), JointSettings())
    moved = replace(motion, velocities=motion.velocities[shuffled] * [mirror, 1.0, mirror])
    for one, another in zip(hierarchy(assemblage, [motion]), hierarchy(other, [moved]), strict=True):
        back = another[np.argsort(shuffled)]
        assert len(np.unique(one)) == len(np.unique(back)) == len(np.unique(np.column_stack([one, back]), axis=0))


def test_the_hierarchy_goes_from_every_stone_to_one_body_and_never_through_a_support(wall_1):
    assemblage, analysis = wall_1
    groups = hierarchy(assemblage, [analysis.headline.mechanism])
    fixed = np.array([block.fixed for block in assemblage.wall.blocks])
    assert [len(np.unique(group[~fixed])) for group in groups] == list(range(33, 0, -1))
    assert all(not np.isin(group[fixed], group[~fixed]).any() for group in groups)
