"""Walls on which no rule was ever tried, for macroblock_peaks.py: seeds from FIRST on, which no other study, test or
example uses. Families take turns."""

from __future__ import annotations

import any_wall

from orchestrator.masonry.patterns import IrregularCourses, irregular_courses
from orchestrator.masonry.wall import Wall

FIRST, WALLS = 5000, 30
LARGE = {"widths": (0.2, 0.4), "heights": (0.15, 0.2)}
COURSES = (
    IrregularCourses(0.8, 0.6, seed=FIRST),
    IrregularCourses(2.0, 1.2, friction=0.5, seed=FIRST + 1, **LARGE),
    IrregularCourses(0.7, 1.4, seed=FIRST + 2),
    IrregularCourses(1.4, 2.0, openings=((0.475, 0.925, 0.8, 1.4),), seed=FIRST + 3, **LARGE),
    IrregularCourses(1.4, 1.0, friction=0.6, seed=FIRST + 4, **LARGE),
)


def wall_of(number: int) -> tuple[str, Wall]:
    """Return family and wall of a number from 0 on."""
    families = len(any_wall.FAMILIES) + 1
    turn, family = divmod(number, families)
    if family == 0:
        return "irregular courses", irregular_courses(COURSES[turn])
    return any_wall.wall_of((FIRST + turn) * len(any_wall.FAMILIES) + family - 1)
