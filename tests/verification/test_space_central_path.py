"""The path of smoothed contact: closed forms, the validator, invariance, and a wall on which it turns back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from orchestrator.geometry.polyhedra import box
from orchestrator.space.central_path import PRODUCTS_LEFT, follow
from orchestrator.space.conic_program import solve_associative
from orchestrator.space.contacts import find_joints
from orchestrator.space.descent import closed
from orchestrator.space.equilibrium import equilibrium_of
from orchestrator.space.generators.shapes import Plan, Stones, u_wall
from orchestrator.space.loads import SpaceLoadSettings, loads_on
from orchestrator.space.springs import joint_stiffness, springs_of
from orchestrator.space.states import state_of
from orchestrator.space.ties import Tie, with_ties
from orchestrator.space.work import Work
from tests.support.space_walls import WITHOUT_DILATION, turned, v_groove, wall_of


def path_of(wall, direction="-y", ties=(), **settings):
    """Assemblage, loads, equilibrium and the end of the path."""
    assemblage = with_ties(find_joints(wall), ties)
    loads = loads_on(wall, SpaceLoadSettings(direction=direction))
    equilibrium = equilibrium_of(assemblage, loads)
    springs = springs_of(assemblage, equilibrium, joint_stiffness(assemblage))
    end = follow(springs, equilibrium, solve_associative(equilibrium), Work(), **settings)
    return assemblage, loads, equilibrium, end


@pytest.mark.parametrize(("wall", "direction", "expected"), WITHOUT_DILATION)
def test_the_path_ends_at_the_limit_without_dilation(wall, direction, expected):
    end = path_of(wall, direction)[-1]
    assert end.left <= PRODUCTS_LEFT
    assert end.load_multiplier == pytest.approx(expected, abs=2e-6)


def test_friction_that_is_a_tenth_off_is_seen():
    assert path_of(v_groove(np.radians(45), 0.55), "+y")[-1].load_multiplier > 1.05 * 0.707107


def test_a_tie_yields():
    """A block of 0.2 x 0.2 x 1 m tied back at its top with a tenth of its weight: 0.2 + 2 x 0.1."""
    block, wall = box((0.0, 0.0, 0.0), (0.2, 0.2, 1.0)), box((-1.0, 0.0, 0.0), (-0.8, 0.2, 2.0))
    tied = wall_of([box((-3.0, -3.0, -1.0), (3.0, 3.0, 0.0)), wall, block], 0.9, supports=2)
    tie = Tie(blocks=(1, 2), start=(-0.8, 0.1, 1.0), end=(0.0, 0.1, 1.0), strength=0.1 * tied.weights[2])
    assert path_of(tied, "+x", (tie,))[-1].load_multiplier == pytest.approx(0.4, abs=2e-6)


@pytest.mark.parametrize(("plan", "turns"), [(Plan(6, 4, 12), 0), (Plan(8, 5, 18), 2)])
def test_the_path_leads_to_a_state_past_the_points_where_it_turns_back(plan, turns):
    """The end of the path is closed to a state that the validator passes; 174 and 333 blocks."""
    assemblage, loads, equilibrium, end = path_of(u_wall(plan, Stones()))
    assert end.turns >= turns
    found = closed(equilibrium, end.slip, Work(), 0.0)
    state = state_of("closed", assemblage, loads, found.forces, found.mechanism.velocities, "corners")
    assert state.valid, state.error
    assert state.load_multiplier == pytest.approx(end.load_multiplier, rel=2e-3)


def test_the_path_is_the_same_when_the_model_is_turned_mirrored_and_renumbered():
    """To 2e-6 at products of 1e-4; further down rounding decides where on a face of forces the end is (2e-4)."""
    wall = u_wall(Plan(4, 2, 8), Stones())
    expected = path_of(wall, enough=1e-4)[-1].load_multiplier
    other, turn = turned(wall)
    shuffled = np.random.default_rng(5).permutation(len(wall.blocks))
    renumbered = replace(wall, blocks=tuple(wall.blocks[k] for k in shuffled))
    models = ((other, tuple(turn @ [0.0, -1.0, 0.0])), (renumbered, "-y"), (wall.moved(np.diag([-1.0, 1, 1])), "-y"))
    for changed, direction in models:
        end = path_of(changed, direction, enough=1e-4)[-1]
        assert end.load_multiplier == pytest.approx(expected, rel=2e-6)


def test_a_path_that_is_given_no_work_says_how_far_it_is():
    assemblage, _, equilibrium, end = path_of(u_wall(Plan(2, 1, 2), Stones()))
    springs = springs_of(assemblage, equilibrium, joint_stiffness(assemblage))
    begun = follow(springs, equilibrium, solve_associative(equilibrium), Work(until=0))
    assert begun.left > 1.0 > PRODUCTS_LEFT >= end.left
