"""Pictures of mechanisms: moved blocks, hinges, sliding joints, the load, the line of thrust."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from orchestrator.geometry.rigid import polygon_centroid
from orchestrator.loads.dead_loads import DeadLoad
from orchestrator.masonry.interfaces import straight_interfaces
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.ties import Tie
from orchestrator.masonry.wall import Block, Wall
from orchestrator.present import plots
from orchestrator.present.plots.canvas import BLUE, lay_out
from orchestrator.present.plots.load_arrows import load_arrow, settlement_arrow
from orchestrator.present.plots.thrust import carrying, thrust
from orchestrator.present.plots.wall_pictures import hinge_ends, rigid_displacement
from tests.support.figures import polygons, segments, shown
from tests.support.walls import between

FORWARD = np.array([1.0, 0.0])


def test_ends_of_a_tie_move_with_their_blocks_and_an_anchor_stays(assemblage, state):
    """Upper left corner of the third block: by hand it moves up by its velocity and half of it to the right."""
    factor = 0.08 * 1.2 / np.hypot(1.0, 0.5)
    tie = Tie((assemblage.wall.blocks[3].id,), (0.5, 1.0), (3.0, 1.1), 1e3)
    axes = plots.mechanism(assemblage, state, FORWARD, ties=(tie,)).axes[0]
    (bar,) = next(one for one in axes.collections if one.get_label() == "tie").get_segments()
    np.testing.assert_allclose(bar, [[0.5 + 0.5 * factor, 1.0 + factor], [3.0, 1.1]], atol=1e-12)
    assert axes.get_xlim()[1] > 3.0


def test_arrows_of_a_floor_move_with_their_block(assemblage, state):
    """The upper block turns about its lower right corner, (1.5, 0.5): its top rises by the distance from there."""
    factor = 0.08 * 1.2 / np.hypot(1.0, 0.5)
    floor = DeadLoad(level=1.0, line_load=1e3)
    axes = plots.mechanism(assemblage, state, FORWARD, dead=(floor,)).axes[0]
    arrows = next(one for one in axes.collections if one.get_label() == "extra dead loads").get_segments()
    tips = np.array([tip for _, tip in arrows])
    before = tips[:, 0] - 0.5 * factor
    assert before.min() > 0.5
    assert before.max() < 1.5
    np.testing.assert_allclose(tips[:, 1], 1.0 + factor * (1.5 - before), atol=1e-12)
    assert axes.get_ylim()[1] > max(start[1] for start, _ in arrows)


def test_mechanism_moves_blocks_by_their_velocities_scaled_to_8_percent_of_the_height(assemblage, state):
    figure = plots.mechanism(assemblage, state, FORWARD)
    factor = 0.08 * 1.2 / np.hypot(1.0, 0.5)
    assert len(polygons(figure, 0)) == 4  # undeformed outlines, support included
    moved = polygons(figure, 1)
    np.testing.assert_allclose(moved[0], assemblage.wall.blocks[1].polygon)
    # velocities at the corners by hand: lower left, lower right, upper right, upper left
    expected = between(0.5, 0.5, 1.5, 1) + factor * np.array([[0, 1], [0, 0], [0.5, 0], [0.5, 1]])
    np.testing.assert_allclose(moved[2], expected, atol=1e-12)
    assert max(np.linalg.norm(moved[2] - between(0.5, 0.5, 1.5, 1), axis=1)) == pytest.approx(0.096)
    assert figure.axes[0].get_title().splitlines()[1:] == [
        "Mechanism of micro-LA (the paper's sequence): load multiplier 0.2963",
        "largest displacement drawn as 0.096 m (8% of the height)",
    ]


def test_mechanism_marks_hinges_and_joints_that_slide_under_load(assemblage, state):
    figure = plots.mechanism(assemblage, state, FORWARD)
    np.testing.assert_allclose(segments(figure, BLUE), [[[1, 0], [1, 0.5]]])  # joint 3 slips too, but came apart
    (hinges,) = figure.axes[0].lines
    np.testing.assert_allclose(hinges.get_xydata(), [[1.5, 0.5]], atol=1e-12)
    assert shown(figure)[1] == [
        "undeformed",
        "displaced",
        "support",
        "thrust (widest: 0.005 kN)",
        "sliding joint",
        "hinge",
    ]


def test_the_legend_of_a_mechanism_names_what_is_there(assemblage, state):
    rocking = replace(state.mechanism, slip=np.zeros(5))
    assert "sliding joint" not in shown(plots.mechanism(assemblage, replace(state, mechanism=rocking), FORWARD))[1]
    sliding = replace(state.mechanism, opening=np.zeros((5, 2)))
    assert "hinge" not in shown(plots.mechanism(assemblage, replace(state, mechanism=sliding), FORWARD))[1]


@pytest.mark.parametrize("direction", [1, -1])
def test_mechanism_shows_the_load_beside_the_wall_it_pushes(assemblage, state, direction):
    axes = plots.mechanism(assemblage, state, direction * FORWARD).axes[0]
    arrow = next(text for text in axes.texts if text.get_text() == "")
    (tip, _), (tail, height) = arrow.xy, arrow.xyann
    assert np.sign(tip - tail) == direction
    assert tip < 0.0 if direction > 0 else tip > 2.0
    assert axes.get_xlim()[0] < min(tip, tail) < max(tip, tail) < axes.get_xlim()[1]
    assert height == pytest.approx((2 * 0.25 + 1 * 0.75) / 3), "of the weight's resultant"


@pytest.mark.parametrize("left", [-1.0, 8.0])
def test_the_arrow_of_a_settlement_points_down_beside_the_support_that_sinks(left):
    wall = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 6.0], [0.0, 6.0]])
    support = np.array([[left, -0.5], [left + 3.0, -0.5], [left + 3.0, 0.0], [left, 0.0]])
    tail, tip = settlement_arrow(support, wall, np.array([0.0, -1.0]))
    assert tip[1] < tail[1]
    assert tip[0] == pytest.approx(tail[0])
    assert tail[0] < left if left < 0.0 else tail[0] > left + 3.0
    assert 0.5 * (tail[1] + tip[1]) == pytest.approx(-0.25)


@pytest.mark.parametrize("name", ["settlement", "λ × weight × height, as given on named blocks"])
def test_the_name_of_a_load_stands_within_the_frame(assemblage, state, name):
    """However long it is, and beside an upright arrow at the edge of the picture, too."""
    for direction in (FORWARD, np.array([0.0, -1.0])):
        figure = plots.mechanism(assemblage, state, direction, name)
        FigureCanvasAgg(figure)
        lay_out(figure)
        figure.set_layout_engine("none")
        axes = figure.axes[0]
        (text,) = [one for one in axes.texts if one.get_text() == name]
        written, frame = text.get_window_extent(), axes.get_window_extent()
        assert frame.x0 < written.x0 < written.x1 < frame.x1
        assert frame.y0 < written.y0 < written.y1 < frame.y1


@pytest.mark.parametrize("direction", [1, -1])
def test_load_arrow_turns_with_the_load_and_keeps_clear_of_the_wall(direction):
    points = np.array([[0.0, 0.0], [2.0, 1.0]])
    tail, tip = load_arrow(points, np.array([direction * np.cos(np.pi / 6), np.sin(np.pi / 6)]), 0.7)
    assert 0.5 * (tail[1] + tip[1]) == pytest.approx(0.7)
    assert np.arctan2(tip[1] - tail[1], direction * (tip[0] - tail[0])) == pytest.approx(np.pi / 6)
    assert all((x < 0.0 if direction > 0 else x > 2.0) for x, _ in (tail, tip))


def test_thrust_crosses_joints_at_their_resultants_and_ends_in_the_support_along_them():
    """Block 2 x 1 rocking about its toe under 0.6 of its weight W: all through the toe, at slope 1 : 0.6."""
    blocks = (Block(0, between(-1, -1, 3, 0), True, 1e3), Block(1, between(0, 0, 2, 1), False, 1e3))
    ends = np.array([[2.0, 0.0]]), np.array([[0.0, 0.0]])
    joints = straight_interfaces(np.array([0]), np.array([1]), *ends, 1.0, np.array([0.65]))
    stack = Assemblage(Wall("w", blocks, 1.0, 0.65), joints)
    drawn = thrust(stack, np.array([[2000.0, 0.0, 1200.0]]))
    np.testing.assert_allclose(drawn.segments[:, 0], [[2.0, 0.0]] * 2)
    tangent, down = stack.joints.tangent[0], -stack.joints.normal[0]
    np.testing.assert_allclose(np.cross(drawn.segments[0, 1] - [2.0, 0.0], down - 0.6 * tangent), 0.0, atol=1e-12)
    assert drawn.segments[0, 1, 1] < 0.0
    assert drawn.resultant == pytest.approx(2000.0 * np.hypot(1.0, 0.6))


def test_thrust_of_a_block_with_two_joints_is_a_straight_line_between_them():
    blocks = tuple(Block(n, between(0, n, 2, n + 1), n == 0, 1e3) for n in range(3))
    start, end = np.array([[2.0, 1.0], [2.0, 2.0]]), np.array([[0.0, 1.0], [0.0, 2.0]])
    joints = straight_interfaces(np.array([0, 1]), np.array([1, 2]), start, end, 1.0, np.full(2, 0.65))
    stack = Assemblage(Wall("w", blocks, 1.0, 0.65), joints)
    drawn = thrust(stack, np.array([[3.0, 1.0, 0.5], [1.0, 1.0, 0.5]]))
    inside = drawn.segments[drawn.block == 1]
    np.testing.assert_allclose(sorted(inside[:, 0].tolist()), [[1.0, 2.0], [1.5, 1.0]])
    np.testing.assert_allclose(inside[0, 1], inside[1, 1])
    np.testing.assert_allclose(np.cross(inside[0, 1] - [1.5, 1.0], np.array([1.0, 2.0]) - [1.5, 1.0]), 0.0, atol=1e-12)


def test_rigid_displacement_is_about_the_centroid():
    block = Block(1, between(1, 1, 3, 2), False, 1.0)
    found = rigid_displacement(block, np.array([0.1, 0.2, 0.5]), np.array([[2, 1.5], [3, 2]]))
    np.testing.assert_allclose(found, [[0.1, 0.2], [0.1 - 0.25, 0.2 + 0.5]])


def test_centroid_of_an_l_shape_far_from_the_origin():
    shape = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], dtype=float) + 1e6
    np.testing.assert_allclose(polygon_centroid(shape) - 1e6, [5 / 6, 5 / 6], rtol=1e-9)


def test_hinge_is_a_joint_that_opens_at_one_end_only():
    opening = np.array([[0.0, 1.0], [1.0, 1e-5], [1.0, 0.5], [0.0, 0.0], [-0.2, 1.0]])
    assert hinge_ends(opening, 0.01).tolist() == [0, 1, -1, -1, -1]


def test_a_joint_carries_load_when_either_end_is_pressed():
    assert carrying(np.array([[0, 1, 0], [1, 0, 0], [1e-9, 0, 5], [0, 0, 0.0]])).tolist() == [True, True, False, False]
