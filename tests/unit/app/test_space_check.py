"""`check` of a wall in space is the first page of a case; `limit` ends with the number that counts."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

from orchestrator.app import cli
from orchestrator.geometry.polyhedra import box
from orchestrator.present.in_space import space_pictures
from orchestrator.present.in_space.raster import drawn, places_of_numbers, view_towards
from orchestrator.space.contacts import find_joints
from tests.support.space_walls import GROUND, block_file_of, record, wall_of

CASE = """
[wall]
blocks = "wall.json"
[load]
direction = [0, -1, 0]
[[load.dead]]
blocks = [1]
force = "2 kN"
inertia = true
"""


@pytest.fixture
def case(tmp_path):
    (tmp_path / "wall.json").write_text(json.dumps(record()))
    path = tmp_path / "case.toml"
    path.write_text(CASE)
    return path


def test_check_sums_up_loads_materials_and_joints(case, tmp_path, capsys):
    """A block of 0.05 m3 and 1 kN, with 2 kN on it that have mass, on a bed of 0.25 m2."""
    assert cli.main(["check", str(case), "--output", str(tmp_path / "out")]) == 0
    lines = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
    expected = [
        "weight of the blocks all 1.000 yes",
        "extra: 2 kN on block 1 1 2.000 yes",
        "all dead load, vertical resultant 3.000",
        "base shear at λ = 1, (0, -1, 0) 3.000",
        "(none) 1 0.05 1.000 20 0.6",
        "block, support 1 0.25 0.6",
        "Joint forces can balance its dead load, and the live load brings it down.",
    ]
    assert [line for line in expected if line not in lines] == []


def test_check_tells_how_far_corners_were_moved(case, tmp_path, capsys):
    """Two corners of the bed 0.1 mm above the ground: the two levels, 0 and 0.1 mm, have 0.025 mm for their mean."""
    wall = record()
    for corner in wall["blocks"][1]["vertices"][:2]:
        corner[2] += 0.1
    case.with_name("wall.json").write_text(json.dumps(wall))
    assert cli.main(["check", str(case), "--output", str(tmp_path / "out")]) == 0
    printed = capsys.readouterr().out
    assert "corners lie up to 0.075 mm off planes that they have in common, and were put there" in printed
    assert "nothing to complain about" in printed


def test_check_tells_what_is_unusual(case, tmp_path, capsys):
    settings = ["--set", "wall.unit_weight=20000 kN/m3", "--set", "wall.friction=35"]
    assert cli.main(["check", str(case), *settings, "--output", str(tmp_path / "out")]) == 0
    printed = capsys.readouterr().out
    assert "UNUSUAL: unit weight 2e+04 kN/m3, usual are 3 to 32 kN/m3; is 20000 N/m3 meant?" in printed
    assert "UNUSUAL: friction of 1 joint 35, usual are 0.2 to 1.5; is an angle of 35 degrees meant?" in printed
    assert "extra dead load" not in printed, "2 of 1,000 kN"
    assert "see the warnings above" in printed


def test_check_refuses_a_wall_that_limit_refuses(tmp_path, capsys):
    """A block that rests on the last 0.2 m of its support: `check` had nothing to complain about."""
    wall = record()
    wall["blocks"][1]["vertices"] = [[x + 1300, y, z] for x, y, z in wall["blocks"][1]["vertices"]]
    path = tmp_path / "wall.json"
    path.write_text(json.dumps(wall))
    said = []
    for command in ("limit", "check"):
        assert cli.main([command, str(path), "--output", str(tmp_path / command)]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        said.append(line)
    assert said[0] == said[1]


def turned_inside_out(wall):
    wall["blocks"][1]["faces"] = [face[::-1] for face in wall["blocks"][1]["faces"]]


def with_a_face_left_out(wall):
    wall["blocks"][1]["faces"].pop()


def with_an_id_twice(wall):
    wall["blocks"][1]["id"] = 0


def with_a_friction_below_0(wall):
    wall["friction"] = -1


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (turned_inside_out, "block 1: its faces run clockwise seen from outside; reverse every face"),
        (with_a_face_left_out, "block 1: is open"),
        (with_an_id_twice, "block 0: two blocks have this id"),
        (with_a_friction_below_0, "friction: -1 is outside 1e-09 to 1e+09; give the tangent of an angle"),
    ],
)
def test_a_fault_in_the_block_file_is_told_by_its_name(case, tmp_path, capsys, spoil, said):
    wall = record()
    spoil(wall)
    (tmp_path / "wall.json").write_text(json.dumps(wall))
    for command in ("check", "limit"):
        assert cli.main([command, str(case), "--output", str(tmp_path / command)]) == 2
        assert capsys.readouterr().err.startswith(f"{tmp_path / 'wall.json'}: {said}")


def test_limit_says_which_number_counts(case, tmp_path, capsys):
    assert cli.main(["limit", str(case), "--output", str(tmp_path / "out")]) == 0
    printed = capsys.readouterr().out
    said = "λ = 0.60000 counts (elastic joints): base shear 1.800 kN, a collapse state with friction that does not "
    assert said + "dilate; it reaches the associative upper bound, and no lower one was found." in printed


UNITS = {"units": {"length": "m", "unit_weight": "kN/m3"}, "unit_weight": 20, "friction": 0.6}
WALLS = {
    "space": block_file_of([GROUND, box((0.0, 0.0, 0.0), (1.0, 0.4, 2.0))]),
    "plane": UNITS | {
        "thickness": 1.0,
        "blocks": [
            {"id": 0, "polygon": [[-5, -1], [5, -1], [5, 0], [-5, 0]], "fixed": True},
            {"id": 1, "polygon": [[0, 0], [0.4, 0], [0.4, 2], [0, 2]]},
        ],
    },
}  # fmt: skip
"""one pier of 16 kN, 0.4 m thick and 2 m high"""
LOADS = {
    "inclined": {"space": "direction = [0, 1, 1]", "plane": 'inclination = "45 deg"'},
    "upright": {"space": 'direction = "+z"', "plane": 'inclination = "90 deg"'},
}


@pytest.fixture(params=["space", "plane"])
def pier(request, tmp_path, capsys):
    """What a command prints of the pier under a load, in space and in the plane."""
    (tmp_path / "wall.json").write_text(json.dumps(WALLS[request.param]))

    def said(command: str, load: str, *more: str) -> str:
        case = tmp_path / "case.toml"
        case.write_text(f'project.language = "it"\nwall.blocks = "wall.json"\n[load]\n{LOADS[load][request.param]}\n')
        output = () if "--json" in more else ("--output", str(tmp_path / "out"))
        assert cli.main([command, str(case), *more, *output]) == 0
        return " ".join(capsys.readouterr().out.split())

    return said


def figures_of(page) -> str:
    """What the page of the collapse says of the load of a wall in space, "" in the plane, where there is none."""
    text = page.read_text(encoding="utf-8") if page.exists() else ""
    return " ".join(re.findall(r"<tr><th>((?:taglio|carico)[^<]*</th><td>[^<]*)</td>", text)).replace("</th><td>", ": ")


def test_the_base_shear_of_an_inclined_load_is_its_horizontal_part(pier, tmp_path):
    """Lifted and pushed at 45 degrees the pier turns about its edge: 16 kN x 0.2 m = V (1 m + 0.2 m)."""
    shear = 16.0 * 0.2 / 1.2
    assert re.search(r"base shear at λ = 1, .* 11\.314 Mat", pier("check", "inclined"))
    assert json.loads(pier("limit", "inclined", "--json"))["base_shear"] == pytest.approx(1e3 * shear, rel=1e-6)
    printed = pier("limit", "inclined")
    assert f"): base shear {shear:.3f} kN, a collapse state" in printed
    assert f" 0.23570 {shear:.3f} " in printed
    assert figures_of(tmp_path / "out" / "collapse.html") in ("taglio alla base: 2,667 kN", "")


def test_an_upright_load_stands_where_a_base_shear_would(pier, tmp_path):
    """The pier is lifted by its weight."""
    printed = pier("check", "upright")
    assert "live load at λ = 1, upwards 16.000 Mat" in printed
    assert json.loads(pier("limit", "upright", "--json"))["base_shear"] == pytest.approx(0.0, abs=1e-9)
    printed += pier("limit", "upright")
    assert "): live load 16.00 kN upwards, a collapse state" in printed
    assert " 1.00000 16.00 " in printed
    assert not re.search("shear (at|kN|[0-9])", printed)
    assert figures_of(tmp_path / "out" / "collapse.html") in ("carico sismico: 16,00 kN verso l&#39;alto", "")


def test_the_picture_has_the_numbers_of_all_blocks_that_are_seen(tmp_path, monkeypatch):
    """Four walls around a block that is seen from neither side."""
    figures = []
    monkeypatch.setattr(space_pictures, "_written", lambda figure, path: figures.append(figure) or path)
    around = [box((-2.0, y, 0.0), (2.0, y + 0.5, 4.0)) for y in (-2.0, 1.5)]
    around += [box((x, -1.5, 0.0), (x + 0.5, 1.5, 4.0)) for x in (-2.0, 1.5)]
    hidden = box((-0.5, -0.5, 0.0), (0.5, 0.5, 0.3))
    wall = find_joints(wall_of([GROUND, *around, hidden], 0.6))
    space_pictures.save_wall(wall, np.array([0.0, -1.0, 0.0]), tmp_path / "blocks.png")
    for axes in figures[0].axes:
        assert {text.get_text() for text in axes.texts} == {"0", "1", "2", "3", "4"}


def test_the_number_of_a_block_stands_where_a_ray_meets_it_first():
    """Rays towards the picture against boxes, side by side of each (the slab method)."""
    steps = [box((x, 0.3 * x, 0.0), (x + 1.0, 2.0, 1.0 + 0.5 * (x % 3))) for x in range(6)]
    view = view_towards("aslant", np.array([0.6, -1.0, 0.7]), np.array([0.0, 0.0, 1.0]))
    low, high = np.array([-5.0, -5.0]), np.array([7.0, 5.0])
    picture = drawn(steps, np.full((6, 3), 0.9), [], view, (low, high), 600)
    places = places_of_numbers(picture)
    assert set(places) == set(range(6))
    for number, (column, row, across, along) in places.items():
        assert min(across, along) > 5
        for right, up in ((column, row), (column + across // 3, row), (column, row - along // 3)):
            place = low + (np.array([right, len(picture.face) - 1 - up]) + 0.5) * (12.0 / 600)
            start = place @ view.axes[:2] + 50.0 * view.axes[2]
            reached = [first_met(step.vertices, start, -view.axes[2]) for step in steps]
            assert int(np.argmin(reached)) == number


def first_met(corners, start, along) -> float:
    """How far along a ray a box begins, infinite for one that it misses."""
    both = (np.array([corners.min(axis=0), corners.max(axis=0)]) - start) / along
    enter, leave = both.min(axis=0).max(), both.max(axis=0).min()
    return float(enter) if enter < leave else np.inf
