"""Loads on blocks: stretches on tops that are parts or slopes, places and settings that are refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from orchestrator.basis.errors import CaseError
from orchestrator.loads import DeadLoad, LiveLoad, LoadSettings, loads_on
from orchestrator.loads.block_loads import height_of_live_load
from orchestrator.masonry.block_properties import block_centroids
from tests.support.limit_analysis_cases import FLOOR, assemblage_of, box, tower


def test_a_stretch_lies_on_the_parts_of_the_tops_it_covers():
    """Four blocks of 0.5 m side by side at one level; q from 0.3 to 1.2 m lies on 0.2, 0.5 and 0.2 m of three."""
    stones = [box(0.5 * k, 0.0, 0.5, 1.0) for k in range(4)]
    wall, q = assemblage_of([FLOOR, *stones]).wall, 3e3
    load = DeadLoad(level=1.0, line_load=q, stretch=(0.3, 1.2))
    extra = loads_on(wall, LoadSettings(dead=(load,))).dead - loads_on(wall).dead
    assert extra[:, 1] == pytest.approx([0.0, -q * 0.2, -q * 0.5, -q * 0.2, 0.0], abs=1e-9)
    arms = [0.0, 0.4 - 0.25, 0.0, 1.1 - 1.25, 0.0]
    assert extra[:, 2] == pytest.approx(np.array(arms) * extra[:, 1], abs=1e-9)
    total = loads_on(wall, LoadSettings(dead=(replace(load, stretch=()),))).dead - loads_on(wall).dead
    assert total[1:, 1] == pytest.approx([-q * 0.5] * 4)


def test_a_stretch_on_a_slope_goes_by_its_horizontal_width():
    """A gable from (0, 1) up to (1, 2) and down to (2, 1): q from 0.5 to 2 m, resultants q 0.5 at 0.75, q at 1.5 m."""
    gable = np.array([[0, 0], [2, 0], [2, 1], [1, 2], [0, 1]], dtype=float)
    wall, q = assemblage_of([FLOOR, gable]).wall, 2e3
    loads = LoadSettings(dead=(DeadLoad((1,), line_load=q, stretch=(0.5, 2.0)),))
    extra = (loads_on(wall, loads).dead - loads_on(wall).dead)[1]
    assert extra == pytest.approx([0.0, -1.5 * q, -q * (0.5 * 0.75 + 1.0 * 1.5 - 1.5 * 1.0)])


def test_moments_on_a_turned_block_are_those_of_a_wall_that_is_drawn_so():
    """A stone and the place of a floor on it, drawn turned by a right angle: y up becomes -x."""
    stone, place = np.array(box(0.0, 0.0, 0.5, 1.0)), np.array([0.4, 0.9])
    quarter = np.array([[0.0, 1.0], [-1.0, 0.0]])  # of rows

    def loads(turned):
        outline, at = (turned(one) for one in (stone, place))
        floor = DeadLoad((1,), force=3e3, at=tuple(at.tolist()), inertia=True)
        return loads_on(assemblage_of([FLOOR, outline]).wall, LoadSettings(inclination=0.3, dead=(floor,)))

    drawn, lies = loads(lambda point: point), loads(lambda point: point @ quarter + [1.0, 0.0])
    assert np.abs(drawn.turned[1]).min() > 100.0
    assert drawn.turned[1] == pytest.approx([lies.dead[1, 2], lies.live[1, 2]])
    assert lies.turned[1] == pytest.approx([-drawn.dead[1, 2], -drawn.live[1, 2]]), "half a turn in all"
    alone = drawn.of_blocks(np.array([False, True]))
    assert alone.turned.tolist() == [drawn.turned[1].tolist()]
    assert not loads_on(assemblage_of([FLOOR, stone]).wall).turned.any(), "weights act at centroids"


def test_the_resultant_of_a_live_load_is_at_the_mean_height_of_its_forces():
    """A stone of W = 2 F under a floor F: 1 m high, forces at 0.5 and 1 m; by mass x height W/2 and F are alike."""
    wall = assemblage_of([FLOOR, box(0.0, 0.0, 0.5, 1.0)]).wall
    weight = -loads_on(wall).dead[1, 1]
    load = LoadSettings(dead=(DeadLoad((1,), line_load=weight, inertia=True),))  # per metre, over half a metre
    assert height_of_live_load(wall, LoadSettings()) == pytest.approx(0.5)
    assert height_of_live_load(wall, load) == pytest.approx((2 * 0.5 + 1.0) / 3)
    assert height_of_live_load(wall, replace(load, distribution="mass_height")) == pytest.approx(0.75)
    given = LoadSettings(distribution="per_block", live=(LiveLoad((1,), 1e3),))
    assert height_of_live_load(wall, given) == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("load", "key"),
    [
        (DeadLoad((1,), force=1.0, stretch=(0.0, 1.0)), "stretch"),
        (DeadLoad((1,), line_load=1.0, stretch=(1.0, 0.0)), "stretch"),
        (DeadLoad((1,), line_load=1.0, stretch=(0.1,)), "stretch"),
        (DeadLoad((1,), line_load=1.0, stretch=(5.0, 6.0)), "stretch"),
        (DeadLoad((1,), line_load=1.0, stretch=(0.1, 0.6)), "stretch"),
        (DeadLoad((1,), line_load=1.0, at=(0.0, 0.5)), "at"),
        (DeadLoad((1,), force=1.0, at=(0.0,)), "at"),
        (DeadLoad((1, 2), force=1.0, at=(0.0, 0.5)), "at"),
        (DeadLoad(level=2.0, force=1.0, at=(0.0, 0.5)), "at"),
        (DeadLoad((1,), force=1.0, at=(0.0, 1.001)), "at"),
    ],
)
def test_places_that_are_none_are_refused(load, key):
    with pytest.raises(CaseError) as refused:
        loads_on(tower(0.5, 1.0, blocks=2).wall, LoadSettings(dead=(load,)))
    assert refused.value.key == f"load.dead.0.{key}"


def given(*forces):
    """Return forces on block 1, one after the other, as a live load."""
    return LoadSettings(distribution="per_block", live=tuple(LiveLoad((1,), force) for force in forces))


@pytest.mark.parametrize(
    ("settings", "complaint"),
    [
        (LoadSettings(dead=(DeadLoad((7,), force=1.0),)), r"load\.dead\.0\.blocks: there is no block 7"),
        (LoadSettings(dead=(DeadLoad((0,), force=1.0),)), r"load\.dead\.0\.blocks: block 0 is a support"),
        (LoadSettings(dead=(DeadLoad((1,)),)), r"load\.dead\.0: needs one of force and line_load"),
        (LoadSettings(dead=(DeadLoad((1,), 1.0, 1.0),)), r"load\.dead\.0: needs one of force and line_load"),
        (
            LoadSettings(dead=(DeadLoad(level=0.7, force=1.0),)),
            r"load\.dead\.0\.level: no block .* 0\.7 m; tops are at 1 m",
        ),
        (LoadSettings(dead=(DeadLoad((1,), force=1.0, level=1.0),)), r"load\.dead\.0: needs one of level and blocks"),
        (LoadSettings(dead=(DeadLoad(force=1.0),)), r"load\.dead\.0: needs one of level and blocks"),
        (LoadSettings(distribution="per_block"), r"load\.live: 0 given"),
        (LoadSettings(live=(LiveLoad((1,), 1.0),)), r"load\.live: 1 given"),
        (given(1e3, 0.0), r"load\.live\.1\.force: is zero"),
        (given(1e3, -1e3), r"load\.live: .* add up to 0 kN of 2 kN .* at least 10% of their sizes"),
        (given(1e3, -2e3), r"load\.live: .* add up to -1 kN of 3 kN"),
    ],
)
def test_loads_that_cannot_be(settings, complaint):
    with pytest.raises(CaseError, match=complaint):
        loads_on(tower(1.0, 1.0).wall, settings)


STEPPED = np.array([[0.8, 0.6], [1.6, 0.6], [1.6, 0.9], [1.4, 0.9], [1.4, 1.0], [0.8, 1.0]])
"""a stone with a step in its top: 0.6 m at y = 1, 0.2 m at y = 0.9"""


@pytest.mark.parametrize(
    ("level", "stretch", "expected"),
    [
        (1.0, (), {1: (0.8, 0.4), 3: (0.6, 1.1)}),
        (0.9, (), {3: (0.2, 1.5)}),
        (1.0, (0.6, 1.0), {1: (0.2, 0.7), 3: (0.2, 0.9)}),
        (0.9, (1.5, 1.6), {3: (0.1, 1.55)}),
    ],
)
def test_a_floor_lies_on_the_parts_of_a_stepped_top_that_are_at_its_level(level, stretch, expected):
    """Width and x of the middle of what it lies on, by hand; nothing on the other step, nor on the stone below."""
    stones = [box(0.0, 0.0, 0.8, 1.0), box(0.8, 0.0, 0.8, 0.6), STEPPED]
    wall, q = assemblage_of([FLOOR, *stones]).wall, 5e3
    load = LoadSettings(dead=(DeadLoad(level=level, line_load=q, stretch=stretch, inertia=True),))
    bare, loaded = loads_on(wall), loads_on(wall, load)
    extra = loaded.dead - bare.dead
    assert np.flatnonzero(np.abs(extra[:, 1]) > 1e-9).tolist() == list(expected)
    for block, (width, middle) in expected.items():
        centroid = block_centroids(wall)[block]
        assert extra[block] == pytest.approx([0.0, -q * width, -q * width * (middle - centroid[0])])
        pushed = (loaded.live - bare.live)[block]
        assert pushed == pytest.approx([q * width, 0.0, -q * width * (level - centroid[1])])


@pytest.mark.parametrize(
    ("stone", "tops"),
    [(STEPPED - [0.8, 0.6], "tops are at 0.3, 0.4 m"), (np.array([[0, 0], [2, 0], [1, 1.0]]), "none is level")],
)
def test_a_level_without_a_top_is_refused_with_the_levels_that_there_are(stone, tops):
    wall = assemblage_of([FLOOR, stone]).wall
    with pytest.raises(CaseError) as refused:
        loads_on(wall, LoadSettings(dead=(DeadLoad(level=0.7, line_load=1e3),)))
    assert refused.value.key == "load.dead.0.level"
    assert tops in refused.value.remedy
