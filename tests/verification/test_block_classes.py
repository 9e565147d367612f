"""Blocks of several materials: stacks of two, against statics and the strength of materials written out by hand.

Widths b, heights h, the wall's thickness T; a block of its own thickness t weighs and carries over t only.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from orchestrator.limit_analysis import analyse
from orchestrator.loads import LoadSettings, loads_on
from orchestrator.macroblocks.bodies import make_bodies
from orchestrator.macroblocks.criteria import one_body_per_block, partition_of
from orchestrator.masonry.block_classes import BlockClass, with_classes
from orchestrator.masonry.joints import JointClass, JointSettings, find_joints
from orchestrator.masonry.wall import Block, Wall
from orchestrator.pushover.meshing import MeshSettings, mesh_bodies
from orchestrator.pushover.settings import ElasticSettings
from orchestrator.pushover.solids.elastic_constants import constants_of
from orchestrator.pushover.solids.nodal_loads import nodal_loads
from tests.support.limit_analysis_cases import analysed
from tests.support.pushover_chain import assemblage_of, model_of, rectangle, run, stack

B, H, T = 0.4, 0.5, 0.1
HEAVY = BlockClass("heavy", unit_weight=75e3)
THIN = BlockClass("thin", thickness=0.04)


def two(upper: BlockClass, friction=3.0, lower: BlockClass | None = None):
    """Two blocks of 25 kN/m3, changed by the classes given."""
    wall = stack((B, H), (B, H), friction=friction)
    ground, first, second = wall.blocks
    blocks = (
        ground,
        replace(first, material=lower.material if lower else "stone"),
        replace(second, material=upper.material),
    )
    return with_classes(replace(wall, blocks=blocks), (upper, *([lower] if lower else [])))


def partitions(wall):
    """Every stone a body, and both stones one body."""
    assemblage = assemblage_of(wall)
    return one_body_per_block(assemblage), partition_of(assemblage, np.array([1, 0, 0]))


def overturning(weights):
    """(W1 + W2) b/2 = lambda (W1 h/2 + W2 3h/2), lower than b/h of the upper block alone where W2 > W1 / 3."""
    return weights.sum() * B / 2 / (weights @ [0.5 * H, 1.5 * H])


@pytest.mark.parametrize(("upper", "weights"), [(HEAVY, [1.0, 3.0]), (THIN, [1.0, 0.4])])
@pytest.mark.parametrize("direction", [1, -1])
def test_two_materials_overturn_about_the_toe_in_limit_analysis(upper, weights, direction):
    wall = two(upper)
    found = analysed(assemblage_of(wall), direction)
    weights = np.array(weights) * 25e3 * T * B * H
    assert found.weight == pytest.approx(weights.sum(), rel=1e-12)
    assert found.associative.load_multiplier == pytest.approx(overturning(weights), rel=1e-7)


@pytest.mark.parametrize(("upper", "weights"), [(HEAVY, [1.0, 3.0]), (THIN, [1.0, 0.4])])
@pytest.mark.parametrize("merged", [False, True])
def test_two_materials_overturn_about_the_toe_in_finite_elements(upper, weights, merged):
    """A macroblock has the centroid of its stones (its middle would give b / 2h = 0.4), and their base reaction."""
    wall = two(upper)
    loads = LoadSettings()
    result = run(model_of(wall, partitions(wall)[merged], loads=loads), final_displacement=2e-3)
    weights = np.array(weights) * 25e3 * T * B * H
    assert result.peak == pytest.approx(overturning(weights), rel=2e-3)
    assert result.model.weight == pytest.approx(weights.sum(), rel=1e-9)
    reaction = result.under_gravity.normal_force @ result.model.support_side
    assert reaction == pytest.approx(weights.sum(), rel=1e-7)


@pytest.mark.parametrize("distribution", ["mass", "mass_height"])
def test_forces_and_moments_of_a_macroblock_of_several_materials_are_those_of_its_stones(distribution):
    wall = two(HEAVY, lower=THIN)
    settings = LoadSettings(distribution=distribution)
    blocks = loads_on(wall, settings)
    moments = []
    for partition in partitions(wall):
        bodies = make_bodies(assemblage_of(wall), partition)
        meshes = mesh_bodies(bodies, MeshSettings(size=0.2), None)
        given = nodal_loads(wall, bodies, meshes, settings)
        model = model_of(wall, partition, loads=settings)
        force = model.lateral.reshape(-1, 3)[:, 0]
        moments.append((force.sum(), force @ model.front.nodes[:, 1], given.dead.sum()))
    expected = (blocks.live[:, 0].sum(), blocks.live[1:, 0] @ [0.5 * H, 1.5 * H], 0.0)
    for found in moments:
        assert found == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_a_column_of_two_materials_shortens_as_its_parts_do():
    """Under its weight, nu = 0: (W1/2 + W2) h / (E1 b t1) + W2/2 h / (E2 b t2), and the lower part alone the first."""
    soft = BlockClass("soft", unit_weight=25e3, elastic_modulus=1e8, poisson_ratio=0.0, thickness=0.05)
    stiff = BlockClass("stiff", unit_weight=50e3, elastic_modulus=4e8, poisson_ratio=0.0)
    wall = two(stiff, lower=soft)
    model = model_of(wall, loads=LoadSettings(), mesh_size=0.05)
    nodes, moved = model.meshes.nodes, run(model, 1e-4).under_gravity.displacement[:, 1]
    w1, w2 = 25e3 * 0.05 * B * H, 50e3 * T * B * H
    lower = (w1 / 2 + w2) * H / (1e8 * B * 0.05)
    upper = w2 / 2 * H / (4e8 * B * T)
    top = nodes[:, 1] > 2 * H - 1e-9
    middle = (np.abs(nodes[:, 1] - H) < 1e-9) & (model.meshes.body_of_node == 0)
    assert -moved[middle].mean() == pytest.approx(lower, rel=0.01)
    assert -moved[top].mean() == pytest.approx(lower + upper, rel=0.01)


def test_constants_of_a_body_are_the_mean_of_its_stones_by_volume_and_those_of_the_case_elsewhere():
    wall = two(BlockClass("timber", elastic_modulus=11e9, poisson_ratio=0.4), lower=BlockClass("thin", thickness=0.05))
    elastic = ElasticSettings(elastic_modulus=2e9, poisson_ratio=0.1)
    apart, together = (constants_of(make_bodies(assemblage_of(wall), p), elastic) for p in partitions(wall))
    assert apart.elastic_modulus[:2] == pytest.approx([2e9 * 0.5, 11e9])
    assert apart.poisson_ratio[:2] == pytest.approx([0.1, 0.4])
    assert together.elastic_modulus[0] == pytest.approx((2e9 * 0.05 + 11e9 * 0.1) / 0.2)
    assert together.poisson_ratio[0] == pytest.approx((0.1 * 0.05 + 0.4 * 0.1) / 0.15)


@pytest.mark.parametrize(("friction", "expected"), [(0.2, 0.2), (0.9, 0.3)])
def test_the_lower_friction_of_two_classes_counts(friction, expected):
    """A squat block on a squat block slides; a class's friction holds in all its joints unless the other's is less."""
    wall = stack((0.8, 0.2), (0.8, 0.2), friction=0.3)
    ground, first, second = wall.blocks
    wall = replace(wall, blocks=(ground, first, replace(second, material="timber")))
    found = analyse(assemblage_of(with_classes(wall, (BlockClass("timber", friction=friction),))))
    assert found.associative.load_multiplier == pytest.approx(expected, rel=1e-7)


def test_a_joint_class_says_what_two_materials_have_whatever_their_own_friction():
    wall = with_classes(two(HEAVY), (BlockClass("stone", friction=0.2),))
    joints = find_joints(wall, JointSettings(classes=(JointClass(between=("heavy", "stone"), friction=0.7),))).joints
    assert joints.friction.tolist() == [0.2, 0.7]


def test_joints_are_as_wide_as_the_thinner_block():
    """A thin block held by cohesion c alone slides at c b t / W = c / (gamma h); the FE's joint has the same force."""
    cohesive = JointClass(cohesion=30e3, tensile_strength=1e9, friction=1e-6)
    lone = stack((B, H), friction=0.5)
    blocks = (lone.blocks[0], replace(lone.blocks[1], material="thin"))
    joints = assemblage_of(with_classes(replace(lone, blocks=blocks), (THIN,)), cohesive)
    assert joints.joints.area == pytest.approx(0.04 * joints.joints.length)
    assert analyse(joints).associative.load_multiplier == pytest.approx(30e3 / (25e3 * H), rel=1e-5)
    assert make_bodies(joints, one_body_per_block(joints)).interfaces.cohesion == pytest.approx([30e3 * 0.04 / T])


def test_a_steel_tie_that_is_anchored_holds_a_slender_tower_to_a_wide_one():
    """Without it the slender one overturns at b2/h; with it both turn alike, (W1 b1 + W2 b2) / ((W1 + W2) h)."""
    towers = [(1, 0.0, 0.6), (2, 0.9, 0.3)]
    stones = [Block(number, rectangle(x, 0.0, width, 1.0), False, 30e3, "stone") for number, x, width in towers]
    ground, tie = (
        Block(0, rectangle(-1.0, -0.2, 4.0, 0.2), True, 30e3),
        Block(3, rectangle(0, 1, 1.2, 0.005), False, 30e3, "steel"),
    )
    steel = BlockClass("steel", unit_weight=78.5e3, thickness=0.01, friction=0.3)
    apart = Wall("towers", (ground, *stones), T, 5.0)
    tied = with_classes(replace(apart, blocks=(*apart.blocks, tie)), (steel,))
    anchored = assemblage_of(tied, JointClass(between=("steel", "stone"), cohesion=1e6))
    assert analyse(assemblage_of(apart)).associative.load_multiplier == pytest.approx(0.3, rel=1e-7)
    assert analyse(anchored).associative.load_multiplier == pytest.approx((0.36 + 0.09) / 0.9, rel=5e-3)
    slipping = assemblage_of(tied, JointClass(between=("steel", "stone"), cohesion=0.0))
    assert analyse(slipping).associative.load_multiplier == pytest.approx(0.3, rel=0.02), "friction on its weight only"
