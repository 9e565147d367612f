"""Half of the thickness is enough: the whole wall, front and back, has the same curve, forces and stresses.

A mesh whose back is the mirror image of its front, diagonals included, has an answer that is mirrored too. Solved as a
whole it knows nothing of that, and must come to what the nodes in front give alone. Meshes as users get them have
diagonals that lean one way; there the two differ by what the elements do.
"""

from dataclasses import replace

import numpy as np
import pytest
from mpi4py import MPI

from orchestrator.macroblocks.bodies import Bodies
from orchestrator.masonry.wall import Block, Wall
from orchestrator.pushover.meshing import BodyMeshes, MeshSettings, mesh_bodies, volumes
from orchestrator.pushover.model import ContactModel, build_model
from orchestrator.pushover.path.stepping import Pushover
from orchestrator.pushover.settings import ContactSettings, ElasticSettings, NewtonSettings, SteppingSettings
from orchestrator.pushover.solids.nodal_loads import own_weight
from orchestrator.pushover.solve.linear_system import LinearSystem
from orchestrator.pushover.stress import contact_forces, element_stress
from tests.support.pushover_chain import Run, bodies_of
from tests.support.walls import rectangle


def mirrored(bodies: Bodies) -> BodyMeshes:
    """Return meshes of two layers: one of half the thickness, and its image behind the middle."""
    half = mesh_bodies(replace(bodies, thickness=bodies.thickness / 2), MeshSettings(size=0.3))
    middle = half.nodes[:, 2].max()
    tetrahedra, nodes, of_node, sides = [], [], [], []
    count = 0
    for body in range(bodies.moving):
        own = np.flatnonzero(half.body_of_node == body)
        behind = own[half.nodes[own, 2] < middle - 1e-9]
        front = np.full(len(half.nodes), -1)
        front[own] = count + np.arange(len(own))
        image = front.copy()
        image[behind] = count + len(own) + np.arange(len(behind))
        nodes += [half.nodes[own], half.nodes[behind] * [1, 1, -1] + [0, 0, 2 * middle]]
        of_node.append(np.full(len(own) + len(behind), body))
        count += len(own) + len(behind)
        of_body = half.tetrahedra[half.body_of_tetrahedron == body]
        tetrahedra += [front[of_body], image[of_body][:, [0, 2, 1, 3]]]
        of_side = half.side_triangles[half.body_of_side == body]
        sides += [front[of_side], image[of_side][:, [0, 2, 1]]]
    number = np.arange(bodies.moving)
    found = replace(
        half,
        nodes=np.concatenate(nodes),
        body_of_node=np.concatenate(of_node),
        tetrahedra=np.concatenate(tetrahedra),
        body_of_tetrahedron=np.repeat(number, [2 * np.sum(half.body_of_tetrahedron == body) for body in number]),
        side_triangles=np.concatenate(sides),
        body_of_side=np.repeat(number, [2 * np.sum(half.body_of_side == body) for body in number]),
        side_edge=np.concatenate([np.tile(half.side_edge[half.body_of_side == body], 2) for body in number]),
    )
    assert (volumes(found.nodes, found.tetrahedra) > 0).all()
    return found


def pier() -> Wall:
    """A pier of three courses, the middle one of two stones, on a support that is wider."""
    stones = [(0.0, 0.0, 1.0, 0.4), (0.0, 0.4, 0.45, 0.4), (0.45, 0.4, 0.55, 0.4), (0.0, 0.8, 1.0, 0.4)]
    blocks = [Block(0, rectangle(-0.5, -0.2, 2.0, 0.2), True, 20e3)]
    blocks += [Block(number, rectangle(*stone), False, 20e3) for number, stone in enumerate(stones, start=1)]
    return Wall("pier", tuple(blocks), 0.3, 0.6)


def model(wall: Wall, meshes: BodyMeshes | None, halves: bool) -> ContactModel:
    bodies = bodies_of(wall)
    meshes = meshes or mesh_bodies(bodies, MeshSettings(size=0.3))
    return build_model(
        bodies,
        meshes,
        ElasticSettings(),
        ContactSettings(),
        True,
        own_weight(meshes, np.array([1.0, 0.0])),
        None,
        halves,
    )


def pushed(of: ContactModel, most: float = 0.02) -> Run:
    with LinearSystem(of, MPI.COMM_SELF) as system:
        stepping = SteppingSettings(final_displacement=most)
        return Run(of, list(Pushover(of, system, NewtonSettings(), stepping, 0.4).increments()))


@pytest.fixture(scope="module")
def both() -> tuple[Run, Run]:
    meshes = mirrored(bodies_of(pier()))
    return pushed(model(pier(), meshes, True)), pushed(model(pier(), meshes, False))


def test_the_wall_as_a_whole_has_the_same_curve(both):
    half, whole = both
    assert len(half.model.gravity) == pytest.approx(0.7 * len(whole.model.gravity), rel=0.1)
    assert half.peak == pytest.approx(whole.peak, rel=1e-6)
    first, second = half.curve, whole.curve
    rises = second.control_displacement_m[:40]
    assert first.control_displacement_m[:40] == pytest.approx(rises, rel=1e-6)
    falls = first.control_displacement_m > 1e-3  # increments are not of one size: bodies' frames weigh their nodes
    at = np.interp(first.control_displacement_m[falls], second.control_displacement_m, second.base_shear_N)
    assert first.base_shear_N[falls] == pytest.approx(at, rel=1e-5)


def test_so_have_displacements_stresses_and_joints(both):
    first, second = (run.increments[30] for run in both)
    assert first.displacement == pytest.approx(second.displacement, abs=1e-6 * np.abs(second.displacement).max())
    stress = [
        element_stress(run.model.meshes, run.model.elastic, run.increments[30].displacement, True) for run in both
    ]
    assert stress[0] == pytest.approx(stress[1], abs=1e-6 * np.abs(stress[1]).max())
    on_joints = []
    for run in both:
        force, joint = contact_forces(run.model, run.increments[30]), run.model.possible.interface
        on_joints.append(np.column_stack([np.bincount(joint, part) for part in force.T[:2]]))
    assert on_joints[0] == pytest.approx(on_joints[1], abs=1e-6 * both[0].model.weight)


def test_a_mesh_whose_diagonals_lean_one_way_departs_little():
    half, whole = (pushed(model(pier(), None, halves)) for halves in (True, False))
    assert len(half.model.gravity) == len(whole.model.gravity) / 2
    assert half.model.weight == pytest.approx(whole.model.weight, rel=1e-12)
    assert half.peak == pytest.approx(whole.peak, rel=2e-3)
