"""What only large walls use, on walls small enough for HiGHS (SciPy), an independent solver of Eq. (1)."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.optimize import linprog

from orchestrator.limit_analysis import LimitAnalysisSettings, analyse
from orchestrator.limit_analysis.paper import linear_program
from orchestrator.limit_analysis.paper.equilibrium import assemble_equilibrium
from orchestrator.limit_analysis.paper.linear_program import solve_limit_lp
from orchestrator.limit_analysis.paper.yield_conditions import coulomb, yield_matrix, yield_offset
from orchestrator.limit_analysis.search import direct_loading
from orchestrator.limit_analysis.validation import validate
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.patterns import running_bond
from tests.support.limit_analysis_cases import assemblage_of, box, case


@pytest.fixture(scope="module")
def terms():
    """Running bond, 14 courses of 10 blocks."""
    assemblage = find_joints(running_bond(10, 14), JointSettings())
    return assemble_equilibrium(assemblage, 1), coulomb(assemblage)


@pytest.fixture(scope="module")
def by_highs(terms):
    """max lambda of Eq. (1), forces over the mean block weight."""
    equilibrium, friction = terms
    w = equilibrium.mean_weight
    found = linprog(
        np.append(np.zeros(equilibrium.matrix.shape[1]), -1.0),
        A_ub=sp.hstack([-yield_matrix(friction), sp.csc_matrix((4 * len(friction.slope), 1))]),
        b_ub=yield_offset(friction) / w,
        A_eq=sp.hstack([equilibrium.matrix, -equilibrium.live_load[:, None] / w]),
        b_eq=equilibrium.dead_load / w,
        bounds=(None, None),
        method="highs",
    )
    assert found.status == 0
    return found.x[-1]


@pytest.mark.parametrize("name", ["LARGE", "VERY_LARGE"])
def test_multiplier_of_a_large_wall_is_that_of_highs(terms, by_highs, name, monkeypatch):
    """Treated as large or very large: lambda to 1e-6, forces in equilibrium and within 1e-8 block weights."""
    monkeypatch.setattr(linear_program, name, 100)
    equilibrium, friction = terms
    found = solve_limit_lp(equilibrium, friction)
    assert found.load_multiplier == pytest.approx(by_highs, rel=1e-6)
    assert equilibrium.residual(found.joint_forces, found.load_multiplier) < 1e-8
    assert friction.excess(found.joint_forces) < 1e-8 * equilibrium.mean_weight


def test_a_very_large_wall_without_a_state_says_so_and_runs_no_sequence():
    """keystone_wall has none: its keystone hangs by friction alone."""
    found = analyse(case("keystone_wall_13x9"), LimitAnalysisSettings(search_blocks=1, sequence_blocks=1))
    assert found.sequence is None
    assert found.path is None
    assert found.headline is found.associative
    assert found.remarks == (
        "loading: no state of rest under the dead load was found",
        "the paper's sequence left out for so many blocks, more than 1",
    )


def test_a_wall_that_is_not_followed_to_its_end_has_a_valid_state_and_says_how_far_it_was_loaded():
    """Running bond, 290 blocks: below Eq. (1), above the rest it was loaded to; power, flow and friction balance."""
    wall = find_joints(running_bond(14, 20), JointSettings())
    found = analyse(wall, LimitAnalysisSettings(search_blocks=1, sequence_blocks=1, path_blocks=1))
    state = found.headline
    assert (state.flow_rule, state.converged) == ("smoothed", True)
    assert state is found.path
    terms = assemble_equilibrium(wall, 1)
    assert validate(wall, terms, coulomb(wall, terms.dead_total), state).complaints == ()
    assert 0.8 * state.load_multiplier < found.last_rest < state.load_multiplier < found.associative.load_multiplier
    (said,) = [remark for remark in found.remarks if "path" in remark]
    assert said.startswith("the path was not followed to its end: state closed by smoothed conditions; at rest up to ")
    assert f"{found.last_rest:.4f}" in said


@pytest.mark.parametrize(("width", "height", "expected"), [(0.5, 1.0, 0.5), (1.0, 0.5, 0.65)])
def test_one_block_rests_up_to_its_state_on_this_road_too(width, height, expected):
    """min(mu, b/h); loading is asked for a rest 1 % below, and finds it."""
    block = assemblage_of([box(-3, -1, 6, 1), box(0, 0, width, height)])
    found = analyse(block, LimitAnalysisSettings(path_blocks=0))
    assert found.headline.flow_rule == "smoothed"
    assert found.headline.load_multiplier == pytest.approx(expected, rel=1e-6)
    assert found.last_rest == pytest.approx(0.99 * expected, rel=1e-6)


def test_a_wall_too_large_to_be_loaded_at_all_says_so(monkeypatch):
    monkeypatch.setattr(direct_loading, "BUDGET", 0)
    found = analyse(assemblage_of([box(-3, -1, 6, 1), box(0, 0, 0.5, 1.0)]), LimitAnalysisSettings(path_blocks=0))
    assert found.last_rest is None
    assert any("the wall was not loaded, for the number of blocks" in remark for remark in found.remarks)
