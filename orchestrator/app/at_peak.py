"""What the wall is at the peak of a curve and at its end, against the wall as drawn."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from orchestrator.app.what_moves import STANDS
from orchestrator.assessment.capacity import STILL, Capacity
from orchestrator.basis.arrays import BoolArray
from orchestrator.limit_analysis.search.what_is_left import bound_of_what_is_left
from orchestrator.loads import Loads
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.masonry.joints import Assemblage
from orchestrator.pushover.increments import GAVE_WAY, RESTED, Increment, PushoverCurve
from orchestrator.storage.summary import AtPeak, NarrowPeak, Snap

if TYPE_CHECKING:
    from orchestrator.pushover.model import ContactModel

DROP = 0.05
"""part of its peak that a wall loses where the peak may be a spike, and that a load lies below it at which it snaps"""
NARROW = 1 / 400
"""part of the final displacement within which it is one, and that a motion without rest has to be longer than to count:
a tenth of the largest increment"""
BoundLeft = Callable[[BoolArray], float | None]
"""from the bodies (b,) that have fallen to the associative multiplier of what is left, None where it has none"""


def bound_left(assemblage: Assemblage, loads: Loads, bodies: Bodies) -> BoundLeft:
    """Return what finds the associative multiplier of a wall without bodies; loads, ties: those of limit analysis."""

    def bound(fallen: BoolArray) -> float | None:
        gone = [block for body in np.flatnonzero(fallen) for block in bodies.bodies[body].blocks]
        return bound_of_what_is_left(assemblage, loads, ~np.isin(np.arange(len(assemblage.wall.blocks)), gone))

    return bound


def wall_at_peak(contact_model: ContactModel, at_peak: Increment, bound_without: BoundLeft) -> AtPeak:
    """Return what has fallen at the peak, the bound of what is left, and what the contacts drawn bear there."""
    from orchestrator.pushover.path.increment_record import in_front
    from orchestrator.pushover.path.moved_wall import most_of_drawn_contacts

    weight, fallen = contact_model.body_weight, at_peak.fallen
    return AtPeak(
        fallen=float(weight[fallen].sum() / weight.sum()),
        bound_left=bound_without(fallen) if fallen.any() else None,
        drawn_contacts=most_of_drawn_contacts(contact_model, in_front(contact_model, at_peak)),
        increment=at_peak.number,
    )


def at_the_top(
    capacity: Capacity, contact_model: ContactModel, at_rest: Increment, at_end: Increment
) -> tuple[Capacity, float]:
    """Return the capacity of a curve, without the rounding of a top that stands still, and the control displacement at
    its end over the motion of the body that went farthest, both since the wall was at rest without live load."""
    from orchestrator.pushover.path.increment_record import in_front
    from orchestrator.pushover.path.moving import body_motion

    before, after = (in_front(contact_model, one).displacement for one in (at_rest, at_end))
    farthest = np.max(body_motion(contact_model, (after - before).ravel()) * ~at_end.fallen, initial=1e-300)
    share = abs(at_end.control_displacement - at_rest.control_displacement) / float(farthest)
    if share >= STILL:
        return capacity, share
    return replace(capacity, initial_stiffness=None, displacement_at_peak=0.0, final_displacement=0.0), 0.0


def farthest_snap(
    increments: Iterable[Increment], at_peak: Increment, end: float, gone: Callable[[Increment, Increment], float]
) -> Snap | None:
    """Return the farthest motion from rest to rest among increments in their order, up to the peak, None where none is
    longer than NARROW of the final displacement `end` (m).

    gone: how far the part of the wall that moves has gone from one rest to another, m; it counts where the top stands.

    A wall whose displacements are prescribed goes through equilibria that bear less than it bore before. Under that
    load it moves on to the first that bears as much again: such a motion where it is less than the peak by DROP. What
    has fallen from one rest to the next is the top of one of them alone: how far that went is not known then. Where it
    bore more and more on the way a load in between may find it at rest: the farthest such motion where there is no
    other.
    """

    def snap(before: Increment, after: Increment, bore_less: bool) -> Snap:
        top, part = abs(after.pushed - before.pushed), gone(before, after)
        if top <= STANDS * part:
            return Snap(before.load_multiplier, part, None, bore_less)
        return Snap(before.load_multiplier, top, top / abs(at_peak.pushed), bore_less)

    rest, snaps, ways = at_peak, list[Snap](), set[str]()
    highest, fell = at_peak, False
    for one in increments:
        ways |= {attempt.action for attempt in one.attempts} | ({GAVE_WAY} if one.moving else set())
        if one.moving or one.number > at_peak.number:
            continue
        if not np.array_equal(one.fallen, rest.fallen):
            rest, ways, highest, fell = one, set(), one, False
            continue
        if ways & {RESTED, GAVE_WAY} and one.phase != "gravity":
            snaps.append(snap(rest, one, GAVE_WAY in ways))
        rest, ways = one, set()
        if one.phase == "gravity" or one.load_multiplier >= highest.load_multiplier:
            if fell and highest.load_multiplier < (1.0 - DROP) * at_peak.load_multiplier:
                snaps.append(snap(highest, one, bore_less=True))
            highest, fell = one, False
        else:
            fell = True
    far = [one for one in snaps if one.moved > NARROW * end]
    return max(far, key=lambda one: (one.bore_less, one.moved), default=None)


def spike_of(curve: PushoverCurve, end: float) -> NarrowPeak | None:
    """Return how soon after its peak a curve has lost DROP of it, None where that is no spike; end: of a curve, m."""
    static = curve.static
    peak = int(np.argmax(static.base_shear_N))
    lower = np.flatnonzero(static.base_shear_N[peak:] < (1.0 - DROP) * static.base_shear_N[peak])
    if not len(lower):
        return None
    first = peak + int(lower[0])
    moved = float(abs(static.control_displacement_m[first] - static.control_displacement_m[peak]))
    return NarrowPeak(float(static.load_multiplier[first]), moved) if moved < NARROW * end else None


def moment_of_load(contact_model: ContactModel, state: Increment) -> float:
    """Return the moment of the live load's horizontal part about the wall's base, N m, above 0."""
    nodes = contact_model.front.nodes
    horizontal = contact_model.lateral[: nodes.size : 3]
    moment = state.load_multiplier * float(horizontal @ (nodes[:, 1] - nodes[:, 1].min()))
    return max(abs(moment), float(np.finfo(float).tiny))
