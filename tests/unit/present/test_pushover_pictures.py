"""Pictures of a pushover: displaced bodies with the status of their joints, capacity curves with limit analysis."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from matplotlib import colormaps
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch

from orchestrator.assessment.capacity import Capacity
from orchestrator.limit_analysis.paper.limit_state import LimitAnalysis
from orchestrator.loads import Loads
from orchestrator.loads.dead_loads import DeadLoad
from orchestrator.macroblocks.bodies import Bodies, Body
from orchestrator.masonry.interfaces import straight_interfaces
from orchestrator.masonry.wall import Block, Wall
from orchestrator.present import plots
from orchestrator.present.joint_pieces import (
    NO_STATE,
    closed_loops,
    interface_pieces,
    shares_of_interface,
    shown_displacement,
    status_of_pieces,
)
from orchestrator.present.page.collapse import LARGEST_INTEGER, packed
from orchestrator.present.phrases import phrases
from orchestrator.present.plots.canvas import BLUE, FAINT, INK, STONE, VERMILLION
from orchestrator.present.plots.pushover_pictures import FELL, draw_curve, outline, readable_factor
from orchestrator.present.plots.words import tell
from orchestrator.pushover.increments import Increment, PushoverCurve
from orchestrator.pushover.meshing import BodyMeshes
from orchestrator.storage import ContactPlaces
from tests.support.figures import drawn, pixel, polygons, segments, shown
from tests.support.walls import between


@pytest.fixture
def model():
    """Support under body 0 (a frame with a hole), body 1 on top of it; meshes of the extruded outlines only."""
    hole = between(0.5, 0.5, 1.5, 1.0)[::-1]
    frame = np.vstack([between(0, 0, 2, 1.5)[:3], [[1, 1.5]], [[0, 1.5]]])  # imprinted: end of the joint above
    outlines = [frame, between(0, 1.5, 1, 2), between(-0.5, -0.2, 2.5, 0)]
    made = [
        Body(n, f"block {n}", outlines[n], (hole,) if n == 0 else (), n == 2, 25e3, np.array([n])) for n in range(3)
    ]
    start, end = np.array([[2.0, 0.0], [0.0, 1.5]]), np.array([[0.0, 0.0], [1.0, 1.5]])
    joints = straight_interfaces(np.array([2, 1]), np.array([0, 0]), start, end, 0.1, np.full(2, 0.65))
    no_toes = np.zeros(2), np.zeros((2, 2))
    bodies = Bodies(tuple(made), 2, 0.1, joints, np.arange(2), np.array([2, 0]), np.array([0, 3]), 1.0, *no_toes)
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
    none, gap, status = np.zeros(8), np.full(8, 0.005), np.array([1, 2, 1, 2, 0, 0, 0, 0])
    return Increment(
        7, "displacement", 1.0, 0.25, displacement, 0 * displacement, none, np.zeros((8, 2)), *3 * [none],
        *2 * [np.zeros(0)], gap, none,
        status, 100.0, 400.0, 0.0123, 0.0, 0.01, 1.0, *6 * [0.0], 100.0, 0.0, False,
        np.ones(2, bool), np.zeros(2, bool), np.zeros(2), 0.0, 3, (0.1,),
    )  # fmt: skip


CONTACTS = ContactPlaces(np.array([0, 1, 5, 6, 18, 19, 22, 23]), np.repeat([0, 1], 4))
"""corners of body 0 on the support, of body 1 on body 0, at both faces of the wall"""


def test_deformed_draws_each_body_displaced_with_its_holes(model, increment):
    figure = plots.deformed(*model, increment, CONTACTS, name="frame", amplification=10.0)
    frame, top = (patch.get_path() for patch in figure.axes[0].patches if isinstance(patch, PathPatch))
    assert len(frame.vertices) == 6 + 5
    assert pixel(figure, 0.25, 0.75) == pixel(figure, 0.6, 1.8) == STONE
    assert pixel(figure, 1.0, 0.75) == "#ffffff"  # the hole
    expected = between(0.1, 1.55, 1.1, 2.05)
    assert {tuple(np.round(p, 9)) for p in top.vertices} == {tuple(p) for p in expected}
    np.testing.assert_array_equal(polygons(figure, 0), [model[0].bodies[2].exterior])
    assert figure.axes[0].get_title().splitlines() == [
        "frame",
        "Load multiplier 0.2500, base shear 0.1000 kN",
        "control displacement 12.30 mm, displacements drawn × 10",
    ]
    assert figure.axes[0].get_xlim()[1] > 2.5


def test_arrows_of_a_floor_move_with_their_body(model, increment):
    """10 x (10 mm, 5 mm), on the top of body 1."""
    blocks = tuple(Block(n, body.exterior, n == 2, 25e3) for n, body in enumerate(model[0].bodies))
    dead = Wall("frame", blocks, 0.1, 0.65), (DeadLoad(blocks=(1,), line_load=1e3),)
    axes = plots.deformed(*model, increment, CONTACTS, name="frame", amplification=10.0, dead=dead).axes[0]
    drawn = next(one for one in axes.collections if one.get_label() == "extra dead loads")
    tips = np.array([tip for _, tip in drawn.get_segments()])
    np.testing.assert_allclose(tips[:, 1], 2.05, atol=1e-12)
    assert 0.1 < tips[:, 0].min() < 0.2 < 1.0 < tips[:, 0].max() < 1.1


@pytest.fixture
def fell(model, increment):
    """Body 1 has fallen by 400 m; body 0 has gone 10 mm to the right."""
    _, meshes = model
    displacement = np.zeros_like(meshes.nodes)
    displacement[meshes.body_of_node == 0, 0] = 0.01
    displacement[meshes.body_of_node == 1] = [4.0, -400.0, 0.0]
    return replace(increment, displacement=displacement, fallen=np.array([False, True]))


def test_a_stone_that_fell_is_a_pale_outline_where_it_stood(model, fell):
    """Neither axes nor the factor know how far it fell; it has no joints any more, and no load."""
    blocks = tuple(Block(n, body.exterior, n == 2, 25e3) for n, body in enumerate(model[0].bodies))
    dead = Wall("frame", blocks, 0.1, 0.65), (DeadLoad(blocks=(0,), force=1e3), DeadLoad(blocks=(1,), line_load=1e3))
    figure = plots.deformed(*model, fell, CONTACTS, name="frame", dead=dead)
    axes = figure.axes[0]
    assert axes.get_title().endswith("× 10")
    assert np.ptp(axes.get_ylim()) < 3.0
    frame, top = (patch for patch in axes.patches if isinstance(patch, PathPatch))
    assert {tuple(np.round(p, 9)) for p in top.get_path().vertices} == {tuple(p) for p in between(0, 1.5, 1, 2)}
    assert (top.get_fill(), to_hex(top.get_edgecolor()), top.get_linestyle()) == (False, FAINT, "--")
    assert frame.get_fill()
    (arrow,) = (one for one in axes.collections if one.get_label() == "extra dead loads")
    assert len(arrow.get_segments()) == 3, "the one onto the middle of body 0"
    assert not segments(figure, VERMILLION)[3:], "no open joint"
    assert FELL in shown(figure)[1]


@pytest.mark.parametrize("language", ["it", "pt"])
def test_that_a_stone_fell_is_said_in_other_languages(model, fell, language):
    figure = plots.deformed(*model, fell, CONTACTS, name="frame")
    tell(figure, language)
    assert FELL not in shown(figure)[1]
    assert phrases(language)(FELL) in shown(figure)[1]


def test_a_stone_in_the_page_that_fell_stays_where_it_stood(model, fell):
    """Its displacement would take all digits of the others; its joints are in no state."""
    contact = interface_pieces(*model, CONTACTS)[0]
    status = status_of_pieces(model[0], CONTACTS, contact, fell)
    np.testing.assert_array_equal(status == NO_STATE, CONTACTS.interface[contact] == 1)
    np.testing.assert_array_equal(shown_displacement(model[1], fell)[model[1].body_of_node == 1], 0.0)
    assert packed(shown_displacement(model[1], fell))[0] == pytest.approx(0.01 / LARGEST_INTEGER)


def test_deformed_colours_joints_by_status_on_the_displaced_slave(model, increment):
    figure = plots.deformed(*model, increment, CONTACTS, name="frame", amplification=10.0)

    def sorted_ends(colour):
        return sorted(sorted(map(tuple, np.round(s, 9).tolist())) for s in segments(figure, colour))

    assert sorted_ends(INK) == [[(0.0, 0.0), (1.0, 0.0)]]  # half of the base joint sticks, half slips
    assert sorted_ends(BLUE) == [[(1.0, 0.0), (2.0, 0.0)]]
    assert sorted_ends(VERMILLION) == [[(0.1, 1.55), (0.6, 1.55)], [(0.6, 1.55), (1.1, 1.55)]]
    assert shown(figure)[1] == ["support", "closed (stick)", "slipping", "open by less than 0.01 mm", "open"]


def test_a_joint_open_by_a_hair_is_drawn_thinner(model, increment):
    hair = replace(increment, gap=np.array([0, 0, 0, 0, 5e-6, 5e-6, 0.005, 0.005]))
    for drawn_increment, widths in ((increment, {2.2}), (hair, {0.8})):
        axes = plots.deformed(*model, drawn_increment, CONTACTS, name="frame").axes[0]
        lines = [c for c in axes.collections if isinstance(c, LineCollection) and len(c.get_segments())]
        assert {c.get_linewidth()[0] for c in lines if to_hex(c.get_color()[0]) == VERMILLION} == widths


def test_damaged_joints_have_a_band_that_a_scale_explains(model, increment):
    """Half of the base joint is damaged by 0.25; without damage there is neither band nor scale."""
    assert len(plots.deformed(*model, increment, CONTACTS, name="frame").axes) == 1
    damaged = replace(increment, damage=np.array([0.25, 0, 0.25, 0, 0, 0, 0, 0]))
    axes, scale = plots.deformed(*model, damaged, CONTACTS, name="frame").axes
    (band,) = [c for c in axes.collections if isinstance(c, LineCollection) and c.get_array() is not None]
    assert band.get_array().tolist() == [0.25]
    assert sorted(band.get_segments()[0].tolist()) == [[0.0, 0.0], [1.0, 0.0]]
    assert scale.get_ylabel() == "damage of bonded joints (1: broken)"
    assert scale.get_ylim() == (0.0, 1.0)
    drawn(axes.figure)  # colours are mapped when drawing
    assert to_hex(band.get_color()[0]) == to_hex(colormaps["YlGnBu"](0.25))


def test_deformed_chooses_a_readable_factor(model, increment):
    figure = plots.deformed(*model, increment, CONTACTS, name="frame")
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


@pytest.fixture
def curves_figure(state):
    return figure_of_curves(state, np.zeros(4, int))


def figure_of_curves(state, fallen):
    state = replace(state, horizontal_load=22225.0)
    analysis = LimitAnalysis(
        loads=Loads(np.zeros((4, 3)), np.zeros((4, 3)), np.array([1.0, 0.0])),
        weight=22225.0,
        vertical_load=22225.0,
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
        counts, none, shear, shear, shear, moved, none, none, *4 * [counts], none, counts, fallen, "done"
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


def test_the_multiplier_of_a_peak_after_stones_have_fallen_is_of_what_is_left(state):
    """The second axis has base shear over the weight of all."""
    for fallen, left in (([0, 0, 1, 1], True), ([0, 0, 0, 1], False)):
        figure = figure_of_curves(state, np.array(fallen))
        labels = [line.get_label() for line in figure.axes[0].lines]
        assert (f"peak 6.600 kN (λ = 0.2970{' of what is left' * left}) at 10.00 mm") in labels


@pytest.mark.filterwarnings("error")
def test_a_curve_against_the_load_is_seen_whole_beside_one_along_it():
    """Static rows only: what falls goes far beyond, either way."""
    zeros, counts = np.zeros(4), np.zeros(4, int)
    shear, moving = np.array([0.0, 5000.0, 6600.0, 0.0]), np.array([0, 0, 0, 1])

    def moved(*millimetres):
        displacement = 1e-3 * np.array(millimetres, float)
        return PushoverCurve(
            counts, zeros, shear, shear, shear, displacement, zeros, zeros, *4 * [counts], zeros, moving, counts, "done"
        )

    along, against = moved(1, 3, 11, 500), moved(1, -1, -4, -500)
    for curves, ends in (([against], (-5.25, 0.0)), ([along, against], (-5.25, 10.5)), ([along], (0.0, 10.5))):
        axes = Figure().add_subplot()
        for curve in curves:
            draw_curve(axes, curve, "black", "-", "")
        assert axes.get_xlim() == pytest.approx(ends)
    lines = [plots.ModelCurve(name, "micro", True, one) for name, one in (("along", along), ("against", against))]
    for figure in (plots.load_case_curves(lines, ""), plots.load_case_curves(lines[:1], "")):
        left, right = figure.axes[0].get_xlim()
        assert left == pytest.approx(-5.25 if len(figure.axes[0].lines) == 2 else 0.0)
        assert right > 10.0


def test_curves_show_limit_analysis_as_lines_and_a_band(curves_figure):
    lines = {line.get_label(): line for line in curves_figure.axes[0].lines}
    associative = lines["micro-LA, associative: λ = 0.3478"]
    headline = lines["micro-LA, the paper's sequence: λ = 0.2963"]
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
    assert second.get_ylabel() == "λ = base shear / weight"
