"""Flat arches on piers: a snap past the peak is motion, and stones that slide by turns do not keep increments short.

Of a review in November 2026. A static increment is a path of equilibrium: its work and energies balance by themselves.
"""

from __future__ import annotations

import numpy as np

from orchestrator import MeshSettings, analyse, one_body_per_block, push
from orchestrator.pushover.path.curve_checks import ENERGY
from tests.support.walls import of_file


def pushed(name, mesh=None):
    """The finished pushover of a wall of tests/data, every stone a body, and its increments."""
    assemblage, told = of_file(name), []
    done = push(assemblage, analyse(assemblage), one_body_per_block(assemblage), mesh=mesh, report=told.append)
    return done, [one.increment for one in told]


def test_a_snap_past_the_peak_is_no_path_of_equilibrium():
    """The top goes back by 0.4 mm and the load by an eighth while the driven stones go on: an increment of 0.42 mm took
    it for static, with 40 % of its own work and 2.3 % of all missing, and no peak counted. (With elements of one size;
    short ones bear 0.2283.)"""
    done, increments = pushed("jack_arch_on_piers_22_stones", MeshSettings(toe_offset=0.5))
    assert done.summary.valid
    assert 0.2324 < done.capacity.peak_multiplier < 0.2330
    assert done.summary.energy_error < 1e-3
    assert not done.summary.moving_steps
    (snap,) = np.flatnonzero(np.diff([one.load_multiplier for one in increments]) < -0.02)
    before, after = increments[snap : snap + 2]
    assert after.control_displacement < before.control_displacement - 2e-4
    assert after.attempts[-1].action == "moved, bearing less on the way, until it rested"
    friction, resisted = after.dissipated_energy - before.dissipated_energy, after.other_work - before.other_work
    assert resisted > friction, "mass and viscosity take what the snap gives off"
    assert abs(after.energy_error - before.energy_error) < ENERGY * friction


def test_stones_that_slide_by_turns_do_not_keep_increments_short():
    """Two stones slide by turns, every increment departs from the one before: as long as none grew then, 2,000 of 2.8
    micrometres ended at 7.6 mm."""
    done, _ = pushed("jack_arch_on_piers_13_stones")
    assert done.summary.valid
    assert done.summary.stopped_because == "base shear 20 % below its peak"
    assert 0.1233 < done.capacity.peak_multiplier < 0.1234
    assert done.summary.steps < 300
