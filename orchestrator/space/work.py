"""How much a search in space has worked, counted by its factorisations.

A search ends by their number, never by a clock: its answer is the same on every machine, and beside any other work.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

SECONDS_EACH = 2e-4
"""What a factorisation of few contact points takes, about."""
SECONDS_A_POINT = 4.4e-7
"""Times the contact points to the power GROWTH, what one takes besides: of Newton's method, of interior points and of
cone programs alike, to a factor of 1.5, with 532 to 23,000 points on a core of 2026."""
GROWTH = 1.25
"""of a factorisation with the contact points"""


@dataclass(slots=True)
class Work:
    """Factorisations so far, and up to how many what is being done may go on."""

    done: int = 0
    until: float = inf

    @property
    def left(self) -> float:
        """Factorisations that are left, not positive where there are none."""
        return self.until - self.done


def factorisations_in(seconds: float, points: int) -> float:
    """Return how many factorisations of a wall with so many contact points take so long, about."""
    return seconds / (SECONDS_EACH + SECONDS_A_POINT * points**GROWTH)
