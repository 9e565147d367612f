from __future__ import annotations

import numpy as np
import pytest
import shapely

from orchestrator.macroblocks.bodies import Part, make_bodies
from orchestrator.macroblocks.criteria import Partition, one_body, one_body_per_block
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.patterns import running_bond
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.masonry.wall import Block, Wall
from tests.support.paths import DATA, PROJECT
from tests.support.walls import between


def assemblage_of(*blocks):
    """Blocks given as polygons; the first is the support."""
    made = tuple(Block(number, np.array(p, dtype=float), number == 0, 25e3) for number, p in enumerate(blocks))
    return find_joints(Wall("test", made, 0.1, 0.6), JointSettings())


def partition_of(assemblage, *bodies):
    """Return the partition whose bodies are the given sets of block ids, supports last."""
    number = {block: k for k, body in enumerate(bodies) for block in body}
    body_of_block = np.array([number.get(block.id, len(bodies)) for block in assemblage.wall.blocks])
    same = np.flatnonzero(body_of_block[assemblage.joints.i] == body_of_block[assemblage.joints.j])
    return Partition(body_of_block, len(bodies), same, np.zeros(0, int), None)


def has_vertex(ring, point):
    return bool((np.linalg.norm(ring - point, axis=1) < 1e-9).any())


@pytest.fixture
def bond():
    return find_joints(running_bond(2, 2), JointSettings())


def test_joint_ends_are_imprinted_on_both_sides(bond):
    bodies = make_bodies(bond, one_body_per_block(bond))
    assert len(bodies.joint) == bond.joints.count == 2 + 1 + 4 + 2
    for k in range(len(bodies.joint)):
        for body in (bodies.interfaces.i[k], bodies.interfaces.j[k]):
            for end in (bodies.interfaces.start[k], bodies.interfaces.end[k]):
                assert has_vertex(bodies.bodies[body].exterior, end)


def test_a_whole_block_under_two_half_ones_has_a_vertex_in_the_middle_and_no_other(bond):
    bodies = make_bodies(bond, one_body_per_block(bond))
    bottom_left = bodies.bodies[0].exterior
    expected = {(0.0, 0.0), (0.4, 0.0), (0.4, 0.175), (0.2, 0.175), (0.0, 0.175)}
    assert {(round(x, 9), round(y, 9)) for x, y in bottom_left} == expected


def test_collinear_vertices_of_merged_blocks_vanish_and_joint_ends_stay(bond):
    """The lower course merged: its top keeps the ends of the joints above it, its base those of the blocks' joints."""
    partition = partition_of(bond, {1, 2}, {3}, {4}, {5})
    course = make_bodies(bond, partition).bodies[0]
    assert course.area == pytest.approx(0.8 * 0.175)
    assert {round(x, 9) for x, y in course.exterior if y > 0.1} == {0.0, 0.2, 0.4, 0.6, 0.8}
    assert {round(x, 9) for x, y in course.exterior if y < 0.1} == {0.0, 0.4, 0.8}


def test_interfaces_run_counter_clockwise_round_body_i(bond):
    bodies = make_bodies(bond, partition_of(bond, {1, 2}, {3, 4}, {5}))
    assert len(bodies.joint) > 3
    for k in range(len(bodies.joint)):
        tangent = bodies.interfaces.end[k] - bodies.interfaces.start[k]
        left = 0.5 * (bodies.interfaces.start[k] + bodies.interfaces.end[k]) + 1e-3 * np.array(
            [-tangent[1], tangent[0]]
        )
        assert shapely.Polygon(bodies.bodies[bodies.interfaces.i[k]].exterior).contains(shapely.Point(left))
        assert bodies.interfaces.i[k] != bodies.interfaces.j[k]


def test_a_body_round_an_opening_has_a_hole_and_one_round_another_body_has_its_joints_on_it():
    frame = [
        between(-1, -1, 4, 0),
        between(0, 0, 3, 1),
        between(0, 1, 1, 2),
        between(2, 1, 3, 2),
        between(0, 2, 3, 3),
    ]
    opening = assemblage_of(*frame)
    body = make_bodies(opening, one_body(opening)).bodies[0]
    assert len(body.holes) == 1
    assert body.area == pytest.approx(8.0)
    assert shapely.LinearRing(body.exterior).is_ccw
    assert not shapely.LinearRing(body.holes[0]).is_ccw
    filled = assemblage_of(*frame, between(1, 1, 2, 2))
    bodies = make_bodies(filled, partition_of(filled, {1, 2, 3, 4}, {5}))
    assert len(bodies.bodies[0].holes) == 1
    pairs = [{int(i), int(j)} for i, j in zip(bodies.interfaces.i, bodies.interfaces.j, strict=True)]
    assert pairs.count({0, 1}) == 4
    assert pairs.count({0, 2}) == 1
    assert len(pairs) == 5


def test_openings_of_wall_6_are_holes_of_the_trivial_body():
    wall = read_blocks(PROJECT / "meshes" / "ferris_tinloi_wall6.json")
    assemblage = find_joints(wall, JointSettings())
    bodies = make_bodies(assemblage, one_body(assemblage))
    assert bodies.moving == 1
    openings = sorted(tuple(np.round([*hole.min(axis=0), *hole.max(axis=0)], 6)) for hole in bodies.bodies[0].holes)
    assert openings == [
        (0.6, 0.7, 1.0, 1.575),
        (0.6, 2.1, 1.0, 2.975),
        (1.8, 0.7, 2.2, 1.575),
        (1.8, 2.1, 2.2, 2.975),
    ]
    assert bodies.bodies[0].area == pytest.approx(22.225 / 25.0 / 0.1)


def test_body_that_touches_itself_in_a_point_keeps_its_opening():
    """Three L-connected stones round a square gap that is closed by one corner only."""
    ring = assemblage_of(
        between(-1, -1, 3, 0), between(0, 0, 2, 1), between(0, 1, 1, 2), between(0, 2, 3, 3),
        between(2, 1, 3, 2),
    )  # fmt: skip
    body = make_bodies(ring, one_body(ring)).bodies[0]
    assert body.area == pytest.approx(2 + 1 + 3 + 1)
    assert shapely.Polygon(body.exterior, body.holes).is_valid


def test_rounded_drawings_keep_their_area():
    wall = read_blocks(DATA / "arch27_t0107.json")
    assemblage = find_joints(wall, JointSettings())
    body = make_bodies(assemblage, one_body(assemblage)).bodies[0]
    assert body.area == pytest.approx(
        sum(shapely.Polygon(b.polygon).area for b in wall.blocks if not b.fixed), rel=1e-4
    )
    assert body.holes == ()


def test_unit_weight_is_weight_over_volume():
    light, heavy = Block(1, between(0, 0, 1, 1), False, 10e3), Block(2, between(1, 0, 4, 1), False, 20e3)
    wall = Wall("two", (Block(0, between(-1, -1, 5, 0), True, 1.0), light, heavy), 0.1, 0.6)
    assemblage = find_joints(wall, JointSettings())
    assert make_bodies(assemblage, one_body(assemblage)).bodies[0].unit_weight == pytest.approx(17.5e3)


def test_bodies_of_one_material_have_exactly_the_constants_of_the_case():
    """Not but for rounding: constants that differ in the last digit would change every result in the last digits."""
    assemblage = find_joints(read_blocks(DATA / "ferris_tinloi_wall3.json"), JointSettings())
    for bodies in (
        make_bodies(assemblage, one_body(assemblage)),
        make_bodies(assemblage, one_body_per_block(assemblage)),
    ):
        assert {body.parts for body in bodies.bodies} == {(Part(1.0, None, None),)}
