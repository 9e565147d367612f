"""Contact forces that balance a load, or do not, whatever they grow to."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy import sparse
from scipy.optimize import nnls

from orchestrator.pushover.path.moved_wall import balances

DATA = Path(__file__).parent / "unbalanced_contacts.json"


@pytest.mark.parametrize(("push", "held"), [(0.4, True), (0.6, False)], ids=["within friction", "beyond"])
def test_a_block_pressed_on_a_floor_bears_what_friction_bears(push: float, held: bool) -> None:
    edges = sparse.csr_matrix([[0.5, -0.5], [1.0, 1.0]])  # of Coulomb's cone, friction 0.5
    assert balances(edges, np.array([push, -1.0])) is held


def test_forces_of_a_horseshoe_arch_that_balance_nothing() -> None:
    """HiGHS ran for ever when it was asked for such forces; least squares say that there are none."""
    found = json.loads(DATA.read_text())
    forces = sparse.csr_matrix((found["value"], (found["row"], found["column"])), found["shape"])
    load = np.array(found["load"])
    assert nnls(forces.toarray(), -load)[1] > 0.1 * np.linalg.norm(load)
    assert not balances(forces, load)
