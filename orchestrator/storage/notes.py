"""What is said of pushovers besides their figures: why they are not valid, what fell, what to do about it.

Macroblocks are elastic inside and carry tension where their inner joints could not. How much depends on the mesh, and
it says nothing of the wall: the stones may carry the same load another way. Whether they can is told by the static
theorem. If the weight and the load at the associative multiplier are each in balance with forces that no joint
refuses, so is every load between. A peak up to that multiplier therefore asks no joint inside a macroblock for
tension; a peak beyond it rests on strength that the stones do not have.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

from orchestrator.basis.printed import printed
from orchestrator.pushover.path.curve_checks import BEYOND
from orchestrator.storage.summary import LimitSummary, PushoverSummary, Summary

TOE_MOMENT = 0.01
"""part of the live load's moment that toes may carry too much before that is told"""
FAR_BEYOND = 0.05
"""part by which a peak may exceed the associative bound (no theorem for large displacements), and one of macroblocks
that of every stone as a rigid block, before that is told"""
CRACK_ELEMENTS = 8
"""elements along a bonded joint below which a peak at which it cracks is doubtful: a block of 0.5 m bears 21 % too much
with three, 5 % with five and 2 % with ten"""
DISTRUST = "distrust the peak"
"""what is said of a peak for which nothing that limit analysis leaves out is a reason"""
COARSE_TOES = "the mesh is too coarse for crushing toes: refine mesh.size"
TOLD = 5
"""local failures that are told one by one"""


def reasons(pushovers: Sequence[PushoverSummary]) -> list[str]:
    """Return why pushovers are not valid."""
    return [f"{pushed.model} FE: {pushed.not_valid_because}" for pushed in pushovers if not pushed.valid]


def is_of_every_stone(pushed: PushoverSummary, stones: int) -> bool:
    """Return whether every one of so many stones was a body: of macroblocks, too, where they are as many."""
    return pushed.model == "micro" or pushed.bodies == stones


def most_that_stones_bear(limit: LimitSummary) -> float:
    """Return the highest multiplier of any state of rigid stones: the associative bound, or what they were found to
    bear in large displacements, for which that is none; infinite where stones touch in points that have no joint."""
    return max(limit.bound, limit.large_displacements or 0.0) if limit.is_bound else inf


def is_to_be_distrusted(pushed: PushoverSummary, limit: LimitSummary, stones: int) -> bool:
    """Return whether every stone as an elastic body bears more than FAR_BEYOND above what rigid stones can."""
    most = (1.0 + FAR_BEYOND) * most_that_stones_bear(limit)
    return is_of_every_stone(pushed, stones) and pushed.peak_multiplier > most


def cautions(pushed: PushoverSummary, limit: LimitSummary, stones: int) -> list[str]:
    """Return what makes a peak doubtful: toes that crush, macroblocks that bear far more than their stones, stones that
    bear far more than they can as rigid ones."""
    said, peak = [], printed("multiplier", pushed.peak_multiplier)
    highest = max(limit.multiplier, *(limit.interval or (0.0,)))
    if not is_of_every_stone(pushed, stones) and pushed.peak_multiplier > (1.0 + FAR_BEYOND) * highest:
        said.append(
            f"{pushed.model} FE: the peak {peak} is more than 5 % above that of every "
            f"stone in limit analysis ({printed('multiplier', highest)}): compare with --model micro"
        )
    if pushed.toe_error > TOE_MOMENT:
        share = f"{100 * pushed.toe_error:.2g} %"
        said.append(
            f"{pushed.model} FE: at the peak, toes that crush carry {share} of the load's moment too much: "
            f"{COARSE_TOES}"
        )
    if pushed.crack_elements is not None and pushed.crack_elements < CRACK_ELEMENTS:
        said.append(
            f"{pushed.model} FE: the peak is too high: bonded joints crack there that have {pushed.crack_elements} "
            "elements along them, and need ten: refine mesh.size"
        )
    if is_to_be_distrusted(pushed, limit, stones):
        most = printed("multiplier", most_that_stones_bear(limit))
        said.append(
            f"{pushed.model} FE: joints crush, and the peak {peak} is more than 5 % above the associative bound "
            f"{most}: {COARSE_TOES}"
            if pushed.crushing
            else f"{pushed.model} FE: {DISTRUST} {peak}: it is more than 5 % above {most}, the most that rigid stones "
            "can bear; look at the deformed wall, and compare with a finer mesh.size"
        )
    return said


def remarks(summary: Summary) -> list[str]:
    """Return what pushovers have to say beside their figures: local failures, macroblocks that carry more than their
    stones can, a peak that was not reached.

    Many events are told in short: the first ones, and how many there were.
    """
    limit, stones, said = summary.limit_analysis, summary.wall.blocks, list[str]()
    bound = limit.bound if limit.is_bound else inf
    for pushed in summary.pushover:
        for event in pushed.events[:TOLD]:
            bodies, share = ", ".join(event.bodies), 100 * event.dead_load_share
            said.append(
                f"{pushed.model} FE: {bodies} ({share:.2g} % of the dead load) fell at a load multiplier of "
                f"{printed('multiplier', event.load_multiplier)}; the wall went on"
            )
        if (more := len(pushed.events) - TOLD) > 0:
            said.append(f"{pushed.model} FE: {more} more local failures, in summary.json")
        said += cautions(pushed, summary.limit_analysis, stones)
        if not is_of_every_stone(pushed, stones) and pushed.peak_multiplier > (1.0 + BEYOND) * bound:
            said.append(
                f"macro FE: the peak {printed('multiplier', pushed.peak_multiplier)} is more than the stones can carry "
                f"without tension inside macroblocks ({printed('multiplier', bound)}, as drawn); "
                "take --model micro, or smaller tolerances"
            )
        if not pushed.peak_reached:
            carried = f"; the wall carries at least {printed('multiplier', pushed.peak_multiplier)}"
            said.append(f"{pushed.model} FE: the peak was not reached" + carried * pushed.valid)
    return said
