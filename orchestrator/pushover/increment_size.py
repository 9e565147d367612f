"""How increments shrink after a failure and grow after success."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from orchestrator.errors import ConvergenceError
from orchestrator.pushover.state import Attempt, Increment

EASY = 8
"""iterations up to which the next increment may grow"""
FOLLOWED = "followed a snap"
"""what an attempt says that was carried on to the next state of rest"""


@dataclass(frozen=True, slots=True)
class Policy:
    """How increments shrink after a failure and grow after success; smaller than `smallest` is giving up.

    In the unit of the increment: share of gravity, time in s, or mean displacement in m.
    """

    largest: float
    smallest: float
    shrink: float
    grow: float

    def reduced(self, size: float, error: ConvergenceError) -> float:
        """Return the next smaller size. Raises ConvergenceError from `error` below the smallest."""
        smaller = size * self.shrink
        if smaller < self.smallest:
            raise ConvergenceError("stepping", f"no increment above {self.smallest:g} converges ({error})") from error
        return smaller

    def after(self, iterations: int, size: float) -> float:
        """Return the size after an increment that took so many iterations."""
        return min(size * self.grow, self.largest) if iterations <= EASY else size


def snapped(state: Increment) -> bool:
    """Return whether the increment followed a snap; where joints stick and slip in turn, one snap follows another."""
    return bool(state.attempts) and state.attempts[-1].action == FOLLOWED


SolveStep = Callable[[Increment, float], Increment]


def follow(state: Increment, size: float, solve_step: SolveStep, policy: Policy) -> Iterator[Increment]:
    """Yield converged increments for ever; after a failure try again smaller. Raises ConvergenceError at the end."""
    attempts: tuple[Attempt, ...] = ()
    while True:
        try:
            solved = solve_step(state, size)
        except ConvergenceError as error:
            smaller = policy.reduced(size, error)
            attempts += (Attempt(str(error), size, f"retried with {smaller:g}", error.iterations),)
            size = smaller
            continue
        following = policy.after(0 if snapped(solved) else solved.iterations, size)
        state = replace(solved, attempts=attempts + solved.attempts, step=(following, size))
        size, attempts = following, ()
        yield state
