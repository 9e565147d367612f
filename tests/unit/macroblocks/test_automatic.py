"""Macroblocks that choose themselves: fewest bodies whose rigid-body multiplier stays near micro limit analysis."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from orchestrator.app import driver
from orchestrator.limit_analysis import analyse
from orchestrator.macroblocks import automatic
from orchestrator.macroblocks.automatic import (
    Motion,
    chosen,
    hierarchy,
    kept_multiplier,
    locked,
    macroblocks_of,
    motion_of_blocks,
)
from orchestrator.macroblocks.criteria import MacroblockSettings, one_body_per_block, partition_of
from orchestrator.macroblocks.merged_blocks import merged_multiplier
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.patterns import IrregularCourses, irregular_courses
from orchestrator.settings import case as cases
from tests.support.paths import DATA
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


def test_the_hierarchy_goes_from_every_stone_to_one_body_and_never_through_a_support(wall_1):
    assemblage, analysis = wall_1
    groups = hierarchy(assemblage, [analysis.headline.mechanism])
    fixed = np.array([block.fixed for block in assemblage.wall.blocks])
    assert [len(np.unique(group[~fixed])) for group in groups] == list(range(33, 0, -1))
    assert all(not np.isin(group[fixed], group[~fixed]).any() for group in groups)


@pytest.mark.parametrize("margin", [0.02, 0.002])
def test_wall_1_few_bodies_and_the_multiplier_within_the_margin(wall_1, margin):
    """The whole sequence on the bodies knows nothing of how they were chosen."""
    assemblage, analysis = wall_1
    partition = chosen(assemblage, analysis, margin)
    assert 1 < partition.count < 10
    micro = analysis.headline
    found = merged_multiplier(assemblage, partition.body_of_block, micro.flow_rule)
    assert found == pytest.approx(micro.load_multiplier, rel=margin)


def test_a_smaller_margin_never_gives_fewer_bodies(wall_1):
    assemblage, analysis = wall_1
    counts = [chosen(assemblage, analysis, margin).count for margin in (0.1, 0.02, 0.001)]
    assert counts == sorted(counts)


def test_macroblocks_that_save_little_are_told(wall_1, monkeypatch):
    assemblage, analysis = wall_1
    assert not any("save little" in remark for remark in chosen(assemblage, analysis, 0.02).remarks)
    monkeypatch.setattr(automatic, "_joined_while", lambda *_: one_body_per_block(assemblage))
    remarks = chosen(assemblage, analysis, 0.02).remarks
    assert "33 macroblocks of 33 stones save little: run --model micro has every stone" in remarks


def test_a_tower_that_overturns_as_one_still_has_two_bodies():
    """One body would do (lambda = b/h = 0.2), but it is no mechanism worth a finite element."""
    assemblage = of_file("tower_5_blocks")
    partition = chosen(assemblage, analyse(assemblage), 0.02)
    assert partition.count == 2


def random_wall(*arguments, **settings):
    assemblage = find_joints(irregular_courses(IrregularCourses(*arguments, **settings)), JointSettings())
    return assemblage, analyse(assemblage)


SEED_2 = ((0.7, 1.4), {"seed": 2})
DOOR_AND_WINDOW = ((0.5, 1.0, 0.0, 1.2), (1.6, 2.1, 0.6, 1.3))
SEED_7 = ((2.6, 1.8), {"openings": DOOR_AND_WINDOW, "widths": (0.2, 0.4), "heights": (0.15, 0.2), "seed": 7})


@pytest.mark.parametrize(("pattern", "peak"), [(SEED_2, 0.3614), (SEED_7, 0.3648)])
def test_the_state_that_the_elastic_wall_meets_stays_possible(pattern, peak):
    """Peaks of micro-FE, docs/studies/robustness.md; the sequence settles on 0.3779 and 0.4139.

    The headline is the peak to 1.5 %, and the bodies have it.
    """
    assemblage, analysis = random_wall(*pattern[0], **pattern[1])
    assert analysis.headline.load_multiplier == pytest.approx(peak, rel=0.015)
    partition = chosen(assemblage, analysis, 0.01)
    assert 1 < partition.count < 10
    assert kept_multiplier(assemblage, analysis, analysis.headline, partition, 0.01) is not None


def test_bodies_that_can_only_slide_do_not_keep_a_state_that_turns(wall_1):
    """Two halves of wall 1 one upon the other: friction 0.65 at the bed joint, 1.6 % above micro-LA's 0.6398."""
    assemblage, analysis = wall_1
    middle = np.array([block.polygon[:, 1].mean() > 0.5 for block in assemblage.wall.blocks], int)
    halves = partition_of(assemblage, middle)
    assert halves.count == 2
    assert kept_multiplier(assemblage, analysis, analysis.headline, halves, 0.02) == pytest.approx(0.65, abs=1e-4)
    assert kept_multiplier(assemblage, analysis, analysis.headline, halves, 0.01) is None


def test_a_single_block_stays_one_body():
    assemblage = of_file("single_block_sliding")
    assert chosen(assemblage, analyse(assemblage), 0.02).count == 1


@pytest.mark.parametrize(
    ("override", "choice"),
    [
        ("macroblocks.margin=0.01", "automatic"),
        ("macroblocks.tol_n=1e-3", "tolerances"),
        ("macroblocks.tol_d='450 mm'", "tolerances"),
    ],
)
def test_a_case_file_that_names_a_tolerance_means_it(override, choice):
    assert cases.read(DATA / "ferris_tinloi_wall1.json", [override]).macroblocks.choose == choice


def test_it_is_the_default_of_the_case_file():
    case = cases.read(DATA / "ferris_tinloi_wall1.json", ["macroblocks.margin=0.01"])
    partition = driver.segment(case).partition
    assert partition.tolerances is None
    assert any("chosen automatically" in remark for remark in partition.remarks)


def test_tolerances_that_are_given_are_honoured(wall_1):
    """tol_n = 0 and tol_D = 0: no two blocks that move are joined, whatever could be chosen automatically."""
    assemblage, analysis = wall_1
    strict = MacroblockSettings(tol_n=0.0, tol_d=0.0)
    found = macroblocks_of(assemblage, analysis, strict)
    assert found.tolerances == strict
    assert found.count > macroblocks_of(assemblage, analysis).count > 1
    assert macroblocks_of(assemblage, analysis, MacroblockSettings(choose="tolerances")).tolerances is not None


def test_a_rest_that_no_limit_state_closes_leaves_every_stone_a_body_at_once(wall_1, caplog):
    """No bodies could keep what is no state of the stones: nothing is tried but the stones themselves."""
    assemblage, analysis = wall_1
    forces = 0.8 * analysis.path.joint_forces
    rest = replace(analysis.path, flow_rule="last_rest", load_multiplier=0.4, joint_forces=forces, converged=False)
    with caplog.at_level("INFO"):
        partition = chosen(assemblage, replace(analysis, path=rest, sequence=None), 0.01)
    stones = sum(not block.fixed for block in assemblage.wall.blocks)
    assert partition.count == stones
    assert [record.args for record in caplog.records if "trying" in record.msg] == [(stones,)] * 2
    assert "save little" in partition.remarks[1]
