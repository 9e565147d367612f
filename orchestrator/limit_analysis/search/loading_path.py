"""The path of a wall under a growing live load: rigid blocks on elastic joints, from gravity to what it cannot bear.

The load grows in steps. Where the wall does not balance it moves against a drag, slowly (backward Euler), until it
rests again, however far that is: joints open, close and slide on the way, and a wall that was only rearranging itself
stands. Where that takes long displacements are prescribed instead of the load: either the wall comes to bear more, or
it moves ever more like a mechanism: forces stand still, openings have no force, slips no dilation. That is a limit
state, checked as it stands (validation.py), the one that loading leads to; or one near it is (nearest_state.py). A
load step in which neither is found was too large, and is halved.

Two multipliers come of it: the last at which the wall rests, and that of the state. They are one to FINE unless the
mechanism loses strength when it comes loose (a wedged stone): then the state lies below the last rest.
Displacements are small: joints keep their directions. `soft_from` says from which multiplier on the wall moved further
than SOFT times its elastic displacement; beyond it geometry decides, and only finite displacements tell.
Sources: overdamped motion as a substitute for dynamics after a loss of equilibrium; own combination.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.basis.errors import ConvergenceError
from orchestrator.limit_analysis.paper.limit_state import LimitState, LinearProgramRecord
from orchestrator.limit_analysis.paper.linear_program import LimitSolution
from orchestrator.limit_analysis.problem import Problem
from orchestrator.limit_analysis.search.elastic_contact import (
    JOINT_SMOOTHING,
    STIFFNESSES,
    Position,
    Stiffness,
    elastic_wall,
)
from orchestrator.limit_analysis.search.implicit_step import Task
from orchestrator.limit_analysis.search.nearest_state import Closing
from orchestrator.limit_analysis.search.overdamped import (
    FAR,
    FIRST_DRAG,
    MOTION,
    NEARLY,
    REST_BUDGET,
    Moved,
    Overdamped,
)

STEPS = 10
"""Load steps up to the associative multiplier."""
FINE, COARSE = 1e-3, 1e-2
"""Bracket, part of the associative multiplier, between the last rest and the state met; and that of a wall that creeps
without coming near a mechanism, or below a state that is closed and met twice: what it rests at is no sharper."""
CLOSE, END_BUDGET = 1e-5, 150
"""Flow error of an end that is worth checking, and factorisations of an end."""
GROWTH, LEAST_ADVANCE = ((9, 3.0), (np.inf, 1.7)), 0.3
"""Growth of the displacement prescribed after a step of so many factorisations, 10 instead of 3 once forces nearly
stand still (CLOSE); factor after one that was not found."""
FAILURES = 8
"""Steps in a row that are not found before an end is given up."""
LEAST = 1e-6
"""Live load, mean block weights, at the associative multiplier of a wall that is not on the verge of falling anyway."""
SOFT, FARTHEST = 10.0, 1e5
"""Displacement over the elastic one from which on a wall is called soft; and from which on a mechanism is not followed
any further."""


@dataclass(frozen=True, eq=False, slots=True)
class LoadPath:
    """What growing load does to a wall.

    multipliers (r,): loads at which it rests, the first 0; displacements (r,): along the live load, over the elastic
    one of the same multiplier (1 for the first); forces: of the joints (k, 3) in N at each of them. `last_rest` is the
    last of these; `state` what is met there, `converged` where the check passes, else the last rest with the mechanism
    that fits best.
    soft_from: multiplier from which on displacements exceed SOFT, None if they never do. not_at_rest: the
    lowest load at which no rest was found; given_up: whether the budget ended before the two were FINE apart.
    """

    multipliers: FloatArray
    displacements: FloatArray
    forces: tuple[FloatArray, ...]
    state: LimitState | None
    factorisations: int
    seconds: float
    not_at_rest: float = np.inf
    given_up: bool = False

    @property
    def last_rest(self) -> float:
        """Largest multiplier at which the wall was found at rest."""
        return float(self.multipliers[-1])

    @property
    def soft_from(self) -> float | None:
        """Multiplier from which on the wall moved further than SOFT times its elastic displacement."""
        soft = np.flatnonzero(self.displacements > SOFT)
        return float(self.multipliers[soft[0]]) if len(soft) else None


class Loading(Overdamped):
    """The motions of one wall, each followed to a limit state where it comes to one."""

    def __init__(self, problem: Problem, stiffness: Stiffness) -> None:
        """Nothing has moved yet."""
        super().__init__(elastic_wall(problem.assemblage, problem.equilibrium, problem.friction, stiffness))
        self.problem = problem
        self.closing = Closing(problem, self.wall.stiffness)

    def bears_more(self, ended: Moved, moved: Moved) -> bool:
        """Whether a wall that did not rest carries more than its load before it has become soft."""
        return ended.multiplier > moved.multiplier and not self.is_further(SOFT, ended.position, ended.multiplier)

    def end(self, moved: Moved, while_weaker: bool = False) -> Moved:
        """Drive a motion that is NEARLY a mechanism on by displacements until forces stand still.

        The `state` of what is returned passes the check, or is None; its flow is inf where nothing was driven.

        while_weaker: only until the wall bears more than the load under which it did not rest.
        """
        live, position, change = self.wall.problem.live, moved.position, moved.change
        advance, failures, end = float(live @ change), 0, min(self.spent + END_BUDGET, self.most)
        best = replace(moved, flow=np.inf)
        multiplier = moved.multiplier
        while advance > 0 and self.spent < end and failures < FAILURES:
            expected = change * (advance / float(live @ change))
            found = self.step(position, Task(multiplier, 0.0, advance), expected)
            if not found.found:
                if best.flow < MOTION and self.is_further(FAR, position, multiplier):
                    break
                advance, failures = LEAST_ADVANCE * advance, failures + 1
                continue
            change = found.position.displacements - position.displacements
            flow = self.flow(found.position, position, found.multiplier * advance)
            position, multiplier, failures = found.position, found.multiplier, 0
            if flow <= 2.0 * best.flow:
                best = Moved(position, change, multiplier, flow, False)
            if while_weaker and self.bears_more(Moved(position, change, multiplier, flow, False), moved):
                return Moved(position, change, multiplier, flow, False)
            if flow < CLOSE and (state := self.checked(position, change, multiplier)) is not None:
                return replace(best, state=state)
            if flow < MOTION and self.is_further(FARTHEST, position, multiplier):
                break
            growth = next(factor for most, factor in GROWTH if found.effort <= most)
            advance *= 10.0 if growth == 3.0 and flow < CLOSE else growth
        return best

    def closed(self, lost: Moved, ended: Moved, low: float, high: float, fine: float) -> Moved | None:
        """Return the state that a motion came to, or one near it (nearest_state.py), between its multipliers or by
        `fine` beyond; else the motion if it is NEARLY one."""
        if ended.state is not None:
            return ended
        scale = self.wall.problem.per_multiplier
        driven = ended if np.isfinite(ended.flow) else lost
        there = driven.multiplier / scale
        state = self.states(driven.position, driven.change, driven.multiplier)[0]
        found = self.closing.near(state, state.mechanism.slip, min(low, there) - fine, max(high, there) + fine)
        if found is not None:
            return replace(driven, multiplier=scale * found.load_multiplier, state=found)
        return ended if ended.flow <= NEARLY else None

    def checked(self, position: Position, change: FloatArray, multiplier: float) -> LimitState | None:
        """Return forces with the mechanism that fits them best, or else with their motion, if that passes the check."""
        for state in self.states(position, change, multiplier):
            if not self.problem.complaints(state):
                return state
        return None

    def states(self, position: Position, change: FloatArray, multiplier: float) -> list[LimitState]:
        """Return forces with the best mechanism for their normal forces, and with their own motion where it goes along
        with the live load."""
        equilibrium = self.problem.equilibrium
        along = float(self.wall.problem.live @ change)
        open_ends = self.wall.stiffness[:, :2] * position.rates[:, :2] > JOINT_SMOOTHING
        velocities = equilibrium.row_scale * change / (equilibrium.live_total * (along if along > 0 else 1.0))
        forces = equilibrium.mean_weight * position.forces
        own = LimitSolution(
            multiplier / self.wall.problem.per_multiplier, forces, velocities,
            equilibrium.joint_rates(velocities), self.spent, 0.0, "path",
        )  # fmt: skip
        found = [own] if along > 0 else []
        try:
            mechanism = self.closing.programs.mechanism(own.normal)
            found.insert(0, replace(own, velocities=mechanism.velocities, rates=mechanism.rates))
        except ConvergenceError:
            pass
        records = (LinearProgramRecord(own.load_multiplier, 0.0, self.spent, 0.0, "path"),)
        states = [self.problem.state("path", self.problem.no_dilatancy, own, with_, records) for with_ in found]
        return [
            replace(one, open_ends=read_only(open_ends, np.bool_)) if with_ is own else one
            for one, with_ in zip(states, found, strict=True)
        ]


def load_path(problem: Problem, associative: float, stiffness: Stiffness = STIFFNESSES[0]) -> LoadPath | None:
    """Load a wall whose joints do not crush from gravity until it does not rest any more.

    associative: the multiplier of Eq. (1), which no state exceeds. Returns None for a wall that does not come to rest
    under its dead load.
    """
    started = perf_counter()
    loading = Loading(problem, stiffness)
    scale, live = loading.wall.problem.per_multiplier, loading.wall.problem.live
    stands = loading.gravity()
    if not stands.rests:
        return None
    if scale * associative < LEAST:
        return LoadPath(read_only([0.0]), read_only([1.0]), (), None, loading.spent, perf_counter() - started)
    position = stands.position
    rests = [(0.0, 0.0, position.forces)]
    met: Moved | None = None
    lost: Moved | None = None
    low, high, fine = 0.0, np.inf, FINE * associative
    enough = fine
    target = step = associative / STEPS
    while high - low > enough and not loading.is_spent:
        found, ended = _led_to(loading, position, scale * target)
        if found.rests:
            position, low = found.position, target
            rests.append((target, loading.moved(position), position.forces))
            if len(rests) == 2:
                loading.elastic = loading.moved(position) / (scale * target)
            if met is not None and met.multiplier / scale - low <= enough:
                break
            step = min(2.0 * step, associative / STEPS)
            target = next_load(low, high, associative, step)
            continue
        closed = loading.closed(found, ended, low, target, fine)
        if closed is None and np.isinf(ended.flow) and target - low > 2.0 * fine:
            step = 0.5 * (target - low)  # neither a rest nor a motion was found in so large a step
            target = low + step
            continue
        lost, high, before = found, target, met
        if closed is not None and (met is None or met.state is None or closed.state is not None):
            met = closed
        if met is not None and met.multiplier > scale * (high + COARSE * associative):
            met = None
        again = met is not None and before is not None and abs(met.multiplier - before.multiplier) <= scale * fine
        if met is None or (again and met.state is not None):
            enough = COARSE * associative
        if met is not None and 0.0 <= met.multiplier / scale - low <= enough:
            break
        ends = met if met is not None and not again else ended
        target = load_below(ends.multiplier / scale if np.isfinite(ends.flow) else np.inf, low, high, fine)
    state = None if met is None else met.state
    if state is None or not state.converged:
        last = loading.states(position, np.zeros_like(live) if lost is None else lost.change, scale * low)
        state = replace(last[0], flow_rule="last_rest", converged=False) if last and low > 0 else None
    return LoadPath(
        multipliers=read_only([multiplier for multiplier, _, _ in rests]),
        displacements=read_only([1.0, *(moved / (scale * at * loading.elastic) for at, moved, _ in rests[1:])]),
        forces=tuple(read_only(problem.equilibrium.mean_weight * each) for _, _, each in rests),
        state=state,
        factorisations=loading.spent,
        seconds=perf_counter() - started,
        not_at_rest=high,
        given_up=loading.is_spent and high - low > enough,
    )


def _led_to(loading: Loading, position: Position, load: float) -> tuple[Moved, Moved]:
    """Return where a load (scaled) leads from a rest, and where a motion that does not rest ends."""
    found = ended = loading.rest(position, load, FIRST_DRAG, REST_BUDGET)
    if not found.rests:
        ended = loading.end(found, while_weaker=True)
        if np.isfinite(ended.flow) and loading.bears_more(ended, found):
            found = loading.rest(ended.position, load, FIRST_DRAG, REST_BUDGET)
            ended = ended if found.rests else loading.end(found)
    return found, ended


def next_load(low: float, high: float, associative: float, step: float) -> float:
    """Return the next multiplier after a rest at `low`: half a step where a whole one would end at the associative
    one, where hardly any wall rests."""
    return min(low + (step if low + 1.5 * step < associative else 0.5 * step), 0.5 * (low + high))


def load_below(multiplier: float, low: float, high: float, fine: float) -> float:
    """Return the load just below what a motion led to, if between a rest and what did not rest; else their middle."""
    below = multiplier - 0.5 * fine
    return below if low < below < high - 0.25 * fine else 0.5 * (low + high)
