"""Regular masonry without a drawing."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from orchestrator.masonry.wall import Block, Wall, read_only


def running_bond(
    blocks_per_course: int,
    courses: int,
    block_length: float = 0.4,
    block_height: float = 0.175,
    thickness: float = 0.1,
    unit_weight: float = 25e3,
    friction: float = 0.65,
) -> Wall:
    """Return a wall of whole blocks, every second course with half blocks at both ends, on one wider support.

    The lowest course is a whole one (wall 1 of Ferris and Tin-Loi, of the same size, begins with the halved one and
    is weaker: associative multiplier 0.6429 against 0.6500 here). Lengths in m, unit weight in N/m3.
    Blocks are numbered from 1, course by course from the left; the support is 0.
    """
    length = blocks_per_course * block_length
    whole = np.arange(blocks_per_course + 1) * block_length
    halved = np.concatenate([[0.0], whole[:-1] + block_length / 2, [length]])
    rectangles = [(-0.2, length + 0.2, -block_height, 0.0)]
    for course in range(courses):
        ends = halved if course % 2 else whole
        level = course * block_height
        rectangles += [(left, right, level, level + block_height) for left, right in pairwise(ends)]
    blocks = tuple(
        Block(number, _rectangle(*sides), fixed=number == 0, unit_weight=unit_weight)
        for number, sides in enumerate(rectangles)
    )
    return Wall(f"running bond {blocks_per_course} x {courses}", blocks, thickness, friction)


def _rectangle(left: float, right: float, bottom: float, top: float) -> np.ndarray:
    return read_only([[left, bottom], [right, bottom], [right, top], [left, top]])
