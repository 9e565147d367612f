"""Centres of rotation with their special cases, largest corner velocity, and checks of power and dilation by hand."""

from __future__ import annotations

from dataclasses import replace
from math import inf, isnan

import numpy as np
import pytest

from orchestrator.basis.arrays import read_only
from orchestrator.limit_analysis.paper.equilibrium import assemble_equilibrium
from orchestrator.limit_analysis.paper.mechanism import (
    centres_of_rotation,
    dilation,
    largest_corner_velocity,
    mechanism_from,
    power_residual,
)
from orchestrator.limit_analysis.paper.yield_conditions import coulomb
from orchestrator.masonry.interfaces import straight_interfaces
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.wall import Block, Wall
from tests.support.limit_analysis_cases import weight_along

CENTROIDS = np.array([[0.0, 0.0], [1.0, 2.0], [3.0, 1.0]])


def block_on_floor(cohesion=0.0):
    """2 m x 1 m, 2 kN, on a floor with mu = 0.5; the joint's tangent points left, its normal up."""
    floor = Block(0, read_only([[-1, -1], [9, -1], [9, 0], [-1, 0]]), True, 1000.0)
    block = Block(1, read_only([[0, 0], [2, 0], [2, 1], [0, 1]]), False, 1000.0)
    ends = np.array([[2.0, 0.0]]), np.array([[0.0, 0.0]])
    joints = straight_interfaces(np.array([0]), np.array([1]), *ends, 1.0, np.array([0.5]))
    return Assemblage(Wall("block", (floor, block), 1.0, 0.5), replace(joints, cohesion=read_only([cohesion])))


def test_centre_of_a_turning_block_stands_still():
    velocities = np.array([[0.3, -0.1, 0.5], [0.0, 0.2, -2.0], [0.1, 0.1, 0.1]])
    centres = centres_of_rotation(velocities, CENTROIDS)
    for (u, v, omega), centroid, centre in zip(velocities, CENTROIDS, centres, strict=True):
        arm = centre - centroid
        assert u - omega * arm[1] == pytest.approx(0.0, abs=1e-15)
        assert v + omega * arm[0] == pytest.approx(0.0, abs=1e-15)


def test_block_turning_about_its_own_centroid():
    velocities = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    assert centres_of_rotation(velocities, CENTROIDS)[0].tolist() == [0.0, 0.0]


def test_resting_blocks_have_no_centre():
    velocities = np.array([[1.0, 0.0, 0.3], [0.0, 0.0, 0.0], [1e-8, 0.0, 1e-9]])
    centres = centres_of_rotation(velocities, CENTROIDS)
    assert np.isfinite(centres[0]).all()
    assert np.isnan(centres[1:]).all()
    assert np.isfinite(centres_of_rotation(velocities, CENTROIDS, resting=1e-12)[2]).all()


def test_a_wall_at_rest_has_no_centres():
    assert np.isnan(centres_of_rotation(np.zeros((3, 3)), CENTROIDS)).all()


def test_translating_blocks_have_their_centre_at_infinity_normal_to_their_motion():
    velocities = np.array([[2.0, 0.0, 0.0], [0.0, -2.0, 1e-16], [1.0, 1.0, 0.0]])
    along_x, down, diagonal = centres_of_rotation(velocities, CENTROIDS).tolist()
    assert along_x == [0.0, inf]
    assert down == [inf, 2.0]
    assert diagonal == [-inf, inf]


def test_alike_translations_share_their_centre_at_infinity():
    velocities = np.array([[1.0, 0.5, 0.0], [1.0, 0.5, 1e-18], [1.0, 0.5, -1e-18]])
    first, *others = centres_of_rotation(velocities, CENTROIDS).tolist()
    assert first == [-inf, inf]
    assert all(other == first for other in others)


def test_single_sliding_block():
    (centre,) = centres_of_rotation(np.array([[1.0, 0.0, 0.0]]), np.array([[4.0, 5.0]]))
    assert centre.tolist() == [4.0, inf]
    assert not isnan(centre[0])


def test_largest_corner_velocity():
    """The block turns about its lower left corner: the far corner moves sqrt(5) omega."""
    omega = 0.2
    velocities = np.array([[0.0, 0.0, 0.0], [-omega * 0.5, omega * 1.0, omega]])
    assert largest_corner_velocity(block_on_floor().wall, velocities) == pytest.approx(np.sqrt(5.0) * omega)


def test_largest_corner_velocity_of_a_shape_without_symmetry():
    """A triangle with its centroid at the origin drifts right at 1 and turns at 1: corners move at (1 - y, x)."""
    corners = np.array([[-1.0, -1.0], [2.0, -1.0], [-1.0, 2.0]])
    wall = Wall("triangle", (Block(0, read_only(corners), False, 1000.0),), 1.0, 0.5)
    assert largest_corner_velocity(wall, np.array([[1.0, 0.0, 1.0]])) == pytest.approx(np.hypot(2.0, 2.0))


def test_mechanism_is_scaled_to_unit_live_power():
    assemblage = block_on_floor()
    mechanism = mechanism_from(assemblage.wall, assemble_equilibrium(assemblage), np.array([3.0, 0.0, 0.0]))
    assert mechanism.velocities.tolist() == [[0, 0, 0], [1 / 2000, 0, 0]]
    assert mechanism.slip == pytest.approx([-1 / 2000])
    assert mechanism.largest_displacement == pytest.approx(1 / 2000)
    pushed_left = assemble_equilibrium(assemblage, weight_along(assemblage, -1))
    leftwards = mechanism_from(assemblage.wall, pushed_left, np.array([-3.0, 0.0, 0.0]))
    assert leftwards.velocities[1, 0] == pytest.approx(-1 / 2000)


@pytest.mark.parametrize(
    ("psi", "lift", "cohesion", "multiplier"),
    [(0.5, 0.5, 0.0, 0.5), (0.0, 0.0, 0.0, 0.5), (0.0, 0.0, 300.0, 0.8), (-0.005, -0.005, 0.0, 0.5)],
)
def test_power_of_a_sliding_block_balances_for_each_flow_rule(psi, lift, cohesion, multiplier):
    """It slides right at 1, lifts at psi: live 2000 lambda, dead -2000 psi, friction (2 m2 c + (mu - psi) 2000) 1."""
    assemblage = block_on_floor(cohesion)
    equilibrium, law = assemble_equilibrium(assemblage), coulomb(assemblage)
    assert law.cohesion == pytest.approx([2.0 * cohesion])
    forces = np.array([[1000.0, 1000.0, 2000.0 * multiplier]])
    mechanism = mechanism_from(assemblage.wall, equilibrium, np.array([1.0, lift, 0.0]))
    balance = power_residual(equilibrium, law, np.array([psi]), multiplier, forces, mechanism)
    assert balance == pytest.approx(0.0, abs=1e-12)
    wrong = power_residual(equilibrium, law, np.array([psi]), 1.1 * multiplier, forces, mechanism)
    assert wrong > 0.05


def test_dilation_counts_only_where_a_joint_carries_load():
    assemblage = block_on_floor()
    equilibrium, law = assemble_equilibrium(assemblage), coulomb(assemblage)
    tilting = mechanism_from(assemblage.wall, equilibrium, np.array([0.5, 1.0, -1.0]))  # about the right toe
    at_toe, at_heel = np.array([[2000.0, 0.0, 0.0]]), np.array([[0.0, 2000.0, 0.0]])
    assert dilation(equilibrium, law, at_toe, tilting) == pytest.approx(0.0, abs=1e-12)
    assert dilation(equilibrium, law, at_heel, tilting) == pytest.approx(2.0 / np.sqrt(5.0))
    sliding = mechanism_from(assemblage.wall, equilibrium, np.array([1.0, 0.5, 0.0]))
    assert dilation(equilibrium, law, at_toe, sliding) == pytest.approx(0.5 / np.hypot(1.0, 0.5))
