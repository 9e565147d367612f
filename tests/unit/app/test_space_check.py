"""`check` of a wall in space is the first page of a case; `limit` ends with the number that counts."""

from __future__ import annotations

import json

import pytest

from orchestrator.app import cli
from tests.support.space_walls import record

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
        "all dead load 3.000",
        "base shear at λ = 1, (0, -1, 0) 3.000",
        "(none) 1 0.05 1.000 20 0.6",
        "block, support 1 0.25 0.6",
        "Joint forces can balance its dead load, and the live load brings it down.",
    ]
    assert [line for line in expected if line not in lines] == []


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


def test_limit_says_which_number_counts(case, tmp_path, capsys):
    assert cli.main(["limit", str(case), "--output", str(tmp_path / "out")]) == 0
    printed = capsys.readouterr().out
    said = "λ = 0.60000 counts (elastic joints): base shear 1.800 kN, a collapse state with friction that does not "
    assert said + "dilate; it reaches the associative upper bound, and no lower one was found." in printed
