"""A run that is killed (SIGKILL, as by the kernel or a queue) loses nothing: it goes on and ends in the same curve.

Each kill falls where it hurts most: a file has been written under its temporary name and is about to be renamed. The
longer test with kills at random times is docs/studies/killed.py.
"""

from __future__ import annotations

import re

import numpy as np
import pytest

from tests.support.killing import curve, difference, killed_at_file, run
from tests.support.paths import DATA

MODEL = "micro"
WALL = DATA / "tower_5_blocks.json"
RUN = ["run", str(WALL), "--model", MODEL, "--set", "stepping.final_displacement=2mm", "--output"]
MOMENTS = {
    "under gravity": (f"{MODEL}/states/000003.h5", 2),
    "in displacement control": (f"{MODEL}/states/000040.h5", 39),
    "all states in one file": ("states.h5", None),
    "a picture": (f"{MODEL}_peak.png", None),
}
"""the file that was about to be renamed, and the last increment on the disk by then (None: of the whole curve)"""


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    return tmp_path_factory.mktemp("cache")


@pytest.fixture(scope="module")
def whole(tmp_path_factory, cache):
    """The curve of the uninterrupted run and its last increment."""
    folder = tmp_path_factory.mktemp("whole")
    done = run([*RUN, str(folder)], cache)
    assert done.returncode == 0, done.stderr
    last = np.genfromtxt(folder / MODEL / "curve.csv", delimiter=",", names=True)["step"][-1]
    return curve(folder, MODEL), int(last)


def test_resumed_curve_is_the_uninterrupted_one(whole, cache, tmp_path):
    """Killed at one moment after the other, and resumed each time."""
    expected, last = whole
    command, resumed = [*RUN, str(tmp_path)], []
    for moment, (file, stored) in MOMENTS.items():
        assert killed_at_file(command, cache, file) == -9, moment
        assert not (tmp_path / "summary.json").exists(), "a killed run has no result"
        command = [*RUN, str(tmp_path), "--resume"]
        resumed.append(last if stored is None else stored)
    done = run(command, cache)
    assert done.returncode == 0, done.stderr
    log = (tmp_path / "run.log").read_text()
    assert [int(number) for number in re.findall(r"resumed after increment (\d+)\n", log)] == resumed
    assert difference(curve(tmp_path, MODEL), expected) <= 1e-10
    assert not [*tmp_path.rglob(".*")], "nothing half-written is left, and no lock"


def test_a_rank_that_is_killed_ends_the_other_and_both_go_on(whole, cache, tmp_path):
    """Two ranks share the linear system; what order of summation changes is within the solver's tolerance."""
    shared = [*RUN, str(tmp_path), "--set", "newton.distribute_above=0"]
    assert killed_at_file(shared, cache, f"{MODEL}/states/000015.h5", ranks=2) == 137
    done = run([*shared, "--resume"], cache, ranks=2)
    assert done.returncode == 0, done.stderr
    assert difference(curve(tmp_path, MODEL), whole[0]) < 1e-8
