"""The interior-point step of the push against closed forms and against Newton's method on the same springs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

from orchestrator.geometry.polyhedra import box
from orchestrator.space.analysis import SpaceLimitSettings, analyse
from orchestrator.space.conic_program import gravity_forces
from orchestrator.space.contacts import find_joints
from orchestrator.space.equilibrium import equilibrium_of
from orchestrator.space.generators.shapes import Plan, Stones, u_wall
from orchestrator.space.interior_step import interior_step
from orchestrator.space.loads import SpaceLoadSettings, loads_on
from orchestrator.space.springs import displaced, flow_error, joint_stiffness, springs_of
from orchestrator.space.stiffness import ContactStiffness
from orchestrator.space.ties import Tie, with_ties
from orchestrator.space.wall import SpaceBlock
from tests.support.space_walls import WITHOUT_DILATION, wall_of


def problem(wall, direction, ties=()):
    """Springs, gravity forces over the mean weight, and mean weight over the live load's sum."""
    assemblage = with_ties(find_joints(wall), ties)
    equilibrium = equilibrium_of(assemblage, loads_on(wall, SpaceLoadSettings(direction=direction)))
    stiffness = joint_stiffness(assemblage)
    springs = springs_of(assemblage, equilibrium, stiffness)
    forces = gravity_forces(equilibrium, stiffness) / equilibrium.weight_scale
    return springs, forces, equilibrium.weight_scale / equilibrium.live_total


def leapt(springs, forces, lengths=(1.0, 30.0, 1e3, 3e4), goal=1e-9):
    """Steps of these lengths, each from where the last one led."""
    multiplier, velocities = 0.0, np.zeros_like(springs.dead)
    for h in lengths:
        pushed, left, _ = interior_step(springs, forces, multiplier, h * velocities, h, goal)
        multiplier, velocities, forces = pushed.multiplier, pushed.displacements / h, pushed.forces
    return pushed, left


@pytest.mark.parametrize(("wall", "direction", "expected"), WITHOUT_DILATION)
def test_steps_that_grow_thirtyfold_end_at_the_limit_without_dilation(wall, direction, expected):
    springs, forces, scale = problem(wall, direction)
    pushed, left = leapt(springs, forces)
    assert left < 1e-8
    assert pushed.error < 1e-6
    assert scale * pushed.multiplier == pytest.approx(expected, abs=2e-6)
    assert flow_error(springs, pushed, pushed.displacements / 3e4) < 1e-5


def test_a_tie_yields_and_a_frictionless_end_carries_no_shear():
    """A block of 0.2 x 0.2 x 1 m tied back at its top with a tenth of its weight: 0.2 + 2 x 0.1."""
    block, wall = box((0.0, 0.0, 0.0), (0.2, 0.2, 1.0)), box((-1.0, 0.0, 0.0), (-0.8, 0.2, 2.0))
    tied = wall_of([box((-3.0, -3.0, -1.0), (3.0, 3.0, 0.0)), wall, block], 0.9, supports=2)
    tie = Tie(blocks=(1, 2), start=(-0.8, 0.1, 1.0), end=(0.0, 0.1, 1.0), strength=0.1 * tied.weights[2])
    springs, forces, scale = problem(tied, "+x", (tie,))
    pushed, left = leapt(springs, forces)
    assert left < 1e-8
    assert scale * pushed.multiplier == pytest.approx(0.4, abs=2e-6)
    assert pushed.forces[-1] == pytest.approx([0.1, 0.0, 0.0], abs=1e-6)


@pytest.mark.parametrize("h", [0.3, 3.0])
def test_newtons_method_agrees(h):
    """The same step of the same springs: what the forces are where the interior points ended says so without them."""
    springs, forces, _ = problem(u_wall(Plan(4, 2, 4), Stones()), "-y")
    pushed, left = leapt(springs, forces, (h,), 1e-12)
    assert left < 1e-12
    law = displaced(springs, forces, pushed.multiplier, pushed.displacements)
    assert springs.live @ pushed.displacements == pytest.approx(h)
    assert pushed.forces == pytest.approx(law.forces, abs=1e-5)
    assert law.error < 1e-4


def test_friction_that_is_a_tenth_off_is_seen():
    """Mutation: forces of a wall with other friction are none of this one's springs."""
    wall = u_wall(Plan(4, 2, 4), Stones())
    springs, forces, _ = problem(wall, "-y")
    other, _, _ = problem(u_wall(Plan(4, 2, 4), Stones(friction=0.66)), "-y")
    pushed, _ = leapt(other, forces, (3.0,), 1e-12)
    law = displaced(springs, forces, pushed.multiplier, pushed.displacements)
    assert np.abs(pushed.forces - law.forces).max() > 1e-3


def test_leaps_end_in_the_state_that_steps_end_in():
    """U(4,2,8): 0.3195 by Newton's method; 0.2 % is what the length of steps may change, 0.5 % closing.

    Of so many blocks a wall is pushed in leaps: 235 cubes stand beside it, apart, and slide at 0.6 only.
    """
    wall = u_wall(Plan(4, 2, 8), Stones())
    ground = SpaceBlock(1000, box((0.0, 2.0, -1.0), (100.0, 3.0, 0.0)), fixed=True)
    cubes = [SpaceBlock(1001 + k, box((1.0 + 0.4 * k, 2.4, 0.0), (1.2 + 0.4 * k, 2.6, 0.2))) for k in range(235)]
    assemblage = find_joints(replace(wall, blocks=(*wall.blocks, ground, *cubes)))
    loads = loads_on(assemblage.wall, SpaceLoadSettings(direction="-y"))
    found = analyse(assemblage, loads, SpaceLimitSettings(states="headline"))
    assert found.states[0].load_multiplier == pytest.approx(0.3195, rel=2e-3)
    assert found.headline is not None
    assert found.headline.load_multiplier == pytest.approx(0.3195, rel=5e-3)
    assert not found.headline.validation.complaints


@pytest.mark.parametrize("torsion", ["corners", "uniform"])
def test_the_stiffness_matrix_is_that_of_the_equilibrium_equations(torsion):
    """B diag(k D) B^T, of any D, summed by joints and as the product of sparse matrices."""
    assemblage = find_joints(u_wall(Plan(2, 1, 2), Stones()))
    equilibrium = equilibrium_of(assemblage, loads_on(assemblage.wall, SpaceLoadSettings(direction="-y")), torsion)
    generator, points = np.random.default_rng(1), len(equilibrium.friction)
    tangent, stiffness = generator.normal(size=(points, 3, 3)), generator.random(points)
    B = sp.diags(equilibrium.row_scale) @ equilibrium.matrix
    expected = (B @ sp.block_diag(list(stiffness[:, None, None] * tangent)) @ B.T).toarray()
    found = ContactStiffness(assemblage, equilibrium).matrix(stiffness, tangent).toarray()
    assert found == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())
