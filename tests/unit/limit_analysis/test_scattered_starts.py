"""Starts around known slips: as many as asked for, none negative, the same for a mirrored wall; descents from them."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import chain

import numpy as np
import pytest

from orchestrator.limit_analysis.paper.equilibrium import assemble_equilibrium
from orchestrator.limit_analysis.paper.linear_program import solve_limit_lp
from orchestrator.limit_analysis.paper.yield_conditions import coulomb
from orchestrator.limit_analysis.search import scattered_starts as module
from orchestrator.limit_analysis.search.lower_states import TwoPrograms, descent
from orchestrator.limit_analysis.search.scattered_starts import TURNS, scattered_starts, scattered_states
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.sources.block_files import read_blocks
from tests.support.paths import DATA

WALL = read_blocks(DATA / "ferris_tinloi_wall3.json")


def mirrored(wall):
    blocks = tuple(replace(block, polygon=(block.polygon * [-1.0, 1.0])[::-1].copy()) for block in wall.blocks)
    return replace(wall, blocks=blocks[::-1])


def by_place(assemblage, direction):
    """A slip that depends on where a joint is, and the joints' places, rounded."""
    x, y = (assemblage.midpoint * [direction, 1.0]).T
    return np.abs(np.sin(7.0 * x + 3.0 * y)), [tuple(place) for place in np.round([x, y], 6).T]


def starts(wall, direction):
    assemblage = find_joints(wall, JointSettings())
    slip, places = by_place(assemblage, direction)
    found = list(scattered_starts(assemblage, direction, slip, 4))
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


@pytest.fixture(scope="module")
def descents():
    """Three starts near a mechanism, three that have nothing of one: their descents, and how to run them all."""
    assemblage = find_joints(WALL, JointSettings())
    equilibrium, friction = assemble_equilibrium(assemblage, 1), coulomb(assemblage)
    one, two = (TwoPrograms(equilibrium, friction) for _ in range(2))
    known = one.mechanism(solve_limit_lp(equilibrium, friction).normal)
    near, far = known.rates[:, 2], by_place(assemblage, 1)[0]
    begin = [list(scattered_starts(assemblage, 1, slip, 3)) for slip in (near, far)]

    def in_two_threads():
        with ThreadPoolExecutor(max_workers=1) as other:
            return scattered_states(other, (one, two), chain(*begin))

    alone = [[state for start in group for state in descent(one, start, TURNS)] for group in begin]
    return *alone, in_two_threads


def multipliers(states):
    return [state.forces.load_multiplier for state in states]


def test_two_threads_find_what_one_finds_in_the_same_order(descents, monkeypatch):
    """Bit for bit: a descent does not depend on what its programs solved before."""
    monkeypatch.setattr(module, "HOPELESS", ())
    near, far, in_two_threads = descents
    assert len(near) > 6
    assert multipliers(in_two_threads()) == multipliers(near + far)


def test_descents_from_starts_that_have_nothing_of_a_mechanism_end_early(descents):
    """Those around a mechanism do not, as far as they reach states."""
    near, far, in_two_threads = descents
    found = in_two_threads()
    assert any(state.balances for state in near)
    assert multipliers(found[: len(near)]) == multipliers(near)
    assert 3 <= len(found) - len(near) < len(far)


def test_without_any_hope_each_descent_has_one_turn(descents, monkeypatch):
    monkeypatch.setattr(module, "HOPELESS", (-1.0,))
    assert len(descents[-1]()) == 6
