"""Contacts are found by the numbers of edges and faces: bent joints, points where stones meet, stones out of line."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.macroblocks.bodies import make_bodies
from orchestrator.macroblocks.criteria import one_body_per_block
from orchestrator.masonry.patterns import running_bond
from orchestrator.masonry.wall import Block, Wall
from orchestrator.pushover.contact.contact_search import find_contacts
from orchestrator.pushover.contact.faces import STRAIGHT, find_faces, sides_of_edges, sides_of_faces, touching_faces
from orchestrator.pushover.contact.possible_contacts import TURNED
from orchestrator.pushover.meshing import MeshSettings, mesh_bodies
from orchestrator.pushover.model import displaced
from tests.support.pushover_chain import assemblage_of, model_of, rectangle


def wall_of(*polygons) -> Wall:
    """The first block is the support."""
    blocks = [Block(k, np.array(p, float), k == 0, 25e3) for k, p in enumerate(polygons)]
    return Wall("test", tuple(blocks), 0.1, 0.6)


def bent(height: float) -> Wall:
    """Two stones on each other; the bed between them has a vertex in its middle, `height` (m) too high."""
    support = rectangle(-0.4, -0.2, 0.8, 0.2)
    lower = [[-0.2, 0.0], [0.2, 0.0], [0.2, 0.2], [0.0, 0.2 + height], [-0.2, 0.2]]
    upper = [[-0.2, 0.2], [0.0, 0.2 + height], [0.2, 0.2], [0.2, 0.4], [-0.2, 0.4]]
    return wall_of(support, lower, upper)


@pytest.mark.parametrize(("height", "faces"), [(1e-6, 1), (1e-4, 1), (5e-4, 1), (2e-3, 2), (2e-2, 2)])
def test_a_node_in_a_bend_has_one_contact_where_the_joint_is_nearly_straight(height, faces):
    """0.2 m on both sides: the joint bends by 10 times its height per metre, 1e-5 rad to 0.2 rad."""
    assert (10 * height < STRAIGHT) == (faces == 1)
    model = model_of(bent(height), mesh_size=0.25, large_displacement=True)
    assert set(model.rows.tolist()) <= set(range(model.tracking.touching)), "what touches, and nothing else"
    between = (model.contacts.slave_body < 2) & (model.contacts.master_body < 2)
    middle = between & (np.abs(model.contacts.point[:, 0]) < 1e-9)
    of_a_node = 1 if 10 * height < TURNED else 2
    assert middle.sum() == of_a_node
    assert between.sum() == 2 + of_a_node
    assert np.abs(model.gap_offset).max() < 1e-9
    rows = model.normal_rows.toarray()
    assert np.linalg.matrix_rank(rows) == len(rows)


def test_faces_hold_the_sides_of_their_edges():
    model = model_of(bent(1e-4))
    assemblage = assemblage_of(bent(1e-4))
    bodies = make_bodies(assemblage, one_body_per_block(assemblage))
    faces = find_faces(bodies)
    assert np.bincount(faces.body).tolist() == [4, 4, 4]
    of_edges, of_faces = sides_of_edges(faces, model.meshes), sides_of_faces(faces, model.meshes)
    for number, triangles in enumerate(of_faces):
        parts = [of_edges[edge] for edge in np.flatnonzero(faces.of_edge == number)]
        assert sorted(map(tuple, np.concatenate(parts).tolist())) == sorted(map(tuple, triangles.tolist()))
    assert sum(map(len, of_faces)) == len(model.meshes.side_triangles)


def test_interfaces_on_one_face_have_one_slave():
    """Whichever body of an interface is body i: a node between two of them would have two contacts that are one."""
    assemblage = assemblage_of(bent(1e-4))
    bodies = make_bodies(assemblage, one_body_per_block(assemblage))
    faces, meshes = find_faces(bodies), mesh_bodies(bodies, MeshSettings(), None)
    touching = touching_faces(bodies, faces, sides_of_edges(faces, meshes))
    between = (touching.slave < bodies.moving) & (touching.master < bodies.moving)
    assert between.sum() == 2
    assert len(set(touching.slave[between].tolist())) == 1
    assert (touching.slave < bodies.moving).all(), "a support is never a slave"


def test_contacts_where_five_stones_meet_are_independent():
    """A cross of head and bed joints with a voussoir's joint through it: every pair that shares an edge, once."""
    support = rectangle(-0.6, -0.2, 1.2, 0.2)
    stones = (
        [[-0.5, 0.0], [0.0, 0.0], [0.0, 0.3], [-0.5, 0.3]],
        [[0.0, 0.0], [0.5, 0.0], [0.5, 0.3], [0.0, 0.3]],
        [[-0.5, 0.3], [0.0, 0.3], [-0.3, 0.6], [-0.5, 0.6]],
        [[0.0, 0.3], [0.3, 0.6], [-0.3, 0.6]],
        [[0.0, 0.3], [0.5, 0.3], [0.5, 0.6], [0.3, 0.6]],
    )
    model = model_of(wall_of(support, *stones), large_displacement=True)
    contacts = model.contacts
    at_point = np.flatnonzero(np.linalg.norm(contacts.point - [0.0, 0.3, 0.0], axis=1) < 1e-9)
    pairs = {tuple(sorted(p)) for p in zip(contacts.slave_body[at_point], contacts.master_body[at_point], strict=True)}
    assert len(at_point) == len(pairs) == 5
    rows = model.normal_rows.toarray()
    assert np.linalg.matrix_rank(rows) == len(rows)


@pytest.mark.parametrize("step", [0.0, 2e-4, -2e-4])
@pytest.mark.parametrize("turn", [0.0, 3e-3])
def test_a_stone_that_slides_past_its_neighbour_meets_the_next_one_out_of_line(step, turn):
    """The next stone lies 0.2 mm higher or lower and is turned by 0.2 degrees, as in a drawing that was healed."""
    support = rectangle(-1.0, -0.2, 2.0, 0.2)
    first = rectangle(-0.4, 0.0, 0.4, 0.2)
    following = [[0.0, 0.0], [0.4, 0.0], [0.4, 0.2 + step + 0.4 * turn], [0.0, 0.2 + step]]
    upper = rectangle(-0.4, 0.2, 0.4, 0.2)
    model = model_of(wall_of(support, first, following, upper), large_displacement=True)
    assert not ((model.contacts.slave_body == 2) & (model.contacts.master_body == 1)).any()
    moved = np.zeros_like(model.front.nodes)
    moved[model.front.body_of_node == 2, 0] = 0.1
    contacts = displaced(model, moved.ravel()).contacts
    met = {(int(s), int(m)) for s, m in zip(contacts.slave_body, contacts.master_body, strict=True)}
    assert {(0, 2), (2, 0)} & met
    assert {(1, 2), (2, 1)} & met


@pytest.mark.parametrize(("slid", "meets"), [(0.3e-3, False), (3e-3, True)])
def test_a_stone_that_reaches_the_next_one_rests_on_more_than_its_edge(slid, meets):
    """Beds of 0.4 m side by side, a stone of size 0.28 m on the first slides over by 0.1 % and by 1 % of it."""
    support, upper = rectangle(-1.0, -0.2, 2.0, 0.2), rectangle(-0.4, 0.2, 0.4, 0.2)
    model = model_of(
        wall_of(support, rectangle(-0.4, 0.0, 0.4, 0.2), rectangle(0.0, 0.0, 0.4, 0.2), upper), large_displacement=True
    )
    moved = np.zeros_like(model.front.nodes)
    moved[model.front.body_of_node == 2, 0] = slid
    contacts = displaced(model, moved.ravel()).contacts
    met = {(int(s), int(m)) for s, m in zip(contacts.slave_body, contacts.master_body, strict=True)}
    assert {(0, 2), (2, 0)} & met
    assert bool({(1, 2), (2, 1)} & met) == meets


@pytest.mark.parametrize("scale", [0.1, 10.0])
def test_a_displaced_wall_and_its_similitude_have_the_same_contacts(scale):
    assert contacts_of_a_displaced_wall(scale) == contacts_of_a_displaced_wall(1.0)


def contacts_of_a_displaced_wall(scale: float) -> list[tuple[float, ...]]:
    """Return slave, master and undeformed place over the scale of all contacts, in ascending order."""
    wall = running_bond(3, 4, block_length=0.4 * scale, block_height=0.175 * scale, thickness=0.1 * scale)
    model = model_of(wall, mesh_size=0.2 * scale, large_displacement=True)
    nodes, body, random = model.front.nodes / scale, model.front.body_of_node, np.random.default_rng(1)
    drift, turn = random.uniform(-3e-3, 3e-3, (model.bodies, 2)), random.uniform(-5e-3, 5e-3, model.bodies)
    moved = np.zeros_like(nodes)
    moved[:, 0] = drift[body, 0] - turn[body] * (nodes[:, 1] - 0.35)
    moved[:, 1] = drift[body, 1] + turn[body] * (nodes[:, 0] - 0.6)
    rows, possible = displaced(model, scale * moved.ravel()).rows, model.possible
    assert 25 < len(rows) < len(possible)
    place = np.round(possible.point[rows] / scale, 6).tolist()
    bodies = zip(possible.slave_body[rows].tolist(), possible.master_body[rows].tolist(), strict=True)
    return sorted((*pair, *point) for pair, point in zip(bodies, place, strict=True))


def test_contacts_are_those_of_the_joints():
    assemblage = assemblage_of(running_bond(3, 3))
    bodies = make_bodies(assemblage, one_body_per_block(assemblage))
    contacts = find_contacts(bodies, model_of(running_bond(3, 3)).meshes)
    for k in range(bodies.interfaces.count):
        mine = contacts.interface == k
        assert {*contacts.slave_body[mine].tolist(), *contacts.master_body[mine].tolist()} <= {
            int(bodies.interfaces.i[k]),
            int(bodies.interfaces.j[k]),
        }
        along = (contacts.point[mine, :2] - bodies.interfaces.start[k]) @ (
            bodies.interfaces.end[k] - bodies.interfaces.start[k]
        )
        assert along.min() > -1e-9
        assert along.max() < np.sum((bodies.interfaces.end[k] - bodies.interfaces.start[k]) ** 2) + 1e-9
