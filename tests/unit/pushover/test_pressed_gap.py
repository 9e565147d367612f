"""Gaps between displaced outlines of bodies that press each other: stones lifted by a known height."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.macroblocks.bodies import make_bodies
from orchestrator.macroblocks.criteria import one_body_per_block
from orchestrator.pushover.meshing import MeshSettings, mesh_bodies
from orchestrator.pushover.path.body_overlap import PRESSES, DisplacedOutlines
from tests.support.pushover_chain import assemblage_of, stack

STANDING = np.zeros(2, bool)
WEIGHT = np.array([300.0, 250.0])
PAIRS = np.array([0, 1, 1]), np.array([2, 0, 0])
"""the lower stone on the support by one contact, the upper one on the lower one by two"""


@pytest.fixture(scope="module")
def wall():
    """A stone of 0.4 m x 0.3 m and one of 0.2 m x 0.5 m on it."""
    assemblage = assemblage_of(stack((0.4, 0.3), (0.2, 0.5), friction=0.6))
    bodies = make_bodies(assemblage, one_body_per_block(assemblage))
    return DisplacedOutlines(bodies, mesh_bodies(bodies, MeshSettings(size=0.2), None))


def gap_of(wall, force, *lifted, fallen=STANDING):
    meshes = wall.meshes
    displacement = np.zeros_like(meshes.nodes)
    for body, height in lifted:
        displacement[meshes.body_of_node == body, 1] = height
    found = wall.largest_pressed_gap(displacement, fallen, PAIRS, np.array(force), WEIGHT)
    return found.distance, found.share


def test_stones_that_touch_have_no_gap(wall):
    assert gap_of(wall, [550.0, 125.0, 125.0])[1] < 1e-12


@pytest.mark.parametrize("height", [1e-4, 1e-2])
def test_a_force_across_a_gap_is_found(wall, height):
    """The smaller stone has an area of 0.1 m2."""
    gap, share = gap_of(wall, [550.0, 125.0, 125.0], (1, height))
    assert gap == pytest.approx(height, rel=1e-9)
    assert share == pytest.approx(height / np.sqrt(0.1), rel=1e-9)


def test_a_force_across_a_gap_over_the_support_is_found(wall):
    """The stone that is lifted, of 0.12 m2, takes with it the one on it."""
    gap, share = gap_of(wall, [550.0, 125.0, 125.0], (0, 0.01), (1, 0.01))
    assert gap == pytest.approx(0.01, rel=1e-9)
    assert share == pytest.approx(0.01 / np.sqrt(0.12), rel=1e-9)


@pytest.mark.parametrize("force", [[550.0, 0.0, 0.0], [550.0, -125.0, -125.0], [550.0, 0.4 * PRESSES * 250.0, 0.0]])
def test_what_does_not_press_may_stand_apart(wall, force):
    """Nothing between them, a bond in tension, and a force that does not matter to the lighter one."""
    assert gap_of(wall, force, (1, 0.01))[0] == 0.0


def test_what_has_fallen_may_be_anywhere(wall):
    assert gap_of(wall, [300.0, 125.0, 125.0], (1, 0.5), fallen=np.array([False, True]))[0] == 0.0
