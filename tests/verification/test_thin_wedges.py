"""A block on a wedge that runs out to nothing under its corner: three stones touch in one point.

A bed whose top rises by b to the right, a wedge on it whose top is level, and a block on the wedge. Pushed down the
slope, block and wedge slide together at tan(phi - b), with tan(phi) the coefficient of friction, and the block's corner
leaves that of the bed. Pushed the other way the block slides on the level joint at tan(phi): uphill it needs more.
"""

from __future__ import annotations

from math import atan, tan

import numpy as np
import pytest

from orchestrator import (
    DeadLoad,
    JointSettings,
    LoadSettings,
    SteppingSettings,
    analyse,
    find_joints,
    loads_on,
    one_body_per_block,
    push,
)
from orchestrator.masonry.wall import Block, Wall
from tests.support.walls import between

FRICTION, LENGTH = 0.55, 2.0


def on_a_wedge(rise: float, scale: float, side: int) -> Wall:
    """Return the wall with its tip at the right end, or at the left one for a `side` of -1."""
    outlines = [
        between(-0.3, -0.3, LENGTH + 0.3, 0.0),
        np.array([(0.0, 0.0), (LENGTH, 0.0), (LENGTH, 0.3 + LENGTH * rise), (0.0, 0.3)]),
        np.array([(0.0, 0.3), (LENGTH, 0.3 + LENGTH * rise), (0.0, 0.3 + LENGTH * rise)]),
        between(0.0, 0.3 + LENGTH * rise, LENGTH, 0.65 + LENGTH * rise),
    ]
    drawn = [scale * (outline if side > 0 else (outline * [-1.0, 1.0])[::-1]) for outline in outlines]
    return Wall("wedge", tuple(Block(k, outline, k == 0, 24e3) for k, outline in enumerate(drawn)), 0.6, FRICTION)


@pytest.mark.parametrize(
    ("rise", "scale", "side", "at_the_tip"),
    [(0.05, 1.0, 1, 0.0), (0.05, 0.1, -1, 0.0), (0.02, 1.0, 1, 0.0), (0.15, 1.0, -1, 0.0), (0.05, 1.0, 1, 4.0)],
)
def test_a_corner_bears_on_the_face_that_it_is_on(rise, scale, side, at_the_tip):
    """The bed's corner bore on the block's face, level, after it had left it: 0.503 for 0.487, and 0.519 with a load of
    four times the block's weight at the tip."""
    wall = on_a_wedge(rise, scale, side)
    place = (side * scale * (LENGTH - 0.1), scale * (0.65 + LENGTH * rise))
    force = at_the_tip * 0.35 * LENGTH * scale**2 * wall.thickness * 24e3
    dead = (DeadLoad((3,), force=force, at=place, inertia=True),) if force else ()
    assemblage = find_joints(wall, JointSettings())
    for direction, expected in (("-x", tan(atan(FRICTION) - atan(rise))), ("+x", FRICTION)):
        load = LoadSettings(direction if side > 0 else {"-x": "+x", "+x": "-x"}[direction], dead=dead)
        analysis = analyse(assemblage, loads=loads_on(assemblage.wall, load))
        stepping = SteppingSettings(final_displacement=0.02 * scale)
        done = push(assemblage, analysis, one_body_per_block(assemblage), load, stepping=stepping)
        assert not done.complaints
        assert done.capacity.peak_multiplier == pytest.approx(expected, rel=2e-3)
