"""How much larger than a static increment the next one is, by how much it departs from the one before (numpy only)."""

from __future__ import annotations

import numpy as np

from orchestrator.pushover.increments import Increment

BENT = 0.5
"""an increment that departs from the one before by this share of its length, or more, is followed by one as large; one
that departs by half of it, or less, by one twice as large"""
ASTRAY = 0.05
"""while the base shear falls increments grow above the largest, as long as they are expected to depart from the one
before by less than this share of the largest (a curve drawn through them is off by an eighth of that)"""
LONGEST_STRAIGHT = 4.0
"""such an increment at most, over the largest"""


def growth(state: Increment, bent: float, smaller: bool) -> float:
    """Return by what factor the increment after the one from `state` is larger than that, which is so bent.

    smaller: it was found only after a larger one had failed. Under displacement control it may bend although it was no
    larger than the one before it, which was found at once: then shorter ones do not make the path straight, as where
    stones slide by turns.
    """
    if smaller:
        return 1.0
    if bent >= BENT:
        was_held = state.phase == "displacement" and state.step[0] <= state.step[1] and not state.attempts
        return 2.0 if was_held else 1.0
    return min(BENT / bent, 2.0) if bent else 2.0


def longer(bent: float, length: float) -> float:
    """Return by what factor an increment may be longer than the largest, as the last one, so long and bent, was."""
    return min(max(float(np.sqrt(ASTRAY * length / bent)), 1.0), LONGEST_STRAIGHT) if bent else 1.0
