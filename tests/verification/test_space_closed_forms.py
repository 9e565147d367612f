"""Associative multipliers in space against closed forms, and walls whose values two programs share (cases 1 to 14 of
the out-of-plane acceptance list)."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
import shapely

from orchestrator.geometry.polyhedra import box, rotation
from orchestrator.limit_analysis.gravity import refuse_what_cannot_be_analysed
from orchestrator.space.analysis import analyse
from orchestrator.space.contacts import find_joints
from orchestrator.space.equilibrium import torsion_factors
from orchestrator.space.generators.shapes import Plan, Stones, box_wall, l_wall, straight_wall, t_wall, u_wall
from orchestrator.space.loads import SpaceLoadSettings, loads_on
from orchestrator.space.ties import Tie, with_ties
from tests.support.limit_analysis_cases import case, weight_along
from tests.support.paths import DATA
from tests.support.space_walls import (
    associative,
    block_on_ground,
    couple_that_twists,
    extruded,
    hollow_pier,
    of_assemblage,
    turned,
    twist,
    v_groove,
    wall_of,
)

S = Stones()
WALLS = {
    "U(4,2,8)": (u_wall(Plan(4, 2, 8), S), 68, 180, 0.34229),
    "L(4,2,8)": (l_wall(Plan(4, 2, 8), S), 52, 134, 0.26676),
    "T(4,2,8)": (t_wall(Plan(4, 2, 8), S), 60, 160, 0.26676),
    "T with straight joints": (t_wall(Plan(4, 2, 8), S, straight_joints=True), 52, 131, 0.26676),
    "box(4,3,8)": (box_wall(Plan(4, 3, 8), S), 112, 322, 0.41442),
    "U(6,4,12)": (u_wall(Plan(6, 4, 12), S), 174, 484, 0.32276),
    "U(8,3,6)": (u_wall(Plan(8, 3, 6), S), 87, 235, 0.35567),
    "L(6,4,12)": (l_wall(Plan(6, 4, 12), S), 126, 344, 0.21675),
}


@pytest.mark.parametrize(("degrees", "expected"), [(0, 0.4), (45, 0.282843), (60, 0.230940), (90, 0.2)])
def test_a_block_overturns_over_the_side_that_is_nearest_along_the_load(degrees, expected):
    """Case 1: min(mu, x / (h cos psi), y / (h sin psi)); Gauss points instead of corners would give 0.58 of it."""
    psi = np.radians(degrees)
    found = associative(block_on_ground(0.4, 0.2, 1.0, 0.7), (np.cos(psi), np.sin(psi), 0.0))
    assert found.load_multiplier == pytest.approx(expected, abs=1e-6)
    by_angle = associative(block_on_ground(0.4, 0.2, 1.0, 0.7), None, angle=psi)
    assert by_angle.load_multiplier == pytest.approx(expected, abs=1e-6)


def test_a_flat_block_slides_alike_in_all_directions():
    """Case 2: mu. A pyramid of eight sides instead of the cone has 0.924 mu in its worst direction."""
    for psi in 2 * np.pi * np.arange(16) / 16 + 0.1:
        found = associative(block_on_ground(1.0, 0.7, 0.1, 0.53), (np.cos(psi), np.sin(psi), 0.0))
        assert found.load_multiplier == pytest.approx(0.53, abs=1e-6)


@pytest.mark.parametrize(
    ("ratio", "corners", "uniform"), [(1.0, 0.707107, 0.38260), (2.0, 1.118034, 0.59323), (4.0, 2.061553, 1.06078)]
)
def test_a_block_is_twisted_on_its_bed(ratio, corners, uniform):
    """Case 3: mu N d / 2 with forces at the corners, mu N r under uniform pressure; both over mu N b, b the short
    side."""
    assert twist(ratio, "corners") == pytest.approx(corners, abs=1e-5)
    assert twist(ratio, "uniform") == pytest.approx(uniform, abs=1e-5)


@pytest.mark.parametrize("inner", [0.3, 0.6, 0.8, 0.9])
def test_a_slab_is_twisted_on_a_hollow_pier(inner):
    """On a square with a square hole of a part q of its side b: mu N b 0.38260 (1 - q^3) / (1 - q^2) under uniform
    pressure, as the distances of both squares have integrals 0.38260 b^3; the hole takes nothing from the corners."""
    side = 0.7
    shapes = [hollow_pier(side, inner * side), box((-1.0, -1.0, 0.0), (1.0, 1.0, 0.2))]
    wall = wall_of(shapes, 0.4)
    (joint,) = find_joints(wall).joints.holes
    assert len(joint) == 1
    assert couple_that_twists(wall, "corners") / side == pytest.approx(0.707107, abs=1e-5)
    mean = 0.38260 * (1.0 - inner**3) / (1.0 - inner**2)
    assert couple_that_twists(wall, "uniform") / side == pytest.approx(mean, abs=2e-5)


def test_a_hole_away_from_the_middle_is_told_from_one_of_the_same_area_in_it():
    """Two joints of one outline and one area: the mean distances are those of a grid."""
    grid = np.stack(np.meshgrid(*np.linspace(-0.5, 0.5, 1001)[None].repeat(2, 0)), -1).reshape(-1, 2)
    found, expected = [], []
    for height, width in ((0.4, 0.4), (0.2, 0.8)):
        void = shapely.box(-0.5 * width, -0.5 * height, 0.5 * width, 0.5 * height)
        solid = grid[~shapely.contains_xy(void, grid[:, 0], grid[:, 1])]
        expected.append(np.linalg.norm(solid, axis=1).mean() / 0.5**0.5)
        pier, slab = hollow_pier(1.0, 1.0), box((-1.0, -1.0, 0.0), (1.0, 1.0, 0.2))
        vertices = pier.vertices.copy()
        vertices[8:, :2] *= [width, height]
        found.append(torsion_factors(find_joints(wall_of([replace(pier, vertices=vertices), slab], 0.4)).joints)[0])
    assert found == pytest.approx(expected, abs=2e-3)
    assert abs(found[0] - found[1]) > 0.01


@pytest.mark.parametrize("off", [0.0, 1e-7, 1e-6, 1e-5])
def test_corners_that_a_drawing_has_micrometres_apart_are_one_point_of_contact(off):
    """Two stones of 0.4 m: the upper one's corners lie inside and outside the lower one's by turns."""
    lower, upper = box((0.0, 0.0, 0.0), (0.4, 0.4, 0.2)), box((0.0, 0.0, 0.2), (0.4, 0.4, 0.4))
    vertices = upper.vertices + off * np.array([[1, -1, 0], [1, 1, 0], [-1, 1, 0], [-1, -1, 0]] * 2)
    joints = find_joints(wall_of([lower, replace(upper, vertices=vertices)], 0.4)).joints
    assert len(joints.corners(0)) == 4


def test_torsion_factor_of_other_shapes():
    """A triangle's and a hexagon's mean distance from the centroid, integrated on a grid of a million points."""
    hexagon = np.array([[np.cos(a), np.sin(a)] for a in np.pi / 3 * np.arange(6)])
    for polygon in (hexagon, np.array([[0.0, 0.0], [1.0, 0.0], [0.2, 0.9]])):
        shape = extruded(polygon, 1.0)
        wall = wall_of([box((-3.0, -1.0, -3.0), (3.0, 0.0, 3.0)), shape], 0.5, up=np.array([0.0, 1.0, 0.0]))
        joints = find_joints(wall).joints
        grid = np.stack(np.meshgrid(*np.linspace(-1, 1, 801)[None].repeat(2, 0)), -1).reshape(-1, 2)
        edges, corner = np.roll(polygon, -1, axis=0) - polygon, polygon
        inside = np.all(
            [e[0] * (grid[:, 1] - c[1]) - e[1] * (grid[:, 0] - c[0]) > 0 for e, c in zip(edges, corner, strict=True)],
            axis=0,
        )
        points = grid[inside]
        mean = np.linalg.norm(points - points.mean(axis=0), axis=1).mean()
        if polygon is hexagon:
            assert torsion_factors(joints)[0] == pytest.approx(mean, abs=2e-3)  # corners lie at the distance 1
        else:
            lever = np.linalg.norm(
                polygon - polygon.mean(axis=0), axis=1
            ).mean()  # equal weights: a triangle's only ones
            assert torsion_factors(joints)[0] == pytest.approx(mean / lever, abs=2e-3)


def test_a_block_on_a_slope_pushed_across_it():
    """Case 4: sqrt(mu^2 cos^2 a - sin^2 a) for mu 0.6 and 20 degrees."""
    slope = rotation((0.0, 1.0, 0.0), np.radians(20.0))
    wall = block_on_ground(0.5, 0.5, 0.1, 0.6).moved(slope)
    found = associative(replace(wall, up=np.array([0.0, 0.0, 1.0])), "+y")
    assert found.load_multiplier == pytest.approx(0.448230, abs=1e-6)


@pytest.mark.parametrize(("degrees", "mu", "expected"), [(45, 0.5, 0.816497), (60, 0.5, 0.603023), (30, 0.2, 0.426401)])
def test_a_prism_in_a_groove_is_wedged_by_dilation(degrees, mu, expected):
    """Case 5: mu / sqrt(sin^2 b - mu^2 cos^2 b)."""
    found = associative(v_groove(np.radians(degrees), mu), "+y")
    assert found.load_multiplier == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize(
    "name",
    [
        "ferris_tinloi_wall1", "ferris_tinloi_wall3", "arch27_t0107", "orduna_panel_set11", "orduna_panel_set13",
        "single_block_sliding", "tower_5_blocks", "block_on_10deg_slope", "../../meshes/ferris_tinloi_wall6",
    ],
)  # fmt: skip
def test_plane_walls_as_prisms_have_the_plane_value(name):
    """Case 6: one feasible set is the sum over the thickness of the other."""
    from orchestrator.space.block_files import read_wall

    wall = case(name)
    plane = refuse_what_cannot_be_analysed(wall, weight_along(wall, 1)).load_multiplier
    found = associative(read_wall(DATA / f"{name}.json"), "+x").load_multiplier
    assert found == pytest.approx(plane, rel=1e-5)


@pytest.mark.parametrize(
    ("path", "expected"), [("ferris_tinloi_wall1", 0.095238), ("../../meshes/ferris_tinloi_wall6", 0.027211)]
)
def test_a_straight_wall_turns_about_its_foot(path, expected):
    """Case 7: t / H, whatever the bond."""
    from orchestrator.space.block_files import read_wall

    wall = read_wall(DATA / f"{path}.json")
    record = json.loads((DATA / f"{path}.json").read_text())
    height = max(y for b in record["blocks"] if not b.get("fixed") for _, y in b["polygon"])
    assert record["thickness"] / height == pytest.approx(expected, abs=1e-6)
    assert associative(wall, (0, 0, 1)).load_multiplier == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("name", WALLS)
def test_walls_with_returns(name):
    """Case 12, associative."""
    wall, blocks, joints, expected = WALLS[name]
    assemblage = find_joints(wall)
    assert (len(wall.blocks) - 1, assemblage.joints.count) == (blocks, joints)
    assert not assemblage.ignored
    assert of_assemblage(assemblage, "-y").load_multiplier == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize(
    ("name", "direction", "expected"),
    [
        ("U(4,2,8)", "+y", 0.52375), ("U(4,2,8)", "+x", 0.38446), ("L(4,2,8)", (-1.0, -1.0, 0.0), 0.37690),
        ("box(4,3,8)", (-1.0, -1.0, 0.0), 0.50701),
    ],
)  # fmt: skip
def test_walls_with_returns_under_other_loads(name, direction, expected):
    assert associative(WALLS[name][0], direction).load_multiplier == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize(("friction", "expected"), [(0.4, 0.32726), (0.8, 0.37853)])
def test_a_u_shaped_wall_with_other_friction(friction, expected):
    assert associative(u_wall(Plan(4, 2, 8), Stones(friction=friction)), "-y").load_multiplier == pytest.approx(
        expected, abs=1e-5
    )


@pytest.mark.parametrize(("plan", "expected"), [(Plan(4, 0, 8), 0.125), (Plan(6, 0, 12), 0.083333)])
def test_a_straight_wall_of_the_generator(plan, expected):
    wall = straight_wall(plan, S)
    assert associative(wall, "-y").load_multiplier == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("torsion", ["corners", "uniform"])
def test_nothing_changes_when_the_model_is_turned_mirrored_or_renumbered(torsion):
    """Case 14."""
    wall = u_wall(Plan(4, 2, 4), S)
    direction = np.array([0.3, -1.0, 0.1])
    expected = associative(wall, tuple(direction), torsion).load_multiplier
    for axis in ((1.0, 2.0, 3.0), (1.0, 0.0, 0.0), (-1.0, 0.4, 0.0)):
        other, turn = turned(wall, axis)
        assert associative(other, tuple(turn @ direction), torsion).load_multiplier == pytest.approx(expected, rel=1e-6)
    mirror = np.diag([-1.0, 1.0, 1.0])
    mirrored = associative(wall.moved(mirror), tuple(mirror @ direction), torsion).load_multiplier
    assert mirrored == pytest.approx(expected, rel=1e-6)
    shuffled = np.random.default_rng(3).permutation(len(wall.blocks))
    renumbered = replace(wall, blocks=tuple(replace(wall.blocks[k], id=n + 7) for n, k in enumerate(shuffled)))
    assert associative(renumbered, tuple(direction), torsion).load_multiplier == pytest.approx(expected, rel=1e-6)


def test_uniform_torsion_lowers_wide_facades_only():
    """Section A.3: U(4,2,8) stays at 0.34229, U(8,3,6) falls from 0.35567 to about 0.338."""
    assert associative(WALLS["U(4,2,8)"][0], "-y", "uniform").load_multiplier == pytest.approx(0.34229, abs=1e-4)
    assert associative(WALLS["U(8,3,6)"][0], "-y", "uniform").load_multiplier == pytest.approx(0.3376, abs=2e-3)


@pytest.mark.parametrize(("strength", "expected"), [(50.0, 0.25), (1e9, 1.0)])
def test_a_tie_holds_a_block_back(strength, expected):
    """A block of 1 kN, 0.2 x 0.2 x 1 m, tied back at its top to a wall behind it: it turns when
    lambda W h / 2 = W t / 2 + F_y h, that is 0.2 + 2 F_y / W, or its foot slides out under a strong tie: pressure at
    the heel, moments about the tie lambda W h / 2 = W t / 2 + mu W h, lambda = 2 mu + t / h."""
    weight = 0.2 * 0.2 * 20e3
    block, wall = box((0.0, 0.0, 0.0), (0.2, 0.2, 1.0)), box((-1.0, 0.0, 0.0), (-0.8, 0.2, 2.0))
    tied = wall_of([box((-3.0, -3.0, -1.0), (3.0, 3.0, 0.0)), wall, block], 0.4, supports=2)
    tie = Tie(blocks=(1, 2), start=(-0.8, 0.1, 1.0), end=(0.0, 0.1, 1.0), strength=strength * weight / 2000)
    assemblage = with_ties(find_joints(tied), (tie,))
    loads = loads_on(tied, SpaceLoadSettings(direction="+x"))
    analysis = analyse(assemblage, loads)
    turning, sliding = 0.2 + 2 * tie.strength / weight, 2 * 0.4 + 0.2
    assert min(turning, sliding) == pytest.approx(expected)
    assert analysis.headline.load_multiplier == pytest.approx(expected, abs=1e-5)
    assert analysis.associative.load_multiplier >= expected - 1e-6
    assert not analysis.states[0].error
    back = analyse(assemblage, loads_on(tied, SpaceLoadSettings(direction="-x")))
    assert back.headline.load_multiplier == pytest.approx(0.2, abs=1e-5), "a tie does not push"
