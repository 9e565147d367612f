"""What a push on elastic joints in space must not depend on, and what counts where it does not come to rest."""

from __future__ import annotations

import sys
from dataclasses import replace
from time import thread_time

import numpy as np
import pytest

from orchestrator.geometry.polyhedra import box
from orchestrator.present.answer import answer_in_space
from orchestrator.space.analysis import SpaceLimitSettings, analyse
from orchestrator.space.contacts import find_joints
from orchestrator.space.found import PUSHES
from orchestrator.space.generators.shapes import Plan, Stones, u_wall
from orchestrator.space.loads import SpaceLoadSettings, loads_on
from orchestrator.space.wall import SpaceWall
from tests.support.space_walls import GROUND, cut_by_planes, v_groove, wall_of
from tests.verification.test_space_states import states_of


@pytest.mark.parametrize("cut", [(1, 4), (1, 1), (2, 1), (4, 1)])
def test_how_many_stones_a_course_of_leaves_is_cut_into_changes_nothing(cut):
    """The wall is prismatic: its thin leaf falls off alone, at b / H as in the plane, however leaves are cut."""
    leaves = ((0.0, 0.2, 20e3), (0.2, 0.6, 26e3))
    boxes = [
        (box((2.0 * k / count, front, 0.3 * course), (2.0 * (k + 1) / count, back, 0.3 * (course + 1))), weight)
        for (front, back, weight), count in zip(leaves, cut, strict=True)
        for course in range(4)
        for k in range(count)
    ]
    wall = wall_of([box((-1.0, -1.0, -0.3), (3.0, 2.0, 0.0)), *(one for one, _ in boxes)], friction=0.7)
    weights = [20e3, *(weight for _, weight in boxes)]
    blocks = [replace(block, unit_weight=weight) for block, weight in zip(wall.blocks, weights, strict=True)]
    headline = states_of(replace(wall, blocks=tuple(blocks)), states="headline").headline
    assert headline.load_multiplier == pytest.approx(0.2 / 1.2, abs=1e-4)


@pytest.mark.parametrize("stacks", [3, 5])
def test_stacks_that_fall_side_by_side_at_one_multiplier_rest_there(stacks):
    """b / H of each, whatever share of the motion it has: Newton's method left more out of balance than a state may by
    far, and its steps got ever shorter."""
    boxes = [box((0.0, 0.2, 0.4 * course), (2.0, 0.8, 0.4 * (course + 1))) for course in range(3)]
    for k in range(stacks):
        start, end = 2.0 * k / stacks, 2.0 * (k + 1) / stacks
        boxes += [box((start, 0.8, 0.4 * course), (end, 0.98, 0.4 * (course + 1))) for course in range(3)]
    found = states_of(
        wall_of([box((-1.0, -1.0, -0.3), (3.0, 2.0, 0.0)), *boxes], friction=0.7), "+y", states="headline"
    )
    assert found.headline.name == PUSHES[0]
    assert found.headline.load_multiplier == pytest.approx(0.18 / 1.2, abs=1e-4)
    assert found.seconds < 5.0


def test_a_push_ends_where_a_mirrored_one_does():
    """The U-shaped wall under two directions that mirror each other: one crept on for 35 s, and had no state."""
    assemblage, ends = find_joints(u_wall(Plan(4, 2, 8), Stones())), []
    for angle in np.radians([202.0, 338.0]):
        loads = loads_on(assemblage.wall, SpaceLoadSettings(direction=(np.cos(angle), np.sin(angle), 0.0)))
        analysis = analyse(assemblage, loads, SpaceLimitSettings(states="headline"))
        assert analysis.headline.name == PUSHES[0]
        ends.append(analysis.headline.load_multiplier)
    assert ends[0] == pytest.approx(ends[1], rel=1e-5)


def test_a_state_above_a_load_at_which_loading_has_not_come_to_rest_is_no_capacity():
    """Leaves in stacks, in too little time: the push stood at 0.15, their closed form, and a state at 0.20 counted."""
    found = states_of(v_groove(np.radians(45), 0.5), "+y")
    moves = replace(found.states[0], load_multiplier=0.5, error="not at rest after 1400 factorisations")
    state = replace(found.states[0], name="descent from elastic joints, turn 1")
    unsettled = replace(found, states=(moves, state))
    assert unsettled.headline is state
    assert unsettled.not_at_rest == 0.5
    (said,) = answer_in_space(unsettled)
    assert said.startswith("λ = 0.70711 is no capacity")
    assert "Lower is λ = (0.50000), where loading had not come to rest." in said
    lower = replace(state, load_multiplier=0.504)
    assert replace(found, states=(moves, state, lower)).headline is lower
    nearer = replace(found, states=(replace(moves, load_multiplier=0.705), state))
    assert nearer.not_at_rest is None
    assert "0.70711 counts" in answer_in_space(nearer)[0]


def test_what_is_nearly_a_state_counts_in_brackets_where_no_push_ended_in_one():
    """Walls of 1,000 blocks came within 1e-5 of a state, and had their associative bound for an answer, 28 % above."""
    found = states_of(v_groove(np.radians(45), 0.5), "+y")
    assert not any(state.nearly for state in found.states)
    wrong = replace(found.states[0].validation, flow=2e-5)
    moves = replace(found.states[0], load_multiplier=0.5, error="not at rest", nearly=True, validation=wrong)
    other = replace(found.states[0], name="descent from elastic joints, turn 1", load_multiplier=0.6)
    assert replace(found, states=(moves, other)).headline is moves, "a state that bears more is farther from the load"
    assert replace(found, states=(found.states[0], moves)).headline is found.states[0]
    closed = replace(other, load_multiplier=0.4995)
    assert replace(found, states=(moves, closed)).headline is closed, "the state that its end was closed to"
    nearest = replace(other, load_multiplier=0.5, error="flow", nearly=True, validation=wrong)
    farther = replace(nearest, validation=replace(wrong, flow=3e-4))
    alone = replace(found, states=(replace(moves, nearly=False), farther, nearest))
    assert alone.headline is nearest
    assert alone.range == (0.5, 0.5)
    assert answer_in_space(alone)[0].startswith(
        "λ = (0.50000) counts (descent from elastic joints, turn 1, a state but for 2e-05 of its power): "
    )
    assert replace(alone, associative=None).headline is None, "what has no bound may move by rounding alone"


@pytest.mark.parametrize("states", ["range", "headline"])
def test_where_the_joints_stiffness_decides_the_lower_end_counts(states):
    """The U-shaped wall under mass x height: springs stiffer with depth 0.2219, equal ones 0.2182, 1.6 % less."""
    assemblage = find_joints(u_wall(Plan(4, 2, 8), Stones()))
    loads = loads_on(assemblage.wall, SpaceLoadSettings(direction="-y", distribution="mass_height"))
    analysis = analyse(assemblage, loads, SpaceLimitSettings(states=states))
    pushes = {state.name: state.load_multiplier for state in analysis.states if state.valid and state.name in PUSHES}
    assert len(pushes) == 2
    assert analysis.headline.load_multiplier == min(pushes.values()) == pytest.approx(0.2182, abs=1e-3)


def test_what_is_found_does_not_depend_on_the_machine(monkeypatch):
    """Rubble cut by planes and a U wall, in less time than they need; where clocks run a thousandfold."""
    rubble, away = wall_of([GROUND, *cut_by_planes(1, 11)], 0.6), SpaceLoadSettings(direction=(0.0, 1.0, 0.0))

    def multipliers(wall: SpaceWall, seconds: float) -> list[float]:
        assemblage = find_joints(wall)
        found = analyse(assemblage, loads_on(assemblage.wall, away), SpaceLimitSettings(time=seconds))
        return [state.load_multiplier for state in found.states]

    walls = [(rubble, 0.1), (u_wall(Plan(6, 4, 6), Stones()), 0.5)]
    here = [multipliers(*given) for given in walls]
    assert all(found != multipliers(wall, 20.0) for found, (wall, _) in zip(here, walls, strict=True)), "time binds"
    for module in [module for name, module in sys.modules.items() if name.startswith("orchestrator.space")]:
        for clock in {"thread_time", "process_time", "perf_counter", "monotonic", "time"} & set(vars(module)):
            monkeypatch.setattr(module, clock, lambda: 1e3 * thread_time())
    assert [multipliers(*given) for given in walls] == here
