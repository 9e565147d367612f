"""Past its peak a straight curve is followed in longer increments: it is the curve that short ones give."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from orchestrator import LoadSettings, SteppingSettings, analyse, loads_on, one_body_per_block, push
from tests.support.walls import of_file

FINE = 8
"""times as short as by default"""
NEAR = 0.002
"""part of the peak by which both curves may differ, past it, at the same displacement of the top"""


@pytest.mark.parametrize(
    ("name", "direction"), [("ferris_tinloi_wall1", "+x"), ("tower_5_blocks", "+x"), ("rubble_36_stones", "-x")]
)
def test_long_increments_follow_the_curve_of_short_ones(name, direction):
    assemblage, load = of_file(name), LoadSettings(direction)
    analysis = analyse(assemblage, loads=loads_on(assemblage.wall, load))
    settings = SteppingSettings(final_displacement=0.02)
    fine = replace(settings, displacement_increment=settings.displacement_increment / FINE)

    def curve(stepping):
        done = push(assemblage, analysis, one_body_per_block(assemblage), load, stepping=stepping)
        static = done.curve.static
        return static.control_displacement_m, static.load_multiplier

    (moved, bears), (moved_fine, bears_fine) = curve(settings), curve(fine)
    peak = bears_fine.argmax()
    past = moved > max(moved_fine[peak], moved[bears.argmax()])
    expected = np.interp(moved[past], moved_fine[peak:], bears_fine[peak:])
    assert np.abs(bears[past] - expected).max() < NEAR * bears_fine.max()
    assert bears.max() == pytest.approx(bears_fine.max(), rel=NEAR)
    assert np.diff(moved[past]).max() > 1.5 * settings.displacement_increment * settings.final_displacement
