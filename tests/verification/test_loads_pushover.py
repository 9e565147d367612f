"""Loads beyond weight and its horizontal image in the FE pushover: the statics of one and two blocks, by hand."""

from __future__ import annotations

from math import cos, radians, sin

import numpy as np
import pytest

from orchestrator.app.pushed import push
from orchestrator.basis.errors import CaseError
from orchestrator.limit_analysis import analyse
from orchestrator.loads import DeadLoad, LiveLoad, LoadSettings, loads_on
from orchestrator.macroblocks.bodies import make_bodies
from orchestrator.macroblocks.criteria import one_body_per_block, partition_of
from orchestrator.masonry.block_properties import block_centroids, block_weights
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.masonry.wall import Block, Wall
from orchestrator.pushover.meshing import MeshSettings, mesh_bodies
from orchestrator.pushover.path.curve import pushover_increments
from orchestrator.pushover.settings import SteppingSettings
from orchestrator.pushover.solids.nodal_loads import nodal_loads
from tests.support.paths import DATA
from tests.support.pushover_chain import assemblage_of, model_of, rectangle, run, stack

TOWER = (0.4, 0.6)
W = 25e3 * 0.1 * 0.4 * 0.6
P = 1.5 * W
ON_TOP = DeadLoad((1,), line_load=P / 0.4)
AT_CENTROID = DeadLoad((1,), force=P)


def peak(*sizes, friction, loads, direction=1, large_displacement=False):
    model = model_of(
        stack(*sizes, friction=friction), direction=direction, loads=loads, large_displacement=large_displacement
    )
    result = run(model, final_displacement=2e-3)
    return result.peak, result


@pytest.mark.parametrize("load", [ON_TOP, AT_CENTROID])
@pytest.mark.parametrize("direction", [1, -1])
def test_dead_load_without_inertia_holds_a_block_down(load, direction):
    """Sliding at mu (W + P)/W; the base shear is that force in N."""
    found, result = peak(TOWER, friction=0.2, loads=LoadSettings(dead=(load,)), direction=direction)
    assert found == pytest.approx(0.2 * (W + P) / W, rel=1e-3)
    assert result.curve.base_shear_N.max() == pytest.approx(0.2 * (W + P), rel=1e-3)
    assert result.model.horizontal_load == pytest.approx(W, rel=1e-9)
    reaction = result.under_gravity.normal_force[: len(result.model.support_side)] @ result.model.support_side
    assert reaction == pytest.approx(W + P, rel=1e-7)


@pytest.mark.parametrize("large_displacement", [False, True])
def test_dead_load_against_overturning(large_displacement):
    """(W + P) b/2 = lambda W h/2 without inertia; with the load's own inertia on the top, W h/2 + P h."""
    b, h = TOWER
    held, _ = peak(TOWER, friction=3.0, loads=LoadSettings(dead=(ON_TOP,)), large_displacement=large_displacement)
    assert held == pytest.approx((W + P) * b / (W * h), rel=5e-3)
    inert = DeadLoad((1,), line_load=P / 0.4, inertia=True)
    pushed, _ = peak(TOWER, friction=3.0, loads=LoadSettings(dead=(inert,)), large_displacement=large_displacement)
    assert pushed == pytest.approx((W + P) * b / (W * h + 2 * P * h), rel=5e-3)


@pytest.mark.parametrize("kind", ["point", "stretch"])
def test_a_load_beside_the_middle_turns_a_block_about_its_toe(kind):
    """W b/2 + P (b - x) = lambda W h/2, P on the top at x from the left end."""
    (b, h), x, e = TOWER, 0.1, 0.05
    left = stack(TOWER, friction=5.0).blocks[1].polygon[:, 0].min()
    place = {"force": P, "at": (left + x, h)}
    if kind == "stretch":
        place = {"line_load": P / (2 * e), "stretch": (left + x - e, left + x + e)}
    held, _ = peak(TOWER, friction=5.0, loads=LoadSettings(dead=(DeadLoad((1,), **place),)))
    assert held == pytest.approx((W * b / 2 + P * (b - x)) / (W * h / 2), rel=5e-3)


@pytest.mark.parametrize("merged", [False, True])
def test_a_floor_at_a_level_is_carried_and_pushed_where_it_rests(merged):
    """Two blocks, a floor between them (at h, with inertia): lambda (2 W h + P h) = (2 W + P) b/2."""
    b, h, P = 0.4, 0.5, 700.0
    weight = 25e3 * 0.1 * b * h
    wall = stack((b, h), (b, h), friction=3.0)
    assemblage = assemblage_of(wall)
    partition = partition_of(assemblage, np.array([1, 0, 0])) if merged else one_body_per_block(assemblage)
    floor = LoadSettings(dead=(DeadLoad(level=h, line_load=P / b, inertia=True),))
    result = run(model_of(wall, partition, loads=floor), final_displacement=2e-3)
    assert result.peak == pytest.approx((2 * weight + P) * b / 2 / (2 * weight * h + P * h), rel=2e-3)
    assert result.model.weight == pytest.approx(2 * weight + P, rel=1e-9)
    reaction = result.under_gravity.normal_force @ result.model.support_side
    assert reaction == pytest.approx(2 * weight + P, rel=1e-7)


@pytest.mark.parametrize(("level", "width", "middle"), [(1.0, 0.6, 0.3), (0.9, 0.2, 0.7)])
def test_a_floor_on_a_step_of_a_top_stands_there(level, width, middle):
    """A stone with 0.6 m of top at y = 1 and 0.2 m at 0.9: resultant and its x on the nodes, by hand."""
    outline = np.array([[0, 0], [0.8, 0], [0.8, 0.9], [0.6, 0.9], [0.6, 1], [0, 1]], dtype=float)
    ground = np.array([[-1, -0.2], [2, -0.2], [2, 0], [-1, 0]], dtype=float)
    wall = Wall("stepped", (Block(0, ground, True, 25e3), Block(1, outline, False, 25e3)), 0.1, 0.6)
    loads = LoadSettings(dead=(DeadLoad(level=level, line_load=P),))
    bare, loaded = model_of(wall), model_of(wall, loads=loads)
    force = (bare.gravity - loaded.gravity)[: bare.front.nodes.size][1::3]
    assert force.sum() == pytest.approx(P * width)
    assert force @ bare.front.nodes[:, 0] == pytest.approx(P * width * middle)


def test_mass_times_height():
    """Two blocks: forces 1 : 3 of the resultant at h/2 and 3h/2, so at 5h/4."""
    b, h = 0.4, 0.5
    found, _ = peak((b, h), (b, h), friction=0.9, loads=LoadSettings(distribution="mass_height"))
    assert found == pytest.approx(0.4 * b / h, rel=1e-3)


def test_live_load_on_the_upper_block():
    """It overturns on the lower one: lambda F h/2 = W b/2, or both do: lambda F 3h/2 = 2 W b/2."""
    b, h, F = 0.4, 0.5, 800.0
    weight = 25e3 * 0.1 * b * h
    loads = LoadSettings(distribution="per_block", live=(LiveLoad((2,), F),))
    found, result = peak((b, h), (b, h), friction=3.0, loads=loads)
    assert found == pytest.approx(weight * b / (1.5 * h * F), rel=1e-3)
    assert result.model.horizontal_load == pytest.approx(F, rel=1e-9)


@pytest.mark.parametrize("direction", ["+x", "-x"])
@pytest.mark.parametrize(("lower", "upper"), [(-800.0, 1600.0), (1600.0, -800.0)])
def test_forces_against_the_direction(lower, upper, direction):
    """Both turn forwards about the base, or the upper one backwards: lambda |M| = N b/2; base shear of their sum."""
    b, h = 0.4, 0.5
    weight = 25e3 * 0.1 * b * h
    live = (LiveLoad((1,), lower), LiveLoad((2,), upper))
    moments = abs(lower * h / 2 + upper * 3 * h / 2), abs(upper * h / 2)
    expected = min(2 * weight * b / 2 / moments[0], weight * b / 2 / moments[1])
    loads = LoadSettings(direction, distribution="per_block", live=live)
    found, result = peak((b, h), (b, h), friction=3.0, loads=loads, direction=1 if direction == "+x" else -1)
    assert found == pytest.approx(expected, rel=1e-3)
    assert result.model.horizontal_load == pytest.approx(lower + upper, rel=1e-9)
    assert result.curve.base_shear_N.max() == pytest.approx(expected * (lower + upper), rel=2e-3)


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("angle", [-30, 20])
def test_inclined_live_load_on_a_sliding_block(angle, direction):
    """lambda cos a = mu (1 - lambda sin a); base shear lambda W cos a."""
    a, mu = radians(angle), 0.3
    _, result = peak((0.8, 0.3), friction=mu, loads=LoadSettings(inclination=a), direction=direction)
    expected = mu / (cos(a) + mu * sin(a))
    weight = 25e3 * 0.1 * 0.8 * 0.3
    assert result.curve.static.load_multiplier.max() == pytest.approx(expected, rel=2e-3)
    assert result.curve.static.base_shear_N.max() == pytest.approx(expected * weight * cos(a), rel=1e-3)


@pytest.mark.parametrize("macroblocks", [False, True])
def test_resultant_and_moment_are_those_of_limit_analysis(macroblocks):
    """Wall 3 with every kind of load, each stone a body or all stones one body: force and moment about the origin."""
    wall = read_blocks(DATA / "ferris_tinloi_wall3.json")
    free = [block.id for block in wall.blocks if not block.fixed]
    outline = {block.id: block.polygon for block in wall.blocks}
    left, right = outline[free[-1]][:, 0].min(), outline[free[-1]][:, 0].max()
    settings = LoadSettings(
        distribution="mass_height",
        dead=(
            DeadLoad((free[-1],), line_load=2e3, inertia=True),
            DeadLoad((free[3], free[7]), force=300.0),
            DeadLoad((free[-1],), line_load=5e3, inertia=True, stretch=(left, 0.7 * left + 0.3 * right)),
            DeadLoad((free[5],), force=700.0, inertia=True, at=tuple(outline[free[5]][2])),
        ),
    )
    assemblage = assemblage_of(wall)
    fixed = np.array([block.fixed for block in wall.blocks])
    partition = partition_of(assemblage, fixed.astype(int)) if macroblocks else one_body_per_block(assemblage)
    bodies = make_bodies(assemblage, partition)
    meshes = mesh_bodies(bodies, MeshSettings(size=0.3), None)
    found = nodal_loads(wall, bodies, meshes, settings)
    blocks, centroid, weight = loads_on(wall, settings), block_centroids(wall), block_weights(wall)
    x, y, z = meshes.nodes.T
    dead = np.array([found.dead.sum(), found.dead @ x, found.dead @ z])
    extra = -blocks.dead[~fixed, 1] - weight[~fixed]
    moment = -blocks.dead[~fixed, 2].sum() + extra @ centroid[~fixed, 0]
    assert dead == pytest.approx([extra.sum(), moment, extra.sum() * wall.thickness / 2], rel=1e-9)
    live = np.array([found.live.sum(), found.live @ y, found.live @ z])
    along, turning = blocks.live[~fixed, 0], blocks.live[~fixed, 2]
    expected = [along.sum(), along @ centroid[~fixed, 1] - turning.sum(), along.sum() * wall.thickness / 2]
    assert live == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("width", [0.009, 0.01])
@pytest.mark.parametrize("unit", [1.0, 1e6])
def test_a_small_stone_on_a_large_wall_overturns_under_its_own_load(width, unit):
    """6e-5 of the weight of 33 stones under it: W b / h. While an increment was solved when the wall was, a stone that
    carried all of its weight as a residual bore 3.3 % more, and a force in N not the same as one in MN."""
    courses = [np.arange(0.0, 2.0, 0.4), np.array([0.0, 0.2, 0.6, 1.0, 1.4, 1.8])]
    polygons = [rectangle(-0.5, -0.3, 3.0, 0.3)]
    for course in range(6):
        starts = courses[course % 2]
        ends = np.append(starts[1:], 2.0)
        polygons += [rectangle(x, 0.3 * course, end - x, 0.3) for x, end in zip(starts, ends, strict=True)]
    polygons.append(rectangle(0.7, 1.8, width, 2.0 * width))
    stones = tuple(Block(number, outline, number == 0, 20e3) for number, outline in enumerate(polygons))
    assemblage = find_joints(Wall("small stone", stones, 1.0, 0.7), JointSettings())
    load = LoadSettings(distribution="per_block", live=(LiveLoad((len(stones) - 1,), unit),))
    analysis = analyse(assemblage, loads=loads_on(assemblage.wall, load))
    bears = 0.5 * 20e3 * 2.0 * width**2
    assert unit * analysis.headline.load_multiplier == pytest.approx(bears, rel=1e-6)
    done = push(assemblage, analysis, one_body_per_block(assemblage), load)
    assert not done.complaints
    assert unit * done.capacity.peak_multiplier == pytest.approx(bears, rel=5e-3)


def test_the_direction_of_a_live_load_may_have_any_length_but_not_be_upright():
    """A block that slides at 0.3 of its weight does so whatever the length of the vector."""
    assemblage = assemblage_of(stack((1.0, 0.5), friction=0.3))
    bodies, short = make_bodies(assemblage, one_body_per_block(assemblage)), SteppingSettings(final_displacement=1e-3)
    for way in ((1.0, 0.0), (-2.0, 0.0)):
        rows = pushover_increments(bodies, MeshSettings(size=0.5), stepping=short, direction=way)
        assert max(row.load_multiplier for row in rows) == pytest.approx(0.3, rel=1e-3)
    with pytest.raises(CaseError, match=r"direction: .* has no horizontal part"):
        next(pushover_increments(bodies, direction=(0.0, -1.0)))
