"""Equilibrium rows written out by hand for one and two blocks."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.basis.arrays import read_only
from orchestrator.geometry.rigid import polygon_area, polygon_centroid
from orchestrator.limit_analysis.paper.equilibrium import assemble_equilibrium
from orchestrator.masonry.block_properties import (
    block_areas,
    block_centroids,
    block_weights,
)
from orchestrator.masonry.interfaces import straight_interfaces
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.wall import Block, Wall
from tests.support.limit_analysis_cases import weight_along
from tests.support.walls import upright


def stack():
    """Floor, block 1 (2 m x 1 m, 2 kN), block 2 (1 m x 1 m, 1 kN) on its right end. Joint 0: floor-1, joint 1: 1-2."""
    floor = upright(7, -1, -1, 4, 1, 1000.0, fixed=True)
    blocks = (floor, upright(8, 0, 0, 2, 1, 1000.0), upright(9, 1, 1, 1, 1, 1000.0))
    start = np.array([[2.0, 0.0], [2.0, 1.0]])  # along the counter-clockwise outline of i: tops run to the left
    end = np.array([[0.0, 0.0], [1.0, 1.0]])
    joints = straight_interfaces(np.array([0, 1]), np.array([1, 2]), start, end, 1.0, np.full(2, 0.5))
    return Assemblage(Wall("stack", blocks, 1.0, 0.5), joints)


def test_polygon_properties_of_an_l_shape():
    corners = np.array([[0, 0], [3, 0], [3, 1], [1, 1], [1, 2], [0, 2]], dtype=float)
    assert polygon_area(corners) == pytest.approx(4.0)
    assert polygon_area(corners[::-1]) == pytest.approx(-4.0)
    assert polygon_centroid(corners) == pytest.approx([(3 * 1.5 + 1 * 0.5) / 4, (3 * 0.5 + 1 * 1.5) / 4])


def test_areas_and_centroids_of_blocks_with_different_numbers_of_corners():
    """L, unit triangle about (1/3, 1/3) and rectangle, far away."""
    l_shape = [[0, 0], [3, 0], [3, 1], [1, 1], [1, 2], [0, 2]]
    triangle, box = [[0, 0], [1, 0], [0, 1]], [[0, 0], [0.4, 0], [0.4, 0.2], [0, 0.2]]
    far = [3e3, 5e3]
    blocks = [Block(n, read_only(np.add(p, far)), False, 1.0) for n, p in enumerate((l_shape, triangle, box))]
    wall = Wall("three", tuple(blocks), 1.0, 0.5)
    assert block_areas(wall) == pytest.approx([4.0, 0.5, 0.08])
    expected = [(5.0 / 4, 3.0 / 4), (1 / 3, 1 / 3), (0.2, 0.1)]
    assert block_centroids(wall) - far == pytest.approx(np.array(expected), abs=1e-11)


def test_centroid_far_from_the_origin_keeps_its_digits():
    corners = np.array([[0, 0], [0.4, 0], [0.4, 0.175], [0, 0.175]])
    shifted = polygon_centroid(corners + [3e5, 5e6])  # map coordinates
    assert shifted - [3e5, 5e6] == pytest.approx([0.2, 0.0875], abs=2e-9)  # corners themselves are rounded to 1e-9 m


def test_loads_are_weights_at_centroids():
    assemblage = stack()
    assert block_weights(assemblage.wall) == pytest.approx([4000, 2000, 1000])
    assert block_centroids(assemblage.wall).tolist() == [[1, -0.5], [1, 0.5], [1.5, 1.5]]
    for direction in (1, -1):
        equilibrium = assemble_equilibrium(assemblage, weight_along(assemblage, direction))
        assert equilibrium.free_blocks.tolist() == [1, 2]
        assert equilibrium.dead_load.tolist() == [0, -2000, 0, 0, -1000, 0]
        assert equilibrium.live_load.tolist() == [direction * 2000, 0, 0, direction * 1000, 0, 0]
        assert equilibrium.total_weight == 3000
        assert equilibrium.unit_force == 1500


def test_matrix_of_the_stack_by_hand():
    """Rows x, y, moment of blocks 1 and 2; columns n_start, n_end, s of both joints. The normal points up, the tangent
    to the left; block i pushes j with +n, +s, and B q are the forces blocks exert: minus for j, plus for i."""
    B = assemble_equilibrium(stack()).matrix.toarray()
    lower = [[0, 0, 1], [-1, -1, 0], [-1, 1, 0.5]]  # joint 0 on block 1 (its j): arms x = +1, -1; y = -0.5
    upper_on_1 = [[0, 0, -1], [1, 1, 0], [1, 0, 0.5]]  # joint 1 on block 1 (its i): arms x = +1, 0; y = +0.5
    upper_on_2 = [[0, 0, 1], [-1, -1, 0], [-0.5, 0.5, 0.5]]  # joint 1 on block 2 (its j): arms x = +-0.5; y = -0.5
    assert B[:3, :3].tolist() == lower
    assert B[:3, 3:].tolist() == upper_on_1
    assert B[3:, 3:].tolist() == upper_on_2
    assert not B[3:, :3].any()


def test_residual_vanishes_for_the_state_at_rest_only():
    """The upper block's 1 kN on its joint's middle; the lower joint carries 3 kN with its resultant at x = 3.5/3 m."""
    equilibrium = assemble_equilibrium(stack())
    at_start = 3000 * (3.5 / 3) / 2
    at_rest = np.array([[at_start, 3000 - at_start, 0.0], [500.0, 500.0, 0.0]])
    assert equilibrium.residual(at_rest, 0.0) < 1e-14
    assert equilibrium.residual(at_rest + [[30.0, 0, 0], [0, 0, 0]], 0.0) == pytest.approx(0.01, rel=0.3)
    assert equilibrium.residual(at_rest, 0.1) > 0.01


def test_joint_rates_of_a_known_motion():
    """Block 2 lifts 0.1 m/s, drifts 0.3 m/s to the right and turns 0.2 rad/s; block 1 rests."""
    equilibrium = assemble_equilibrium(stack())
    rates = equilibrium.joint_rates(np.array([0, 0, 0, 0.3, 0.1, 0.2]))
    opening_right, opening_left = 0.1 + 0.2 * 0.5, 0.1 - 0.2 * 0.5
    slip_to_the_left = -(0.3 - 0.2 * (-0.5))
    assert rates == pytest.approx(np.array([[0, 0, 0], [opening_right, opening_left, slip_to_the_left]]))


def test_velocities_of_supports_are_zero():
    equilibrium = assemble_equilibrium(stack())
    everyone = equilibrium.of_all_blocks(np.arange(1.0, 7.0))
    assert everyone.tolist() == [[0, 0, 0], [1, 2, 3], [4, 5, 6]]
