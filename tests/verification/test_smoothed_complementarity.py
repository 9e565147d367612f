"""Smoothed complementarity conditions: closed form, and a valid state of a large wall."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from orchestrator.limit_analysis.paper.equilibrium import assemble_equilibrium
from orchestrator.limit_analysis.paper.linear_program import LimitProgram, solve_limit_lp
from orchestrator.limit_analysis.paper.yield_conditions import coulomb
from orchestrator.limit_analysis.problem import Problem
from orchestrator.limit_analysis.search import smoothed_complementarity
from orchestrator.limit_analysis.search.complementarity import CentralPoint
from orchestrator.limit_analysis.search.lower_states import CLOSE_FACE_WEIGHT, TwoPrograms, descent
from orchestrator.limit_analysis.search.moving_part import moving_part
from orchestrator.limit_analysis.search.other_states import closed_state
from orchestrator.limit_analysis.search.scaled_problem import scaled_problem
from orchestrator.limit_analysis.search.smoothed_complementarity import (
    LAST_GAP,
    Reached,
    both_slips,
    smoothed_start,
    solve_smoothed,
)
from orchestrator.limit_analysis.validation import validate
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.patterns import running_bond
from tests.support.limit_analysis_cases import assemblage_of, box


@pytest.mark.parametrize(("width", "height", "expected"), [(0.5, 1.0, 0.5), (1.0, 0.5, 0.65)])
def test_one_block_overturns_or_slides(width, height, expected):
    """min(mu, b/h)."""
    wall = assemblage_of([box(-3, -1, 6, 1), box(0, 0, width, height)])
    found = solve_smoothed(assemble_equilibrium(wall), coulomb(wall), 1.0)
    assert found.converged
    assert found.gap <= LAST_GAP
    assert found.load_multiplier == pytest.approx(expected, abs=1e-5)


@pytest.fixture(scope="module")
def bond():
    """A wall of 290 blocks: its assemblage, terms of Eq. (1), Coulomb's law, associative optimum and moving part."""
    wall = find_joints(running_bond(14, 20), JointSettings())
    whole, friction = assemble_equilibrium(wall), coulomb(wall)
    optimum = solve_limit_lp(whole, friction)
    return wall, whole, friction, optimum, moving_part(wall, whole, friction, optimum.velocities)


def test_a_search_that_goes_back_returns_the_nearest_it_had(bond, monkeypatch):
    """Six steps lead on, then none does, however far it goes back."""
    _, whole, friction, _, _ = bond
    gaps, dragged = [], smoothed_complementarity.dragged

    def six_times(problem, before, targets, *rest):
        if len(gaps) == 6:
            return Reached(before, 50, False)
        reached = dragged(problem, before, targets, *rest)
        if reached.found:
            gaps.append(float(targets.sum() / reached.iterate.multiplier))
        return reached

    monkeypatch.setattr(smoothed_complementarity, "dragged", six_times)
    found = solve_smoothed(whole, friction, 1.0)
    assert not found.converged
    assert len(gaps) == 6
    assert found.gap == pytest.approx(min(gaps), rel=1e-9)


def test_blocks_that_rest_are_supports(bond):
    """Rates of the part are those of the whole wall where both have them, and there are no others."""
    _, whole, friction, _, part = bond
    moving, joints = part.blocks, part.joints
    assert 0 < moving.sum() < len(moving)
    assert part.equilibrium.matrix.shape == (3 * moving.sum(), 3 * joints.sum())
    rng = np.random.default_rng(1)
    velocities = np.where(np.repeat(moving, 3), rng.normal(size=3 * len(moving)), 0.0)
    rates = whole.joint_rates(velocities)
    assert rates[joints] == pytest.approx(part.equilibrium.joint_rates(velocities[np.repeat(moving, 3)]), abs=1e-12)
    assert not rates[~joints].any()
    assert part.friction.slope == pytest.approx(friction.slope[joints])


@pytest.fixture(scope="module")
def state(bond):
    """A state of that wall that the two programs find without any part."""
    _, whole, friction, _, _ = bond
    found = solve_smoothed(whole, friction, 1.0)
    return next(each for each in descent(TwoPrograms(whole, friction), found.slip) if each.balances)


def test_mechanism_of_the_part_closes_the_forces_of_a_state(bond, state):
    """As that of the whole wall does; no block beside the part moves."""
    _, whole, friction, _, part = bond
    of_part = TwoPrograms(whole, friction, part).closed(state.forces)
    assert of_part.balances
    assert whole.live_load @ of_part.mechanism.velocities == pytest.approx(1.0)
    assert of_part.mechanism.rates == pytest.approx(whole.joint_rates(of_part.mechanism.velocities))
    resting = ~np.repeat(part.blocks, 3)
    assert resting.any()
    assert not of_part.mechanism.velocities[resting].any()


def test_where_the_part_is_too_small_the_whole_wall_has_the_mechanism(bond, state):
    """The part about the upper right corner holds blocks of the mechanism: it needs more load than the forces carry."""
    wall, whole, friction, _, part = bond
    corners = np.array([wall.wall.blocks[block].polygon.mean(axis=0) for block in whole.free_blocks])
    only_one = np.repeat(np.arange(len(corners)) == np.argmax(corners @ [1.0, 1.0]), 3).astype(float)
    small = moving_part(wall, whole, friction, only_one)
    assert 0 < small.blocks.sum() < 0.5 * part.blocks.sum()
    strength = friction.slope * np.maximum(state.forces.normal, 0.0)
    no_slope = replace(small.friction, slope=np.full(small.joints.sum(), 1e-12))
    held = LimitProgram(small.equilibrium, no_slope).solve(strength[small.joints])
    assert held.load_multiplier > 1.01 * state.forces.load_multiplier
    assert TwoPrograms(whole, friction, small).closed(state.forces).balances


@pytest.mark.parametrize("scale", [1.0, 300.0])
def test_both_directions_of_slip_are_found_whatever_their_sum_was(scale):
    """Joints that stick, slide and open, with y z = t in each of their four conditions: p and m from p - m alone."""
    wall = assemblage_of([box(-3, -1, 6, 1), *(box(3 * i, 0, 1, 1) for i in range(-1, 1))])
    problem = scaled_problem(assemble_equilibrium(wall), coulomb(wall))
    rng, joints = np.random.default_rng(1), len(problem.friction)
    for _ in range(200):
        targets = np.exp(3.0 * rng.normal(size=(joints, 4)))
        normal = np.exp(3.0 * rng.normal(size=(joints, 2)))
        limit = problem.friction * normal.sum(axis=1) + problem.cohesion
        shear = limit * np.tanh(3.0 * rng.normal(size=joints))
        strength = np.column_stack([normal, limit + shear, limit - shear])
        rates = targets / strength
        wrong = rates + np.outer(rng.normal(size=joints), [0.0, 0.0, 1.0, 1.0])
        iterate = CentralPoint(0.3, np.zeros(problem.B.shape[0]), np.column_stack([normal, shear]), strength, wrong)
        found = both_slips(problem, iterate, targets, scale)
        assert joints > 0
        assert (found > 0).all()
        assert found == pytest.approx(rates, rel=1e-6)


@pytest.mark.parametrize(("blocks", "courses"), [(28, 35), (60, 30)])
def test_state_of_a_large_wall(blocks, courses):
    """Closed by forces on the whole wall and a mechanism of its moving part: valid, and below Eq. (1)."""
    wall = find_joints(running_bond(blocks, courses), JointSettings())
    equilibrium, friction = assemble_equilibrium(wall), coulomb(wall)
    optimum = solve_limit_lp(equilibrium, friction)
    height = wall.joints.centroid[:, 1]
    depth = equilibrium.block_length + height.max() - height
    part = moving_part(wall, equilibrium, friction, optimum.velocities)
    found, slip = smoothed_start(part, depth)
    assert found.gap <= LAST_GAP
    closed = next(descent(TwoPrograms(equilibrium, friction, part), slip, face_weight=CLOSE_FACE_WEIGHT))
    state = closed_state(Problem(wall, equilibrium, friction), closed)
    assert validate(wall, equilibrium, friction, state).complaints == ()
    assert 0.44 < state.load_multiplier < optimum.load_multiplier - 1e-3
