"""Why keystone_wall_13x9 has no non-associative multiplier: a block that hangs by friction falls alone at any of them.

Blocks 75 and 79 close an opening each and touch nothing below. A block of weight W that slides down between neighbours
which press it with N_l and N_r and leave it free above needs mu (N_l + N_r) = W; its motion is vertical, so that the
live load does no work and neither dilation nor lambda enter: whatever forces are in the other joints, this is a limit
state. Horizontal balance of the block, N_l - N_r = -lambda W (load to the right, block left of its right neighbour),
leaves lambda free between -1/mu and 1/mu. That the rest of the wall bears such forces is asked of another solver, with
other unknowns (resultants, moments about the origin).
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog

from orchestrator.limit_analysis import LimitAnalysisSettings, analyse
from tests.support.limit_analysis_cases import answers, case, with_resultants

NAME = "keystone_wall_13x9"


def falling(number, multiplier):
    """Forces at a multiplier in which block `number` falls alone; None where there are none."""
    wall = case(NAME)
    balance, right_side, yields = with_resultants(NAME)
    position = [block.id for block in wall.wall.blocks].index(number)
    below, above = (wall.joints.j == position), (wall.joints.i == position)
    rows, values = [], []
    heads = 0
    for k in np.flatnonzero(below | above):
        row = np.zeros(yields.shape[1])
        if abs(wall.joints.normal[k, 0]) > 0.99:
            heads += 1
            upward = wall.joints.tangent[k, 1] * (1.0 if below[k] else -1.0)  # what shear does to the block
            row[3 * k], row[3 * k + 1] = wall.joints.friction[k], -upward
        else:
            row[3 * k] = 1.0
        rows.append(row)
        values.append(0.0)
    assert heads == 2
    fixed = np.zeros(yields.shape[1])
    fixed[-1] = 1.0
    equal, given = np.vstack([balance, *rows, fixed]), np.concatenate([right_side, values, [multiplier]])
    found = linprog(0.0 * fixed, yields, np.zeros(len(yields)), equal, given, bounds=(None, None), method="highs")
    return found.x if found.status == 0 else None


@pytest.mark.parametrize(
    ("number", "multiplier"), [(79, 0.0), (79, -0.3), (79, 0.2), (79, 0.43), (75, 0.0), (75, -0.3)]
)
def test_block_falls_alone_at_any_multiplier(number, multiplier):
    forces = falling(number, multiplier)
    wall = case(NAME)
    position = [block.id for block in wall.wall.blocks].index(number)
    beside = np.flatnonzero(
        ((wall.joints.i == position) | (wall.joints.j == position)) & (abs(wall.joints.normal[:, 0]) > 0.99)
    )
    weight = 0.4 * 0.175 * 0.1 * 25.0  # kN
    assert 0.65 * forces[3 * beside].sum() == pytest.approx(weight, rel=1e-6)
    assert abs(np.diff(forces[3 * beside])[0]) == pytest.approx(abs(multiplier) * weight, rel=1e-6, abs=1e-9)


def test_not_beyond_the_associative_optimum():
    """The bounds of the static theorem hold for these states too."""
    assert falling(79, answers(NAME).associative.load_multiplier + 1e-3) is None


def test_no_non_associative_state_is_claimed():
    """Where no part is local: else these blocks come loose first, and the wall goes on without them."""
    found = analyse(case(NAME), LimitAnalysisSettings(local_share=0.0))
    assert found.non_associative_range is None
    assert found.headline is found.associative
