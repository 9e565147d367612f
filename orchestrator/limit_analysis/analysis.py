"""Micro limit analysis of an assemblage: all answers for one load direction, each with its checks.

Does it stand (gravity check)? - associative optimum of Eq. (1) - the paper's sequence, Eq. (2) - the dilation shift -
the complementarity program - a search for lower states from all of these.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from time import perf_counter

from orchestrator.errors import ConvergenceError
from orchestrator.joints import Assemblage
from orchestrator.limit_analysis.dilation_shift import run_dilation_shift
from orchestrator.limit_analysis.equilibrium import assemble_equilibrium
from orchestrator.limit_analysis.gravity import associative_optimum, refuse_what_falls
from orchestrator.limit_analysis.linear_program import LimitSolution
from orchestrator.limit_analysis.loads import Loads
from orchestrator.limit_analysis.lower_states import (
    CLOSE_FACE_WEIGHT,
    FACE_WEIGHT,
    ClosedState,
    TwoPrograms,
    closing,
    descent,
)
from orchestrator.limit_analysis.problem import Problem, record_of
from orchestrator.limit_analysis.scattered_starts import scattered_starts, scattered_states
from orchestrator.limit_analysis.search import Search, closed_state, has_complementarity_program, lowest_valid
from orchestrator.limit_analysis.sequence import LimitAnalysisSettings, run_sequence
from orchestrator.limit_analysis.side_by_side import side_by_side
from orchestrator.limit_analysis.standard_view import standard_view
from orchestrator.limit_analysis.state import LimitAnalysis, LimitState
from orchestrator.limit_analysis.yield_conditions import coulomb

logger = logging.getLogger(__name__)

FACE_BALANCE = 1e-5
"""Power that may be out of balance at the upper end of the range that goes with the shift's mechanism: the end moves
by up to 2e-6 with the mechanism's rounding (wall 3: 1e-6 out of balance at 0.40265)."""
SHORT = 6
"""Programs at most of a sequence or shift that begins at a state of the complementarity program."""
NEARLY = 1e-2
"""Largest power out of balance of forces and mechanism that are shown, as not converged, where there is no state."""
LEFT_OUT = "sequence and dilation shift left out for so many blocks"
NOTHING_BALANCES = "no non-associative solution found: complementarity program: no forces and mechanism that balance"


def analyse(
    assemblage: Assemblage,
    settings: LimitAnalysisSettings | None = None,
    load_direction: int = 1,
    loads: Loads | None = None,
) -> LimitAnalysis:
    """Analyse an assemblage under its dead load and lambda times its live load.

    load_direction is +1 or -1 (along x); without `loads` both are the weight of every block. The wall is analysed in
    its standard view: neither its numbering nor the side it is seen from matters. Raises CaseError when the wall
    cannot stand under its dead load or no live load brings it down, ConvergenceError when the associative program
    cannot be solved. A non-associative answer that cannot be found is None, and `remarks` says why. Source:
    formulation.md, section 1.
    """
    assert load_direction in (1, -1)
    started = perf_counter()
    settings = settings or LimitAnalysisSettings()
    view = standard_view(assemblage, load_direction, loads)
    equilibrium = assemble_equilibrium(view.assemblage, 1, view.loads)
    problem = Problem(view.assemblage, equilibrium, coulomb(view.assemblage, equilibrium.dead_total))
    blocks, joints = len(equilibrium.free_blocks), len(assemblage.block_i)
    logger.info("%d blocks, %d joints: does it stand, and Eq. (1)", blocks, joints)
    _, optimum = side_by_side(lambda: refuse_what_falls(problem), lambda: associative_optimum(problem))
    bound = optimum.load_multiplier
    logger.info("associative multiplier %.4f; looking for states without dilation", bound)
    search = Search(problem, settings)
    if len(equilibrium.free_blocks) > settings.search_blocks:
        search.run(optimum)
        sequence, shift, remarks = of_large_wall(problem, optimum, search, settings)
        candidates = search.passed
    else:
        sequence, shift, remarks, candidates = of_small_wall(problem, optimum, search, settings)
    found = search.first
    lowest_state = lowest_valid(problem, candidates)
    complementarity = found and closed_state(problem, *found)
    if lowest_state is None and not any(state.converged for state in (sequence, shift) if state is not None):
        complementarity, remark = nearest_state(problem, candidates)
        remarks += remark
    answer = LimitAnalysis(
        load_direction=1,
        weight=problem.equilibrium.total_weight,
        horizontal_load=problem.equilibrium.base_shear,
        tilting_table=problem.equilibrium.live_load_is_turned_dead_load and problem.friction.scales_with_load,
        associative=problem.state("associative", problem.friction.slope, optimum, optimum, (record_of(optimum, 0.0),)),
        sequence=sequence,
        dilation_shift=shift,
        remarks=remarks,
        seconds=perf_counter() - started,
        complementarity=complementarity,
        lowest=lowest_state,
    )
    return view.carried_back(answer, assemble_equilibrium(assemblage, load_direction, loads))


def of_small_wall(
    problem: Problem, optimum: LimitSolution, search: Search, settings: LimitAnalysisSettings
) -> tuple[LimitState | None, LimitState | None, tuple[str, ...], list[ClosedState]]:
    """Return sequence, dilation shift, remarks, and the states of the search and of descents from these two.

    Another thread runs sequence and shift while this one searches; then both go down from starts around what was found.
    """
    other_programs = TwoPrograms(problem.equilibrium, problem.friction)

    def with_lower(
        found: tuple[LimitState | None, tuple[str, ...]],
    ) -> tuple[LimitState | None, tuple[str, ...], list[ClosedState]]:
        state, remarks = found
        return state, remarks, [] if state is None else list(descent(other_programs, state.mechanism.slip))

    with ThreadPoolExecutor(max_workers=1) as other:
        first = other.submit(lambda: with_lower(sequence_state(problem, other_programs, optimum, settings)))
        second = other.submit(lambda: with_lower(dilation_shift_state(problem, other_programs, settings)))
        search.run(optimum)
        scattered: list[ClosedState] = []
        known = first.result()[0] or second.result()[0]
        if known is not None:
            starts = scattered_starts(problem.assemblage, 1, known.mechanism.slip, settings.search_slips)
            scattered = scattered_states(other, (search.programs, other_programs), starts)
    (sequence, remarks, below_sequence), (shift, more, below_shift) = first.result(), second.result()
    return sequence, shift, remarks + more, search.passed + below_sequence + below_shift + scattered


def of_large_wall(
    problem: Problem, optimum: LimitSolution, search: Search, settings: LimitAnalysisSettings
) -> tuple[LimitState | None, LimitState | None, tuple[str, ...]]:
    """Return sequence and dilation shift from the state that the search has found, and remarks; none of very large."""
    begin = search.first[0] if search.first is not None else None
    very_large = len(problem.equilibrium.free_blocks) > settings.sequence_blocks
    if very_large and (begin is not None or has_complementarity_program(problem.friction)):
        left_out = f"{LEFT_OUT}, more than {settings.sequence_blocks}"
        return None, None, (left_out,) if begin is not None else (left_out, NOTHING_BALANCES)
    start = optimum if begin is None else begin.forces
    settings = settings if begin is None else _shortened(settings)
    other_programs = TwoPrograms(problem.equilibrium, problem.friction)
    (sequence, remarks), (shift, more) = side_by_side(
        lambda: sequence_state(problem, search.programs, start, settings),
        lambda: dilation_shift_state(problem, other_programs, settings, begin),
    )
    return sequence, shift, remarks + more


def _shortened(settings: LimitAnalysisSettings) -> LimitAnalysisSettings:
    """Return the settings for sequence and shift that begin at a state: there they stay, or soon leave."""
    return replace(
        settings,
        seed_cohesions=settings.seed_cohesions[-1:],
        maximum_iterations=max(settings.minimum_iterations, min(settings.maximum_iterations, SHORT)),
        maximum_shift_iterations=min(settings.maximum_shift_iterations, SHORT),
    )


def sequence_state(
    problem: Problem, programs: TwoPrograms, start: LimitSolution, settings: LimitAnalysisSettings
) -> tuple[LimitState | None, tuple[str, ...]]:
    """Return the state the paper's sequence settles on, or None and a remark.

    It goes on from the normal forces of `start`.

    In the mechanism of the last program of Eq. (2) sliding joints close by alpha mu |slip|. The state has the forces in
    Coulomb's cone that go with it (`confirmed`), and the mechanism without any dilation that goes with these forces.
    """
    try:
        iterates, confirmation = run_sequence(problem.equilibrium, problem.friction, start, settings)
        mechanism = programs.mechanism(confirmation.normal)
    except ConvergenceError as error:
        return None, (f"the paper's sequence found no state: {error}",)
    records = [record_of(iterate.solution, iterate.seed) for iterate in iterates]
    records += [record_of(confirmation, 0.0), record_of(mechanism, 0.0)]
    state = problem.state("sequence", problem.no_dilatancy, confirmation, mechanism, tuple(records))
    if state.power_residual > settings.power_tolerance:
        imbalance = f"the power of what it settled on is out of balance by {state.power_residual:.1e}"
        return None, (f"the paper's sequence found no state: {imbalance}",)
    return state, ()


def dilation_shift_state(
    problem: Problem, programs: TwoPrograms, settings: LimitAnalysisSettings, begin: ClosedState | None = None
) -> tuple[LimitState | None, tuple[str, ...]]:
    """Return the lowest state that goes with the slips of the dilation shift.

    The shift stops at an error of 1e-5, which its own last mechanism keeps as interpenetration (5e-6 found) and
    friction that gives power (2e-8). A shift that has settled is therefore closed as every other state of the search
    is: two programs return forces, and a mechanism without dilation, whose power balances to 1e-8 (found: 6e-11 and
    2e-10).
    A shift that has not settled is still returned: its forces balance and respect friction, only the flow rule is
    violated, by what `dilation` says; `converged` is then False and a remark tells.
    """
    slip = None if begin is None else begin.mechanism.rates[:, 2]
    try:
        run = run_dilation_shift(problem.equilibrium, problem.friction, settings, slip)
    except ConvergenceError as error:
        return None, (f"no solution by the dilation shift: {error}",)
    last = run.iterates[-1]
    records = tuple(record_of(iterate.solution, iterate.relaxation) for iterate in run.iterates)
    records += (record_of(run.final, last.relaxation),)
    state = problem.state("dilation_shift", problem.no_dilatancy, run.final, run.final, records, run.settled)
    remark = f"dilation shift not settled after {len(run.iterates)} linear programs: "
    remark += f"the dilation left takes {last.error:.1e} of the live load's power"
    if not run.settled:
        return state, (remark,)
    closed = closing(programs, run.final.rates[:, 2], FACE_WEIGHT if begin is None else CLOSE_FACE_WEIGHT)
    if closed is None:
        return replace(state, converged=False), ("dilation shift settled on no limit state: power does not balance",)
    records += tuple(record_of(solved, last.relaxation) for solved in (closed.forces, closed.mechanism))
    found = (closed.forces.load_multiplier, highest_multiplier(problem, programs, closed))
    state = problem.state("dilation_shift", problem.no_dilatancy, closed.forces, closed.mechanism, records, True, found)
    if not (wrong := problem.complaints(state)):
        return state, ()
    return replace(state, converged=False), (f"dilation shift settled on no limit state: {', '.join(wrong)}",)


def highest_multiplier(problem: Problem, programs: TwoPrograms, closed: ClosedState) -> float:
    """Return the other end of the face of forces that balance the mechanism of a state, to FACE_BALANCE."""
    ends = [closed.forces.load_multiplier]
    for forces in programs.highest_forces(closed.mechanism.rates[:, 2]):
        end = problem.state("dilation_shift", problem.no_dilatancy, forces, closed.mechanism, ())
        if end.power_residual <= FACE_BALANCE:
            ends.append(end.load_multiplier)
            break
    return max(ends)


def nearest_state(problem: Problem, states: Sequence[ClosedState]) -> tuple[LimitState | None, tuple[str, ...]]:
    """Return what is out of balance by least, not converged, if that is not more than NEARLY, and a remark."""
    nearest = min(states, key=lambda state: state.imbalance, default=None)
    if nearest is None or nearest.imbalance > NEARLY:
        return None, ()
    state = replace(closed_state(problem, nearest), converged=False)
    text = f"complementarity program: the nearest forces and mechanism are out of balance by {nearest.imbalance:.1e}"
    wrong = ", ".join(problem.complaints(state))
    return state, (f"{text} ({wrong})" if wrong else text,)
