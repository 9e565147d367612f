"""Motion of a wall of rigid blocks on elastic joints against a drag, slow enough for its way not to matter.

Backward Euler steps (implicit_step.py) under a held load, the drag smaller after each that was found, until the wall
rests, or has moved far. The blocks may be stones or bodies of several stones.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.limit_analysis.paper.limit_state import LimitState
from orchestrator.limit_analysis.search.elastic_contact import ElasticWall, Position, undeformed
from orchestrator.limit_analysis.search.implicit_step import Step, Task, implicit_step

REST = 1e-6
"""Force that drag takes, mean block weights, below which a wall rests."""
GRAVITY_DRAG = 1.0
"""Drag with which gravity begins: force per displacement, mean block weights over elastic displacement."""
FIRST_DRAG = 1e-4
"""Drag with which a held load begins."""
MOST_DRAG = 1e4
"""Drag at which a motion is given up."""
SLOWER = 4.0
"""Factor on the drag after a step that was not found."""
EASY = 11
"""Factorisations of a step at most after which the drag falls by EASIER."""
EASIER = 0.1
"""Factor on the drag after an easy step."""
HARDER = 1.2
"""Factor on the drag after any other step that was found."""
LOST = 1e3
"""Displacement over the elastic one from which on no motion is followed."""
FALLEN = 1e12
"""Displacement, in elastic ones of a mean block's weight, beyond which no digit is left for what is elastic."""
REST_BUDGET = 600
"""Factorisations of a rest; the load that is held last has all that are left."""
GRAVITY_BUDGET = 800
"""Factorisations of gravity."""
BUDGET = 12_000_000
"""Factorisations in all, times blocks."""
SMALLEST_BUDGET = 1500
"""Factorisations in all at least, however many blocks."""
MOST_IN_ALL = 12_000
"""Factorisations in all at most, however few blocks."""


@dataclass(frozen=True, eq=False, slots=True)
class Moved:
    """Where a motion has led: position, last change of displacements (3m,), multiplier, flow error, whether at rest.

    state: the limit state that it came to, where one was looked for and passes the check. taken: the part of the live
    load that the drag takes, by work, on the last change, of a wall that has gone on bearing too little: it bears the
    rest of it there. Else 0.
    """

    position: Position
    change: FloatArray
    multiplier: float
    flow: float
    rests: bool
    state: LimitState | None = None
    taken: float = 0.0

    @property
    def borne(self) -> float:
        """The multiplier that the wall bears where it is."""
        return (1.0 - self.taken) * self.multiplier


class Overdamped:
    """The motions of one wall against a drag, and the factorisations that they have taken.

    counts: how often which way out was needed, such as `slower`, a larger drag after a step that was not found.
    """

    def __init__(self, wall: ElasticWall) -> None:
        """Nothing has moved yet."""
        self.wall = wall
        blocks = len(wall.problem.dead) // 3
        self.spent, self.most = 0, int(np.clip(BUDGET / blocks, SMALLEST_BUDGET, MOST_IN_ALL))
        self.at_gravity = undeformed(self.wall)
        self.counts = Counter[str]()
        self.elastic = np.inf  # live displacement of the first load step over its multiplier

    @property
    def is_spent(self) -> bool:
        """Whether no factorisations are left."""
        return self.spent >= self.most

    @property
    def live(self) -> FloatArray:
        """The live load (3m,) where the wall was last looked at."""
        return self.wall.problem.live

    def moved(self, position: Position) -> float:
        """Return the displacement along the live load since gravity."""
        return float(self.wall.problem.live @ (position.displacements - self.at_gravity.displacements))

    def is_further(self, times: float, position: Position, multiplier: float) -> bool:
        """Whether the wall has moved more than so many times its elastic displacement."""
        return self.moved(position) > times * self.elastic * multiplier

    def step(self, before: Position, task: Task, expected: FloatArray) -> Step:
        """Solve one step and count it."""
        found = implicit_step(self.wall, before, task, expected)
        self.spent += found.factorisations
        return found

    def rest(
        self, position: Position, multiplier: float, drag: float, budget: int, too_little: float = -np.inf
    ) -> Moved:
        """Move from a position under a load until the wall rests, or has moved far, or the budget is spent.

        A step that is not found is tried again against a larger drag, which then stays for the next one. A wall that
        goes on bearing less than the multiplier `too_little` is followed for REST_BUDGET factorisations.
        """
        start, end = position, min(self.spent + budget, self.most)
        change, velocity, flow = np.zeros_like(position.displacements), np.zeros_like(position.displacements), np.inf
        slower, taken, fell = False, 0.0, np.inf
        while self.spent < min(end, fell + REST_BUDGET) and drag < MOST_DRAG:
            drag *= self.times_too_long(velocity / drag)
            found = self.step(position, Task(multiplier, drag), velocity / drag)
            if not found.found:
                drag, slower = SLOWER * drag, True
                self.counts["slower"] += 1
                continue
            change = found.position.displacements - position.displacements
            flow = self.flow(found.position, position, multiplier * float(self.wall.problem.live @ change))
            position, velocity = found.position, drag * change
            if np.abs(velocity).max() < REST:
                return Moved(position, change, multiplier, flow, True)
            taken = self.taken(velocity, change, multiplier)
            fell = min(fell, self.spent) if (1.0 - taken) * multiplier < too_little else np.inf
            if np.abs(change).max() > FALLEN or self.is_lost(start, position, change, multiplier):
                break
            if not slower:
                drag *= EASIER if found.effort <= EASY else HARDER
            slower = False
        goes_on = self.spent >= fell + REST_BUDGET
        return Moved(position, change, multiplier, flow, False, taken=taken if goes_on else 0.0)

    def taken(self, drag_force: FloatArray, change: FloatArray, multiplier: float) -> float:
        """Return the part of the live load that a drag's force (3m,) takes on a change of displacements (3m,), by work;
        0 where it takes more than the live load does: stones go down then."""
        live_work, work = multiplier * float(self.live @ change), float(drag_force @ change)
        return work / live_work if work < live_work else 0.0

    def times_too_long(self, change: FloatArray) -> float:
        """Return how many times longer a change of displacements (3m,) is than a step may be, at least 1."""
        return 1.0

    def is_lost(self, start: Position, here: Position, change: FloatArray, multiplier: float) -> bool:
        """Whether a motion from `start` under a multiplier is not followed any further; change: the last one."""
        return float(self.wall.problem.live @ change) > 1.0 and self.is_further(LOST, here, multiplier)

    def gravity(self) -> Moved:
        """Move from the wall as drawn under its dead load; displacements count from the rest it comes to."""
        stands = self.rest(undeformed(self.wall), 0.0, GRAVITY_DRAG, GRAVITY_BUDGET)
        self.at_gravity = stands.position
        return stands

    def flow(self, there: Position, here: Position, live_power: float) -> float:
        """Return the flow error of what changed between two positions."""
        return self.wall.flow_error(there.forces, there.rates - here.rates, live_power)
