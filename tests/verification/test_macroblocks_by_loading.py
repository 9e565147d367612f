"""Macroblocks bear what every stone bears, in finite elements: limit analysis chose them and takes no part in that."""

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
    macroblocks_of,
    push,
)
from orchestrator.masonry.patterns import ArchedOpening, ArchedWall, IrregularCourses, Rubble, arched_wall, rubble


def of_stones(seed):
    """Wall of docs/studies/any_wall.py: rubble without courses."""
    random = np.random.default_rng(seed)
    return rubble(Rubble(1.8, 1.6, stone=random.uniform(0.25, 0.4), flatness=random.uniform(1.0, 2.5), seed=seed))


def with_arch(seed, rise):
    """Wall of docs/studies/any_wall.py: irregular courses over a doorway with an arch."""
    courses = IrregularCourses(
        2.8, 2.2, thickness=0.4, widths=(0.35, 0.6), heights=(0.22, 0.32), overlap=0.07, friction=0.7, seed=seed
    )
    opening = ArchedOpening(0.95, 1.85, 0.0, 1.0, rise=rise, depth=0.25, voussoirs=7)
    return arched_wall(ArchedWall(courses, (opening,), quoins=(0.6, 0.4) if seed % 2 else None))


@pytest.mark.parametrize(
    ("wall", "direction", "every_stone"),
    [
        pytest.param(of_stones(2), "+x", 0.3680, id="a stack at the edge that slides by itself"),
        pytest.param(
            with_arch(1, 0.2),
            "-x",
            0.5236,
            id="bodies that lock",
            marks=pytest.mark.xfail(reason="the bodies chosen bear 0.5599, 6.9 % more: not yet", strict=False),
        ),
    ],
)
def test_macroblocks_bear_what_every_stone_bears(wall, direction, every_stone):
    """every_stone: peak of micro-FE, `push` with `one_body_per_block`. Bodies chosen by the multiplier of a limit state
    alone bore 0.2449 (4 bodies of 47 stones) and 0.5599 (4 of 47)."""
    assemblage, load = find_joints(wall, JointSettings()), LoadSettings(direction)
    analysis = analyse(assemblage, loads=loads_on(wall, load))
    partition = macroblocks_of(assemblage, analysis)
    assert partition.count < 24
    height = np.ptp(np.vstack([block.polygon for block in wall.blocks if not block.fixed])[:, 1])
    done = push(assemblage, analysis, partition, load, stepping=SteppingSettings(final_displacement=height / 30))
    peak = done.capacity.peak_base_shear / analysis.horizontal_load
    assert -0.02 < peak / every_stone - 1 < 0.04
