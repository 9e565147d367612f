"""Contacts of displaced bodies."""

import numpy as np
import pytest

from orchestrator.masonry.patterns import running_bond
from orchestrator.pushover.model import displaced
from tests.verification.pushover_chain import model_of


@pytest.mark.parametrize("tilt", [0.0, 2e-3])
def test_motion_out_of_the_plane_moves_no_contact(tilt):
    """The whole wall 3 mm forward, upright or leaning: equilibrium out of the plane is that of the undeformed wall."""
    model = model_of(running_bond(2, 3), large_displacement=True)
    nodes = model.meshes.nodes
    forward = np.zeros_like(nodes)
    forward[:, 2] = 3e-3 + tilt * nodes[:, 1]
    moved = displaced(model, forward.ravel())
    assert len(moved.contacts) > 20
    assert moved.rows.tolist() == model.rows.tolist()
    assert abs(moved.normal_rows - model.normal_rows).max() < 1e-12
    assert abs(moved.tangential_rows - model.tangential_rows).max() < 1e-12
    assert np.abs(moved.normal_rows @ forward.ravel() + moved.gap_offset).max() < 1e-12
