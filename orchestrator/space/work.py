"""How much a search in space has worked, counted by its factorisations.

A search ends by their number, never by a clock: its answer is the same on every machine, and beside any other work.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

SECONDS_A_POINT = 3e-6
"""Processor time of a factorisation for each contact point, about: 1.8e-6 to 4.4e-6 of Newton's method, of interior
points and of cone programs, 532 to 6,200 points. From it the number of factorisations that a time stands for."""
SECONDS_EACH = 2e-4
"""What a factorisation of few points takes, about."""


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
    """Return how many factorisations of a wall with so many contact points a time stands for."""
    return seconds / (SECONDS_EACH + SECONDS_A_POINT * points)
