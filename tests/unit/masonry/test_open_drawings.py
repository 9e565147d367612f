"""Drawings whose outlines were left open, and drawings that stand on their heads: what is said of them."""

from __future__ import annotations

import ezdxf
import numpy as np
import pytest

from orchestrator.app.intake import import_wall
from orchestrator.basis.errors import CaseError
from orchestrator.masonry.sources.drawing import HealingSettings, closed
from orchestrator.masonry.wall import Block, Wall
from tests.support.drawings import MILLIMETRES
from tests.support.walls import between

MATERIAL = {"thickness": "0.5 m", "unit_weight": "20 kN/m3", "friction": "0.7"}
GROUND = between(-100, -200, 1700, 0)
BOXES = [between(400 * c, 200 * r, 400 * c + 400, 200 * r + 200) for r in range(3) for c in range(4)]


def saved(path, closed=(), opened=(), ground=GROUND, ground_is_closed=True):
    """Draw outlines (mm) on the layer of the blocks, closed or left open, the ground on that of the supports."""
    document = ezdxf.new()
    document.header["$INSUNITS"] = MILLIMETRES
    drawn = [*((one, True, "blocks") for one in closed), *((one, False, "blocks") for one in opened)]
    for outline, is_closed, layer in [*drawn, (ground, ground_is_closed, "supports")]:
        document.modelspace().add_lwpolyline(outline, close=is_closed, dxfattribs={"layer": layer})
    document.saveas(path)
    return path


def said_of(path, **options):
    """Return the remarks on a drawing that is read, or what it is refused with."""
    try:
        return "; ".join(import_wall(path, MATERIAL | options).remarks)
    except CaseError as refused:
        return str(refused)


@pytest.mark.parametrize("seed", range(12))
def test_outlines_that_were_left_open_are_told_to_be_closed(tmp_path, seed):
    """Its lines miss each other by fractions of a millimetre."""
    errors = np.random.default_rng(seed).uniform(-0.5, 0.5, (12, 4, 2))
    drawing = saved(tmp_path / "open.dxf", opened=np.array(BOXES) + errors)
    assert "polylines are open, the first at" in said_of(drawing)


BATTLEMENTS = [(x + dx, 200 + y) for x in range(0, 1200, 300) for dx, y in ((0, 0), (0, 150), (150, 150), (150, 0))]
HALF_CIRCLE = [(800 - 400 * np.cos(t), 200 + 400 * np.sin(t)) for t in np.linspace(0.0, np.pi, 19)]


@pytest.mark.parametrize(
    "line",
    [[(0, 200), (400, 200), (400, 600), (800, 600), (800, 1000)], BATTLEMENTS, HALF_CIRCLE, [(0, 200), (0, 900)]],
)
def test_lines_that_bend_are_no_outlines_left_open(tmp_path, line):
    """Steps, battlements, an arc and a straight line on closed stones: what is open bounds nothing, and is told."""
    said = said_of(saved(tmp_path / "line.dxf", BOXES[:4], [line]))
    assert "no outline" in said
    assert "if it is an outline" not in said


@pytest.mark.parametrize("sides", [2, 3])
def test_a_stone_of_which_one_side_is_missing_is_told_beside_closed_ones(tmp_path, sides):
    stone = [(0, 200), (300, 500), (-20, 450)] if sides == 2 else [(0, 200), (0, 400), (400, 400), (400, 200)]
    said = said_of(saved(tmp_path / "open.dxf", BOXES[:4], [stone]))
    assert "1 polyline is open, which begins at (0, 0.2) m: if it is an outline" in said


def test_of_an_outline_that_crosses_itself_no_overlap_is_looked_for():
    """GEOS has no common area of it and the stone beside it: there was a traceback."""
    random = np.random.default_rng(0)
    crosses = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.5, -1e-4 * random.random()), (0.0, 1.0)]
    beside = np.array([(0.5, -0.5), (1.5, -0.5), (1.5, 0.5), (0.5, 0.5)]) + random.uniform(-0.3, 0.3, (4, 2))
    stones = [Block(k + 1, np.array(outline), k == 1, 20e3) for k, outline in enumerate((crosses, beside))]
    with pytest.raises(CaseError, match=r"its polygon crosses or touches itself at \(0\.5"):
        closed(Wall("", tuple(stones), 0.5, 0.7), HealingSettings())


def test_a_support_that_was_left_open_is_not_told_to_be_drawn_on_its_own_layer(tmp_path):
    said = said_of(saved(tmp_path / "ground.dxf", BOXES, ground_is_closed=False))
    assert "supports: the drawing has none; 1 polyline is open, which begins at (-0.1, -0.2) m: if it is" in said
    assert 'draw each as a closed outline, or give --ground "200 mm"' in said


@pytest.mark.parametrize("turn", [(1.0, -1.0), (-1.0, 1.0)])
def test_a_wall_on_its_head_is_not_taken_for_loose_stones(tmp_path, turn):
    """As drawn with y downwards; or a mirror image, which stands."""
    outlines = [np.array(box) * turn for box in BOXES]
    path = saved(tmp_path / "turned.dxf", outlines, ground=np.array(GROUND) * turn)
    stands = turn[1] > 0.0
    assert ("whether the drawing stands upright" in said_of(path)) is not stands
    dropped = said_of(path, loose="drop")
    assert ("whether the drawing stands upright" in dropped) is not stands
    assert "try --loose drop" not in dropped
