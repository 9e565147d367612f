"""What growing load does to a wall stone by stone: local failures first, then the wall's own state.

A mechanism that moves less than a share of the dead load, and of the live load too, is a local failure
(loads/local_part.py), with all that came loose since the wall was last found at rest under more load than before. Its
stones are taken away with their weight and live load, for they lie on the ground; so are stones that then fall. What
stands is loaded anew from gravity, as long as it carries live load.
(Bonding such stones to a neighbour instead gives the same for one small stone and odd wedges for several.)

Joints have two stiffnesses in turn, and the wall is loaded with both. A state that is a property of the wall is the
same with both; where the multipliers differ by more than SAME_ANSWER their interval is the answer, and the lower limit
state is the headline. They take turns: in two threads at a time last digits differ from run to run (where arrays
come to lie in memory), and a run must repeat itself.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from orchestrator.basis.arrays import BoolArray
from orchestrator.basis.errors import CaseError, ConvergenceError
from orchestrator.limit_analysis.gravity import associative_optimum
from orchestrator.limit_analysis.paper.limit_state import LimitState, LocalFailure, is_of_geometry
from orchestrator.limit_analysis.paper.linear_program import LimitSolution
from orchestrator.limit_analysis.paper.yield_conditions import YieldConditions
from orchestrator.limit_analysis.problem import Problem
from orchestrator.limit_analysis.search.elastic_contact import STIFFNESSES, Stiffness
from orchestrator.limit_analysis.search.large_walls import large_path
from orchestrator.limit_analysis.search.loading_path import SAME_ANSWER, LoadPath, StateSearch, going_down, load_path
from orchestrator.limit_analysis.search.moving_parts import ids_of, moves, moving_share, shares_of, standing_of
from orchestrator.limit_analysis.search.rigid_pushover import RigidPushover, rigid_pushover
from orchestrator.limit_analysis.search.what_is_left import of_whole
from orchestrator.loads.block_loads import Loads
from orchestrator.loads.local_part import is_local
from orchestrator.masonry.joints import Assemblage

logger = logging.getLogger(__name__)

MISSED = 1e-3
"""Part of the associative multiplier, which no state exceeds, by which a path comes past it only where it has missed
stones that are lighter than what joints are smooth by: they came loose at that multiplier, at the latest."""
ROUNDING = 1e-9
"""part of the cohesion that is rounding, of tension that ends where Coulomb's cone does"""
ANOTHER_PEAK = 1e-3
"""Part of the multiplier by which the peak in large displacements is another than the last rest in small ones."""
GEOMETRY = 0.02
"""Part of the multiplier by which the peak in large displacements lies off the limit state of a wall whose answer it
is. Deformation takes something from any wall: 1.9 % from Ferris & Tin-Loi's wall 6, 1.5 % from its micro-FE."""


@dataclass(frozen=True, slots=True)
class Road:
    """How a wall is loaded.

    path: from a wall and its associative optimum to its path, None where it finds no rest under its dead load; falling:
    the motion in which blocks go down then, None where that is not known.
    """

    path: Callable[[Problem, LimitSolution], LoadPath | None]
    falling: Callable[[Problem], LimitState | None]


@dataclass(frozen=True, eq=False, slots=True)
class Loaded:
    """Where loading ended: the state of the wall that is left (None: not found), its path, and what came loose first.

    The state's arrays are those of the whole wall: stones that came loose are at rest in it, their joints carry
    nothing. left (n,): the blocks that are still there, `part` their problem and `optimum` its associative one. spread:
    lowest and highest multiplier with joints of different stiffness, or in small and large displacements,
    where loading led to them. pushed: the
    curve of what is left in large displacements, where the wall was pushed. displaced_rests: whether it came to rest
    there under some live load, if it was. on_its_springs: what it bears, at rest or moving, in small displacements
    with the stiffness of joints that it is pushed with, nan where no limit state was closed. lets_go: the lowest state
    that it moves to from a last rest. factorisations: so far.
    """

    state: LimitState | None
    path: LoadPath
    local_failures: tuple[LocalFailure, ...]
    left: BoolArray
    part: Problem
    optimum: LimitSolution
    spread: tuple[float, float] | None = None
    pushed: RigidPushover | None = None
    displaced_rests: bool = True
    on_its_springs: float = math.nan
    lets_go: LimitState | None = None
    factorisations: int = 0

    @property
    def multiplier(self) -> float:
        """That of the state, 0 where none was found."""
        return 0.0 if self.state is None else self.state.load_multiplier

    @property
    def closed(self) -> bool:
        """Whether there is a limit state, and not a last rest alone."""
        return self.state is not None and self.state.converged

    @property
    def geometry_decides(self) -> bool:
        """Whether the answer is the peak in large displacements, and not the limit state of the wall as drawn."""
        return self.pushed is not None and self.state is not None and self.multiplier == self.pushed.peak

    @property
    def is_unloaded(self) -> bool:
        """Whether a wall with a state was not loaded in small displacements."""
        return self.state is not None and not self.path.forces

    def of_whole(self, state: LimitState, whole: Assemblage) -> LimitState:
        """Return a state of the blocks that are left with the arrays of the whole wall, zeros elsewhere."""
        return of_whole(state, whole, self.left)


def has_path(friction: YieldConditions) -> bool:
    """Whether joints follow the law of elastic_contact.py, but for crushing: a point in tension bears shear."""
    beyond = friction.slope * friction.tension > (1.0 + ROUNDING) * friction.cohesion
    return not beyond.any()


def loaded(
    problem: Problem, loads: Loads, optimum: LimitSolution, local_share: float, most_blocks: int, pushes: bool
) -> Loaded | None:
    """Load a wall along +x until it fails as a whole, in small displacements and, if it `pushes`, in large ones, too.

    Stones that come loose in large displacements where the wall stands in small ones are a local failure, too: the wall
    is loaded again without them. None: no rest at first. A wall of more than `most_blocks` is not loaded in
    small displacements if it has a state of smoothed conditions.
    """
    found = in_small_displacements(problem, loads, optimum, local_share, most_blocks)
    while found is not None and pushes and is_pushed(found):
        logger.info("pushing rigid blocks in large displacements")
        pushed = rigid_pushover(found.part, found.optimum.load_multiplier)
        spent = found.factorisations + (pushed.factorisations if pushed else 0)
        found = replace(found, pushed=pushed, displaced_rests=pushed is not None, factorisations=spent)
        failure = come_loose(found, problem, loads, local_share)
        if failure is None:
            return settled(found, problem.assemblage)
        left = found.left & ~np.isin([block.id for block in problem.assemblage.wall.blocks], failure.stones)
        before = left, (*found.local_failures, failure)
        rest = in_small_displacements(problem, loads, optimum, local_share, most_blocks, before)
        if rest is None:
            return found
        found = replace(rest, factorisations=rest.factorisations + spent)
    return found


def in_small_displacements(
    problem: Problem,
    loads: Loads,
    optimum: LimitSolution,
    local_share: float,
    most_blocks: int,
    before: tuple[BoolArray, tuple[LocalFailure, ...]] | None = None,
) -> Loaded | None:
    """Load a wall with joints of both stiffnesses; before: the blocks (n,) that are left, and what came loose.

    Stones that go down under the dead load with joints of one stiffness and not of the other are held, not wedged.
    """
    if len(problem.equilibrium.free_blocks) > most_blocks and not problem.friction.crushes.any():
        large = peeled(problem, loads, optimum, local_share, Road(large_path, lambda part: None), before)
        if large is not None:
            return large
    found = [peeled(problem, loads, optimum, local_share, road(stiffness), before) for stiffness in STIFFNESSES]
    stands = [one is not None and not any(each.under_dead_load for each in one.local_failures) for one in found]
    if any(stands):
        found = [one if it_stands else None for one, it_stands in zip(found, stands, strict=True)]
    known = [one for one in found if one is not None and one.state is not None]
    answer = lower_of(known) if len(known) == len(STIFFNESSES) else next(iter(known), found[0] or found[1])
    if answer is None:
        return None
    carried = [one.path.carries for one in found if one is not None and np.array_equal(one.left, answer.left)]
    first = found[0]
    same = first is not None and first.closed and np.array_equal(first.left, answer.left)
    return replace(
        answer,
        on_its_springs=max(first.multiplier, first.path.last_rest) if first is not None and same else math.nan,
        lets_go=min(filter(None, carried), key=lambda state: state.load_multiplier, default=None),
        factorisations=sum(one.factorisations for one in found if one is not None),
    )


def settled(found: Loaded, whole: Assemblage) -> Loaded:
    """Return a wall that bears no more in large displacements than a state that it moves to from its last rest in small
    ones with that state: it lets go there before."""
    pushed, state = found.pushed, found.lets_go
    if pushed is None or state is None or not pushed.is_past:
        return found
    if pushed.peak > (1.0 + SAME_ANSWER) * state.load_multiplier:
        return found
    low, high = state.load_multiplier, max((found.multiplier, *(found.spread or ())))
    spread = (low, high) if high > (1.0 + SAME_ANSWER) * low else None
    return replace(found, state=of_whole(state, whole, found.left), spread=spread)


def is_pushed(found: Loaded) -> bool:
    """Whether a wall is pushed in large displacements: not with joints that hold unpressed, until they break, or
    crush."""
    return found.multiplier > 0.0 and found.part.friction.scales_with_load


def moving_without_load(problem: Problem, met: Loaded | None) -> tuple[int, ...]:
    """Return the ids of the blocks that move under next to no live load, of a wall that bears none."""
    if met is None or met.state is None or met.state.load_multiplier > 0.0:
        return ()
    return ids_of(problem, met.left & moves(problem, met.state))


def come_loose(found: Loaded, problem: Problem, loads: Loads, local_share: float) -> LocalFailure | None:
    """Return the local failure with which a push in large displacements ended, None where the wall itself failed."""
    pushed = found.pushed
    if pushed is None or pushed.ends is None or not pushed.is_past or (found.closed and not is_another(found, pushed)):
        return None
    state = of_whole(pushed.ends, problem.assemblage, found.left)
    moving, share, gone = moving_share(problem, loads, state, found.left)
    if not is_local(share, gone, local_share):
        return None
    return LocalFailure(ids_of(problem, moving), share.dead, (pushed.peak, pushed.peak), state)


def lower_of(found: Sequence[Loaded]) -> Loaded | None:
    """Return the lower of two answers with the interval of both; where they agree to SAME_ANSWER, the closed one.

    A limit state, or a last rest from which the wall moves to one, counts before a last rest that none closed, however
    low: the wall stands there, and nobody knows how much further. The interval has that rest as its end.
    """
    multipliers = [one.state.load_multiplier for one in found if one.state is not None]
    low, high = min(multipliers, default=0.0), max(multipliers, default=0.0)
    if high - low <= SAME_ANSWER * abs(low):
        return max(found, key=lambda one: one.state is not None and one.state.converged, default=None)

    def rank(one: Loaded) -> tuple[bool, float]:
        assert one.state is not None
        return not one.state.converged and one.path.carries is None, one.state.load_multiplier

    return replace(min(found, key=rank), spread=(low, high))


def in_large_displacements(found: Loaded, whole: Assemblage) -> Loaded:
    """Return the peak in large displacements of a wall that was pushed where that is another answer, in an interval
    with what loading met in small ones."""
    pushed = found.pushed
    if pushed is None or pushed.state is None or not is_another(found, pushed):
        return found
    ends = (pushed.peak, *((found.multiplier, *(found.spread or ())) if not found.is_unloaded else ()))
    spread = (min(ends), max(ends)) if max(ends) - min(ends) > SAME_ANSWER * max(ends) else None
    return replace(found, state=of_whole(pushed.state, whole, found.left), spread=spread)


def is_another(found: Loaded, pushed: RigidPushover) -> bool:
    """Whether the peak in large displacements lies off (GEOMETRY) the state in small ones, and is the answer.

    Where no limit state was closed it is that from ANOTHER_PEAK on, passed or not: what is known then is up to which
    load the wall stands, and in large displacements it is known truly; but not above a rest that is lower with joints
    of the other stiffness, with which the wall is not pushed. Below a limit state it must have passed. Above,
    it must lie off what the same springs bear in small displacements, too, and blocks must have moved farther than
    joints give way: else the joints differ, not the geometry. A wall that was not loaded in small displacements has no
    such state: its peak counts from SAME_ANSWER on.
    """
    if not found.closed:
        above = pushed.peak > found.multiplier
        return abs(pushed.peak - found.multiplier) > ANOTHER_PEAK * found.multiplier and not (above and found.spread)
    if found.is_unloaded:
        off = pushed.peak / found.multiplier - 1.0
        return off > SAME_ANSWER or (pushed.is_past and off < -SAME_ANSWER)
    below = pushed.is_past and pushed.peak < (1.0 - GEOMETRY) * found.multiplier
    above = pushed.peak > (1.0 + GEOMETRY) * float(np.fmax(found.multiplier, found.on_its_springs))
    return below or (above and is_of_geometry(pushed.curve, found.multiplier))


def road(stiffness: Stiffness) -> Road:
    """Return how walls are loaded whose joints have a stiffness."""
    return Road(
        path=lambda problem, optimum: load_path(problem, optimum.load_multiplier, stiffness),
        falling=lambda problem: going_down(StateSearch(problem, stiffness))[1],
    )


def peeled(
    problem: Problem,
    loads: Loads,
    optimum: LimitSolution,
    local_share: float,
    road: Road,
    before: tuple[BoolArray, tuple[LocalFailure, ...]] | None = None,
) -> Loaded | None:
    """Load a wall, taking local failures away until what moves is the wall; before: the blocks left, and what is not.

    A wall that stones have left is loaded as if it had been drawn without them: in steps of its own associative
    optimum, which is its bound too. What then goes down under the dead load came loose with them, and what goes down
    before any load is a local failure of its own: nothing holds it but a wedge. What comes loose below a rest that its
    bound excludes (MISSED) is the mechanism of the bound.
    """
    whole = problem.assemblage
    left, failures = before or (np.ones(len(whole.wall.blocks), dtype=bool), ())
    found: Loaded | None = None
    spent = 0
    under = max((failure.multipliers[1] for failure in failures), default=-np.inf)
    earlier = [stone for failure in failures[:-1] for stone in failure.stones]
    rested = shares_of(problem, loads, np.isin([block.id for block in whole.wall.blocks], earlier))  # at its last rest
    while (standing := standing_of(problem, loads, left)) is not None:
        part, stands = standing
        falls = left & ~stands
        if falls.any() and failures:
            gone, lost = shares_of(problem, loads, ~stands), shares_of(problem, loads, falls).dead
            if not is_local(gone - rested, rested, local_share):
                return found
            failures = (*failures[:-1], failures[-1].taking(ids_of(problem, falls), lost))
        left = stands
        try:
            optimum = optimum if part is problem else associative_optimum(part)
        except (CaseError, ConvergenceError):  # what is left is wedged between supports
            return found
        path = road.path(part, optimum)
        spent += path.factorisations if path else 0
        if path is None and (falling := road.falling(part)) is not None:
            motion = of_whole(falling, whole, left)
            down = left & moves(problem, motion)
            gone, lost = shares_of(problem, loads, ~left | down), shares_of(problem, loads, down).dead
            if down.any() and is_local(gone - rested, rested, local_share):
                last = failures[-1] if failures else LocalFailure((), 0.0, (0.0, 0.0), motion)
                failures = (*failures[:-1], last.taking(ids_of(problem, down), lost))
                left = left & ~down
                continue
        if path is None or path.state is None:
            nothing = None if path is None or failures else Loaded(None, path, failures, left, part, optimum)
            return replace(found, factorisations=spent) if found else nothing
        state = of_whole(path.state, whole, left)
        found = Loaded(state, path, failures, left, part, optimum, factorisations=spent)
        bound = optimum.load_multiplier
        low, high = sorted((state.load_multiplier, path.last_rest))
        if high > (1.0 + MISSED) * bound:
            state, low, high = of_whole(part.bound(optimum), whole, left), bound, bound
        moving, share, gone = moving_share(problem, loads, state, left)
        rested = gone if path.last_rest > under else rested
        is_known = state.converged or not state.load_multiplier
        if not is_known or not is_local(gone + share - rested, rested, local_share):
            return found
        under = max(under, high)
        failures = (
            *failures,
            LocalFailure(ids_of(problem, moving), share.dead, (min(low, bound), min(high, bound)), state),
        )
        left = left & ~moving
    return found
