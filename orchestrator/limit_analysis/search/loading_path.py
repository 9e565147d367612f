"""The path of a wall under a growing live load: rigid blocks on elastic joints, from gravity to what it cannot bear.

The load grows in steps. Where the wall does not balance it moves against a drag, slowly (backward Euler), until it
rests again: joints open, close and slide on the way. Where it does not rest, displacements are prescribed instead of
the load, from the last rest on: each step is an equilibrium. Either the wall comes to bear the load that was asked for,
and goes on from there, or it moves ever more like a mechanism: forces stand still, openings have no force, slips no
dilation. That is a limit state, checked as it stands (validation.py), the first that loading leads to. Where neither
comes about (the wall snaps back, or creeps) the load step is halved; rest and no rest are FINE apart in the end, and
the state nearest to where the path has led is looked for (nearest_state.py).

Two multipliers come of it: the last at which the wall rests, and that of the state. They are one to FINE unless the
mechanism loses strength when it comes loose (a wedged stone): then the state lies below the last rest.
Displacements are small: joints keep their directions. `soft_from` says from which multiplier on the wall moved further
than SOFT times its elastic displacement; beyond it geometry decides, and only finite displacements tell.
Sources: overdamped motion as a substitute for dynamics after a loss of equilibrium; own combination.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from time import perf_counter

import numpy as np

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.basis.errors import ConvergenceError
from orchestrator.limit_analysis.paper.limit_state import LimitState, LinearProgramRecord
from orchestrator.limit_analysis.paper.linear_program import LimitSolution
from orchestrator.limit_analysis.problem import Problem
from orchestrator.limit_analysis.search.elastic_contact import (
    STIFFNESSES,
    Position,
    Stiffness,
    elastic_wall,
    joint_forces,
    joint_stiffness,
    open_ends,
)
from orchestrator.limit_analysis.search.implicit_step import Task
from orchestrator.limit_analysis.search.nearest_state import Closing
from orchestrator.limit_analysis.search.overdamped import FIRST_DRAG, MOTION, REST_BUDGET, Moved, Overdamped

STEPS = 20
"""Load steps up to the associative multiplier."""
FINE = 1e-3
"""Bracket, part of the associative multiplier, between the last rest and the lowest load without rest."""
SHARP, CLOSE, NEAR, DRIVEN_BUDGET = 1e-8, 1e-5, 1e-4, 600
"""Flow errors of a limit state that is sharp enough, of a motion that is worth checking, and of one that is soon;
factorisations under prescribed displacements."""
GROWTH, FASTER_GROWTH, LEAST_ADVANCE = 2.0, 10.0, 0.3
"""Growth of the displacement prescribed after each step, and once forces nearly stand still (NEAR); factor after one
that was not found."""
FAILURES = 8
"""Steps in a row that are not found before prescribed displacements are given up."""
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
    counts: how often which way out was needed (overdamped.py).
    """

    multipliers: FloatArray
    displacements: FloatArray
    forces: tuple[FloatArray, ...]
    state: LimitState | None
    factorisations: int
    seconds: float
    not_at_rest: float = np.inf
    given_up: bool = False
    counts: dict[str, int] = field(default_factory=dict)

    @property
    def last_rest(self) -> float:
        """Largest multiplier at which the wall was found at rest."""
        return float(self.multipliers[-1])

    @property
    def soft_from(self) -> float | None:
        """Multiplier from which on the wall moved further than SOFT times its elastic displacement."""
        soft = np.flatnonzero(self.displacements > SOFT)
        return float(self.multipliers[soft[0]]) if len(soft) else None


@dataclass(frozen=True, eq=False, slots=True)
class Walked:
    """How far a wall was loaded: its rests, the first under the dead load; the motion after the last of them (None: it
    was not lost), with the limit state it is; and the lowest multiplier at which no rest was found, inf if none."""

    rests: tuple[Moved, ...]
    lost: Moved | None
    high: float


class Loading(Overdamped):
    """The motions of one wall under loads and prescribed displacements."""

    def checked(self, position: Position, change: FloatArray, multiplier: float) -> LimitState | None:
        """Return the limit state that forces and their motion are; none is known here."""
        return None

    def driven(self, rest: Moved, load: float) -> tuple[Moved, Moved]:
        """Go on from a rest by prescribed displacements until the wall bears a load (scaled), or is in a limit state.

        rest: its `change` says which way, and how far at first. Returns where that ended, with the `state` that passes
        the check if one was met, and the equilibrium with the largest multiplier on the way.
        """
        live, here = self.wall.problem.live, rest
        advance, failures, end = float(live @ rest.change), 0, min(self.spent + DRIVEN_BUDGET, self.most)
        highest, met = rest, None
        while self.spent < end and failures < FAILURES and here.multiplier < load:
            expected = here.change * (advance / float(live @ here.change))
            found = self.step(here.position, Task(here.multiplier, 0.0, advance), expected)
            if not found.found and met is not None:
                break
            if not found.found:
                advance, failures = LEAST_ADVANCE * advance, failures + 1
                continue
            flow, failures = self.flow(found.position, here.position, found.multiplier * advance), 0
            change = found.position.displacements - here.position.displacements
            here = Moved(found.position, change, found.multiplier, flow, True)
            highest = here if here.multiplier > highest.multiplier else highest
            if flow < CLOSE and (state := self.checked(here.position, change, here.multiplier)) is not None:
                met = replace(here, state=state)
            if met is not None and flow < SHARP:
                break
            if flow < MOTION and self.is_further(FARTHEST, here.position, here.multiplier):
                break
            advance *= FASTER_GROWTH if flow < NEAR else GROWTH
        return met or here, highest

    def way_on(self, rest: Moved, found: Moved) -> Moved | None:
        """Return a rest with the way on from it that a motion took, as long as an elastic one at first; None: back."""
        way = found.position.displacements - rest.position.displacements
        along = float(self.wall.problem.live @ way)
        elastic = self.elastic * (found.multiplier - rest.multiplier)
        return replace(rest, change=way * min(1.0, elastic / along)) if along > 0 else None

    def loaded_from(self, stands: Moved, associative: float) -> Walked:
        """Load the wall from its rest under the dead load until it does not rest any more."""
        scale, fine = self.wall.problem.per_multiplier, FINE * associative
        rests, lost, high = [stands], None, np.inf
        driven_from: Moved | None = None
        target = step = associative / STEPS
        while high - rests[-1].multiplier / scale > fine and not self.is_spent:
            rest = rests[-1]
            found = self.rest(rest.position, scale * target, FIRST_DRAG, REST_BUDGET)
            if found.rests:
                rests.append(found)
                step = min(2.0 * step, associative / STEPS)
            elif driven_from is not rest and (way := self.way_on(rest, found)) is not None:
                lost, highest = self.driven(way, scale * target)
                rests += [highest] if highest.multiplier > rest.multiplier else []
                if lost.multiplier < scale * target or lost.state is not None:
                    driven_from, high = rests[-1], target
                    if lost.flow < MOTION:
                        break  # a mechanism: there is no other rest on this way
                elif lost.multiplier >= scale * high:
                    high = np.inf
            else:
                lost, high = lost or found, target
            if len(rests) > 1 and np.isinf(self.elastic):
                self.elastic = self.moved(rests[1].position) / rests[1].multiplier
            target = next_load(rests[-1].multiplier / scale, high, step)
            step = target - rests[-1].multiplier / scale
        return Walked(tuple(rests), lost, high)


class StateSearch(Loading):
    """Loading of a wall whose motions are followed to limit states."""

    def __init__(self, problem: Problem, stiffness: Stiffness) -> None:
        """Nothing has moved yet."""
        equilibrium, modulus = problem.equilibrium, problem.elastic_modulus
        super().__init__(
            elastic_wall(problem.assemblage, equilibrium, problem.friction, stiffness, elastic_modulus=modulus)
        )
        self.problem = problem
        self.closing = Closing(problem, joint_stiffness(self.wall))

    def nearest(self, lost: Moved, low: float, high: float) -> LimitState | None:
        """Return the limit state nearest to where a motion has led, between two multipliers (nearest_state.py)."""
        state = self.states(lost.position, lost.change, lost.multiplier)[0]
        return self.closing.near(state, state.mechanism.slip, low, high)

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
        opened = open_ends(self.wall, position.rates)
        velocities = equilibrium.row_scale * change / (equilibrium.live_total * (along if along > 0 else 1.0))
        forces = equilibrium.mean_weight * joint_forces(position.forces)
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
            replace(one, open_ends=read_only(opened, np.bool_)) if with_ is own else one
            for one, with_ in zip(states, found, strict=True)
        ]


def load_path(problem: Problem, associative: float, stiffness: Stiffness = STIFFNESSES[0]) -> LoadPath | None:
    """Load a wall whose joints do not crush from gravity until it does not rest any more.

    associative: the multiplier of Eq. (1), which no state exceeds. Returns None for a wall that does not come to rest
    under its dead load.
    """
    started = perf_counter()
    search = StateSearch(problem, stiffness)
    stands = search.gravity()
    if not stands.rests:
        return None
    if search.wall.problem.per_multiplier * associative < LEAST:
        return LoadPath(read_only([0.0]), read_only([1.0]), (), None, search.spent, perf_counter() - started)
    walked = search.loaded_from(stands, associative)
    return _path_of(search, walked, FINE * associative, perf_counter() - started)


def next_load(low: float, high: float, step: float) -> float:
    """Return the next multiplier after a rest at `low`: a step on, or half way to where there is no rest."""
    return min(low + step, 0.5 * (low + high))


def _path_of(search: StateSearch, walked: Walked, fine: float, seconds: float) -> LoadPath:
    """Return the path with its state: the one met, one near its end, or the last rest with the mechanism it has."""
    scale, rests, lost, high = search.wall.problem.per_multiplier, walked.rests, walked.lost, walked.high
    last = rests[-1]
    low = last.multiplier / scale
    state = None if lost is None else lost.state
    if state is None and lost is not None:
        state = search.nearest(lost, low - fine, high + fine)
    if state is None and low > 0:
        change = np.zeros_like(last.change) if lost is None else lost.change
        at_rest = search.states(last.position, change, last.multiplier)
        state = replace(at_rest[0], flow_rule="last_rest", converged=False) if at_rest else None
    moved = [search.moved(one.position) / (one.multiplier * search.elastic) for one in rests[1:]]
    weight = search.problem.equilibrium.mean_weight
    return LoadPath(
        multipliers=read_only([one.multiplier / scale for one in rests]),
        displacements=read_only([1.0, *moved]),
        forces=tuple(read_only(weight * joint_forces(one.position.forces)) for one in rests),
        state=state,
        factorisations=search.spent,
        seconds=seconds,
        not_at_rest=high,
        given_up=search.is_spent and high - low > fine,
        counts=dict(search.counts),
    )
