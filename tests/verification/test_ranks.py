"""The same case on 1, 2 and 4 ranks, as a user starts it."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.paths import DATA
from tests.support.ranks import on_ranks

WALL = DATA / "ferris_tinloi_wall1.json"


def start(ranks, folder, *arguments, wall=WALL):
    """Run a wall, by default wall 1, to 0.5 mm (past its peak) on so many ranks; return what it printed."""
    command = ("-m", "tests.support.undrawn", "run", wall, "--output", folder)
    done = on_ranks(ranks, *command, "--set", "stepping.final_displacement=0.5mm", *arguments)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def curve(folder):
    """Return load multiplier, base shear and control displacement, one array."""
    table = np.genfromtxt(folder / "micro" / "curve.csv", delimiter=",", names=True)
    return np.column_stack([table[name] for name in ("load_multiplier", "base_shear_N", "control_displacement_m")])


@pytest.fixture(scope="module")
def serial(tmp_path_factory):
    folder = tmp_path_factory.mktemp("serial")
    start(1, folder, "--model", "micro")
    return curve(folder)


def test_two_ranks_below_the_threshold_give_the_same_bits_and_print_once(serial, tmp_path):
    """Macroblocks under ranks: tests/unit/app/test_load_cases.py, test_study.py."""
    printed = start(2, tmp_path, "--model", "micro")
    lines = [line for line in printed.splitlines() if line.strip()]
    assert len(set(lines)) == len(lines) > 10
    assert len(serial) > 20
    assert curve(tmp_path).tobytes() == serial.tobytes()


@pytest.mark.parametrize(("ranks", "increments"), [(2, 1000), (4, 24)])
def test_shared_linear_system_agrees_to_solver_tolerance(serial, tmp_path, ranks, increments):
    """All ranks assemble and solve together; nothing but the order of summation may differ."""
    shared = ["newton.distribute_above=0", f"stepping.largest_increments={increments}"]
    start(ranks, tmp_path, "--model", "micro", *(part for setting in shared for part in ("--set", setting)))
    found = curve(tmp_path)
    expected = serial[: len(found)]
    assert len(found) > (16 if ranks == 4 else len(serial) - 1)
    assert found == pytest.approx(expected, rel=1e-8, abs=1e-12 * expected.max())
