"""10-node tetrahedra with straight outline edges: exact where they must be, softer in bending than 4-node ones."""

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from orchestrator.macroblocks.bodies import make_bodies
from orchestrator.macroblocks.criteria import one_body_per_block
from orchestrator.pushover.meshing import MeshSettings, mesh_bodies
from orchestrator.pushover.model import build_model
from orchestrator.pushover.settings import ContactSettings, ElasticSettings
from orchestrator.pushover.solids.elastic_constants import ElasticConstants
from orchestrator.pushover.solids.elasticity import assemble, gravity_and_lateral_loads
from tests.support.pushover_chain import assemblage_of, run, stack

LENGTH, HEIGHT, THICKNESS = 0.8, 0.2, 0.1


def bar(size):
    assemblage = assemblage_of(stack((LENGTH, HEIGHT), friction=0.5))
    bodies = make_bodies(assemblage, one_body_per_block(assemblage))
    return mesh_bodies(bodies, MeshSettings(size=size), None)


def of_order(order, meshes, poisson_ratio=0.2):
    constants = ElasticConstants(np.array([1e9]), np.array([poisson_ratio]))
    return assemble(meshes, constants, order)


def with_departures(field, elasticity):
    """Nodal values (nodes, 3) as unknowns; edges do not depart."""
    return np.concatenate([field.ravel(), np.zeros(elasticity.stiffness.shape[0] - field.size)])


@pytest.mark.parametrize("order", [1, 2])
def test_rigid_motion_costs_nothing_and_uniform_strain_its_energy(order):
    meshes = bar(0.1)
    elasticity = of_order(order, meshes)
    x, y, z = meshes.nodes.T
    turned = with_departures(np.column_stack([0.1 - y, x, 0.2 + 0 * z]), elasticity)
    assert turned @ elasticity.stiffness @ turned < 1e-6 * 1e9
    stretched = with_departures(np.column_stack([1e-3 * x, 0 * y, 0 * z]), elasticity)
    constrained_modulus = 1e9 * 0.8 / (1.2 * 0.6)
    energy = 0.5 * constrained_modulus * 1e-6 * LENGTH * HEIGHT * THICKNESS
    assert 0.5 * stretched @ elasticity.stiffness @ stretched == pytest.approx(energy, rel=1e-9)


@pytest.mark.parametrize("order", [1, 2])
def test_weight_is_that_of_the_volume(order):
    meshes = bar(0.1)
    elasticity = of_order(order, meshes)
    gravity, lateral = gravity_and_lateral_loads(elasticity.mass, len(meshes.nodes))
    weight = 25e3 * LENGTH * HEIGHT * THICKNESS
    corners = 3 * len(meshes.nodes)
    assert gravity[1:corners:3].sum() == pytest.approx(-weight, rel=1e-9)
    assert lateral[0:corners:3].sum() == pytest.approx(weight, rel=1e-9)


def bending_energy_ratio(order, size):
    """Energy of a bar whose ends are turned against each other over that of the beam (exact for Poisson ratio 0)."""
    meshes = bar(size)
    elasticity = of_order(order, meshes, poisson_ratio=0.0)
    curvature = 1e-3
    x, y = meshes.nodes[:, 0], meshes.nodes[:, 1] - HEIGHT / 2
    exact = np.column_stack([-curvature * x * y, 0.5 * curvature * x**2, 0 * x])
    ends = np.flatnonzero(np.abs(np.abs(x) - LENGTH / 2) < 1e-9)
    held = np.add.outer(3 * ends, np.arange(3)).ravel()
    free = np.setdiff1d(np.arange(elasticity.stiffness.shape[0]), held)
    u = np.zeros(elasticity.stiffness.shape[0])
    u[held] = exact.ravel()[held]
    u[free] = spsolve(elasticity.stiffness[free][:, free].tocsc(), -elasticity.stiffness[free][:, held] @ u[held])
    beam = 0.5 * 1e9 * THICKNESS * HEIGHT**3 / 12 * curvature**2 * LENGTH
    return 0.5 * u @ elasticity.stiffness @ u / beam


def test_bending_is_softer_and_converges_faster():
    """2 and 4 elements over the height: 1.45, 1.09 of the beam's energy; 10-node tetrahedra 1.04, 1.004."""
    linear = [bending_energy_ratio(1, HEIGHT / n) for n in (2, 4)]
    quadratic = [bending_energy_ratio(2, HEIGHT / n) for n in (2, 4)]
    assert 1.0 < quadratic[1] < 1.01 < quadratic[0] < 1.05
    assert linear[0] > 1.4
    assert (quadratic[0] - 1) / (quadratic[1] - 1) > 1.5 * (linear[0] - 1) / (linear[1] - 1)


def test_a_wall_of_10_node_tetrahedra_slides_and_rocks_at_the_same_multiplier():
    """A single block: the closed forms of test_stacked_blocks hold whatever the elements; large displacements too."""
    for friction, multiplier in ((0.3, 0.3), (0.9, 0.5)):
        assemblage = assemblage_of(stack((0.4, 0.8), friction=friction))
        bodies = make_bodies(assemblage, one_body_per_block(assemblage))
        meshes = mesh_bodies(bodies, MeshSettings(), None)
        elastic = ElasticSettings(element_order=2)
        for large in (False, True):
            model = build_model(bodies, meshes, elastic, ContactSettings(), large)
            assert run(model, final_displacement=1e-3).peak == pytest.approx(multiplier, rel=5e-3)
