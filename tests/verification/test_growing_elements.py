"""Elements that grow inside of a body leave its strength as it is, and little less of its bending."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator import (
    JointSettings,
    MeshSettings,
    SteppingSettings,
    analyse,
    find_joints,
    one_body,
    push,
)
from orchestrator.masonry.patterns import running_bond


def test_a_wall_of_one_body_bends_and_turns_over_as_with_elements_of_one_size():
    """The closed form b / h of a rigid block is more, as the toe gives way; a slender body bends 2 to 3 % less."""
    assemblage = find_joints(running_bond(3, 14), JointSettings())
    analysis, stepping = analyse(assemblage), SteppingSettings(final_displacement=0.01)
    grown, even, fine = (
        push(assemblage, analysis, one_body(assemblage), mesh=mesh, stepping=stepping)
        for mesh in (MeshSettings(), MeshSettings(growth=0.0), MeshSettings(0.065, growth=0.0))
    )
    width, height = np.ptp(np.vstack([one.polygon for one in assemblage.wall.blocks if not one.fixed]), axis=0)
    assert grown.summary.nodes < 0.7 * even.summary.nodes
    assert grown.capacity.initial_stiffness == pytest.approx(even.capacity.initial_stiffness, rel=0.025)
    assert grown.capacity.initial_stiffness == pytest.approx(fine.capacity.initial_stiffness, rel=0.04)
    assert grown.capacity.peak_multiplier == pytest.approx(even.capacity.peak_multiplier, rel=1e-4)
    assert grown.capacity.peak_multiplier == pytest.approx(fine.capacity.peak_multiplier, rel=3e-3)
    assert 0.95 * width / height < grown.capacity.peak_multiplier < width / height
