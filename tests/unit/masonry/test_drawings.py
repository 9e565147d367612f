"""What drawings get wrong: lines that stop short, stones drawn twice, units; each is read all the same, or said."""

from __future__ import annotations

from itertools import pairwise

import ezdxf
import numpy as np
import pytest
from scipy.interpolate import BPoly

from orchestrator.app.intake import import_wall
from orchestrator.basis.errors import CaseError
from orchestrator.geometry.healing import heal
from orchestrator.masonry.patterns import ArchedOpening, ArchedWall, IrregularCourses, Rubble, arched_wall, rubble
from orchestrator.masonry.sources import drawing
from tests.support.drawings import CENTIMETRES, INCHES, METRES, MILLIMETRES, polylines
from tests.support.walls import between

MATERIAL = {"thickness": "0.3 m"}
WALLS = {
    "rubble": lambda: rubble(Rubble(1.8, 1.4, stone=0.35, seed=2)),
    "arch": lambda: arched_wall(
        ArchedWall(
            IrregularCourses(3.2, 2.8, thickness=0.4, widths=(0.3, 0.5), heights=(0.2, 0.28), overlap=0.06),
            (ArchedOpening(1.1, 2.1, 0.0, 1.2, depth=0.25, voussoirs=11),),
        )
    ),
}


def drawn(path, lines=(), outlines=()):
    """Draw lines (ends in mm) and closed outlines on the layer of the blocks."""
    document = ezdxf.new()
    document.header["$INSUNITS"] = MILLIMETRES
    for a, b in lines:
        document.modelspace().add_line(a, b, dxfattribs={"layer": "blocks"})
    for outline in outlines:
        document.modelspace().add_lwpolyline(outline, close=True, dxfattribs={"layer": "blocks"})
    document.saveas(path)
    return path


def frame(*corners):
    """The edges of a box as lines."""
    outline = between(*corners)
    return list(zip(outline, np.roll(outline, -1, axis=0), strict=True))


def read(path, **options):
    taken = import_wall(path, MATERIAL | {"ground": "0.2 m"} | options)
    return sum(not block.fixed for block in taken.wall.blocks), taken.remarks


def test_lines_that_stop_short_are_counted_with_places_and_the_tolerance_that_closes_them(tmp_path):
    """A frame of three stones: both joints inside stop 3 mm short below, and one 2 mm short above."""
    joints = [((400, 3), (400, 300)), ((800, 3), (800, 298))]
    path = drawn(tmp_path / "short.dxf", frame(0, 0, 1200, 300) + joints)
    found, remarks = read(path)
    assert found == 1
    assert (
        "blocks: WARNING: 2 lines close no outline; 3 open ends at (0.4, 0.003), (0.8, 0.003), (0.8, 0.298) m, "
        "2 mm to 3 mm from the nearest line; "
        '--tolerance "4 mm" closes 2 outlines more'
    ) in remarks
    assert "WARNING" in remarks[0], "warnings are first"
    found, remarks = read(path, tolerance="4 mm")
    assert found == 3
    assert not [remark for remark in remarks if "open end" in remark]


def test_a_line_that_no_tolerance_closes_is_told_apart(tmp_path):
    """A dimension line outside and a joint that stops 20 mm short: the smallest tolerance that closes the joint."""
    extra = [((400, 20), (400, 300)), ((0, 600), (900, 600)), ((1000, 900), (1010, 900))]
    _, remarks = read(drawn(tmp_path / "short.dxf", frame(0, 0, 800, 300) + extra))
    said = next(remark for remark in remarks if "open end" in remark)
    assert "3 lines close no outline; 5 open ends at (0, 0.6), (0.4, 0.02), (0.9, 0.6), (1, 0.9), (1.01, 0.9) m" in said
    assert 'tolerance "30 mm" closes 1 outline more, 1 line stays open then' in said


def test_a_drawing_none_of_whose_lines_close_is_refused_with_the_tolerance_to_try(tmp_path):
    outline = between(0, 0, 400, 300)
    lines = [(a + 0.01 * (b - a), b) for a, b in zip(outline, np.roll(outline, -1, axis=0), strict=True)]
    path = drawn(tmp_path / "open.dxf", lines)
    with pytest.raises(CaseError, match=r'none; 4 lines .* --tolerance "5 mm" closes 1 outline more$'):
        read(path)
    assert read(path, tolerance="5 mm")[0] == 1


def test_a_line_within_a_stone_that_meets_none_is_told_with_what_to_do(tmp_path):
    path = drawn(tmp_path / "dangling.dxf", [*frame(0, 0, 800, 300), ((100, 80), (200, 130))])
    found, remarks = read(path)
    assert found == 1
    assert remarks[0] == (
        "blocks: WARNING: 1 line closes no outline; 2 open ends at (0.1, 0.08), (0.2, 0.13) m; no --tolerance up to "
        "50 mm closes an outline more: draw on to where they meet others, or delete what is no outline"
    )


def test_an_open_polyline_that_ends_on_a_closed_stone_is_told_to_be_closed(tmp_path):
    """The fourth side of the second stone is one of the first."""
    document = ezdxf.new()
    document.header["$INSUNITS"] = MILLIMETRES
    space = document.modelspace()
    space.add_lwpolyline([(0, 0), (500, 0), (500, 300), (0, 300)], close=True, dxfattribs={"layer": "blocks"})
    space.add_lwpolyline([(500, 0), (900, 0), (900, 300), (500, 300)], dxfattribs={"layer": "blocks"})
    document.saveas(tmp_path / "open.dxf")
    found, remarks = read(tmp_path / "open.dxf")
    assert found == 1
    assert remarks[0] == (
        "blocks: WARNING: 1 polyline is open, which begins at (0.5, 0) m: if it is an outline, close it "
        "(Close in CAD, Z in an SVG path)"
    )
    assert remarks[1] == (
        "blocks: WARNING: 1 line closes no outline; 2 open ends at (0.5, 0), (0.5, 0.3) m, 0 mm from the nearest line; "
        "there is a closed outline, whose sides bound no other: draw on along it until closed"
    )


def test_an_arched_wall_of_lines_and_arcs_with_gaps_is_refused_with_the_tolerance_that_reads_it(tmp_path):
    """Every arc begins 3 mm late, and every joint 3 mm outside the intrados."""
    document = ezdxf.new()
    document.header["$INSUNITS"] = MILLIMETRES
    space, blocks = document.modelspace(), {"layer": "blocks"}
    angles = np.linspace(0.0, 180.0, 6)
    for radius in (500.0, 700.0):
        for a, b in pairwise(angles):
            space.add_arc((0, 0), radius, a + np.degrees(3.0 / radius), b, dxfattribs=blocks)
    for x, y in zip(np.cos(np.radians(angles)), np.sin(np.radians(angles)), strict=True):
        space.add_line((503 * x, 503 * y), (700 * x, 700 * y), dxfattribs=blocks)
    document.saveas(tmp_path / "arch.dxf")
    with pytest.raises(CaseError) as refused:
        read(tmp_path / "arch.dxf")
    said = str(refused.value)
    assert "mm from the nearest line" in said, said
    tolerance = said.partition('--tolerance "')[2].partition('"')[0]
    assert read(tmp_path / "arch.dxf", tolerance=tolerance)[0] == 5


def test_outlines_that_overlap_by_more_than_the_tolerance_are_refused_with_the_one_that_reads_them(tmp_path):
    jitter = np.random.default_rng(1).uniform(-1.5, 1.5, (12, 4, 2))
    boxes = [between(400 * c, 200 * r, 400 * c + 400, 200 * r + 200) for r in range(3) for c in range(4)]
    path = drawn(tmp_path / "errors.dxf", outlines=np.array(boxes) + jitter)
    with pytest.raises(CaseError, match=r'--tolerance "\d+ mm" closes the wall') as refused:
        read(path)
    tolerance = refused.value.remedy.partition('"')[2].partition('"')[0]
    found, remarks = read(path, tolerance=tolerance)
    assert found == 12
    assert not [remark for remark in remarks if "WARNING" in remark]


def test_a_tolerance_is_not_promised_to_close_a_wall_with_curves(tmp_path):
    """The lower edge of a stone bends 15 mm into the ground, by how much depends on the chords of its curve."""
    document = ezdxf.new()
    document.header["$INSUNITS"] = METRES
    space, points = document.modelspace(), [(0, 0), (0.3, 0), (0.6, 0), (0.7, 0.3), (0.3, 0.5), (0, 0.3), (0, 0)]
    space.add_spline([(*point, 0) for point in points], dxfattribs={"layer": "blocks"})
    space.add_lwpolyline(between(-0.2, -0.2, 1.0, 0), close=True, dxfattribs={"layer": "supports"})
    document.saveas(tmp_path / "spline.dxf")
    with pytest.raises(CaseError, match=r'--tolerance "8 mm" may close the wall: curves are read anew with it'):
        read(tmp_path / "spline.dxf", ground="")


def test_a_spline_of_degree_four_is_read_where_it_runs(tmp_path):
    """Its one span is the polynomial of its Bernstein coefficients."""
    document, heights = ezdxf.new(), np.array([0.5, 0.9, 0.2, 0.9, 0.5])
    document.header["$INSUNITS"] = METRES
    top = document.modelspace().add_spline(degree=4, dxfattribs={"layer": "blocks"})
    top.control_points = [(0.25 * k, height, 0) for k, height in enumerate(heights)]
    top.knots = [0] * 5 + [1] * 5
    sides = [(0, 0.5), (0, 0), (1, 0), (1, 0.5)]
    document.modelspace().add_lwpolyline(sides, dxfattribs={"layer": "blocks"})
    document.saveas(tmp_path / "spline.dxf")
    taken = import_wall(tmp_path / "spline.dxf", MATERIAL | {"ground": "0.2 m", "tolerance": "0.1 mm"})
    (stone,) = (block for block in taken.wall.blocks if not block.fixed)
    x, y = stone.polygon[stone.polygon[:, 1] > 0].T
    assert y == pytest.approx(BPoly(heights[:, None], [0, 1])(x), abs=1e-5)


@pytest.mark.parametrize("overlap", [2, 5, 6])
def test_a_stone_drawn_too_long_is_refused_above_the_tolerance_and_has_no_tip(tmp_path, overlap):
    boxes = [(0, 0, 500 + overlap, 250), (500, 0, 1000, 250), (0, 250, 250, 500), (250, 250, 1000, 500)]
    path = drawn(tmp_path / "long.dxf", outlines=[between(*box) for box in boxes])
    with pytest.raises(CaseError, match=r"blocks? 1 .*(lie on one another, by more than|overlaps block 2)") as refused:
        read(path)
    tolerance = refused.value.remedy.partition('"')[2].partition('"')[0]
    found, remarks = read(path, tolerance=tolerance)
    assert found == 4
    assert any(f"1 overlap between blocks closed, median {overlap} mm" in remark for remark in remarks)
    assert not [remark for remark in remarks if "WARNING" in remark or "tip" in remark]


def test_an_exact_drawing_has_no_short_edges_to_speak_of(tmp_path):
    joints = [((200.1 * k, 0), (200.1 * k, 300)) for k in range(1, 4)]
    _, remarks = read(drawn(tmp_path / "exact.dxf", frame(0, 0, 800.4, 300) + joints))
    assert not [remark for remark in remarks if "short edge" in remark]


def test_an_open_polyline_is_closed_by_the_distance_of_its_ends(tmp_path):
    document = ezdxf.new()
    document.header["$INSUNITS"] = MILLIMETRES
    corners = [(0, 0), (400, 0), (400, 300), (0, 300), (0, 6)]
    document.modelspace().add_lwpolyline(corners, dxfattribs={"layer": "blocks"})
    document.modelspace().add_lwpolyline(between(400, 0, 800, 300), close=True, dxfattribs={"layer": "blocks"})
    document.saveas(tmp_path / "open.dxf")
    _, remarks = read(tmp_path / "open.dxf")
    assert any(
        '2 open ends at (0, 0), (0, 0.006) m, 6 mm from the nearest line; --tolerance "8 mm" closes 1 outline' in said
        for said in remarks
    )


def test_an_outline_of_lines_around_another_one_is_said(tmp_path):
    lines = frame(0, 0, 800, 600) + frame(200, 200, 400, 400)
    said = (
        r"block 2: touches no other .*; reading it warned of a likely cause: .*1 outline of lines encloses others and"
    )
    with pytest.raises(CaseError, match=said):
        read(drawn(tmp_path / "ring.dxf", lines, [between(0, -300, 800, 0)]))


def test_an_outline_there_and_back_is_refused_with_its_place(tmp_path):
    """Four corners, two of them clicked twice: of two corners no ring can be made."""
    outlines = [between(0, 0, 400, 300), [(500, 0), (900, 0), (900, 0), (500, 0)]]
    with pytest.raises(CaseError, match=r"outline at \(0\.5, 0\) m: .* has no area; draw its corners in order"):
        read(drawn(tmp_path / "back.dxf", outlines=outlines))


@pytest.mark.parametrize(("shift", "apart"), [(0.0, ""), (0.6, ", up to 0.6 mm apart")])
def test_a_stone_drawn_twice_within_the_tolerance_is_one(tmp_path, shift, apart):
    stones = [between(0, 0, 400, 300), between(400, 0, 800, 300), between(0, 300, 800, 500)]
    found, remarks = read(drawn(tmp_path / "twice.dxf", outlines=[*stones, stones[1] + [shift, 0.0]]))
    assert found == 3
    x = 0.6 + 1e-3 * shift
    assert f"blocks: 1 outline drawn twice{apart}, kept once; at ({x:.4g}, 0.15) m" in remarks


def test_every_stone_drawn_twice_by_another_hand_is_read_once(tmp_path):
    wall = rubble(Rubble(1.4, 1.2, stone=0.35, seed=1))
    document = ezdxf.new()
    document.header["$INSUNITS"] = MILLIMETRES
    random = np.random.default_rng(0)
    for _ in range(2):
        for block in wall.blocks:
            corners = 1e3 * block.polygon + random.uniform(-0.3, 0.3, block.polygon.shape)
            layer = {"layer": "supports" if block.fixed else "blocks"}
            document.modelspace().add_lwpolyline(corners, close=True, dxfattribs=layer)
    document.saveas(tmp_path / "twice.dxf")
    taken = import_wall(tmp_path / "twice.dxf", MATERIAL)
    assert len(taken.wall.blocks) == len(wall.blocks)
    assert any(said.startswith(f"blocks: {len(wall.blocks) - 1} outlines drawn twice") for said in taken.remarks)


@pytest.mark.parametrize("shift", [0.4, 0.8])
def test_lines_drawn_twice_leave_no_slivers(tmp_path, shift):
    lines = [*frame(0, 0, 800, 300), ((400, 0), (400, 300))]
    lines += [(np.add(a, shift), np.add(b, shift)) for a, b in lines]
    found, remarks = read(drawn(tmp_path / "twice.dxf", lines), tolerance="2 mm")
    assert found == 2
    assert any("ends of lines up to" in remark and "apart taken to meet" in remark for remark in remarks)


@pytest.mark.parametrize("tolerance", ["1 mm", "2 mm", "5 mm", "20 mm"])
def test_a_head_joint_drawn_twice_is_named_as_the_sliver_it_is(tmp_path, tolerance):
    """It lies on both stones by 0.2 mm, which is less than any of the tolerances: none of them helps."""
    boxes = [between(400 * k, 0, 400 * k + 400, 300) for k in range(4)]
    path = drawn(tmp_path / "sliver.dxf", outlines=[*boxes, between(799.8, 0, 800.2, 300)])
    said = rf"block \d at \(0.8, 0.15\) m: is a sliver 0.4 mm wide, thinner than the {tolerance} over which gaps and .*"
    with pytest.raises(CaseError, match=said + "a joint drawn twice") as refused:
        read(path, tolerance=tolerance)
    assert "--tolerance" not in refused.value.remedy
    assert "lie on one another" not in refused.value.problem


def test_a_pinning_stone_thinner_than_the_mortar_around_it_is_named_and_not_taken_for_an_overlap(tmp_path):
    """Stones drawn 5 mm apart, between two of them a wedge 4.5 mm thick; less mortar leaves it a stone."""
    below = [(1343, 1797.5), (1202.5, 1754.2), (1202.5, 1502.5), (1597.5, 1502.5), (1597.5, 1797.5)]
    above = [(1649.1, 2006.1), (1350.9, 2006.1), (1379.9, 1813.3), (1620.1, 1813.3)]
    wedge = [(1397.5, 1808.3), (1378.2, 1808.3), (1359.2, 1802.5), (1397.5, 1802.5)]
    beside = [(1640.8, 1802.5), (1621.8, 1808.3), (1402.5, 1808.3), (1402.5, 1802.5)]
    path = drawn(tmp_path / "pinning.dxf", outlines=[below, above, wedge, beside])
    with pytest.raises(
        CaseError, match=r"block 2 at \(1.383, 1.805\) m: is 4.5 mm wide, thinner than the 9 mm"
    ) as refused:
        read(path, mortar="6 mm")
    assert "unite it with a neighbour, or lower --tolerance or --mortar" in refused.value.remedy
    assert read(path, mortar="4 mm")[0] == 4


def test_thin_stones_side_by_side_are_no_copies(tmp_path):
    slates = [between(0, 8 * k, 600, 8 * k + 8) for k in range(4)]
    found, remarks = read(drawn(tmp_path / "slates.dxf", outlines=slates), tolerance="10 mm")
    assert found == 4
    assert not [remark for remark in remarks if "twice" in remark]


def test_a_stone_that_closing_gaps_would_fold_is_named_with_its_place(tmp_path, monkeypatch):
    """No drawing is known any more that does this; what is said must not blame the order of the corners."""

    def folding(polygons, *settings):
        healed, joined = heal(polygons, *settings)
        healed[1] = healed[1][[0, 2, 1, 3]]
        return healed, joined

    monkeypatch.setattr(drawing, "heal", folding)
    said = (
        r"block 1 at \(0.2, 0.15\) m: its polygon crosses or touches itself at \(0.2, 0.15\) m "
        r"where gaps and overlaps up to 1 mm are closed; correct the corners there"
    )
    with pytest.raises(CaseError, match=said):
        read(drawn(tmp_path / "wall.dxf", outlines=[between(0, 0, 400, 300), between(400, 0, 800, 300)]))


@pytest.mark.parametrize("errors", [{}, {"error": 4e-4}, {"gap": 3e-3}])
@pytest.mark.parametrize("family", WALLS)
def test_a_drawing_is_the_same_wall_in_any_unit(tmp_path, family, errors):
    """In mm, cm, m and inches, by the header or as given: corners within 1e-6 m, as nearly parallel lines enlarge
    rounding."""
    options = MATERIAL | {"tolerance": "5 mm"}
    words = {MILLIMETRES: "mm", CENTIMETRES: "cm", METRES: "m", INCHES: "in"}
    walls = [
        import_wall(polylines(tmp_path / "wall.dxf", WALLS[family](), unit=unit, **errors), options | given).wall
        for unit, word in words.items()
        for given in ({}, {"unit": word})
    ]
    for wall in walls[1:]:
        for block, first in zip(wall.blocks, walls[0].blocks, strict=True):
            assert block.fixed == first.fixed
            assert block.polygon == pytest.approx(first.polygon, abs=1e-6)
