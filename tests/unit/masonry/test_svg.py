"""Stones from SVG: shapes, transforms, curves as fine as asked, groups as roles and materials."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from orchestrator.basis.errors import CaseError
from orchestrator.masonry.sources.closed_outlines import Layers
from orchestrator.masonry.sources.svg import read_svg
from tests.support.drawn_stones import GROUND, STONES, expected, polygons, same


def svg(tmp_path, body, head='width="120mm" height="90mm" viewBox="0 0 120 90"'):
    spaces = 'xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"'
    (tmp_path / "wall.svg").write_text(f"<svg {spaces} {head}>{body}</svg>")
    return tmp_path / "wall.svg"


def as_path(stone, command="M"):
    (x, y), *rest = stone
    return f"{command} {x},{y} " + " ".join(f"L{a},{b}" for a, b in rest) + " z"


def as_polygon(stone):
    return " ".join(f"{x},{y}" for x, y in stone)


@pytest.mark.parametrize(
    "body",
    [
        "".join(f'<path d="{as_path(stone)}"/>' for stone in STONES),
        f'<path d="{" ".join(as_path(stone) for stone in STONES)}"/>',
        "".join(f'<polygon points="{as_polygon(stone)}"/>' for stone in STONES),
        "".join(f'<polyline points="{as_polygon([*stone, stone[0]])}"/>' for stone in STONES),
        '<g transform="translate(5 7) scale(.5)"><g transform="matrix(0 2 -2 0 0 0)">'
        + "".join(f'<path transform="rotate(-90)" d="{as_path(stone)}"/>' for stone in STONES)
        + "</g></g>",
        '<path d="m0 0h40v20H0zm40 0 h60l-5 20h-55zM0 20l60-0 0 3e1-60-5z"/>'
        '<path d="M60,20 95,20 90,55 60,50Z" style="fill:none"/>',
        "".join(
            f'<line x1="{a[0]}" y1="{a[1]}" x2="{b[0]}" y2="{b[1]}"/>'
            for stone in STONES
            for a, b in zip(stone, [*stone[1:], stone[0]], strict=True)
        ),
    ],
    ids=["paths", "one path", "polygons", "polylines", "transforms", "relative", "lines"],
)
def test_svg_shapes_are_the_stones(tmp_path, body):
    drawing = read_svg(svg(tmp_path, body), Layers(), 1e-5)
    assert len(drawing.stones) == 4
    for exact in expected(0.001):
        assert min(same(outline, exact) for outline in drawing.stones) == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize(
    ("rules", "group", "by"),
    [
        ("", 'style="transform: translate(10px, 0px)"', "transform"),
        (".moved { transform: translate(10px, 0px) }", 'class="moved"', "transform"),
        ("", 'style="rotate: 3deg"', "rotate"),
        ("", 'transform="rotate(3)" transform-origin="50 50"', "transform-origin"),
    ],
)
def test_what_a_style_moves_is_refused(tmp_path, rules, group, by):
    """It is not read, and the stones would be somewhere else."""
    body = f'<style>{rules}</style><path d="M0,0 h40 v20 h-40 z"/><g {group}><path d="M40,0 h40 v20 h-40 z"/></g>'
    with pytest.raises(CaseError, match=f"g: is moved by {by}, which is not read; write it as the attribute transform"):
        read_svg(svg(tmp_path, body), Layers(), 1e-5)


def test_a_style_that_moves_nothing_is_read(tmp_path):
    body = '<g style="transform: none; fill: red" transform-origin="5 5"><path d="M0,0 h40 v20 h-40 z"/></g>'
    assert len(read_svg(svg(tmp_path, body), Layers(), 1e-5).stones) == 1


@pytest.mark.parametrize(("how", "unit"), [("", 0.01), ("xMidYMid meet", 0.01), ("xMidYMid slice", 0.02)])
def test_a_drawing_of_other_proportions_than_its_view_box_is_scaled_as_it_says(tmp_path, how, unit):
    """2 m x 1 m of 100 x 100 units: all of them fit at 10 mm, the sheet is full at 20 mm (SVG 1.1, 7.8)."""
    head = f'width="2000mm" height="1000mm" viewBox="0 0 100 100" preserveAspectRatio="{how}"'
    drawing = read_svg(svg(tmp_path, '<path d="M0,0 h40 v20 h-40 z"/>', head), Layers(), 1e-5)
    assert np.ptp(drawing.stones[0], axis=0) == pytest.approx([40 * unit, 20 * unit])


def test_one_stone_and_one_hole_are_told_in_the_singular(tmp_path):
    path = "M0,0 h40 v20 h-40 z m10,5 h10 v5 h-10 z"
    drawing = read_svg(svg(tmp_path, f'<path fill-rule="evenodd" d="{path}"/>'), Layers(), 1e-5)
    assert "1 stone found" in drawing.remarks
    assert "blocks: WARNING: 1 hole in outlines filled" in drawing.remarks


def test_svg_groups_are_roles_and_materials(tmp_path):
    one, two, three, four = (f'<path d="{as_path(stone)}"/>' for stone in STONES)
    body = (
        f'<g inkscape:groupmode="layer" inkscape:label="stone" id="layer1">{one}{two}<g id="g12">{three}</g></g>'
        f'<g id="timber">{four}</g><g id="supports"><path d="{as_path(GROUND)}"/></g>'
        f'<g id="notes">{one}<text>wall</text></g><g id="stone" style="display: none">{one}</g>'
        f'<defs><g id="stone">{four}</g></defs>'
    )
    drawing = read_svg(svg(tmp_path, body), Layers("stone, timber"), 1e-5)
    assert drawing.materials == ("stone", "stone", "stone", "timber")
    assert len(drawing.supports) == 1
    assert "WARNING: passed over: 1 hidden path, 1 text" in drawing.remarks
    with pytest.raises(
        CaseError, match=r"nothing is drawn in a group 'blocks'; .*groups: notes, stone, supports, timber"
    ):
        read_svg(svg(tmp_path, body), Layers(), 1e-5)


def test_svg_of_clones_alone_says_that_they_are_passed_over(tmp_path):
    stone = f'<defs><path id="a" d="{as_path(STONES[0])}"/></defs><use href="#a"/><use href="#a" x="40"/>'
    with pytest.raises(CaseError, match=r"nothing is drawn in a group 'blocks'; passed over: 2 use"):
        read_svg(svg(tmp_path, stone), Layers(), 1e-5)


HIDDEN = [
    ("", '<path d="{0}" visibility="hidden"/>'),
    ("", '<path d="{0}" style="fill:none; visibility : collapse"/>'),
    ("", '<g visibility="hidden"><path d="{0}"/></g>'),
    ("", '<g display="none"><path visibility="visible" d="{0}"/></g>'),
    (".old, .gone { display: none }", '<path class="a gone" d="{0}"/>'),
    ("path#p7{visibility:hidden !important}", '<path id="p7" d="{0}"/>'),
    ("/* path{} */ .old{display:inline} .old{display:none}", '<g class="old"><path d="{0}"/></g>'),
]
SHOWN = [
    ("", '<g visibility="hidden"><path visibility="visible" d="{0}"/></g>'),
    ("circle.old{display:none} .older{display:none}", '<path class="old" d="{0}"/>'),
    (".old{display:none}", '<path class="old" style="display:inline" d="{0}"/>'),
    (".old{display:none} #p7{display:block}", '<path class="old" id="p7" d="{0}"/>'),
]


@pytest.mark.parametrize(("sheet", "last"), HIDDEN)
def test_what_is_hidden_is_passed_over_and_counted(tmp_path, sheet, last):
    rest = "".join(f'<path d="{as_path(stone)}"/>' for stone in STONES[:-1])
    body = f"<style>{sheet}</style>{rest}{last.format(as_path(STONES[-1]))}"
    drawing = read_svg(svg(tmp_path, body), Layers(), 1e-5)
    assert len(drawing.stones) == 3
    assert "passed over: 1 hidden path" in drawing.remarks


@pytest.mark.parametrize(("sheet", "last"), SHOWN)
def test_what_is_shown_again_is_read(tmp_path, sheet, last):
    rest = "".join(f'<path d="{as_path(stone)}"/>' for stone in STONES[:-1])
    body = f"<style>{sheet}</style>{rest}{last.format(as_path(STONES[-1]))}"
    assert len(read_svg(svg(tmp_path, body), Layers(), 1e-5).stones) == 4


@pytest.mark.parametrize(
    ("sheet", "last", "shapes"),
    [
        ("", '<path clip-path="url(#c)" d="{0}"/>', "1 shape"),
        ("", '<path style="clip-path: url(#c)" d="{0}"/>', "1 shape"),
        ("", '<path mask="url(#c)" d="{0}"/>', "1 shape"),
        (".half { clip-path: url(#c) }", '<path class="half" d="{0}"/>', "1 shape"),
        ("", '<g clip-path="url(#c)"><path d="{0}"/><g><path d="M0,70 h10 v10 h-10 z"/></g></g>', "2 shapes"),
    ],
)
def test_a_stone_that_is_clipped_is_read_whole_and_counted(tmp_path, sheet, last, shapes):
    body = "".join(f'<path d="{as_path(stone)}"/>' for stone in STONES[:3]) + last.format(as_path(STONES[3]))
    clip = '<defs><clipPath id="c"><rect x="0" y="0" width="1" height="1"/></clipPath></defs>'
    drawing = read_svg(svg(tmp_path, f"<style>{sheet}</style>{clip}{body}"), Layers(), 1e-5)
    assert len(drawing.stones) == 3 + int(shapes[0])
    said = (
        f"WARNING: {shapes} with a clip-path or mask read as if without: delete what it hides, or cut the shapes there"
    )
    assert said in drawing.remarks


def test_a_clip_path_that_is_none_or_of_what_is_hidden_is_not_said(tmp_path):
    body = "".join(f'<path clip-path="none" d="{as_path(stone)}"/>' for stone in STONES)
    hidden = f'<g display="none" clip-path="url(#c)"><path d="{as_path(STONES[0])}"/></g>'
    drawing = read_svg(svg(tmp_path, body + hidden), Layers(), 1e-5)
    assert not [remark for remark in drawing.remarks if "WARNING" in remark]


def test_a_rule_that_hides_and_cannot_be_read_is_a_warning(tmp_path):
    body = f'<style>g > .old {{display:none}}</style><path d="{as_path(STONES[0])}"/>'
    remarks = read_svg(svg(tmp_path, body), Layers(), 1e-5).remarks
    assert "WARNING: style of 'g > .old' hides or moves something and is not read" in remarks


@pytest.mark.parametrize(
    ("inner", "unit"),
    [
        ('x="10" y="20" width="60" height="45" viewBox="0 0 120 90"', 0.5e-3),
        ('width="60" height="80" viewBox="0 0 120 90"', 0.5e-3),
        ('width="60" height="45" viewBox="0 0 240 90" preserveAspectRatio="xMinYMax slice"', 0.5e-3),
        ('x="7"', 1e-3),
    ],
)
def test_a_drawing_within_a_drawing_is_read_at_its_scale(tmp_path, inner, unit):
    body = f"<svg {inner}>" + "".join(f'<path d="{as_path(stone)}"/>' for stone in STONES) + "</svg>"
    drawing = read_svg(svg(tmp_path, body), Layers(), 1e-5)
    for outline, exact in zip(drawing.stones, expected(unit), strict=True):
        assert same(outline, exact) == pytest.approx(0, abs=1e-12)


def test_a_drawing_within_a_drawing_is_where_it_is_placed(tmp_path):
    """A square of 10 in a view of 20 x 10 that is fitted into 100 x 100: 50 high, 25 from the top; beside it one of the
    drawing around."""
    body = (
        '<rect x="0" y="0" width="5" height="100"/><svg x="5" y="0" width="100" height="100" viewBox="0 0 20 10">'
        '<rect width="10" height="10"/></svg>'
    )
    _, inner = polygons(read_svg(svg(tmp_path, body), Layers(), 1e-5))
    assert inner.bounds == pytest.approx((0.005, 0.025, 0.055, 0.075))


@pytest.mark.parametrize(
    ("head", "scale", "unit"),
    [
        ('width="12cm" height="9cm" viewBox="0 0 120 90"', None, 1e-3),
        ('width="120" height="90" viewBox="0 0 120 90"', 0.02, 0.02),
        ('width="120mm" height="90mm" viewBox="0 0 240 180"', None, 0.5e-3),
        ('width="120mm" height="90mm"', None, 0.0254 / 96),
        ('width="120mm" height="90mm" viewBox="-7 -9 120 90"', 0.01, 0.01),
    ],
)
def test_svg_units(tmp_path, head, scale, unit):
    body = "".join(f'<path d="{as_path(stone)}"/>' for stone in STONES)
    drawing = read_svg(svg(tmp_path, body, head), Layers(), 1e-5, scale)
    for outline, exact in zip(drawing.stones, expected(unit), strict=True):
        assert same(outline, exact) == pytest.approx(0, abs=1e-9 * unit)


@pytest.mark.parametrize(
    ("body", "area"),
    [
        ('<circle cx="50" cy="40" r="20"/>', np.pi * 20**2),
        ('<ellipse cx="50" cy="40" rx="20" ry="10" transform="rotate(30 50 40)"/>', np.pi * 200),
        ('<rect x="10" y="10" width="60" height="40" rx="10"/>', 60 * 40 - (4 - np.pi) * 100),
        ('<rect x="10" y="10" width="60" height="40"/>', 60 * 40),
        ('<path d="M10 10A20 20 0 0150 10z"/>', np.pi * 200),
        ('<path d="M10 10a20 20 0 1 0 40 0z"/>', np.pi * 200),
        ('<path d="M30 10 A20 20 0 1 1 10 30 z"/>', 0.75 * np.pi * 400 + 200),
        ('<path d="M0 0 Q 30 60 60 0 z"/>', 60 * 60 / 3),
        ('<path d="M0 0 Q 15 30 30 30 T 60 0 z"/>', 2 * (30 * 30 - 30 * 30 / 3)),
        ('<path d="M0 0 C 0 40 60 40 60 0 z"/>', 60 * 40 * 0.6),
        ('<path d="M0 0 C 10 20 20 30 30 30 S 50 20 60 0 z"/>', 2 * 30 * 20),
        ('<path d="M0 0 h60 v60 h-60z M20 20 h20 v20 h-20z"/>', 3600),
    ],
)
def test_svg_curves_are_as_fine_as_asked(tmp_path, body, area):
    drawing = read_svg(svg(tmp_path, body), Layers(), 1e-6)
    assert len(drawing.stones) == 1
    found = polygons(drawing)[0]
    assert found.area == pytest.approx(area * 1e-6, abs=1e-6 * found.length)
    coarse = polygons(read_svg(svg(tmp_path, body), Layers(), 1e-4))[0]
    assert shapely.hausdorff_distance(found, coarse) < 1.1e-4


@pytest.mark.parametrize(
    ("body", "head", "complaint"),
    [
        (f'<path d="{as_path(STONES[0])}"/>', 'width="120" height="90"', "--scale: the drawing does not say"),
        (f'<path d="{as_path(STONES[0])}"/>', 'width="9furlong" height="9mm"', "--scale: the drawing does not say"),
        (f'<path d="{as_path(STONES[0])}"/>', 'width="9mm" height="9mm" viewBox="0 0 0 9"', "viewBox: is not four"),
        (
            f'<path d="{as_path(STONES[0])}"/>',
            'width="9mm" height="9mm" viewBox="0 0 a 9"',
            "viewBox: '0 0 a 9' is not",
        ),
        ("", None, "blocks: nothing is drawn"),
        ('<path id="p1" d="M 0 0 L 5 nan z"/>', None, "path p1: path data cannot be read at 'nan z'"),
        ('<path d="M 0 0 L 5 z"/>', None, "path: path data have 1 numbers after 'L'"),
        ('<path d="5 5 L 5 z"/>', None, "path: path data have 2 numbers after 'no command'"),
        ('<path d="M0 0 L1e14 0 L 0 5z"/>', None, "a coordinate is not a number below 1e9 m"),
        ('<path d="M0 0 L1e999 0 L 0 5z"/>', None, "path: a number is not below 1e+15"),
        ('<path d="M0 0 C 0 1e8 1e8 0 5 5z"/>', None, "a curve needs more than 1000 chords"),
        ('<g transform="spin(3)"><path d="M0 0"/></g>', None, "transform: 'spin' with 1 numbers cannot be read"),
        (
            '<g transform="scale(x)"><path d="M0 0"/></g>',
            None,
            "transform: 'x' is not a list of numbers in user units",
        ),
        ('<svg width="50%" height="9" viewBox="0 0 9 9"/>', None, "nested svg: its place or size '50%' is not in user"),
        ("<g>" * 200 + "</g>" * 200, None, "nested more than 100 deep"),
    ],
)
def test_svg_drawings_that_cannot_be_used(tmp_path, body, head, complaint):
    path = svg(tmp_path, body, head) if head else svg(tmp_path, body)
    with pytest.raises(CaseError) as caught:
        read_svg(path, Layers(), 1e-3)
    assert "wall.svg: " in str(caught.value)
    assert complaint in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "content",
    [b"", b"not xml", b"<svg>", b"<html/>", b"\x00\xff", b'<?xml version="1.0" encoding="nothing"?><svg/>'],
)
def test_what_is_no_svg(tmp_path, content):
    (tmp_path / "wall.svg").write_bytes(content)
    with pytest.raises(CaseError, match=r"wall\.svg: is not an SVG drawing"):
        read_svg(tmp_path / "wall.svg", Layers(), 1e-3)


def test_svg_entities_are_refused_before_they_expand(tmp_path):
    bomb = "".join(f'<!ENTITY e{k + 1} "{10 * f"&e{k};"}">' for k in range(9))
    (tmp_path / "wall.svg").write_text(f'<!DOCTYPE svg [<!ENTITY e0 "lol">{bomb}]><svg>&e9;</svg>')
    with pytest.raises(CaseError, match="declares entities, which are not read; save it as plain SVG"):
        read_svg(tmp_path / "wall.svg", Layers(), 1e-3)
