"""Motion of a wall of rigid blocks on elastic joints against a drag, slow enough for its way not to matter.

Backward Euler steps (implicit_step.py) under a held load, the drag smaller after each that was found, until the wall
rests, or moves like a mechanism. The blocks may be stones or bodies of several stones.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.limit_analysis.paper.limit_state import LimitState
from orchestrator.limit_analysis.search.elastic_contact import ElasticWall, Position, undeformed
from orchestrator.limit_analysis.search.implicit_step import Step, Task, implicit_step

REST = 1e-6
"""Force that drag takes, mean block weights, below which a wall rests."""
GRAVITY_DRAG, FIRST_DRAG, MOST_DRAG = 1.0, 1e-4, 1e4
"""Force per displacement, mean block weights over elastic displacement: where gravity and a load step begin, and where
it is given up."""
SLOWER, FASTER = 4.0, ((11, 0.1), (13, 0.3))
"""Factor on the drag after a step that was not found; and after one that took at most so many factorisations."""
LAGGED_STEPS, LAGGED_DRAG, STIFFER, STEADY = 4, 0.5, 64.0, 1e-4
"""Steps at the friction of the step before after one that is not found, the factor on the drag after each; the factor
where they did not help; and the change of a normal force (mean block weights) at which they end."""
MOTION, NEARLY = 1e-3, 1e-2
"""Flow errors: of a motion that is that of a mechanism; and of one that has gone FAR."""
REST_BUDGET, GRAVITY_BUDGET, BUDGET, SMALLEST_BUDGET, MOST_IN_ALL = 400, 800, 1_000_000, 1500, 6_000
"""Factorisations: of a rest, of gravity; in all, times blocks, and in all at least and at most."""
FAR = 100.0
"""Displacement over the elastic one from which on a motion whose forces nearly stand still is not followed further."""


@dataclass(frozen=True, eq=False, slots=True)
class Moved:
    """Where a motion has led: position, last change of displacements (3m,), multiplier, flow error, whether at rest.

    state: the limit state that it came to, where one was looked for and passes the check.
    """

    position: Position
    change: FloatArray
    multiplier: float
    flow: float
    rests: bool
    state: LimitState | None = None


class Overdamped:
    """The motions of one wall against a drag, and the factorisations that they have taken."""

    def __init__(self, wall: ElasticWall) -> None:
        """Nothing has moved yet."""
        self.wall = wall
        blocks = len(wall.problem.dead) // 3
        self.spent, self.most = 0, int(np.clip(BUDGET / blocks, SMALLEST_BUDGET, MOST_IN_ALL))
        self.at_gravity = undeformed(self.wall)
        self.elastic = np.inf  # live displacement of the first load step over its multiplier

    @property
    def is_spent(self) -> bool:
        """Whether no factorisations are left."""
        return self.spent >= self.most

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

    def rest(self, position: Position, multiplier: float, drag: float, budget: int) -> Moved:
        """Move from a position under a load until the wall rests, or moves as a mechanism, or the budget is spent.

        A step of Coulomb's friction need not have a solution that is found. With the friction that the normal forces of
        the step before allow it is a convex program, and has one: a few such steps lead to where the other is found
        again. Only steps of Coulomb's friction end in a rest.
        """
        live, end = self.wall.problem.live, min(self.spent + budget, self.most)
        change, velocity, flow = np.zeros_like(position.displacements), np.zeros_like(position.displacements), np.inf
        lagged = failures = 0
        while self.spent < end and drag < MOST_DRAG:
            found = self.step(position, Task(multiplier, drag, lagged=lagged > 0), velocity / drag)
            if not found.found and lagged:
                drag, lagged = SLOWER * drag, lagged - 1
                continue
            if not found.found:
                lagged, failures = LAGGED_STEPS, failures + 1
                drag *= 1.0 if failures == 1 else STIFFER
                continue
            change = found.position.displacements - position.displacements
            flow = self.flow(found.position, position, multiplier * float(live @ change))
            steady = np.abs(found.position.forces[:, 0] - position.forces[:, 0]).max() < STEADY
            position, velocity = found.position, drag * change
            if lagged:
                drag, lagged = LAGGED_DRAG * drag, 0 if steady else lagged - 1
                continue
            failures = 0
            if np.abs(velocity).max() < REST:
                return Moved(position, change, multiplier, flow, True)
            if live @ change > 1.0 and flow < (NEARLY if self.is_further(FAR, position, multiplier) else MOTION):
                break
            drag *= next((factor for most, factor in FASTER if found.effort <= most), 1.2)
        return Moved(position, change, multiplier, flow, False)

    def gravity(self) -> Moved:
        """Move from the wall as drawn under its dead load; displacements count from the rest it comes to."""
        stands = self.rest(undeformed(self.wall), 0.0, GRAVITY_DRAG, GRAVITY_BUDGET)
        self.at_gravity = stands.position
        return stands

    def flow(self, there: Position, here: Position, live_power: float) -> float:
        """Return the flow error of what changed between two positions."""
        return self.wall.flow_error(there.forces, there.rates - here.rates, live_power)
