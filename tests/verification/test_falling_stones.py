"""A stone that creeps to an edge and falls: no step of its motion is longer than steps of motion may be.

A stone lies on a slope of 0.1 at the end of a block, 0.45 of its width beyond it. It slides where its weight and the
live load press along the slope as friction resists, (mu - s) / (1 + mu s), by so little that it creeps; where its
centre has passed the edge it tips, and nothing holds it any more.
"""

from __future__ import annotations

import numpy as np
import pytest
from mpi4py import MPI

from orchestrator.masonry.wall import Block, Wall
from orchestrator.pushover.path.increment_record import in_front
from orchestrator.pushover.path.motion import FASTEST, TOO_FAR
from orchestrator.pushover.path.moving import body_motion, body_size
from orchestrator.pushover.path.stepping import Pushover
from orchestrator.pushover.settings import NewtonSettings, SteppingSettings
from orchestrator.pushover.solve.linear_system import LinearSystem
from tests.support.pushover_chain import model_of, rectangle

SLOPE, FRICTION = 0.1, 0.4


def ledge(width: float) -> Wall:
    """A block of 2 m x 1 m whose top falls along x, and a flat stone on its end."""
    right = 2.0 + 0.45 * width
    left = right - width
    below = np.array([(0.0, 0.0), (2.0, 0.0), (2.0, 1.0 - SLOPE * 2.0), (0.0, 1.0)])
    corners = ((left, 0.0), (right, 0.0), (right, width / 4), (left, width / 4))
    stone = np.array([(x, 1.0 - SLOPE * x + height) for x, height in corners])
    blocks = (
        Block(0, rectangle(-1.0, -0.2, 4.0, 0.2), True, 20e3),
        Block(1, below, False, 20e3),
        Block(2, stone, False, 20e3),
    )
    return Wall("ledge", blocks, 0.3, FRICTION)


@pytest.mark.parametrize("width", [0.3, 0.6])
def test_no_step_of_a_fall_is_longer_than_steps_of_motion_may_be(width):
    model = model_of(ledge(width), mesh_size=0.5, large_displacement=True)
    steps, size = [], body_size(model)
    with LinearSystem(model, MPI.COMM_SELF) as system:
        for row in Pushover(model, system, NewtonSettings(), SteppingSettings(), FRICTION).increments():
            steps.append(float(np.max(body_motion(model, in_front(model, row).change.ravel()) / size)))
            if row.fallen.any():
                break
    assert row.fallen.tolist() == [False, True]
    slides = (FRICTION - SLOPE) / (1.0 + FRICTION * SLOPE)
    assert row.load_multiplier == pytest.approx(slides, rel=5e-3)
    assert max(steps) <= TOO_FAR * FASTEST
    assert sum(steps) < 1.5, "it is taken out where it has lost its hold, and not far below"
