"""Kinematics of mechanisms by hand: participation, displacement of balance, what friction takes."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.assessment.seismic.kinematic import Moving, kinematics, participation

FORWARD = np.array([1.0, 0.0])


def test_the_part_that_friction_takes_is_stated():
    """10 kN that slides at 0.65 (friction takes all) or turns about its toe at 0.5 (weight is lifted, none)."""
    slides = Moving(np.array([10e3]), np.array([[1.0, 0.0, 0.0]]), np.zeros(1, np.int64))
    turns = Moving(np.array([10e3]), np.array([[0.5, 0.25, -1.0]]), np.zeros(1, np.int64))
    assert kinematics(0.65, slides, slides, FORWARD).friction_share == pytest.approx(1.0)
    assert kinematics(0.5, turns, turns, FORWARD).friction_share == pytest.approx(0.0, abs=1e-12)


def test_participation_by_hand():
    """Weights 1, 1 with displacements 1, 3: (1 + 3)^2 / (2 (1 + 9)) = 0.8."""
    assert participation(np.ones(2), np.array([1.0, 3.0])) == pytest.approx(0.8)


def test_what_only_slides_has_a_participation_of_one_at_any_speeds():
    """Slabs on each other that slide at 0.3, by shares that nothing decides: all may slide on the lowest bed."""
    weight, body = np.full(3, 10e3), np.arange(3)
    slabs = Moving(weight, np.array([[1.0, 0, 0], [1.7, 0, 0], [3.0, 0, 0]]), body)
    assert participation(weight, slabs.velocities[:, 0]) < 0.85
    assert kinematics(0.3, slabs, slabs, FORWARD).participation == 1.0


def test_slow_bodies_are_not_in_the_mechanism_and_fast_ones_are_whatever_the_scale():
    weight, body = np.array([10e3, 10e3, 99e3]), np.arange(3)
    velocity = np.array([[1.0, 0.2, 0], [3.0, 0.6, 0], [0.02, 0, 0]])  # up a slope
    for scale in (1.0, -7.0):
        masses = Moving(weight, velocity * [scale, abs(scale), 1.0], body)
        found = kinematics(0.65, masses, masses, np.sign(scale) * FORWARD)
        assert found.participation == pytest.approx(0.8)
        assert found.bodies == 2
        assert found.displacement is None, "what slides has no d_0*"


def test_mirrored_and_faster_mechanisms_have_the_same_displacement():
    """A block of 0.5 m x 1 m turning about its lower corner is in balance 0.25 m further."""
    velocity = np.array([[0.5, 0.25, -1.0]])
    for factor, direction in ((np.array([1, 1, 1]), 1), (7.0 * np.array([-1, 1, -1]), -1)):
        masses = Moving(np.array([10e3]), factor * velocity, np.zeros(1, np.int64))
        assert kinematics(0.5, masses, masses, direction * FORWARD).displacement == pytest.approx(0.25)


@pytest.mark.parametrize("stones", [1, 2, 4, 8])
def test_a_tower_that_turns_as_one_has_the_displacement_of_one_body_however_many_stones_it_has(stones):
    """0.4 m x 2 m about its lower corner: in balance when its centroid is above that, 0.2 m further (it was 0.264)."""
    height = 2.0 / stones * (np.arange(stones) + 0.5)
    velocities = np.column_stack([height, np.full(stones, 0.2), np.full(stones, -1.0)])
    masses = Moving(np.full(stones, 24e3 / stones), velocities, np.zeros(stones, np.int64))
    found = kinematics(0.2, masses, masses, FORWARD)
    assert found.displacement == pytest.approx(0.2)
    assert found.participation == pytest.approx(1.0)


def test_rounding_in_the_turn_of_what_slides_is_no_displacement():
    """A block that slides at 0.6 with a turn of 1e-13 came to rest 6e12 m further on, with a ratio of 667."""
    masses = Moving(np.array([10e3]), np.array([[1.0, 0.0, -1e-13]]), np.zeros(1, np.int64))
    assert kinematics(0.6, masses, masses, FORWARD, reach=3.0).displacement is None
    turning = Moving(np.array([10e3]), np.array([[0.5, 0.25, -1.0]]), np.zeros(1, np.int64))
    assert kinematics(0.5, turning, turning, FORWARD, reach=3.0).displacement == pytest.approx(0.25)
