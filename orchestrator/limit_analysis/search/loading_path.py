"""The path of a wall under a growing live load: rigid blocks on elastic joints, from gravity to what it cannot bear.

The wall is pushed (pushing.py) with joints as they were drawn, until it moves ever more like a mechanism: forces stand
still, openings have no force, slips no dilation. That is a limit state, checked as it stands (validation.py), the first
that loading leads to. Where the wall creeps or moves with no end in sight the state nearest to where it has come is
looked for (nearest_state.py), and where there is none the answer is the last load at which it rests.

Two multipliers come of it: the last at which the wall rests, and that of the state. They are one, nearly, unless the
mechanism loses strength when it comes loose (a wedged stone): then the wall bears the last rest, and no state is met.
Displacements are small: joints keep their directions. `soft_from` says from which multiplier on the wall moved further
than SOFT times its elastic displacement; beyond it geometry decides, and only finite displacements tell.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from time import perf_counter

import numpy as np

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.basis.errors import ConvergenceError
from orchestrator.limit_analysis.paper.limit_state import SOFT, LimitState, LinearProgramRecord
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
from orchestrator.limit_analysis.search.nearest_state import Closing
from orchestrator.limit_analysis.search.overdamped import Moved
from orchestrator.limit_analysis.search.pushing import HELD, STEPS, Pushing, Way

LEAST = 1e-6
"""Live load, mean block weights, at the associative multiplier of a wall that is not on the verge of falling anyway."""
GOES_DOWN = 0.1
"""Part of the speed of the fastest block above which a block goes down under the dead load."""
LETS_GO = 0.2
"""Part of the load held by which a state may lie below it that a wall moves to from there."""
SAME_ANSWER = 0.01
"""Part of the multiplier by which paths of different stiffness may differ and be one answer, and a state from the last
rest that it is met at: farther down it is what the wall carries once it has lost its hold, not what it bears."""


@dataclass(frozen=True, eq=False, slots=True)
class LoadPath:
    """What growing load does to a wall.

    multipliers (r,): loads at which it rests, the first 0; displacements (r,): along the live load, over the elastic
    one of the same multiplier (1 for the first); forces: of the joints (k, 3) in N at each of them, none of a wall that
    was not loaded, whose state stands for its last rest. `last_rest` is the last of these; `state` what is met
    there, `converged` where the check passes, else the last rest with the mechanism that fits best, of a wall that
    rests under no live load its motion.
    soft_from: multiplier from which on displacements exceed SOFT, None if they never do. not_at_rest: the load just
    above the last rest under which no other was found, inf where none was held to its end; given_up: whether all
    factorisations were spent before one was. counts: how often which way out was needed (overdamped.py, pushing.py).
    """

    multipliers: FloatArray
    displacements: FloatArray
    forces: tuple[FloatArray, ...]
    state: LimitState | None
    factorisations: int
    seconds: float
    not_at_rest: float = np.inf
    given_up: bool = False
    carries: LimitState | None = None
    counts: dict[str, int] = field(default_factory=dict)

    @staticmethod
    def unloaded(state: LimitState, factorisations: int = 0) -> LoadPath:
        """Return the path of a wall that was not loaded: nothing is known of the way to its state."""
        ends = read_only([0.0, state.load_multiplier]), read_only([1.0, 1.0])
        return LoadPath(*ends, (), state, factorisations, 0.0)

    @property
    def last_rest(self) -> float:
        """Largest multiplier at which the wall was found at rest."""
        return float(self.multipliers[-1])

    def up_to(self, state: LimitState) -> LoadPath:
        """Return the path to another state, of less load."""
        rests, last = int(np.searchsorted(self.multipliers, state.load_multiplier)), len(self.multipliers) - 1
        return replace(
            self,
            multipliers=read_only([*self.multipliers[:rests], state.load_multiplier]),
            displacements=read_only([*self.displacements[:rests], self.displacements[min(rests, last)]]),
            forces=(*self.forces[:rests], state.joint_forces),
            state=state,
        )

    @property
    def soft_from(self) -> float | None:
        """Multiplier from which on the wall moved further than SOFT times its elastic displacement."""
        soft = np.flatnonzero(self.displacements > SOFT)
        return float(self.multipliers[soft[0]]) if len(soft) else None


class StateSearch(Pushing):
    """Loading of a wall whose motions are followed to limit states."""

    def __init__(self, problem: Problem, stiffness: Stiffness) -> None:
        """Nothing has moved yet."""
        equilibrium, modulus = problem.equilibrium, problem.elastic_modulus
        super().__init__(
            elastic_wall(problem.assemblage, equilibrium, problem.friction, stiffness, elastic_modulus=modulus)
        )
        self.problem = problem
        self.closing = Closing(problem, joint_stiffness(self.wall))

    def closed(self, last: Moved, motion: Moved, load_step: float) -> Moved | None:
        """Return the limit state nearest to a motion, or else the one nearest to the last equilibrium.

        Of those that are mechanisms along the live load. Either counts within HELD of its own load, the former LETS_GO
        below it, too (nearest_state.py).
        """
        within = HELD * STEPS * load_step
        for here, below in ((motion, LETS_GO * motion.multiplier), (last, within)):
            if not (self.is_mechanism(here) and float(self.live @ here.change) > 0.0):
                continue
            state = self.states(here.position, here.change, here.multiplier)[0]
            ends = (here.multiplier - below, here.multiplier + within)
            low, high = (end / self.wall.problem.per_multiplier for end in ends)
            near = self.closing.near(state, state.mechanism.slip, low, high)
            if near is not None:
                return replace(here, state=near)
        return None

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
        forces = equilibrium.unit_force * joint_forces(self.wall, position.forces)
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
    """Load a wall from gravity until it does not rest any more.

    associative: the multiplier of Eq. (1), which no state exceeds. Joints that crush are loaded as if they did not;
    what is met is the nearest state in which they do. Returns None for a wall that does not come to rest under its dead
    load, or of which there is no such state.
    """
    if not problem.friction.crushes_joints:
        return _loaded(problem, associative, stiffness)
    found = _loaded(replace(problem, friction=problem.friction.hard), associative, stiffness)
    if found is None or found.state is None or not found.state.converged:
        return None
    closing = Closing(problem, np.ones_like(found.state.joint_forces))
    state = closing.near(found.state, found.state.mechanism.slip, 0.0, np.inf)
    return None if state is None else found.up_to(state)


def _loaded(problem: Problem, associative: float, stiffness: Stiffness) -> LoadPath | None:
    """Return the path of a wall whose joints do not crush."""
    started = perf_counter()
    search = StateSearch(problem.measured_by_load(associative), stiffness)
    stands = search.gravity()
    if not stands.rests:
        return None
    if is_on_the_verge(problem, associative):
        return LoadPath(read_only([0.0]), read_only([1.0]), (), None, search.spent, perf_counter() - started)
    way = search.pushed(stands, associative)
    return _path_of(search, way, perf_counter() - started)


def is_on_the_verge(problem: Problem, associative: float) -> bool:
    """Return whether next to no live load, with the associative multiplier, lets a wall fall."""
    return associative * problem.equilibrium.live_total < LEAST * problem.equilibrium.unit_force


def going_down(search: StateSearch) -> tuple[tuple[int, ...], LimitState | None]:
    """Return the ids of the blocks that go on moving under the dead load of a wall, with their motion alone at a
    multiplier of 0; none of a wall that comes to rest."""
    problem, found = search.problem, search.gravity()
    if found.rests:
        return (), None
    change, equilibrium = found.change.reshape(-1, 3), problem.equilibrium
    speed = np.abs(change).max(axis=1)
    fast = speed > GOES_DOWN * speed.max()
    alone = np.where(fast[:, None], change / speed.max(), 0.0).ravel()
    forces = equilibrium.unit_force * joint_forces(search.wall, found.position.forces)
    ids = sorted(problem.assemblage.wall.blocks[block].id for block in equilibrium.free_blocks[fast])
    return tuple(ids), problem.falling(forces, equilibrium.row_scale * alone)


def _path_of(search: StateSearch, way: Way, seconds: float) -> LoadPath:
    """Return the path with its state: the one met, one near its end, or the last rest with the mechanism it has."""
    scale, rests, peak, met = search.wall.problem.per_multiplier, way.rising, way.peak, way.met
    state, carries = None if met is None else met.state, None
    if state and scale * state.load_multiplier < (1.0 - SAME_ANSWER) * peak.multiplier:
        carries, state = state, None
    at_rest = [] if state else search.states(peak.position, way.lost.change, peak.multiplier)
    if at_rest:
        state = replace(at_rest[0 if peak.multiplier > 0.0 else -1], flow_rule="last_rest", converged=False)
    moved = [search.moved(one.position) / (one.multiplier * search.elastic) for one in rests[1:]]
    weight, is_lost = search.problem.equilibrium.unit_force, way.is_lost and not search.is_spent
    return LoadPath(
        multipliers=read_only([one.multiplier / scale for one in rests]),
        displacements=read_only([1.0, *moved]),
        forces=tuple(read_only(weight * joint_forces(search.wall, one.position.forces)) for one in rests),
        state=state,
        factorisations=search.spent,
        seconds=seconds,
        not_at_rest=way.held / scale if is_lost else np.inf,
        given_up=not is_lost and way.met is None,
        carries=carries,
        counts=dict(search.counts),
    )
