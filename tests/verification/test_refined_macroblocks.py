"""Macroblocks that bear another load in finite elements than limit analysis says are refined until they do not."""

from __future__ import annotations

import json
from itertools import pairwise

import numpy as np
import pytest

from orchestrator import (
    JointSettings,
    LoadSettings,
    MeshSettings,
    SteppingSettings,
    analyse,
    find_joints,
    loads_on,
    macroblocks_of,
    one_body,
    one_body_per_block,
    push,
    push_and_refine,
    read_run,
)
from orchestrator.app import driver
from orchestrator.app.curve_end import NOT_ENOUGH
from orchestrator.app.progress import IncrementDone, StageDone
from orchestrator.macroblocks.refinement import HELD
from orchestrator.masonry.patterns import Arch, Rubble, arch_on_piers, rubble
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.settings import case as cases
from tests.support.paths import DATA
from tests.support.walls import between

WALL = DATA / "rubble_36_stones.json"
"""run 65 of docs/studies/path.py: rubble, drawn with errors of millimetres"""
MICRO_FE = 0.4523
"""peak of that wall pushed to -x stone by stone, docs/studies/macroblock_peaks.csv"""


def test_bodies_that_do_not_know_the_mechanism_of_the_stones():
    """From one body (0.65, its friction), and twice as many each time; every stone bears 0.3680 (micro-FE).

    On some processors 4 to 32 bodies bear 0.206, as a column at the edge leans away: then every stone is pushed.
    """
    random = np.random.default_rng(2)
    wall = rubble(Rubble(1.8, 1.6, stone=random.uniform(0.25, 0.4), flatness=random.uniform(1.0, 2.5), seed=2))
    assemblage, load = find_joints(wall, JointSettings()), LoadSettings("+x")
    analysis = analyse(assemblage, loads=loads_on(wall, load))
    stepping = SteppingSettings(final_displacement=0.05)
    partition, done = push_and_refine(
        assemblage,
        analysis,
        one_body(assemblage),
        lambda bodies, suffices: push(
            assemblage, analysis, bodies, load, stepping=stepping, mesh=MeshSettings(0.2), suffices=suffices
        ),
    )
    assert partition.count > 2
    assert "1 bear 0.6" in partition.remarks[-1]
    assert done.capacity.peak_base_shear / analysis.horizontal_load == pytest.approx(0.3680, rel=0.02)


def test_few_bodies_of_a_thin_arch_bear_no_more_than_its_voussoirs():
    """4 bear 0.0396, which is between what rigid blocks bear and what stones leave that give way at edges."""
    assemblage = find_joints(arch_on_piers(Arch(24, 5.0, 0.6, friction=0.8, thickness=1.0)), JointSettings())
    analysis = analyse(assemblage)
    bodies = macroblocks_of(assemblage, analysis)
    assert bodies.count < 8
    _, done = push_and_refine(
        assemblage, analysis, bodies, lambda finer, suffices: push(assemblage, analysis, finer, suffices=suffices)
    )
    every_stone = push(assemblage, analysis, one_body_per_block(assemblage))
    assert done.capacity.peak_base_shear == pytest.approx(every_stone.capacity.peak_base_shear, rel=0.04)


def test_a_curve_whose_peak_does_not_suffice_ends_beyond_it():
    """And not before it: a curve that suffices has the same rows up to there, and may have a higher peak later."""
    assemblage, load = find_joints(read_blocks(WALL), JointSettings()), LoadSettings("-x")
    analysis = analyse(assemblage, loads=loads_on(assemblage.wall, load))
    asked = []

    def refused(multiplier):
        asked.append(multiplier)
        return False

    partition = macroblocks_of(assemblage, analysis)
    whole = push(assemblage, analysis, partition, load, suffices=lambda multiplier: True)
    left = push(assemblage, analysis, partition, load, suffices=refused)
    rows = len(left.curve.step)
    assert rows < len(whole.curve.step)
    assert np.array_equal(left.curve.base_shear_N, whole.curve.base_shear_N[:rows])
    assert left.capacity.peak_base_shear == whole.curve.base_shear_N[:rows].max()
    assert asked == [pytest.approx(left.capacity.peak_base_shear / analysis.horizontal_load, rel=1e-9)]
    assert left.curve.base_shear_N[-1] < 0.99 * left.capacity.peak_base_shear < left.curve.base_shear_N[-2]
    assert left.summary.valid
    assert left.curve.stopped_because == NOT_ENOUGH


@pytest.mark.usefixtures("without_pictures")
def test_macroblocks_that_supports_hold_are_pushed_once(tmp_path):
    """A running bond 3 mm beside an abutment as high as itself: it leans on that, and no load brings it down."""
    abutment = [[-0.3, -0.3], [1.6, -0.3], [1.6, 1.2], [1.203, 1.2], [1.203, 0], [-0.3, 0]]
    courses = [((0, 0.3, 0.9, 1.2) if course % 2 else (0, 0.6, 1.2), 0.3 * course) for course in range(4)]
    stones = [between(a, y, b, y + 0.3).tolist() for cuts, y in courses for a, b in pairwise(cuts)]
    record = {"units": {"length": "m", "unit_weight": "kN/m3"}, "thickness": 0.5, "friction": 0.6, "unit_weight": 20.0}
    blocks = [{"id": n, "polygon": one, "fixed": n == 0} for n, one in enumerate([abutment, *stones])]
    (tmp_path / "wall.json").write_text(json.dumps(record | {"blocks": blocks}), encoding="utf-8")
    done = []
    case = cases.read(tmp_path / "wall.json", ["load.direction=+x", "run.models=['macro']"])
    outcome = driver.run(case, tmp_path / "run", False, None, done.append)
    (pushover,) = outcome.summary.pushover
    assert pushover.held
    assert pushover.bodies < len(stones)
    assert sum(isinstance(one, StageDone) and one.stage == "macro FE" for one in done) == 1
    assert HELD in read_run(tmp_path / "run").partition.remarks


class Killed(Exception):
    """Stands for the signal that ends a run between two increments."""


@pytest.mark.usefixtures("without_pictures")
def test_a_run_has_the_bodies_that_bear_what_the_stones_bear_and_can_be_resumed(tmp_path):
    """Eight bodies, which fail as rigid ones where the stones do, bear 0.505 in finite elements."""
    settings = ["load.direction=-x", "run.models=['macro']", "stepping.final_displacement=20mm", "mesh.size=200mm"]
    settings += ["mesh.toe_offset=0.5"]
    case = cases.read(WALL, settings)
    began = []

    def report(event):
        if isinstance(event, IncrementDone) and event.increment.number == 1:
            began.append(event)
        if isinstance(event, IncrementDone) and len(began) == 2 and event.increment.number == 25:
            raise Killed

    with pytest.raises(Killed):
        driver.run(case, tmp_path, False, None, report)
    assert len([*(tmp_path / "macro" / "states").glob("*.h5")]) == 25
    after = []
    outcome = driver.run(
        case, tmp_path, True, None, lambda event: after.append(event) if isinstance(event, IncrementDone) else None
    )
    assert after[0].increment.number == 26, "the second pushover goes on"
    (pushover,) = outcome.summary.pushover
    assert pushover.peak_multiplier == pytest.approx(MICRO_FE, rel=0.02)
    assert not outcome.complaints
    stored = read_run(tmp_path)
    assert stored.partition.count == pushover.bodies == outcome.summary.macroblocks.count
    every_stone = outcome.summary.wall.blocks
    assert pushover.bodies in (16, every_stone), (
        "by the processor: 16 bear 1.5 % more than 32 on one, which are too many"
    )
    again = driver.run(case, tmp_path, True, None, lambda event: None)
    assert again.summary.macroblocks.count == pushover.bodies, "a run that is finished keeps its macroblocks"
    assert again.summary.pushover[0].peak_multiplier == pushover.peak_multiplier
    assert read_run(tmp_path).partition.remarks == stored.partition.remarks
