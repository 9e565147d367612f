"""Limit analysis of blocks that are held together: closed forms and the kinematic theorem."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orchestrator.limit_analysis import analyse
from orchestrator.macroblocks.criteria import MacroblockSettings, merged, one_body, one_body_per_block
from orchestrator.macroblocks.merged_blocks import merged_multiplier
from tests.support.limit_analysis_cases import weight_along
from tests.support.walls import of_file


@pytest.fixture(scope="module")
def wall_1():
    return of_file("ferris_tinloi_wall1")


def test_one_body_slides_or_overturns(wall_1):
    """lambda = min(mu, b/h): wall 1 (2.0 m x 1.05 m) slides at 0.65, the tower (0.4 m x 2 m) overturns at 0.2."""
    tower = of_file("tower_5_blocks")
    assert merged_multiplier(wall_1, one_body(wall_1).body_of_block, "associative") == pytest.approx(0.65, rel=1e-7)
    assert merged_multiplier(tower, one_body(tower).body_of_block, "associative") == pytest.approx(0.2, rel=1e-7)
    behind = merged_multiplier(tower, one_body(tower).body_of_block, "associative", weight_along(tower, -1))
    assert behind == pytest.approx(0.2, rel=1e-7)


def test_nothing_merged_is_micro_limit_analysis(wall_1):
    analysis = analyse(wall_1)
    body = one_body_per_block(wall_1).body_of_block
    assert merged_multiplier(wall_1, body, "associative") == pytest.approx(0.64286, abs=1e-5)
    found = merged_multiplier(wall_1, body, "sequence")
    assert found == pytest.approx(analysis.sequence.load_multiplier, rel=1e-5)


def test_merging_what_moves_as_one_changes_nothing(wall_1):
    """The optimal mechanism is still possible, and no mechanism is new: the multiplier stays (kinematic theorem)."""
    analysis = analyse(wall_1)
    rigid = MacroblockSettings(tol_n=1e-7, tol_s=1e-7, tol_r=1e-7, tol_d=np.inf)
    partition = merged(wall_1, analysis.associative.mechanism, rigid)
    assert partition.count < 20, "some blocks do move as one"
    found = merged_multiplier(wall_1, partition.body_of_block, "associative")
    assert found == pytest.approx(analysis.associative.load_multiplier, rel=1e-6)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10_000))
def test_merging_more_never_lowers_the_associative_multiplier(seed):
    wall, random = of_file("ferris_tinloi_wall1"), np.random.default_rng(seed)
    free = ~np.array([block.fixed for block in wall.wall.blocks])
    body = np.zeros(len(free), int)
    body[free] = random.integers(0, 12, free.sum())
    coarser = np.where(free, body // 2, 0)
    for bodies in (body, coarser):
        bodies[~free] = 12
    low, high = (merged_multiplier(wall, b, "associative") for b in (body, coarser))
    assert 0.64286 - 1e-5 <= low <= high + 1e-7
