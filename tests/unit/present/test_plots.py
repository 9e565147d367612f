"""Pictures of hand-made walls: what is drawn, where, in which colour; files that are not blank."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from io import BytesIO
from itertools import pairwise
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib import colormaps
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PathCollection, PolyCollection
from matplotlib.colors import to_hex, to_rgb
from matplotlib.image import imread
from matplotlib.patches import PathPatch

from orchestrator.assessment.capacity import Capacity
from orchestrator.limit_analysis.paper.limit_state import LimitAnalysis, LimitState, Mechanism
from orchestrator.macroblocks.bodies import Bodies, Body
from orchestrator.macroblocks.criteria import Partition
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.patterns import running_bond
from orchestrator.masonry.ties import Tie
from orchestrator.masonry.wall import Block, Wall
from orchestrator.present import plots
from orchestrator.present.joint_pieces import closed_loops, nodes_of_contacts, shares_of_interface
from orchestrator.present.plots.canvas import BLUE, INK, STONE, VERMILLION, lay_out, legend_below, wall_figure
from orchestrator.present.plots.pushover_pictures import outline, readable_factor
from orchestrator.present.plots.thrust import carrying, thrust
from orchestrator.present.plots.wall_pictures import (
    centroid,
    colours_of_bodies,
    hinge_ends,
    load_arrow,
    rigid_displacement,
    settlement_arrow,
)
from orchestrator.pushover.increments import Increment, PushoverCurve
from orchestrator.pushover.meshing import BodyMeshes
from tests.support.walls import between, four_blocks


@pytest.fixture
def assemblage():
    return four_blocks()


@pytest.fixture
def state():
    """Block 13 rocks about its lower right corner while joint 2, pressed together, is said to slip."""
    velocities = np.zeros((4, 3))
    velocities[3] = [0.25, 0.5, -1.0]  # about (1.5, 0.5): the lower left corner rises by 1
    opening = np.array([[0, 0], [0, 0], [0, 0], [0.5, 1.0], [0, 0.5]])
    forces = np.array([[1, 1, 0], [1, 1, 0], [1, 1, 1], [0, 0, 0], [5, 0, 0]], dtype=float)
    mechanism = Mechanism(velocities, opening, np.array([0, 0, 0.3, 0.4, 0.0]), float(np.hypot(1.0, 0.5)))
    return LimitState("sequence", 0.2963, forces, mechanism, (), True, 0.0, 0.0, 0.0, 0.0)


def polygons(figure, collection):
    """Corners of a PolyCollection of the first axes, without the closing point."""
    found = [c for c in figure.axes[0].collections if isinstance(c, PolyCollection)]
    return [path.vertices[:-1] for path in found[collection].get_paths()]


def segments(figure, colour):
    """Segments of all line collections of one colour."""
    found = [c for c in figure.axes[0].collections if isinstance(c, LineCollection)]
    chosen = [c for c in found if to_hex(c.get_color()[0]) == to_hex(colour)]
    return [segment for c in chosen for segment in c.get_segments()]


def shown(figure):
    """All texts of the axes and the labels of the legend."""
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    return [text.get_text() for text in figure.axes[0].texts], legend


def drawn(figure):
    """The canvas after drawing: positions are final, pixels exist (a bare figure's canvas draws nothing)."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return canvas


def pixel(figure, x, y):
    """Colour drawn at x, y in m."""
    canvas = drawn(figure)
    across, up = figure.axes[0].transData.transform((x, y))
    return to_hex(np.asarray(canvas.buffer_rgba())[-1 - int(up), int(across)] / 255)


# blocks


def test_every_block_is_drawn_where_it_stands_and_supports_are_hatched(assemblage):
    figure = plots.blocks(assemblage.wall, numbered=True)
    np.testing.assert_array_equal(polygons(figure, 0), [b.polygon for b in assemblage.wall.blocks[1:]])
    np.testing.assert_array_equal(polygons(figure, 1), [assemblage.wall.blocks[0].polygon])
    assert [c.get_hatch() for c in figure.axes[0].collections] == [None, "////"]
    texts, legend = shown(figure)
    assert texts == ["10", "11", "12", "13"]
    np.testing.assert_allclose(figure.axes[0].texts[3].get_position(), [1.0, 0.75])
    assert legend == ["block", "support"]
    assert (figure.axes[0].get_xlabel(), figure.axes[0].get_ylabel()) == ("x (m)", "y (m)")
    assert figure.axes[0].get_title() == "hand made\n3 blocks, 1 support"


def test_materials_have_colours_of_their_own_and_a_legend(assemblage):
    ground, *stones = assemblage.wall.blocks
    named = [replace(block, material=name) for block, name in zip(stones, ("brick", "", "brick"), strict=True)]
    figure = plots.blocks(replace(assemblage.wall, blocks=(ground, *named)))
    assert shown(figure)[1] == ["block", "brick (2)", "support"]
    places = [block.polygon.mean(axis=0) for block in stones]
    colours = [pixel(figure, *place) for place in places]
    assert colours[0] == colours[2] != colours[1]
    assert colours[1] == STONE


@pytest.mark.parametrize("name", ["$x", "$x_$", "_hidden", "a$\\frac$"])
def test_materials_may_have_any_name(assemblage, name):
    named = [replace(block, material=name) for block in assemblage.wall.blocks]
    figure = plots.blocks(replace(assemblage.wall, blocks=tuple(named)))
    drawn(figure)
    assert [label.strip().replace("\\$", "$") for label in shown(figure)[1]] == [f"{name} (3)", "support"]


def test_everything_drawn_lies_inside_the_axes(assemblage):
    axes = plots.blocks(assemblage.wall).axes[0]
    assert axes.get_xlim()[0] < 0.0 < 2.0 < axes.get_xlim()[1]
    assert axes.get_ylim()[0] < -0.2 < 1.0 < axes.get_ylim()[1]


def test_numbers_of_two_thousand_stones_are_few_artists_at_the_centroids():
    wall = running_bond(40, 60)
    figure = plots.blocks(wall, numbered=True)
    digits = [c for c in figure.axes[0].collections if isinstance(c, PathCollection)]
    assert not figure.axes[0].texts
    assert len(digits) < 100
    offsets = np.vstack([c.get_offsets() for c in digits])
    expected = np.vstack([np.tile(centroid(b.polygon), (len(str(b.id)), 1)) for b in wall.blocks])
    np.testing.assert_allclose(*(p[np.lexsort(np.round(p, 9).T)] for p in (offsets, expected)), atol=1e-9)
    boxes = [c.get_paths()[0].get_extents() for c in digits if len(c.get_offsets())]
    assert min(box.x0 for box in boxes) == pytest.approx(-max(box.x1 for box in boxes), abs=0.5)  # points


def test_numbers_are_left_out_unless_asked_for(assemblage):
    assert shown(plots.blocks(assemblage.wall))[0] == []


@pytest.mark.parametrize("name", ["from $5^{ to $6", "very " * 40 + "long", "<svg> & \\alpha"])
def test_any_name_can_be_drawn_and_fits(assemblage, name, tmp_path):
    figure = plots.blocks(replace(assemblage.wall, name=name))
    plots.save(figure, tmp_path, "blocks")
    drawn(figure)
    box = figure.axes[0].title.get_window_extent()
    assert 0 < box.x0 < box.x1 < figure.bbox.width
    assert figure.axes[0].get_title().splitlines()[0][:12] == name[:12]
    ElementTree.parse(tmp_path / "blocks.svg")


@pytest.mark.parametrize("legend", [0, 2, 7])
@pytest.mark.parametrize("size", [(5, 6), (7, 7.5), (2.2, 1.3), (2, 2.4), (1, 8), (8, 1)])
def test_no_line_of_a_title_is_cut_off(size, legend):
    figure, axes = wall_figure(np.array([[0, 0], size]), "load multiplier 0.12\ndisplacements drawn × 5", "a wall")
    for number in range(legend):
        axes.plot([], [], label=f"label {number}")
    legend_below(axes, 3)
    lay_out(figure)
    drawn(figure)
    title = axes.title.get_window_extent()
    assert title.y1 <= figure.bbox.y1
    assert 0 <= title.x0 <= title.x1 <= figure.bbox.x1


def test_a_wall_far_from_the_origin_is_drawn_without_an_offset_on_the_axes(assemblage):
    blocks = tuple(replace(b, polygon=b.polygon + np.array([5e5, 4e6])) for b in assemblage.wall.blocks)
    figure = plots.blocks(replace(assemblage.wall, blocks=blocks))
    drawn(figure)
    assert figure.axes[0].xaxis.get_offset_text().get_text() == ""
    assert polygons(figure, 0)[0][0].tolist() == [5e5, 4e6]


# mechanism


def test_ends_of_a_tie_move_with_their_blocks_and_an_anchor_stays(assemblage, state):
    """Upper left corner of the third block: by hand it moves up by its velocity and half of it to the right."""
    factor = 0.08 * 1.2 / np.hypot(1.0, 0.5)
    tie = Tie((assemblage.wall.blocks[3].id,), (0.5, 1.0), (3.0, 1.1), 1e3)
    axes = plots.mechanism(assemblage, state, 1, ties=(tie,)).axes[0]
    (bar,) = next(one for one in axes.collections if one.get_label() == "tie").get_segments()
    np.testing.assert_allclose(bar, [[0.5 + 0.5 * factor, 1.0 + factor], [3.0, 1.1]], atol=1e-12)
    assert axes.get_xlim()[1] > 3.0


def test_mechanism_moves_blocks_by_their_velocities_scaled_to_8_percent_of_the_height(assemblage, state):
    figure = plots.mechanism(assemblage, state, 1)
    factor = 0.08 * 1.2 / np.hypot(1.0, 0.5)
    assert len(polygons(figure, 0)) == 4  # undeformed outlines, support included
    moved = polygons(figure, 1)
    np.testing.assert_allclose(moved[0], assemblage.wall.blocks[1].polygon)
    # velocities at the corners by hand: lower left, lower right, upper right, upper left
    expected = between(0.5, 0.5, 1.5, 1) + factor * np.array([[0, 1], [0, 0], [0.5, 0], [0.5, 1]])
    np.testing.assert_allclose(moved[2], expected, atol=1e-12)
    assert max(np.linalg.norm(moved[2] - between(0.5, 0.5, 1.5, 1), axis=1)) == pytest.approx(0.096)
    assert figure.axes[0].get_title().splitlines()[1:] == [
        "Mechanism of micro-LA (sequence): load multiplier 0.2963",
        "largest displacement drawn as 0.096 m (8% of the height)",
    ]


def test_mechanism_marks_hinges_and_joints_that_slide_under_load(assemblage, state):
    figure = plots.mechanism(assemblage, state, 1)
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


@pytest.mark.parametrize("direction", [1, -1])
def test_mechanism_shows_the_load_beside_the_wall_it_pushes(assemblage, state, direction):
    axes = plots.mechanism(assemblage, state, direction).axes[0]
    arrow = next(text for text in axes.texts if text.get_text() == "")
    (tip, _), (tail, height) = arrow.xy, arrow.xyann
    assert np.sign(tip - tail) == direction
    assert tip < 0.0 if direction > 0 else tip > 2.0
    assert axes.get_xlim()[0] < min(tip, tail) < max(tip, tail) < axes.get_xlim()[1]
    assert height == pytest.approx(0.5)


@pytest.mark.parametrize("left", [-1.0, 8.0])
def test_the_arrow_of_a_settlement_points_down_beside_the_support_that_sinks(left):
    wall = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 6.0], [0.0, 6.0]])
    support = np.array([[left, -0.5], [left + 3.0, -0.5], [left + 3.0, 0.0], [left, 0.0]])
    tail, tip = settlement_arrow(support, wall, -np.pi / 2)
    assert tip[1] < tail[1]
    assert tip[0] == pytest.approx(tail[0])
    assert tail[0] < left if left < 0.0 else tail[0] > left + 3.0
    assert 0.5 * (tail[1] + tip[1]) == pytest.approx(-0.25)


@pytest.mark.parametrize("name", ["settlement", "λ × weight × height, as given on named blocks"])
def test_the_name_of_a_load_stands_within_the_frame(assemblage, state, name):
    """However long it is, and beside an upright arrow at the edge of the picture, too."""
    for inclination in (0.0, -np.pi / 2):
        figure = plots.mechanism(assemblage, state, 1, inclination, name)
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
    tail, tip = load_arrow(points, direction, np.pi / 6)
    assert np.arctan2(tip[1] - tail[1], direction * (tip[0] - tail[0])) == pytest.approx(np.pi / 6)
    assert all((x < 0.0 if direction > 0 else x > 2.0) for x, _ in (tail, tip))


def test_thrust_crosses_joints_at_their_resultants_and_ends_in_the_support_along_them():
    """Block 2 x 1 rocking about its toe under 0.6 of its weight W: all through the toe, at slope 1 : 0.6."""
    blocks = (Block(0, between(-1, -1, 3, 0), True, 1e3), Block(1, between(0, 0, 2, 1), False, 1e3))
    joint = {"start": np.array([[2.0, 0.0]]), "end": np.array([[0.0, 0.0]])}
    block_i, block_j, mu = np.array([0]), np.array([1]), np.array([0.65])
    stack = Assemblage(Wall("w", blocks, 1.0, 0.65), block_i, block_j, **joint, friction=mu, cohesion=np.zeros(1))
    drawn = thrust(stack, np.array([[2000.0, 0.0, 1200.0]]))
    np.testing.assert_allclose(drawn.segments[:, 0], [[2.0, 0.0]] * 2)
    tangent, down = stack.tangent[0], -stack.normal[0]
    np.testing.assert_allclose(np.cross(drawn.segments[0, 1] - [2.0, 0.0], down - 0.6 * tangent), 0.0, atol=1e-12)
    assert drawn.segments[0, 1, 1] < 0.0
    assert drawn.resultant == pytest.approx(2000.0 * np.hypot(1.0, 0.6))


def test_thrust_of_a_block_with_two_joints_is_a_straight_line_between_them():
    blocks = tuple(Block(n, between(0, n, 2, n + 1), n == 0, 1e3) for n in range(3))
    start, end = np.array([[2.0, 1.0], [2.0, 2.0]]), np.array([[0.0, 1.0], [0.0, 2.0]])
    pairs = {"block_i": np.array([0, 1]), "block_j": np.array([1, 2]), "start": start, "end": end}
    stack = Assemblage(Wall("w", blocks, 1.0, 0.65), **pairs, friction=np.full(2, 0.65), cohesion=np.zeros(2))
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
    np.testing.assert_allclose(centroid(shape) - 1e6, [5 / 6, 5 / 6], rtol=1e-9)


def test_hinge_is_a_joint_that_opens_at_one_end_only():
    opening = np.array([[0.0, 1.0], [1.0, 1e-5], [1.0, 0.5], [0.0, 0.0], [-0.2, 1.0]])
    assert hinge_ends(opening, 0.01).tolist() == [0, 1, -1, -1, -1]


def test_a_joint_carries_load_when_either_end_is_pressed():
    assert carrying(np.array([[0, 1, 0], [1, 0, 0], [1e-9, 0, 5], [0, 0, 0.0]])).tolist() == [True, True, False, False]


# macroblocks


def test_macroblocks_have_one_colour_each_and_thick_interfaces(assemblage):
    partition = Partition(np.array([2, 0, 0, 1]), 2, np.array([2]), np.array([], int), None)
    figure = plots.macroblocks(assemblage, partition)
    np.testing.assert_array_equal(polygons(figure, 0), [b.polygon for b in assemblage.wall.blocks[1:]])
    left, right, top = map(to_hex, figure.axes[0].collections[0].get_facecolors())
    assert left == right != top
    kept = [0, 1, 3, 4]
    np.testing.assert_array_equal(segments(figure, "black"), np.stack([assemblage.start, assemblage.end], axis=1)[kept])
    assert shown(figure)[0] == ["0", "1"]
    np.testing.assert_allclose(figure.axes[0].texts[1].get_position(), [1.0, 0.75])
    assert figure.axes[0].get_title().endswith("2 macroblocks, 4 of 5 joints remain")


def test_neighbouring_bodies_differ_in_colour_on_a_planar_map():
    """5 x 8 bodies in running bond, each touching up to 6 others; colours stay within the palette of nine."""
    pairs = [(8 * r + c, 8 * r + c + 1) for r in range(5) for c in range(7)]
    pairs += [(8 * r + c, 8 * (r + 1) + c + d) for r in range(4) for c in range(8) for d in (0, 1) if c + d < 8]
    colours = colours_of_bodies(np.array(pairs), 40)
    assert all(colours[a] != colours[b] for a, b in pairs)
    assert set(colours) == set(range(9))  # all used, none beyond


def test_one_body_without_neighbours_has_a_colour():
    assert colours_of_bodies(np.empty((0, 2), dtype=int), 1).tolist() == [0]


# deformed


@pytest.fixture
def model():
    """Support under body 0 (a frame with a hole), body 1 on top of it; meshes of the extruded outlines only."""
    hole = between(0.5, 0.5, 1.5, 1.0)[::-1]
    frame = np.vstack([between(0, 0, 2, 1.5)[:3], [[1, 1.5]], [[0, 1.5]]])  # imprinted: end of the joint above
    outlines = [frame, between(0, 1.5, 1, 2), between(-0.5, -0.2, 2.5, 0)]
    made = [
        Body(n, f"block {n}", outlines[n], (hole,) if n == 0 else (), n == 2, 25e3, np.array([n])) for n in range(3)
    ]
    start, end = np.array([[2.0, 0.0], [1.0, 1.5]]), np.array([[0.0, 0.0], [0.0, 1.5]])
    joints = (np.array([2, 0]), np.array([0, 1]), start, end, np.full(2, 0.65), np.arange(2))
    bodies = Bodies(tuple(made), 2, 0.1, *joints, edge_i=np.array([2, 3]), edge_j=np.array([0, 0]))
    nodes, triangles, body_of_node, body_of_side, side_edge = [], [], [], [], []
    count = 0
    for body, rings in ((0, (frame, hole)), (1, (outlines[1],))):
        edges = 0
        for ring in rings:
            here = np.arange(len(ring))
            following = np.roll(here, -1)
            nodes += [np.column_stack([ring, np.full(len(ring), z)]) for z in (0.0, 0.1)]
            lower, upper = [here, following, following + len(ring)], [here, following + len(ring), here + len(ring)]
            triangles += [np.column_stack(lower) + count, np.column_stack(upper) + count]
            count += 2 * len(ring)
            body_of_node += [body] * 2 * len(ring)
            body_of_side += [body] * 2 * len(ring)
            side_edge += 2 * list(range(edges, edges + len(ring)))
            edges += len(ring)
    meshes = BodyMeshes(
        np.vstack(nodes), np.empty((0, 4), int), np.array(body_of_node), np.array([], int), np.vstack(triangles),
        np.array(body_of_side), np.array(side_edge), np.full(2, 25e3), 2, 0.0,
    )  # fmt: skip
    return bodies, meshes


@pytest.fixture
def increment(model):
    """Body 1 has moved 10 mm to the right and 5 mm up; body 0 stands."""
    _, meshes = model
    displacement = np.zeros_like(meshes.nodes)
    displacement[meshes.body_of_node == 1] = [0.01, 0.005, 0.0]
    none, gap, status = np.zeros(6), np.full(6, 0.005), np.array([1, 2, 0, 0, 0, 0])
    return Increment(
        7, "displacement", 1.0, 0.25, displacement, 0 * displacement, none, np.zeros((6, 2)), *3 * [none],
        *2 * [np.zeros(0)], gap, none,
        status, 100.0, 400.0, 0.0123, 0.01, 1.0, *6 * [0.0], 100.0, 0.0, False, np.ones(2, bool), np.zeros(2, bool),
        np.zeros(2), 0.0, 3, (0.1,),
    )  # fmt: skip


CONTACTS = {
    "contact_points": np.array([[0, 0], [2, 0], [0, 1.5], [1, 1.5], [0, 1.5], [1, 1.5]], dtype=float),
    "body_slave": np.array([0, 0, 1, 1, 1, 1]),
    "body_master": np.array([2, 2, 0, 0, 0, 0]),
}


def test_deformed_draws_each_body_displaced_with_its_holes(model, increment):
    figure = plots.deformed(*model, increment, **CONTACTS, name="frame", amplification=10.0)
    frame, top = (patch.get_path() for patch in figure.axes[0].patches if isinstance(patch, PathPatch))
    assert len(frame.vertices) == 6 + 5
    assert pixel(figure, 0.25, 0.75) == pixel(figure, 0.6, 1.8) == STONE
    assert pixel(figure, 1.0, 0.75) == "#ffffff"  # the hole
    expected = between(0.1, 1.55, 1.1, 2.05)
    assert {tuple(np.round(p, 9)) for p in top.vertices} == {tuple(p) for p in expected}
    np.testing.assert_array_equal(polygons(figure, 0), [model[0].bodies[2].exterior])
    assert figure.axes[0].get_title().splitlines() == [
        "frame",
        "Load multiplier 0.2500, control displacement 12.30 mm",
        "displacements drawn × 10",
    ]
    assert figure.axes[0].get_xlim()[1] > 2.5


def test_deformed_colours_joints_by_status_on_the_displaced_slave(model, increment):
    figure = plots.deformed(*model, increment, **CONTACTS, name="frame", amplification=10.0)

    def sorted_ends(colour):
        return sorted(sorted(map(tuple, np.round(s, 9).tolist())) for s in segments(figure, colour))

    assert sorted_ends(INK) == [[(0.0, 0.0), (1.0, 0.0)]]  # half of the base joint sticks, half slips
    assert sorted_ends(BLUE) == [[(1.0, 0.0), (2.0, 0.0)]]
    assert sorted_ends(VERMILLION) == [[(0.1, 1.55), (0.6, 1.55)], [(0.6, 1.55), (1.1, 1.55)]]
    assert shown(figure)[1] == ["support", "closed (stick)", "slipping", "open by less than 0.01 mm", "open"]


def test_a_joint_open_by_a_hair_is_drawn_thinner(model, increment):
    hair = replace(increment, gap=np.array([0, 0, 5e-6, 5e-6, 0.005, 0.005]))
    for drawn_increment, widths in ((increment, {2.2}), (hair, {0.8})):
        axes = plots.deformed(*model, drawn_increment, **CONTACTS, name="frame").axes[0]
        lines = [c for c in axes.collections if isinstance(c, LineCollection) and len(c.get_segments())]
        assert {c.get_linewidth()[0] for c in lines if to_hex(c.get_color()[0]) == VERMILLION} == widths


def test_damaged_joints_have_a_band_that_a_scale_explains(model, increment):
    """Half of the base joint is damaged by 0.25; without damage there is neither band nor scale."""
    assert len(plots.deformed(*model, increment, **CONTACTS, name="frame").axes) == 1
    damaged = replace(increment, damage=np.array([0.25, 0, 0, 0, 0, 0]))
    axes, scale = plots.deformed(*model, damaged, **CONTACTS, name="frame").axes
    (band,) = [c for c in axes.collections if isinstance(c, LineCollection) and c.get_array() is not None]
    assert band.get_array().tolist() == [0.25]
    assert sorted(band.get_segments()[0].tolist()) == [[0.0, 0.0], [1.0, 0.0]]
    assert scale.get_ylabel() == "damage of bonded joints (1: broken)"
    assert scale.get_ylim() == (0.0, 1.0)
    drawn(axes.figure)  # colours are mapped when drawing
    assert to_hex(band.get_color()[0]) == to_hex(colormaps["YlGnBu"](0.25))


def test_deformed_chooses_a_readable_factor(model, increment):
    figure = plots.deformed(*model, increment, **CONTACTS, name="frame")
    assert figure.axes[0].get_title().endswith("× 10")  # 6 % of 2 m is 12 times 10 mm


@pytest.mark.parametrize(
    ("drawn", "largest", "factor"),
    [(0.12, 0.01, 10), (0.12, 0.005, 20), (0.12, 0.0023, 50), (0.12, 0.1, 1), (0.12, 0.5, 1), (0.12, 0.0, 1)],
)
def test_readable_factor(drawn, largest, factor):
    assert readable_factor(drawn, largest) == factor


def test_outline_follows_the_mesh_in_order(model):
    _, meshes = model
    path = outline(meshes, 0, meshes.nodes[:, :2])
    assert len(path.vertices) == 5 + 1 + 4 + 1
    np.testing.assert_array_equal(np.unique(path.vertices, axis=0), np.unique(meshes.nodes[:18, :2], axis=0))


def test_loops_close_also_where_an_outline_touches_itself():
    edges = np.array([[0, 1], [1, 2], [2, 0], [2, 3], [3, 4], [4, 2]])  # two triangles that share node 2
    loops = closed_loops(edges)
    walked = [(a, b) for loop in loops for a, b in pairwise([*loop, loop[0]])]
    assert sorted(walked) == sorted(map(tuple, edges.tolist()))


def test_an_interface_is_shared_midway_between_its_contacts():
    used, borders = shares_of_interface(np.array([1.0, 0.0, 0.0, 0.4]))  # two contacts at 0: front and back
    assert used.tolist() == [1, 3, 0]
    np.testing.assert_allclose(borders, [0, 0.2, 0.7, 1])


def test_contacts_find_the_node_of_their_own_body(model):
    _, meshes = model
    found = nodes_of_contacts(meshes, np.array([[1.0, 1.5], [1.0, 1.5]]), np.array([0, 1]))
    assert meshes.body_of_node[found].tolist() == [0, 1]
    np.testing.assert_array_equal(meshes.nodes[found, :2], [[1.0, 1.5], [1.0, 1.5]])


# curves


@pytest.fixture
def curves_figure(state):
    analysis = LimitAnalysis(
        load_direction=1,
        weight=22225.0,
        horizontal_load=22225.0,
        tilting_table=True,
        associative=replace(state, flow_rule="associative", load_multiplier=0.3478),
        sequence=state,
        path=None,
        highest=0.3015,
        remarks=(),
        seconds=0.1,
    )
    shear, counts = np.array([0.0, 5000.0, 6600.0, 6500.0]), np.zeros(4, int)
    moved = np.array([0.001, 0.003, 0.011, 0.021])
    none = np.zeros(4)
    curve = PushoverCurve(
        counts, none, shear, shear, shear, moved, none, none, *4 * [counts], none, counts, counts, "done"
    )
    capacity = Capacity(6600.0, 0.29696, 0.010, 0.020, 2.5e6, 0.0, True)
    models = {"macroblocks": (curve, capacity), "micro": (curve, capacity)}
    return plots.curves(models, analysis, "wall 6")


def test_curves_are_in_kilonewtons_and_millimetres_from_gravity_on(curves_figure):
    lines = {line.get_label(): line for line in curves_figure.axes[0].lines}
    expected = [[0, 0], [2, 5], [10, 6.6], [20, 6.5]]
    np.testing.assert_allclose(lines["macroblocks"].get_xydata(), expected)
    np.testing.assert_allclose(lines["micro"].get_xydata(), expected)
    assert lines["macroblocks"].get_color() != lines["micro"].get_color()
    assert lines["macroblocks"].get_linestyle() != lines["micro"].get_linestyle()
    np.testing.assert_allclose(lines["peak 6.600 kN (λ = 0.2970) at 10.00 mm"].get_xydata(), [[10, 6.6]])
    axes = curves_figure.axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("control displacement (mm)", "base shear (kN)")


def test_curves_show_limit_analysis_as_lines_and_a_band(curves_figure):
    lines = {line.get_label(): line for line in curves_figure.axes[0].lines}
    associative = lines["micro-LA, associative: λ = 0.3478"]
    headline = lines["micro-LA, non-associative (sequence): λ = 0.2963"]
    assert associative.get_ydata()[0] == pytest.approx(0.3478 * 22.225)
    assert headline.get_ydata()[0] == pytest.approx(0.2963 * 22.225)
    (band,) = curves_figure.axes[0].patches
    assert (band.get_y(), band.get_height()) == pytest.approx((0.2963 * 22.225, 0.0052 * 22.225))
    legend = [text.get_text() for text in curves_figure.legends[0].get_texts()]
    assert "micro-LA, non-associative range: λ = 0.2963 to 0.3015" in legend
    assert len(legend) == 7
    assert curves_figure.axes[0].get_ylim()[1] > 0.3478 * 22.225


def test_second_axis_is_the_load_multiplier(curves_figure):
    drawn(curves_figure)
    axes = curves_figure.axes[0]
    (second,) = axes.child_axes
    np.testing.assert_allclose(np.array(axes.get_ylim()) / 22.225, second.get_ylim())
    assert second.get_ylabel() == "load multiplier λ = base shear / weight"


# files


def test_save_writes_a_picture_that_is_not_blank_twice_the_same(assemblage, tmp_path):
    paths = plots.save(plots.blocks(assemblage.wall), tmp_path / "figures", "blocks")
    assert [p.name for p in paths] == ["blocks.png", "blocks.svg"]
    picture = imread(paths[0])[:, :, :3]
    assert picture.shape[1] > 700  # 5 inches at 150 dpi
    stone = np.all(np.abs(picture - to_rgb(STONE)) < 0.02, axis=2)
    assert 0.1 < stone.mean() < 0.9
    frame = np.concatenate([picture[0], picture[-1], picture[:, 0], picture[:, -1]])
    assert (frame == 1.0).all()  # nothing is cut off at the border
    assert ElementTree.parse(paths[1]).getroot().tag.endswith("svg")
    again = plots.save(plots.blocks(assemblage.wall), tmp_path / "again", "blocks")
    assert [p.read_bytes() for p in paths] == [p.read_bytes() for p in again]


def test_a_picture_that_cannot_be_drawn_leaves_the_older_one(assemblage, tmp_path):
    (path, _) = plots.save(plots.blocks(assemblage.wall), tmp_path, "blocks")
    before = path.read_bytes()
    broken = plots.blocks(assemblage.wall)
    broken.axes[0].set_xlabel("$\\nonsense{$")
    with pytest.raises(ValueError, match="nonsense"):
        plots.save(broken, tmp_path, "blocks")
    assert path.read_bytes() == before
    assert imread(BytesIO(before)).size > 0


def test_pyplot_is_never_loaded():
    said = "import sys, orchestrator.present.plots; sys.exit('matplotlib.pyplot' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", said], check=False).returncode == 0
