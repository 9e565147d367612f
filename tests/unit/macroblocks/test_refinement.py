"""Finer macroblocks, and when they are asked for."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from orchestrator.app.curve_end import NOT_ENOUGH
from orchestrator.app.refining import push_and_refine
from orchestrator.basis.errors import CaseError, ConvergenceError
from orchestrator.limit_analysis import analyse
from orchestrator.macroblocks.automatic import ELSEWHERE
from orchestrator.macroblocks.criteria import one_body, one_body_per_block, partition_of, stones_of
from orchestrator.macroblocks.refinement import HELD, Borne, finer, is_enough, more_bodies, remarked
from tests.support.walls import of_file

MARGIN = 0.01
STONES = 40


@pytest.fixture(scope="module")
def wall_1():
    assemblage = of_file("ferris_tinloi_wall1")
    return assemblage, analyse(assemblage)


def test_finer_bodies_are_parts_of_the_bodies_and_twice_as_many(wall_1):
    assemblage, analysis = wall_1
    coarse = one_body(assemblage)
    for count in (2, 4, 8):
        fine = finer(assemblage, analysis, coarse)
        assert fine.count == count
        for number in range(fine.count):
            parents = coarse.body_of_block[fine.body_of_block == number]
            assert len(set(parents)) == 1
        coarse = fine


def test_in_the_end_every_stone_is_a_body_and_before_it_at_most_half_as_many(wall_1):
    assemblage, analysis = wall_1
    partition, stones = one_body(assemblage), one_body_per_block(assemblage)
    counts = [partition.count]
    while (fine := finer(assemblage, analysis, partition)) is not None:
        partition = fine
        counts.append(partition.count)
    assert counts == [1, 2, 4, 8, 16, stones.count]
    assert len(set(partition.body_of_block)) == len(set(stones.body_of_block))


@pytest.mark.parametrize(
    ("bodies", "stones", "more"),
    [
        (25, 100, 50),
        (26, 100, 100),
        (60, 171, 171),
        (171, 171, None),
        (52, 531, 104),
        (100, 531, 200),
        (104, 531, None),
    ],
)
def test_many_bodies_of_a_large_wall_are_not_divided_any_more(bodies, stones, more):
    """More than 200 take as long as every stone does, which is pushed where that is asked for."""
    assert more_bodies(bodies, stones) == more


def test_two_bodies_of_a_mechanism_of_two_are_these():
    """A stack of which the upper part slides: parts that move as one lose no energy when they lock."""
    assemblage = of_file("tower_5_blocks")
    analysis = analyse(assemblage)
    velocities = np.zeros_like(analysis.headline.mechanism.velocities)
    free = np.flatnonzero([not block.fixed for block in assemblage.wall.blocks])
    velocities[free[3:], 0] = 1.0
    state = replace(analysis.headline, mechanism=replace(analysis.headline.mechanism, velocities=velocities))
    fine = finer(assemblage, replace(analysis, path=state, sequence=None), one_body(assemblage))
    assert fine.count == 2
    assert len(set(fine.body_of_block[free[3:]])) == len(set(fine.body_of_block[free[:3]])) == 1


def bears(*shares, is_peak=True, is_valid=True):
    """Bodies 2, 4, 8 ... that bear shares of the headline."""
    return lambda headline: [Borne(2 ** (k + 1), share * headline, is_peak, is_valid) for k, share in enumerate(shares)]


@pytest.mark.parametrize(
    ("borne", "enough"),
    [
        (bears(1.008), False),  # within the margin, but 4 of 40 stones are few
        (bears(1.008, 1.0), True),
        (bears(1.0, 1.12), False),
        (bears(1.12, 1.0), False),
        (bears(1.12, 1.0, 1.0), True),
        (bears(1.015, 1.015, 1.015, 1.015), False),  # 28 of 59 stones with a window: 11 %
        (bears(1.05), False),
        (bears(1.05, 1.05), False),
        (bears(1.05, 1.05, 1.05), False),  # 8 of 40 stones are few
        (bears(1.05, 1.05, 1.05, 1.05), False),  # the same thrice in a row, and more than rigid stones can
        (bears(1.37, 1.39, 1.39, 1.39, 1.39), False),
        (bears(1.05, 1.05, 1.03, 1.03), False),
        (bears(1.05, 1.05, 1.03, 1.005), True),
        (bears(0.95), False),
        (bears(0.80, 0.95), False),
        (bears(0.80, 0.805), False),
        (bears(0.80, 0.965, 0.96, 0.96), True),
        (bears(0.80, 0.805, 0.80, 0.80), False),  # another state
        (bears(0.60, is_peak=False), True),  # pushed no further: nothing is known
        (bears(1.00, is_valid=False), False),
    ],
)
def test_which_bodies_are_enough(wall_1, borne, enough):
    analysis = wall_1[1]
    assert is_enough(analysis, MARGIN, borne(analysis.headline.load_multiplier), STONES) is enough


@pytest.mark.parametrize(("bodies", "enough"), [(5, True), (4, False)])
def test_twice_as_many_are_tried_only_where_they_are_few(wall_1, bodies, enough):
    analysis = wall_1[1]
    borne = [Borne(bodies, analysis.headline.load_multiplier, is_peak=True, is_valid=True)]
    assert is_enough(analysis, MARGIN, borne, STONES) is enough


def test_the_same_thrice_far_below_what_rigid_blocks_bear_as_they_move_is_another_state(wall_1):
    """How soft stones and mortar are rigid blocks on springs know; bonds, for which they are not moved, they do not."""
    analysis = wall_1[1]
    headline = analysis.headline.load_multiplier
    for peak, share, enough in ((None, 0.6, True), (headline, 0.6, False), (headline, 0.96, True)):
        known = replace(analysis, rigid_peak=peak, pressed_peak=None)
        assert is_enough(known, MARGIN, bears(share, share, share, share)(headline), STONES) is enough
    small = [replace(one, in_large=False) for one in bears(*[0.6] * 4)(headline)]
    assert is_enough(replace(analysis, rigid_peak=headline), MARGIN, small, STONES)


def test_bodies_that_supports_hold_agree_with_nothing_and_are_not_refined(wall_1):
    """They bear any multiple of the load: no number of bodies has a peak that limit analysis could tell."""
    assemblage, analysis = wall_1
    held = Borne(2, 20 * analysis.headline.load_multiplier, is_peak=False, is_valid=True, is_held=True)
    assert is_enough(analysis, MARGIN, [held], STONES)
    assert not is_enough(analysis, MARGIN, [replace(held, is_held=False)], STONES)
    assert not is_enough(analysis, MARGIN, [replace(held, is_valid=False)], STONES)
    before = one_body(assemblage).remarks
    assert remarked(analysis, MARGIN, one_body(assemblage), [held], STONES).remarks == (*before, HELD)
    stones = replace(held, bodies=STONES)
    assert remarked(analysis, MARGIN, one_body(assemblage), [stones], STONES).remarks == before


def test_an_interval_of_limit_analysis_is_no_agreement(wall_1):
    """Any number of bodies may bear something between its ends: thrice the same must be borne, or the headline."""
    assemblage, analysis = wall_1
    headline = analysis.headline.load_multiplier
    wide = replace(analysis, interval=(0.8 * headline, headline))
    assert not is_enough(wide, MARGIN, bears(0.9)(headline), 2)
    assert is_enough(wide, MARGIN, bears(0.9, 0.9, 0.9)(headline), 2)
    assert is_enough(wide, MARGIN, bears(1.0)(headline), 2)
    above = replace(analysis, interval=(headline, 1.1 * headline))
    assert not is_enough(above, MARGIN, bears(1.05, 1.05, 1.05)(headline), 2), "44 of 132 stones of an arcade: 4.7 %"
    said = remarked(wide, MARGIN, one_body(assemblage), bears(0.9)(headline), 2).remarks
    assert said == one_body(assemblage).remarks, "nor is it a difference"


def test_bodies_in_large_displacements_agree_with_rigid_blocks_in_large_displacements(wall_1):
    """A wall that loses 4 % of its strength as it moves; 4 % off the headline is no difference then."""
    assemblage, analysis = wall_1
    headline = analysis.headline.load_multiplier
    moved = replace(analysis, rigid_peak=0.96 * headline)
    large, small = (
        [replace(bears(share)(headline)[0], in_large=one) for share in (0.96, 1.0)] for one in (True, False)
    )
    assert [is_enough(moved, MARGIN, [one], 2) for one in large] == [True, False]
    assert [is_enough(moved, MARGIN, [one], 2) for one in small] == [False, True]
    assert remarked(moved, MARGIN, one_body(assemblage), large[:1], 2).remarks == one_body(assemblage).remarks


def test_bodies_agree_down_to_what_is_left_as_stones_give_way_at_edges(wall_1):
    assemblage, analysis = wall_1
    headline = analysis.headline.load_multiplier
    pressed = replace(analysis, pressed_peak=0.95 * headline)
    shares = (0.93, 0.945, 0.97, 1.005, 1.03)
    twice = [is_enough(pressed, MARGIN, bears(share, share)(headline), 4) for share in shares]
    assert twice == [is_enough(pressed, MARGIN, bears(share, share, share)(headline), 400) for share in shares]
    assert not any(is_enough(pressed, MARGIN, bears(share, share)(headline), 400) for share in shares)  # 4 are few
    assert twice == [False, *[True] * 3, False]
    assert not any(is_enough(pressed, MARGIN, bears(share)(headline), 2) for share in shares)  # wherever it is between
    near = replace(analysis, pressed_peak=0.985 * headline)
    once = [is_enough(near, MARGIN, bears(share)(headline), 2) for share in (0.97, 0.98, 0.99, 1.005, 1.03)]
    assert once == [False, *[True] * 3, False]
    nothing = replace(analysis, pressed_peak=0.0)
    assert [is_enough(nothing, MARGIN, bears(*of)(headline), 4) for of in ((0.3,), (0.3, 0.3))] == [False, True]
    whole = one_body(assemblage)
    assert remarked(nothing, MARGIN, whole, bears(0.3)(headline), 2).remarks == whole.remarks
    small = [replace(one, in_large=False) for one in bears(0.97, 0.97)(headline)]
    assert not is_enough(pressed, MARGIN, small, 4)
    assert (
        remarked(pressed, MARGIN, one_body(assemblage), bears(0.945)(headline), 2).remarks
        == one_body(assemblage).remarks
    )


def test_finer_macroblocks_that_do_not_fit_into_the_memory_leave_those_before_them(wall_1):
    assemblage, analysis = wall_1

    def push(partition, suffices):
        if partition.count > 2:
            raise CaseError("mesh.size", "needs more than there is", "choose larger elements")
        capacity = SimpleNamespace(peak_multiplier=1.0, peak_reached=True)
        return SimpleNamespace(
            capacity=capacity,
            summary=SimpleNamespace(valid=True, displacements="large", held=False, stopped_because=""),
            of=partition.count,
            cut_short=False,
        )

    partition, done = push_and_refine(assemblage, analysis, one_body(assemblage), push)
    assert partition.count == done.of == 2
    assert any("4 macroblocks could not be pushed: mesh.size: needs more" in remark for remark in partition.remarks)
    with pytest.raises(CaseError, match="needs more"):
        push_and_refine(assemblage, analysis, one_body_per_block(assemblage), push)


def test_finer_macroblocks_without_a_curve_leave_those_before_them(wall_1):
    """A stone that macroblocks hold falls under gravity once it is a body of its own."""
    assemblage, analysis = wall_1
    pushed = []

    def push(partition, suffices):
        pushed.append(partition.count)
        if partition.count > 2:
            raise ConvergenceError("macro FE", "no equilibrium under gravity")
        summary = SimpleNamespace(valid=True, displacements="large", held=False, stopped_because="")
        capacity = SimpleNamespace(peak_multiplier=1.0, peak_reached=True)
        return SimpleNamespace(capacity=capacity, summary=summary, cut_short=False)

    partition, _ = push_and_refine(assemblage, analysis, one_body(assemblage), push)
    assert pushed == [1, 2, 4, 2], "what the last pushover leaves in a folder is that of the macroblocks returned"
    assert partition.count == 2
    assert any("4 macroblocks could not be pushed: " in remark for remark in partition.remarks)
    with pytest.raises(ConvergenceError):
        push_and_refine(assemblage, analysis, one_body_per_block(assemblage), push)


def test_a_larger_margin_asks_for_less(wall_1):
    analysis = wall_1[1]
    headline = analysis.headline.load_multiplier
    assert is_enough(analysis, 0.05, bears(1.04, 1.01)(headline), STONES)
    assert not is_enough(analysis, MARGIN, bears(1.04, 1.01)(headline), STONES)


def test_what_is_said(wall_1):
    assemblage, analysis = wall_1
    headline = analysis.headline.load_multiplier
    partition = replace(partition_of(assemblage, np.arange(len(assemblage.wall.blocks))), remarks=("chosen", ELSEWHERE))
    said = remarked(analysis, MARGIN, partition, bears(1.0)(headline), STONES).remarks
    assert said == ("chosen", ELSEWHERE)
    said = remarked(analysis, MARGIN, partition, bears(1.1, 1.0)(headline), STONES).remarks
    expected = f"2 bear {1.1 * headline:.4f}, 4 bear {headline:.4f} (rigid blocks {analysis.rigid_peak:.4f})"
    assert said == ("chosen", f"refined: in finite elements {expected}")
    said = remarked(
        analysis, MARGIN, partition, bears(1.0, is_valid=False)(headline) + bears(1.0)(headline), STONES
    ).remarks
    assert f"2 bear {headline:.4f} (not valid), 2 bear" in said[-1]
    said = remarked(analysis, MARGIN, partition, bears(1.1, 1.06)(headline), STONES).remarks
    assert said[-1].startswith("these macroblocks bear 6.0% more in finite elements than in limit analysis: compare")
    said = remarked(analysis, MARGIN, partition, bears(1.1, 1.06)(headline), 4).remarks
    assert said[-1] == "all stones bear 6.0% more in finite elements than in limit analysis"


def pushes(assemblage, analysis, shares, ends="", cut_short=0):
    """Push one body, two and so on that bear these shares of the headline; return their numbers, which of the shares
    would have sufficed, and the partition pushed last; ends: what a curve that does not suffice says of its end;
    cut_short: how many curves end before their peak as bodies overlap."""
    headline, pushed, sufficed = analysis.headline.load_multiplier, [], []

    def push(partition, suffices):
        share = shares[min(len(pushed), len(shares) - 1)]
        pushed.append(partition.count)
        sufficed.append(suffices(share * headline))
        said = "" if sufficed[-1] else ends
        summary = SimpleNamespace(valid=True, displacements="large", held=False, stopped_because=said)
        is_short = len(pushed) <= cut_short
        capacity = SimpleNamespace(peak_multiplier=share * headline, peak_reached=not is_short)
        return SimpleNamespace(capacity=capacity, summary=summary, cut_short=is_short)

    partition, _ = push_and_refine(assemblage, analysis, one_body(assemblage), push)
    return pushed, sufficed, partition


def test_bodies_that_bear_more_than_rigid_blocks_cannot_be_the_last(wall_1):
    """Whatever their curve is beyond the peak; those that bear as much or less may come to agree yet."""
    pushed, sufficed, _ = pushes(*wall_1, [1.3, 1.1, 1.0, 1.0])
    assert (pushed, sufficed) == ([1, 2, 4], [False, False, True])
    assert pushes(*wall_1, [0.8, 0.95, 1.2, 1.0])[1] == [True, True, False, True]


def test_bodies_that_overlap_before_their_peak_are_never_the_last(wall_1):
    """They bear at least so much; a curve that goes on to its end without a peak below limit analysis is enough."""
    assert pushes(*wall_1, [0.9, 1.0, 1.0], cut_short=1)[0] == [1, 2, 4]
    assert pushes(*wall_1, [1.0, 1.0, 1.0], cut_short=1)[0] == [1, 2]


def test_every_stone_suffices_whatever_it_bears(wall_1):
    pushed, sufficed, partition = pushes(*wall_1, [1.3, 1.2], NOT_ENOUGH)
    assert pushed[-1] == partition.count == stones_of(wall_1[0])
    assert sufficed == [*[False] * (len(pushed) - 1), True]


def test_macroblocks_left_beyond_their_peak_are_never_the_last(wall_1):
    """Where finer ones have no curve these are pushed again, and nothing stops them."""
    assemblage, analysis = wall_1
    asked = []

    def push(partition, suffices):
        if partition.count > 1:
            raise CaseError("mesh.size", "needs more than there is", "choose larger elements")
        asked.append(suffices(1e3))
        said = "" if asked[-1] else NOT_ENOUGH
        summary = SimpleNamespace(valid=True, displacements="large", held=False, stopped_because=said)
        capacity = SimpleNamespace(peak_multiplier=1e3, peak_reached=True)
        return SimpleNamespace(capacity=capacity, summary=summary, cut_short=False)

    _, done = push_and_refine(assemblage, analysis, one_body(assemblage), push)
    assert asked == [False, True]
    assert done.summary.stopped_because == ""
