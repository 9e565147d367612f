"""States closed near where a path has led: closed forms from forces at rest far below; joints that stand open."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from orchestrator.basis.arrays import read_only
from orchestrator.limit_analysis.gravity import problem_of
from orchestrator.limit_analysis.search.elastic_contact import elastic_wall, joint_stiffness
from orchestrator.limit_analysis.search.loading_path import load_path
from orchestrator.limit_analysis.search.nearest_state import Closing
from tests.support.limit_analysis_cases import answers, assemblage_of, box, case

FLOOR = box(-3.0, -0.5, 6.0, 0.5)


@pytest.mark.parametrize(("width", "height"), [(0.5, 1.0), (1.0, 1.0)])
def test_state_from_forces_under_dead_load_alone(width, height):
    """min(mu, b/h), and nothing where the multipliers asked for leave it out; no slip is known at first."""
    wall = assemblage_of([FLOOR, box(-width / 2, 0, width, height)])
    problem = problem_of(wall)
    expected = min(0.65, width / height)
    path = load_path(problem, expected)
    standing = replace(path.state, joint_forces=path.forces[0])
    closing = Closing(problem, joint_stiffness(elastic_wall(wall, problem.equilibrium, problem.friction)))
    no_slip = np.zeros(wall.joints.count)
    found = closing.near(standing, no_slip, 0.0, 1.0)
    assert found.load_multiplier == pytest.approx(expected, rel=1e-6)
    assert problem.complaints(found) == ()
    assert closing.near(standing, no_slip, 0.0, 0.9 * expected) is None


def test_state_near_the_last_rest_of_a_published_wall():
    """Ferris and Tin-Loi's wall 4: from the forces of its last rest and the slips of its state, 0.264 again."""
    wall = case("ferris_tinloi_wall4")
    problem = problem_of(wall)
    bound = answers("ferris_tinloi_wall4").associative.load_multiplier
    path = load_path(problem, bound)
    resting = replace(path.state, joint_forces=path.forces[-1], load_multiplier=path.last_rest)
    closing = Closing(problem, joint_stiffness(elastic_wall(wall, problem.equilibrium, problem.friction)))
    found = closing.near(resting, path.state.mechanism.slip, path.last_rest, bound)
    assert found.load_multiplier == pytest.approx(0.264, abs=1e-3)


def pushed_against_a_stop():
    """A sliding block's state at lambda = mu, and the joint to a fixed stop that it slides towards."""
    wall = assemblage_of([FLOOR, box(-0.5, 0.0, 1.0, 0.5), box(0.5, 0.0, 0.5, 0.5)], fixed=(0, 2))
    problem = problem_of(wall)
    alone = problem_of(assemblage_of([FLOOR, box(-0.5, 0.0, 1.0, 0.5)]))
    sliding = load_path(alone, 0.65).state
    stop = np.flatnonzero((wall.joints.i == 1) & (wall.joints.j == 2) | (wall.joints.i == 2) & (wall.joints.j == 1))
    floor = np.flatnonzero((wall.joints.i == 0) & (wall.joints.j == 1) | (wall.joints.i == 1) & (wall.joints.j == 0))
    assert len(stop) == len(floor) == 1
    forces = np.zeros((wall.joints.count, 3))
    forces[floor] = sliding.joint_forces
    state = replace(
        sliding,
        joint_forces=read_only(forces),
        mechanism=replace(
            sliding.mechanism, velocities=read_only(np.vstack([sliding.mechanism.velocities, np.zeros(3)]))
        ),
    )
    return problem, state, int(stop[0])


def test_only_a_joint_that_stands_open_may_close():
    problem, state, stop = pushed_against_a_stop()
    (complaint,) = problem.complaints(state)
    assert complaint.startswith("interpenetration")
    open_ends = np.zeros((len(state.joint_forces), 2), dtype=bool)
    elsewhere = open_ends.copy()
    open_ends[stop] = True
    elsewhere[1 - stop] = True
    assert problem.complaints(replace(state, open_ends=open_ends)) == ()
    assert problem.complaints(replace(state, open_ends=elsewhere)) == (complaint,)


def test_a_joint_that_stands_open_carries_nothing_when_it_closes():
    problem, state, stop = pushed_against_a_stop()
    forces = state.joint_forces.copy()
    forces[stop, :2] = 0.1 * problem.equilibrium.unit_force
    open_ends = np.zeros((len(forces), 2), dtype=bool)
    open_ends[stop] = True
    said = " ".join(problem.complaints(replace(state, joint_forces=forces, open_ends=open_ends)))
    assert "flow" in said
    assert "equilibrium" in said
