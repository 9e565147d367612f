"""How far the part of a wall has gone that moves, which its top need not show."""

from __future__ import annotations

from typing import TYPE_CHECKING

from orchestrator.pushover.increments import Increment
from orchestrator.pushover.settings import SteppingSettings

if TYPE_CHECKING:
    from orchestrator.pushover.model import ContactModel

STANDS = 0.5
"""part of what moves by which the top has moved at most where it stands"""


def part_gone(model: ContactModel, stepping: SteppingSettings, before: Increment, after: Increment) -> float:
    """Return the mean displacement along the live load in m, from one increment to another, of the part that moves; 0
    where that is local or has no live load."""
    from orchestrator.pushover.model import driven_by
    from orchestrator.pushover.path.increment_record import in_front
    from orchestrator.pushover.path.losses import is_local_motion
    from orchestrator.pushover.path.moving import body_motion, moving_part

    change = in_front(model, after).displacement - in_front(model, before).displacement
    motion = body_motion(model, change) * ~after.fallen
    part = moving_part(model, motion) & ~after.fallen
    if not model.body_live[part].any() or is_local_motion(model, motion, after.fallen, None, stepping.local_share):
        return 0.0
    return abs(float(driven_by(model, part).mean_row @ change.ravel()))
