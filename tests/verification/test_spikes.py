"""A peak that a wall loses again at once is told: polygonal stones, of which one sticks at a rocking pier's foot.

Limit analysis has the state beyond the spike, and finer elements have no spike (0.1412 with a third of the size).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from orchestrator import JointSettings, MeshSettings, SteppingSettings, analyse, find_joints, one_body_per_block, push
from orchestrator.app.at_peak import spike_of
from orchestrator.loads import LoadSettings, loads_on
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.pushover.increments import COLUMNS, PushoverCurve

WALL = Path(__file__).parents[1] / "data" / "polygonal_40_stones.json"


def curve(displacement, multiplier) -> PushoverCurve:
    """Return a curve of a wall of 1 N by displacement in m and multiplier."""
    columns = {name: np.zeros(len(displacement)) for name in COLUMNS}
    columns |= {"control_displacement_m": np.array(displacement), "step": np.arange(len(displacement))}
    columns |= {"load_multiplier": np.array(multiplier), "base_shear_N": np.array(multiplier)}
    return PushoverCurve(**columns, stopped_because="")


def test_what_is_a_spike():
    end = 0.1
    assert spike_of(curve([0, 1e-4, 2e-4, 0.1], [0, 0.3, 0.28, 0.2]), end).moved == pytest.approx(1e-4)
    assert spike_of(curve([0, 1e-4, 1e-2, 0.1], [0, 0.3, 0.28, 0.2]), end) is None
    assert spike_of(curve([0, 1e-4, 2e-4, 0.1], [0, 0.3, 0.29, 0.2]), end) is None
    assert spike_of(curve([0, 1e-4], [0, 0.3]), end) is None


def test_a_wall_of_polygonal_stones_falls_from_its_spike_to_limit_analysis():
    assemblage, load = find_joints(read_blocks(WALL), JointSettings()), LoadSettings("+x")
    analysis = analyse(assemblage, loads=loads_on(assemblage.wall, load))
    stepping = SteppingSettings(final_drop=0.1)
    mesh = MeshSettings(toe_offset=0.5)  # short elements where stones turn have no spike either
    found = push(assemblage, analysis, one_body_per_block(assemblage), load, mesh=mesh, stepping=stepping).summary
    assert found.peak_multiplier > 1.04 * analysis.headline.load_multiplier
    assert found.spike.load_multiplier == pytest.approx(analysis.headline.load_multiplier, rel=0.01)
    assert found.spike.moved < 1e-4
