"""Limit analysis of a wall in space: associative bound, headline without dilation, range of states found.

headline   the end of the push on elastic joints from the gravity state, springs stiffer with depth; that with equal
           springs where it is lower by more than ONE_ANSWER
range      lowest and highest valid state found: also, on small walls, pushes with equal springs and the dilation shift,
           on larger ones the path of smoothed contact; descents from all these
Every state is validated from geometry, forces and velocities (validation.py) before it counts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Annotated

import numpy as np
from annotated_types import Gt

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.checked import Checked
from orchestrator.basis.errors import ConvergenceError
from orchestrator.basis.printed import as_lambda
from orchestrator.basis.units import Unit
from orchestrator.limit_analysis.gravity import GRAVITY_TOLERANCE, refuse_the_verge
from orchestrator.limit_analysis.remarks import no_rest_words
from orchestrator.space import descent
from orchestrator.space.central_path import STAGE, follow
from orchestrator.space.conic_program import ConicSolution
from orchestrator.space.contacts import SpaceAssemblage
from orchestrator.space.elastic_joints import HELD_BY, Push, push
from orchestrator.space.equilibrium import SpaceEquilibrium, Torsion, equilibrium_of
from orchestrator.space.found import ONE_ANSWER, PUSHES, SpaceAnalysis, States
from orchestrator.space.gravity import at_rest, fastest, forces_under_gravity, listed
from orchestrator.space.loads import SpaceLoads
from orchestrator.space.resistance import UnresistedError, associative_optimum, moves, multiplier_or_held
from orchestrator.space.springs import joint_stiffness, springs_of
from orchestrator.space.states import SpaceState, state_of
from orchestrator.space.validation import LIMITS
from orchestrator.space.work import Work, factorisations_in

Report = Callable[[str], None]
BRACKET = 0.01
"""Relative difference of the multipliers with both torsions from which both are reported."""
SHIFTS = 25
"""Programs of the dilation shift, at most."""
TURNS = 6
"""Turns of a descent, at most."""
SMALL_BLOCKS = 100
"""Larger walls have the path of smoothed contact (central_path.py) in place of a push with equal springs, which creeps
on tall walls, and of the dilation shift, which settles at 52 to 68 blocks and not at 174."""
SECOND_PUSH = 8.0
"""Times the work of the first push, and at least of as many seconds, that the second one may take: it creeps on tall
walls."""
SHARES = (0.35, 0.6, 0.9, 0.95)
"""Parts of the work after which the first push, the second or the path, descents and shift, and the last descent end at
the latest."""
DEPTH_POWER = 2.0
"""stiffness of a joint grows with this power of its depth below the top"""
LEAST = 1e-4
"""live load, mean block weights, below which the end of a push is no state but for rounding, and none that was closed
from it without it is the wall's"""
NO_LOAD = "it needs no live load"
"""why a state is none: under the dead load alone it falls, unless joints are pressed beforehand"""
LOOSE = "what moves in them stands only as its joints are pressed beforehand; they are no capacities"
UNBOUNDED = (
    "if sliding dilated, joints would press ever more and the wall would bear any load in this direction: there is no "
    "upper bound, and joints that are pressed beforehand may bear more than the states found"
)


@dataclass(frozen=True, slots=True)
class SpaceLimitSettings(Checked):
    """What the limit analysis of a wall in space does."""

    torsion: Torsion = "corners"
    """how a joint resists twisting: forces at its corners, or as under uniform pressure"""
    states: States = "range"
    """what is looked for without dilation: headline and range, the headline only, or nothing"""
    time: Annotated[float, Gt(0), Unit("s")] = 100.0
    """processor time for the search without dilation, about: counted by its factorisations, so that the answer is the
    same on every machine; what it has found by then is reported"""


def analyse(
    assemblage: SpaceAssemblage,
    loads: SpaceLoads,
    settings: SpaceLimitSettings | None = None,
    report: Report = lambda _: None,
) -> SpaceAnalysis:
    """Run the limit analysis. Raises CaseError for a wall that cannot stand, or just can, and for a load that nothing
    resists, ConvergenceError where the associative program fails."""
    settings, started = settings or SpaceLimitSettings(), perf_counter()
    equilibrium = equilibrium_of(assemblage, loads, settings.torsion)
    stiffness = joint_stiffness(assemblage, DEPTH_POWER)
    balanced = forces_under_gravity(assemblage, equilibrium, stiffness)
    gravity, falling = at_rest(assemblage, equilibrium, balanced, stiffness)
    report("whether it stands is open" if falling else "joint forces can balance its dead load")
    other: Torsion = "uniform" if settings.torsion == "corners" else "corners"
    other_torsion = multiplier_or_held(equilibrium_of(assemblage, loads, other))
    optimum = associative = unresisted = None
    try:
        optimum = associative_optimum(equilibrium, other_torsion)
        associative = state_of("associative", assemblage, loads, optimum, optimum.velocities, settings.torsion)
        report(f"associative multiplier {optimum.load_multiplier:.5f}")
    except UnresistedError as error:  # a state without dilation is the only answer, then
        unresisted = error
        settings = replace(settings, states="headline") if settings.states == "none" else settings
    states = list[SpaceState]()
    remarks = [no_rest_words(listed(falling), len(falling))] * bool(falling)
    if settings.states != "none":
        search = _Search(assemblage, loads, equilibrium, gravity, optimum, settings.time, report)
        states += search.pushes()
        if unresisted is not None and search.is_held and not any(state.valid for state in states):
            raise unresisted
        if settings.states == "range" or not any(state.valid for state in states):
            end = min(state.load_multiplier for state in states)
            for state in search.others():
                states.append(state)
                if settings.states == "headline" and state.valid and state.load_multiplier <= (1.0 + ONE_ANSWER) * end:
                    break
        if unresisted is not None and not any(state.valid for state in states):
            raise ConvergenceError("search without dilation", f"{UNBOUNDED}; no state was found: {_nearest(states)}")
        remarks += [f"WARNING: {UNBOUNDED}"] * (unresisted is not None) + _remarks(states, unresisted is None)
    weight = float(assemblage.wall.weights[~assemblage.wall.fixed].sum())
    analysis = SpaceAnalysis(
        assemblage=assemblage,
        loads=loads,
        torsion=settings.torsion,
        associative=associative,
        other_torsion=other_torsion,
        states=tuple(states),
        weight=weight,
        seconds=perf_counter() - started,
        remarks=tuple(remarks),
        going_down=falling,
        looked_for=settings.states,
    )
    if analysis.not_at_rest is not None:
        more = f"loading had not come to rest at λ = ({as_lambda(analysis.not_at_rest)}), and the wall may fail there"
        analysis = replace(analysis, remarks=(*remarks, f"WARNING: {more}: give limit_analysis.time more"))
    borne = analysis.shown.load_multiplier * equilibrium.live_total
    refuse_the_verge(borne, GRAVITY_TOLERANCE * weight / len(equilibrium.free_blocks))
    return analysis


class _Search:
    """The search for states without dilation, for as many factorisations as a time stands for."""

    def __init__(
        self,
        assemblage: SpaceAssemblage,
        loads: SpaceLoads,
        equilibrium: SpaceEquilibrium,
        gravity: FloatArray,
        associative: ConicSolution | None,
        seconds: float,
        report: Report,
    ) -> None:
        self._assemblage, self._loads, self._equilibrium = assemblage, loads, equilibrium
        self._gravity, self._associative, self._report = gravity, associative, report
        self._second = factorisations_in(1.0, len(equilibrium.friction))
        self._work, self._most = Work(), seconds * self._second
        self._small = len(equilibrium.free_blocks) <= SMALL_BLOCKS
        self._starts: list[tuple[str, FloatArray]] = []
        self._flow = np.inf
        self.is_held = False

    def _until(self, share: float) -> Work:
        """Return the work, which may go on up to a share of all."""
        self._work.until = share * self._most
        return self._work

    def pushes(self) -> list[SpaceState]:
        """Return the ends of the first push and, on small walls, of that with equal springs, whatever they ended as.

        Raises FallsError where the first one ends under next to no live load.
        """
        first = self._push(PUSHES[0], DEPTH_POWER, SHARES[0])
        if first.converged:
            least = LEAST * self._equilibrium.weight_scale
            moving = fastest(self._assemblage, self._equilibrium, first.velocities)
            refuse_the_verge(first.load_multiplier * self._equilibrium.live_total, least, moving)
        ends = [self._of_push(PUSHES[0], first)]
        self._starts = [("elastic joints", first.slip)]
        self._flow = first.flow
        is_quick = self._until(0.8 * SHARES[0]).left > 0  # else work is better spent on closing what it came to
        if self._small and is_quick:
            most = SECOND_PUSH * max(first.factorisations, self._second)
            second = self._push(PUSHES[1], 0.0, SHARES[1], most)
            ends.append(self._of_push(PUSHES[1], second))
            self._starts.append(("equal springs", second.slip))
        return ends

    def others(self) -> Iterator[SpaceState]:
        """Yield what else is found, from the ends of the pushes, from the path of smoothed contact or the shift."""
        smoothed = [] if self._small or self._associative is None else self._smoothed(self._flow, self._associative)
        for name, slip in smoothed + self._starts:
            yield from self._closed(name, slip, self._until(SHARES[2]))
        if not self._small:
            return
        self._report("dilation shift")
        work = self._until(SHARES[2])
        shifted = descent.settled(descent.dilation_shift(self._equilibrium, work), SHIFTS, work)
        if shifted is not None and self._until(SHARES[3]).left > 0:
            yield from self._closed("dilation shift", shifted.solution.slip, self._until(SHARES[3]))

    def _smoothed(self, flow: float, associative: ConicSolution) -> list[tuple[str, FloatArray]]:
        """Return the end of the path of smoothed contact as a start, if there is one and it came nearer to a state than
        a push with this flow error, or the push has found one."""
        stiffness = joint_stiffness(self._assemblage, 0.0)
        springs = springs_of(self._assemblage, self._equilibrium, stiffness)
        try:
            end = follow(springs, self._equilibrium, associative, self._until(SHARES[1]), self._report)
        except ConvergenceError:
            return []
        return [(STAGE, end.slip)] if end.left < max(flow, LIMITS["flow"]) else []

    def _push(self, name: str, power: float, share: float, most: float = np.inf) -> Push:
        stiffness = joint_stiffness(self._assemblage, power)
        work = self._until(share)
        work.until = work.done + min(max(work.left, self._second), most)
        wall = (self._assemblage, self._equilibrium, self._gravity)
        return push(*wall, stiffness, work, lambda text: self._report(f"{name}: {text}"))

    def _of_push(self, name: str, pushed: Push) -> SpaceState:
        state = self._state(name, pushed, pushed.velocities)
        if pushed.converged:
            return state
        self.is_held |= self._applied(pushed.load_multiplier) >= HELD_BY
        spent = f"not at rest after {pushed.factorisations} factorisations"
        why = f"{spent}: λ {pushed.load_multiplier:.4f}, flow error {pushed.flow:.0e}"
        return replace(state, error=why, nearly=state.nearly or state.valid)

    def _state(self, name: str, solution: ConicSolution | Push, velocities: FloatArray) -> SpaceState:
        """Return a state, valid or not; one that needs no live load, or is moved by its rounding only, is none."""
        torsion = self._equilibrium.torsion
        state = state_of(name, self._assemblage, self._loads, solution, velocities, torsion)
        if (state.valid or state.nearly) and self._applied(state.load_multiplier) <= LEAST:
            return replace(state, error=NO_LOAD, nearly=False)
        if state.valid and self._associative is None and not moves(self._equilibrium, state.velocities):
            return replace(state, error="it moves by rounding of the load only")
        return state

    def _applied(self, multiplier: float) -> float:
        """Return the live load at a multiplier, mean block weights."""
        return multiplier * self._equilibrium.live_total / self._equilibrium.weight_scale

    def _closed(self, name: str, slip: FloatArray, work: Work) -> Iterator[SpaceState]:
        """Yield the states of a descent from slips and the highest that goes with them."""
        self._report(f"descent from {name}")
        for number, one in enumerate(descent.descent(self._equilibrium, slip, TURNS, work), 1):
            yield self._of_closed(f"descent from {name}, turn {number}", one)
        if work.left <= 0:
            return
        try:
            highest = descent.closed(self._equilibrium, slip, work, -descent.FACE_WEIGHT)
        except ConvergenceError:
            return
        yield self._of_closed(f"highest from {name}", highest)

    def _of_closed(self, name: str, closed: descent.Closed) -> SpaceState:
        return self._state(name, closed.forces, closed.mechanism.velocities)


def _remarks(states: list[SpaceState], is_bounded: bool) -> list[str]:
    """Say what the figures do not: states that need no live load, which push the headline is not, and how near to a
    state one came where none is. is_bounded: whether what is nearly a state may count."""
    loose = dict.fromkeys(as_lambda(one.load_multiplier) for one in states if one.error == NO_LOAD)
    said = [f"states at λ = {', '.join(loose)} need no live load: {LOOSE}"] if loose else []
    if states[0].valid:
        return said
    why = f"the push on elastic joints found no state ({states[0].error})"
    pushes = [state for state in states if state.name in PUSHES]
    instead = {
        "that with equal springs did": any(state.valid for state in pushes),
        "its end is nearly one": is_bounded and states[0].nearly,
        "that with equal springs nearly did": is_bounded and any(state.nearly for state in pushes),
        "the headline is the state that its end was closed to": any(state.valid for state in states),
        "the headline is what is nearest to one": is_bounded and any(state.nearly for state in states),
    }
    if any(instead.values()):
        return [*said, f"WARNING: {why}; {next(words for words, is_so in instead.items() if is_so)}"]
    none = f"no state without dilation found: {why}; {_nearest(states)}"
    return [*said, f"WARNING: {none}; the associative multiplier is a bound"]


def _nearest(states: list[SpaceState]) -> str:
    near = min(states, key=lambda state: state.validation.flow)
    return f"nearest to one: λ {near.load_multiplier:.4f}, {near.validation.flow:.0e} of its power out of balance"
