"""Criteria (3) and (4) on hand-made mechanisms whose partition is known by reasoning."""

from __future__ import annotations

from itertools import pairwise
from math import inf

import numpy as np
import pytest

from orchestrator.basis.errors import CaseError
from orchestrator.limit_analysis import Mechanism
from orchestrator.macroblocks.criteria import MacroblockSettings, merged, one_body, one_body_per_block
from orchestrator.masonry.block_properties import block_centroids
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.patterns import running_bond
from orchestrator.masonry.wall import Block, Wall


def column(*heights: float, width: float = 0.4) -> Wall:
    """Blocks on top of each other on a support (block 0)."""
    levels = np.concatenate([[-0.2, 0.0], np.cumsum(heights)])
    blocks = []
    for number, (low, high) in enumerate(pairwise(levels)):
        polygon = np.array([[0, low], [width, low], [width, high], [0, high]], dtype=float)
        blocks.append(Block(number, polygon, number == 0, 25e3))
    return Wall("column", tuple(blocks), 0.1, 0.6)


def assemblage_of(wall):
    return find_joints(wall, JointSettings())


def mechanism(assemblage, motion):
    """Return the mechanism of blocks that move by `motion`: block id -> (centre of rotation, rate) or (u, v)."""
    centroids = block_centroids(assemblage.wall)
    velocities = np.zeros((len(centroids), 3))
    for number, block in enumerate(assemblage.wall.blocks):
        first, second = motion.get(block.id, (0.0, 0.0))
        if np.ndim(first):
            arm = centroids[number] - np.array(first)
            velocities[number] = (-second * arm[1], second * arm[0], second)
        else:
            velocities[number] = (first, second, 0.0)

    def at(block, point):
        u, v, rate = velocities[block].T
        arm = point - centroids[block]
        return np.column_stack([u - rate * arm[:, 1], v + rate * arm[:, 0]])

    i, j = assemblage.joints.i, assemblage.joints.j
    relative = [at(j, point) - at(i, point) for point in (assemblage.joints.start, assemblage.joints.end)]
    opening = np.column_stack([np.sum(r * assemblage.joints.normal, axis=1) for r in relative])
    slip = np.sum(relative[0] * assemblage.joints.tangent, axis=1)
    return Mechanism(velocities, opening, slip, float(np.abs(velocities[:, :2]).max()))


def groups(assemblage, partition):
    """Return the sets of block ids of the moving bodies."""
    ids = np.array([block.id for block in assemblage.wall.blocks])
    return [set(ids[partition.body_of_block == body].tolist()) for body in range(partition.count)]


@pytest.fixture
def three():
    return assemblage_of(column(0.3, 0.3, 0.3))


def test_blocks_that_rotate_about_one_point_are_one_body(three):
    toe = [0.4, 0.3]
    partition = merged(three, mechanism(three, {2: (toe, -1.0), 3: (toe, -1.0)}), MacroblockSettings())
    assert groups(three, partition) == [{1}, {2, 3}]
    assert partition.body_of_block[0] == 2, "the support comes after the moving bodies"
    assert [set(three.joints.i[[k]]) | set(three.joints.j[[k]]) for k in partition.vanished_joints] == [{2, 3}]


def test_centres_further_apart_than_tol_d_stay_two_bodies(three):
    """Both turn alike, with a tiny opening between them, but about points 0.5 m apart."""
    motion = mechanism(three, {2: ([0.4, 0.3], -1.0), 3: ([0.4, 0.8], -1.0)})
    far = MacroblockSettings(tol_n=inf, tol_d=0.49)
    near = MacroblockSettings(tol_n=inf, tol_d=0.51)
    assert groups(three, merged(three, motion, far)) == [{1}, {2}, {3}]
    assert groups(three, merged(three, motion, near)) == [{1}, {2, 3}]


def test_resting_blocks_merge_with_each_other_and_never_with_a_moving_one(three):
    sliding_top = mechanism(three, {3: (1.0, 0.0)})
    settings = MacroblockSettings(tol_n=inf, tol_d=1e6)
    assert groups(three, merged(three, sliding_top, settings)) == [{1, 2}, {3}]


def test_alike_translations_merge_and_different_ones_do_not(three):
    alike = mechanism(three, {1: (1.0, 0.0), 2: (1.0, 0.0), 3: (1.0, 1.0)})
    assert groups(three, merged(three, alike, MacroblockSettings(tol_n=inf))) == [{1, 2}, {3}]
    opposite = mechanism(three, {1: (1.0, 0.0), 2: (-1.0, 0.0), 3: (-1.0, 0.0)})
    assert groups(three, merged(three, opposite, MacroblockSettings(tol_n=inf))) == [{1}, {2, 3}]


@pytest.mark.parametrize("largest", [0.0, 0.45, 1e6])
def test_courses_that_slide_at_different_speeds_are_no_body(three, largest):
    sliding = mechanism(three, {1: (0.2, 0.0), 2: (0.6, 0.0), 3: (1.0, 0.0)})
    criteria = MacroblockSettings(tol_n=inf, tol_d=largest)
    assert groups(three, merged(three, sliding, criteria)) == [{1}, {2}, {3}]


def test_translations_are_alike_to_a_thousandth_of_their_speed(three):
    nearly = mechanism(three, {1: (1.0, 0.0), 2: (1.0005, 0.0), 3: (1.003, 0.0)})
    assert groups(three, merged(three, nearly, MacroblockSettings(tol_n=inf))) == [{1, 2}, {3}]


def test_translating_against_rotating_is_infinitely_far(three):
    motion = mechanism(three, {1: (1.0, 0.0), 2: (1.0, 0.0), 3: ([0.4, 0.6], -1.0)})
    assert groups(three, merged(three, motion, MacroblockSettings(tol_n=inf, tol_d=1e9))) == [{1, 2}, {3}]


@pytest.mark.parametrize(
    ("settings", "merges"),
    [
        (MacroblockSettings(tol_n=inf, tol_s=0.99, tol_d=inf), False),
        (MacroblockSettings(tol_n=inf, tol_s=1.01, tol_d=inf), True),
        (MacroblockSettings(tol_n=0.0, tol_d=inf), True),  # it slides without opening
    ],
)
def test_tangential_tolerance(settings, merges):
    two = assemblage_of(column(0.3, 0.3))
    partition = merged(two, mechanism(two, {2: (1.0, 0.0)}), settings)
    assert (partition.count == 1) == merges


def test_rotation_and_normal_tolerances_at_midpoint_and_ends():
    """The upper block turns by 1 about the joint's midpoint: opening 0 in the middle, 0.2 at the ends."""
    two = assemblage_of(column(0.3, 0.3))
    motion = mechanism(two, {2: ([0.2, 0.3], -1.0)})
    scaled = {"tol_d": inf, "scale": "unit_power"}
    assert merged(two, motion, MacroblockSettings(tol_n=0.01, **scaled)).count == 1
    assert merged(two, motion, MacroblockSettings(tol_n=0.01, evaluate_at="ends", **scaled)).count == 2
    assert merged(two, motion, MacroblockSettings(tol_n=0.21, evaluate_at="ends", **scaled)).count == 1
    assert merged(two, motion, MacroblockSettings(tol_n=inf, tol_r=0.99, **scaled)).count == 2
    assert merged(two, motion, MacroblockSettings(tol_n=inf, tol_r=1.01, **scaled)).count == 1


def test_scale_multiplies_tolerances():
    """A slip of 5e-3 in unit power is the largest displacement, 1, in unit displacement."""
    two = assemblage_of(column(0.3, 0.3))
    motion = mechanism(two, {2: (5e-3, 0.0)})
    tolerance = {"tol_n": inf, "tol_s": 0.1, "tol_d": inf}
    assert merged(two, motion, MacroblockSettings(scale="unit_power", **tolerance)).count == 1
    assert merged(two, motion, MacroblockSettings(scale="unit_displacement", **tolerance)).count == 2


def test_joined_through_others_is_reported():
    """The lower right stone slips on the support; all stones merge by rotation tolerance, one joint exceeds tol_s."""
    wall = assemblage_of(running_bond(2, 2))
    bottom_left, bottom_right = 1, 2
    top = [block.id for block in wall.wall.blocks if block.id > 2]
    drift = {bottom_left: (1.0, 0.0), bottom_right: (1.2, 0.0)} | {number: (1.1, 0.0) for number in top}
    settings = MacroblockSettings(tol_n=0.3, tol_s=0.15, tol_d=inf, scale="unit_power")
    opens = mechanism(wall, drift)
    partition = merged(wall, opens, MacroblockSettings(tol_n=0.15, tol_s=0.15, tol_d=inf))
    assert partition.count == 1
    pair = {frozenset((int(wall.joints.i[k]), int(wall.joints.j[k]))) for k in partition.transitive_joints}
    assert pair == {frozenset((bottom_left, bottom_right))}
    assert any("joined through others" in remark for remark in partition.remarks)
    assert merged(wall, opens, settings).transitive_joints.size == 0


def test_one_body_warns_and_one_body_per_block_keeps_every_joint():
    wall = assemblage_of(running_bond(3, 3))
    trivial, every = one_body(wall), one_body_per_block(wall)
    assert trivial.count == 1
    assert any("one macroblock" in remark for remark in trivial.remarks)
    assert every.count == sum(not block.fixed for block in wall.wall.blocks) == 10
    assert every.vanished_joints.size == 0
    assert every.remarks == ()


def test_tolerance_below_the_noise_is_refused():
    two = assemblage_of(column(0.3, 0.3))
    with pytest.raises(CaseError, match=r"macroblocks\.tol_n.*noise.*use at least"):
        merged(two, mechanism(two, {2: (1.0, 0.0)}), MacroblockSettings(tol_n=1e-12))
