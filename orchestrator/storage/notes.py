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

from orchestrator.assessment.capacity import OUTSIDE
from orchestrator.basis.printed import millimetres, percent_of, printed, wedged_words
from orchestrator.limit_analysis.turning_joints import FAR_LESS
from orchestrator.pushover.path.curve_checks import BEYOND
from orchestrator.storage.summary import LimitSummary, PushoverSummary, Snap, Summary

TOE_MOMENT = 0.01
"""part of the live load's moment that toes may carry too much before that is told"""
FAR_BEYOND = 0.05
"""part by which a peak may exceed the associative bound (a theorem for small displacements and the joints drawn only),
and one of macroblocks what every stone bears as a rigid block, before it is distrusted or does not count"""
FAR_SHORT = 0.1
"""part by which a peak may lie below the least that every stone bears in limit analysis before that is told (none of 93
does)"""
CRACK_MOMENT = 0.02
"""part of the live load's moment that bonds which crack may carry too much before that is told"""
FALLEN_ROUNDING = 1e-6
"""part of the dead load by which what has fallen may differ with how its weight is added up"""
DISTRUST = "distrust the peak"
"""what is said of a peak for which nothing that limit analysis leaves out is a reason"""
HELD = "held by supports once it has moved: this load does not bring the wall down"
"""what is said of a wall that has no peak because a gap has closed"""
COARSE_TOES = "the mesh is too coarse for crushing toes: refine mesh.size"
TOLD = 5
"""local failures, and bodies that fell under gravity, that are told one by one"""


def reasons(pushovers: Sequence[PushoverSummary]) -> list[str]:
    """Return why pushovers are not valid."""
    return [f"{pushed.model} FE: {pushed.not_valid_because}" for pushed in pushovers if not pushed.valid]


def is_of_every_stone(pushed: PushoverSummary, stones: int) -> bool:
    """Return whether every one of so many stones was a body: of macroblocks, too, where they are as many."""
    return pushed.model == "micro" or pushed.bodies == stones


def is_far(snap: Snap, peak_multiplier: float) -> bool:
    """Return whether a wall that found rest again bears much more than it did before."""
    return snap.load_multiplier < (1.0 - FAR_BEYOND) * peak_multiplier


def bound_at_peak(pushed: PushoverSummary, limit: LimitSummary) -> float:
    """Return the associative multiplier of the wall that is left at a peak, infinite where nothing bounds it, or where
    stones touch in points that have no joint."""
    if not limit.is_bound:
        return inf
    if not pushed.at_peak.fallen:
        return limit.bound
    left = pushed.at_peak.bound_left
    return inf if left is None else max(left, limit.associative_left or 0.0)


def most_that_stones_bear(pushed: PushoverSummary, limit: LimitSummary) -> float:
    """Return the highest multiplier of any state of the rigid stones that are left at a peak: the associative bound, or
    what they were found to bear in large displacements, for which that is none."""
    return max(bound_at_peak(pushed, limit), limit.large_displacements or 0.0)


def is_beyond_the_drawn(pushed: PushoverSummary, limit: LimitSummary, stones: int) -> bool:
    """Return whether every stone as an elastic body bears more than FAR_BEYOND above what rigid stones can that touch
    where they were drawn, in small displacements or as far as they were pushed."""
    most = (1.0 + FAR_BEYOND) * most_that_stones_bear(pushed, limit)
    return is_of_every_stone(pushed, stones) and not pushed.held and pushed.peak_multiplier > most


def is_of_new_contacts(pushed: PushoverSummary, limit: LimitSummary) -> bool:
    """Return whether the wall, as it has moved, bears no more than rigid stones can without contacts that have come."""
    drawn = pushed.at_peak.drawn_contacts
    return drawn is not None and drawn <= (1.0 + FAR_BEYOND) * most_that_stones_bear(pushed, limit)


def is_to_be_distrusted(pushed: PushoverSummary, limit: LimitSummary, stones: int) -> bool:
    """Return whether a peak is beyond what rigid stones can bear, and no contact that has come explains it."""
    return is_beyond_the_drawn(pushed, limit, stones) and not is_of_new_contacts(pushed, limit)


def highest_of_limit_analysis(limit: LimitSummary) -> float:
    """Return the highest multiplier that every stone was found to bear in limit analysis."""
    return max(limit.multiplier, limit.large_displacements or 0.0, *(limit.interval or (0.0,)))


def contradicts(pushed: PushoverSummary, limit: LimitSummary, stones: int) -> bool:
    """Return whether macroblocks bear more than FAR_BEYOND above every stone in limit analysis: they do not count."""
    most = (1.0 + FAR_BEYOND) * highest_of_limit_analysis(limit)
    return not is_of_every_stone(pushed, stones) and pushed.peak_multiplier > most


def first_of_valid(pushovers: Sequence[PushoverSummary]) -> PushoverSummary | None:
    """Return the valid pushover of every stone, else that of macroblocks, None where none is valid."""
    valid = {pushed.model: pushed for pushed in pushovers if pushed.valid}
    return valid.get("micro") or valid.get("macro")


def why_not(pushed: PushoverSummary, limit: LimitSummary, stones: int) -> str | None:
    """Return why the peak of a valid curve does not count, and limit analysis does; None where it counts."""
    if pushed.held:
        return f"{pushed.model} FE: {HELD}"
    if contradicts(pushed, limit, stones):
        return (
            f"{pushed.model} FE: the peak {printed('multiplier', pushed.peak_multiplier)} is more than 5 % above that "
            f"of every stone in limit analysis ({printed('multiplier', highest_of_limit_analysis(limit))}), and does "
            "not count: compare with --model micro"
        )
    return None


def counts(summary: Summary) -> bool:
    """Return whether a run has a finite element number that counts, or is held, or was not to have one."""
    pushed = first_of_valid(summary.pushover)
    return pushed is None or not contradicts(pushed, summary.limit_analysis, summary.wall.blocks)


def fallen_alone(pushed: PushoverSummary, limit: LimitSummary) -> float:
    """Return how much more of the dead load has fallen at a peak than in limit analysis, or less (< 0)."""
    more = pushed.at_peak.fallen - sum(failure.share for failure in limit.local_failures)
    return more if abs(more) > FALLEN_ROUNDING else 0.0


def cautions(pushed: PushoverSummary, limit: LimitSummary, stones: int) -> list[str]:
    """Return what makes a peak doubtful, or that it is of another wall than was drawn: what has fallen, contacts that
    have come, toes that crush, stones that bear far more than they can as rigid ones."""
    said, peak, at_peak = [], printed("multiplier", pushed.peak_multiplier), pushed.at_peak
    if at_peak.fallen:
        said.append(
            f"{pushed.model} FE: the peak is of what is left when {100 * at_peak.fallen:.2g} % of the dead load has "
            "fallen"
        )
    if pushed.toe_error > TOE_MOMENT:
        share = f"{100 * pushed.toe_error:.2g} %"
        said.append(
            f"{pushed.model} FE: at the peak, toes that crush carry {share} of the load's moment too much: "
            f"{COARSE_TOES}"
        )
    if pushed.crack_error > CRACK_MOMENT and pushed.valid:
        said.append(
            f"{pushed.model} FE: the peak may be {percent_of(pushed.crack_error)} too high, as elements are too long "
            f"where bonds crack: refine mesh.size, {millimetres(pushed.crack_size)} are enough"
        )
    if not is_beyond_the_drawn(pushed, limit, stones):
        found = max(limit.multiplier, limit.large_displacements or 0.0)
        far = not pushed.held and pushed.peak_multiplier > (1.0 + FAR_BEYOND) * found
        if far and is_of_every_stone(pushed, stones):
            in_place = ", with what has fallen here in its place" * (fallen_alone(pushed, limit) > 0.0)
            said.append(
                f"{pushed.model} FE: the peak {peak} is more than 5 % above {printed('multiplier', found)}, what every "
                f"stone bears in limit analysis{in_place}: friction may lead to another state, or elements are too "
                "long: compare with a quarter of mesh.size"
            )
        return said
    most = printed("multiplier", most_that_stones_bear(pushed, limit))
    if at_peak.drawn_contacts is not None and is_of_new_contacts(pushed, limit):
        bears = f"bears at most {printed('multiplier', at_peak.drawn_contacts)}"
        said.append(
            f"{pushed.model} FE: the peak {peak} is more than 5 % above {most}, the most that the joints drawn can "
            "bear, as a gap has closed or a stone has moved onto another: without contacts that were not drawn the "
            f"wall, as it has moved, {bears if at_peak.drawn_contacts else 'does not stand'}"
        )
    elif pushed.crushing:
        said.append(
            f"{pushed.model} FE: joints crush, and the peak {peak} is more than 5 % above the associative bound "
            f"{most}: {COARSE_TOES}"
        )
    else:
        said.append(
            f"{pushed.model} FE: {DISTRUST} {peak}: it is more than 5 % above {most}, the most that rigid stones can "
            "bear in small displacements, or as far as they were pushed; look at the deformed wall, and compare with "
            "a finer mesh.size"
        )
    return said


def _far_short(pushed: PushoverSummary, limit: LimitSummary, stones: int) -> list[str]:
    """Return that every stone bears far less than what loading meets in limit analysis, where the same has fallen."""
    peaks = (*(limit.interval or ()), limit.rigid_peak, limit.pressed_peak)
    least = min(limit.multiplier, *(peak for peak in peaks if peak is not None), inf)
    is_state = limit.kind != "an upper bound only" and not (limit.going_down or fallen_alone(pushed, limit))
    reached = pushed.valid and pushed.peak_reached and is_of_every_stone(pushed, stones)
    if not (is_state and reached and pushed.peak_multiplier < (1.0 - FAR_SHORT) * least):
        return []
    peak, bears = printed("multiplier", pushed.peak_multiplier), printed("multiplier", least)
    found = ""
    if limit.lowest is not None and limit.lowest <= pushed.peak_multiplier:
        found = f", as were found from {printed('multiplier', limit.lowest)} on"
    return [
        f"{pushed.model} FE: the peak {peak} is more than 10 % below {bears}, the least that every stone bears in "
        f"limit analysis as loading meets it: friction may lead to another state{found}, or elements are too long: "
        "compare with a quarter of mesh.size"
    ]


def _fell_under_gravity(pushed: PushoverSummary, limit: LimitSummary) -> list[str]:
    """Return what fell before any live load acted, why that may be, and what to try."""
    events = [event for event in pushed.events if event.under_gravity]
    if not events:
        return []
    bodies = [body for event in events for body in event.bodies]
    names = ", ".join(bodies[:TOLD]) + f" and {len(bodies) - TOLD} more" * (len(bodies) > TOLD)
    share = 100 * sum(event.dead_load_share for event in events)
    said = (
        f"{pushed.model} FE: {names} ({share:.2g} % of the dead load) fell under the dead load alone; the wall went on"
    )
    if limit.going_down:
        return [f"{said}: in limit analysis, too, stones go down there unless they are wedged"]
    if any(not high for _, high in (loose.multipliers for loose in limit.local_failures)):
        return [f"{said}: in limit analysis, too, stones come loose under next to no live load, or none"]
    return [
        f"{said}: in finite elements joints slip by up to contact.slip_tolerance before friction holds; limit analysis "
        "has all stones standing there: try a smaller contact.slip_tolerance"
    ]


def standing_is_open(limit: LimitSummary) -> str | None:
    """Return that limit analysis leaves open whether a wall stands, and why; None where it does not."""
    return f"whether the wall stands is open: {wedged_words(limit.going_down)}" if limit.going_down else None


def rigid_stones_alone(limit: LimitSummary) -> str | None:
    """Return that limit analysis speaks of rigid stones, where stones that give way at edges bear far less; None where
    they do not."""
    bears = min(limit.multiplier, limit.rigid_peak or limit.multiplier)
    far_less = limit.pressed_peak is not None and limit.pressed_peak < (1.0 - FAR_LESS) * bears
    return "rigid stones bear far more than is left as they give way at edges" if far_less else None


def without_reference(summary: Summary) -> str | None:
    """Return that the pushover of every stone, the reference of macroblocks, did not come to its end; None where it
    did, or was not to be made."""
    if any(pushed.model == "micro" and not pushed.valid for pushed in summary.pushover):
        return "the curve of every stone, the reference of macroblocks, is not valid"
    if "micro" in (summary.failed or {}):
        return "every stone, the reference of macroblocks, has no curve"
    return None


def remarks(summary: Summary) -> list[str]:
    """Return what pushovers have to say beside their figures: local failures, macroblocks that carry more than their
    stones can, a top that moves against the load, a peak that was not reached, or that supports hold the wall.

    Many events are told in short: the first ones, and how many there were.
    """
    stones, said = summary.wall.blocks, list[str]()
    for pushed in summary.pushover:
        said += _fell_under_gravity(pushed, summary.limit_analysis)
        events = [event for event in pushed.events if not event.under_gravity]
        for event in events[:TOLD]:
            bodies, share = ", ".join(event.bodies), 100 * event.dead_load_share
            when = "after the peak, " if event.increment > pushed.at_peak.increment > 0 else ""
            said.append(
                f"{pushed.model} FE: {bodies} ({share:.2g} % of the dead load) fell {when}at a load multiplier of "
                f"{printed('multiplier', event.load_multiplier)}; the wall went on"
            )
        if (more := len(events) - TOLD) > 0:
            said.append(f"{pushed.model} FE: {more} more local failures, in summary.json")
        if pushed.valid and (why := why_not(pushed, summary.limit_analysis, stones)):
            said.append(why)
        said += cautions(pushed, summary.limit_analysis, stones)
        said += [] if summary.wall.bonded else _far_short(pushed, summary.limit_analysis, stones)  # bonds break
        bound = bound_at_peak(pushed, summary.limit_analysis)
        of_stones = pushed.held or is_of_every_stone(pushed, stones)
        if not of_stones and pushed.peak_multiplier > (1.0 + BEYOND) * bound:
            said.append(
                f"macro FE: the peak {printed('multiplier', pushed.peak_multiplier)} is more than the stones can carry "
                f"without tension inside macroblocks ({printed('multiplier', bound)}, as drawn); "
                "take --model micro"
            )
        if pushed.initial_stiffness is None and pushed.control_share > 0.0:
            said.append(
                f"{pushed.model} FE: at first the mean of the top edge moves against the live load: base shear over "
                "that displacement is no stiffness of the wall, and none is given"
            )
        if pushed.control_share < OUTSIDE:
            said.append(
                f"{pushed.model} FE: the mean of the top edge moves {percent_of(pushed.control_share)} of the stone "
                "that goes farthest: it is outside the mechanism; displacements and stiffness of this curve are not of "
                "what fails"
            )
        if pushed.snap is not None and is_far(pushed.snap, pushed.peak_multiplier):
            lost, moved = printed("multiplier", pushed.snap.load_multiplier), f"{1e3 * pushed.snap.moved:.3g}"
            of_peak = pushed.snap.share
            way = (
                f"a part of it had gone {moved} mm, which its top does not show"
                if of_peak is None
                else f"its top had moved by {moved} mm, {percent_of(of_peak)} of what it has moved at its peak"
            )
            said.append(
                f"{pushed.model} FE: beyond λ = {lost} the wall found no rest before {way}: motion has no inertia "
                "here, and an earthquake may carry it on"
                if pushed.snap.bore_less
                else f"{pushed.model} FE: by the load after λ = {lost} {way}, bearing more and more: whether it rests "
                "on the way a smaller stepping.load_increment tells"
            )
        if pushed.spike is not None and pushed.control_share >= OUTSIDE:
            left, moved = printed("multiplier", pushed.spike.load_multiplier), f"{1e3 * pushed.spike.moved:.2g}"
            said.append(
                f"{pushed.model} FE: the peak is a spike: when its top has moved by {moved} mm more the wall bears λ = "
                f"{left}; such a peak may depend on the elements: compare with a quarter of mesh.size"
            )
        if not (pushed.peak_reached or pushed.held):
            carried = f"; the wall carries at least {printed('multiplier', pushed.peak_multiplier)}"
            said.append(f"{pushed.model} FE: the peak was not reached" + carried * pushed.valid)
    return said
