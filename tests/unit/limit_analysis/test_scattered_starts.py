"""Starts around known slips: as many as asked for, none negative, the same for a mirrored wall; descents from them."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from itertools import chain

import numpy as np
import pytest

from orchestrator.limit_analysis.paper.equilibrium import assemble_equilibrium
from orchestrator.limit_analysis.paper.linear_program import solve_limit_lp
from orchestrator.limit_analysis.paper.yield_conditions import coulomb
from orchestrator.limit_analysis.search.lower_states import TwoPrograms, descent
from orchestrator.limit_analysis.search.scattered_starts import TURNS_AROUND_A_STATE, scattered_starts, scattered_states
from orchestrator.limit_analysis.standard_view import standard_view
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.sources.block_files import read_blocks
from tests.support.limit_analysis_cases import weight_along
from tests.support.paths import DATA

WALL = read_blocks(DATA / "ferris_tinloi_wall3.json")


def mirrored(wall):
    blocks = tuple(replace(block, polygon=(block.polygon * [-1.0, 1.0])[::-1].copy()) for block in wall.blocks)
    return replace(wall, blocks=blocks[::-1])


def by_place(assemblage):
    """A slip that depends on where a joint is, and the joints' places, rounded."""
    x, y = assemblage.joints.centroid.T
    return np.abs(np.sin(7.0 * x + 3.0 * y)), [tuple(place) for place in np.round([x, y], 6).T]


def starts(wall, direction):
    """In the standard view of a wall pushed along +x (1) or -x (-1)."""
    assemblage = find_joints(wall, JointSettings())
    seen = standard_view(assemblage, weight_along(assemblage, direction)).assemblage
    slip, places = by_place(seen)
    found = list(scattered_starts(seen, slip, 4))
    return slip, [dict(zip(places, start, strict=True)) for start in found]


def test_a_wall_seen_from_behind_has_the_same_starts():
    _, here = starts(WALL, 1)
    _, there = starts(mirrored(WALL), -1)
    assert len(here) == 4
    for one, other in zip(here, there, strict=True):
        assert one.keys() == other.keys()
        assert [other[place] for place in one] == pytest.approx(list(one.values()))


def test_starts_differ_and_let_every_joint_slide():
    slip, found = starts(WALL, 1)
    values = np.array([list(start.values()) for start in found])
    assert (values > 0.0).all()
    assert (values.std(axis=0) > 0.0).all()
    assert np.corrcoef(np.log(values.mean(axis=0)), np.log(slip + 1e-3))[0, 1] > 0.3, "they keep the pattern"


class NobodyElse(ThreadPoolExecutor):
    """Leaves all that is to be done to who asks."""

    def submit(self, *_):
        done: Future[None] = Future()
        done.set_result(None)
        return done


@pytest.fixture(scope="module")
def descents():
    """Three starts near a mechanism, three that have nothing of one: their descents, and how two threads run all."""
    assemblage = find_joints(WALL, JointSettings())
    equilibrium, friction = assemble_equilibrium(assemblage), coulomb(assemblage)
    one, two = (TwoPrograms(equilibrium, friction) for _ in range(2))
    known = one.mechanism(solve_limit_lp(equilibrium, friction).normal)
    near, far = known.rates[:, 2], by_place(assemblage)[0]
    begin = [list(scattered_starts(assemblage, slip, 3)) for slip in (near, far)]

    def run(threads):
        with threads(max_workers=1) as other:
            return scattered_states(other, (one, two), chain(*begin))

    return *([list(descent(one, start, TURNS_AROUND_A_STATE)) for start in group] for group in begin), run


def multipliers(states):
    return [state.forces.load_multiplier for state in states]


def test_two_threads_find_what_one_finds_in_the_same_order(descents):
    """Bit for bit: a descent does not depend on what its programs solved before."""
    near, far, run = descents
    found = multipliers(run(ThreadPoolExecutor))
    assert found == multipliers(run(NobodyElse))
    assert len(found) >= len([*chain(*near)]) + len(far) > 6 + len(far)


def test_descents_around_a_mechanism_are_followed_to_their_end(descents):
    near, _, run = descents
    expected = [*chain(*near)]
    assert any(state.balances for state in expected)
    assert multipliers(run(ThreadPoolExecutor)[: len(expected)]) == multipliers(expected)


def test_a_descent_that_begins_out_of_balance_by_more_than_the_live_loads_power_has_one_turn(descents):
    """Starts that have nothing of a mechanism, whose descents would go on."""
    near, far, run = descents
    begun = [states[0] for states in far]
    assert min(state.imbalance for state in begun) > 1.0
    assert min(len(states) for states in far) > 1
    assert multipliers(run(ThreadPoolExecutor)[len([*chain(*near)]) :]) == multipliers(begun)
