"""Walls that should not be, or hardly: each runs, or is refused in one line with the reason. None crashes.

A wall runs when its micro-FE (every stone, all contacts) carries its weight and takes its first load increments. Where
no list of joints or no analysis can be right, the refusal is part of the list.
"""

from __future__ import annotations

import json

import pytest

from orchestrator import one_body_per_block, push
from orchestrator.app import cli, driver
from orchestrator.basis.errors import CaseError
from orchestrator.masonry.sources.drawing import implausible
from orchestrator.settings import case as cases


def box(left, right, bottom, top):
    return [[left, bottom], [right, bottom], [right, top], [left, top]]


GROUND = box(-0.5, 1.5, -0.2, 0)
LOW = [GROUND, box(0, 0.5, 0, 0.2), box(0.5, 1, 0, 0.2)]
BOND = [*LOW, box(0, 0.25, 0.2, 0.4), box(0.25, 0.75, 0.2, 0.4), box(0.75, 1, 0.2, 0.4)]
NEEDLE = [[[0.5, 0], [1, 0], [1, 0.2], [0.502, 0.2]], [[0.5, 0], [0.502, 0.2], [0.5, 0.2]]]
RUNS = "runs"


def sliver(width):
    stones = [box(0, 0.5 - width, 0, 0.2), box(0.5 - width, 0.5, 0, 0.2), box(0.5, 1, 0, 0.2)]
    return {"blocks": [GROUND, *stones, *BOND[3:]]}


def near_joints(distance):
    """Head joints of two courses that are off by `distance`."""
    return {"blocks": [*LOW, box(0, 0.5 + distance, 0.2, 0.4), box(0.5 + distance, 1, 0.2, 0.4)]}


WALLS = {
    "as it should be": ({}, RUNS),
    "sliver of 2 mm": (sliver(2e-3), RUNS),
    "sliver of 0.1 mm": (sliver(1e-4), RUNS),
    "sliver of 10 um": (sliver(1e-5), "block 2: its polygon is thinner than"),
    "needle": ({"blocks": [GROUND, LOW[1], *NEEDLE, *BOND[3:]]}, RUNS),
    "head joints off by 2 mm": (near_joints(2e-3), RUNS),
    "head joints off by 0.5 mm": (near_joints(5e-4), RUNS),
    "head joints off by 21 um": (near_joints(2.1e-5), RUNS),
    "head joints off by 10 um": (near_joints(1e-5), RUNS),
    "a corner drawn twice, 0.1 um apart": (
        {"blocks": [GROUND, [[0, 0], [0.5, 0], [0.5, 1e-7], [0.5, 0.2], [0, 0.2]], LOW[2]]},
        RUNS,
    ),
    "a head joint open by 1 mm": ({"blocks": [GROUND, box(0, 0.499, 0, 0.2), LOW[2], box(0, 1, 0.2, 0.4)]}, RUNS),
    "touching in a point, held elsewhere": ({"blocks": [*LOW, box(0, 0.5, 0.2, 0.4)]}, RUNS),
    "touching in a point only": ({"blocks": [*LOW[:2], box(0.5, 1, 0.2, 0.4)]}, "block 2: touches no other block"),
    "standing on an edge": (
        {"blocks": [GROUND, [[0.3, 0.2], [0.5, 0], [0.7, 0.2]], box(0.2, 0.8, 0.2, 0.4)]},
        "block 1: is not connected to any support",
    ),
    "lintel of 1 : 100": ({"blocks": [GROUND, box(0, 0.1, 0, 0.2), box(0.9, 1, 0, 0.2), box(0, 1, 0.2, 0.21)]}, RUNS),
    "needle of stone, 100 : 1": ({"blocks": [GROUND, box(0.5, 0.51, 0, 1)]}, RUNS),
    "leaf of 100 : 1 beside a wall": ({"blocks": [GROUND, box(0, 0.01, 0, 1), box(0.01, 0.5, 0, 1)]}, RUNS),
    "friction 0.01": ({"friction": 0.01}, RUNS),
    "friction 0.1": ({"friction": 0.1}, RUNS),
    "friction 2": ({"friction": 2.0}, RUNS),
    "friction 5": ({"friction": 5.0}, RUNS),
    "1 mm thick": ({"thickness": 1e-3}, RUNS),
    "10 m thick": ({"thickness": 10.0}, RUNS),
    "UTM coordinates": ({"offset": (500_000, 4_500_000)}, RUNS),
    "farther than the earth is round": ({"offset": (1e8, 1e8)}, "subtract a common offset"),
    "metres read as millimetres": ({"scale": 1e-3, "thickness": 3e-4}, RUNS),
}


def read(folder, blocks=BOND, thickness=0.3, friction=0.6, offset=(0, 0), scale=1.0, mesh=0.2):
    """Return the case of a wall whose coordinates are moved and scaled; only its first increments are asked for."""
    outlines = [[[scale * x + offset[0], scale * y + offset[1]] for x, y in polygon] for polygon in blocks]
    record = {
        "name": "ill-posed",
        "units": {"length": "m", "unit_weight": "kN/m3"},
        "thickness": thickness,
        "unit_weight": 20.0,
        "friction": friction,
        "blocks": [{"id": k, "polygon": p, "fixed": k == 0} for k, p in enumerate(outlines)],
    }
    (folder / "wall.json").write_text(json.dumps(record))
    settings = ["run.models=['micro']", "stepping.largest_increments=10", f"mesh.size={mesh}m"]
    return cases.read(folder / "wall.json", settings)


@pytest.mark.parametrize("name", WALLS)
def test_runs_or_is_refused_with_the_reason(name, tmp_path):
    given, expected = WALLS[name]
    if expected != RUNS:
        with pytest.raises(CaseError, match=expected) as caught:
            driver.run(read(tmp_path, **given), tmp_path / "run", False, None, lambda event: None)
        assert len(str(caught.value).splitlines()) == 1
        return
    case = read(tmp_path, **given)
    found = driver.segment(case)
    every_block = one_body_per_block(found.assemblage)
    pushover = push(
        found.assemblage, found.analysis, every_block, case.load, mesh=case.mesh, stepping=case.stepping
    ).summary
    assert pushover.bodies == sum(not block.fixed for block in found.assemblage.wall.blocks)
    assert pushover.steps > 5
    assert pushover.max_penetration_over_size < 5e-3
    assert pushover.peak_multiplier > 0.0


@pytest.mark.parametrize(("width", "warned"), [(2e-3, False), (1e-3, True), (1e-4, True)])
def test_a_sliver_is_warned_about_before_its_pushover(width, warned, tmp_path):
    """Slivers of 1, 0.5 and 0.1 mm have the right peak (friction), then fall out: their curves are not valid."""
    said = implausible(driver.check(read(tmp_path, **sliver(width))).wall)
    assert [text.split(" is ")[0] for text in said] == ["WARNING: block 2"] * warned


def test_coordinates_far_from_the_origin_change_nothing(tmp_path):
    """UTM coordinates are 1e-9 m coarse: the multiplier is that of the wall at the origin to 1e-7."""
    here, there = (driver.limit(read(tmp_path, offset=at))[1] for at in ((0, 0), (500_000, 4_500_000)))
    assert there.associative.load_multiplier == pytest.approx(here.associative.load_multiplier, rel=1e-7)
    assert there.headline.load_multiplier == pytest.approx(here.headline.load_multiplier, rel=1e-6)


def test_a_wall_of_two_centimetres_is_warned_about_and_runs(tmp_path):
    texts = []
    case = read(tmp_path, scale=0.01, thickness=0.003, mesh=0.002)
    (pushover,) = driver.run(case, tmp_path / "run", False, None, lambda event: texts.append(event)).summary.pushover
    assert pushover.peak_multiplier > 0.0
    assert any("is the unit right?" in getattr(event, "text", "") for event in texts)


def test_millimetres_read_as_metres_are_refused_before_the_pushover(tmp_path, capsys):
    """A wall of 2 km; limit analysis, which knows no size, has its multiplier and points the size out."""
    read(tmp_path, scale=1000.0)
    command = [str(tmp_path / "wall.json"), "--output", str(tmp_path / "run")]
    for pushover in ("run", "study"):
        assert cli.main([pushover, *command]) == 2
        printed = capsys.readouterr()
        assert all(line.startswith("micro-LA: ") for line in printed.out.splitlines())
        (line,) = printed.err.splitlines()
        assert "wall.json: units.length: the wall measures 2000 m" in line
        assert not (tmp_path / "run" / "summary.json").exists()
    assert cli.main(["limit", *command]) == 0
