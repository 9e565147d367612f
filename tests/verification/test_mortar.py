"""Joints with normal and shear stiffness against closed forms: columns, rotation, shear, a cantilever of blocks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from orchestrator.masonry.joints import JointClass
from orchestrator.pushover.settings import ElasticSettings
from tests.support.pushover_chain import model_of, run, stack

NORMAL, SHEAR = 2e9, 8e8
MORTAR = JointClass(normal_stiffness=NORMAL, shear_stiffness=SHEAR)
RIGID = ElasticSettings(elastic_modulus=1e14)
THICKNESS, UNIT_WEIGHT = 0.1, 25e3
WIDTH, HEIGHT = 0.4, 0.25


def column(count, **options):
    """Blocks of 0.4 m x 0.25 m, one on the other."""
    return model_of(stack(*[(WIDTH, HEIGHT)] * count, friction=0.6), joints=MORTAR, mesh_size=0.1, **options)


def pushed(model, final_displacement=2e-5, **options):
    """A curve in so small displacements that no joint opens or slides."""
    return run(model, final_displacement, displacement_increment=0.1, load_increment=0.01, **options)


def mean_at(model, displacement, level):
    """Mean displacement (2,) in m of the nodes at a level of the undeformed column."""
    nodes = model.meshes.nodes
    here = np.abs(nodes[:, 1] - level) < 1e-9
    return displacement[: len(nodes)][here, :2].mean(axis=0)


@pytest.mark.parametrize("large_displacement", [False, True])
@pytest.mark.parametrize("count", [1, 3])
def test_a_column_shortens_by_the_sum_of_its_joints(count, large_displacement):
    """Rigid blocks: sum of N / (k_n A), N the weight above each joint."""
    model = column(count, elastic=RIGID, large_displacement=large_displacement)
    state = pushed(model).under_gravity
    area, block = WIDTH * THICKNESS, UNIT_WEIGHT * WIDTH * HEIGHT * THICKNESS
    expected = sum(above * block for above in range(1, count + 1)) / (NORMAL * area)
    assert -mean_at(model, state.displacement, count * HEIGHT)[1] == pytest.approx(expected, rel=1e-4)


def test_joints_and_blocks_are_in_series():
    """Elastic blocks, Poisson's ratio 0: the shortening of the blocks alone is added, gamma H^2 / (2 E)."""
    soft = ElasticSettings(elastic_modulus=1e9, poisson_ratio=0.0)
    model = column(3, elastic=soft)
    state = pushed(model).under_gravity
    block, height = UNIT_WEIGHT * WIDTH * HEIGHT * THICKNESS, 3 * HEIGHT
    joints = 6 * block / (NORMAL * WIDTH * THICKNESS)
    stone = UNIT_WEIGHT * height**2 / (2 * soft.elastic_modulus)
    assert -mean_at(model, state.displacement, height)[1] == pytest.approx(joints + stone, rel=0.01)


@pytest.mark.parametrize(("mesh_size", "within"), [(0.2, 1e-3), (0.1, 1e-3), (0.04, 1e-3)])
def test_a_block_turns_by_moment_over_stiffness(mesh_size, within):
    """lambda W h / 2 over k_n t b^3 / 12, whatever the mesh from two elements along the joint on."""
    wall = stack((WIDTH, HEIGHT), friction=2.0)
    model = model_of(wall, joints=MORTAR, mesh_size=mesh_size, elastic=RIGID)
    result = pushed(model, 1e-6)
    state = result.increments[-1]
    turned = (state.displacement - result.under_gravity.displacement)[: len(model.meshes.nodes)]
    nodes = model.meshes.nodes
    arm = nodes[:, 0] - nodes[:, 0].mean()
    rotation = -(arm @ turned[:, 1]) / (arm @ arm)
    moment = state.load_multiplier * model.weight * HEIGHT / 2
    assert state.load_multiplier < WIDTH / (3 * HEIGHT), "the joint is closed all over"
    assert rotation == pytest.approx(moment / (NORMAL * THICKNESS * WIDTH**3 / 12), rel=within)


def test_a_joint_slips_by_shear_over_stiffness_and_then_slides():
    """V / (k_s A) below friction, whatever the pressure; then the shear stays at mu W."""
    wall = stack((0.8, 0.05), friction=0.3)
    model = model_of(wall, joints=replace(MORTAR, normal_stiffness=1e12), mesh_size=0.1, elastic=RIGID)
    path = run(model, 2e-6, displacement_increment=0.02, load_increment=0.02).increments
    slid = np.array([i.mean_displacement for i in path if i.phase != "gravity"])
    shear = np.array([i.base_shear for i in path if i.phase != "gravity"])
    sticks = shear < 0.9 * 0.3 * model.weight
    assert np.count_nonzero(sticks) > 10
    assert slid[sticks] == pytest.approx(shear[sticks] / (SHEAR * 0.8 * THICKNESS), rel=1e-3, abs=1e-12)
    assert shear[-1] == pytest.approx(0.3 * model.weight, rel=1e-3)


def stiffness_of_cantilever(count, elastic=None):
    """Base shear over mean displacement of the top of blocks under a load that is proportional to mass.

    Joints: shear V_j / (k_s A) and rotation M_j / (k_n I) x the arm to the top. Blocks, if elastic: Timoshenko's
    cantilever of the whole height under a uniform load w, w H^4 / (8 E I) + w H^2 / (2 G A 5/6).
    """
    area, inertia, load = WIDTH * THICKNESS, THICKNESS * WIDTH**3 / 12, UNIT_WEIGHT * WIDTH * THICKNESS
    height = count * HEIGHT
    moved = 0.0
    for joint in range(count):
        above = height - joint * HEIGHT
        moved += load * above / (SHEAR * area) + load * above**2 / 2 / (NORMAL * inertia) * above
    if elastic:
        modulus, shear = elastic.elastic_modulus, elastic.elastic_modulus / (2 * (1 + elastic.poisson_ratio))
        moved += load * height**4 / (8 * modulus * inertia) + load * height**2 / (2 * shear * area * 5 / 6)
    return load * height / moved


@pytest.mark.parametrize("count", [2, 5])
def test_initial_stiffness_of_a_cantilever_of_rigid_blocks(count):
    result = pushed(column(count, elastic=RIGID), 1e-6)
    row = result.curve
    found = row.base_shear_N[-1] / (row.control_displacement_m[-1] - row.control_displacement_m[0])
    assert found == pytest.approx(stiffness_of_cantilever(count), rel=2e-3)


def test_initial_stiffness_of_a_cantilever_of_elastic_blocks():
    soft = ElasticSettings(elastic_modulus=2e9, poisson_ratio=0.2, element_order=2)
    result = pushed(column(5, elastic=soft), 1e-6)
    row = result.curve
    found = row.base_shear_N[-1] / (row.control_displacement_m[-1] - row.control_displacement_m[0])
    assert found == pytest.approx(stiffness_of_cantilever(5, soft), rel=0.05)
    assert found < 0.9 * stiffness_of_cantilever(5), "blocks count"


def test_the_energy_of_mortar_closes():
    """External work is stored (half of it in the joints) or spent."""
    result = run(column(3, large_displacement=True), 0.02, displacement_increment=0.02)
    last = result.increments[-1]
    total = last.internal_energy + last.dissipated_energy + last.other_work + last.energy_error + last.lost_in_motion
    assert last.external_work == pytest.approx(total, rel=1e-9)
    assert result.effort.energy_error < 0.01
    stored = 0.5 * result.model.mortar.compliance @ last.normal_force**2
    assert stored > 0.3 * last.internal_energy
