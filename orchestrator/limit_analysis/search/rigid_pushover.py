"""Pushover curve of rigid blocks in large displacements: equilibrium of blocks where they have come to (P-delta).

The wall is pushed (pushing.py) with joints that move with its blocks. What it bears grows, and falls in the end,
because a mechanism has formed or because blocks have moved too far. A step is solved with joints linearised about some
displacements, and again about those that it found, until gaps, slips and moment arms are true, those of loads too.

Only joints that were drawn touch, in points (joint_points.py) with springs as stiff as the stones beside them (SPREAD)
and their mortar.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.limit_analysis.paper.limit_state import LimitState
from orchestrator.limit_analysis.problem import Problem
from orchestrator.limit_analysis.search.elastic_contact import STIFFNESSES, Position, Stiffness, moving_wall, undeformed
from orchestrator.limit_analysis.search.implicit_step import Step, Task, going_on, implicit_step, missing
from orchestrator.limit_analysis.search.loading_path import StateSearch, is_on_the_verge
from orchestrator.limit_analysis.search.overdamped import REST_BUDGET, Moved
from orchestrator.limit_analysis.search.pushing import DROP

PAST = 0.02
"""Part of its peak by which a curve has fallen where the peak is passed."""
FAR = 0.5
"""Motion of the fastest block since the peak, block lengths (turns times one), where prescribed displacements end, too,
and where the peak is passed; or, if that is less,"""
DRIFT = 1 / 30
"""part of the height of what moves: a wall that bears more only after it has moved so far has failed."""
TRUE = 1e-2
"""Force that gaps and slips may be wrong by in pressed joints, mean block weights."""
PRESSED = 1e-3
"""Normal force of joints that are pressed, mean block weights."""
TURNS = 4
"""Times that a step is solved at most until gaps and slips are true."""
SAME_ARMS = 1e-3
"""Motion since joints were linearised up to which forces act where they did, block lengths."""
LONGEST = 0.02
"""Motion in one step, block lengths."""


@dataclass(frozen=True, eq=False, slots=True)
class RigidPushover:
    """displacement (s,) along the live load in m and multiplier (s,) of the equilibria, from gravity on.

    state: the peak, with the forces there and all the motion from it on, as a last rest that no limit state closed;
    None where the wall bears nothing. ends: the same with the motion in its last step, in which some stones alone may
    fall. is_past: whether what it bears has fallen by PAST since the peak, or blocks have moved far, and do not come to
    rest under a load just above it; else no more is known than that it bears it. counts: the ways out that were needed:
    steps not taken (`turned`, `shorter`, `slower`) or taken after all (`elsewhere`), and loads `held`.
    """

    displacement: FloatArray
    multiplier: FloatArray
    state: LimitState | None
    ends: LimitState | None
    is_past: bool
    factorisations: int
    counts: dict[str, int]

    @property
    def peak(self) -> float:
        """The largest multiplier."""
        return float(self.multiplier.max())

    @property
    def curve(self) -> FloatArray:
        """Displacement in m and multiplier (s, 2)."""
        return read_only(np.column_stack([self.displacement, self.multiplier]))


class DisplacedWallSearch(StateSearch):
    """A wall whose joints and loads move with its blocks."""

    def __init__(self, problem: Problem, stiffness: Stiffness) -> None:
        """Nothing has moved yet."""
        super().__init__(problem, stiffness)
        free = [block.polygon for block in problem.assemblage.wall.blocks if not block.fixed]
        self.far = min(FAR, DRIFT * float(np.ptp(np.vstack(free)[:, 1])) / problem.equilibrium.block_length)
        equilibrium, modulus = problem.equilibrium, problem.elastic_modulus
        self.wall = moving_wall(problem.assemblage, equilibrium, problem.friction, stiffness, modulus)
        self.at_gravity = undeformed(self.wall)
        self.linearise(np.zeros_like(self.wall.problem.dead))

    @property
    def live(self) -> FloatArray:
        """The live load (3m,) where the wall was last linearised."""
        return self.linearised.problem.live

    def moved(self, position: Position) -> float:
        """Return by how much the points where live forces act have moved along them since gravity."""
        assert self.wall.moved_loads is not None
        there, stood = (self.wall.moved_loads.beyond(one.displacements) for one in (position, self.at_gravity))
        return super().moved(position) + (there - stood)

    def motion(self, change: FloatArray) -> float:
        """Return how far the fastest block moves by a change of displacements (3m,), in block lengths."""
        assert self.wall.joints is not None
        return self.wall.joints.largest(change)

    def times_too_long(self, change: FloatArray) -> float:
        """Return how many times longer a change of displacements (3m,) is than a step may be, at least 1."""
        return max(1.0, self.motion(change) / LONGEST)

    def is_lost(self, start: Position, here: Position, change: FloatArray, multiplier: float) -> bool:
        """Whether blocks have moved far."""
        return self.motion(here.displacements - start.displacements) > self.far

    def linearise(self, displacements: FloatArray) -> None:
        """Take joints and loads as they are where blocks have moved by displacements (3m,)."""
        self.linearised, self.about = self.wall.at(displacements), displacements

    def checked(self, position: Position, change: FloatArray, multiplier: float) -> LimitState | None:
        """Return nothing: no state is looked for where blocks have moved."""
        return None

    def is_mechanism(self, here: Moved) -> bool:
        """Return that they do not: where blocks have moved a load does not stand still."""
        return False

    def is_followed(self, here: Moved, peak: Moved) -> bool:
        """Whether the load has not fallen by DROP and blocks have not moved far since the peak, FAR where it falls."""
        far = FAR if here.multiplier < self.too_little(peak) else self.far
        return here.multiplier >= (1.0 - DROP) * peak.multiplier and self.since(peak, here) <= far

    def too_little(self, peak: Moved) -> float:
        """Multiplier below which a wall has passed its peak."""
        return (1.0 - PAST) * peak.multiplier

    def is_past(self, peak: Moved, here: Moved) -> bool:
        """Whether what the wall bears has fallen by PAST since the peak, or blocks have moved far."""
        return here.borne < self.too_little(peak) or self.since(peak, here) > self.far

    def budget_held(self, peak: Moved, last: Moved) -> int:
        """Factorisations for the load held last above a peak: few where the curve has shown a fall."""
        return REST_BUDGET if self.is_past(peak, last) else super().budget_held(peak, last)

    def since(self, peak: Moved, here: Moved) -> float:
        """Return how far the fastest block has moved from one equilibrium to another, in block lengths."""
        return self.motion(here.position.displacements - peak.position.displacements)

    def step(self, before: Position, task: Task, expected: FloatArray) -> Step:
        """Solve one step: with joints as they were linearised last, then about what was found, until that is true."""
        assert self.wall.joints is not None
        there = before.displacements + expected
        if self.motion(there - self.about) > SAME_ARMS:
            self.linearise(there)
        expected, multiplier = going_on(self.linearised, before, task, expected)
        task = replace(task, multiplier=multiplier)
        self.spent += 1
        for _ in range(TURNS):
            found = implicit_step(self.linearised, before, task, expected)
            self.spent += found.factorisations
            if not found.found:
                break
            there = found.position.displacements
            true = self.wall.joints.rates(there)
            if self.is_true(found.position, true, found.multiplier):
                held = task.advance is None and self.goes_back(before, task, there)
                return replace(found, position=replace(found.position, rates=true), found=not held)
            self.linearise(there)
            expected = there - before.displacements
        return replace(found, found=False)

    def goes_back(self, before: Position, task: Task, there: FloatArray) -> bool:
        """Whether blocks that are held by a drag alone move to displacements (3m,) against the force out of balance.

        Loads that add to displacements can have an equilibrium there, but one that the wall falls away from.
        """
        if np.all(self.linearised.loads.restoring(task.multiplier) >= 0.0):
            return False
        lacks = missing(self.linearised, before, task, before.forces, np.zeros_like(there), task.multiplier)
        return float(lacks @ (there - before.displacements)) > 0.0

    def is_true(self, there: Position, true: FloatArray, multiplier: float) -> bool:
        """Whether a position has the gaps and slips (c, 2) of pressed joints that are true there, the moments of loads,
        and moment arms."""
        assert self.wall.moved_loads is not None
        dead, live = self.linearised.loads.at(there.displacements)
        loads = self.wall.moved_loads.linearised(there.displacements)
        if np.abs(loads.dead - dead + multiplier * (loads.live - live)).max() >= TRUE:
            return False
        pressed = (there.forces[:, 0] > PRESSED) | (-self.wall.stiffness[:, 0] * true[:, 0] > PRESSED)
        wrong = np.abs(self.wall.stiffness * (true - there.rates))[pressed].max(initial=0.0)
        return bool(wrong < TRUE) and self.motion(there.displacements - self.about) <= SAME_ARMS


def rigid_pushover(problem: Problem, associative: float, stiffness: Stiffness = STIFFNESSES[0]) -> RigidPushover | None:
    """Push a wall whose joints do not crush in large displacements until it bears no more.

    associative: the multiplier of Eq. (1). Returns None for a wall that does not come to rest under its dead load, or
    not under any live load.
    """
    pushed = DisplacedWallSearch(problem.measured_by_load(associative), stiffness)
    stands = pushed.gravity()
    scale = pushed.wall.problem.per_multiplier
    if not stands.rests or is_on_the_verge(problem, associative):
        return None
    way = pushed.pushed(stands, associative)
    peak = way.peak
    if peak is stands:
        return None
    fall = way.lost.position.displacements - peak.position.displacements

    def moving(change: FloatArray) -> LimitState | None:
        found = pushed.states(peak.position, change, peak.multiplier)
        return replace(found[-1], flow_rule="last_rest", converged=False) if found else None

    return RigidPushover(
        displacement=read_only([pushed.wall.unit * pushed.moved(one.position) for one in way.equilibria]),
        multiplier=read_only([one.multiplier / scale for one in way.equilibria]),
        state=moving(fall if fall.any() else way.lost.change),
        ends=moving(way.lost.change),
        is_past=way.is_lost and any(pushed.is_past(peak, one) for one in (way.equilibria[-1], way.lost)),
        factorisations=pushed.spent,
        counts=dict(pushed.counts),
    )
