"""Walls in drawings: wall 1 of Ferris and Tin-Loi comes back with its multiplier, gaps and overlaps are healed."""

from __future__ import annotations

import json
from itertools import pairwise

import numpy as np
import pytest
import shapely

from orchestrator.basis.errors import CaseError
from orchestrator.masonry.sources.closed_outlines import Layers
from orchestrator.masonry.sources.drawing import Drawing, HealingSettings, wall_of
from orchestrator.masonry.sources.dxf import read_dxf
from tests.support.intake import (
    MATERIAL,
    PUBLISHED,
    WALL_1,
    areas,
    as_polylines,
    assert_same_wall,
    associative,
    joint_lengths,
    rubble,
    touching_pairs,
    written,
)
from tests.support.paths import DATA
from tests.support.walls import rectangle

TOLERANCE = 1e-3


def union(wall):
    return shapely.union_all([shapely.Polygon(block.polygon) for block in wall.blocks], grid_size=1e-9)


def as_shared_lines(wall):
    """Return a function that draws every edge of the joint pattern once, each line between two nodes of it."""
    free = [shapely.Polygon(block.polygon).exterior for block in wall.blocks if not block.fixed]
    network = shapely.line_merge(shapely.union_all(free, grid_size=1e-9))

    def draw(space, _):
        for line in network.geoms:
            for a, b in zip(line.coords[:-1], line.coords[1:], strict=True):
                space.add_line(*(1000 * np.array([*p, 0]) for p in (a, b)), dxfattribs={"layer": "blocks"})
        (ground,) = (block.polygon for block in wall.blocks if block.fixed)
        space.add_lwpolyline(1000 * ground, close=True, dxfattribs={"layer": "supports"})

    return draw


def imported(path, unit="", layers=Layers(), tolerance=TOLERANCE, ground=None):  # noqa: B008
    drawing = read_dxf(path, layers, tolerance, unit)
    return wall_of(drawing, path.stem, MATERIAL, HealingSettings(tolerance, ground))


@pytest.mark.parametrize("as_drawn", [as_polylines, as_shared_lines])
def test_wall_1_comes_back_from_a_drawing(tmp_path, as_drawn):
    wall, remarks = imported(written(tmp_path / "wall.dxf", as_drawn(WALL_1)))
    assert_same_wall(wall, WALL_1)
    assert associative(wall) == pytest.approx(PUBLISHED, abs=5e-4)
    assert remarks == ["drawing unit 0.001 m, from its header"]


LINTEL = (0.0, 0.4, 1.2, 0.1)


JAMBS = [(0.0, 0.0, 0.3, 0.4), (0.9, 0.0, 0.3, 0.4)]


def test_layers_are_materials_where_blocks_are_on_several(tmp_path):
    def draw(space, _):
        for jamb in JAMBS:
            space.add_lwpolyline(1000 * rectangle(*jamb), close=True, dxfattribs={"layer": "Stone"})
        space.add_lwpolyline(1000 * rectangle(*LINTEL), close=True, dxfattribs={"layer": "Timber"})

    path = written(tmp_path / "door.dxf", draw)
    wall, _ = imported(path, layers=Layers(blocks="stone, timber"), ground=0.2)
    assert [block.material for block in wall.blocks] == ["", "Stone", "Stone", "Timber"]
    wall, _ = imported(path, layers=Layers(blocks="timber,st*", openings="none"), ground=0.2)
    assert [block.material for block in wall.blocks] == ["", "Stone", "Stone", "Timber"]
    with pytest.raises(CaseError, match="nothing is drawn on layer 'brick, wood'"):
        imported(path, layers=Layers(blocks="brick, wood"), ground=0.2)


def test_a_block_of_lines_is_of_the_layer_that_most_of_its_outline_is_drawn_on(tmp_path):
    """The bed between jambs and lintel is drawn once, with the jambs; the rest of the lintel on its own layer."""

    def draw(space, _):
        def line(layer, *points):
            for a, b in pairwise(points):
                space.add_line(*((1000 * p[0], 1000 * p[1]) for p in (a, b)), dxfattribs={"layer": layer})

        for x in (0.0, 0.9):
            line("stone", (x, 0.4), (x, 0), (x + 0.3, 0), (x + 0.3, 0.4), (x, 0.4))
        line("timber", (0, 0.4), (0, 0.5), (1.2, 0.5), (1.2, 0.4))
        line("timber", (0.3, 0.4), (0.9, 0.4))

    wall, _ = imported(written(tmp_path / "door.dxf", draw), layers=Layers(blocks="stone,timber"), ground=0.2)
    assert [block.material for block in wall.blocks] == ["", "stone", "stone", "timber"]


def test_gaps_and_overlaps_of_a_drawing_are_healed_and_listed(tmp_path):
    """Corners off by up to 0.4 mm: neighbours are up to 0.8 mm apart or over each other, less than the tolerance.

    The healed wall must have all joints of the exact one; courses stay straight, so that bed joints do not interlock.
    """
    wall, remarks = imported(written(tmp_path / "wall.dxf", as_polylines(WALL_1, noise=0.4e-3)))
    assert_same_wall(wall, WALL_1, within=1.5e-3)
    count, length = joint_lengths(wall)
    assert count == joint_lengths(WALL_1)[0] == 83
    assert length == pytest.approx(joint_lengths(WALL_1)[1], rel=5e-3)
    assert associative(wall) == pytest.approx(PUBLISHED, rel=5e-3)
    assert any("gaps between blocks closed" in remark for remark in remarks)
    assert any("overlaps between blocks closed" in remark for remark in remarks)
    assert not [remark for remark in remarks if "NOT closed" in remark]


@pytest.mark.parametrize("seed", [0, 1, 2, 3, 4, 5, 6, 8])
def test_rubble_is_healed_too(seed):
    """Corners off by up to tolerance / (2 sqrt 2) each way: no two that belong together are farther than tolerance.

    Seed 7 has an edge of 0.7 mm, which the tolerance takes for a point.
    """
    off, random = TOLERANCE / np.sqrt(8), np.random.default_rng(seed)
    stones = rubble(seed)
    noisy = tuple(stone + random.uniform(-off, off, stone.shape) for stone in stones)
    settings = HealingSettings(TOLERANCE, 0.2)
    exact, remarks = wall_of(Drawing(tuple(stones)), "rubble", MATERIAL, settings)
    assert not [remark for remark in remarks if "short edge" not in remark], "of 1/100 of a stone: points, and said"
    healed, remarks = wall_of(Drawing(noisy), "rubble", MATERIAL, settings)
    assert touching_pairs(healed, 5 * TOLERANCE) == touching_pairs(exact, 5 * TOLERANCE)
    assert joint_lengths(healed)[1] == pytest.approx(joint_lengths(exact)[1], rel=2e-3)
    assert areas(healed) == pytest.approx(areas(exact), abs=1.5 * TOLERANCE)
    assert not [remark for remark in remarks if "NOT closed" in remark]


def test_a_gap_wider_than_the_tolerance_is_named(tmp_path):
    def draw(space, _):
        space.add_lwpolyline([(0, 0), (500, 0), (500, 300), (0, 300)], close=True, dxfattribs={"layer": "blocks"})
        space.add_lwpolyline([(504, 0), (900, 0), (900, 300), (504, 300)], close=True, dxfattribs={"layer": "blocks"})

    _, remarks = imported(written(tmp_path / "gap.dxf", draw), ground=0.2)
    assert remarks[0] == (
        "WARNING: gap of 4 mm between blocks 1 and 2 at (0.502, 0.15) m NOT closed, wider than the tolerance; "
        "--tolerance closes it, or --mortar if it is a joint"
    )


def test_ends_of_lines_that_nearly_meet_close_a_block(tmp_path):
    corners = np.array([[0, 0, 0], [500, 0, 0], [500, 300, 0], [0, 300, 0]], float)

    def draw(space, _):
        for k in range(4):
            shift = np.array([0.3 * (-1) ** k, 0.2, 0])
            space.add_line(corners[k] + shift, corners[(k + 1) % 4] - shift, dxfattribs={"layer": "blocks"})
        space.add_line((900, 900), (950, 950), dxfattribs={"layer": "blocks"})

    wall, remarks = imported(written(tmp_path / "lines.dxf", draw), ground=0.2)
    assert [block.fixed for block in wall.blocks] == [True, False]
    assert areas(wall) == pytest.approx([0.15], rel=5e-3)
    said = "1 line closes no outline; 2 open ends at (0.9, 0.9), (0.95, 0.95) m; no --tolerance up to 50 mm closes"
    assert any(said in remark for remark in remarks)


def test_an_arc_becomes_chords_within_the_tolerance(tmp_path):
    """Half disc of radius 0.5 m on its chord: its area is pi r^2 / 2, and chords with a rise of 1 mm cut off little."""

    def draw(space, _):
        space.add_arc((0, 0), 500, 0, 180, dxfattribs={"layer": "blocks"})
        space.add_line((-500, 0), (500, 0), dxfattribs={"layer": "blocks"})

    wall, _ = imported(written(tmp_path / "arc.dxf", draw), ground=0.2)
    exact = np.pi * 0.25 / 2
    assert exact - np.pi * 0.5 * TOLERANCE < areas(wall)[0] < exact


def test_openings_leave_no_block_and_entities_in_block_references_count(tmp_path):
    def draw(space, document):
        stone = document.blocks.new("STONE")
        stone.add_lwpolyline([(0, 0), (400, 0), (400, 200), (0, 200)], close=True, dxfattribs={"layer": "blocks"})
        for x in (0, 400, 800):
            space.add_blockref("STONE", (x, 0))
        hole = [(410, 10), (790, 10), (790, 190), (410, 190)]
        space.add_lwpolyline([(400, 0), (800, 0), (800, 200), (400, 200)], close=True, dxfattribs={"layer": "Openings"})
        space.add_lwpolyline(hole, close=True, dxfattribs={"layer": "blocks"})

    wall, remarks = imported(written(tmp_path / "openings.dxf", draw), ground=0.2)
    assert areas(wall) == pytest.approx([0.08, 0.08])
    assert "2 outlines inside openings left out" in remarks


def test_one_outline_in_an_opening_is_told_in_the_singular():
    left, right = rectangle(0.0, 0.0, 0.4, 0.2), rectangle(0.4, 0.0, 0.4, 0.2)
    drawing = Drawing((left, right), (rectangle(-0.2, -0.2, 1.2, 0.2),), (right,))
    assert "1 outline inside openings left out" in wall_of(drawing, "wall", MATERIAL, HealingSettings())[1]


@pytest.mark.parametrize(
    ("insunits", "unit", "factor"), [(4, "", 1000), (6, "", 1), (1, "", 1 / 0.0254), (0, "cm", 100)]
)
def test_unit_of_the_header_or_as_given(tmp_path, insunits, unit, factor):
    path = written(tmp_path / "wall.dxf", as_polylines(WALL_1, factor=factor), insunits)
    assert_same_wall(imported(path, unit)[0], WALL_1)


def test_a_drawing_without_unit_is_refused(tmp_path):
    with pytest.raises(CaseError, match=r"wall\.dxf: \$INSUNITS: the header states no unit of length; .*--unit mm"):
        imported(written(tmp_path / "wall.dxf", as_polylines(WALL_1), 0))


def test_millimetres_read_as_metres_are_pointed_out_and_far_coordinates_moved(tmp_path):
    _, remarks = imported(written(tmp_path / "wall.dxf", as_polylines(WALL_1)), "m")
    assert any("the wall measures 2400 m: is the unit right?" in remark for remark in remarks)

    def far(space, _):
        for block in WALL_1.blocks:
            layer = {"layer": "supports" if block.fixed else "blocks"}
            space.add_lwpolyline(block.polygon + [512_345.0, 4_823_456.0], close=True, dxfattribs=layer)

    wall, remarks = imported(written(tmp_path / "utm.dxf", far, 6))
    assert "moved by (-512344, -4823455) m" in remarks
    assert areas(wall) == pytest.approx(areas(WALL_1), rel=1e-6)
    assert associative(wall) == pytest.approx(PUBLISHED, abs=5e-4)


@pytest.mark.parametrize(
    ("layers", "ground", "complaint"),
    [
        (Layers(blocks="stones"), None, r"nothing is drawn on layer 'stones'; .*BLOCKS, Supports"),
        (Layers(supports="soil"), None, r"supports: the drawing has none; .*--ground"),
        (Layers(openings="*"), None, r"openings: every block lies in one"),
        (Layers(), 0.2, r"--ground: the drawing has supports of its own"),
        (Layers(blocks="*"), None, r"block 0 at \(1, -0.08\d*\) m: overlaps block 1 by 0.42 m2"),
    ],
)
def test_layers_that_do_not_fit_are_refused(tmp_path, layers, ground, complaint):
    with pytest.raises(CaseError, match=complaint):
        imported(written(tmp_path / "wall.dxf", as_polylines(WALL_1)), layers=layers, ground=ground)


def test_reference_is_the_published_wall():
    """Otherwise every comparison above would prove nothing."""
    record = json.loads((DATA / "ferris_tinloi_wall1.json").read_text())
    assert record["expected"]["published"][0]["assoc"] == PUBLISHED
    assert associative(WALL_1) == pytest.approx(PUBLISHED, abs=5e-4)


def test_a_spike_thinner_than_the_tolerance_is_healed():
    """A block whose outline runs 0.5 mm above its neighbour's and back."""
    ground, low = rectangle(-0.5, -0.2, 3.0, 0.2), rectangle(0.0, 0.0, 2.0, 0.5)
    high = np.array([[0.0, 0.5], [1.5, 0.5], [1.5, 0.5005], [1.0, 0.5005], [1.0, 1.0], [0.0, 1.0]])
    drawn = Drawing((np.asarray(low), high), (np.asarray(ground),))
    wall, _ = wall_of(drawn, "spike", MATERIAL, HealingSettings(TOLERANCE))
    assert areas(wall) == pytest.approx([0.5, 1.0], rel=2e-3)


def test_open_polylines_that_end_where_they_begin_but_for_an_error_are_pointed_out(tmp_path):
    """Read as lines they would bound whatever their neighbours leave: stones with wedges between them."""

    def draw(space, _):
        for x, y in ((0, 0), (500, 0), (0, 300), (500, 300)):
            corners = [(x, y), (x + 500, y), (x + 500, y + 300), (x, y + 300), (x, y + 3)]
            space.add_lwpolyline(corners, dxfattribs={"layer": "blocks"})

    file = written(tmp_path / "open.dxf", draw)
    _, remarks = imported(file, ground=0.2)
    said = "4 polylines end up to 3 mm from the beginning, the first at (0, 0) m: close what is open"
    assert any(said in remark and '--tolerance "4 mm"' in remark for remark in remarks)
    wall, remarks = imported(file, tolerance=4e-3, ground=0.2)
    assert areas(wall) == pytest.approx(4 * [0.15], rel=0.02)
    assert not any("WARNING" in remark for remark in remarks)


@pytest.mark.parametrize(("overlap", "advised"), [(20, True), (60, False)])
def test_no_tolerance_is_advised_that_import_refuses(tmp_path, overlap, advised):
    def draw(space, _):
        for left in (0, 500 - overlap):
            corners = [(left, 0), (left + 500, 0), (left + 500, 300), (left, 300)]
            space.add_lwpolyline(corners, close=True, dxfattribs={"layer": "blocks"})

    with pytest.raises(CaseError, match="overlaps") as refused:
        imported(written(tmp_path / "over.dxf", draw), ground=0.2)
    assert ("--tolerance" in str(refused.value)) is advised
