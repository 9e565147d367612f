"""What is said of pushovers besides their figures: why they are not valid, what fell, what to do about it."""

from __future__ import annotations

from collections.abc import Sequence

from orchestrator.basis.printed import printed
from orchestrator.storage.summary import PushoverSummary

COARSE = 0.01
"""part of a joint by which the resultant of its toe may lie off before that is told"""
TOLD = 5
"""local failures that are told one by one"""


def reasons(pushovers: Sequence[PushoverSummary]) -> list[str]:
    """Return why pushovers are not valid."""
    return [f"{pushed.model} FE: {pushed.not_valid_because}" for pushed in pushovers if not pushed.valid]


def remarks(pushovers: Sequence[PushoverSummary]) -> list[str]:
    """Return what pushovers have to say beside their figures: local failures, tension inside macroblocks, a peak that
    was not reached.

    Many events are told in short: the first ones, and how many there were.
    """
    said = []
    for pushed in pushovers:
        for event in pushed.events[:TOLD]:
            bodies, share = ", ".join(event.bodies), 100 * event.mass_share
            said.append(
                f"{pushed.model} FE: {bodies} ({share:.2g} % of the mass) fell at a load multiplier of "
                f"{printed('multiplier', event.load_multiplier)}; the wall went on"
            )
        if (more := len(pushed.events) - TOLD) > 0:
            said.append(f"{pushed.model} FE: {more} more local failures, in summary.json")
        if pushed.toe_error > COARSE:
            said.append(
                f"{pushed.model} FE: at the peak the resultant of a toe may lie off by "
                f"{100 * pushed.toe_error:.2g} % of its joint, "
                "as elements are longer than what crushes; lower mesh.size"
            )
        if pushed.tension_inside > 0.0:
            said.append(
                f"{pushed.model} FE: macroblocks hold together by up to {printed('stress', pushed.tension_inside)} MPa "
                "of tension inside at the peak, which their joints might not carry; --model micro tells"
            )
        if not pushed.peak_reached:
            multiplier = printed("multiplier", pushed.peak_multiplier)
            said.append(f"{pushed.model} FE: the peak was not reached; the wall carries at least {multiplier}")
    return said
