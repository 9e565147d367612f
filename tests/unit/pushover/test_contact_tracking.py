"""Contacts of displaced bodies."""

import numpy as np
import pytest

from orchestrator.masonry.patterns import running_bond
from orchestrator.masonry.wall import Block, Wall
from orchestrator.pushover.contact.contact_tracking import COVER
from orchestrator.pushover.model import displaced
from tests.support.pushover_chain import model_of, rectangle, stack


@pytest.mark.parametrize("tilt", [0.0, 2e-3])
def test_motion_out_of_the_plane_moves_no_contact(tilt):
    """The whole wall 3 mm forward, upright or leaning: equilibrium out of the plane is that of the undeformed wall."""
    model = model_of(running_bond(2, 3), large_displacement=True)
    nodes = model.front.nodes
    forward = np.zeros_like(nodes)
    forward[:, 2] = 3e-3 + tilt * nodes[:, 1]
    moved = displaced(model, forward.ravel())
    assert len(moved.contacts) > 10
    assert moved.rows.tolist() == model.rows.tolist()
    assert abs(moved.normal_rows - model.normal_rows).max() < 1e-12
    assert abs(moved.tangential_rows - model.tangential_rows).max() < 1e-12
    assert np.abs(moved.normal_rows @ forward.ravel() + moved.gap_offset).max() < 1e-12


@pytest.mark.parametrize("yaw", [0.0, 2e-3, -2e-3])
def test_a_block_that_slides_over_the_end_of_another_is_held_there_all_the_way(yaw):
    """Solved whole, as 10-node tetrahedra are.

    The lower block has turned about the vertical, so that its front lies ahead of its back by `yaw` (m).

    The upper one's end passes front and back of the lower one's at different times: at either, a contact must be there.
    """
    model = model_of(stack((0.4, 0.3), (0.4, 0.3), friction=0.6), large_displacement=True, halves=False)
    nodes, body = model.front.nodes, model.front.body_of_node
    for slid in np.arange(0.0, 6e-3, 1e-4):
        moved = np.zeros_like(nodes)
        moved[body == 1, 0] = slid
        moved[body == 0, 0] = yaw * (nodes[body == 0, 2] - 0.05) / 0.1
        contacts = displaced(model, moved.ravel()).contacts
        between = (contacts.slave_body < 2) & (contacts.master_body < 2)
        for side in (1, -1):
            at_end = between & (side * contacts.point[:, 0] > 0.19)
            assert set(np.round(contacts.point[at_end, 2], 6)) == {0.0, 0.1}, (slid, side)


@pytest.mark.parametrize("left", [0.0, 0.5])
def test_contacts_of_two_straight_faces_do_not_depend_on_each_other(left):
    """A block on half of a wide one, to the left or to the right, slides 9 mm each way over the node in the middle.

    Three contacts of one straight edge with another would have no unique forces: the wide block's mesh has two edges.
    """
    wall = Wall("two blocks", (
        Block(0, rectangle(-0.2, -0.2, 1.4, 0.2), True, 25e3),
        Block(1, rectangle(0.0, 0.0, 1.0, 0.4), False, 25e3),
        Block(2, rectangle(left, 0.4, 0.5, 0.2), False, 25e3),
    ), 0.2, 0.6)  # fmt: skip
    model = model_of(wall, mesh_size=0.5, large_displacement=True)
    node = model.front.nodes
    size, edge = np.sqrt(0.5 * 0.2), 0.5
    for slid in np.arange(-9e-3, 9.1e-3, 5e-4):
        moved = np.zeros_like(node)
        moved[model.front.body_of_node == 1, 0] = slid
        rows = displaced(model, moved.ravel()).normal_rows.toarray()
        assert np.linalg.svd(rows, compute_uv=False)[-1] > COVER * size / edge, slid


@pytest.mark.parametrize("turn", [-0.02, -0.005, 0.005, 0.02])
def test_of_two_corners_that_meet_the_deeper_one_is_held(turn):
    """The upper block has slid until it rests on the last 2 mm of the lower one, turned about the middle of these.

    Turned counter-clockwise (turn > 0) its own corner sinks in, 1 mm to the left; else that of the lower block does.
    """
    model = model_of(stack((0.4, 0.3), (0.4, 0.3), friction=0.6), large_displacement=True)
    nodes, body = model.front.nodes, model.front.body_of_node
    upper, moved = body == 1, np.zeros_like(nodes)
    corner = np.array([0.199, 0.3]) - [0.398, 0.0]  # what comes to lie at x = 0.199 m, the middle of the 2 mm
    arm = nodes[upper, :2] - corner
    turned = np.column_stack(
        [np.cos(turn) * arm[:, 0] - np.sin(turn) * arm[:, 1], np.sin(turn) * arm[:, 0] + np.cos(turn) * arm[:, 1]]
    )
    moved[upper, :2] = [0.199, 0.3] + turned - nodes[upper, :2]
    contacts = displaced(model, moved.ravel()).contacts
    between = (contacts.slave_body < 2) & (contacts.master_body < 2)
    assert contacts.point[between, 0] == pytest.approx([0.198 if turn > 0 else 0.2], abs=1e-5)
