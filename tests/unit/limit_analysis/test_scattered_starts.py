"""Starts around known slips: as many as asked for, none negative, the same for a mirrored wall; descents from them."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from orchestrator.joints import JointSettings, find_joints
from orchestrator.limit_analysis.equilibrium import assemble_equilibrium
from orchestrator.limit_analysis.linear_program import solve_limit_lp
from orchestrator.limit_analysis.lower_states import TwoPrograms, descent
from orchestrator.limit_analysis.scattered_starts import HOPELESS, TURNS, scattered_starts, scattered_states
from orchestrator.limit_analysis.yield_conditions import coulomb
from orchestrator.masonry.readers import read_blocks

WALL = read_blocks(Path(__file__).parents[2] / "data" / "ferris_tinloi_wall3.json")


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


def hopeful(states):
    """Return the states of a descent up to the first that is further from balance than its turn allows."""
    kept = []
    for state in states:
        kept.append(state)
        if len(kept) <= len(HOPELESS) and state.imbalance > HOPELESS[len(kept) - 1]:
            break
    return kept


def test_two_threads_find_what_one_finds_in_the_same_order():
    """Bit for bit: a descent does not depend on what its programs solved before. Hopeless ones end early."""
    assemblage = find_joints(WALL, JointSettings())
    equilibrium, friction = assemble_equilibrium(assemblage, 1), coulomb(assemblage)
    one = TwoPrograms(equilibrium, friction)
    known = one.mechanism(solve_limit_lp(equilibrium, friction).normal)
    near, far = known.rates[:, 2], by_place(assemblage, 1)[0]
    begin = [start for slip in (near, far) for start in scattered_starts(assemblage, 1, slip, 3)]
    whole = [list(descent(one, start, TURNS)) for start in begin]
    alone = [state.forces.load_multiplier for states in whole for state in hopeful(states)]
    with ThreadPoolExecutor(max_workers=1) as other:
        states = scattered_states(other, (one, TwoPrograms(equilibrium, friction)), iter(begin))
    assert 6 < len(alone) < sum(len(states) for states in whole)
    assert [state.forces.load_multiplier for state in states] == alone
