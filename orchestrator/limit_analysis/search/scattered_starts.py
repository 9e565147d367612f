"""Lower states from scattered starts: descents from the slips of a state that is known, each joint's times chance.

Smooth starts (lower_states.starts) lead to few states. Of five random walls the elastic pushover of every stone meets
on two one that is 5 and 13 % below all that were found from them (docs/studies/tolerances.md); ten scattered starts
find both, with each of four sequences of random numbers (SPREAD_OF_SLIPS 1 to 3, NEW_SLIP 0.05 to 0.2 alike; 0.01 on
one of them only), in 0.1 to 0.2 s. Starts that have nothing of a known state rarely lead to any.
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import chain, repeat

import numpy as np

from orchestrator.basis.arrays import FloatArray, IntArray
from orchestrator.limit_analysis.search.lower_states import ClosedState, TwoPrograms, descent
from orchestrator.masonry.joints import Assemblage

SPREAD_OF_SLIPS = 2.0
"""Slips are multiplied by exp(SPREAD_OF_SLIPS x a normal variate)."""
NEW_SLIP = 0.05
"""Largest slip of joints that had none, part of the largest slip."""
TURNS_AROUND_A_STATE = 4
"""Of each descent at most: eight find no more, at twice the cost."""
HOPELESS_DESCENTS = (0.3, 3e-2, 3e-3)
"""Power out of balance, relative to the live load's power, above which a descent ends after its first turns: around a
known state, what is far from balance by then reached none in the turns that were left. That spares an eighth of the
turns; half of the first, a third of the second, a tenth of the third each lose the lowest state of one of 110 analyses
(walls of docs/studies up to 300 blocks). Starts that have nothing of a known state may come back from further away."""
SEED_OF_STARTS = 1
"""of the random numbers, so that the same wall has the same starts"""


def scattered_starts(assemblage: Assemblage, slip: FloatArray, count: int) -> Iterator[FloatArray]:
    """Yield `count` slips (k,) >= 0 around known ones (k,), m/s, for a wall in its standard view."""
    random = np.random.default_rng(SEED_OF_STARTS)
    order = _by_place(assemblage)
    for _ in range(count):
        factor, added = np.empty_like(slip), np.empty_like(slip)
        factor[order], added[order] = np.exp(SPREAD_OF_SLIPS * random.normal(size=len(slip))), random.random(len(slip))
        yield np.abs(slip) * factor + NEW_SLIP * np.abs(slip).max() * added


def _by_place(assemblage: Assemblage) -> IntArray:
    """Return the joints from bottom to top, along +x in each course."""
    x, y = np.round(assemblage.joints.centroid, 6).T
    order: IntArray = np.lexsort((x, y))
    return order


def scattered_states(
    other: ThreadPoolExecutor, programs: tuple[TwoPrograms, TwoPrograms], starts: Iterator[FloatArray]
) -> list[ClosedState]:
    """Return all states (some may not balance) of the descents from scattered starts, each (k,) in m/s.

    Descents are independent: this thread and `other` take the next that is left, each with its own programs.
    """
    left = iter(list(enumerate(starts)))
    found: dict[int, list[ClosedState]] = {}

    def take_what_is_left(own: TwoPrograms) -> None:
        found.update((number, list(while_hopeful(descent(own, start, TURNS_AROUND_A_STATE)))) for number, start in left)

    elsewhere = other.submit(take_what_is_left, programs[1])
    take_what_is_left(programs[0])
    elsewhere.result()
    return [state for number in sorted(found) for state in found[number]]


def while_hopeful(states: Iterator[ClosedState]) -> Iterator[ClosedState]:
    """Yield the states of a descent up to the first that is out of balance by too much for its turn."""
    for state, most in zip(states, chain(HOPELESS_DESCENTS, repeat(np.inf)), strict=False):
        yield state
        if state.imbalance > most:
            return
