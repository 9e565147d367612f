"""What must not change: the mirrored wall, another density with another stiffness, the origin of the coordinates."""

from dataclasses import replace

import numpy as np
import pytest

from orchestrator.macroblocks.bodies import make_bodies
from orchestrator.macroblocks.criteria import one_body_per_block
from orchestrator.masonry.interfaces import straight_interfaces
from orchestrator.masonry.patterns import running_bond
from orchestrator.pushover.meshing import MeshSettings, mesh_bodies
from orchestrator.pushover.model import build_model
from orchestrator.pushover.settings import ContactSettings, ElasticSettings
from orchestrator.pushover.solids.nodal_loads import own_weight
from tests.support.pushover_chain import assemblage_of, run

MIRROR = np.array([-1.0, 1.0])


def parts():
    assemblage = assemblage_of(running_bond(3, 5))
    bodies = make_bodies(assemblage, one_body_per_block(assemblage))
    return bodies, mesh_bodies(bodies, MeshSettings(size=0.2), None)


def pushed(bodies, meshes, direction=1, modulus=3.5e9):
    along = own_weight(meshes, np.array([direction, 0.0]))
    elastic = ElasticSettings(elastic_modulus=modulus)
    model = build_model(bodies, meshes, elastic, ContactSettings(), loads=along)
    curve = run(model, final_displacement=2e-3).curve
    assert len(curve.step) > 30
    return curve.control_displacement_m, curve.base_shear_N / model.weight


@pytest.fixture(scope="module")
def reference():
    return pushed(*parts())


def between(bodies, start, end):
    """The bodies with their interfaces moved."""
    old = bodies.interfaces
    return replace(bodies, interfaces=straight_interfaces(old.i, old.j, start, end, bodies.thickness, old.friction))


def mirrored(bodies, meshes):
    """Return the mirror image, outlines and tetrahedra kept positive, joints kept counter-clockwise round body i."""
    outlines = tuple(replace(body, exterior=(body.exterior * MIRROR)[::-1]) for body in bodies.bodies)
    return (
        replace(between(bodies, bodies.interfaces.end * MIRROR, bodies.interfaces.start * MIRROR), bodies=outlines),
        replace(
            meshes,
            nodes=meshes.nodes * [-1.0, 1.0, 1.0],
            tetrahedra=meshes.tetrahedra[:, [0, 2, 1, 3]],
            side_triangles=meshes.side_triangles[:, ::-1],
        ),
    )


def test_mirrored_wall_under_mirrored_load_gives_the_same_curve(reference):
    displacement, shear = pushed(*mirrored(*parts()), direction=-1)
    assert displacement == pytest.approx(reference[0], rel=1e-6)
    assert shear == pytest.approx(reference[1], rel=1e-6, abs=1e-9)


def test_twice_the_density_and_twice_the_stiffness_leave_the_multiplier(reference):
    bodies, meshes = parts()
    bodies = replace(bodies, bodies=tuple(replace(one, unit_weight=2 * one.unit_weight) for one in bodies.bodies))
    displacement, shear = pushed(bodies, replace(meshes, unit_weight=2 * meshes.unit_weight), modulus=7e9)
    assert displacement == pytest.approx(reference[0], rel=1e-6)
    assert shear == pytest.approx(reference[1], rel=1e-6, abs=1e-9)


def test_origin_of_the_coordinates_does_not_matter(reference):
    bodies, meshes = parts()
    shift = np.array([1000.0, 500.0])
    moved = between(bodies, bodies.interfaces.start + shift, bodies.interfaces.end + shift)
    displacement, shear = pushed(moved, replace(meshes, nodes=meshes.nodes + [*shift, 0.0]))
    assert displacement == pytest.approx(reference[0], rel=1e-6)
    assert shear == pytest.approx(reference[1], rel=1e-6, abs=1e-9)
