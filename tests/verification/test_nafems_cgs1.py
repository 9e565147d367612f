"""NAFEMS contact benchmark CGS-1 (patch test): two blocks pressed together by a uniform pressure.

Exact: every tetrahedron has the stress -p, the stack shortens by p H / E. Poisson's ratio is 0, so that friction has
nothing to do. The pressure takes the place of the weight in the model.

Node-to-surface contact passes where the nodes of the two faces meet, or those of the coarser face are among those of
the finer one. (A mesh that is solved whole needs the same triangles on both faces, too: `mesh.matching_faces`.) Where
they do not, what a slave's node bears is not what the master's nodes expect of a uniform pressure.
"""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from mpi4py import MPI

from orchestrator.macroblocks.bodies import make_bodies
from orchestrator.macroblocks.criteria import one_body_per_block
from orchestrator.pushover.meshing import BodyMeshes, MeshSettings, mesh_bodies, volumes
from orchestrator.pushover.model import ContactModel, build_model
from orchestrator.pushover.path.increment_record import at_rest
from orchestrator.pushover.settings import ContactSettings, ElasticSettings, NewtonSettings
from orchestrator.pushover.solve.iterate import Target, evaluate
from orchestrator.pushover.solve.linear_system import LinearSystem
from orchestrator.pushover.solve.newton import solve_increment
from tests.support.pushover_chain import assemblage_of, stack

PRESSURE = 1e6
ELASTIC = ElasticSettings(elastic_modulus=1e10, poisson_ratio=0.0)
SIZES = ((0.6, 0.3), (0.6, 0.3))


def joined(parts: list[BodyMeshes]) -> BodyMeshes:
    """Take body n from the n-th of `parts`, each a mesh of all bodies."""
    nodes, tetrahedra, sides, node_body, tetrahedron_body, side_body, side_edge = [], [], [], [], [], [], []
    first = 0
    for body, part in enumerate(parts):
        mine = np.flatnonzero(part.body_of_node == body)
        shift = first - mine[0]
        nodes.append(part.nodes[mine])
        tetrahedra.append(part.tetrahedra[part.body_of_tetrahedron == body] + shift)
        sides.append(part.side_triangles[part.body_of_side == body] + shift)
        side_edge.append(part.side_edge[part.body_of_side == body])
        for bodies, items in ((node_body, nodes), (tetrahedron_body, tetrahedra), (side_body, sides)):
            bodies.append(np.full(len(items[-1]), body))
        first += len(mine)
    joint = [np.concatenate(x) for x in (nodes, tetrahedra, node_body, tetrahedron_body, sides, side_body, side_edge)]
    names = [field.name for field in fields(BodyMeshes)][:7]
    return replace(parts[0], **dict(zip(names, joint, strict=True)))


def pressed(
    lower: float, upper: float, layers: int = 2, matching: bool = True, halves: bool = True
) -> tuple[ContactModel, np.ndarray]:
    """Return the model of two blocks meshed with these sizes, and its displacement (m, 3) under the pressure."""
    assemblage = assemblage_of(stack(*SIZES, friction=0.1))
    bodies = make_bodies(assemblage, one_body_per_block(assemblage))
    meshes = joined([mesh_bodies(bodies, MeshSettings(size, layers, matching), None) for size in (lower, upper)])
    model = build_model(bodies, meshes, ELASTIC, ContactSettings(), halves=halves)
    model = replace(model, gravity=model.front.of_front(pressure_on_top(meshes)))
    state = at_rest(model)
    start = state.displacement.ravel()
    problem = Target(1.0, start, state.elastic_slip, 1.0, None, 0.6 * 0.1 * PRESSURE / len(model.contacts))
    with LinearSystem(model, MPI.COMM_SELF) as system:
        first = evaluate(model, problem, start, state.normal_force, 0.0)
        iterate = solve_increment(model, system, problem, first, NewtonSettings(iterations=60))
    assert iterate.active.all()
    return model, model.front.of_all(iterate.displacement.reshape(-1, 3))


def pressure_on_top(meshes: BodyMeshes) -> np.ndarray:
    """Return the consistent nodal forces (3 m,) of a uniform pressure on the highest face."""
    top = meshes.side_triangles[(meshes.nodes[meshes.side_triangles][..., 1] > 0.6 - 1e-9).all(axis=1)]
    a, b, c = (meshes.nodes[top[:, k]] for k in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    assert area.sum() == pytest.approx(0.06)
    force = np.zeros_like(meshes.nodes)
    np.add.at(force[:, 1], top, -PRESSURE * area[:, None] / 3)
    return force.ravel()


def errors(model: ContactModel, displacement: np.ndarray) -> tuple[float, float, float]:
    """Return root mean square and largest error of the vertical stress over the pressure, and of the shortening."""
    meshes = model.meshes
    corners, nodal = meshes.nodes[meshes.tetrahedra], displacement[meshes.tetrahedra]
    edges, moved = ((x[:, 1:] - x[:, :1]).transpose(0, 2, 1) for x in (corners, nodal))
    stress = ELASTIC.elastic_modulus * (moved @ np.linalg.inv(edges))[:, 1, 1]
    wrong = stress / PRESSURE + 1.0
    volume = volumes(meshes.nodes, meshes.tetrahedra)
    top = meshes.nodes[:, 1] > 0.6 - 1e-9
    shortening = -displacement[top, 1].mean() / (PRESSURE * 0.6 / ELASTIC.elastic_modulus)
    return float(np.sqrt(volume @ wrong**2 / volume.sum())), float(np.abs(wrong).max()), float(abs(shortening - 1))


@pytest.mark.parametrize("matching", [False, True])
@pytest.mark.parametrize(("size", "layers"), [(0.2, 1), (0.2, 2), (0.1, 2), (0.07, 3)])
def test_faces_of_one_mesh_size_pass(size, layers, matching):
    """Neighbours share nodes on their joint: exact, whichever way diagonals lean."""
    assert max(errors(*pressed(size, size, layers, matching))) < 1e-6


def test_solved_whole_they_pass_with_diagonals_that_match_only():
    """Half of the thickness knows no diagonals on a joint (front.py); the whole of it does."""
    assert max(errors(*pressed(0.2, 0.2, matching=True, halves=False))) < 1e-6
    rms, largest, _ = errors(*pressed(0.2, 0.2, matching=False, halves=False))
    assert 0.01 < rms < 0.025
    assert largest < 0.15


@pytest.mark.parametrize(("lower", "upper"), [(0.2, 0.1), (0.1, 0.2), (0.1, 0.05), (0.05, 0.1)])
def test_nested_faces_pass(lower, upper):
    """Every node of the coarser face is one of the finer face, which is the slave."""
    model, displacement = pressed(lower, upper)
    between = model.contacts.master_body < 2
    assert set(model.contacts.slave_body[between].tolist()) == {int(upper < lower)}
    assert max(errors(model, displacement)) < 1e-6


@pytest.mark.parametrize(("lower", "upper"), [(0.1, 0.07), (0.07, 0.1)])
def test_faces_that_do_not_match_have_local_errors(lower, upper):
    """What node-to-surface contact gives where no nodes meet: 2 % on average, 12 % in single tetrahedra."""
    rms, largest, shortening = errors(*pressed(lower, upper))
    assert 0.01 < rms < 0.03
    assert largest < 0.15
    assert shortening < 0.002


def test_diagonals_that_differ_are_noticed(monkeypatch):
    """The detector: with the upper block's mesh turned about the vertical axis the diagonals cross; solved whole, it
    fails."""

    def turned(part: BodyMeshes) -> BodyMeshes:
        nodes = part.nodes.copy()
        nodes[:, 0] *= -1
        swapped = part.tetrahedra[:, [0, 2, 1, 3]]
        return replace(part, nodes=nodes, tetrahedra=swapped, side_triangles=part.side_triangles[:, ::-1])

    together = joined
    monkeypatch.setattr(f"{__name__}.joined", lambda parts: together([parts[0], turned(parts[1])]))
    with pytest.raises(AssertionError):
        assert max(errors(*pressed(0.1, 0.1, halves=False))) < 1e-6
