"""Overlap of displaced outlines: stones pushed into each other by a known depth."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.macroblocks.bodies import make_bodies
from orchestrator.macroblocks.criteria import one_body_per_block, partition_of
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.wall import Wall
from orchestrator.pushover.meshing import MeshSettings, mesh_bodies
from orchestrator.pushover.path.body_overlap import DisplacedOutlines
from tests.support.pushover_chain import assemblage_of, stack
from tests.support.walls import upright

STANDING = np.zeros(2, bool)


@pytest.fixture(scope="module")
def wall():
    """A stone of 0.4 m x 0.3 m and one of 0.2 m x 0.5 m on it."""
    assemblage = assemblage_of(stack((0.4, 0.3), (0.2, 0.5), friction=0.6))
    bodies = make_bodies(assemblage, one_body_per_block(assemblage))
    return DisplacedOutlines(bodies, mesh_bodies(bodies, MeshSettings(size=0.2), None))


def moved(wall, body, right, up):
    meshes = wall.meshes
    displacement = np.zeros_like(meshes.nodes)
    displacement[meshes.body_of_node == body, :2] = [right, up]
    return displacement


def test_stones_that_touch_do_not_overlap(wall):
    found = wall.largest_overlap(moved(wall, 1, 0.03, 0.0), STANDING)
    assert found.distance < 1e-12
    assert found.share < 1e-12


@pytest.mark.parametrize("depth", [1e-6, 1e-4, 1e-3])
def test_a_stone_that_sinks_in_overlaps_by_the_depth(wall, depth):
    """The smaller stone has an area of 0.1 m2."""
    found = wall.largest_overlap(moved(wall, 1, 0.03, -depth), STANDING)
    assert found.distance == pytest.approx(depth, rel=1e-6)
    assert found.share == pytest.approx(depth / np.sqrt(0.1), rel=1e-6)
    assert set(found.names) == {"block 1", "block 2"}
    assert found.place[1] == pytest.approx(0.3 - depth / 2, abs=depth)


def test_a_stone_that_sinks_into_the_support_is_found(wall):
    found = wall.largest_overlap(moved(wall, 0, 0.0, -1e-4), STANDING)
    assert found.distance == pytest.approx(1e-4, rel=1e-6)
    assert set(found.names) == {"block 1", "the support"}


def test_a_frame_around_a_large_hole_is_no_full_stone():
    """Four stones round a window are one body of 0.19 m2 round a hole of 0.81 m2: a stone within it overlaps nothing,
    one in its jamb does."""
    frame = [upright(1, 0, 0, 1, 0.05), upright(2, 0, 0.95, 1, 0.05), upright(3, 0, 0.05, 0.05, 0.9)]
    frame += [upright(4, 0.95, 0.05, 0.05, 0.9), upright(5, 0.4, 0.05, 0.2, 0.2)]
    blocks = [upright(0, -1, -0.2, 3, 0.2, fixed=True), *frame]
    assemblage = find_joints(Wall("frame", tuple(blocks), 0.3, 0.6), JointSettings())
    bodies = make_bodies(assemblage, partition_of(assemblage, np.array([0, 1, 1, 1, 1, 2])))
    outlines = DisplacedOutlines(bodies, mesh_bodies(bodies, MeshSettings(size=0.05), None))
    small = int(np.argmin([body.area for body in bodies.bodies[: bodies.moving]]))
    assert outlines.largest_overlap(moved(outlines, small, 0.2, 0.3), STANDING).distance < 1e-12
    assert outlines.largest_overlap(moved(outlines, small, 0.37, 0.3), STANDING).distance == pytest.approx(0.02)


def test_mortar_may_close_by_as_much(wall):
    assert wall.largest_overlap(moved(wall, 1, 0.0, -1e-3), STANDING, 1e-3).distance < 1e-12


def test_a_gap_is_no_overlap(wall):
    assert wall.largest_overlap(moved(wall, 1, 0.0, 1e-3), STANDING).distance == 0.0


def test_what_has_fallen_may_lie_anywhere(wall):
    fallen = np.array([False, True])
    assert wall.largest_overlap(moved(wall, 1, 0.0, -0.2), fallen).distance == 0.0
