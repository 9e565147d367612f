"""The same case on 1, 2 and 4 ranks, as a user starts it."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.paths import DATA
from tests.support.ranks import on_ranks

WALL = DATA / "ferris_tinloi_wall1.json"


def start(ranks, folder, *arguments, wall=WALL):
    """Run a wall, by default wall 1, to 0.5 mm (past its peak) on so many ranks; return what it printed."""
    command = ("-m", "orchestrator", "run", wall, "--output", folder)
    done = on_ranks(ranks, *command, "--set", "stepping.final_displacement=0.5mm", *arguments)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def curves(folder, *models):
    """Return load multiplier, base shear and control displacement of the models, by default of both, one array."""
    models = models or ("macro", "micro")
    tables = [np.genfromtxt(folder / model / "curve.csv", delimiter=",", names=True) for model in models]
    names = ("load_multiplier", "base_shear_N", "control_displacement_m")
    return [np.column_stack([table[name] for name in names]) for table in tables]


@pytest.fixture(scope="module")
def serial(tmp_path_factory):
    folder = tmp_path_factory.mktemp("serial")
    start(1, folder)
    return curves(folder)


def test_two_ranks_below_the_threshold_give_the_same_bits_and_print_once(serial, tmp_path):
    printed = start(2, tmp_path)
    lines = [line for line in printed.splitlines() if line.strip()]
    assert len(set(lines)) == len(lines) > 10
    for found, expected in zip(curves(tmp_path), serial, strict=True):
        assert len(expected) > 20
        assert found.tobytes() == expected.tobytes()


@pytest.mark.parametrize(("ranks", "increments"), [(2, 1000), (4, 40)])
def test_shared_linear_system_agrees_to_solver_tolerance(serial, tmp_path, ranks, increments):
    """All ranks assemble and solve together; nothing but the order of summation may differ."""
    shared = ["newton.distribute_above=0", f"stepping.largest_increments={increments}"]
    start(ranks, tmp_path, "--model", "micro", *(part for setting in shared for part in ("--set", setting)))
    (found,) = curves(tmp_path, "micro")
    expected = serial[1][: len(found)]
    assert len(found) > (30 if ranks == 4 else len(serial[1]) - 1)
    assert found == pytest.approx(expected, rel=1e-8, abs=1e-12 * expected.max())
