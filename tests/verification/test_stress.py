"""Stress of the FE model against statics: a column under its own weight, a turned body, a body under uniform strain."""

from __future__ import annotations

import numpy as np
import pytest
from mpi4py import MPI

from orchestrator.macroblocks.bodies import make_bodies
from orchestrator.macroblocks.criteria import one_body_per_block, partition_of
from orchestrator.masonry.joints import JointClass, JointSettings, find_joints
from orchestrator.masonry.patterns import running_bond
from orchestrator.masonry.wall import Wall
from orchestrator.pushover.meshing import MeshSettings, mesh_bodies
from orchestrator.pushover.model import build_model, driven_by
from orchestrator.pushover.path.stepping import Pushover
from orchestrator.pushover.settings import ContactSettings, ElasticSettings, NewtonSettings, SteppingSettings
from orchestrator.pushover.solids.nodal_loads import own_weight
from orchestrator.pushover.solve.linear_system import LinearSystem
from orchestrator.pushover.stress import (
    contact_forces,
    element_stress,
    in_fixed_axes,
    slave_areas,
    von_mises,
)
from tests.support.pushover_chain import assemblage_of, stack
from tests.support.walls import upright

WEIGHT, HEIGHT, WIDTH, THICKNESS = 25e3, 2.0, 0.4, 0.1


def column(order):
    """A column of one block on a support; thickness 0.1 m."""
    assemblage = assemblage_of(stack((WIDTH, HEIGHT), friction=0.7))
    bodies = make_bodies(assemblage, one_body_per_block(assemblage))
    meshes = mesh_bodies(bodies, MeshSettings(size=0.1), None)
    elastic = ElasticSettings(element_order=order)
    return bodies, build_model(bodies, meshes, elastic, ContactSettings(), True)


def under_gravity(model):
    """The last increment before the load."""
    last = None
    with LinearSystem(model, MPI.COMM_SELF) as system:
        for increment in Pushover(model, system, NewtonSettings(), SteppingSettings()).increments():
            if increment.phase != "gravity":
                return last
            last = increment


def volumes(meshes):
    corners = meshes.nodes[meshes.tetrahedra]
    return np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6


@pytest.mark.parametrize("order", [1, 2])
def test_column_under_its_own_weight(order):
    """sigma_y = -rho g (height - y). Its mean is exact for any mesh (virtual work of the displacement (0, y, 0))."""
    bodies, model = column(order)
    increment = under_gravity(model)
    stress = element_stress(model.meshes, model.elastic, increment.displacement, True)
    volume = volumes(model.meshes)
    assert volume.sum() == pytest.approx(HEIGHT * WIDTH * THICKNESS, rel=1e-9)
    assert stress[:, 1, 1] @ volume / volume.sum() == pytest.approx(-WEIGHT * HEIGHT / 2, rel=1e-4)
    above = HEIGHT - model.meshes.nodes[model.meshes.tetrahedra].mean(axis=1)[:, 1]
    for top, bottom in ((0.2, 0.6), (0.6, 1.0), (1.0, 1.4), (1.4, 1.8)):
        layer = (above > top) & (above < bottom)
        share = volume[layer] / volume[layer].sum()
        expected = -WEIGHT * float(above[layer] @ share)
        assert stress[layer, 1, 1] @ share == pytest.approx(expected, rel=0.02)
        assert np.linalg.eigvalsh(stress[layer])[:, 0] @ share == pytest.approx(expected, rel=0.03)
        assert von_mises(stress[layer]) @ share == pytest.approx(-expected, rel=0.05)
    area = slave_areas(model, bodies)
    resting = np.flatnonzero(increment.normal_force > 0.0)
    assert area[resting].sum() == pytest.approx(WIDTH * THICKNESS, rel=1e-9)
    mean_pressure = increment.normal_force[resting].sum() / area[resting].sum()
    assert mean_pressure == pytest.approx(WEIGHT * HEIGHT, rel=1e-4)


def test_a_node_between_two_joints_stands_for_its_area_in_both():
    """Two stones that are one body on a third of 1 m: five nodes a row in two joints, an area of 1 m x 0.3 m."""
    stones = [upright(1, 0, 0, 1, 0.25), upright(2, 0, 0.25, 0.5, 0.25), upright(3, 0.5, 0.25, 0.5, 0.25)]
    wall = Wall("three", (upright(0, -2, -0.3, 6, 0.3, fixed=True), *stones), 0.3, 0.6)
    assemblage = find_joints(wall, JointSettings())
    bodies = make_bodies(assemblage, partition_of(assemblage, np.array([8, 1, 9, 9])))
    meshes = mesh_bodies(bodies, MeshSettings(size=0.25), None)
    model = build_model(bodies, meshes, ElasticSettings(), ContactSettings(), False)
    between = model.possible.point[:, 1] > 0.1
    area = slave_areas(model, bodies)[between]
    place = model.possible.point[between, 0]
    found = [area[np.abs(place - x) < 1e-3].sum() for x in (0.0, 0.25, 0.5, 0.75, 1.0)]
    assert found == pytest.approx([0.0375, 0.075, 0.075, 0.075, 0.0375])


@pytest.mark.parametrize("degrees", [0.0, 30.0, 45.0])
def test_the_mean_displacement_of_what_is_driven_goes_along_the_load(degrees):
    """All bodies that go 1 m along an inclined load have a mean displacement of 1 m along it."""
    bodies, _ = column(1)
    way = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
    meshes = mesh_bodies(bodies, MeshSettings(size=0.1), None)
    model = build_model(bodies, meshes, ElasticSettings(), ContactSettings(), False, own_weight(meshes, way))
    moved = np.column_stack([np.tile(way, (len(model.body), 1)), np.zeros(len(model.body))]).ravel()
    driven = driven_by(model, np.ones(model.bodies, bool))
    assert [one.mean_row @ moved for one in (model, driven)] == pytest.approx([1.0, 1.0], rel=1e-9)


@pytest.mark.parametrize("order", [1, 2])
def test_a_turned_body_has_the_stress_of_the_body_that_is_not(order):
    _, model = column(order)
    random = np.random.default_rng(1)
    small = 1e-5 * random.standard_normal((len(model.front.row), 3))
    cosine, sine = np.cos(0.7), np.sin(0.7)
    turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    turned = small @ turn.T
    turned[: len(model.meshes.nodes)] += model.meshes.nodes @ (turn - np.eye(3)).T + [0.3, -0.2, 0.0]
    before, after = (element_stress(model.meshes, model.elastic, u, True) for u in (small, turned))
    assert np.abs(after - before).max() < 1e-6 * np.abs(before).max()
    assert np.abs(before).max() > 1e5


def test_stress_in_fixed_axes_turns_with_the_body():
    """R sigma R^T of a body that a rigid rotation has turned, whatever was rotated first."""
    _, model = column(1)
    small = np.column_stack(
        [np.zeros(len(model.meshes.nodes)), -1e-4 * model.meshes.nodes[:, 1], model.meshes.nodes[:, 0] * 0]
    )
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    turned = (model.meshes.nodes + small) @ turn.T - model.meshes.nodes
    stress = element_stress(model.meshes, model.elastic, turned, True)
    fixed = in_fixed_axes(model.meshes, stress, turned)
    first, second = 3.5e9 * 0.2 / (1.2 * 0.6), 3.5e9 / 2.4
    expected = -1e-4 * np.diag([first + 2 * second, first, first])  # what was vertical lies along x now
    np.testing.assert_allclose(fixed, np.broadcast_to(expected, fixed.shape), atol=1.0)


@pytest.mark.parametrize("strengths", [{}, {"cohesion": 2e4, "tensile_strength": 1e4}, {"shear_stiffness": 2e9}])
@pytest.mark.parametrize("large", [True, False])
def test_forces_of_contacts_hold_every_body(strengths, large):
    """Force and moment of weight, live load and contacts vanish on each block of a wall that slides and rocks."""
    assemblage = find_joints(running_bond(3, 4), JointSettings(classes=(JointClass(**strengths),)))
    bodies = make_bodies(assemblage, one_body_per_block(assemblage))
    meshes = mesh_bodies(bodies, MeshSettings(size=0.2), None)
    model = build_model(bodies, meshes, ElasticSettings(), ContactSettings(), large)
    with LinearSystem(model, MPI.COMM_SELF) as system:
        steps = Pushover(model, system, NewtonSettings(), SteppingSettings(final_displacement=5e-3)).increments()
        state = next(one for one in steps if one.load_multiplier > 0.1 and not one.moving)
    force, possible = contact_forces(model, state), model.possible
    moved = meshes.nodes + state.displacement[: len(meshes.nodes)]
    front, nodal = model.front, (model.gravity + state.load_multiplier * model.lateral).reshape(-1, 3)
    node = possible.slave_node
    place = np.where((node >= 0)[:, None], moved[np.maximum(node, 0)], possible.point)
    total = np.zeros((bodies.moving + len(possible), 6))
    parts = (
        (front.body_of_node, moved[front.number], nodal),
        (possible.slave_body, place, force),
        (possible.master_body, place, -force),
    )
    for body, at, on_body in parts:
        np.add.at(total, body, np.hstack([on_body, np.cross(at, on_body)]))
    in_plane = total[: bodies.moving, [0, 1, 5]]  # across the wall, what is in front and its image cancel
    assert np.abs(in_plane).max() < 1e-3 * model.weight / bodies.moving
    assert np.linalg.norm(force[:, 0]) > 0.05 * model.weight / bodies.moving


def test_uniform_strain_is_hookes_law():
    """eps_x = 1e-4 alone: sigma_x = (lambda + 2 mu) eps, sigma_y = sigma_z = lambda eps; von Mises 2 mu eps."""
    _, model = column(1)
    stretched = np.column_stack([1e-4 * model.meshes.nodes[:, 0], np.zeros((len(model.meshes.nodes), 2))])
    stress = element_stress(model.meshes, model.elastic, stretched, False)
    first, second = 3.5e9 * 0.2 / (1.2 * 0.6), 3.5e9 / 2.4
    expected = 1e-4 * np.diag([first + 2 * second, first, first])
    np.testing.assert_allclose(stress, np.broadcast_to(expected, stress.shape), atol=1.0)
    np.testing.assert_allclose(von_mises(stress), 2e-4 * second, rtol=1e-6)


def test_stress_by_hand_agrees_with_the_stiffness_of_dolfinx():
    """Strain energy: half of u K u = half of sigma : eps over the volume, for 4-node elements."""
    _, model = column(1)
    in_front = 1e-5 * np.random.default_rng(2).standard_normal((len(model.front.nodes), 3))
    displacement = model.front.of_all(in_front)
    stress = element_stress(model.meshes, model.elastic, displacement, False)
    modulus, ratio = 3.5e9, 0.2
    trace = np.trace(stress, axis1=1, axis2=2)
    strain = (1 + ratio) / modulus * stress - ratio / modulus * trace[:, None, None] * np.eye(3)
    energy = 0.5 * np.sum(stress * strain, axis=(1, 2)) @ volumes(model.meshes)
    u = in_front.ravel()
    assert energy == pytest.approx(0.5 * u @ (model.stiffness @ u), rel=1e-9)
