"""Elements along joints whose toes crush."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.macroblocks.bodies import make_bodies
from orchestrator.macroblocks.criteria import one_body_per_block
from orchestrator.masonry.joints import JointClass
from orchestrator.pushover.estimate import estimate
from orchestrator.pushover.meshing import MeshSettings, mesh_bodies, volumes
from orchestrator.pushover.toes import Toes, element_ends, graded
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


def along(length, *toes, size=0.2):
    """Where elements end along an edge from (0, 0) with toes: place (x, y), element, over which distance."""
    place, element, over = map(np.array, zip(*toes, strict=True))
    return graded(
        np.zeros(2),
        np.array([length, 0.0]),
        Toes(
            place,
            element,
            over,
            np.full(len(toes), np.inf),
            np.zeros((len(toes), 2), int),
            np.ones((len(toes), 2), bool),
        ),
        size,
    )


def test_elements_are_short_over_the_toe_and_grow_from_there():
    ends = along(1.0, ((0.0, 0.0), 0.045, 0.15))
    lengths = np.diff([0.0, *ends, 1.0])
    assert (lengths[: ends.searchsorted(0.15)] <= 0.045 * (1 + 1e-3)).all()
    assert (lengths[ends.searchsorted(0.15) + 1 :] > lengths[0]).all()
    assert lengths.max() <= 0.2 * (1 + 1e-3)
    assert (lengths[1:] / lengths[:-1]).max() < 2.5
    assert along(1.0, ((1.0, 0.0), 0.045, 0.15))[::-1] == pytest.approx(1.0 - ends, abs=1e-9)


def test_elements_of_other_edges_are_short_near_a_toe_too():
    """An edge 0.1 m beside the toe: 0.04 + 0.7 (0.1 - 0.05) m at its start."""
    near, far = along(1.0, ((0.0, 0.1), 0.04, 0.05)), along(1.0, ((0.0, 0.3), 0.04, 0.05))
    assert near[0] == pytest.approx(0.075, rel=0.2)
    assert not len(far)


def test_elements_scale_with_the_joint():
    one = along(1.0, ((0.0, 0.0), 0.045, 0.1), ((1.0, 0.0), 0.07, 0.3))
    tenth = along(1e-3, ((0.0, 0.0), 4.5e-5, 1e-4), ((1e-3, 0.0), 7e-5, 3e-4), size=2e-4)
    assert tenth == pytest.approx(one, rel=1e-9)


def test_a_toe_that_does_not_matter_leaves_the_size():
    """Half of a toe of 0.05 m is 6 % of the joint."""
    bodies = bodies_of((500, 0), (0, 500))
    assert element_ends(bodies, 0.2, 0.06)
    assert not element_ends(bodies, 0.2, 0.065)


def test_a_bond_that_has_cracked_has_a_toe_that_does_not_depend_on_the_force():
    """1.23 L (3 f_t L / (pi E delta))^(1/2), of both stones' compliances; limit analysis says which end."""
    wall = assemblage_of(stack((0.4, 0.5), (0.4, 0.5), friction=0.6), JointClass(cohesion=1e5, tensile_strength=1e4))
    pull = 0.5 * 1e4 * 0.4 * 0.1
    for more in (0.0, 500.0):
        forces = np.array([[-pull, pull + more, 0.0], [-0.4 * pull, 0.3 * pull, 0.0]])
        bodies = make_bodies(wall, one_body_per_block(wall), forces, 2e9, 1e-4)
        one, both = (1.23 * 0.4 * np.sqrt(3e4 * 0.4 * stones / (np.pi * 2e9 * 1e-4)) for stones in (1, 2))
        assert bodies.bond_toe == pytest.approx([one, both])
        assert bodies.toe == pytest.approx(np.array([[0.0, one], [0.0, 0.0]]))


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


def test_elements_across_a_column_that_leans_are_short_along_it():
    """Four over its width of 0.4 m, for eight widths."""
    bends = np.array([[True, False]])
    sides = np.zeros((1, 2), int)
    column = Toes(np.zeros((1, 2)), np.array([0.01]), np.array([0.02]), np.array([0.4]), sides, bends)
    ends = graded(np.zeros(2), np.array([0.0, 6.0]), column, 1.0) * 6.0
    lengths = np.diff([0.0, *ends, 6.0])
    assert lengths[ends.searchsorted(1.0) : ends.searchsorted(3.0)] == pytest.approx(0.1, rel=0.05)
    assert lengths[-1] > 0.5
