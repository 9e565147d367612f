"""Slender columns under a floor, whose stones give way at edges and bend: finite elements of the default size against
fine ones and a beam-column on a bed without tension; what limit analysis says of them.

The beam-column, of height h and stiffness E I, stands on a half-plane: with k^2 = N / (E I), the moment at a foot that
turns by r is N tan(k h) / k (lambda + r), and a bed of length b bears N (b / 2 - N / (pi E t r)). lambda is largest at
one r.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from orchestrator import ElasticSettings, MeshSettings, SteppingSettings, one_body_per_block, push
from orchestrator.basis.errors import ConvergenceError
from orchestrator.limit_analysis import LimitAnalysisSettings, analyse
from orchestrator.loads import DeadLoad, LoadSettings, loads_on
from orchestrator.macroblocks.bodies import make_bodies
from orchestrator.macroblocks.criteria import partition_of
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.pressed_edges import columns_on
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.masonry.wall import Block, Wall
from orchestrator.pushover.meshing import mesh_bodies
from orchestrator.pushover.toes import element_ends
from tests.support.limit_analysis_cases import box
from tests.support.paths import PROJECT

WIDTH, HEIGHT, DEEP, TOP = 0.5, 4.0, 0.5, 300e3
"""of a column under a floor, m and N"""
ALONE = LimitAnalysisSettings(search_blocks=1, sequence_blocks=1)
FINE = MeshSettings(0.05, toe_offset=0.5)


def column(stones, size=1.0):
    outlines = [np.array(box(0.0, HEIGHT / stones * level, WIDTH, HEIGHT / stones)) for level in range(stones)]
    blocks = [Block(0, size * np.array(box(-1.0, -0.2, 5.0, 0.2)), True, 20e3)]
    blocks += [Block(k, size * outline, False, 20e3) for k, outline in enumerate(outlines, 1)]
    floor = DeadLoad((stones,), force=TOP * size**2, at=(0.5 * WIDTH * size, HEIGHT * size), inertia=True)
    return find_joints(Wall("column", tuple(blocks), DEEP, 0.7), JointSettings()), LoadSettings(dead=(floor,))


def portico():
    """Two columns of four drums under a beam with a floor on it."""
    blocks = [Block(0, np.array(box(-2.0, -0.2, 8.0, 0.2)), True, 20e3)]
    for x in (0.0, 3.0):
        blocks += [Block(len(blocks) + k, np.array(box(x, k, WIDTH, 1.0)), False, 20e3) for k in range(4)]
    blocks.append(Block(9, np.array(box(0.0, HEIGHT, 3.0 + WIDTH, 0.5)), False, 20e3))
    floor = DeadLoad((9,), force=2 * TOP, at=(1.5 + 0.5 * WIDTH, HEIGHT + 0.5), inertia=True)
    return find_joints(Wall("portico", tuple(blocks), DEEP, 0.7), JointSettings()), LoadSettings(dead=(floor,))


def pushed(case, modulus, mesh=None):
    """What finite elements bear, over the weight; limit analysis."""
    assemblage, load = case
    found = analyse(assemblage, ALONE, loads_on(assemblage.wall, load), modulus)
    stones, elastic = one_body_per_block(assemblage), ElasticSettings(elastic_modulus=modulus)
    stepping = SteppingSettings(final_displacement=0.0375 * assemblage.wall.blocks[-1].polygon[:, 1].max())
    done = push(assemblage, found, stones, load, elastic=elastic, stepping=stepping, mesh=mesh)
    assert done.summary.valid, done.summary.not_valid_because
    return done.capacity.peak_base_shear / found.horizontal_load, found


def told(found):
    """The part of what it bears as drawn that a column is said to lose."""
    said = [re.search(r"leans on the joint .* loses about ([\d.]+) %", remark) for remark in found.remarks]
    return max((0.01 * float(one[1]) for one in said if one), default=0.0)


def beam_column(modulus):
    """The largest multiplier of one stone under the floor, all of the load at the height of its resultant."""
    own = 20e3 * WIDTH * HEIGHT * DEEP
    weight, arm = own + TOP, (0.5 * own + TOP) / (own + TOP)
    k = np.sqrt(weight / (modulus * DEEP * WIDTH**3 / 12.0))
    lever = np.tan(k * HEIGHT * arm) / k

    def bears(turn):
        return (0.5 * WIDTH - weight / (np.pi * modulus * DEEP * turn)) / lever - turn

    return -minimize_scalar(lambda turn: -bears(turn), bounds=(1e-5, 0.1), method="bounded").fun


@pytest.mark.parametrize(("modulus", "tolerance"), [(3.5e9, 0.05), (1e10, 0.05), (50e9, 0.05)])
def test_a_stone_under_a_floor_bears_what_a_beam_column_on_a_bed_without_tension_does(modulus, tolerance):
    peak, _ = pushed(column(1), modulus)
    assert peak == pytest.approx(beam_column(modulus), rel=tolerance)


@pytest.mark.parametrize(("stones", "modulus"), [(1, 3.5e9), (8, 3.5e9), (3, 1e9)])
def test_elements_of_the_default_size_bear_what_fine_ones_do(stones, modulus):
    """25 to 66 % more without short elements at the edges that columns lean on, and across these columns."""
    fine, _ = pushed(column(stones), modulus, FINE)
    peak, found = pushed(column(stones), modulus)
    coarse, _ = pushed(column(stones), modulus, MeshSettings(toe_offset=0.5))
    assert peak == pytest.approx(fine, rel=0.03)
    assert coarse > 1.2 * fine
    drawn = (found.drawn or found.headline).load_multiplier
    assert told(found) == pytest.approx(1.0 - fine / drawn, abs=0.1)
    assert told(found) > 0.2


def on_two_stones():
    """A column of four drums on a course of two stones."""
    blocks = [Block(0, np.array(box(-1.0, -0.2, 5.0, 0.2)), True, 20e3)]
    blocks += [Block(k, np.array(box(0.5 * k - 0.75, 0.0, 0.5, 0.3)), False, 20e3) for k in (1, 2)]
    blocks += [Block(k + 3, np.array(box(0.0, 0.3 + k, WIDTH, 1.0)), False, 20e3) for k in range(4)]
    floor = DeadLoad((6,), force=TOP, at=(0.5 * WIDTH, HEIGHT + 0.3), inertia=True)
    return find_joints(Wall("on two stones", tuple(blocks), DEEP, 0.7), JointSettings()), LoadSettings(dead=(floor,))


def in_a_thicker_wall():
    """Eight drums half as thick as the wall that they belong to."""
    assemblage, load = column(8)
    blocks = (replace(one, thickness=None if one.fixed else DEEP) for one in assemblage.wall.blocks)
    wall = replace(assemblage.wall, blocks=tuple(blocks), thickness=2.0 * DEEP)
    return find_joints(wall, JointSettings()), load


def beside_a_stone():
    """A loose stone stands against the column, which is pushed away from it."""
    assemblage, load = column(4)
    stone = (Block(5, np.array(box(-1.0, 0.0, 1.0, 1.0)), False, 20e3),)
    wall = replace(assemblage.wall, blocks=assemblage.wall.blocks + stone)
    return find_joints(wall, JointSettings()), load


@pytest.mark.parametrize("case", [on_two_stones, in_a_thicker_wall, beside_a_stone])
def test_a_column_is_one_whatever_it_stands_on_and_beside_whatever_wall(case):
    fine, _ = pushed(case(), 3.5e9, FINE)
    peak, found = pushed(case(), 3.5e9)
    assert peak == pytest.approx(fine, rel=0.03)
    drawn = (found.drawn or found.headline).load_multiplier
    assert told(found) == pytest.approx(1.0 - fine / drawn, abs=0.1)


@pytest.mark.parametrize("x", [0.25, 0.35, 0.4])
def test_a_column_under_a_floor_beside_its_middle_loses_the_more_the_nearer_the_floor_is_to_the_edge(x):
    """10 GPa, pushed to the right: finite elements lose 13, 24 and 39 % of what rigid blocks bear as drawn."""
    assemblage, _ = column(4)
    load = LoadSettings(dead=(DeadLoad((4,), force=TOP, at=(x, HEIGHT), inertia=True),))
    peak, found = pushed((assemblage, load), 1e10)
    drawn = (found.drawn or found.headline).load_multiplier
    assert told(found) == pytest.approx(1.0 - peak / drawn, abs=0.1)


def test_a_taller_wall_beside_a_column_changes_nothing_that_is_said_of_it():
    assemblage, load = column(4)
    tall = (Block(5, np.array(box(3.0, 0.0, 0.9, 12.0)), False, 20e3),)
    beside = find_joints(replace(assemblage.wall, blocks=assemblage.wall.blocks + tall), JointSettings())
    alone, both = (analyse(joints, ALONE, loads_on(joints.wall, load), 3.5e9) for joints in (assemblage, beside))
    assert told(both) == pytest.approx(told(alone), abs=0.01)


def test_a_column_that_leans_already_falls_under_its_dead_load_whichever_way_it_is_pushed():
    """Drums that lean by 1 in 20: elements are short at both ends of their beds."""
    assemblage, load = column(4)
    leaning = (
        replace(one, polygon=one.polygon + 0.05 * one.polygon[:, 1:] * [1.0, 0.0]) for one in assemblage.wall.blocks[1:]
    )
    wall = replace(assemblage.wall, blocks=(assemblage.wall.blocks[0], *leaning))
    floor = DeadLoad((4,), force=TOP, at=(0.5 * WIDTH + 0.05 * HEIGHT, HEIGHT), inertia=True)
    for direction in ("+x", "-x"):
        load = LoadSettings(direction, dead=(floor,))
        with pytest.raises(ConvergenceError, match="does not stand under its dead load"):
            pushed((find_joints(wall, JointSettings()), load), 3.5e9)


def test_a_portico_too():
    fine, _ = pushed(portico(), 3.5e9, FINE)
    peak, found = pushed(portico(), 3.5e9)
    assert peak == pytest.approx(fine, rel=0.03)
    assert told(found) > 0.1


def test_a_column_of_another_size_has_the_same_answers():
    """Lengths and modulus times a tenth, thickness alike: all angles are the same."""
    (one, found), (tenth, again) = pushed(column(4), 3.5e9), pushed(column(4, 0.1), 3.5e8)
    assert tenth == pytest.approx(one, rel=3e-3), "rounding decides how far joints creep as they slide"
    assert told(again) == told(found) > 0.2


def test_nothing_is_said_and_no_element_short_where_stones_are_stiff_for_what_they_bear():
    assemblage, _ = column(8)
    found = analyse(assemblage, ALONE, loads_on(assemblage.wall, LoadSettings()))
    assert not told(found)
    bodies = make_bodies(assemblage, one_body_per_block(assemblage), found.headline.joint_forces)
    assert not element_ends(bodies, MeshSettings().size_of(bodies), MeshSettings().toe_offset)


def test_a_column_half_as_thick_as_the_wall_loses_more():
    """Its stones bear twice as much per thickness; the block class of a thinner stone, not the wall, says how much."""
    assemblage, load = column(8)
    half = replace(assemblage.wall, blocks=tuple(replace(one, thickness=0.5 * DEEP) for one in assemblage.wall.blocks))
    whole, thin = (
        analyse(joints, ALONE, loads_on(joints.wall, load))
        for joints in (assemblage, find_joints(half, JointSettings()))
    )
    assert told(thin) > 1.3 * told(whole)


def test_a_column_bears_the_same_from_whichever_corner_its_stones_are_drawn():
    """The circles round its toes lie left of the first corner then, or below, and gmsh takes no "x - -0.5" (it ended
    the process)."""
    assemblage, load = column(3)
    stepping, borne = SteppingSettings(final_displacement=0.02), []
    for first in range(4):
        blocks = tuple(replace(b, polygon=np.roll(b.polygon, first, axis=0)) for b in assemblage.wall.blocks)
        turned = find_joints(replace(assemblage.wall, blocks=blocks), JointSettings())
        found = analyse(turned, ALONE, loads_on(turned.wall, load))
        done = push(turned, found, one_body_per_block(turned), load, stepping=stepping)
        assert done.summary.valid, done.summary.not_valid_because
        borne.append(done.capacity.peak_base_shear / found.horizontal_load)
    assert borne == pytest.approx([borne[0]] * 4, rel=2e-3)


def test_courses_are_no_columns():
    """Benchmark 1 has stones of half the width beside its openings, and every joint is under more than one stone."""
    assemblage = find_joints(read_blocks(PROJECT / "meshes/ferris_tinloi_wall6.json"), JointSettings())
    assert not columns_on(assemblage.wall, assemblage.joints, np.ones(assemblage.joints.count)).height.any()


def test_columns_are_as_high_as_the_stones_that_stand_on_each_other_alone():
    assemblage, _ = portico()
    columns = columns_on(assemblage.wall, assemblage.joints, np.ones(10))
    level = assemblage.joints.centroid[:, 1]
    assert columns.height == pytest.approx(np.maximum(level, HEIGHT - level)), "beds and tops of both columns too"
    assert columns.width == pytest.approx(np.full(10, WIDTH))


def test_a_wall_that_is_one_body_under_a_column_has_long_elements():
    """Only the column bends: two courses of eight stones of 1 m x 0.5 m stand under its four drums, all one body."""
    blocks = [Block(0, np.array(box(-5.0, -1.2, 12.0, 0.2)), True, 20e3)]
    places = [(k % 8 - 4.0, -1.0 + 0.5 * (k // 8)) for k in range(16)]
    blocks += [Block(k, np.array(box(*place, 1.0, 0.5)), False, 20e3) for k, place in enumerate(places, 1)]
    blocks += [Block(17 + k, np.array(box(0.25, k, WIDTH, 1.0)), False, 20e3) for k in range(4)]
    floor = DeadLoad((20,), force=TOP, at=(0.25 + 0.5 * WIDTH, HEIGHT), inertia=True)
    assemblage = find_joints(Wall("on a wall", tuple(blocks), DEEP, 0.7), JointSettings())
    found = analyse(assemblage, ALONE, loads_on(assemblage.wall, LoadSettings(dead=(floor,))), 3.5e9)
    one_wall = partition_of(assemblage, np.array([0, *[1] * 16, *range(17, 21)]))
    bodies = make_bodies(assemblage, one_wall, found.headline.joint_forces, 3.5e9)
    short, long = (mesh_bodies(bodies, MeshSettings(toe_offset=offset)) for offset in (0.005, 0.5))
    nodes, before = (np.bincount(mesh.body_of_node) for mesh in (short, long))
    (wall,) = (body.number for body in bodies.bodies if len(body.blocks) == 16)
    drums = np.arange(bodies.moving) != wall
    assert nodes[drums].max() > 4 * before[drums].max()
    assert nodes[wall] < 1.5 * before[wall]
