"""What the tests of walls in space would see: each mutation below moves a closed form out of its tolerance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from orchestrator.space import equilibrium as equations
from orchestrator.space.conic_program import solve_associative
from orchestrator.space.contacts import Interfaces, find_joints
from orchestrator.space.generators.shapes import Plan, Stones, u_wall
from orchestrator.space.loads import SpaceLoads, SpaceLoadSettings, loads_on
from orchestrator.space.polyhedra import rotation
from tests.verification.space_walls import block_on_ground

ROCKING = block_on_ground(0.4, 0.2, 1.0, 0.7)
SLIDING = block_on_ground(1.0, 0.7, 0.1, 0.53)


def multiplier(wall, direction, change=lambda joints: joints, mutate=lambda equilibrium: equilibrium):
    assemblage = find_joints(wall)
    assemblage = replace(assemblage, joints=change(assemblage.joints))
    loads = loads_on(wall, SpaceLoadSettings(direction=direction))
    return solve_associative(mutate(equations.equilibrium_of(assemblage, loads))).load_multiplier


def test_without_a_mutation_both_are_exact():
    assert multiplier(ROCKING, "+x") == pytest.approx(0.4, abs=1e-6)
    assert multiplier(SLIDING, (np.cos(0.1), np.sin(0.1), 0.0)) == pytest.approx(0.53, abs=1e-6)


def test_friction_that_is_a_tenth_off():
    off = multiplier(SLIDING, "+x", mutate=lambda one: replace(one, friction=1.1 * one.friction))
    assert abs(off - 0.53) > 1e-2


def test_a_tangent_with_the_wrong_sign_on_one_side():
    """The force on block j then is not the opposite of that on block i."""
    wall = u_wall(Plan(4, 2, 8), Stones())

    def flipped(one):
        matrix = one.matrix.tolil()
        first_tangent = (np.arange(matrix.shape[1]) % 3 == 1).astype(float)
        odd_blocks = np.flatnonzero(np.arange(matrix.shape[0]) // 6 % 2)
        matrix[odd_blocks] = one.matrix[odd_blocks].multiply(1.0 - 2.0 * first_tangent).tolil()
        return replace(one, matrix=matrix.tocsc())

    assert abs(multiplier(wall, "-y", mutate=flipped) - 0.34229) > 1e-3


def test_a_moment_about_the_wrong_point(monkeypatch):
    real = equations.np.cross

    def about_the_corner(arm, direction):
        return real(arm + [0.05, 0.0, 0.0], direction)

    monkeypatch.setattr(equations.np, "cross", about_the_corner)
    try:
        off = multiplier(ROCKING, "+x")
    finally:
        monkeypatch.undo()
    assert abs(off - 0.4) > 1e-2


def test_gauss_points_instead_of_corners():
    def inner(joints: Interfaces) -> Interfaces:
        centre = joints.centroid[joints.joint]
        return replace(joints, point=centre + (joints.point - centre) / np.sqrt(3.0))

    assert multiplier(ROCKING, "+x", inner) == pytest.approx(0.4 / np.sqrt(3.0), abs=1e-6)


def test_a_corner_that_is_left_out():
    def three(joints: Interfaces) -> Interfaces:
        return replace(joints, point=joints.point[1:], joint=joints.joint[1:])

    directions = ("+x", "-x", "+y", "-y")
    assert (
        min(multiplier(ROCKING, direction, three) / (0.4 if "x" in direction else 0.2) for direction in directions)
        < 0.9
    )


def test_a_pyramid_of_eight_sides_instead_of_the_cone():
    """cos(pi / 8) of the strength in its worst direction: outside 1e-6 by far, which the test of 16 directions asks."""
    worst = np.cos(np.pi / 8)
    assert 1.0 - worst > 1e-2
    turned = SLIDING.moved(rotation((0.0, 0.0, 1.0), 0.1))
    assert multiplier(turned, (np.cos(0.1), np.sin(0.1), 0.0)) == pytest.approx(0.53, abs=1e-6)


def test_torsion_of_corners_under_uniform():
    """With beta = 1 the block would twist at mu N d / 2, 1.85 times what `uniform` must give."""
    wall = block_on_ground(0.3, 0.3, 0.2, 0.4)
    assemblage = find_joints(wall)
    beta = equations.torsion_factors(assemblage.joints)
    assert beta == pytest.approx([2 * 0.38260 / np.sqrt(2.0)], abs=1e-5)
    loads = loads_on(wall)
    uniform = equations.equilibrium_of(assemblage, SpaceLoads(loads.dead, loads.live, loads.direction), "uniform")
    corners = equations.equilibrium_of(assemblage, loads)
    assert abs(uniform.matrix - corners.matrix).max() > 0.05
