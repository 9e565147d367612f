"""A hand-made wall, its limit analysis and macroblocks, which files and summary are written from."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.basis.arrays import read_only
from orchestrator.limit_analysis.paper.limit_state import (
    LimitAnalysis,
    LimitState,
    LinearProgramRecord,
    LocalFailure,
    Mechanism,
)
from orchestrator.loads import Loads
from orchestrator.macroblocks.criteria import MacroblockSettings, Partition
from tests.support.walls import four_blocks


@pytest.fixture
def assemblage():
    return four_blocks('Wall "ä" <&>')


def limit_state(rule, multiplier, programs):
    mechanism = Mechanism(np.arange(12.0).reshape(4, 3), np.ones((5, 2)), np.full(5, 2.0), 3.0)
    records = tuple(LinearProgramRecord(multiplier, 0.1, 12, 0.01, "Solved") for _ in range(programs))
    return LimitState(
        flow_rule=rule,
        load_multiplier=multiplier,
        joint_forces=np.arange(15.0).reshape(5, 3),
        mechanism=mechanism,
        records=records,
        converged=True,
        equilibrium_residual=1e-12,
        yield_residual=2e-12,
        power_residual=3e-12,
        dilation=0.0,
        horizontal_load=3125.0,
        live_total=3125.0,
    )


@pytest.fixture
def analysis():
    return LimitAnalysis(
        loads=Loads(read_only(np.ones((2, 3))), read_only(np.eye(2, 3)), read_only([1.0, 0.0])),
        weight=3125.0,
        vertical_load=3125.0,
        horizontal_load=3125.0,
        tilting_table=True,
        associative=limit_state("associative", 0.35, 1),
        sequence=limit_state("sequence", 0.29, 7),
        path=limit_state("path", 0.29, 7),
        highest=0.31,
        local_failures=(LocalFailure((13,), 0.02, (0.1, 0.2), limit_state("path", 0.2, 7)),),
        remarks=("hand made",),
        seconds=0.5,
    )


@pytest.fixture
def partition():
    """Blocks 11 and 12 are one body, 13 another, the support a third."""
    return Partition(np.array([2, 0, 0, 1]), 2, np.array([2]), np.array([], dtype=int), MacroblockSettings())
