"""Loads beyond weight and its horizontal image, against the statics of one and two blocks written out by hand."""

from __future__ import annotations

from dataclasses import replace
from math import cos, radians, sin

import numpy as np
import pytest

from orchestrator import LoadCase, load_cases, one_body_per_block, push
from orchestrator.basis.errors import CaseError
from orchestrator.limit_analysis import analyse
from orchestrator.loads import DeadLoad, LiveLoad, LoadSettings, loads_on
from tests.support.limit_analysis_cases import FLOOR, assemblage_of, box, case, mirrored, tower


def multipliers(assemblage, settings):
    """Associative and sequence multiplier, and that which loading meets of states whose power balances."""
    found = analyse(assemblage, loads=loads_on(assemblage.wall, settings))
    for state in (found.associative, found.sequence, found.headline):
        assert state.equilibrium_residual < 1e-10
        assert state.power_residual < 1e-7
    return [state.load_multiplier for state in (found.associative, found.sequence, found.headline)]


@pytest.mark.parametrize("direction", ["+x", "-x"])
def test_dead_load_without_inertia_holds_a_block_down(direction):
    """Sliding mu (W + F)/W, rocking (b/h) (W + F)/W; a line load on the whole top does what its resultant does."""
    W, F = 20e3 * 0.5, 5e3
    for load in (DeadLoad((1,), force=F), DeadLoad((1,), line_load=F / 0.5)):
        slender = multipliers(tower(0.5, 1.0), LoadSettings(direction, dead=(load,)))
        assert slender == pytest.approx([0.5 * (W + F) / W] * 3, abs=1e-6)
        smooth = multipliers(tower(0.5, 1.0, friction=0.2), LoadSettings(direction, dead=(load,)))
        assert smooth == pytest.approx([0.2 * (W + F) / W] * 3, abs=1e-6)


def test_dead_load_with_inertia_pushes_where_it_stands():
    """Rocking: (W + F) b/2 = lambda (W h/2 + F h) on the top, lambda (W + F) h/2 at the centroid."""
    b, h, F = 0.5, 1.0, 5e3
    W = 20e3 * b * h
    top = multipliers(tower(b, h), LoadSettings(dead=(DeadLoad((1,), line_load=F / b, inertia=True),)))
    assert top == pytest.approx([(W + F) * b / 2 / (W * h / 2 + F * h)] * 3, abs=1e-6)
    centroid = multipliers(tower(b, h), LoadSettings(dead=(DeadLoad((1,), force=F, inertia=True),)))
    assert centroid == pytest.approx([b / h] * 3, abs=1e-6)


@pytest.mark.parametrize("inertia", [False, True])
@pytest.mark.parametrize("kind", ["point", "stretch"])
def test_a_load_beside_the_middle_turns_a_block_about_its_toe(kind, inertia):
    """A block b x h, W, with F on its top at x from its left end, a point load or q over 2e around x; rocking to +x:

    W b/2 + F (b - x) = lambda (W h/2 + F h), the last term with inertia only.
    """
    b, h, F, x, e = 0.5, 1.0, 4e3, 0.125, 0.1
    W, left = 20e3 * b * h, -b / 2
    place = {"force": F, "at": (left + x, h)}
    if kind == "stretch":
        place = {"line_load": F / (2 * e), "stretch": (left + x - e, left + x + e)}
    settings = LoadSettings(dead=(DeadLoad((1,), inertia=inertia, **place),))
    turning = (W * b / 2 + F * (b - x)) / (W * h / 2 + inertia * F * h)
    assert multipliers(tower(b, h, friction=3.0), settings) == pytest.approx([turning] * 3, abs=1e-6)


def test_a_floor_rests_on_the_course_whose_tops_are_at_its_level():
    """Two towers of three blocks; a floor at 2h with inertia: each, b wide, turns about its toe, nothing slides.

    lambda (W 3h/2 + q b 2h) = (W + q b) b/2, with W of three blocks; the levels between and above carry nothing.
    """
    b, h, q = 0.4, 0.5, 3e3
    stones = [box(x, h * level, b, h) for x in (0.0, 1.0) for level in range(3)]
    wall = assemblage_of([FLOOR, *stones], friction=5.0)
    floor = LoadSettings(dead=(DeadLoad(level=2 * h, line_load=q, inertia=True),))
    loads = loads_on(wall.wall, floor)
    extra = loads.dead - loads_on(wall.wall).dead
    assert np.flatnonzero(extra[:, 1]).tolist() == [2, 5]
    assert extra[[2, 5], 1] == pytest.approx(-q * b)
    W = 3 * 20e3 * b * h
    turning = (W + q * b) * b / 2 / (W * 1.5 * h + q * b * 2 * h)
    assert multipliers(wall, floor) == pytest.approx([turning] * 3, abs=1e-6)


def test_line_load_acts_on_the_edges_that_face_upwards_only():
    """A right-angled triangle's hypotenuse is its top: middle at half its width, a third away from the centroid's."""
    triangle = assemblage_of([FLOOR, [(0, 0), (1.2, 0), (0, 0.6)]])
    W, q = 20e3 * 0.36, 1e3
    expected = (W * 0.8 + q * 1.2 * 0.6) / (W * 0.2)  # about the toe at x = 1.2; weight at x = 0.4, y = 0.2
    rough = replace(triangle, joints=replace(triangle.joints, friction=np.array([10.0])))
    found = analyse(rough, loads=loads_on(rough.wall, LoadSettings(dead=(DeadLoad((1,), line_load=q),))))
    assert found.associative.load_multiplier == pytest.approx(expected, rel=1e-8)


def test_mass_times_height():
    """Two blocks: forces 1 : 3 of the resultant at h/2 and 3h/2, at 5h/4: lambda 2 W 5h/4 = 2 W b/2."""
    b, h = 0.5, 0.6
    found = multipliers(tower(b, h, blocks=2), LoadSettings(distribution="mass_height"))
    assert found == pytest.approx([0.4 * b / h] * 3, abs=1e-6)
    loads = loads_on(tower(b, h, blocks=2).wall, LoadSettings(distribution="mass_height"))
    assert loads.live[1:, 0] == pytest.approx(np.array([0.25, 0.75]) * 2 * 20e3 * b * h)


@pytest.mark.parametrize("size", [1.0, 1e3, 1e7])
def test_live_load_per_block(size):
    """A force on the upper of two blocks only: rocking about the base, lambda F 3h/2 = 2 W b/2, whatever its size."""
    b, h = 0.3, 0.6
    W = 20e3 * b * h
    settings = LoadSettings(distribution="per_block", live=(LiveLoad((2,), size),))
    found = multipliers(tower(b, h, blocks=2), settings)
    assert np.array(found) * size == pytest.approx([min(W * b / (1.5 * h), W * b / h)] * 3, rel=1e-6)
    assert analyse(
        tower(b, h, blocks=2), loads=loads_on(tower(b, h, blocks=2).wall, settings)
    ).horizontal_load == pytest.approx(size)


@pytest.mark.parametrize("direction", ["+x", "-x"])
@pytest.mark.parametrize(("lower", "upper"), [(-1e3, 2e3), (2e3, -1e3), (-5e3, 9e3)])
def test_forces_against_the_direction(lower, upper, direction):
    """Either of two blocks turns forwards or backwards about the joint below it: lambda |M| = N b/2."""
    b, h = 0.3, 0.75
    W = 20e3 * b * h
    live = (LiveLoad((1,), lower), LiveLoad((2,), upper))
    wall = tower(b, h, blocks=2, friction=5.0)
    settings = LoadSettings(direction, distribution="per_block", live=live)
    moments = abs(lower * h / 2 + upper * 3 * h / 2), abs(upper * h / 2)
    expected = min(2 * W * b / 2 / moments[0], W * b / 2 / moments[1])
    assert multipliers(wall, settings) == pytest.approx([expected] * 3, rel=1e-6)
    assert analyse(wall, loads=loads_on(wall.wall, settings)).horizontal_load == pytest.approx(lower + upper)


@pytest.mark.parametrize("direction", ["+x", "-x"])
@pytest.mark.parametrize("angle", [-30, 20, 60])
def test_inclined_live_load_on_a_sliding_block(angle, direction):
    """lambda cos a = mu (1 - lambda sin a)."""
    a, mu = radians(angle), 0.3
    found = multipliers(tower(2.0, 0.5, friction=mu), LoadSettings(direction, a))
    assert found == pytest.approx([mu / (cos(a) + mu * sin(a))] * 3, abs=1e-6)


def test_live_load_that_points_up_lifts_the_wall_at_one():
    found = analyse(tower(1.0, 1.0), loads=loads_on(tower(1.0, 1.0).wall, LoadSettings(inclination=radians(90))))
    assert found.associative.load_multiplier == pytest.approx(1.0, abs=1e-8)
    assert found.horizontal_load == pytest.approx(0.0, abs=1e-8)


def test_mirror_image_of_an_unsymmetrically_loaded_wall():
    wall = case("ferris_tinloi_wall3")
    settings = LoadSettings(
        inclination=radians(10),
        distribution="mass_height",
        dead=(DeadLoad((wall.wall.blocks[-1].id,), line_load=2e3, inertia=True), DeadLoad((5, 6), force=300.0)),
    )
    image = replace(settings, direction="-x")
    plain = analyse(wall, loads=loads_on(wall.wall, settings)).associative.load_multiplier
    other = mirrored(wall)
    image = analyse(other, loads=loads_on(other.wall, image)).associative.load_multiplier
    assert image == pytest.approx(plain, abs=1e-8)
    assert abs(plain - analyse(wall).associative.load_multiplier) > 1e-3


CASES = (LoadCase("left", "-x", dead=(DeadLoad((1,), force=5e3),)), LoadCase("right", "+x"))


@pytest.mark.parametrize(
    ("load", "key", "multipliers_of"),
    [
        (LoadSettings(envelope=True), "load.envelope", [0.5, 0.5, 0.5, 0.5]),
        (LoadSettings(cases=CASES), "load.cases", [0.75, 0.5]),
    ],
)
def test_from_python_load_cases_are_taken_one_by_one_and_never_left_out(load, key, multipliers_of):
    """A block of 10 kN, b/h = 1/2: (b/h)(W + F)/W. All at once would silently be [load] alone."""
    assemblage = tower(0.5, 1.0)
    analysis, stones = analyse(assemblage), one_body_per_block(assemblage)
    for refusing in (lambda: loads_on(assemblage.wall, load), lambda: push(assemblage, analysis, stones, load)):
        with pytest.raises(CaseError) as refused:
            refusing()
        assert refused.value.key == key
        assert "load_cases(load)" in refused.value.remedy
    found = [multipliers(assemblage, one)[-1] for one in load_cases(load).values()]
    assert found == pytest.approx(multipliers_of, abs=1e-6)
