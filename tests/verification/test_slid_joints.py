"""Rigid blocks that have slid along a joint press each other where they still lie on each other.

Where the end of an edge was no end of the joint it is not known: a corner that slides over it is followed beyond.
"""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator import JointSettings, LoadSettings, SteppingSettings, analyse, find_joints, one_body_per_block, push
from orchestrator.limit_analysis.gravity import problem_of
from orchestrator.limit_analysis.search.joint_points import OF_MORTAR, OF_STONES
from orchestrator.limit_analysis.search.moved_joints import moved_joints
from orchestrator.loads import loads_on
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.masonry.wall import Block, Wall
from tests.support.paths import DATA
from tests.support.walls import between

LENGTH, BED = 0.5, 2.0


@pytest.mark.parametrize("points", [OF_STONES, OF_MORTAR], ids=["stones", "mortar"])
@pytest.mark.parametrize("first_is_bed", [True, False])
@pytest.mark.parametrize("has_vertices", [False, True], ids=["", "vertices"])
@pytest.mark.parametrize(("left", "slid"), [(0.75, 0.4), (1.5, 0.35), (0.0, -0.35), (0.75, -0.6), (1.5, 0.6)])
def test_forces_of_a_joint_act_where_its_blocks_overlap(points, has_vertices, first_is_bed, left, slid):
    """The middle of the joint stayed with the block of the lower number, also once it was off the other. Vertices of
    the bed where the block began and ended, as drawings have them, are no corners of it."""
    bed, block = between(0.0, -0.3, BED, 0.0), between(left, 0.0, left + LENGTH, 0.3)
    if has_vertices:
        bed = np.insert(bed, 3, [[end, 0.0] for end in (left + LENGTH, left) if 0.0 < end < BED], axis=0)
    drawn = [(bed, True), (block, False)] if first_is_bed else [(block, False), (bed, True)]
    wall = Wall("slid", tuple(Block(k, outline, fixed, 20e3) for k, (outline, fixed) in enumerate(drawn)), 0.3, 0.6)
    assemblage = find_joints(wall, JointSettings())
    joints = moved_joints(assemblage, problem_of(assemblage).equilibrium, points.places, 1.0)
    B, rates = joints.at(np.array([slid, 0.0, 0.0]))
    upright, moment = B.toarray()[1:, ::2]
    acts = left + slid + 0.5 * LENGTH + joints.length * moment / upright
    touches = np.abs(rates[:, 0]) < 1e-12
    low, high = max(0.0, left + slid), min(BED, left + slid + LENGTH)
    on_both = (acts > low - 1e-9) & (acts < high + 1e-9)
    assert np.array_equal(touches, on_both), "what lies on both blocks touches, and nothing else"
    if low < high:
        assert (acts[touches].min(), acts[touches].max()) == pytest.approx((low, high))


def test_an_arch_bears_no_more_once_a_joint_has_slid_by_half_its_length():
    """Five voussoirs: the middle of the last joint bore when it was off the springer: 0.4235, finite elements 0.349."""
    assemblage, load = find_joints(read_blocks(DATA / "arch_5_voussoirs.json"), JointSettings()), LoadSettings("-x")
    analysis = analyse(assemblage, loads=loads_on(assemblage.wall, load))
    stepping = SteppingSettings(final_displacement=0.12)
    done = push(assemblage, analysis, one_body_per_block(assemblage), load, stepping=stepping)
    assert not done.complaints
    assert analysis.rigid_peak == pytest.approx(done.capacity.peak_multiplier, rel=0.01)
