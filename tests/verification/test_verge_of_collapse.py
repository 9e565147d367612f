"""Walls that just stand under their dead load, or do not by less than a drawing's rounding: no multiplier counts."""

from __future__ import annotations

import json
from math import cos, radians, sin, tan

import pytest

from orchestrator.app.cli import main
from tests.support.undrawn import undrawn

ANGLE = radians(20.0)
HEADER = {"units": {"length": "m", "unit_weight": "kN/m3"}, "thickness": 0.3, "unit_weight": 20.0}


def beyond_the_edge(beyond):
    """A block of 1 x 0.4 m whose centroid lies so far (m) beyond the edge of the support."""
    left = beyond - 0.5
    ground = [[-1, -0.3], [0, -0.3], [0, 0], [-1, 0]]
    block = [[left, 0], [left + 1, 0], [left + 1, 0.4], [left, 0.4]]
    return HEADER | {
        "friction": 0.6,
        "blocks": [{"id": 0, "polygon": ground, "fixed": True}, {"id": 1, "polygon": block}],
    }


def on_a_slope(friction):
    """A block on a slope of 20 degrees that falls to the left."""

    def turned(*points):
        return [[x * cos(ANGLE) - y * sin(ANGLE), x * sin(ANGLE) + y * cos(ANGLE)] for x, y in points]

    ground = turned((-1, -0.3), (3, -0.3), (3, 0), (-1, 0))
    block = turned((0, 0), (1, 0), (1, 0.4), (0, 0.4))
    walls = [{"id": 0, "polygon": ground, "fixed": True}, {"id": 1, "polygon": block}]
    return HEADER | {"friction": friction, "blocks": walls}


@pytest.mark.parametrize(
    ("wall", "direction"),
    [
        (beyond_the_edge(0.0), "+x"),
        (beyond_the_edge(1e-7), "+x"),
        (beyond_the_edge(-1e-7), "+x"),
        (on_a_slope(tan(ANGLE)), "-x"),
    ],
    ids=["balanced on the edge", "beyond the edge", "short of it by as little", "at the angle of friction"],
)
def test_a_wall_on_the_verge_is_refused(wall, direction, tmp_path, capsys):
    (tmp_path / "wall.json").write_text(json.dumps(wall), encoding="utf-8")
    with undrawn():
        assert main(["limit", str(tmp_path / "wall.json"), "--set", f"load.direction={direction}"]) == 2
    assert "is on the verge of collapse under its dead load" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("wall", "direction", "bears"),
    [(beyond_the_edge(-1e-3), "+x", 1e-3 / 0.2), (on_a_slope(1.01 * tan(ANGLE)), "-x", None)],
    ids=["a millimetre short of the edge", "1 % below the angle of friction"],
)
def test_one_that_has_some_reserve_bears_it(wall, direction, bears, tmp_path, capsys):
    """The block turns at e / (h / 2); that on the slope slides at tan(phi - 20 degrees)."""
    (tmp_path / "wall.json").write_text(json.dumps(wall), encoding="utf-8")
    with undrawn():
        assert main(["limit", str(tmp_path / "wall.json"), "--set", f"load.direction={direction}"]) == 0
    friction = wall["friction"]
    expected = bears or (friction - tan(ANGLE)) / (1 + friction * tan(ANGLE))
    said = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("λ = "))
    assert float(said.split()[2]) == pytest.approx(expected, rel=5e-3)


FACES = [[3, 2, 1, 0], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]


def box(*sides):
    """The corners of a box from its least and largest x, y and z, m."""
    x, y, z = sides
    return [[x[a], y[b], z[c]] for c in (0, 1) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]


@pytest.mark.parametrize(("beyond", "code"), [(0.0, 2), (-1e-7, 2), (-1e-3, 0)])
def test_so_is_one_in_space(beyond, code, tmp_path, capsys):
    """The same block out of its plane."""
    ground = {"id": 0, "vertices": box((-2, 2), (-1, 0), (-0.3, 0)), "faces": FACES, "fixed": True}
    block = {"id": 1, "vertices": box((0, 1), (beyond - 0.5, beyond + 0.5), (0, 0.4)), "faces": FACES}
    wall = {"units": HEADER["units"], "unit_weight": 20.0, "friction": 0.6, "up": "z", "blocks": [ground, block]}
    (tmp_path / "wall.json").write_text(json.dumps(wall), encoding="utf-8")
    (tmp_path / "case.toml").write_text('[wall]\nblocks = "wall.json"\n[load]\ndirection = "+y"\n', encoding="utf-8")
    with undrawn():
        assert main(["limit", str(tmp_path / "case.toml"), "--output", str(tmp_path / "out")]) == code
    printed = capsys.readouterr()
    assert ("is on the verge of collapse under its dead load" in printed.err) is (code == 2)
    assert ("λ = 0.005000 counts" in printed.out) is (code == 0)
