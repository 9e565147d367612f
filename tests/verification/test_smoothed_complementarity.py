"""Smoothed complementarity conditions: closed form, and a valid state of a large wall."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.joints import JointSettings, find_joints
from orchestrator.limit_analysis import analyse
from orchestrator.limit_analysis.equilibrium import assemble_equilibrium
from orchestrator.limit_analysis.linear_program import solve_limit_lp
from orchestrator.limit_analysis.smoothed_complementarity import (
    LAST_GAP,
    moving_part,
    others_held,
    solve_smoothed,
)
from orchestrator.limit_analysis.validation import validate
from orchestrator.limit_analysis.yield_conditions import coulomb
from orchestrator.masonry.patterns import running_bond
from tests.verification.limit_analysis_cases import assemblage_of, box


@pytest.mark.parametrize(("width", "height", "expected"), [(0.5, 1.0, 0.5), (1.0, 0.5, 0.65)])
def test_one_block_overturns_or_slides(width, height, expected):
    """min(mu, b/h)."""
    wall = assemblage_of([box(-3, -1, 6, 1), box(0, 0, width, height)])
    found = solve_smoothed(assemble_equilibrium(wall, 1), coulomb(wall), 1.0)
    assert found.converged
    assert found.gap <= LAST_GAP
    assert found.load_multiplier == pytest.approx(expected, abs=1e-5)


def test_blocks_that_rest_are_supports():
    """A wall of 290 blocks: forces and velocities of the part are those of the whole where both have them."""
    wall = find_joints(running_bond(14, 20), JointSettings())
    whole, friction = assemble_equilibrium(wall, 1), coulomb(wall)
    moving = moving_part(wall, whole, solve_limit_lp(whole, friction).velocities)
    part, strength, joints = others_held(wall, whole, friction, moving)
    assert 0 < moving.sum() < len(moving)
    assert part.matrix.shape == (3 * moving.sum(), 3 * joints.sum())
    rng = np.random.default_rng(1)
    velocities = np.where(np.repeat(moving, 3), rng.normal(size=3 * len(moving)), 0.0)
    rates = whole.joint_rates(velocities)
    assert rates[joints] == pytest.approx(part.joint_rates(velocities[np.repeat(moving, 3)]), abs=1e-12)
    assert not rates[~joints].any()
    assert strength.slope == pytest.approx(friction.slope[joints])


def test_state_of_a_large_wall():
    """997 blocks: valid, below Eq. (1); what the search begins with."""
    wall = find_joints(running_bond(28, 35), JointSettings())
    found = analyse(wall)
    equilibrium, friction = assemble_equilibrium(wall, 1), coulomb(wall)
    assert validate(wall, equilibrium, friction, found.complementarity).complaints == ()
    assert 0.44 < found.complementarity.load_multiplier < found.associative.load_multiplier - 1e-3
