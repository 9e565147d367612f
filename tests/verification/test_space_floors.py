"""Floors let into walls in space: closed forms by virtual work, volumes, and what is refused."""

from __future__ import annotations

import json

import numpy as np
import pytest

from orchestrator.app import cli
from orchestrator.basis.errors import CaseError
from orchestrator.geometry.polyhedra import box
from orchestrator.settings.space_case import read
from orchestrator.space.analysis import SpaceLimitSettings, analyse
from orchestrator.space.contacts import find_joints
from orchestrator.space.floors import Floor, with_floors
from orchestrator.space.generators.shapes import Plan, Stones, u_wall
from orchestrator.space.loads import SpaceLoadSettings, loads_on
from orchestrator.space.wall import check_wall
from tests.support.space_walls import GROUND, block_file_of, wall_of

T, H, SPAN, SLAB = 0.3, 3.0, 4.0, 0.2


def two_walls(bearing: float, unit_weight: float):
    """Two walls, 0 to t and L to L + t, under a slab that bears on the inner part of both."""
    walls = [box((0.0, 0.0, 0.0), (1.0, T, H)), box((0.0, SPAN, 0.0), (1.0, SPAN + T, H))]
    floor = Floor(H, SLAB, (0.0, T - bearing), (1.0, SPAN + bearing), unit_weight)
    return with_floors(wall_of([box((-1.0, -1.0, -0.5), (2.0, 6.0, 0.0)), *walls], 2.0), (floor,))


@pytest.mark.parametrize("bearing", [T, 0.1])
def test_two_walls_that_carry_a_slab_turn_together(bearing):
    """Walls turn about their toes, the slab rides on the heel side of its bearings: it is lifted by b on one wall and
    by t on the other where they move by H. For b = t: t / H, whatever the slab weighs."""
    wall = two_walls(bearing, 25e3)
    check_wall(wall)
    weights = wall.weights
    assert weights[3] == pytest.approx(25e3 * SLAB * (SPAN + 2 * bearing - T))
    walls, load = weights[1] + weights[2], weights[3]
    first, last = T - bearing, SPAN
    tilt = (T - bearing) / (last - first)
    lifted = bearing + tilt * (0.5 * (SPAN + T) - first)
    expected = (0.5 * walls * T + load * lifted) / (0.5 * walls * H + load * (H - 0.5 * SLAB * tilt))
    if bearing == T:
        assert expected == pytest.approx(T / H)
    loads = loads_on(wall, SpaceLoadSettings(direction="+y"))
    found = analyse(find_joints(wall), loads, SpaceLimitSettings(states="headline"))
    assert found.associative.load_multiplier == pytest.approx(expected, rel=1e-5)
    assert found.headline.load_multiplier == pytest.approx(expected, rel=1e-4)


def test_stones_are_cut_where_a_floor_is_let_in():
    wall = u_wall(Plan(4, 2, 6), Stones())
    floor = Floor(0.3, 0.1, (0.05, 0.05), (0.75, 0.4), 25e3)
    floored = with_floors(wall, (floor,))
    check_wall(floored)  # overlaps would be refused
    volume = floored.weights[~floored.fixed].sum() - floored.weights[-1]
    shared = 0.7 * 0.05 + 2 * 0.05 * 0.3  # a half of the facade's thickness, a half of both returns'
    assert volume == pytest.approx(wall.weights[~wall.fixed].sum() - 20e3 * 0.1 * shared)
    assert len({block.id for block in floored.blocks}) == len(floored.blocks)
    joints = find_joints(floored).joints
    slab = len(floored.blocks) - 1
    touching = (joints.i == slab) | (joints.j == slab)
    below = np.abs(joints.normal[touching] @ floored.up) > 0.99
    assert joints.area[touching][below].sum() == pytest.approx(2 * shared)  # what is under it, and what is on it


def test_a_floor_that_cuts_half_a_course_is_refused():
    wall = u_wall(Plan(4, 2, 6), Stones())
    with pytest.raises(CaseError, match=r"wall.floors.0: cuts into block \d+, .*; put its level at a bed joint"):
        with_floors(wall, (Floor(0.25, 0.1, (0.0, 0.0), (0.8, 0.4)),))
    with pytest.raises(CaseError, match=r"wall.floors.0: cuts into a support"):
        with_floors(wall_of([GROUND], 0.6), (Floor(-0.5, 0.1, (0.0, 0.0), (0.8, 0.4)),))
    with pytest.raises(CaseError, match=r"wall.floors.0.end: its two corners make no rectangle"):
        with_floors(wall, (Floor(0.3, 0.1, (0.0, 0.0), (0.0, 0.4)),))


def test_floors_of_a_case_file(tmp_path, capsys):
    case = tmp_path / "floor.toml"
    case.write_text(
        '[wall]\ngenerator = "u"\ncourses = 6\n[[wall.floors]]\nlevel = "600 mm"\nthickness = 0.1\nstart = [0, 0]\n'
        'end = [0.8, 0.5]\nunit_weight = "25 kN/m3"\n[load]\ndirection = "-y"\n'
    )
    assert cli.main(["check", str(case), "--output", str(tmp_path)]) == 0
    assert "nothing to complain about" in capsys.readouterr().out
    case.write_text(case.read_text().replace("600 mm", "550 mm"))
    assert cli.main(["check", str(case), "--output", str(tmp_path)]) == 2
    assert "wall.floors.0: cuts into block" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("start", "end", "shared"),
    [
        ("[0.0, 0.2]", "[1.2, 2.0]", 1.2 * 0.2),
        ("[-0.1, 0.2]", "[1.3, 0.6]", 1.2 * 0.2),
        ("[0.0, 0.2]", "[1.1, 0.6]", 1.1 * 0.2),
        ("[0.2, 0.1]", "[0.6, 2.0]", 0.4 * 0.3),
    ],
)
def test_a_floor_may_end_where_a_stone_ends(tmp_path, capsys, start, end, shared):
    """Stones of 0.4 m, whose ends are off by rounding: what is left weighs the wall less what the floor shares with it,
    1.2 x 0.4 x 1.2 m less `shared` x 0.2 m."""
    stones = 'facade = 3\ncourses = 6\nlength = "400 mm"\nthickness = "400 mm"\nheight = "200 mm"\n'
    floor = f'[[wall.floors]]\nlevel = "600 mm"\nthickness = "200 mm"\nstart = {start}\nend = {end}\n'
    case = tmp_path / "floor.toml"
    case.write_text(
        f'[wall]\ngenerator = "straight"\n{stones}{floor}unit_weight = "1 kN/m3"\n[load]\ndirection = "+y"\n'
    )
    assert cli.main(["check", str(case), "--output", str(tmp_path / "out")]) == 0
    capsys.readouterr()
    wall = read(case).wall
    left = wall.weights[~wall.fixed].sum() - wall.weights[-1]
    assert left == pytest.approx(20e3 * (1.2 * 0.4 * 1.2 - 0.2 * shared), rel=1e-8)


def test_a_floor_inside_one_stone_is_refused():
    wall = u_wall(Plan(4, 2, 6), Stones())
    with pytest.raises(CaseError, match=r"wall.floors.0: lies inside block \d+, which it would leave with a hole; let"):
        with_floors(wall, (Floor(0.2, 0.1, (0.25, 0.02), (0.35, 0.08)),))


def test_a_floor_that_is_dragged_off_its_pier_slides(tmp_path, capsys):
    """A wall of 20 kN turns about its toe and drags a floor of 10.4 kN, which rests on its heel and, by its end, on a
    pier that stands still. What rests on the wall presses it by N = (5.6333 + 0.4333 lambda) kN: about the toe
    25 lambda + 2.5 (10.4 lambda - 0.4 (10.4 - N)) = 4 + 0.4 N."""
    wall, pier = box((0.0, 0.0, 0.0), (1.0, 0.4, 2.5)), box((0.0, 2.6, 0.0), (1.0, 3.0, 2.5))
    shapes = [GROUND, wall, box((0.0, 0.2, 2.5), (1.0, 2.8, 2.7)), pier]
    record = block_file_of(shapes, 0.4)
    record["blocks"][3]["fixed"] = True
    (tmp_path / "wall.json").write_text(json.dumps(record))
    output = ["--output", str(tmp_path / "out")]
    assert cli.main(["limit", str(tmp_path / "wall.json"), "--set", "load.direction=-y", *output]) == 0
    assert "joints: 2 hinge, 0 open, 1 slide, 0 twist\n" in capsys.readouterr().out
    found = json.loads((tmp_path / "out" / "limit_analysis.json").read_text())["non_associative"]
    resting = 10.4 / 2.4 * (1.3 + 0.1 * found)
    assert 25 * found + 2.5 * (10.4 * found - 0.4 * (10.4 - resting)) == pytest.approx(4 + 0.4 * resting, rel=1e-5)
