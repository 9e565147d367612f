"""A run that is stopped and resumed ends where the uninterrupted one does."""

from __future__ import annotations

from dataclasses import replace

import pytest

from orchestrator.app import driver
from orchestrator.app.progress import IncrementDone
from orchestrator.basis.errors import CaseError
from orchestrator.settings import case
from tests.support.paths import DATA

pytestmark = pytest.mark.usefixtures("without_pictures")


class Killed(Exception):
    """Stands for the signal that ends a run between two increments."""


def micro_case(*overrides):
    wall = DATA / "ferris_tinloi_wall1.json"
    settings = ["stepping.final_displacement=2mm", "run.models=['micro']", *overrides]
    return case.read(wall, settings)


def run(folder, resume=False, killed_after=None, **changes):
    def report(event):
        if isinstance(event, IncrementDone) and event.increment.number == killed_after:
            raise Killed

    return driver.run(replace(micro_case(), **changes), folder, resume, None, report)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    run(folder)
    return (folder / "micro" / "curve.csv").read_text().splitlines()


def test_resumed_curve_is_the_uninterrupted_one(whole, tmp_path):
    """Killed under gravity (3), in load control (20) and in displacement control (40), and resumed each time."""
    for phase_end in (3, 20, 40):
        with pytest.raises(Killed):
            run(tmp_path, resume=phase_end > 3, killed_after=phase_end)
        assert len([*(tmp_path / "micro" / "states").glob("*.h5")]) == phase_end
        assert not (tmp_path / "micro" / "curve.csv").exists(), "no result is written of an unfinished run"
    run(tmp_path, resume=True)
    found = (tmp_path / "micro" / "curve.csv").read_text().splitlines()
    assert len(found) == len(whole) > 35
    for line, expected in zip(found[1:], whole[1:], strict=True):
        first, second = ([float(value) for value in row.split(",")] for row in (line, expected))
        assert first[:5] == pytest.approx(second[:5], rel=1e-10, abs=1e-9)


def test_resume_with_another_wall_is_refused_and_nothing_is_lost(tmp_path):
    with pytest.raises(Killed):
        run(tmp_path, killed_after=5)
    stored = sorted((tmp_path / "micro" / "states").glob("*.h5"))
    assert len(stored) == 5
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    with pytest.raises(CaseError, match=r"another model.*without --resume"):
        run(tmp_path, resume=True, load=case.LoadSettings("-x"))
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before
    assert set(stored) <= set(before)
