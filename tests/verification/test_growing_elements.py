"""Elements that grow inside of a body leave its stiffness and its strength as they are."""

from __future__ import annotations

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


def test_a_wall_of_one_body_bends_and_turns_over_as_with_fine_elements_everywhere():
    """Against elements of half the default's size that do not grow; the body slides at its friction, 0.65."""
    assemblage = find_joints(running_bond(6, 8), JointSettings())
    analysis, stepping = analyse(assemblage), SteppingSettings(final_displacement=1e-3)
    grown, fine = (
        push(assemblage, analysis, one_body(assemblage), mesh=mesh, stepping=stepping)
        for mesh in (MeshSettings(), MeshSettings(0.065, growth=0.0))
    )
    assert grown.summary.nodes < 0.25 * fine.summary.nodes
    assert grown.capacity.initial_stiffness == pytest.approx(fine.capacity.initial_stiffness, rel=0.01)
    assert grown.capacity.peak_multiplier == pytest.approx(fine.capacity.peak_multiplier, rel=1e-3)
