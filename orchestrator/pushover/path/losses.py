"""What a wall in motion has lost: bodies without a hold, and whether their fall is a local failure."""

from __future__ import annotations

import numpy as np

from orchestrator.basis.arrays import BoolArray, FloatArray
from orchestrator.basis.graphs import connected_groups
from orchestrator.loads.local_part import Shares, is_local
from orchestrator.pushover.increments import Increment
from orchestrator.pushover.model import ContactModel
from orchestrator.pushover.path.moving import body_motion, body_size, moving_part, participation, without_hold

OUT = 0.5
"""a body that has moved by this share of its size since the wall was static has lost its hold"""
FALLING = 0.05
"""under the weight alone, one that has moved by this share of the wall's height, too: gaps close over less"""


def without_their_hold(model: ContactModel, state: Increment) -> BoolArray:
    """Return the bodies (b,) that have lost their hold in a state in motion and have not fallen yet."""
    moves = moving_part(model, body_motion(model, state.change.ravel()))
    free = without_hold(model, state.normal_force, state.fallen, state.tie_force)
    lost: BoolArray = (free | (moves & (state.gone > OUT * body_size(model)))) & ~state.fallen
    return lost


def fallen_by_weight(model: ContactModel, state: Increment) -> BoolArray:
    """Return the bodies (b,) that fall under the weight alone in a state in motion, and have not fallen yet.

    To be without a hold is not enough: a stone over a gap that was drawn is so until it lies on what is below.
    """
    moves = moving_part(model, body_motion(model, state.change.ravel()))
    far = np.minimum(OUT * body_size(model), FALLING * np.ptp(model.front.nodes[:, 1]))
    lost: BoolArray = moves & (state.gone > far) & ~state.fallen
    return lost


def since_rest(model: ContactModel, state: Increment, lost: BoolArray) -> BoolArray:
    """Return the bodies (b,) that have fallen since the wall was static, with those that are `lost` (b,) now."""
    together: BoolArray = lost | (state.fallen & (state.gone > model.slip_tolerance))
    return together


def shares_of(model: ContactModel, part: BoolArray) -> Shares:
    """Return the shares of the loads that some bodies (b,) have."""
    return participation(model, part.astype(float)) if part.any() else Shares()


def is_the_wall(
    model: ContactModel, state: Increment, lost: BoolArray, loose: BoolArray | None, local_share: float
) -> bool:
    """Return whether the fall of `lost` (b,) bodies ends the curve: it is no local failure, or no live load is left.

    loose (b,): bodies whose fall is local however much they are.
    """
    together = since_rest(model, state, lost)
    failures = apart(model, together) if state.phase == "gravity" else [together]
    stays = lost if loose is None else lost & ~loose
    for failure in failures:
        before = shares_of(model, (state.fallen | together) & ~failure)
        if (stays & failure).any() and not is_local(shares_of(model, failure), before, local_share):
            return True
    return not model.body_live[~(lost | state.fallen)].any()


def apart(model: ContactModel, fallen: BoolArray) -> list[BoolArray]:
    """Return the parts, masks (b,), of bodies that have fallen which do not touch each other as the wall was drawn."""
    slave, master = model.contacts.slave_body, model.contacts.master_body
    there = np.append(fallen, np.zeros(int(max(slave.max(), master.max())) + 1, bool))
    both = there[slave] & there[master]
    part = connected_groups(model.bodies, slave[both], master[both])
    return [fallen & (part == number) for number in np.unique(part[fallen])]


def is_local_motion(
    model: ContactModel, motion: FloatArray, fallen: BoolArray, loose: BoolArray | None, local_share: float
) -> bool:
    """Return whether what moves, by a motion (b,), is a local part of a wall of which bodies `fallen` (b,) are gone.

    What follows elastically, slower than what takes part, does not count.
    """
    moves = moving_part(model, motion)
    if loose is not None and not (moves & ~loose).any():
        return True
    return is_local(participation(model, motion * moves), shares_of(model, fallen), local_share)
