"""What makes a part of a wall local: the one definition of limit analysis, macroblocks and finite elements.

A part is local where it has less than a share of the dead load and less than that share of the live load. Either alone
is not enough: a stone of 3 % of the weight that carries half of the live load is what the wall was asked to bear, and
without it the multiplier is one of another load. Where the live load is that of masses the two shares are one.

What moves, or falls, before the wall comes to rest again is one failure. All local ones together take no more than
MOST_LOCAL of either load: else it is the wall that fails.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.basis.arrays import FloatArray

MOST_LOCAL = 0.5
"""share of either load that may fall in local failures, all together: of less than half a wall no multiplier is its
own"""
ROUNDING = 1e-9
"""of a share: a stone of just that share of the wall is none less, in limit analysis as on a mesh"""


@dataclass(frozen=True, slots=True)
class Shares:
    """Parts of the whole wall's dead load and of its live load (magnitudes)."""

    dead: float = 0.0
    live: float = 0.0

    def __add__(self, other: Shares) -> Shares:
        return Shares(self.dead + other.dead, self.live + other.live)

    def __sub__(self, other: Shares) -> Shares:
        return Shares(self.dead - other.dead, self.live - other.live)

    @property
    def larger(self) -> float:
        """The one by which a part is judged."""
        return max(self.dead, self.live)


def taking_part(dead: FloatArray, live: FloatArray, motion: FloatArray) -> Shares:
    """Return the shares of the loads that take part in a motion; dead, live, motion (n,): magnitudes for each block.

    Motion counts over its mean by the dead load, sum W d^2 / sum W d. Of a part that moves alone these are its shares,
    1 where all move alike; where nothing moves no part is singled out.
    """
    squares = float(dead @ motion**2)
    if not squares > 0.0:
        return Shares(1.0, 1.0)
    over_mean = float(dead @ motion) / squares
    of_dead, of_live = (float(load @ motion) * over_mean / float(load.sum()) for load in (dead, live))
    return Shares(of_dead, of_live)


def is_local(share: Shares, gone: Shares, local_share: float) -> bool:
    """Return whether a failure of shares of the loads is local, where those `gone` have fallen before."""
    return share.larger < (1.0 - ROUNDING) * local_share and (gone + share).larger <= MOST_LOCAL


def sizes(forces: FloatArray) -> FloatArray:
    """Return the magnitudes (n,) of forces (n, 2 or more: x, y)."""
    return np.asarray(np.hypot(forces[:, 0], forces[:, 1]))
