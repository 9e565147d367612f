"""A block slides along a bed that turns by some hundredths of a radian: up a slope, or down one.

On a slope of angle a it needs tan(phi + a) of its weight, with tan(phi) the coefficient of friction. While it bridges
the kink its front rests on one slope and its back on the other, and it needs something between the two.
"""

from __future__ import annotations

from math import atan, tan

import numpy as np
import pytest
from mpi4py import MPI

from orchestrator.masonry.wall import Block, Wall
from orchestrator.pushover.path.stepping import Pushover
from orchestrator.pushover.settings import NewtonSettings, SteppingSettings
from orchestrator.pushover.solve.linear_system import LinearSystem
from tests.support.pushover_chain import model_of, rectangle

FRICTION, LENGTH, GOES, FLAT = 0.7, 0.4, 0.55, 0.05


def bed(angle: float, pieces: int) -> list[Block]:
    """Return a bed whose slope begins at x = 0, of one block or of two."""
    rise, end = 2.0 * tan(angle), 2.0
    if pieces == 1:
        outline = np.array([(-1.0, -0.5), (end, -0.5), (end, rise), (0.0, 0.0), (-1.0, 0.0)])
        return [Block(0, outline, True, 25e3)]
    slope = np.array([(0.0, -0.5), (end, -0.5), (end, rise), (0.0, 0.0)])
    return [Block(0, rectangle(-1.0, -0.5, 1.0, 0.5), True, 25e3), Block(2, slope, True, 25e3)]


@pytest.mark.parametrize("pieces", [1, 2])
@pytest.mark.parametrize("angle", [-0.05, -0.02, 0.02, 0.05])
def test_a_block_slides_over_a_kink_of_its_bed(angle, pieces):
    block = Block(1, rectangle(-FLAT - LENGTH, 0.0, LENGTH, 0.2), False, 25e3)
    wall = Wall("kink", tuple(sorted([*bed(angle, pieces), block], key=lambda b: b.id)), 0.3, FRICTION)
    model = model_of(wall, mesh_size=0.2, large_displacement=True)
    stepping = SteppingSettings(final_displacement=GOES, final_drop=0.9)
    with LinearSystem(model, MPI.COMM_SELF) as system:
        rows = [row for row in Pushover(model, system, NewtonSettings(), stepping).increments() if not row.moving]
    gone = np.array([row.control_displacement for row in rows if row.phase == "displacement"])
    multiplier = np.array([row.load_multiplier for row in rows if row.phase == "displacement"])
    flat, sloping = FRICTION, tan(atan(FRICTION) + angle)
    assert gone[-1] == pytest.approx(GOES, rel=0.05)
    assert multiplier[gone < 0.9 * FLAT] == pytest.approx(flat, rel=2e-3)
    assert multiplier[gone > FLAT + LENGTH + 0.02] == pytest.approx(sloping, rel=2e-3)
    assert multiplier.min() > min(flat, sloping) * (1 - 1e-2)
    assert multiplier.max() < max(flat, sloping) * (1 + 1e-2)
