"""Arches whose voussoirs meet two other stones in one point, pushed past their peaks until 20 % of them are lost.

In the one in courses a voussoir and its skewback slide together over the end of the stone below: corners of both are on
its bed in the same place, and where they stick to each other the forces of these contacts are not unique. In the one
over a lintel a corner of a voussoir slides along one face of the stone above it into a re-entrant corner of that stone.
While it slides, the force of the second face lets it sink deeper: no state is near, and the wall has to move.

In a wall of rubble the tip of a stone lies in such a corner between two others, where three steps of motion bring it:
with Coulomb's friction no further step, however short, had a solution.
"""

from __future__ import annotations

from itertools import takewhile
from pathlib import Path

import pytest

from orchestrator import (
    JointSettings,
    MeshSettings,
    SteppingSettings,
    analyse,
    find_joints,
    make_bodies,
    one_body_per_block,
    push,
    pushover_increments,
)
from orchestrator.loads import LoadSettings, loads_on
from orchestrator.masonry.sources.block_files import read_blocks

DATA = Path(__file__).parents[1] / "data"


@pytest.mark.parametrize("name", ["segmental_arch_49_stones", "relieving_arch_68_stones"])
def test_an_arch_goes_past_its_peak(name):
    """They broke off at a displacement of 4.8 mm, 0.7 % below the peak, and of 6.2 mm, 1.5 % below it."""
    assemblage, load = find_joints(read_blocks(DATA / f"{name}.json"), JointSettings()), LoadSettings("+x")
    analysis = analyse(assemblage, loads=loads_on(assemblage.wall, load))
    stepping = SteppingSettings(final_displacement=0.08)
    done = push(assemblage, analysis, one_body_per_block(assemblage), load, stepping=stepping)
    assert not done.complaints
    assert done.capacity.peak_multiplier < analysis.associative.load_multiplier
    assert done.curve.load_multiplier[-1] < 0.8 * done.capacity.peak_multiplier


@pytest.mark.parametrize("size", [0.09, 0.1])
def test_rubble_with_a_tip_between_two_stones_goes_on(size):
    """It broke off at 0.4013 and 0.4157."""
    wall = find_joints(read_blocks(DATA / "rubble_window_59_stones.json"), JointSettings())
    bodies = make_bodies(wall, one_body_per_block(wall))
    rows = pushover_increments(bodies, mesh=MeshSettings(size), expected_multiplier=0.43)
    assert len(list(takewhile(lambda row: row.phase != "displacement", rows))) > 30
    assert next(rows).load_multiplier > 0.4
