"""Micro limit analysis of an assemblage: all answers for one load direction, each with its checks.

Does it stand (gravity check)? - associative optimum of Eq. (1) - the paper's sequence, Eq. (2) - the dilation shift -
the complementarity program - a search for lower states from all of these.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from orchestrator.errors import CaseError, ConvergenceError
from orchestrator.joints import Assemblage
from orchestrator.limit_analysis.complementarity import ComplementarySolution
from orchestrator.limit_analysis.dilation_shift import run_dilation_shift
from orchestrator.limit_analysis.equilibrium import Equilibrium, assemble_equilibrium
from orchestrator.limit_analysis.linear_program import (
    InfeasibleError,
    LimitSolution,
    UnboundedError,
    solve_gravity_lp,
    solve_limit_lp,
)
from orchestrator.limit_analysis.loads import Loads
from orchestrator.limit_analysis.lower_states import (
    ClosedState,
    TwoPrograms,
    complementary_start,
    descent,
    first_tight,
    lowest,
    starts,
)
from orchestrator.limit_analysis.mechanism import dilation, mechanism_from, power_residual
from orchestrator.limit_analysis.scattered_starts import scattered_states
from orchestrator.limit_analysis.sequence import LimitAnalysisSettings, run_sequence
from orchestrator.limit_analysis.state import FlowRule, LimitAnalysis, LimitState, LinearProgramRecord
from orchestrator.limit_analysis.validation import validate
from orchestrator.limit_analysis.yield_conditions import YieldConditions, coulomb
from orchestrator.masonry.wall import FloatArray, read_only

GRAVITY_TOLERANCE, GRAVITY_TOLERANCE_A_BLOCK = 1e-6, 1e-8
"""Missing force, in mean block weights, that passes as rounding in the gravity check, and at least for each block of
the wall: rounding adds up (walls that stand: 1e-8, at 997 blocks 1.4e-7, at 9,955 5e-5)."""
SHORT = 6
"""Programs at most of a sequence or shift that begins at a state of the complementarity program."""
LEFT_OUT = "sequence and dilation shift left out for so many blocks"
NAMED_BLOCKS = 8
"""How many falling blocks an error message names."""


@dataclass(frozen=True, eq=False, slots=True)
class Problem:
    """What all flow rules share: the assemblage, its equilibrium and Coulomb's law in its joints."""

    assemblage: Assemblage
    equilibrium: Equilibrium
    friction: YieldConditions

    @property
    def no_dilatancy(self) -> FloatArray:
        """Dilatancy (k,) of a non-associative mechanism."""
        return np.zeros_like(self.friction.slope)

    def complaints(self, state: LimitState) -> tuple[str, ...]:
        """What the check without the solver finds wrong with a non-associative state."""
        return validate(self.assemblage, self.equilibrium, self.friction, state).complaints

    def state(
        self,
        flow_rule: FlowRule,
        dilatancy: FloatArray,
        forces_of: LimitSolution,
        mechanism_of: LimitSolution,
        records: tuple[LinearProgramRecord, ...],
        converged: bool = True,
        multiplier_range: tuple[float, float] | None = None,
    ) -> LimitState:
        """Put a state together and check it; sliding joints of its mechanism open by dilatancy (k,) times |slip|."""
        equilibrium, friction = self.equilibrium, self.friction
        load_multiplier, forces = forces_of.load_multiplier, forces_of.joint_forces
        mechanism = mechanism_from(self.assemblage.wall, equilibrium, mechanism_of.velocities)
        return LimitState(
            flow_rule=flow_rule,
            load_multiplier=load_multiplier,
            joint_forces=read_only(forces),
            mechanism=mechanism,
            records=records,
            converged=converged,
            equilibrium_residual=equilibrium.residual(forces, load_multiplier),
            yield_residual=friction.excess(forces) / equilibrium.mean_weight,
            power_residual=power_residual(equilibrium, friction, dilatancy, load_multiplier, forces, mechanism),
            dilation=dilation(equilibrium, friction, forces, mechanism),
            multiplier_range=multiplier_range or (load_multiplier, load_multiplier),
        )


def analyse(
    assemblage: Assemblage,
    settings: LimitAnalysisSettings | None = None,
    load_direction: int = 1,
    loads: Loads | None = None,
) -> LimitAnalysis:
    """Analyse an assemblage under its dead load and lambda times its live load.

    load_direction is +1 or -1 (along x); without `loads` both are the weight of every block. Raises CaseError when the
    wall cannot stand under its dead load or no live load brings it down, ConvergenceError when the associative program
    cannot be solved. A non-associative answer that cannot be found is None, and `remarks` says why. Source:
    formulation.md, section 1.
    """
    assert load_direction in (1, -1)
    started = perf_counter()
    settings = settings or LimitAnalysisSettings()
    equilibrium = assemble_equilibrium(assemblage, load_direction, loads)
    problem = Problem(assemblage, equilibrium, coulomb(assemblage, equilibrium.dead_total))
    refuse_what_falls(problem)
    optimum = associative_optimum(problem)
    large = len(problem.equilibrium.free_blocks) > settings.search_blocks
    programs = TwoPrograms(problem.equilibrium, problem.friction)
    found, candidates = complementary_states(problem, programs, load_direction, settings.search_starts, large)
    begin = found[0] if large and found is not None else None
    if begin is not None:
        settings = _shortened(settings)
    if begin is not None and len(equilibrium.free_blocks) > settings.sequence_blocks:
        sequence, shift = None, None
        remarks: tuple[str, ...] = (f"{LEFT_OUT}, more than {settings.sequence_blocks}",)
    else:
        start = optimum if begin is None else begin.forces
        sequence, sequence_remarks = sequence_state(problem, programs, start, settings)
        shift, shift_remarks = dilation_shift_state(problem, programs, settings, begin)
        remarks = sequence_remarks + shift_remarks
    if not large:
        for other in (sequence, shift):
            candidates += descent(programs, other.mechanism.slip, passed=candidates) if other is not None else ()
        if (known := sequence or shift) is not None:
            slip = known.mechanism.slip
            candidates += scattered_states(assemblage, load_direction, programs, slip, settings.search_slips)
    end = lowest(candidates)
    lowest_state = None if end is None else _closed_state(problem, end)
    return LimitAnalysis(
        load_direction=load_direction,
        weight=problem.equilibrium.total_weight,
        horizontal_load=load_direction * problem.equilibrium.base_shear,
        tilting_table=problem.equilibrium.live_load_is_turned_dead_load and problem.friction.scales_with_load,
        associative=problem.state("associative", problem.friction.slope, optimum, optimum, (_record(optimum, 0.0),)),
        sequence=sequence,
        dilation_shift=shift,
        remarks=remarks,
        seconds=perf_counter() - started,
        complementarity=found and _closed_state(problem, *found),
        lowest=lowest_state,
    )


def _shortened(settings: LimitAnalysisSettings) -> LimitAnalysisSettings:
    """Return the settings for sequence and shift that begin at a state: there they stay, or soon leave."""
    return replace(
        settings,
        seed_cohesions=settings.seed_cohesions[-1:],
        maximum_iterations=max(settings.minimum_iterations, min(settings.maximum_iterations, SHORT)),
        maximum_shift_iterations=min(settings.maximum_shift_iterations, SHORT),
    )


def refuse_what_falls(problem: Problem) -> None:
    """Raise CaseError naming the blocks that fall when no joint forces carry the dead load alone."""
    equilibrium, blocks = problem.equilibrium, problem.assemblage.wall.blocks
    missing, velocities = solve_gravity_lp(equilibrium, problem.friction)
    if missing <= max(GRAVITY_TOLERANCE, GRAVITY_TOLERANCE_A_BLOCK * len(equilibrium.free_blocks)):
        return
    moves = np.abs(velocities / equilibrium.row_scale).reshape(-1, 3).max(axis=1) > 1e-3
    falling = [str(blocks[i].id) for i in equilibrium.free_blocks[moves]]
    named = ", ".join(falling[:NAMED_BLOCKS])
    more = f" and {len(falling) - NAMED_BLOCKS} more" if len(falling) > NAMED_BLOCKS else ""
    raise CaseError(
        "wall",
        f"cannot stand under its own weight: blocks {named}{more} move ({missing:.2g} mean block weights are missing)",
        "support these blocks, give them more bearing, or check friction and which blocks are fixed",
    )


def associative_optimum(problem: Problem) -> LimitSolution:
    """Solve Eq. (1), turning what cannot be solved because of the wall into a CaseError."""
    try:
        return solve_limit_lp(problem.equilibrium, problem.friction)
    except UnboundedError as error:
        text = "no live load in this direction brings it down: blocks are wedged between supports"
        raise CaseError("wall", text, "check which blocks are fixed, or reverse the load") from error
    except InfeasibleError as error:
        text = "cannot stand under its own weight: it lacks less than a millionth of a block's weight"
        raise CaseError("wall", text, "the drawing is on the verge of collapse; give blocks more bearing") from error


def sequence_state(
    problem: Problem,
    programs: TwoPrograms,
    start: LimitSolution,
    settings: LimitAnalysisSettings,
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
        return None, (f"no non-associative solution found: {error}",)
    records = [_record(iterate.solution, iterate.seed) for iterate in iterates]
    records += [_record(confirmation, 0.0), _record(mechanism, 0.0)]
    state = problem.state("sequence", problem.no_dilatancy, confirmation, mechanism, tuple(records))
    if state.power_residual > settings.power_tolerance:
        imbalance = f"the power of what it settled on is out of balance by {state.power_residual:.1e}"
        return None, (f"no non-associative solution found: sequence of Eq. (2): {imbalance}",)
    return state, ()


def dilation_shift_state(
    problem: Problem, programs: TwoPrograms, settings: LimitAnalysisSettings, begin: ClosedState | None = None
) -> tuple[LimitState | None, tuple[str, ...]]:
    """Return the lowest state that goes with the mechanism of the dilation shift.

    A shift that has not settled is still returned: its forces balance and respect friction, only the flow rule is
    violated, by what `dilation` says; `converged` is then False and a remark tells.
    """
    slip = None if begin is None else begin.mechanism.rates[:, 2]
    try:
        run = run_dilation_shift(problem.equilibrium, problem.friction, settings, slip)
    except ConvergenceError as error:
        return None, (f"no solution by the dilation shift: {error}",)
    solutions = [*(iterate.solution for iterate in run.iterates), run.final, run.lowest, run.highest]
    records = tuple(_record(solution, settings.shift_relaxation) for solution in solutions)
    found = (run.lowest.load_multiplier, run.highest.load_multiplier)
    state = problem.state("dilation_shift", problem.no_dilatancy, run.lowest, run.final, records, run.settled, found)
    remark = f"dilation shift not settled after {len(run.iterates)} linear programs: "
    remark += f"the dilation left takes {run.iterates[-1].error:.1e} of the live load's power"
    if not run.settled:
        return state, (remark,)
    if not (wrong := problem.complaints(state)):
        return state, ()
    # its lowest forces allow other mechanisms too: many joints slide, and power of opening and closing ones cancelled
    try:
        mechanism = programs.mechanism(run.lowest.normal)
        state = problem.state("dilation_shift", problem.no_dilatancy, run.lowest, mechanism, records, True, found)
        wrong = problem.complaints(state)
    except ConvergenceError as error:
        wrong = (str(error),)
    if not wrong:
        return state, ()
    return replace(state, converged=False), (f"dilation shift settled on no limit state: {', '.join(wrong)}",)


def complementary_states(
    problem: Problem, programs: TwoPrograms, load_direction: int, count: int, one_is_enough: bool
) -> tuple[tuple[ClosedState, ComplementarySolution] | None, list[ClosedState]]:
    """Return the state of the complementarity program and all that `count` starts and the descents from them passed.

    The first is where the first start leads that leads to a state, before any descent: a wall and its mirror image have
    the same. None where nothing balances.
    """
    if problem.friction.tension.any() or problem.friction.crushes.any():
        return None, []  # the complementarity program knows friction and cohesion only
    passed: list[ClosedState] = []
    first = None
    for start in starts(problem.assemblage, load_direction, count):
        found, slip = complementary_start(programs, problem.equilibrium, problem.friction, start)
        reached = []
        for turn in descent(programs, slip, passed=passed):
            reached.append(turn)
            if turn.balances and one_is_enough:
                break
        passed += reached
        if first is None and (state := first_tight(reached)) is not None:
            first = state, found
        if first is not None and one_is_enough:
            break
    return first, passed


def _closed_state(problem: Problem, closed: ClosedState, found: ComplementarySolution | None = None) -> LimitState:
    """Return a state of the search; its records are the complementarity program and the two programs that closed it."""
    records = (
        ()
        if found is None
        else (LinearProgramRecord(found.load_multiplier, 0.0, found.iterations, found.seconds, "complementarity"),)
    )
    solved = (_record(closed.forces, 0.0), _record(closed.mechanism, 0.0))
    return problem.state("complementarity", problem.no_dilatancy, closed.forces, closed.mechanism, (*records, *solved))


def _record(solution: LimitSolution, parameter: float) -> LinearProgramRecord:
    """Return what one linear program gave and cost."""
    return LinearProgramRecord(
        solution.load_multiplier, parameter, solution.iterations, solution.seconds, solution.status
    )
