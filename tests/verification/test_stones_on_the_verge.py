"""Stones that overhang by half their length: under their weight alone they are balanced on an edge.

By statics the live load tips such a stone about its edge at e / (h / 2), e the distance of its centroid inside the
edge: at nothing where e is nothing. That its neighbour presses against it, and holds it down by friction, is
self-stress that no loading brings about, though a linear program finds it. Such a stone is the wall's failure, or a
local one, as in finite elements.
"""

from __future__ import annotations

import pytest

from orchestrator import JointSettings, SteppingSettings, analyse, find_joints, one_body_per_block, push
from orchestrator.basis.errors import CaseError
from orchestrator.loads import LoadSettings, loads_on
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.wall import Block, Wall
from orchestrator.space.analysis import analyse as analyse_in_space
from orchestrator.space.contacts import SpaceAssemblage
from orchestrator.space.contacts import find_joints as find_space_joints
from orchestrator.space.loads import SpaceLoadSettings
from orchestrator.space.loads import loads_on as space_loads_on
from tests.support.pushover_chain import rectangle
from tests.support.space_walls import extruded, wall_of

HEIGHT, LOAD = 0.4, LoadSettings("-x")


def two_courses(inside: float) -> Assemblage:
    """Two stones and three on them, the first of which overhangs on the left; its centroid is `inside` (m) the edge."""
    below = [rectangle(0.4 - inside, 0.0, 0.8 + inside, HEIGHT), rectangle(1.2, 0.0, 1.2, HEIGHT)]
    above = [rectangle(0.8 * k, HEIGHT, 0.8, HEIGHT) for k in range(3)]
    outlines = [rectangle(-0.2, -0.2, 2.8, 0.2), *below, *above]
    wall = Wall("courses", tuple(Block(k, outline, k == 0, 20e3) for k, outline in enumerate(outlines)), 0.4, 0.5)
    return find_joints(wall, JointSettings())


def in_space(inside: float) -> SpaceAssemblage:
    """The same two courses as prisms."""
    return find_space_joints(
        wall_of([extruded(block.polygon, 0.4) for block in two_courses(inside).wall.blocks], friction=0.5)
    )


def toothed() -> Assemblage:
    """Ten courses of two and a half stones each, toothed at both ends: each tooth but the top one is built over."""
    outlines = [rectangle(-0.5, -0.2, 3.5, 0.2)]
    for course in range(10):
        start = 0.25 * (course % 2)
        outlines += [rectangle(start + 0.5 * k, 0.2 * course, 0.5, 0.2) for k in range(5)]
    wall = Wall("toothed", tuple(Block(k, outline, k == 0, 20e3) for k, outline in enumerate(outlines)), 0.4, 0.6)
    return find_joints(wall, JointSettings())


@pytest.mark.parametrize("inside", [0.01, 0.001])
def test_a_stone_that_is_not_balanced_tips_about_its_edge(inside):
    wall = two_courses(inside)
    assert analyse(wall, loads=loads_on(wall.wall, LOAD)).headline.load_multiplier == pytest.approx(
        inside / (0.5 * HEIGHT), rel=5e-4
    )


@pytest.mark.parametrize("inside", [1e-6, 0.0, -1e-6])
def test_a_wall_whose_stone_is_balanced_is_refused_with_its_number(inside):
    """0.2857 counted, which reached the upper bound."""
    wall = two_courses(inside)
    with pytest.raises(CaseError, match="on the verge of collapse under its dead load: block 3 would move"):
        analyse(wall, loads=loads_on(wall.wall, LOAD))


def test_it_is_so_in_space():
    wall = in_space(0.001)
    loads = space_loads_on(wall.wall, SpaceLoadSettings(direction="-x"))
    assert analyse_in_space(wall, loads).headline.load_multiplier == pytest.approx(0.001 / (0.5 * HEIGHT), rel=5e-4)
    for inside in (1e-6, 0.0):
        wall = in_space(inside)
        with pytest.raises(CaseError, match="on the verge of collapse under its dead load: block 3 would move"):
            analyse_in_space(wall, space_loads_on(wall.wall, SpaceLoadSettings(direction="-x")))


def test_the_other_way_it_leans_on_its_neighbour():
    wall = two_courses(0.0)
    assert analyse(wall, loads=loads_on(wall.wall, LoadSettings("+x"))).headline.load_multiplier > 0.1


def test_a_small_stone_that_is_balanced_comes_loose_and_the_wall_goes_on_as_in_finite_elements():
    wall, load = toothed(), LoadSettings("+x")
    analysis = analyse(wall, loads=loads_on(wall.wall, load))
    (failure,) = analysis.local_failures
    assert failure.stones == (50,)
    assert failure.multipliers == (0.0, 0.0)
    stepping = SteppingSettings(final_displacement=0.02)
    done = push(wall, analysis, one_body_per_block(wall), load, stepping=stepping)
    assert [event.bodies for event in done.summary.events] == [("block 50",)]
    assert done.capacity.peak_multiplier == pytest.approx(analysis.pressed_peak, rel=0.01)
    assert analysis.headline.load_multiplier == pytest.approx(analysis.rigid_peak, rel=0.01)
