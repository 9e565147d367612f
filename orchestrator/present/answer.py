"""Which of several numbers counts, and why: one sentence for the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

from orchestrator.assessment.sensitivity import ALIKE
from orchestrator.basis.printed import percent_more, percent_of, printed
from orchestrator.limit_analysis import LimitAnalysis
from orchestrator.limit_analysis.search.loading_path import SAME_ANSWER
from orchestrator.limit_analysis.turning_joints import FAR_LESS, edges_take
from orchestrator.present.weights import applied_words
from orchestrator.space.analysis import BRACKET
from orchestrator.space.found import SpaceAnalysis
from orchestrator.storage import PushoverSummary, Summary
from orchestrator.storage.notes import (
    DISTRUST,
    FAR_BEYOND,
    HELD,
    contradicts,
    fallen_alone,
    first_of_valid,
    highest_of_limit_analysis,
    is_beyond_the_drawn,
    is_of_every_stone,
    is_to_be_distrusted,
    most_that_stones_bear,
    rigid_stones_alone,
    standing_is_open,
    without_reference,
)
from orchestrator.storage.summary import Kind, LimitSummary

WITHOUT_LOADING = ("sequence", "unloaded")
"""flow rules of states of walls that were not loaded"""
OPEN = "Whether it stands is open; if it does, "
"""what is said first of a wall that does not come to rest under its dead load unless it is wedged"""

NO_CAPACITY = "is no capacity"
"""what is said in the place of "counts" of a bound"""


def answer_of_limit(analysis: LimitAnalysis) -> str:
    """Return the sentence on a limit analysis: the multiplier that counts, its load, and how sure it is."""
    state, bound = analysis.headline, analysis.bound.load_multiplier
    multiplier = state.load_multiplier
    shear = f"{applied_words(multiplier, state.horizontal_load, analysis.upright_load)}, {_without(analysis)}"
    whose = " for rigid stones" if edges_take(analysis, FAR_LESS) else ""
    counts = f"λ = {_limit(multiplier)} counts{whose} ({state.name}): "
    if analysis.going_down:
        counts = f"{OPEN}{counts}"
    if not state.converged and state is not analysis.associative:
        rest = f"Loading met no limit state; the wall was at rest up to λ = ({_limit(multiplier)}): {shear}"
        of_what = ""
        if analysis.geometry_decides:
            least = "" if analysis.rigid_peak is not None else "at least "
            is_loaded = analysis.drawn is None or analysis.drawn.flow_rule != "smoothed"
            why = "Geometry decides: in" if is_loaded and analysis.is_of_geometry else "In"
            bears = "rigid stones bear" if whose else "the wall bears"
            rest = f"{why} large displacements {bears} {least}λ = ({_limit(multiplier)}): {shear}"
            of_what = " in small displacements"
        elsewhere = f"{_found_elsewhere(analysis)}{_bounds(bound, analysis.is_bound, of_what)}"
        return f"{rest}{elsewhere}{_lower_when_moved(analysis, _lowest(analysis))}"
    if state is analysis.associative:
        why = "an upper bound only, as no state with friction that does not dilate was found."
        return f"{_no_capacity(counts)}{shear}{why}"
    low, high = _lowest(analysis), (analysis.non_associative_range or (multiplier, multiplier))[1]
    left = " of what is left" * bool(analysis.local_failures)
    why = _why(low, high, bound, analysis.is_bound, left)
    return f"{counts}{shear}{why}{_lower_when_moved(analysis, low)}{_up_to(analysis)}"


def _no_capacity(counts: str) -> str:
    """Return what is said first of a bound in the place of what counts."""
    return counts.replace("if it does, ", "").replace("counts", NO_CAPACITY)


def _is_followed_in_part(analysis: LimitAnalysis) -> bool:
    """Return whether the state is that of a wall too large to be loaded up to it as drawn, or as far when it moved."""
    if analysis.headline.flow_rule != "smoothed" or analysis.rigid_peak is not None:
        return False
    return analysis.last_rest is None or analysis.last_rest < (1.0 - SAME_ANSWER) * analysis.headline.load_multiplier


def _up_to(analysis: LimitAnalysis) -> str:
    """Return how far a wall was loaded that is too large to be loaded up to its state, or that it was not loaded."""
    if analysis.headline.flow_rule in WITHOUT_LOADING and not analysis.going_down:
        return " This wall is not loaded: it may fail in a lower state."
    if not _is_followed_in_part(analysis):
        return ""
    if analysis.last_rest is None:
        return " So large a wall is not loaded as drawn: it may fail in a lower state."
    rest = f"it was found at rest up to λ = ({_limit(analysis.last_rest)}), and may fail in a lower one."
    return f" So large a wall is not loaded up to its state: {rest}"


def _lowest(analysis: LimitAnalysis) -> float:
    """Return the lowest multiplier of what counts and of the states found beside it."""
    states = (analysis.headline, *([analysis.lowest] if analysis.lowest else []))
    low = min(state.load_multiplier for state in states)
    return min(low, *(analysis.non_associative_range or (low, low)))


def _lower_when_moved(analysis: LimitAnalysis, low: float) -> str:
    """Return that stones bear less in large displacements than in the lowest state found: as they give way at edges,
    where a remark tells that, or by 1 % as rigid blocks."""
    rigid, pressed = analysis.rigid_peak or inf, analysis.pressed_peak
    if pressed is not None and pressed < low and edges_take(analysis, SAME_ANSWER):
        at_edges = "left in large displacements as stones give way at edges"
        if pressed == 0.0:
            return f" About nothing is {at_edges}; finite elements (`run`) tell whether the wall stands."
        return f" Lower is λ = {_limit(pressed)}, about what is {at_edges}."
    if rigid < (1.0 - SAME_ANSWER) * low:
        return f" Lower is λ = {_limit(rigid)}, the most that rigid blocks bear in large displacements."
    return ""


def _without(analysis: LimitAnalysis) -> str:
    """Return which part of the dead load has come loose before the wall reaches its state, if any."""
    if not analysis.local_failures:
        return ""
    return f"of what is left when stones of {percent_of(analysis.share_lost)} of the dead load have come loose, "


def answer_in_space(analysis: SpaceAnalysis) -> list[str]:
    """Return the same sentence on a limit analysis in space, and one more where the way joints twist decides."""
    state, bound = analysis.shown, analysis.bound
    multiplier = state.load_multiplier
    shear = applied_words(multiplier, analysis.horizontal_load, analysis.upright_load)
    counts = f"λ = {_limit(multiplier)} counts ({state.name}): {shear}, "
    if analysis.headline is not None and state.nearly:
        wrong = f"a state but for {max(state.validation.flow, state.validation.power):.0e} of its power"
        counts = f"λ = ({_limit(multiplier)}) counts ({state.name}, {wrong}): {shear}, "
    if analysis.going_down:
        counts = f"{OPEN}{counts}"
    if analysis.not_at_rest is not None:
        counts = _no_capacity(counts)
    if analysis.range is None:
        done = "looked for" if analysis.looked_for == "none" else "found"
        why = f"an upper bound only, as no state with friction that does not dilate was {done}."
        counts = _no_capacity(counts)
    else:
        why = _why(*analysis.range, bound, searched=analysis.looked_for == "range")
    if analysis.not_at_rest is not None:
        why = f"{why} Lower is λ = ({_limit(analysis.not_at_rest)}), where loading had not come to rest."
    return [f"{counts}{why}", *_with_other_torsion(analysis)]


def _with_other_torsion(analysis: SpaceAnalysis) -> list[str]:
    """Return what joints bear at most that twist the other way, where that is less than what counts."""
    other = analysis.other_torsion
    if other >= (1.0 - BRACKET) * analysis.shown.load_multiplier:
        return []
    twist = "twist as under uniform pressure" if analysis.torsion == "corners" else "bear at their corners only"
    return [f"Joints that {twist} reach no more than λ = {_limit(other)}, which is lower: how they twist decides."]


def _why(low: float, high: float, bound: float, holds: bool = True, of_what: str = "", searched: bool = True) -> str:
    """Return what a collapse state is, of states that were found from `low` to `high`, and how near to the bound.

    holds: whether the associative multiplier is a bound; of_what: of which wall, where it is not the wall as drawn;
    searched: whether lower states were looked for.
    """
    why = "a collapse state with friction that does not dilate; "
    if holds and low >= (1.0 - ALIKE) * bound:
        done = "found" if searched else "looked for"
        return f"{why}it reaches the associative upper bound{of_what}, and no lower one was {done}."
    if high - low <= ALIKE * high:
        return f"{why}{_bounds(bound, holds, of_what)}"
    between = f"such states were found from {_limit(low)} to {_limit(high)}, as friction leaves the answer open"
    return f"{why}{between}; {_bounds(bound, holds, of_what)}"


def _bounds(bound: float, holds: bool, of_what: str) -> str:
    """Return that the associative multiplier is an upper bound, or why it is none; of_what as of `_why`."""
    if bound == inf:
        return "there is no upper bound, as joints whose sliding dilates would bear any load."
    if holds:
        return f"the associative {_limit(bound)} is an upper bound{of_what}."
    return f"the associative {_limit(bound)} is no upper bound, as stones bear where there is no joint."


def _found_elsewhere(analysis: LimitAnalysis) -> str:
    """Return, of a wall that came to no limit state when it was loaded, which states other searches found."""
    if analysis.lowest is None:
        return ""
    low, high = (_limit(value) for value in (analysis.lowest.load_multiplier, analysis.highest or 0.0))
    others = f"limit states found without loading have {low}" + f" to {high}" * (low < high)
    return f"{others}; "


def _limit(multiplier: float) -> str:
    return printed("limit multiplier", multiplier)


def answer_of_run(summary: Summary) -> str:
    """Return the sentence on a run: the base shear that counts, or that none does."""
    pushed, limit, stones = first_of_valid(summary.pushover), summary.limit_analysis, summary.wall.blocks
    if pushed is None:
        takes = f", which takes {_and(plastic)}" if (plastic := _bonds(summary)) else ""
        alone = standing_is_open(limit) or f"limit analysis alone stands{takes}{_but(rigid_stones_alone(limit))}"
        return f"No peak counts: none of the curves is valid; {alone}."
    bodies = "every stone" if is_of_every_stone(pushed, stones) else "macroblocks"
    peak, multiplier = printed("force", pushed.peak_base_shear), printed("multiplier", pushed.peak_multiplier)
    here = f"(λ = {multiplier}, FE of {bodies})"
    reference = without_reference(summary) if pushed.model == "macro" else None
    if pushed.held:
        moves = standing_is_open(limit) or f"as drawn it moves at λ = {_limit(limit.multiplier)} (limit analysis)"
        asks = "" if reference or is_of_every_stone(pushed, stones) else "; whether every stone is, --model micro says"
        return f"{HELD.capitalize()} {here}{_but(reference)}; {moves}{asks}."
    if contradicts(pushed, limit, stones):
        above = percent_more(pushed.peak_multiplier, highest_of_limit_analysis(limit))
        text = f"No finite element number counts: {peak} kN {here} is {above} off what every stone bears"
        other = _but(reference) or ", or compare with --model micro"
        return f"{text}; {_take_limit_analysis(limit)}{other}."
    if is_to_be_distrusted(pushed, limit, stones):
        above = f"{pushed.peak_multiplier / most_that_stones_bear(pushed, limit) - 1.0:.1%} above"
        most = "what rigid stones bear at most in small displacements, or as far as they were pushed"
        text = f"{DISTRUST.capitalize()} of {peak} kN {here}, {above} {most}"
        return f"{text}: compare with a finer mesh, or {_take_limit_analysis(limit)}."
    text = f"{peak} kN counts {here}{_but(reference)}{_of_another_wall(pushed, limit, stones)}"
    if not pushed.peak_reached:
        text += ", a lower bound, as the curve ends before its peak"
    beside = f"{_limit_beside(pushed, summary)}{_friction_leaves_open(pushed, limit)}{_stands(pushed, limit)}"
    return f"{text}{_macroblocks_beside(pushed, summary)}; {beside}."


def _take_limit_analysis(limit: LimitSummary) -> str:
    """Return what to go by where no curve counts: nothing, where it is open whether the wall stands."""
    taken = f"take limit analysis (λ = {_limit(limit.multiplier)}){_but(rigid_stones_alone(limit))}"
    return standing_is_open(limit) or taken


def _but(doubt: str | None) -> str:
    return f", but {doubt}" if doubt else ""


def _of_another_wall(pushed: PushoverSummary, limit: LimitSummary, stones: int) -> str:
    """Return of what a peak is where it is not the wall as drawn: what is left, or with contacts that have come."""
    fallen = pushed.at_peak.fallen
    said = f", of what is left when {percent_of(fallen)} of the dead load has fallen" if fallen else ""
    drawn = pushed.at_peak.drawn_contacts
    if drawn is not None and is_beyond_the_drawn(pushed, limit, stones):
        bears = f"bears λ = {printed('multiplier', drawn)}" if drawn else "does not stand"
        said += f", with contacts that were not drawn, without which it {bears} there"
    return said


def _macroblocks_beside(pushed: PushoverSummary, summary: Summary) -> str:
    """Return by how much macroblocks lie off the peak of every stone, where both were pushed."""
    macro = next((one for one in summary.pushover if one.model == "macro" and one.valid), None)
    if macro is None or pushed.model != "micro":
        return ""
    known = macro.peak_reached and pushed.peak_reached
    off = f", {percent_more(macro.peak_multiplier, pushed.peak_multiplier)}" if known else ""
    what = f"({printed('force', macro.peak_base_shear)} kN{off})"
    if macro.at_peak.fallen or pushed.at_peak.fallen:  # not the same load
        what = f"(λ = {printed('multiplier', macro.peak_multiplier)}{off})"
    if is_of_every_stone(macro, summary.wall.blocks):
        return f"; macroblocks are every stone, too {what}"
    if contradicts(macro, summary.limit_analysis, summary.wall.blocks):
        return f"; macroblocks {what} do not count, as they bear more than every stone in limit analysis"
    return f"; macroblocks {what} are its fast approximation"


LIMIT_SUBJECTS: dict[Kind, tuple[str, str]] = {
    "collapse state": ("limit analysis", ""),
    "peak in large displacements": ("limit analysis in large displacements", ""),
    "last load at rest": ("the last load at rest in limit analysis", ", no collapse state,"),
    "an upper bound only": ("the upper bound of limit analysis", ""),
}
"""what the multiplier of limit analysis is called beside a peak, and what is said after by how much it is off"""


def _limit_beside(pushed: PushoverSummary, summary: Summary) -> str:
    """Return by how much limit analysis lies off a peak, and what it takes otherwise than these finite elements."""
    limit, in_large = summary.limit_analysis, pushed.displacements == "large"
    moved, (subject, aside) = limit.kind == "peak in large displacements", LIMIT_SUBJECTS[limit.kind]
    fallen = fallen_alone(pushed, limit)
    rigid = [
        "the stones as rigid",
        *["points in which stones touch as without force"] * limit.meets_in_points,
        *["some that have not fallen here as come loose"] * (fallen < 0.0),
    ]
    in_place = ["what has fallen here as in place"] * (fallen > 0.0)
    edges = _at_edges(limit, pushed) if in_large and pushed.peak_reached else ""
    if in_large and not moved and pushed.peak_reached and limit.rigid_peak is not None:
        both = _in_both(limit.multiplier, limit.rigid_peak, pushed.peak_multiplier)
        return f"{subject}{aside} takes {_and([*rigid, *in_place, *_bonds(summary)])}: {both}{edges}"
    off = f" ({percent_more(limit.multiplier, pushed.peak_multiplier)})" if pushed.peak_reached else ""
    small = ["displacements as small"] if in_large and not moved else []
    said = f"{subject}{off}{aside} takes {_and([*rigid, *small, *in_place, *_bonds(summary)])}{edges}"
    return said if in_large or not moved else f"{said}, finite elements displacements as small"


def _friction_leaves_open(pushed: PushoverSummary, limit: LimitSummary) -> str:
    """Return between which multipliers limit analysis found states, where a peak lies among them but above the lowest,
    or far off the one that counts: that finite elements are elastic does not explain it."""
    low, high = limit.non_associative_range or (inf, -inf)
    among = (1.0 - FAR_BEYOND) * low <= pushed.peak_multiplier <= (1.0 + FAR_BEYOND) * high
    far_off = abs(pushed.peak_multiplier - limit.multiplier) > FAR_BEYOND * limit.multiplier
    alone = high - low <= ALIKE * high
    if alone or not among or not (far_off or low < (1.0 - SAME_ANSWER) * pushed.peak_multiplier):
        return ""
    leaves = "friction or displacements leave" if limit.kind == "peak in large displacements" else "friction leaves"
    return f"; {leaves} open which state is met: from λ = {_limit(low)} to {_limit(high)} were found"


def _stands(pushed: PushoverSummary, limit: LimitSummary) -> str:
    """Return that finite elements came to rest under the dead load, where limit analysis leaves that open."""
    if not limit.going_down or any(event.under_gravity for event in pushed.events):
        return ""
    return "; finite elements come to rest under the dead load, which limit analysis leaves open"


def _in_both(small: float, large: float, peak: float) -> str:
    """Return by how much multipliers in small and in large displacements lie off a peak."""
    in_small, in_large = percent_more(small, peak), percent_more(large, peak)
    if in_small == in_large:
        return f"{in_small} in small displacements and in large ones"
    return f"{in_small} in small displacements, {in_large} in large ones"


def _at_edges(limit: LimitSummary, pushed: PushoverSummary) -> str:
    """Return how far off a peak is what is left as stones give way at edges, where rigid blocks have more; and what to
    do where the peak lies between the two, which elements longer than the edges that are pressed have."""
    left, rigid = limit.pressed_peak, limit.rigid_peak or limit.multiplier
    if left is None or left >= (1.0 - SAME_ANSWER) * rigid:
        return ""
    about = f"about {percent_more(left, pushed.peak_multiplier)}" if left else "by an estimate nothing is left"
    said = f"; {about} where stones give way at edges"
    if not left or left >= (1.0 - SAME_ANSWER) * pushed.peak_multiplier:
        return said
    if pushed.peak_multiplier > (1.0 + SAME_ANSWER) * rigid:  # another state, which no smaller elements come from
        return f"{said}: λ = {_limit(left)}"
    return f"{said}: λ = {_limit(left)}, to which smaller elements (mesh.size) come nearer"


def _bonds(summary: Summary) -> list[str]:
    """Return what limit analysis takes bonds and ties as, where there are any."""
    ties = (summary.settings or {}).get("reinforcement", {}).get("ties")
    plastic = ["bonds as plastic, which soften"] if summary.wall.bonded else []
    return [*plastic, "ties as rigid and plastic, which stretch"] if ties else plastic


def _and(things: Sequence[str]) -> str:
    """Return things in words: one, two and three."""
    return " and ".join(filter(None, (", ".join(things[:-1]), things[-1])))
