"""What only large walls use, on walls small enough for HiGHS (SciPy), an independent solver of Eq. (1)."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.optimize import linprog

from orchestrator.joints import JointSettings, find_joints
from orchestrator.limit_analysis import LimitAnalysisSettings, analyse, analysis, linear_program
from orchestrator.limit_analysis.equilibrium import assemble_equilibrium
from orchestrator.limit_analysis.linear_program import solve_limit_lp
from orchestrator.limit_analysis.yield_conditions import coulomb, yield_matrix, yield_offset
from orchestrator.masonry.patterns import running_bond
from tests.support.limit_analysis_cases import case

NEAREST = "complementarity program: the nearest forces and mechanism are out of balance by "


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
    assert found.dilation_shift is None
    assert found.complementarity is None
    assert found.headline is found.associative
    assert found.remarks == (
        "sequence and dilation shift left out for so many blocks, more than 1",
        "no non-associative solution found: complementarity program: no forces and mechanism that balance",
    )


@pytest.mark.parametrize(
    "settings",
    [LimitAnalysisSettings(search_blocks=1, sequence_blocks=1), LimitAnalysisSettings(maximum_shift_iterations=3)],
    ids=["very large", "shift that has not settled"],
)
def test_nearest_forces_and_mechanism_are_shown_where_there_is_no_state(settings, monkeypatch):
    """Not converged, hence never the headline, and the remark says by how much power is out of balance."""
    monkeypatch.setattr(analysis, "NEARLY", 1.0)
    found = analyse(case("keystone_wall_13x9"), settings)
    nearest = found.complementarity
    assert not nearest.converged
    assert found.headline is found.associative
    assert found.non_associative_range is None
    assert nearest.equilibrium_residual < 1e-8
    said = float(found.remarks[-1].removeprefix(NEAREST).split()[0])
    assert said > 1e-2
    assert said == pytest.approx(nearest.power_residual, rel=0.1)
