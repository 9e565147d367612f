"""What a wall bears is no matter of the last digits of its coordinates, also where stones let go as it loses rest.

A facade of two storeys with a door, windows and lintels: with one of the stiffnesses of the joints it rests under more
than the state bears that it comes to (lambda 0.282 and 0.278; every stone in finite elements 0.280), with the other up
to 0.286.
"""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from orchestrator import JointSettings, LimitAnalysisSettings, LoadSettings, analyse, find_joints, loads_on
from orchestrator.masonry.wall import Block, Wall
from tests.support.walls import between

pytestmark = pytest.mark.long

COURSE, STONE, WIDTH = 0.4, 0.6, 6.0
DOOR, WINDOWS, ABOVE = ((2.4, 3.6),), ((0.9, 1.5), (4.5, 5.1)), ((0.9, 1.8), (2.4, 3.6), (4.2, 5.1))
OPENINGS = {course: DOOR + (WINDOWS if course >= 2 else ()) for course in range(5)} | dict.fromkeys((8, 9, 10), ABOVE)
LINTELS = {5: ((0.6, 1.8), (2.1, 3.9), (4.2, 5.4)), 11: ((0.6, 1.95), (2.1, 3.9), (4.05, 5.4))}
COURSES = 13
HEADLINE = LimitAnalysisSettings(large_displacements=False, search_blocks=0, sequence_blocks=0)


def pier(left, right, shifted):
    """The stones of a course between two x, every other course shifted by half a stone, no end shorter than 0.2 m."""
    heads = np.arange(left + (STONE / 2 if shifted else STONE), right - 0.2, STONE)
    ends = [left, *heads, right]
    return list(pairwise(ends))


def stones():
    """The outlines of all stones, upwards, from the left."""
    found = []
    for course in range(COURSES):
        lintels, left = LINTELS.get(course, ()), 0.0
        for start, end in sorted((*OPENINGS.get(course, ()), *lintels, (WIDTH, WIDTH))):
            here = pier(left, start, course % 2) if start - left > 1e-9 else []
            here += [(start, end)] if (start, end) in lintels else []
            found += [between(a, course * COURSE, b, (course + 1) * COURSE) for a, b in here]
            left = end
    return found


COPIES = {
    "as drawn": (lambda outline: outline, "+x"),
    "rounded to nanometres": (lambda outline: np.round(outline, 9), "+x"),
    "mirrored": (lambda outline: outline[::-1] * [-1.0, 1.0], "-x"),
    "a tenth": (lambda outline: outline / 10.0, "+x"),
    "far away": (lambda outline: outline + [5e5, 0.0], "+x"),
}


@cache
def headline(copy):
    moved, direction = COPIES[copy]
    outlines = [between(-0.2, -0.2, WIDTH + 0.2, 0.0), *stones()]
    blocks = tuple(Block(number, moved(outline), number == 0, 20e3) for number, outline in enumerate(outlines))
    wall = Wall("facade", blocks, 0.3, 0.6)
    found = analyse(find_joints(wall, JointSettings()), HEADLINE, loads_on(wall, LoadSettings(direction)))
    return found.headline


@pytest.mark.parametrize("copy", [copy for copy in COPIES if copy != "as drawn"])
def test_the_headline_is_that_of_the_wall(copy):
    assert headline("as drawn").load_multiplier == pytest.approx(0.2823, rel=1e-3)
    assert headline(copy).load_multiplier == pytest.approx(headline("as drawn").load_multiplier, rel=1e-6)
