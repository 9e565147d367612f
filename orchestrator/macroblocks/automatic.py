"""Macroblocks without tolerances: few bodies that, loaded as rigid ones, fail where the wall fails stone by stone.

Joining again and again the two neighbours that lose least energy when they lock (locking.py) leads from every stone to
one body. First the partition with fewest bodies is taken that still has a limit state within a margin of micro limit
analysis; then bodies that are not needed for it are joined, one pair after the other. One body is never taken: it can
only slide or overturn on its support.

Non-associative states are not unique, and bodies that can take fewer motions than the stones may meet another. Two
are therefore kept, each by its own mechanism: the headline and the paper's. With the headline alone 3 bodies for 71
stones (random 7 of docs/studies) bear 18 % more than these in finite elements; the lowest found too asks for 43 bodies
instead of 9 on benchmark 2. States are looked for on the bodies by a descent from the slips they had (lower_states),
which costs a few milliseconds.

That a state exists does not say that loading leads to it. So the bodies are loaded from gravity (path_of_bodies.py).
Where they fail elsewhere than the stones do, where no limit state of the stones was closed, or where few bodies are
saved, others are looked for that do not, for as much work as loading the stones was. Where none are found a tenth of
the stones is what is begun with: macroblocks are refined when they are pushed (refinement.py). Stones that come loose
before stay bodies; others are chosen for the wall without them, whose lowest state is kept in the place of the paper's,
which is that of these stones.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from orchestrator.basis.errors import ConvergenceError, require_kinds
from orchestrator.basis.printed import as_lambda
from orchestrator.limit_analysis import LimitAnalysis, LimitState
from orchestrator.limit_analysis.paper.limit_state import of_first_joints, refuse_other_analysis
from orchestrator.limit_analysis.paper.linear_program import solve_limit_lp
from orchestrator.limit_analysis.search.lower_states import POWER_LEFT, TwoPrograms, descent
from orchestrator.limit_analysis.search.what_is_left import joints_left, part_of
from orchestrator.macroblocks.criteria import (
    TOLERANCES,
    MacroblockSettings,
    Partition,
    merged,
    one_body,
    partition_of,
    stones_of,
)
from orchestrator.macroblocks.locking import hierarchy, pairs_by_loss
from orchestrator.macroblocks.merged_blocks import merged_problem
from orchestrator.macroblocks.path_of_bodies import as_far_apart, off_headline, work_of
from orchestrator.masonry.joints import Assemblage

logger = logging.getLogger(__name__)

ANOTHER = 1e-4
"""Part of the multiplier by which another state differs at least."""

ELSEWHERE = (
    "loaded from gravity these bodies fail at another multiplier than every stone: compare with run --model micro"
)
"""remark on bodies that, as rigid ones, do not meet the state of the stones"""
EVERY_STONE = "every stone is a macroblock: no two of them share a joint, or there are only two"
"""remark on walls that have no coarser bodies than their stones, but one"""
NO_FEWER = "every stone is a macroblock: no fewer bodies were found that keep what every stone bears"
"""remark where none that were tried do"""
FIRST = 0.1
"""bodies over stones where no bodies are known that keep a state of the stones or fail where these do"""
UNPROVEN = (
    "chosen automatically: one for ten stones, and at least two, joined where least energy is lost; no bodies were "
    "found that fail where every stone does: compare with run --model micro"
)
"""remark on such bodies"""
NEAREST = "chosen automatically: of the bodies that were loaded, those that fail nearest to where every stone does"
"""remark on bodies of which none fail where the stones do"""


def macroblocks_of(
    assemblage: Assemblage,
    analysis: LimitAnalysis,
    criteria: MacroblockSettings | None = None,
    tied: Assemblage | None = None,
) -> Partition:
    """Return macroblocks by the criteria's tolerances (`merged`, which may raise CaseError) where they say so or one is
    not the default; else, without criteria too, those that are `chosen` under the loads of the analysis.

    tied: with ties after the joints of `assemblage`, where the analysis has them: they hold bodies, and join none.
    Raises CaseError for an analysis of another wall and for arguments of another kind.
    """
    kinds = {"assemblage": (assemblage, Assemblage), "analysis": (analysis, LimitAnalysis)}
    require_kinds("write macroblocks_of(assemblage, analysis)", **kinds)
    refuse_other_analysis(tied or assemblage, analysis)
    criteria = criteria or MacroblockSettings()
    by_tolerances = any(getattr(criteria, name) != getattr(MacroblockSettings(), name) for name in TOLERANCES)
    if criteria.choose == "tolerances" or by_tolerances:
        of_joints = of_first_joints(analysis, assemblage.joints.count)
        return merged(assemblage, of_joints.headline.mechanism, criteria)
    return chosen(assemblage, analysis, criteria.margin, tied)


def states_to_keep(analysis: LimitAnalysis) -> list[LimitState]:
    """Return the headline and, where it is another state, the paper's: bodies may meet either."""
    headline, paper = analysis.headline, analysis.sequence
    if paper is None or abs(paper.load_multiplier - headline.load_multiplier) <= ANOTHER * headline.load_multiplier:
        return [headline]
    return [headline, paper]


def chosen(
    assemblage: Assemblage,
    analysis: LimitAnalysis,
    margin: float,
    tied: Assemblage | None = None,
) -> Partition:
    """Return few bodies that keep the states of micro-LA within `margin`, part of it, and meet the headline's.

    tied: as in `macroblocks_of`. Every stone stays a body where nothing coarser does; a wall of one block is one body.
    Where geometry decides, bodies keep the state in small displacements, which has a mechanism, and may fail anywhere
    between it and the peak.
    """
    tied = tied or assemblage
    if analysis.drawn:
        low, high = sorted((analysis.drawn.load_multiplier, analysis.headline.load_multiplier))
        analysis = replace(analysis, path=analysis.drawn, interval=analysis.interval or (low, high))
    if analysis.local_failures:
        return _chosen_without_loose_stones(assemblage, analysis, margin, tied)
    stones, every_stone = stones_of(assemblage), partition_of(assemblage, np.arange(len(assemblage.wall.blocks)))
    if stones <= 2 or one_body(assemblage).count == stones:
        return replace(every_stone, remarks=(EVERY_STONE,))
    partition, said = _of_states(assemblage, analysis, margin, tied, every_stone)
    remarks = [said]
    if analysis.path is not None:
        partition, remarks = _by_path(assemblage, analysis, margin, partition, said)
    if partition.count == stones:
        remarks.append(NO_FEWER)
    elif 2 * partition.count > stones:
        remarks.append(
            f"{partition.count} macroblocks of {stones} stones save little: run --model micro has every stone"
        )
    return replace(partition, remarks=(*remarks, *partition.remarks))


def _of_states(
    assemblage: Assemblage, analysis: LimitAnalysis, margin: float, tied: Assemblage, every_stone: Partition
) -> tuple[Partition, str]:
    """Return the fewest bodies found that have the states of micro-LA, and in words at which multipliers."""
    states = states_to_keep(analysis)
    mechanisms = [state.mechanism for state in states]

    def kept(partition: Partition) -> list[float]:
        """Return the multipliers found for the states, as far as the first that is lost."""
        multipliers = []
        logger.info("macroblocks: trying %d bodies", partition.count)
        for state in states:
            multiplier = kept_multiplier(tied, analysis, state, partition, margin)
            if multiplier is None:
                break
            multipliers.append(multiplier)
        return multipliers

    def keeps(partition: Partition) -> bool:
        return partition.count > 1 and len(kept(partition)) == len(states)

    partition = every_stone
    if keeps(partition):  # else no state was closed that any bodies could keep
        partition = _coarsest([partition_of(assemblage, g) for g in hierarchy(assemblage, mechanisms)][::-1], keeps)
        partition = joined_while(keeps, partition, assemblage, pairs_by_loss(partition, assemblage, mechanisms))
    words = " and ".join(
        f"{as_lambda(multiplier)} (every stone {as_lambda(state.load_multiplier)})"
        for multiplier, state in zip(kept(partition), states, strict=False)
    )
    return partition, f"chosen automatically: multiplier as rigid bodies {words or 'not found'}, margin {margin:.3g}"


def _by_path(
    assemblage: Assemblage, analysis: LimitAnalysis, margin: float, partition: Partition, said: str
) -> tuple[Partition, list[str]]:
    """Return bodies that have the states of the stones, or others that fail where these do or nearer to it, and why."""
    stones = stones_of(assemblage)
    work, off = analysis.factorisations * work_of(stones), np.inf
    if partition.count < stones:
        off, spent = off_headline(assemblage, analysis, partition, np.inf)
        work -= spent
    alike = off <= as_far_apart(margin)
    if alike and 2 * partition.count <= stones:
        return partition, [said]
    bodies, nearest = _by_loading(assemblage, analysis, margin, off, work)
    if bodies is not None and (not alike or bodies.count < partition.count):
        return bodies, [_said_of_loading(analysis, margin)]
    if alike:
        return partition, [said]
    if nearest is not None:
        return nearest, [NEAREST, ELSEWHERE]
    return (partition, [said, ELSEWHERE]) if partition.count < stones else (_first(assemblage, analysis), [UNPROVEN])


def _first(assemblage: Assemblage, analysis: LimitAnalysis) -> Partition:
    """Return the bodies, FIRST of the stones and at least two, that lose least energy when their stones lock."""
    groups = hierarchy(assemblage, [state.mechanism for state in states_to_keep(analysis)])[::-1]
    stones = stones_of(assemblage)
    fewest = stones - len(groups) + 1  # more than one where columns of stones do not touch
    return partition_of(assemblage, groups[max(0, max(2, round(FIRST * stones)) - fewest)])


def _said_of_loading(analysis: LimitAnalysis, margin: float) -> str:
    fail = as_lambda(analysis.headline.load_multiplier)
    return (
        "chosen automatically: loaded from gravity as rigid bodies they fail where every stone does "
        f"({fail}), within {as_far_apart(margin):.3g}; no fewer were found that do"
    )


def _by_loading(
    assemblage: Assemblage, analysis: LimitAnalysis, margin: float, off: float, work: float
) -> tuple[Partition | None, Partition | None]:
    """Return bodies that fail where the stones do when they are loaded, None where none were found for so much work
    (`work_of`); and those of at most half the stones that fail nearest to it, None where none do nearer than `off`."""
    mechanisms = [state.mechanism for state in states_to_keep(analysis)]
    groups = hierarchy(assemblage, mechanisms)[::-1]  # from one body, or as many as do not touch, to every stone
    stones, alike, nearest = stones_of(assemblage), None, None
    most = max(1, max(2, 3 * stones // 4) - (stones - len(groups)))

    def fails_alike(partition: Partition) -> bool:
        nonlocal work, alike, nearest, off
        if work <= 0 or partition.count < 2:
            return False
        distance, spent = off_headline(assemblage, analysis, partition, max(off, as_far_apart(margin)))
        work -= spent
        if distance < off and 2 * partition.count <= stones:
            off, nearest = distance, partition
        if distance > as_far_apart(margin):
            return False
        alike = partition
        return True

    loaded = [partition_of(assemblage, group) for group in groups[:most]]
    loaded = [partition for partition in loaded if partition.count > 1]
    if len(loaded) > 2:
        _coarsest(loaded, fails_alike)
    else:  # `_coarsest` would try none of them
        any(fails_alike(partition) for partition in loaded)  # stops at the first that does
    if alike is None:
        return None, nearest
    return joined_while(fails_alike, alike, assemblage, pairs_by_loss(alike, assemblage, mechanisms)), None


def joined_while(
    keeps: Callable[[Partition], bool], partition: Partition, assemblage: Assemblage, pairs: Sequence[tuple[int, int]]
) -> Partition:
    """Join the bodies of pairs of blocks, one pair after the other, each where `keeps` holds then.

    What bodies have lost they hardly ever have again when they are joined further. So as many pairs are joined at once
    as went well before, twice as many each time, and the first that does not is found by halving.
    """
    done, at_once = 0, len(pairs)
    while done < len(pairs):
        began, too_far = done, len(pairs) + 1
        while too_far > done + 1:
            upto = min(done + at_once, len(pairs)) if too_far > len(pairs) else (done + too_far) // 2
            coarser = _joined(partition, assemblage, pairs[done:upto])
            if coarser.count == partition.count or keeps(coarser):
                partition, done, at_once = coarser, upto, 2 * at_once
            else:
                too_far = upto
        done, at_once = done + 1, max(1, done - began)
    return partition


def _joined(partition: Partition, assemblage: Assemblage, pairs: Sequence[tuple[int, int]]) -> Partition:
    """Return the partition in which the bodies of all these pairs of blocks are one."""
    group = partition.body_of_block
    for i, j in pairs:
        group = np.where(group == group[j], group[i], group)
    return partition_of(assemblage, group)


def _chosen_without_loose_stones(
    assemblage: Assemblage, analysis: LimitAnalysis, margin: float, tied: Assemblage
) -> Partition:
    """Return the partition chosen for the wall without the stones of local failures: these stay bodies of their own.

    The paper's state is that of the wall as drawn: the lowest state of what is left is kept in its place.
    """
    loose = {stone for failure in analysis.local_failures for stone in failure.stones}
    left = np.array([block.id not in loose for block in assemblage.wall.blocks])
    joints = joints_left(tied, left)

    def of_left(state: LimitState) -> LimitState:
        moves = state.mechanism
        mechanism = replace(
            moves, velocities=moves.velocities[left], opening=moves.opening[joints], slip=moves.slip[joints]
        )
        return replace(state, joint_forces=state.joint_forces[joints], mechanism=mechanism)

    met, lowest, loads = of_left(analysis.headline), analysis.lowest, analysis.loads.of_blocks(left)
    other = None if lowest is None else of_left(lowest)
    of_part = replace(
        analysis, loads=loads, associative=of_left(analysis.bound), associative_left=None,
        path=met, sequence=other, drawn=None, local_failures=(),
    )  # fmt: skip
    part = chosen(part_of(assemblage, left), of_part, margin, part_of(tied, left))
    group = len(left) + np.arange(len(left))
    group[left] = part.body_of_block
    partition = partition_of(assemblage, group)
    said = f"come loose before the wall fails and stay bodies of their own: {', '.join(map(str, sorted(loose)))}"
    return replace(partition, remarks=(*part.remarks, said))


def kept_multiplier(
    assemblage: Assemblage,
    analysis: LimitAnalysis,
    state: LimitState,
    partition: Partition,
    margin: float,
) -> float | None:
    """Return the multiplier within `margin` of a state of micro-LA that the bodies have as rigid ones, None if none.

    Non-associative states are not unique. That of micro-LA is one of the bodies where its forces between them have a
    mechanism (they balance on any bodies); else one near it is reached by a descent from the slips it had.
    """
    equilibrium, friction = merged_problem(assemblage, partition.body_of_block, analysis.loads)
    micro = state.load_multiplier
    try:
        if state.flow_rule == "associative":
            found = solve_limit_lp(equilibrium, friction).load_multiplier
            return found if abs(found - micro) <= margin * micro else None
        remains = partition.body_of_block[assemblage.joints.i] != partition.body_of_block[assemblage.joints.j]
        programs, normal = TwoPrograms(equilibrium, friction), state.joint_forces[remains, :2].sum(axis=1)
        if abs(programs.mechanism(normal).load_multiplier - micro) <= POWER_LEFT * micro:
            return micro
        for turn in descent(programs, state.mechanism.slip[remains]):
            found = turn.forces.load_multiplier
            if turn.balances and found <= (1.0 + margin) * micro:  # later ones lie lower, as a rule
                return found if found >= (1.0 - margin) * micro else None
    except ConvergenceError:
        pass
    return None


def _coarsest(coarse_to_fine: Sequence[Partition], keeps: Callable[[Partition], bool]) -> Partition:
    """Return the first that keeps the multiplier, looked for in steps of a quarter and then by halving.

    The multiplier hardly ever grows from coarse to fine (the associative one never does), so that halving finds it.
    """
    last = len(coarse_to_fine) - 1
    low, high = 0, min(1, last)
    while high < last and not keeps(coarse_to_fine[high]):
        low, high = high, min(high + 1 + high // 4, last)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if keeps(coarse_to_fine[middle]) else (middle, high)
    return coarse_to_fine[high]
