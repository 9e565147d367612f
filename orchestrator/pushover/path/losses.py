"""What a wall in motion has lost: bodies without a hold, and whether their fall is a local failure."""

from __future__ import annotations

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.loads.local_part import Shares, is_local
from orchestrator.pushover.increments import BodyMask, Increment
from orchestrator.pushover.model import ContactModel
from orchestrator.pushover.path.moving import body_motion, body_size, moving_part, participation, without_hold

OUT = 0.5
"""a body that has moved by this share of its size since the wall was static has lost its hold"""


def without_their_hold(model: ContactModel, state: Increment) -> BodyMask:
    """Return the bodies (b,) that have lost their hold in a state in motion and have not fallen yet."""
    moves = moving_part(model, body_motion(model, state.change.ravel()))
    free = without_hold(model, state.normal_force, state.fallen, state.tie_force)
    lost: BodyMask = (free | (moves & (state.gone > OUT * body_size(model)))) & ~state.fallen
    return lost


def since_rest(model: ContactModel, state: Increment, lost: BodyMask) -> BodyMask:
    """Return the bodies (b,) that have fallen since the wall was static, with those that are `lost` (b,) now."""
    together: BodyMask = lost | (state.fallen & (state.gone > model.slip_tolerance))
    return together


def shares_of(model: ContactModel, part: BodyMask) -> Shares:
    """Return the shares of the loads that some bodies (b,) have."""
    return participation(model, part.astype(float)) if part.any() else Shares()


def is_the_wall(
    model: ContactModel, state: Increment, lost: BodyMask, loose: BodyMask | None, local_share: float
) -> bool:
    """Return whether the fall of `lost` (b,) bodies ends the curve: it is no local failure, or no live load is left.

    loose (b,): bodies whose fall is local however much they are.
    """
    together = since_rest(model, state, lost)
    stays = lost if loose is None else lost & ~loose
    shares, before = shares_of(model, together), shares_of(model, state.fallen & ~together)
    if stays.any() and not is_local(shares, before, local_share):
        return True
    return not model.body_live[~(lost | state.fallen)].any()


def is_local_motion(
    model: ContactModel, motion: FloatArray, fallen: BodyMask, loose: BodyMask | None, local_share: float
) -> bool:
    """Return whether what moves, by a motion (b,), is a local part of a wall of which bodies `fallen` (b,) are gone."""
    if loose is not None and not (moving_part(model, motion) & ~loose).any():
        return True
    return is_local(participation(model, motion), shares_of(model, fallen), local_share)


def touching(model: ContactModel, bodies: BodyMask) -> BodyMask:
    """Return which possible contacts (c,) have one of some bodies (b,) on either side."""
    slave, master = (np.minimum(body, model.bodies) for body in model.pairs)
    there = np.append(bodies, False)
    either: BodyMask = there[slave] | there[master]
    return either
