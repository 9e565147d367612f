"""An increment that is tried, and tried again: smaller, or from another state."""

from __future__ import annotations

from dataclasses import dataclass, replace

from orchestrator.pushover.increments import Attempt, Increment

SHRINK = 0.25
"""an increment that is tried again is smaller by this factor"""


@dataclass(frozen=True, slots=True)
class Trial:
    """An increment to be tried from a state: its size in the unit of the phase, how often it was made smaller (`cuts`),
    and the attempts before it."""

    state: Increment
    size: float
    cuts: int = 0
    attempts: tuple[Attempt, ...] = ()

    def after(self, *rows: Increment) -> Trial:
        """Return the same trial with the attempts of increments that were solved in it, whatever becomes of them."""
        return replace(self, attempts=self.attempts + tuple(attempt for row in rows for attempt in row.attempts))

    def then(self, why: str, action: str, iterations: int, state: Increment | None = None) -> Trial:
        """Return the next trial after this one failed: from the same state, or anew from another one."""
        attempts = (*self.attempts, Attempt(why, self.size, action, iterations))
        return Trial(state or self.state, self.size, 0 if state else self.cuts, attempts)

    def smaller(self, why: str, iterations: int) -> Trial:
        """Return the next trial after this one failed: from the same state with a smaller increment."""
        size = SHRINK * self.size
        return replace(self.then(why, f"retried with {size:g}", iterations), size=size, cuts=self.cuts + 1)
