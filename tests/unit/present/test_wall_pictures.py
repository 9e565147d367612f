"""Pictures of blocks and macroblocks: what is drawn, where, in which colour; files that are not blank."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from io import BytesIO
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PathCollection
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.image import imread

from orchestrator.geometry.rigid import polygon_centroid
from orchestrator.macroblocks.criteria import Partition, one_body
from orchestrator.masonry.patterns import running_bond
from orchestrator.present import plots
from orchestrator.present.plots.canvas import STONE, lay_out, save, wall_figure
from orchestrator.present.plots.wall_pictures import (
    colours_of_bodies,
)
from orchestrator.present.plots.words import legend_below, write_title
from orchestrator.present.report import model_labels
from tests.support.figures import drawn, pixel, polygons, segments, shown


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
    expected = np.vstack([np.tile(polygon_centroid(b.polygon), (len(str(b.id)), 1)) for b in wall.blocks])
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


LINES = ["load multiplier 0.12", "Mechanism (peak in large displacements): load multiplier " * 3]


@pytest.mark.parametrize("line", LINES)
@pytest.mark.parametrize("legend", [0, 2, 7])
@pytest.mark.parametrize("size", [(5, 6), (7, 7.5), (2.2, 1.3), (2, 2.4), (1, 8), (8, 1)])
def test_no_line_of_a_title_is_cut_off(size, legend, line):
    figure, axes = wall_figure(np.array([[0, 0], size]), f"{line}\ndisplacements drawn × 5", "a wall")
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


def test_macroblocks_have_one_colour_each_and_thick_interfaces(assemblage):
    partition = Partition(np.array([2, 0, 0, 1]), 2, np.array([2]), np.array([], int), None)
    figure = plots.macroblocks(assemblage, partition)
    np.testing.assert_array_equal(polygons(figure, 0), [b.polygon for b in assemblage.wall.blocks[1:]])
    left, right, top = map(to_hex, figure.axes[0].collections[0].get_facecolors())
    assert left == right != top
    kept = [0, 1, 3, 4]
    np.testing.assert_array_equal(segments(figure, "black"), assemblage.joints.point.reshape(-1, 2, 2)[kept])
    assert shown(figure)[0] == ["0", "1"]
    np.testing.assert_allclose(figure.axes[0].texts[1].get_position(), [1.0, 0.75])
    assert figure.axes[0].get_title().endswith("2 macroblocks, 4 of 5 joints remain")
    one = plots.macroblocks(assemblage, one_body(assemblage))
    assert one.axes[0].get_title().endswith("1 macroblock, 2 of 5 joints remain")
    assert [model_labels(count)["macro"] for count in (1, 2)] == ["macroblock FE (1 body)", "macroblock FE (2 bodies)"]


def test_neighbouring_bodies_differ_in_colour_on_a_planar_map():
    """5 x 8 bodies in running bond, each touching up to 6 others; colours stay within the palette of nine."""
    pairs = [(8 * r + c, 8 * r + c + 1) for r in range(5) for c in range(7)]
    pairs += [(8 * r + c, 8 * (r + 1) + c + d) for r in range(4) for c in range(8) for d in (0, 1) if c + d < 8]
    colours = colours_of_bodies(np.array(pairs), 40)
    assert all(colours[a] != colours[b] for a, b in pairs)
    assert set(colours) == set(range(9))  # all used, none beyond


def test_one_body_without_neighbours_has_a_colour():
    assert colours_of_bodies(np.empty((0, 2), dtype=int), 1).tolist() == [0]


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


def test_no_line_of_a_title_ends_within_an_equation():
    """ "... taglio alla base 11,940 kN per λ =" had its 1 on a line of its own."""
    figure = Figure(figsize=(6.0, 2.0))
    for words in range(60, 70):
        title = "n" * words + " λ = 1"
        write_title(axes := figure.add_subplot(), title, "")
        assert axes.get_title().endswith("λ = 1")
        assert axes.title.get_label().endswith(title)


def test_a_legend_of_many_lines_does_not_reach_into_the_label_above_it(tmp_path):
    """Letters are whole pixels high: what has room at one resolution may have none at another."""
    figure = Figure(figsize=(7.0, 5.2), layout="constrained")
    axes = figure.add_subplot()
    axes.set_xlabel("control displacement (mm)")
    for line in range(11):
        axes.plot([0, 1], [line, line], label=f"peak 12.85 kN (of what is left, with many words besides), line {line}")
    legend_below(axes, 2)
    save(figure, tmp_path, "lines")
    FigureCanvasAgg(figure).draw()
    assert figure.legends[0].get_window_extent().y1 <= axes.xaxis.label.get_window_extent().y0
