"""Where rigid blocks touch along a joint, and what part of its area each point stands for: Simpson's rule.

Three points are as stiff in rotation as a joint that is pressed all along, and open when the force leaves the middle
third. From there on a joint of mortar is pressed on the rest of its length only, and ever softer; three points are not:
a block of 0.5 x 2 m on mortar of 0.1 N/mm3 would bear 31 % too much. Points that are dense at the ends follow what is
pressed, however short it is: 2.5 % at most (pytest tests/verification/test_soft_joints.py). Stones need no more than
three: how their force spreads from an end is measured with these (stone_compliance.py).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.basis.arrays import FloatArray, read_only


@dataclass(frozen=True, eq=False, slots=True)
class JointPoints:
    """places (p,): between a joint's start, 0, and its end, 1; areas (p,): parts of its area, 1 in all."""

    places: FloatArray
    areas: FloatArray

    @property
    def joint_of_points(self) -> FloatArray:
        """(3, 2p): what forces (n, s at each point) are at the ends and along the joint; its transpose takes rates the
        other way."""
        found = np.zeros((3, 2 * len(self.places)))
        found[0, ::2], found[1, ::2], found[2, 1::2] = 1.0 - self.places, self.places, 1.0
        return found


def simpson(*ends: float) -> JointPoints:
    """Return the points of Simpson's rule on each part of a joint, between `ends`."""
    parts = np.diff(ends)
    places, areas = np.zeros(2 * len(parts) + 1), np.zeros(2 * len(parts) + 1)
    places[::2], places[1::2] = ends, ends[:-1] + 0.5 * parts
    areas[1::2] = 4.0 * parts / 6.0
    areas[:-1:2] += parts / 6.0
    areas[2::2] += parts / 6.0
    return JointPoints(read_only(places), read_only(areas))


OF_STONES = simpson(0.0, 1.0)
"""of a joint that is as stiff as the stones beside it"""
OF_MORTAR = simpson(0.0, 0.05, 0.2, 0.5, 0.8, 0.95, 1.0)
"""of a joint with a stiffness of its own"""
