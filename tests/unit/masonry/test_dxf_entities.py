"""Stones drawn as block references, arrays, hatches, solids and faces are read; what is not read or hidden is told."""

from __future__ import annotations

import ezdxf
import pytest

from orchestrator.app.intake import import_wall
from orchestrator.basis.errors import CaseError
from tests.support.drawings import MILLIMETRES
from tests.support.walls import between

BOXES = [
    (400 * c + 200 * (r % 2), 200 * r, 400 * c + 400 + 200 * (r % 2), 200 * r + 200) for r in (0, 1) for c in (0, 1)
]
"""left, bottom, right, top of four stones in mm"""
LAST = BOXES[-1]
ON = {"layer": "blocks"}


def polyline(space, box, layer="blocks"):
    return space.add_lwpolyline(between(*box), close=True, dxfattribs={"layer": layer})


def imported(path, last, outlined=BOXES[:-1], ground="0.2 m"):
    """Read a drawing of polylines round the boxes `outlined`, and what `last` draws; return areas (m2) and remarks."""
    document = ezdxf.new("R2000", setup=True)
    document.header["$INSUNITS"] = MILLIMETRES
    space = document.modelspace()
    for box in outlined:
        polyline(space, box)
    last(space, document)
    document.saveas(path)
    taken = import_wall(path, {"thickness": "0.3 m", "ground": ground, "friction": "0.6"})
    return [block for block in taken.wall.blocks if not block.fixed], taken.remarks


def stone(document, name="STONE", width=400, height=200):
    block = document.blocks.new(name)
    block.add_lwpolyline(between(0, 0, width, height), close=True)
    return name


def reference(space, document):
    space.add_blockref(stone(document), LAST[:2], dxfattribs=ON)


def nested(space, document):
    outer = document.blocks.new("OUTER")
    outer.add_blockref(stone(document, width=200), (0, 0), dxfattribs={"xscale": 2.0})
    space.add_blockref("OUTER", (LAST[0], LAST[3]), dxfattribs=ON | {"yscale": -1.0})


def solid(space, _):
    a, b, c, d = between(*LAST)
    space.add_solid([a, b, d, c], dxfattribs=ON)


def trace(space, _):
    a, b, c, d = between(*LAST)
    space.add_trace([a, b, d, c], dxfattribs=ON)


def face(space, _):
    space.add_3dface(between(*LAST), dxfattribs=ON)


def hatch(space, _, box=LAST):
    space.add_hatch(dxfattribs=ON).paths.add_polyline_path(between(*box), is_closed=True)


def edges(space, _):
    path = space.add_hatch(dxfattribs=ON).paths.add_edge_path()
    corners = between(*LAST)
    for k in range(4):
        path.add_line(corners[k], corners[(k + 1) % 4])


def mpolygon(space, _):
    space.add_mpolygon(dxfattribs=ON).paths.add_polyline_path(between(*LAST), is_closed=True)


@pytest.mark.parametrize("draw", [reference, nested, solid, trace, face, hatch, edges, mpolygon])
def test_a_stone_is_read_whatever_it_is_drawn_with(tmp_path, draw):
    stones, remarks = imported(tmp_path / "wall.dxf", draw)
    assert [block.polygon.mean(axis=0) for block in stones][-1] == pytest.approx([0.8, 0.3])
    assert len(stones) == 4
    assert not [said for said in remarks if "WARNING" in said]
    told = "blocks: 1 outline of hatches, solids or faces, where none is drawn"
    assert (told in remarks) == (draw not in (reference, nested))


def test_an_array_of_references_is_as_many_stones(tmp_path):
    def array(space, document):
        spacing = {"column_count": 2, "column_spacing": 400, "row_count": 2, "row_spacing": 200}
        space.add_blockref(stone(document), (0, 0), dxfattribs=ON | spacing)

    assert len(imported(tmp_path / "wall.dxf", array, [])[0]) == 4


def test_hatches_and_texts_on_outlines_are_decoration(tmp_path):
    """One hatch on each stone, one of them 3 mm off, two on all of them, a small one in a corner, texts and points."""

    def decorate(space, document):
        hatch(space, document, (3, 2, 403, 202))
        for box in BOXES[1:]:
            hatch(space, document, box)
        hatch(space, document, (0, 0, 1000, 400))
        hatch(space, document, (10, 10, 60, 60))
        space.add_text("S", dxfattribs=ON | {"height": 50})
        space.add_linear_dim(base=(0, -300), p1=(0, 0), p2=(800, 0), dxfattribs=ON).render()
        space.add_point((0, 0), dxfattribs=ON)

    stones, remarks = imported(tmp_path / "wall.dxf", decorate, BOXES)
    assert len(stones) == 4
    assert "blocks: 6 filled areas passed over, on outlines that are drawn" in remarks
    assert "passed over on layer 'blocks': 1 DIMENSION, 1 POINT, 1 TEXT" in remarks
    assert not [said for said in remarks if "WARNING" in said]


def test_two_hatches_on_one_stone_are_one_stone(tmp_path):
    def twice(space, document):
        hatch(space, document)
        hatch(space, document, [x + 2 for x in LAST])

    assert len(imported(tmp_path / "wall.dxf", twice)[0]) == 4


def test_a_hole_in_a_hatch_is_filled_with_a_warning(tmp_path):
    def with_hole(space, _):
        paths = space.add_hatch(dxfattribs=ON).paths
        paths.add_polyline_path(between(*LAST), is_closed=True)
        paths.add_polyline_path(between(700, 250, 800, 300), is_closed=True)

    stones, remarks = imported(tmp_path / "wall.dxf", with_hole)
    assert len(stones) == 4
    assert "blocks: WARNING: 1 hole in hatches filled" in remarks


def region(space, _):
    space.add_region(dxfattribs=ON).sat = ["400 0 1 0"]  # a region without data is not written


def test_what_may_be_a_stone_and_is_not_read_is_a_warning(tmp_path):
    def regions(space, document):
        for _ in range(2):
            region(space, document)
        space.add_text("S", dxfattribs=ON)
        space.add_text("beside", dxfattribs={"layer": "texts"})
        space.add_blockref("LOST", (0, 0), dxfattribs=ON)

    stones, remarks = imported(tmp_path / "wall.dxf", regions)
    assert len(stones) == 3
    said = (
        "WARNING: passed over on layer 'blocks': 1 INSERT, 2 REGION, 1 TEXT; draw as closed polylines what is a stone"
    )
    assert said in remarks


def test_a_layer_on_which_nothing_can_be_read_is_refused_with_what_is_there(tmp_path):
    with pytest.raises(CaseError, match=r"nothing is drawn on layer 'blocks'; WARNING: passed over on .*: 1 REGION"):
        imported(tmp_path / "wall.dxf", region, [])


def invisible(space, _):
    polyline(space, LAST).dxf.invisible = 1


def in_invisible_reference(space, document):
    space.add_blockref(stone(document), LAST[:2], dxfattribs=ON).dxf.invisible = 1


def in_frozen_reference(space, document):
    document.layers.add("frozen").freeze()
    document.blocks.new("INNER").add_lwpolyline(between(*LAST), close=True, dxfattribs=ON)
    space.add_blockref("INNER", (0, 0), dxfattribs={"layer": "frozen"})


@pytest.mark.parametrize("draw", [invisible, in_invisible_reference, in_frozen_reference])
def test_what_is_hidden_is_passed_over_and_counted(tmp_path, draw):
    stones, remarks = imported(tmp_path / "wall.dxf", draw)
    assert len(stones) == 3
    assert "passed over on layer 'blocks': 1 hidden LWPOLYLINE" in remarks


@pytest.mark.parametrize("hide", ["off", "freeze"])
def test_a_layer_that_is_switched_off_is_not_read(tmp_path, hide):
    def switched(space, document):
        getattr(document.layers.add("blocks"), hide)()

    with pytest.raises(CaseError, match=r"nothing is drawn .*; passed over on layer 'blocks': 3 hidden LWPOLYLINE"):
        imported(tmp_path / "wall.dxf", switched)


def test_supports_that_are_hidden_are_told_where_there_are_no_others(tmp_path):
    def switched(space, document):
        document.layers.add("supports").off()
        polyline(space, (0, -200, 2000, 0), "supports")

    said = r"supports: the drawing has none; passed over on layer 'supports': 1 hidden LWPOLYLINE; show what is hidden"
    with pytest.raises(CaseError, match=said):
        imported(tmp_path / "wall.dxf", switched, ground="")


def test_a_reference_on_a_layer_that_is_off_shows_what_is_on_others(tmp_path):
    def switched(space, document):
        document.layers.add("plan").off()
        document.blocks.new("INNER").add_lwpolyline(between(*LAST), close=True, dxfattribs=ON)
        space.add_blockref("INNER", (0, 0), dxfattribs={"layer": "plan"})

    assert len(imported(tmp_path / "wall.dxf", switched)[0]) == 4


def test_an_ellipse_of_a_ratio_without_sense_is_refused(tmp_path):
    """Flattened it would take all memory."""
    document = ezdxf.new("R2000", setup=True)
    document.header["$INSUNITS"] = MILLIMETRES
    document.modelspace().add_ellipse((0, 0), (100, 0), ratio=0.5, dxfattribs=ON)
    path = tmp_path / "ellipse.dxf"
    document.saveas(path)
    before, name, after = path.read_text().rpartition("AcDbEllipse")
    path.write_text(before + name + after.replace("\n 40\n0.5\n", "\n 40\n1e300\n", 1))
    with pytest.raises(CaseError, match=r"layer 'blocks': an ellipse has a ratio of 1e\+300"):
        import_wall(path, {"thickness": "0.3 m", "ground": "0.2 m", "friction": "0.6"})
