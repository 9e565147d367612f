"""Loads beside and above centroids where blocks have moved: closed forms, springs, a load as a block.

A block that turns about its toe by t moves a force F at (x, y) from the toe, drawn, to (x cos t + y sin t, y cos t -
x sin t), x backwards: dead loads hold it by sum F x, live ones push it by lambda sum F y. A load that kept its moment
about the centroid would not feel that the block leans.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from orchestrator.limit_analysis import LimitAnalysisSettings, analyse
from orchestrator.limit_analysis.gravity import associative_optimum, problem_of
from orchestrator.limit_analysis.search.elastic_contact import SPREAD, elastic_wall, moving_wall
from orchestrator.limit_analysis.search.rigid_pushover import rigid_pushover
from orchestrator.loads import DeadLoad, LiveLoad, LoadSettings, loads_on
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.wall import Block, Wall
from tests.support.limit_analysis_cases import box, tower, transformed

STIFF = 3.5e13
"""Pa"""
B, H = 0.5, 2.0
W = 20e3 * B * H
"""width and height of `tower(B, H)` in m, whose left foot is at -B/2, and its weight in N"""
ALONE = LimitAnalysisSettings(search_blocks=1, sequence_blocks=1)


def pushed_rigid(wall, load, elastic_modulus=STIFF):
    problem = replace(problem_of(wall, loads_on(wall.wall, load)), elastic_modulus=elastic_modulus)
    return rigid_pushover(problem, associative_optimum(problem).load_multiplier)


def rocking(dead, live, moved, angle=0.0):
    """Return the multiplier of a block that turns about its toe until its live forces have moved so far on average.

    dead, live: force, distance of its place from the toe backwards and upwards; angle: of live ones above the x axis.
    """
    along = np.array([np.cos(angle), np.sin(angle)])

    def place(x, y, turn):
        return -x * np.cos(turn) + y * np.sin(turn), y * np.cos(turn) + x * np.sin(turn)

    def mean(turn):
        ways = [(force, np.subtract(place(x, y, turn), (-x, y)) @ along) for force, x, y in live]
        return sum(force * way for force, way in ways) / sum(force for force, *_ in live)

    turn = brentq(lambda turn: mean(turn) - moved, 0.0, 0.5)
    holds = -sum(force * place(x, y, turn)[0] for force, x, y in dead)
    ends = [(force, place(x, y, turn)) for force, x, y in live]
    return holds / sum(force * (along[0] * y - along[1] * x) for force, (x, y) in ends)


def follows(found, expected, tolerance=1e-3):
    """Assert that a curve is that of a block which turns, from where it does."""
    turning = found.displacement > 2e-4
    assert turning.sum() >= 5
    assert found.displacement[-1] > 1e-2
    wanted = [expected(moved) for moved in found.displacement[turning]]
    assert found.multiplier[turning] == pytest.approx(wanted, abs=tolerance * found.peak)


@pytest.mark.parametrize("direction", ["+x", "-x"])
@pytest.mark.parametrize("inertia", [False, True])
@pytest.mark.parametrize("x", [0.15, 0.35])
def test_a_force_on_top_leans_with_its_block(x, inertia, direction):
    """20 kN for 10 kN, a tenth of a metre to either side of the middle."""
    wall = tower(B, H, friction=3.0)
    load = LoadSettings(direction, dead=(DeadLoad((1,), force=2 * W, at=(x - B / 2, H), inertia=inertia),))
    back = B - x if direction == "+x" else x
    own, extra = (W, B / 2, H / 2), (2 * W, back, H)
    found = analyse(wall, ALONE, loads_on(wall.wall, load), STIFF)
    displacement, multiplier = found.rigid_curve.T
    turning = displacement > 2e-4
    live = (own, extra) if inertia else (own,)
    wanted = [rocking((own, extra), live, moved) for moved in displacement[turning]]
    assert displacement[-1] > 1e-2
    assert multiplier[turning] == pytest.approx(wanted, abs=1e-3 * multiplier.max())


def test_a_line_load_leans_with_its_block():
    """Over the left half of the top, with inertia: its resultant is above the quarter point."""
    load = DeadLoad((1,), line_load=W / (B / 2), stretch=(-B / 2, 0.0), inertia=True)
    both = (W, B / 2, H / 2), (W, 0.75 * B, H)
    follows(pushed_rigid(tower(B, H, friction=3.0), LoadSettings(dead=(load,))), lambda u: rocking(both, both, u))


def test_masses_times_height_push_where_they_are_drawn_to():
    """By mass x height a floor of the block's weight has twice as much of the live load; it moves twice as far."""
    floor_at_the_left_end = DeadLoad((1,), force=W, at=(-B / 2, H), inertia=True)
    load = LoadSettings(distribution="mass_height", dead=(floor_at_the_left_end,))
    own, floor = (W, B / 2, H / 2), (W, B, H)
    live = (W * 2 / 3, B / 2, H / 2), (W * 4 / 3, B, H)
    follows(pushed_rigid(tower(B, H, friction=3.0), load), lambda u: rocking((own, floor), live, u))


@pytest.mark.parametrize("degrees", [20.0, -20.0])
def test_an_inclined_live_load_of_a_floor_keeps_its_direction(degrees):
    angle = np.radians(degrees)
    load = LoadSettings(inclination=angle, dead=(DeadLoad((1,), force=W, at=(0.1 - B / 2, H), inertia=True),))
    both = (W, B / 2, H / 2), (W, B - 0.1, H)
    follows(pushed_rigid(tower(B, H, friction=3.0), load), lambda u: rocking(both, both, u, angle))


def test_a_live_force_on_the_block_alone_leaves_the_floor_on_it_a_dead_load():
    load = LoadSettings(
        distribution="per_block", live=(LiveLoad((1,), 1e3),), dead=(DeadLoad((1,), force=W, at=(0.1, H)),)
    )
    own, floor = (W, B / 2, H / 2), (W, B / 2 - 0.1, H)
    follows(pushed_rigid(tower(B, H, friction=3.0), load), lambda u: rocking((own, floor), ((1e3, *own[1:]),), u))


WIDTH, HEIGHT, DEEP, TOP = 0.5, 4.0, 0.5, 300e3
"""of columns under a floor, in m and N"""


def column(stones, cap=0.0, wide=WIDTH):
    """Stones of 20 kN/m3 up to HEIGHT; with a cap so thick, half above and half below that, of the floor's weight;
    wide: at the top of one stone."""
    height = HEIGHT / stones
    outlines = [np.array(box(0.0, height * level, WIDTH, height)) for level in range(stones)]
    if wide < WIDTH:
        outlines[-1][2:, 0] = 0.5 * (WIDTH + wide), 0.5 * (WIDTH - wide)
    weights = [20e3] * stones
    if cap:
        outlines[-1][2:, 1] -= cap / 2
        outlines.append(np.array(box(0.0, HEIGHT - cap / 2, WIDTH, cap)))
        weights.append(TOP / (WIDTH * cap * DEEP))
    blocks = [Block(0, np.array(box(-1.0, -0.2, 5.0, 0.2)), True, 20e3)]
    blocks += [Block(k, *one) for k, one in enumerate(zip(outlines, [False] * len(outlines), weights, strict=True), 1)]
    return find_joints(Wall("column", tuple(blocks), DEEP, 0.7), JointSettings())


def floor_on(stones, x=0.5 * WIDTH):
    return LoadSettings(dead=(DeadLoad((stones,), force=TOP, at=(x, HEIGHT), inertia=True),))


def springy(modulus):
    """Return the largest multiplier of one stone with the floor on it, on three springs without tension (1/6, 2/3, 1/6
    of the base) that stand for half its height: over turns, each balanced for the weight of both."""
    loads = (20e3 * WIDTH * HEIGHT * DEEP, HEIGHT / 2), (TOP, HEIGHT)
    weight = sum(force for force, _ in loads)
    springs = SPREAD * modulus * WIDTH * DEEP / (HEIGHT / 2) * np.array([1.0, 4.0, 1.0]) / 6.0

    def bears(turn):
        places = WIDTH * np.array([-0.5, 0.0, 0.5])
        there, sinks = places * np.cos(turn), places * np.sin(turn)
        level = brentq(lambda v: (springs * np.maximum(v + sinks, 0.0)).sum() - weight, -1.0, 1.0)
        carried = springs * np.maximum(level + sinks, 0.0)
        x, y = carried @ there / weight, -(carried @ sinks) / weight
        holds = sum(force * (x - height * np.sin(turn)) for force, height in loads)
        return holds / sum(force * (height * np.cos(turn) - y) for force, height in loads)

    return max(bears(turn) for turn in np.linspace(1e-4, 0.1, 2000))


@pytest.mark.parametrize("modulus", [3.5e9, 1e9, 0.35e9])
def test_a_floor_takes_from_a_column_on_springs_what_its_lean_takes(modulus):
    """With a floor that kept its moment it would bear 0.0517 of 1 GPa, for 0.0399."""
    found = pushed_rigid(column(1), floor_on(1), modulus)
    assert found.is_past
    assert found.peak == pytest.approx(springy(modulus), rel=0.015)


@pytest.mark.parametrize("stones", [1, 4])
@pytest.mark.parametrize("modulus", [3.5e9, 1e9, 0.35e9])
def test_a_floor_is_what_a_thin_heavy_block_in_its_place_is(stones, modulus):
    """As a load it bore up to 60 % more than as a block of 4 cm (0.0253 for 0.0158: four stones of 0.35 GPa)."""
    load, block = (
        pushed_rigid(column(stones, cap), load, modulus).peak
        for cap, load in ((0.0, floor_on(stones)), (0.04, LoadSettings()))
    )
    assert load == pytest.approx(block, rel=0.015)


def test_a_mirrored_wall_with_a_floor_beside_its_middle_has_the_same_curve():
    def curve(direction, x):
        wall = tower(B, 1.0, 4, friction=3.0)
        floor = DeadLoad((4,), force=300e3, at=(x, 4.0), inertia=True)
        return analyse(wall, ALONE, loads_on(wall.wall, LoadSettings(direction, dead=(floor,))), 1e9).rigid_curve

    assert curve("-x", 0.05) == pytest.approx(curve("+x", -0.05), rel=1e-6, abs=1e-9)
    assert curve("+x", 0.05)[:, 1].max() < 0.9 * curve("+x", -0.05)[:, 1].max(), "nearer to the toe"


def test_a_column_with_a_floor_a_tenth_of_its_size_has_the_same_curve_up_to_its_peak():
    """Lengths and modulus times s, forces per metre of thickness times s^2: all angles are the same."""

    def curve(size, modulus):
        wall = transformed(tower(B, 1.0, 3, friction=3.0), lambda polygon: size * polygon)
        floor = DeadLoad((3,), force=60e3 * size**2, at=(0.05 * size, 3.0 * size), inertia=True)
        return pushed_rigid(wall, LoadSettings(dead=(floor,)), modulus * size)

    large, small = (curve(size, 1e8) for size in (1.0, 0.1))
    assert small.peak == pytest.approx(large.peak, rel=1e-6)
    assert large.peak < 0.9 * curve(1.0, STIFF).peak
    rising = slice(int(large.multiplier.argmax()) + 1)
    assert small.displacement[rising] == pytest.approx(0.1 * large.displacement[rising], rel=1e-4, abs=1e-9)


def test_moments_follow_from_where_blocks_are():
    """The live load is the slope of the way that its points go, and both loads have the slopes that a step takes them
    to have: finite differences."""
    wall = tower(B, 1.0, 3)
    load = LoadSettings(
        inclination=0.4,
        dead=(DeadLoad((3,), force=5e3, at=(0.2, 3.0), inertia=True), DeadLoad((2,), force=3e3, at=(-0.2, 1.4))),
    )
    problem = problem_of(wall, loads_on(wall.wall, load))
    drawn = elastic_wall(problem.assemblage, problem.equilibrium, problem.friction)
    moved = moving_wall(problem.assemblage, problem.equilibrium, problem.friction).moved_loads
    at_first = moved.linearised(np.zeros(9))
    assert at_first.dead == pytest.approx(drawn.problem.dead, abs=1e-15)
    assert at_first.live == pytest.approx(drawn.problem.live, abs=1e-15)
    rng = np.random.default_rng(3)
    far, little = 0.3 * rng.normal(size=9) / moved.radians, 1e-5 * rng.normal(size=9) / moved.radians
    before, there, after = (moved.linearised(far + sign * little) for sign in (-1.0, 0.0, 1.0))
    work = float(moved.live @ little) + 0.5 * (moved.beyond(far + little) - moved.beyond(far - little))
    assert work == pytest.approx(float(there.live @ little), abs=1e-8 * np.abs(little).max())
    for one, (ahead, behind) in enumerate(zip((after.dead, after.live), (before.dead, before.live), strict=True)):
        changed = there.at(far + little)[one] - there.at(far - little)[one]
        assert np.abs(changed).max() > 1e-7
        assert changed == pytest.approx(ahead - behind, abs=1e-12)


@pytest.mark.parametrize("part", [0.8, 0.25, 0.05])
@pytest.mark.parametrize("wide", [WIDTH, 0.1])
def test_a_column_that_buckles_under_its_floor_bears_nothing(wide, part):
    """A foot of three springs, k in all, resists a turn with k (1/6 + 1/6) (b/2)^2; weight and floor overturn it by
    W h + F H. What is softer has equilibria under a small load all the same, as a stick that is balanced leans against
    a push; of a block that tapers, with the floor far from its centroid, implicit steps come to them."""
    wall = column(1, wide=wide)
    weight, middle = 10e3 * (WIDTH + wide) * HEIGHT * DEEP, HEIGHT * (WIDTH + 2 * wide) / (WIDTH + wide) / 3.0
    foot = SPREAD * WIDTH * DEEP / middle * (WIDTH / 2) ** 2 / 3.0
    critical = (weight * middle + TOP * HEIGHT) / foot
    assert pushed_rigid(wall, floor_on(1), part * critical) is None
    found = pushed_rigid(wall, floor_on(1), 1.5 * critical)
    assert found is not None
    assert found.peak > 0.0
    assert (found.displacement[1:] > 0.0).all()
