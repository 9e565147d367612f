"""Macroblocks that bear another load in finite elements than limit analysis says are refined until they do not."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator import (
    JointSettings,
    LoadSettings,
    SteppingSettings,
    analyse,
    find_joints,
    loads_on,
    one_body,
    push,
    push_and_refine,
    read_run,
)
from orchestrator.app import driver
from orchestrator.app.progress import IncrementDone
from orchestrator.masonry.patterns import Rubble, rubble
from orchestrator.settings import case as cases
from tests.support.paths import DATA

WALL = DATA / "rubble_36_stones.json"
"""run 65 of docs/studies/path.py: rubble, drawn with errors of millimetres"""
MICRO_FE = 0.4523
"""peak of that wall pushed to -x stone by stone, docs/studies/path.csv"""


def test_bodies_that_do_not_know_the_mechanism_of_the_stones():
    """From one body (0.65, its friction), and twice as many each time; every stone bears 0.3680 (micro-FE)."""
    random = np.random.default_rng(2)
    wall = rubble(Rubble(1.8, 1.6, stone=random.uniform(0.25, 0.4), flatness=random.uniform(1.0, 2.5), seed=2))
    assemblage, load = find_joints(wall, JointSettings()), LoadSettings("+x")
    analysis = analyse(assemblage, loads=loads_on(wall, load))
    stepping = SteppingSettings(final_displacement=0.05)
    partition, done = push_and_refine(
        assemblage,
        analysis,
        one_body(assemblage),
        lambda bodies: push(assemblage, analysis, bodies, load, stepping=stepping),
    )
    assert 2 < partition.count < 24
    assert "1 bear 0.6" in partition.remarks[-1]
    assert done.capacity.peak_base_shear / analysis.horizontal_load == pytest.approx(0.3680, rel=0.02)


class Killed(Exception):
    """Stands for the signal that ends a run between two increments."""


@pytest.mark.usefixtures("without_pictures")
def test_a_run_has_the_bodies_that_bear_what_the_stones_bear_and_can_be_resumed(tmp_path):
    """Eight bodies, which fail as rigid ones where the stones do, bear 0.505 in finite elements."""
    case = cases.read(WALL, ["load.direction=-x", "run.models=['macro']", "stepping.final_displacement=20mm"])
    began = []

    def report(event):
        if isinstance(event, IncrementDone) and event.increment.number == 1:
            began.append(event)
        if isinstance(event, IncrementDone) and len(began) == 2 and event.increment.number == 40:
            raise Killed

    with pytest.raises(Killed):
        driver.run(case, tmp_path, False, None, report)
    assert len([*(tmp_path / "macro" / "states").glob("*.h5")]) == 40
    after = []
    outcome = driver.run(
        case, tmp_path, True, None, lambda event: after.append(event) if isinstance(event, IncrementDone) else None
    )
    assert after[0].increment.number == 41, "the second pushover goes on"
    (pushover,) = outcome.summary.pushover
    assert pushover.peak_multiplier == pytest.approx(MICRO_FE, rel=0.02)
    assert not outcome.complaints
    stored = read_run(tmp_path)
    assert stored.partition.count == pushover.bodies == outcome.summary.macroblocks.count < 18
