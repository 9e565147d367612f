"""Exported decks run in CalculiX 2.20 (Debian calculix-ccx), a program that shares no line with ours.

Its static increments end when the largest residual force is below 0.5 % of the mean force (manual, *CONTROLS,
R_alpha_n): no load can be expected to come out nearer than about that.
"""

from __future__ import annotations

import json
import re
import shutil
import subprocess

import numpy as np
import pytest

from orchestrator.app.cli import main
from tests.support.paths import DATA

pytestmark = pytest.mark.skipif(shutil.which("ccx") is None, reason="needs CalculiX (ccx), which Debian 13 has not")
RESIDUAL = 0.005
"""CalculiX's own convergence criterion"""
FRICTION = 0.6
TWO_BLOCKS = {
    "name": "two blocks",
    "units": {"length": "m", "unit_weight": "kN/m3"},
    "thickness": 0.3,
    "unit_weight": 20.0,
    "friction": FRICTION,
    "blocks": [
        {"id": 0, "polygon": [[-0.2, -0.2], [1.2, -0.2], [1.2, 0], [-0.2, 0]], "fixed": True},
        {"id": 1, "polygon": [[0, 0], [1, 0], [1, 0.2], [0, 0.2]]},
        {"id": 2, "polygon": [[0.1, 0.2], [0.9, 0.2], [0.9, 0.4], [0.1, 0.4]]},
    ],
}
WEIGHT = (1.0 * 0.2 + 0.8 * 0.2) * 0.3 * 20e3


def reactions(folder, *arguments):
    """Export a deck, run it, and return time (n,) and total reaction of the supports (n, 3) of converged increments."""
    return run_of(folder, deck_of(folder, *arguments))


def deck_of(folder, *arguments):
    assert main(["export", *arguments, "--format", "calculix", "--output", str(folder / "deck.inp"), "--force"]) == 0
    return (folder / "deck.inp").read_text()


def run_of(folder, text):
    (folder / "deck.inp").write_text(text)
    run = subprocess.run(["ccx", "deck"], cwd=folder, capture_output=True, text=True, timeout=300, check=False)
    assert "*ERROR reading" not in run.stdout, run.stdout[-2000:]
    text = (folder / "deck.dat").read_text()
    time = re.findall(r"for set SUPPORT and time\s+(\S+)", text)
    force = re.findall(r"^((?:\s+[-+\d.E]+){3})$", text, re.M)
    return np.array(time, float), np.array([row.split() for row in force], float)


@pytest.fixture
def two_blocks(tmp_path):
    (tmp_path / "wall.json").write_text(json.dumps(TWO_BLOCKS))
    return str(tmp_path / "wall.json")


def test_reaction_of_two_blocks_is_their_weight_and_then_the_load(two_blocks, tmp_path):
    """Gravity, then 0.3 of it sideways: reaction (0, W), then (-0.3 W, W), in both models of the wall."""
    for model in ("macro", "micro"):
        time, force = reactions(tmp_path, two_blocks, "--model", model, "--multiplier", "0.3")
        at = [int(np.argmin(np.abs(time - end))) for end in (1.0, 2.0)]
        assert time[at] == pytest.approx([1.0, 2.0])
        assert force[at[0]] == pytest.approx([0.0, WEIGHT, 0.0], abs=RESIDUAL * WEIGHT)
        assert force[at[1]] == pytest.approx([-0.3 * WEIGHT, WEIGHT, 0.0], abs=RESIDUAL * WEIGHT)


def test_two_blocks_slide_at_the_coefficient_of_friction(two_blocks, tmp_path):
    """Low blocks slide, together or the upper alone, at multiplier mu; springs to the ground take what is beyond."""
    _, force = reactions(tmp_path, two_blocks, "--model", "micro", "--multiplier", "1.0")
    assert -force[:, 0].min() / WEIGHT == pytest.approx(FRICTION, rel=2 * RESIDUAL)
    assert force[-1, 1] == pytest.approx(WEIGHT, rel=RESIDUAL)


def test_joints_of_an_exported_deck_take_no_tension(tmp_path):
    """Gravity turned upwards: the stone leaves its support, which feels nothing; springs of 200 W/m hold it at 5 mm."""
    hanging = {
        **TWO_BLOCKS,
        "blocks": [
            {"id": 0, "polygon": [[0, -0.2], [1, -0.2], [1, 0], [0, 0]], "fixed": True},
            {"id": 1, "polygon": [[0, 0], [1, 0], [1, 0.2], [0, 0.2]]},
        ],
    }
    (tmp_path / "wall.json").write_text(json.dumps(hanging))
    text = deck_of(tmp_path, str(tmp_path / "wall.json")).replace("9.81, 0., -1., 0.", "9.81, 0., 1., 0.")
    _, force = run_of(tmp_path, text)
    assert np.abs(force[:, 1]).max() < RESIDUAL * 1.0 * 0.2 * 0.3 * 20e3


@pytest.mark.parametrize("model", ["macro", "micro"])
def test_wall_1_collapses_where_limit_analysis_says(model, tmp_path):
    """Ferris and Tin-Loi (2001), wall 1, non-associative: 0.640, the largest reaction of the supports within 2 %.

    Twice CalculiX's criterion, and as much again for elastic bodies with penalties against rigid ones (found: 0.651 of
    macroblocks, 0.649 stone by stone; docs/other_programs.md).
    """
    wall = str(DATA / "ferris_tinloi_wall1.json")
    time, force = reactions(tmp_path, wall, "--model", model, "--multiplier", "0.7")
    assert force[int(np.argmin(np.abs(time - 1.0))), 1] == pytest.approx(5250.0, rel=1e-3), "25 kN/m3 x 2.1 m2 x 0.1 m"
    assert -force[:, 0].min() / 5250.0 == pytest.approx(0.640, rel=0.02)
