"""Elements along joints whose toes crush."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.macroblocks.bodies import make_bodies
from orchestrator.macroblocks.criteria import one_body_per_block
from orchestrator.masonry.joints import JointClass
from orchestrator.pushover.estimate import estimate
from orchestrator.pushover.meshing import MeshSettings, mesh_bodies, volumes
from orchestrator.pushover.toes import element_ends, graded
from tests.support.pushover_chain import assemblage_of, stack

STRENGTH = 1e5


def bodies_of(*forces, strength=STRENGTH):
    """Two blocks of 0.4 m x 0.5 m x 0.1 m on each other; forces (start, end) of their two joints, N."""
    wall = assemblage_of(stack((0.4, 0.5), (0.4, 0.5), friction=0.6), JointClass(compressive_strength=strength))
    return make_bodies(wall, one_body_per_block(wall), np.array([[*force, 0.0] for force in forces]))


def test_a_toe_is_where_the_resultant_is_near_the_edge():
    """N = 500 N takes 0.05 m: crushing at 0.025 m from the edge; 0.04 m is near it, 0.06 m is not."""
    for distance, toe in ((0.025, 0.05), (0.04, 0.05), (0.06, 0.0)):
        share = distance / 0.4
        bodies = bodies_of((500 * (1 - share), 500 * share), (500 * share, 500 * (1 - share)))
        assert bodies.toe == pytest.approx(np.array([[toe, 0.0], [0.0, toe]]))
    assert not bodies_of((500, 0), (0, 0), strength=None).toe.any(), "joints that do not crush have none"


def test_elements_are_short_over_the_toe_and_grow_from_there():
    ends = graded(1.0, np.array([0.1, 0.0]), 0.2, 0.01, 0.005)
    lengths = np.diff([0.0, *ends, 1.0])
    short = 2 * np.sqrt(0.005 * 0.1)
    assert (lengths[ends.searchsorted(0.1) + 1 :] > lengths[0]).all()
    assert (lengths[: ends.searchsorted(0.1)] <= short * (1 + 1e-3)).all()
    assert lengths.max() <= 0.2 * (1 + 1e-3)
    assert (lengths[1:] / lengths[:-1]).max() < 2.5
    assert graded(1.0, np.array([0.0, 0.1]), 0.2, 0.01, 0.005)[::-1] == pytest.approx(1.0 - ends, abs=1e-9)


def test_elements_scale_with_the_joint():
    one = graded(1.0, np.array([0.1, 0.3]), 0.2, 0.02, 0.005)
    assert graded(1e-3, np.array([1e-4, 3e-4]), 2e-4, 2e-5, 0.005) == pytest.approx(one, rel=1e-9)


@pytest.mark.parametrize("toe", [(0.0, 0.0), (0.005, 0.0)])
def test_no_toe_and_one_that_does_not_matter_leave_the_size(toe):
    assert not len(graded(1.0, np.array(toe), 0.2, 0.02, 0.005))


@pytest.mark.parametrize("matching", [False, True])
def test_both_bodies_of_a_joint_get_the_same_nodes(matching):
    settings = MeshSettings(matching_faces=matching)
    bodies = bodies_of((500, 0), (0, 500))
    meshes = mesh_bodies(bodies, settings)
    for height, both in ((0.0, False), (0.5, True)):
        on = [
            np.unique(meshes.nodes[(meshes.body_of_node == body) & np.isclose(meshes.nodes[:, 1], height), 0].round(9))
            for body in range(2)
        ]
        assert len(on[0]) > 5
        if both:
            assert on[0] == pytest.approx(on[1], abs=1e-8)
    volume = volumes(meshes.nodes, meshes.tetrahedra)
    assert volume.min() > 0.0
    assert volume.sum() == pytest.approx(2 * 0.4 * 0.5 * 0.1)
    whole = mesh_bodies(bodies, MeshSettings(matching_faces=matching, toe_offset=0.5))
    assert len(whole.nodes) < len(meshes.nodes)


def test_the_estimate_knows_the_elements_at_toes():
    bodies = bodies_of((500, 0), (0, 500))
    assert element_ends(bodies, 0.2, 0.005)
    assert estimate(bodies, MeshSettings()).unknowns > 1.2 * estimate(bodies, MeshSettings(toe_offset=0.5)).unknowns
