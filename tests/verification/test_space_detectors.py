"""What the tests of walls in space would see: each mutation below moves a closed form out of its tolerance."""

from __future__ import annotations

from dataclasses import replace

import clarabel
import numpy as np
import pytest
import scipy.sparse as sp

from orchestrator.geometry.polyhedra import rotation
from orchestrator.space import conic_program
from orchestrator.space import equilibrium as equations
from orchestrator.space.conic_program import solve_associative
from orchestrator.space.contacts import Interfaces, find_joints
from orchestrator.space.generators.shapes import Plan, Stones, u_wall
from orchestrator.space.loads import SpaceLoadSettings, loads_on
from tests.support.space_walls import block_on_ground, twist

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


def pyramid(equilibrium):
    """Eight sides inside the cone: cos a T1 + sin a T2 <= cos(pi / 8) mu N."""
    count, sides = len(equilibrium.friction), np.pi / 4 * np.arange(8)
    point = np.repeat(np.arange(count), 8)
    angle, row = np.tile(sides, count), np.arange(8 * count)
    values = (-np.cos(np.pi / 8) * equilibrium.friction[point], np.cos(angle), np.sin(angle))
    parts = [sp.csc_matrix((v, (row, 3 * point + k)), shape=(8 * count, 3 * count)) for k, v in enumerate(values)]
    return [clarabel.NonnegativeConeT(8 * count)], sum(parts[1:], parts[0]).tocsc(), np.zeros(8 * count)


def test_a_pyramid_of_eight_sides_instead_of_the_cone(monkeypatch):
    """0.924 of sliding in the worst direction, and 0.3946 for 0.448230 across a slope of 20 degrees."""
    slope = block_on_ground(0.5, 0.5, 0.1, 0.6).moved(rotation((0.0, 1.0, 0.0), np.radians(20.0)))
    slope = replace(slope, up=np.array([0.0, 0.0, 1.0]))
    assert multiplier(SLIDING, "+x") == pytest.approx(0.53, abs=1e-6)
    assert multiplier(slope, "+y") == pytest.approx(0.448230, abs=1e-6)
    monkeypatch.setattr(conic_program, "_coulomb_cones", pyramid)
    assert multiplier(SLIDING, "+x") == pytest.approx(0.53 * np.cos(np.pi / 8), abs=1e-6)
    assert multiplier(slope, "+y") == pytest.approx(0.3946, abs=1e-4)


def test_torsion_of_corners_under_uniform(monkeypatch):
    """With beta = 1 a square block twists at 0.707107 mu N b, where `uniform` must give 0.38260."""
    for beta, expected in ((None, 0.38260), (1.0, 0.707107)):
        if beta:
            monkeypatch.setattr(equations, "torsion_factors", lambda joints: np.ones(joints.count))
        assert twist(1.0, "uniform") == pytest.approx(expected, abs=1e-5)
