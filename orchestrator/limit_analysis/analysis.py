"""Micro limit analysis of an assemblage: all answers for one load direction, each with its checks.

Does it stand (gravity check)? - associative optimum of Eq. (1), a bound - the state that loading from gravity meets,
the headline - the paper's sequence, Eq. (2) - the lowest and highest other states found.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace
from time import perf_counter

from orchestrator.basis.checked import accepted
from orchestrator.basis.errors import ConvergenceError, refuse_other_kind, require_kinds
from orchestrator.basis.printed import as_lambda, counted
from orchestrator.limit_analysis.gravity import (
    GRAVITY_TOLERANCE,
    associative_optimum,
    problem_of,
    refuse_the_verge,
    refuse_what_falls,
)
from orchestrator.limit_analysis.leaning_columns import column_words
from orchestrator.limit_analysis.moved_outlines import blocks_in_each_other
from orchestrator.limit_analysis.paper.equilibrium import assemble_equilibrium
from orchestrator.limit_analysis.paper.limit_state import LimitAnalysis, LimitState
from orchestrator.limit_analysis.paper.linear_program import LimitSolution
from orchestrator.limit_analysis.paper.sequence import LimitAnalysisSettings, run_sequence
from orchestrator.limit_analysis.problem import Problem, record_of
from orchestrator.limit_analysis.remarks import few_move_words, paper_words, points_words, remarks_of
from orchestrator.limit_analysis.search.elastic_contact import STIFFNESSES
from orchestrator.limit_analysis.search.loading import (
    Loaded,
    Road,
    has_path,
    in_large_displacements,
    loaded,
    moving_without_load,
    peeled,
)
from orchestrator.limit_analysis.search.loading_path import SAME_ANSWER, LoadPath, going_down
from orchestrator.limit_analysis.search.lower_states import TwoPrograms
from orchestrator.limit_analysis.search.other_states import (
    closing_state,
    reached,
    states_around,
    touched,
)
from orchestrator.limit_analysis.search.rigid_pushover import DisplacedWallSearch
from orchestrator.limit_analysis.side_by_side import side_by_side
from orchestrator.limit_analysis.standard_view import standard_view
from orchestrator.limit_analysis.turning_joints import edge_words, left_at_hinges
from orchestrator.limit_analysis.wedged_stones import all_going_down
from orchestrator.loads.block_loads import Loads, loads_on, refuse_other_loads
from orchestrator.masonry.block_properties import ELASTIC_MODULUS, ElasticModulus
from orchestrator.masonry.joints import Assemblage, fingerprint_of_wall
from orchestrator.masonry.points_in_common import points_in_common

logger = logging.getLogger(__name__)

MOST_PROGRAMS_FROM_MET = 6
"""Programs at most of a sequence that begins at the state that loading meets."""


def analyse(
    assemblage: Assemblage,
    settings: LimitAnalysisSettings | None = None,
    loads: Loads | None = None,
    elastic_modulus: float = ELASTIC_MODULUS,
) -> LimitAnalysis:
    """Analyse an assemblage under its dead load and lambda times its live load.

    elastic_modulus: of stones that have none of their own, Pa: the state in small displacements depends on ratios of
    stiffness alone, the peak in large ones on weight x size over the modulus, and the headline where that peak is it.
    Without `loads` both are the weight of every block, the live load along +x. The wall is analysed in its standard
    view: neither its numbering nor, unless the live load is upright, the side it is seen from matters. Raises CaseError
    for arguments of another kind, loads of another wall or a modulus of no stone, when the wall cannot stand under its
    dead load, just can, or no live load brings it down, ConvergenceError when the associative program cannot be solved.
    A non-associative answer that cannot be found is None, and `remarks` says why. Source: docs/theory.md.
    """
    started = perf_counter()
    remedy = "write analyse(assemblage, settings, loads), or analyse(assemblage, loads=loads_on(assemblage.wall, load))"
    require_kinds(remedy, assemblage=(assemblage, Assemblage))
    refuse_other_kind("settings", settings, LimitAnalysisSettings, remedy)
    refuse_other_kind("loads", loads, Loads, remedy)
    elastic_modulus = accepted(ElasticModulus, elastic_modulus, "elastic_modulus")
    settings, loads = settings or LimitAnalysisSettings(), loads or loads_on(assemblage.wall)
    refuse_other_loads(assemblage.wall, loads)
    view = standard_view(assemblage, loads)
    problem = problem_of(view.assemblage, view.loads, elastic_modulus)
    blocks, joints = len(problem.equilibrium.free_blocks), assemblage.joints.count
    logger.info("%s, %s: does it stand, and Eq. (1)", counted(blocks, "block"), counted(joints, "joint"))
    _, optimum = side_by_side(lambda: refuse_what_falls(problem), lambda: associative_optimum(problem))
    logger.info("associative multiplier %.4f; loading from gravity", optimum.load_multiplier)
    known = non_associative_of(problem, view.loads, optimum, settings)
    answer = answered(problem, optimum, known, loads, perf_counter() - started)
    borne = answer.headline.load_multiplier * problem.equilibrium.live_total
    least = GRAVITY_TOLERANCE * problem.equilibrium.unit_force
    refuse_the_verge(borne, least, moving_without_load(problem, known.met))
    few = [*few_move_words(problem, view.loads, answer.headline, settings.local_share, bool(answer.local_failures))]
    few += paper_words(problem, view.loads, answer, settings.local_share)
    answer = view.carried_back(answer, assemble_equilibrium(assemblage, loads))
    loose = {stone for failure in answer.local_failures for stone in failure.stones}
    points = points_in_common(assemblage)
    said = blocks_in_each_other(assemblage, answer.drawn or answer.headline, loose)
    leaning = column_words(assemblage, loads, answer.headline, elastic_modulus)
    if not known.falling and (known.met is None or known.met.displaced_rests):  # else nothing is known to be left
        answer = replace(answer, pressed_peak=left_at_hinges(assemblage, answer))
    remarks = (*answer.remarks, *edge_words(answer), *few, *points_words(points), *said, *leaning)
    answer = replace(answer, points_in_common=points, is_bound=not (points or said), remarks=remarks)
    return replace(answer, wall=fingerprint_of_wall(assemblage))


@dataclass(frozen=True, eq=False, slots=True)
class NonAssociative:
    """What is known of a problem beside its associative optimum.

    met: what loading meets, None where it is not loaded; drawn: the state there as drawn, before it is pushed in large
    displacements; falling: ids of the blocks that go down where it does not come to rest; sequence: the paper's state,
    or None; other: the states of the search; remarks: why there is none.
    """

    met: Loaded | None
    drawn: LimitState | None
    falling: tuple[int, ...]
    sequence: LimitState | None
    other: Others
    remarks: tuple[str, ...]


def non_associative_of(
    problem: Problem, loads: Loads, optimum: LimitSolution, settings: LimitAnalysisSettings
) -> NonAssociative:
    """Return what loading meets, the paper's value and other states; loads: of the problem's assemblage."""
    met = None
    if has_path(problem.friction):
        most, pushes = settings.path_blocks, settings.large_displacements
        met = loaded(problem, loads, optimum, settings.local_share, most, pushes)
    sequence, remarks = papers_value(problem, optimum, None if met is None else met.state, settings)
    is_loaded = has_path(problem.friction) and not (met is None and problem.friction.crushes_joints)
    if sequence is not None and not is_loaded:
        met = left_by_sequence(problem, loads, optimum, sequence, settings)
    of_left = sequence
    if met is not None and met.part is not problem and met.path.state is not None:
        of_left = None if met.is_unloaded else papers_value(met.part, met.optimum, met.path.state, settings)[0]
    other = others(problem, optimum, met, of_left, settings)
    met = None if met is None else closed_by_others(met, other)
    drawn = None if met is None else met.state
    met = None if met is None else in_large_displacements(met, problem.assemblage)
    falling = ids_of_falling(problem, loads, met) if is_loaded else ()
    return NonAssociative(met, drawn, falling, sequence, other, remarks)


def left_by_sequence(
    problem: Problem, loads: Loads, optimum: LimitSolution, sequence: LimitState, settings: LimitAnalysisSettings
) -> Loaded | None:
    """Return what the paper's sequence leaves of a wall that has no path when its local failures have been taken away,
    None where it has none; loads: of the problem's assemblage, sequence: the state of the whole wall."""

    def path(part: Problem, its_optimum: LimitSolution) -> LoadPath | None:
        state = sequence if part is problem else sequence_state(part, its_optimum, settings)[0]
        return None if state is None else LoadPath.unloaded(state)

    found = peeled(problem, loads, optimum, settings.local_share, Road(path, lambda part: None))
    return found if found is not None and found.local_failures else None


def ids_of_falling(problem: Problem, loads: Loads, met: Loaded | None) -> tuple[int, ...]:
    """Return the ids of the blocks that go down where a wall does not come to rest under its dead load, in small
    displacements or, as soft as its stones are, in large ones; loads: of the problem's assemblage."""
    if met is None:
        return all_going_down(problem, loads)
    return () if met.displaced_rests else going_down(DisplacedWallSearch(met.part, STIFFNESSES[0]))[0]


def answered(
    problem: Problem, optimum: LimitSolution, known: NonAssociative, loads: Loads, seconds: float
) -> LimitAnalysis:
    """Return all answers; loads: of the wall as given, which the answers name."""
    met = known.met
    return LimitAnalysis(
        loads=loads,
        weight=problem.equilibrium.total_weight,
        vertical_load=problem.equilibrium.dead_total,
        horizontal_load=problem.equilibrium.base_shear,
        tilting_table=problem.equilibrium.live_load_is_turned_dead_load and problem.friction.scales_with_load,
        associative=problem.bound(optimum),
        sequence=known.sequence,
        path=answer_of(met),
        remarks=(*remarks_of(problem, met, known.falling), *known.remarks),
        seconds=seconds,
        lowest=known.other.lowest,
        highest=known.other.highest,
        local_failures=met.local_failures if met else (),
        last_rest=last_rest_of(met),
        soft_from=met.path.soft_from if met else None,
        interval=met.spread if met else None,
        associative_left=bound_left(problem, met),
        elastic_modulus=problem.elastic_modulus,
        rigid_curve=met.pushed.curve if met and met.pushed else None,
        rigid_peak=met.pushed.peak if met and met.pushed and met.pushed.is_past else None,
        ways_out=ways_out_of(met),
        drawn=known.drawn if met and met.geometry_decides else None,
        going_down=known.falling,
        factorisations=met.factorisations if met else 0,
    )


def closed_by_others(met: Loaded, other: Others) -> Loaded:
    """Return the state met as the search for others leaves it: one that the path passed below it, or what closes it."""
    if other.passed is not None and met.state is not None:
        high = max((met.state.load_multiplier, *(met.spread or ())))
        met = replace(met, state=other.passed, spread=(other.passed.load_multiplier, high))
    return met if other.closes is None else replace(met, state=other.closes)


def answer_of(met: Loaded | None) -> LimitState | None:
    """Return the state that loading meets, a peak under its own name, None where a wall was not loaded."""
    if met is None or met.state is None:
        return None
    if not met.geometry_decides:
        return met.state
    return replace(met.state, flow_rule="large_displacements")


def last_rest_of(met: Loaded | None) -> float | None:
    """Return the last load at which a wall was found at rest, None where it was not loaded."""
    if met is not None and met.pushed is not None and (met.is_unloaded or met.geometry_decides):
        return met.pushed.peak
    return None if met is None or met.is_unloaded else met.path.last_rest


def ways_out_of(met: Loaded | None) -> dict[str, int]:
    """Return how often which way out was needed on the path and in the push."""
    if met is None:
        return {}
    pushed = {} if met.pushed is None else met.pushed.counts
    return {f"path {name}": times for name, times in met.path.counts.items()} | {
        f"push {name}": times for name, times in pushed.items()
    }


def bound_left(problem: Problem, met: Loaded | None) -> LimitState | None:
    """Return the associative state of what local failures left of a wall, None where there were none."""
    if met is None or not met.local_failures:
        return None
    return met.of_whole(met.part.bound(met.optimum), problem.assemblage)


def papers_value(
    problem: Problem, optimum: LimitSolution, path: LimitState | None, settings: LimitAnalysisSettings
) -> tuple[LimitState | None, tuple[str, ...]]:
    """Return the state of the paper's sequence, or None and a remark; large walls begin at the state that was met."""
    blocks = len(problem.equilibrium.free_blocks)
    if blocks > settings.sequence_blocks:
        return None, (f"the paper's sequence left out for so many blocks, more than {settings.sequence_blocks}",)
    start = optimum
    if blocks > settings.search_blocks and path is not None:
        start = replace(optimum, joint_forces=path.joint_forces)
        iterations = max(settings.minimum_iterations, min(settings.maximum_iterations, MOST_PROGRAMS_FROM_MET))
        last_seed = settings.seed_cohesions[-1:]
        settings = replace(settings, seed_cohesions=last_seed, maximum_iterations=iterations)
    return sequence_state(problem, start, settings)


def sequence_state(
    problem: Problem, start: LimitSolution, settings: LimitAnalysisSettings
) -> tuple[LimitState | None, tuple[str, ...]]:
    """Return the state the paper's sequence settles on, or None and a remark.

    It goes on from the normal forces of `start`.

    In the mechanism of the last program of Eq. (2) sliding joints close by alpha mu |slip|. The state has the forces in
    Coulomb's cone that go with it (`confirmed`), and the mechanism without any dilation that goes with these forces.
    """
    try:
        iterates, confirmation = run_sequence(problem.equilibrium, problem.friction, start, settings)
        mechanism = TwoPrograms(problem.equilibrium, problem.friction).mechanism(confirmation.normal)
    except ConvergenceError as error:
        return None, (f"the paper's sequence found no state: {error}",)
    records = [record_of(iterate.solution, iterate.seed) for iterate in iterates]
    records += [record_of(confirmation, 0.0), record_of(mechanism, 0.0)]
    state = problem.state("sequence", problem.no_dilatancy, confirmation, mechanism, tuple(records))
    if state.power_residual > settings.power_tolerance:
        imbalance = f"the power of what it settled on is out of balance by {state.power_residual:.1e}"
        return None, (f"the paper's sequence found no state: {imbalance}",)
    if state.load_multiplier <= 0.0:
        held = f"what it settled on would have to be held, at λ = {as_lambda(state.load_multiplier)}"
        return None, (f"the paper's sequence found no state: {held}",)
    return state, ()


@dataclass(frozen=True, eq=False, slots=True)
class Others:
    """Other states found: the lowest and the highest that loading could reach; one that it passes on its way; and where
    it closed none, one that closes its last rest."""

    lowest: LimitState | None
    highest: float | None
    passed: LimitState | None
    closes: LimitState | None


def others(
    problem: Problem,
    optimum: LimitSolution,
    met: Loaded | None,
    sequence: LimitState | None,
    settings: LimitAnalysisSettings,
) -> Others:
    """Return what descents find from the slips of what is known, of the associative optimum where nothing is.

    States of a wall that has lost stones are those of what is left, of which `sequence` is the paper's state. Large
    walls are not searched.
    """
    path = None if met is None else met.path.state
    if met is not None and path is not None:
        part, forces = met.part, None if met.is_unloaded else path.joint_forces
        slips = [path.mechanism.slip] + ([sequence.mechanism.slip] if sequence is not None else [])
    else:
        part, forces, slips = problem, None, [sequence.mechanism.slip if sequence is not None else optimum.rates[:, 2]]
    ends, on_the_way = list[LimitState](), list[LimitState]()
    known = path is not None or sequence is not None
    if not known or len(problem.equilibrium.free_blocks) <= settings.search_blocks:
        way = met.path if met is not None and part is met.part else None
        ends, on_the_way = states_around(part, slips, settings.search_slips if known else 0, way)
    states = reached(part, [*ends, *filter(None, [sequence])], forces)
    passed = closes = None
    if met is not None and path is not None and path.converged:
        passed = touched(part, states, met.path, (1.0 - SAME_ANSWER) * path.load_multiplier)
        states.append(path)
    elif met is not None and path is not None:
        closes = closing_state(part, states, path, SAME_ANSWER)
    states += reached(part, on_the_way, forces)
    lowest = min(states, key=lambda state: state.load_multiplier, default=None)
    highest = max((state.load_multiplier for state in states), default=None)
    if met is not None and path is not None:
        lowest = lowest and met.of_whole(lowest, problem.assemblage)
        passed = passed and met.of_whole(replace(passed, flow_rule="path"), problem.assemblage)
        closes = closes and met.of_whole(closes, problem.assemblage)
    elif lowest is not None and lowest.flow_rule == "descent":
        lowest = replace(lowest, flow_rule="unloaded")
    return Others(lowest, highest, passed, closes)
