"""What loading met that a multiplier does not say, in words: local failures, how sure it is, where it moves far."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf

import numpy as np

from orchestrator.basis.printed import as_lambda, as_place, percent_of
from orchestrator.limit_analysis.paper.limit_state import LimitAnalysis, LimitState, is_of_geometry
from orchestrator.limit_analysis.problem import Problem
from orchestrator.limit_analysis.search.loading import Loaded, has_path
from orchestrator.limit_analysis.search.loading_path import LoadPath
from orchestrator.limit_analysis.search.moving_parts import ids_of, moving_share
from orchestrator.limit_analysis.validation import LIMITS
from orchestrator.loads.block_loads import Loads
from orchestrator.loads.local_part import is_local
from orchestrator.masonry.block_properties import block_moduli
from orchestrator.masonry.points_in_common import PointInCommon

RELEASE = 0.01
"""Part of the multiplier by which a state may lie off the last load at rest without a remark."""
SOFT_END = 0.02
"""Part of the last load at rest, below it, in which large displacements are not told: near a limit state they are."""

TOLD = 5
"""Points in common that are told one by one."""

NO_PATH = (
    "joints that crush, or whose tensile strength exceeds cohesion over friction, have no path of loading: states of "
    "this wall are looked for without"
)
"""What is said of walls that are not loaded."""
CRUSHING = "joints that crush are loaded as if they did not: what is met is the nearest state in which they do"
"""What is said of walls with such joints that are loaded."""
BONDED = (
    "limit analysis takes bonds as plastic, with their strength in all of a joint at once: finite elements, in which "
    "they break, may bear less (`run`)"
)
"""What is said of walls whose joints have cohesion or tension."""
CLOSED_BY = {
    "smoothed": "smoothed conditions",
    "descent": "two programs from the mechanism at its last rest",
    "sequence": "the paper's sequence",
}
"""How a state was closed that the path itself did not come to."""


def is_soft(path: LoadPath) -> bool:
    """Whether displacements are large before the last rest, and not only next to it."""
    return path.soft_from is not None and path.soft_from < (1.0 - SOFT_END) * path.last_rest


def points_words(found: tuple[PointInCommon, ...]) -> Iterator[str]:
    """Yield which stones touch in one point, which has no force here, and what that spoils."""
    if not found:
        return
    pairs = ", ".join("{} | {} {} m".format(*one.stones, as_place(*one.place)) for one in found[:TOLD])
    more = ", ..." if len(found) > TOLD else ""
    yield (
        "stones that touch in one point bear nothing there in limit analysis, and may in finite elements: "
        f"{pairs}{more}; all multipliers of limit analysis, the associative one too, may be too low"
    )


def remarks_of(problem: Problem, met: Loaded | None, falling: tuple[int, ...]) -> tuple[str, ...]:
    """Return in words what loading met that a multiplier does not say; falling: ids of blocks, as of NonAssociative."""
    friction = problem.friction
    holds = (friction.cohesion > 0.0) | (friction.tension > 0.0)
    bonded = (BONDED,) if (holds & ~friction.without_shear).any() else ()
    if not has_path(friction) or (friction.crushes_joints and (met is None or met.is_unloaded)):
        return (NO_PATH, *(local_failures_of(met) if met else ()), *bonded)
    bonded = (*bonded, *[CRUSHING] * friction.crushes_joints)
    if met is None:
        return (no_rest_words(", ".join(map(str, falling)), len(falling)), *bonded)
    words = (local_failures_of, answer_words, mechanism_words, geometry_words, interval_words)
    return (*(said for of in words for said in of(met)), *bonded)


def no_rest_words(stones: str, count: int) -> str:
    """Return what is said where loading finds no rest under the dead load; `count` stones go down, by their ids."""
    said = "loading: no state of rest under the dead load was found"
    if not count:
        return said
    return f"{said}: " + (f"stones {stones} go" if count > 1 else f"stone {stones} goes") + " down unless wedged"


def few_move_words(
    problem: Problem, loads: Loads, state: LimitState, local_share: float, peeled: bool
) -> Iterator[str]:
    """Yield which stones move in the state that counts, where they are a local failure and no state of what is left was
    found; loads: of the problem's assemblage, peeled: whether what counts is a state of what local failures left."""
    if peeled or not state.converged:
        return
    for stones, percent in _few_that_move(problem, loads, state, local_share):
        yield (
            f"WARNING: only stones {stones} ({percent} % of the dead load) move at the multiplier that "
            "counts: what is left may bear more; analyse the wall without them, too"
        )


def paper_words(problem: Problem, loads: Loads, answer: LimitAnalysis, local_share: float) -> Iterator[str]:
    """Yield that the paper's value is a local failure, where what counts is a state of what local failures left, or
    that loading was not found to come to it, where it is below all states that it was found to come to."""
    paper, known = answer.sequence, answer.path and answer.non_associative_range
    if paper is None:
        return
    if answer.local_failures:
        for stones, percent in _few_that_move(problem, loads, paper, local_share):
            said = f"only {percent} % of the dead load moves at it (stones {stones})"
            yield f"the paper's value is none of the wall: {said}"
    elif known and paper.load_multiplier < (1.0 - RELEASE) * min(known[0], answer.headline.load_multiplier):
        value = as_lambda(paper.load_multiplier)
        yield f"loading was not found to come to the paper's value {value}, a state of other forces between the stones"


def _few_that_move(problem: Problem, loads: Loads, state: LimitState, local_share: float) -> Iterator[tuple[str, str]]:
    """Yield the ids and the share, in percent of the dead load, of what moves in a state where that is local."""
    moving, share, gone = moving_share(problem, loads, state, np.ones(len(problem.assemblage.wall.blocks), dtype=bool))
    if is_local(share, gone, local_share):
        yield ", ".join(map(str, ids_of(problem, moving))), f"{100 * share.dead:.2g}"


def local_failures_of(met: Loaded) -> Iterator[str]:
    """Yield what came loose before the wall fails."""
    for failure in met.local_failures:
        low, high = failure.multipliers
        at = f"at {as_lambda(high)}" if high - low <= RELEASE * high else f"at {as_lambda(low)} to {as_lambda(high)}"
        at, wedged = ("under the dead load", ", unless wedged") if failure.under_dead_load else (at, "")
        stones = ", ".join(map(str, failure.stones))
        share = f"({100 * failure.share:.2g} % of the dead load)"
        single = len(failure.stones) == 1
        said = f"stone {stones} {share} comes loose" if single else f"stones {stones} {share} come loose"
        yield f"local failure {at}: {said}{wedged}"


def answer_words(met: Loaded) -> Iterator[str]:
    """Yield what the answer is where it is no limit state that the path came to by itself."""
    path, state = met.path, met.state
    if met.geometry_decides:
        bears, drawn = met.multiplier, drawn_of(met)
        least = "" if met.pushed is not None and met.pushed.is_past else "at least "
        blocks = f"rigid blocks in large displacements bear {least}{as_lambda(bears)}"
        if not met.is_unloaded:
            why = "geometry decides: " if geometry_shows(met) else ""
            yield f"{why}{blocks}, in small ones {as_lambda(drawn)}"
        else:
            closed = "a state in small ones, closed by smoothed conditions without loading"
            yield f"{blocks}; {closed}, has {as_lambda(drawn)}"
    elif state is not None and state.flow_rule in CLOSED_BY:
        how = CLOSED_BY[state.flow_rule]
        yield f"the path was not followed to its end: state closed by {how}; {loaded_to(met)}"
    elif (state is None or not state.converged) and path.carries is None:
        creeps = "" if path.not_at_rest == inf else f" and not at {as_lambda(path.not_at_rest)}"
        headline = "" if state is None else ": the headline is that rest"
        rest = as_lambda(path.last_rest)
        yield f"loading: at rest up to {rest}{creeps}, but no limit state was closed there{headline}"
        if path.given_up:
            upper = "the bound" if path.not_at_rest == inf else f"{as_lambda(path.not_at_rest)}"
            yield f"given up after so many steps: between that rest and {upper} nothing is known"


def mechanism_words(met: Loaded) -> Iterator[str]:
    """Yield how the wall comes from its last load at rest to the state that is the answer, and how long this lasts."""
    rest, state = met.path.last_rest, met.state
    if state is None:
        return
    pushed = met.pushed
    if pushed is not None and pushed.is_past and met.geometry_decides and not geometry_shows(met):
        falls = max(float(pushed.multiplier[-1]), 0.0)
        if falls < (1.0 - RELEASE) * pushed.peak:
            most, least = as_lambda(pushed.peak), as_lambda(falls)
            yield f"at rest up to {most}; as it moves what it bears falls to {least} or less"
    elif met.path.carries is not None:
        yield f"at rest up to {as_lambda(rest)}; once it moves it carries {as_lambda(met.path.carries.load_multiplier)}"
    is_path = not met.spread and not met.is_unloaded and state.flow_rule not in CLOSED_BY
    if is_path and state.load_multiplier > (1.0 + RELEASE) * rest:
        found = as_lambda(state.load_multiplier)
        yield f"at rest up to {as_lambda(rest)}; it moves far before it bears the {found} found"
    if state.converged and closes_joints(state):
        yield "joints that had opened close in this state: it lasts until they have, and may bear more then"


def geometry_words(met: Loaded) -> Iterator[str]:
    """Yield from where on displacements are large, what rigid blocks bear in large ones, and whether the modulus
    decides: in small ones only ratios of stiffness matter, in large ones how far the wall moves."""
    if is_soft(met.path) and met.path.soft_from is not None:
        yield f"from {as_lambda(met.path.soft_from)} on displacements are large"
    if met.pushed is not None and not met.geometry_decides:
        most = "bear at most" if met.pushed.is_past else "bear at least"
        yield f"in large displacements rigid blocks {most} {as_lambda(met.pushed.peak)}"
    modulus = modulus_of(met)
    if met.geometry_decides and (met.is_unloaded or geometry_shows(met)):
        yield f"the peak in large displacements depends on the elastic modulus of the stones, here {modulus}"
        if met.multiplier < drawn_of(met) and not met.is_unloaded:
            lost = percent_of(1.0 - met.multiplier / drawn_of(met))
            yield (
                f"rigid blocks on springs lose {lost} as they move; stones that give way at edges and bend may lose "
                "more: finite elements tell (`run`)"
            )
    if not met.displaced_rests:
        yield f"in large displacements no rest under a live load was found, with an elastic modulus of {modulus}"


def geometry_shows(met: Loaded) -> bool:
    """Whether geometry makes the peak in large displacements, and not the joints alone."""
    return met.pushed is not None and is_of_geometry(met.pushed.curve, drawn_of(met))


def drawn_of(met: Loaded) -> float:
    """Return the multiplier of the state in small displacements, or of the last rest where none was found."""
    return met.path.last_rest if met.path.state is None else met.path.state.load_multiplier


def modulus_of(met: Loaded) -> str:
    """Return in words the elastic modulus of the stones that are left, from the least to the largest."""
    wall = met.part.assemblage.wall
    moduli = block_moduli(wall, met.part.elastic_modulus)[[not block.fixed for block in wall.blocks]]
    return " to ".join(dict.fromkeys(f"{1e-9 * one:g}" for one in (moduli.min(), moduli.max()))) + " GPa"


def interval_words(met: Loaded) -> Iterator[str]:
    """Yield between which multipliers the answer lies where it depends on what nobody knows."""
    if met.spread:
        low, high = (as_lambda(end) for end in met.spread)
        yield f"which state is met depends on the joints' stiffness, or on how it moves: {low} to {high}"


def loaded_to(met: Loaded) -> str:
    """Return in words how far a wall was loaded towards a state found otherwise."""
    if met.is_unloaded:
        return "the wall was not loaded in small displacements, for the number of blocks"
    lost = met.path.not_at_rest
    return f"at rest up to {as_lambda(met.path.last_rest)}" + (
        "" if lost == inf else f", no rest found at {as_lambda(lost)}"
    )


def closes_joints(state: LimitState) -> bool:
    """Whether joints that stand open in a state close in its mechanism."""
    opening, least = state.mechanism.opening, LIMITS["interpenetration"] * state.mechanism.largest_displacement
    return state.open_ends is not None and bool((state.open_ends & (opening < -least)).any())
