"""Depth of overlaps against closed forms: a face, a corner and a wedge pressed in, slivers, bars that cross."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from orchestrator.geometry.penetration import penetrations

FLOOR = [(-2.0, -1.0), (2.0, -1.0), (2.0, 0.0), (-2.0, 0.0)]


def deepest(*outlines, free=None):
    shapes = np.array([shapely.Polygon(outline) for outline in outlines], dtype=object)
    free = np.ones(len(shapes), bool) if free is None else np.array(free)
    found = penetrations(shapes, free, float(np.abs(shapely.total_bounds(shapes)).max()))
    if not len(found.depth):
        return 0.0, None, None
    worst = int(np.argmax(found.depth))
    return float(found.depth[worst]), tuple(found.pair[worst].tolist()), found.place[worst]


def box(x, y, width, height):
    return [(x, y), (x + width, y), (x + width, y + height), (x, y + height)]


@pytest.mark.parametrize("depth", [1e-6, 1e-3, 0.02])
@pytest.mark.parametrize("width", [0.1, 3.0])
def test_a_face_pressed_in_lies_as_deep_as_it_was_pressed(depth, width):
    assert deepest(FLOOR, box(-width / 2, -depth, width, 0.5))[0] == pytest.approx(depth, rel=1e-9)


@pytest.mark.parametrize("half", [15.0, 45.0, 70.0], ids=lambda angle: f"{2 * angle:g} degrees")
@pytest.mark.parametrize("depth", [1e-4, 0.02])
def test_a_wedge_pressed_in_lies_as_deep_as_its_tip(half, depth):
    """However sharp: sideways the floor does not let it out."""
    side = 0.3 * np.tan(np.radians(half))
    found, pair, place = deepest(FLOOR, [(0.2, -depth), (0.2 + side, 0.3 - depth), (0.2 - side, 0.3 - depth)])
    assert found == pytest.approx(depth, rel=1e-9)
    assert pair == (0, 1)
    assert place == pytest.approx([0.2, -depth])


def step_with_a_ramp(sunk):
    """A bed with a ramp of 45 degrees behind it, and a box that has slid `sunk` into the ramp along the bed."""
    ground = [(-2.0, -1.0), (2.0, -1.0), (2.0, 1.0), (1.0, 0.0), (-2.0, 0.0)]
    return ground, box(0.5 + sunk, 0.0, 0.5, 0.5)


@pytest.mark.parametrize("sunk", [1e-3, 0.02])
def test_a_corner_in_a_ramp_is_as_deep_with_a_bed_beside_it(sunk):
    """What the two share is a triangle and the whole bed, a line: the line takes nothing from the depth."""
    assert deepest(*step_with_a_ramp(sunk))[0] == pytest.approx(sunk / np.sqrt(2.0), rel=1e-9)


@pytest.mark.parametrize("bed", [1e-9, 1e-4])
def test_face_and_corner_at_once_are_as_deep_as_the_deeper(bed):
    ground, stone = step_with_a_ramp(0.02)
    lowered = [(x, y - bed) for x, y in stone]
    assert deepest(ground, lowered)[0] == pytest.approx((0.02 + bed) / np.sqrt(2.0), rel=1e-9)


def test_a_sliver_along_a_stepped_bed_is_as_deep_as_it_is_thick():
    """Along a tread and a riser it is as deep as the way out, along their bisector."""
    steps = [(-1.0, -1.0), (1.0, -1.0), (1.0, 0.5), (0.0, 0.5), (0.0, 0.0), (-1.0, 0.0)]
    assert deepest(steps, [(-0.8, -1e-3), (1e-3, -1e-3), (1e-3, 0.4), (-0.8, 0.4)])[0] == pytest.approx(
        np.sqrt(2.0) * 1e-3, rel=1e-9
    )


def test_bars_that_cross_are_found_without_a_corner_in_each_other():
    assert deepest(box(-1.0, 0.0, 2.0, 0.1), box(-0.05, -1.0, 0.1, 2.0))[0] == pytest.approx(0.05, rel=1e-9)


@pytest.mark.parametrize("away", [0.0, 4567.3, 512345.0])
def test_rounding_is_no_depth(away):
    turn = np.exp(1j * np.radians(np.arange(0.0, 90.0, 7.0)))
    for rotation in turn:
        turned = [
            [(point.real, point.imag) for point in away + rotation * np.array([complex(*corner) for corner in outline])]
            for outline in (FLOOR, box(-1.3, 0.0, 0.7, 0.4), box(-0.6, 0.0, 0.9, 0.4))
        ]
        assert deepest(*turned)[0] < max(1e-11, 16.0 * np.spacing(away))


def test_a_place_on_an_axis_has_no_sign():
    place = deepest(box(-2.0, -1.0, 4.0, 1.02), [(0.2, -1e-18), (0.5, 0.3), (-0.1, 0.3)])[2]
    assert "{:g}, {:g}".format(*place) == "0.2, 0"


def test_two_supports_may_overlap():
    assert deepest(FLOOR, box(0.0, -0.5, 1.0, 1.0), free=[False, False])[0] == 0.0
    assert deepest(FLOOR, box(0.0, -0.5, 1.0, 1.0), free=[False, True])[0] == pytest.approx(0.5)
