"""Pushover curve of rigid blocks in large displacements: equilibrium of blocks where they have come to (P-delta).

From a first rest under a small load on, displacements along the live load are prescribed: each step is an equilibrium,
with the load as its unknown. Joints open, close and slide on the way; what the wall bears grows, and falls in the end,
because a mechanism has formed or because blocks have moved too far. A step is solved with joints linearised about some
displacements, and again about those that it found, until gaps, slips and moment arms are true. Where the load has
fallen by DROP or blocks have moved FAR since the peak, or no further equilibrium is found (the wall snaps back), the
load of the peak is held, and a little more: where the wall then comes to rest it is pushed on from there, against a
drag, slowly (backward Euler); where it does not, the curve has its peak.

Only joints that were drawn touch, in three points each, with springs as stiff as the stones beside them (SPREAD).
Sources: path following by a displacement, and overdamped motion as a substitute for dynamics after a snap, are common;
own combination.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.limit_analysis.paper.limit_state import LimitState
from orchestrator.limit_analysis.problem import Problem
from orchestrator.limit_analysis.search.elastic_contact import STIFFNESSES, Position, Stiffness, with_joints_that_move
from orchestrator.limit_analysis.search.implicit_step import Step, Task, implicit_step
from orchestrator.limit_analysis.search.loading_path import FAILURES, LEAST, STEPS, StateSearch
from orchestrator.limit_analysis.search.overdamped import FIRST_DRAG, REST_BUDGET, Moved

FIRST_LOADS = (1.0, 0.1, 0.01)
"""Parts of a load step under which a first rest is looked for."""
HELD = 1e-3
"""Part of the associative multiplier that is added to the load of the peak when it is held."""
PAST, DROP, FAR = 0.02, 0.2, 0.5
"""Parts of its peak by which a curve has fallen where the peak is passed, and where prescribed displacements end; and
motion of the fastest block since the peak, block lengths (turns times one), where they end, too."""
TRUE, PRESSED, TURNS = 1e-2, 1e-3, 4
"""Force that gaps and slips may be wrong by, mean block weights, in joints that carry PRESSED; and how often a step is
solved at most until they are true."""
SAME_ARMS, LONGEST = 1e-3, 0.02
"""Motion, block lengths: since joints were linearised, up to which forces act where they did; and in one step."""
GROWTH, SHORTER, TURNED = 2.0, 0.3, 0.3
"""Growth of the displacement prescribed after each step at most; factor after one that was not found or not taken; and
part of its change of displacements by which a step longer than the elastic displacement may differ from the step before
to be taken: where several solutions exist, another path begins there."""


@dataclass(frozen=True, eq=False, slots=True)
class RigidPushover:
    """displacement (s,) along the live load in m and multiplier (s,) of the equilibria, from gravity on.

    state: the peak, with the forces there and the motion after it, as a last rest that no limit state closed; None
    where the wall bears nothing. is_past: whether the load has fallen by PAST since the peak, or blocks have moved FAR,
    and do not come to rest under a load just above it; else no more is known than that the wall bears it. counts: the
    ways out that were needed, steps `turned` and `shorter`, loads `held`, friction `lagged`.
    """

    displacement: FloatArray
    multiplier: FloatArray
    state: LimitState | None
    is_past: bool
    factorisations: int
    counts: dict[str, int]

    @property
    def peak(self) -> float:
        """The largest multiplier."""
        return float(self.multiplier.max())


class Pushed(StateSearch):
    """A wall whose joints move with its blocks."""

    def __init__(self, problem: Problem, stiffness: Stiffness) -> None:
        """Nothing has moved yet."""
        super().__init__(problem, stiffness)
        self.wall = with_joints_that_move(self.wall, problem.assemblage, problem.equilibrium)
        self.linearise(np.zeros_like(self.wall.problem.dead))

    @property
    def is_over(self) -> bool:
        """Whether no factorisations are left but those for the load that is held above the peak."""
        return self.spent >= self.most - REST_BUDGET

    def motion(self, change: FloatArray) -> float:
        """Return how far the fastest block moves by a change of displacements (3m,), in block lengths."""
        assert self.wall.joints is not None
        return self.wall.joints.largest(change)

    def times_too_long(self, change: FloatArray) -> float:
        """Return how many times longer a change of displacements (3m,) is than a step may be, at least 1."""
        return max(1.0, self.motion(change) / LONGEST)

    def is_lost(self, start: Position, here: Position, change: FloatArray, multiplier: float, flow: float) -> bool:
        """Whether blocks have moved FAR."""
        return self.motion(here.displacements - start.displacements) > FAR

    def linearise(self, displacements: FloatArray) -> None:
        """Take joints as they stand where blocks have moved by displacements (3m,)."""
        self.linearised, self.about = self.wall.at(displacements), displacements

    def step(self, before: Position, task: Task, expected: FloatArray) -> Step:
        """Solve one step: with joints as they were linearised last, then about what was found, until that is true."""
        assert self.wall.joints is not None
        for _ in range(TURNS):
            found = implicit_step(self.linearised, before, task, expected)
            self.spent += found.factorisations
            there = found.position
            if not found.found:
                return found
            true = self.wall.joints.rates(there.displacements)
            if self.is_true(there, true):
                return replace(found, position=replace(there, rates=true))
            self.linearise(there.displacements)
            expected = there.displacements - before.displacements
        return replace(found, found=False)

    def is_true(self, there: Position, true: FloatArray) -> bool:
        """Whether a position has the gaps and slips (c, 2) of pressed joints that are true there, and moment arms."""
        pressed = (there.forces[:, 0] > PRESSED) | (-self.wall.stiffness[:, 0] * true[:, 0] > PRESSED)
        wrong = np.abs(self.wall.stiffness * (true - there.rates))[pressed].max(initial=0.0)
        return bool(wrong < TRUE) and self.motion(there.displacements - self.about) <= SAME_ARMS

    def followed(self, rest: Moved, load_step: float) -> Iterator[Moved]:
        """Yield equilibria under prescribed displacements, until none is found or the budget is spent.

        rest: its `change` says which way, and how far at first. load_step: by which the load is to change at most.
        """
        live, here, failures = self.wall.problem.live, rest, 0
        advance = float(live @ rest.change)
        while not self.is_over and failures < FAILURES:
            expected = here.change * (advance / float(live @ here.change))
            shorter = self.times_too_long(expected)
            advance, expected = advance / shorter, expected / shorter
            found = self.step(here.position, Task(here.multiplier, 0.0, advance), expected)
            change = found.position.displacements - here.position.displacements
            turned = np.abs(change - expected).max() > TURNED * np.abs(change).max()
            if not found.found or (turned and advance > self.elastic * here.multiplier):
                failures += not found.found
                self.counts["turned" if found.found else "shorter"] += 1
                advance *= SHORTER
                continue
            grown, failures = abs(found.multiplier - here.multiplier), 0
            here = Moved(found.position, change, found.multiplier, np.inf, True)
            advance *= min(GROWTH, load_step / max(grown, 1e-3 * load_step))
            yield here

    def first_rest(self, stands: Moved, load_step: float) -> Moved:
        """Return a rest under a load up to a step, with all its displacement; the last motion where there is none."""
        for part in FIRST_LOADS:
            found = self.rest(stands.position, part * load_step, FIRST_DRAG, REST_BUDGET)
            if found.rests:
                return replace(found, change=found.position.displacements - stands.position.displacements)
        return found

    def pushed(self, stands: Moved, associative: float) -> tuple[list[Moved], Moved, bool]:
        """Push the wall from its rest under the dead load; return its equilibria, the motion after them, and whether
        the peak is past."""
        scale, path = self.wall.problem.per_multiplier, [stands]
        load_step = scale * associative / STEPS
        first, is_past = self.first_rest(stands, load_step), False
        rest = first
        while rest.rests and not self.is_over:
            path.append(rest)
            self.elastic = min(self.elastic, self.moved(rest.position) / rest.multiplier)
            peak, is_past = rest, False
            for here in self.followed(replace(rest, change=first.change), load_step):
                path.append(here)
                peak = here if here.multiplier > peak.multiplier else peak
                gone = self.motion(here.position.displacements - peak.position.displacements)
                is_past = here.multiplier < (1.0 - PAST) * peak.multiplier or gone > FAR
                if here.multiplier < (1.0 - DROP) * peak.multiplier or gone > FAR:
                    break
            self.counts["held"] += 1
            load = peak.multiplier + HELD * scale * associative
            rest = self.rest(peak.position, load, FIRST_DRAG, REST_BUDGET)
        return path, rest, is_past and not rest.rests


def rigid_pushover(problem: Problem, associative: float, stiffness: Stiffness = STIFFNESSES[0]) -> RigidPushover | None:
    """Push a wall whose joints do not crush in large displacements until it bears no more.

    associative: the multiplier of Eq. (1). Returns None for a wall that does not come to rest under its dead load, or
    not under any live load.
    """
    pushed = Pushed(problem, stiffness)
    stands = pushed.gravity()
    scale = pushed.wall.problem.per_multiplier
    if not stands.rests or scale * associative < LEAST:
        return None
    path, lost, is_past = pushed.pushed(stands, associative)
    peak = max(path, key=lambda one: one.multiplier)
    if peak is stands:
        return None
    found = pushed.states(peak.position, lost.change, peak.multiplier)
    return RigidPushover(
        displacement=read_only([pushed.wall.unit * pushed.moved(one.position) for one in path]),
        multiplier=read_only([one.multiplier / scale for one in path]),
        state=replace(found[-1], flow_rule="last_rest", converged=False) if found else None,
        is_past=is_past,
        factorisations=pushed.spent,
        counts=dict(pushed.counts),
    )
