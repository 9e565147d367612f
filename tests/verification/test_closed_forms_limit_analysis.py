"""Micro limit analysis against closed forms: blocks, towers, slopes, cohesion, arches, and what scaling must leave.

Tolerance 1e-6 throughout (issue 2), on the associative state and on both non-associative ones: in all these problems
one joint slides or one block topples, so dilation does no work and the three multipliers coincide.
"""

from __future__ import annotations

from dataclasses import replace
from math import atan, cos, pi, radians, sin, tan

import numpy as np
import pytest

from orchestrator.basis.arrays import read_only
from orchestrator.basis.errors import CaseError
from orchestrator.limit_analysis import LimitAnalysisSettings, analyse
from orchestrator.limit_analysis.gravity import associative_optimum, problem_of
from orchestrator.limit_analysis.paper.equilibrium import assemble_equilibrium
from orchestrator.limit_analysis.paper.linear_program import solve_gravity_lp
from orchestrator.limit_analysis.paper.yield_conditions import coulomb
from orchestrator.loads import LiveLoad, LoadSettings, loads_on
from orchestrator.masonry.block_properties import ELASTIC_MODULUS, block_weights
from orchestrator.masonry.interfaces import straight_interfaces
from tests.support.limit_analysis_cases import assemblage_of, box, case, mirrored, transformed, weight_along


def multipliers(assemblage, load_direction=1, stiffer=1.0):
    """Associative and sequence multiplier, and that which loading meets; stiffer: stones than they are by default.

    Large displacements have their own images of a wall: test_rigid_pushover.py.
    """
    loads = weight_along(assemblage, load_direction)
    small = LimitAnalysisSettings(large_displacements=False)
    found = analyse(assemblage, small, loads, stiffer * ELASTIC_MODULUS)
    assert found.headline.converged
    return [state.load_multiplier for state in (found.associative, found.sequence, found.headline)]


def floor(width=6.0):
    return box(-width / 2, -0.5, width, 0.5)


def tower(*sizes):
    """Blocks (width, height) on top of each other, centred, on a floor."""
    levels = np.cumsum([0.0] + [height for _, height in sizes])
    return [floor(), *(box(-w / 2, y, w, h) for (w, h), y in zip(sizes, levels, strict=False))]


def on_slope(width, height, angle):
    """A block of width x height on a plane that rises with `angle` in +x, exact to rounding (unlike the data file)."""
    turn = np.array([[cos(angle), -sin(angle)], [sin(angle), cos(angle)]])
    return [np.array(polygon) @ turn.T for polygon in (floor(), box(-width / 2, 0.0, width, height))]


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize(
    ("width", "height", "friction"), [(0.5, 1.0, 0.65), (1.0, 1.0, 0.65), (0.4, 0.175, 0.3), (1.0, 1.5, 0.7)]
)
def test_single_block_slides_or_overturns(width, height, friction, direction):
    expected = min(friction, width / height)
    assert multipliers(assemblage_of(tower((width, height)), friction=friction), direction) == pytest.approx(
        [expected] * 3, abs=1e-6
    )


@pytest.mark.parametrize(("blocks", "width", "height", "friction"), [(5, 1.0, 0.5, 0.65), (3, 2.0, 0.5, 0.4)])
def test_tower_of_equal_blocks(blocks, width, height, friction):
    expected = min(friction, width / (blocks * height))
    assert multipliers(assemblage_of(tower(*[(width, height)] * blocks), friction=friction)) == pytest.approx(
        [expected] * 3, abs=1e-6
    )


def test_two_block_stack_topples_at_the_weaker_joint():
    """Slender block on a wide one: the upper one alone, b/h; wide on slender: both about the lower toe."""
    slender_above = assemblage_of(tower((2.0, 0.5), (0.4, 1.0)))
    assert multipliers(slender_above) == pytest.approx([0.4] * 3, abs=1e-6)
    b, h, B, H = 0.5, 1.0, 1.5, 0.5
    lower, upper = b * h, B * H
    both = (lower + upper) * b / 2 / (lower * h / 2 + upper * (h + H / 2))
    wide_above = assemblage_of(tower((b, h), (B, H)))
    assert both < min(0.65, B / H)
    assert multipliers(wide_above) == pytest.approx([both] * 3, abs=1e-6)


def test_stack_slides_at_its_smoothest_joint():
    stack = assemblage_of(tower((2.0, 0.4), (2.0, 0.4), (2.0, 0.4)))
    friction = np.where(stack.joints.i == 1, 0.25, 0.6)
    assert friction.tolist().count(0.25) == 1
    assert multipliers(replace(stack, joints=replace(stack.joints, friction=read_only(friction)))) == pytest.approx(
        [0.25] * 3, abs=1e-6
    )


@pytest.mark.parametrize(("cohesion", "expected"), [(4e3, 0.3 + 4e3 * 0.8 / (0.8 * 0.5 * 20e3)), (60e3, 0.8 / 0.5)])
def test_cohesion_adds_to_sliding_but_not_to_overturning(cohesion, expected):
    """mu + c b/W (here per metre of thickness, also for a thickness of 0.1 m), at most b/h: no tension."""
    for thickness in (1.0, 0.1):
        block = assemblage_of(tower((0.8, 0.5)), friction=0.3, thickness=thickness)
        glued = replace(block, joints=replace(block.joints, cohesion=read_only([cohesion])))
        assert multipliers(glued) == pytest.approx([expected] * 3, abs=1e-6)


@pytest.mark.parametrize(("direction", "sign"), [(1, 1), (-1, -1)])
def test_block_on_ten_degree_slope(direction, sign):
    """tan(phi + 10 deg) uphill, tan(phi - 10 deg) downhill."""
    expected = tan(atan(0.65) + sign * radians(10))
    flat = assemblage_of(on_slope(2.5, 0.3, radians(10)))
    assert multipliers(flat, direction) == pytest.approx([expected] * 3, abs=1e-6)


@pytest.mark.parametrize("direction", [1, -1])
def test_slender_block_on_slope_overturns(direction):
    """About the toe ahead: horizontal over vertical distance from toe to centroid."""
    width, height, angle = 0.3, 1.0, radians(10)
    toe = np.array([cos(angle), sin(angle)]) * direction * width / 2
    centroid = np.array([-sin(angle), cos(angle)]) * height / 2
    expected = direction * (toe - centroid)[0] / (centroid - toe)[1]
    slender = assemblage_of(on_slope(width, height, angle))
    assert multipliers(slender, direction) == pytest.approx([expected] * 3, abs=1e-6)


@pytest.mark.parametrize(("angle", "friction"), [(10, 0.4), (15, 0.3), (20, 0.2), (30, 0.3), (40, 0.2), (30, 0.5)])
def test_two_voussoirs_in_a_wedge(angle, friction):
    """Two halves of a wedge between abutments inclined by +-t: one slides down, the other up, and along each other.

    Equilibrium of each half across the reaction of its abutment, H between them, W the weight of one, tan p = mu:
        lambda W + W tan(t - p) = H (1 + mu tan(t - p)),      lambda W = W tan(t + p) - H (1 - mu tan(t + p))
    """
    t, height = radians(angle), tan(radians(angle))
    down, up = tan(t - atan(friction)), tan(t + atan(friction))
    ratio = (1 - friction * up) / (1 + friction * down)
    expected = (up - ratio * down) / (1 + ratio)
    left, right = [(0, 0), (0, height), (-1, height)], [(0, 0), (1, height), (0, height)]
    below = [(0, 0), (1, height), (1.5, height), (1.5, -0.5), (0, -0.5)]
    abutments = [[(-x, y) for x, y in below], below]
    for direction in (1, -1):
        wedge = assemblage_of([*abutments, left, right], fixed=(0, 1), friction=friction)
        assert multipliers(wedge, direction) == pytest.approx([expected] * 3, abs=1e-6)


def arch(voussoirs, thickness_ratio):
    """Semicircular arch of mean radius 1 between two supports, straight voussoirs with radial joints."""
    angles = np.linspace(0.0, pi, voussoirs + 1)
    rays = np.column_stack([np.cos(angles), np.sin(angles)])
    inner, outer = (1 - thickness_ratio / 2) * rays, (1 + thickness_ratio / 2) * rays
    stones = [
        [inner[k], outer[k], outer[k + 1], inner[k + 1]]
        for k in range(voussoirs)
    ]  # fmt: skip
    return assemblage_of([box(0.5, -0.5, 1.0, 0.5), box(-1.5, -0.5, 1.0, 0.5), *stones], fixed=(0, 1), friction=0.6)


@pytest.mark.parametrize(("voussoirs", "least"), [(27, 0.10672), (101, 0.10745)])
def test_semicircular_arch_needs_its_least_thickness(voussoirs, least):
    """Cocchetti and Rizzi 2020 for the continuous arch, docs/theory.md for straight voussoirs; t/r to 5e-5."""
    with pytest.raises(CaseError, match="cannot stand under its own weight"):
        analyse(arch(voussoirs, least - 5e-5))
    assert 0.0 < analyse(arch(voussoirs, least + 5e-5)).associative.load_multiplier < 1e-3


def hinges(assemblage, rates):
    """Places in degrees from the crown of the joints that open, and +1 where the extrados opens, -1 the intrados."""
    opening = rates[:, :2]
    turns = np.flatnonzero(np.ptp(opening, axis=1) > 1e-3 * np.abs(opening).max())
    found = []
    for k in turns:
        ends = np.array([assemblage.joints.start[k], assemblage.joints.end[k]])
        x, y = assemblage.joints.centroid[k]
        open_radius, closed_radius = np.linalg.norm(ends[np.argsort(opening[k])[::-1]], axis=1)
        found.append((float(np.degrees(np.arctan2(x, y))), 1 if open_radius > closed_radius else -1))
    return sorted(found)


def test_semicircular_arch_of_least_thickness_has_its_hinges_where_the_thrust_line_touches():
    """Milankovitch 1907: crown (intrados opens), 54.5 degrees from it (extrados opens), springings (intrados opens).

    Without sliding; half a voussoir of 101 is 0.9 degrees, and the crown lies in the middle of one: two joints turn.
    """
    thin = arch(101, 0.1074)
    equilibrium = assemble_equilibrium(thin)
    missing, velocities = solve_gravity_lp(equilibrium, coulomb(thin))
    rates = equilibrium.joint_rates(velocities)
    assert missing > 0
    assert np.abs(rates[:, 2]).max() < 1e-3 * np.abs(rates[:, :2]).max()
    found = hinges(thin, rates)
    for place, opens in ((-90.0, -1), (-54.5, 1), (0.0, -1), (54.5, 1), (90.0, -1)):
        near = [sign for where, sign in found if abs(where - place) < 2.0]
        assert near, f"no hinge at {place} degrees: {found}"
        assert set(near) == {opens}
    assert all(min(abs(abs(where) - place) for place in (0.0, 54.5, 90.0)) < 2.0 for where, _ in found)


def test_arch_under_horizontal_load_turns_about_four_hinges_on_alternating_sides():
    wall = arch(27, 0.15)
    mechanism = analyse(wall).associative.mechanism
    found = hinges(wall, np.column_stack([mechanism.opening, mechanism.slip]))
    assert len(found) == 4
    assert [sign for _, sign in found] in ([1, -1, 1, -1], [-1, 1, -1, 1])


@pytest.mark.parametrize("scaling", [1e-3, 7.0, 1e3])
def test_scaling_lengths_leaves_the_multipliers(scaling):
    """Young's modulus is scaled as weights are over areas: stones are pressed by the same part of themselves."""
    wall = case("ferris_tinloi_wall4")
    grown = transformed(wall, lambda polygon: scaling * polygon)
    if scaling < 1e-2:  # joints are shorter than the least length of a joint then: scale the assemblage itself
        blocks = tuple(replace(block, polygon=read_only(scaling * block.polygon)) for block in wall.wall.blocks)
        ends = scaling * wall.joints.start, scaling * wall.joints.end
        joints = straight_interfaces(wall.joints.i, wall.joints.j, *ends, wall.wall.thickness, wall.joints.friction)
        grown = replace(wall, wall=replace(wall.wall, blocks=blocks), joints=joints)
    assert multipliers(grown, stiffer=scaling) == pytest.approx(multipliers(wall), abs=1e-7)


@pytest.mark.parametrize("scaling", [1e-4, 3.0, 1e4])
def test_scaling_weights_leaves_the_multipliers(scaling):
    wall = case("ferris_tinloi_wall4")
    blocks = tuple(replace(block, unit_weight=scaling * block.unit_weight) for block in wall.wall.blocks)
    heavier = replace(wall, wall=replace(wall.wall, blocks=blocks))
    assert multipliers(heavier, stiffer=scaling) == pytest.approx(multipliers(wall), abs=1e-7)


@pytest.mark.parametrize("name", ["ferris_tinloi_wall3", "arch27_t0107", "orduna_panel_set13"])
def test_mirrored_wall_has_the_value_of_the_opposite_load(name):
    wall, rigid = case(name), 1e5
    assert multipliers(mirrored(wall), -1, rigid) == pytest.approx(multipliers(wall, stiffer=rigid), abs=1e-7)


def test_mirrored_load_on_a_wall_without_symmetry():
    """On a slope the two directions differ, so the mirror image is a real test of signs."""
    slope = assemblage_of(on_slope(2.5, 0.3, radians(10)))
    uphill, downhill = multipliers(slope, 1), multipliers(slope, -1)
    assert uphill[0] > 2 * downhill[0]
    assert multipliers(mirrored(slope), -1) == pytest.approx(uphill, abs=1e-9)
    assert multipliers(mirrored(slope), 1) == pytest.approx(downhill, abs=1e-9)


@pytest.mark.parametrize("width", [0.1, 0.03, 0.02, 0.01, 0.003])
@pytest.mark.parametrize("alone", [False, True])
def test_a_small_stone_on_a_large_one_overturns_at_its_own_slenderness(width, alone):
    """0.66 to 0.0006 % of the dead load, pushed with the wall or `alone`. Measured by the mean of both, a stone of 3e-4
    of it had no optimum, one of 2e-6 a bound of 0.57 for 0.5, and pushed alone a headline of 0.71."""
    stone = box(1.0, 1.0, width, 2.0 * width)
    assemblage = assemblage_of([floor(), box(0.0, 0.0, 3.0, 1.0), stone], friction=0.7)
    weight = block_weights(assemblage.wall)[2]
    loads = LoadSettings(distribution="per_block", live=(LiveLoad((2,), 1.0),)) if alone else LoadSettings()
    found = analyse(assemblage, loads=loads_on(assemblage.wall, loads))
    assert found.associative.load_multiplier == pytest.approx(0.5 * weight if alone else 0.5, rel=1e-6)
    if alone:
        assert found.headline.converged
        assert found.headline.load_multiplier == pytest.approx(0.5 * weight, rel=1e-6)
        assert found.rigid_peak == pytest.approx(0.5 * weight, rel=2e-4)
        return
    (failure,) = found.local_failures
    assert failure.stones == (2,)
    assert failure.multipliers == pytest.approx((0.5, 0.5), rel=1e-6)
    assert found.headline.load_multiplier == pytest.approx(0.7, rel=1e-6)


@pytest.mark.parametrize("size", [0.02, 0.01, 0.008, 0.005, 0.002])
@pytest.mark.parametrize("width", [2.0, 1.0])
def test_small_stones_under_a_large_one_carry_it(size, width):
    """Two pinnings of 1e-4 to 1e-6 of its weight, far apart: it slides. Where the solver scaled the linear program by
    itself, and none of it knew of forces and lengths, half of such walls had no optimum."""
    feet = [box(0.0, 0.5, size, size), box(width - size, 0.5, size, size)]
    stones = [floor(), box(0.0, 0.0, width, 0.5), *feet, box(0.0, 0.5 + size, width, 0.5)]
    assemblage = assemblage_of(stones, friction=0.7)
    problem = problem_of(assemblage)
    assert associative_optimum(problem).load_multiplier == pytest.approx(0.7, rel=1e-6)


@pytest.mark.parametrize(("width", "height"), [(0.01, 0.03), (0.001, 0.01)])
def test_a_stone_lighter_than_what_joints_are_smooth_by_is_a_local_failure(width, height):
    """3e-5 and 1e-6 of the weight under it: the path comes past its bound without it, which no state does."""
    stones = [floor(), box(0.0, 0.0, 3.0, 3.0), box(1.0, 3.0, width, height)]
    found = analyse(assemblage_of(stones, friction=0.7))
    (failure,) = found.local_failures
    assert failure.stones == (2,)
    assert failure.multipliers == pytest.approx((width / height,) * 2, rel=1e-6)
    assert found.headline.load_multiplier == pytest.approx(0.7, rel=1e-6)
