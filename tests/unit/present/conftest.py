"""A hand-made wall and a state of it, which every kind of picture draws."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.limit_analysis.paper.limit_state import LimitState, Mechanism
from tests.support.walls import four_blocks


@pytest.fixture
def assemblage():
    return four_blocks()


@pytest.fixture
def state():
    """Block 13 rocks about its lower right corner while joint 2, pressed together, is said to slip."""
    velocities = np.zeros((4, 3))
    velocities[3] = [0.25, 0.5, -1.0]  # about (1.5, 0.5): the lower left corner rises by 1
    opening = np.array([[0, 0], [0, 0], [0, 0], [0.5, 1.0], [0, 0.5]])
    forces = np.array([[1, 1, 0], [1, 1, 0], [1, 1, 1], [0, 0, 0], [5, 0, 0]], dtype=float)
    mechanism = Mechanism(velocities, opening, np.array([0, 0, 0.3, 0.4, 0.0]), float(np.hypot(1.0, 0.5)))
    return LimitState("sequence", 0.2963, forces, mechanism, (), True, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0)
