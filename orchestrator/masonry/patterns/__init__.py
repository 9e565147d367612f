"""Masonry without a drawing: running bond, irregular courses, rubble, arches in walls and on piers."""

from orchestrator.masonry.patterns.arched_walls import ARCHED_FACADE, ArchedWall, arched_wall
from orchestrator.masonry.patterns.arches import Arch, ArchedOpening, arch_on_piers
from orchestrator.masonry.patterns.courses import IrregularCourses, irregular_courses, running_bond
from orchestrator.masonry.patterns.quantities import Rectangle
from orchestrator.masonry.patterns.random_rubble import Rubble, rubble

__all__ = [
    "ARCHED_FACADE",
    "Arch",
    "ArchedOpening",
    "ArchedWall",
    "IrregularCourses",
    "Rectangle",
    "Rubble",
    "arch_on_piers",
    "arched_wall",
    "irregular_courses",
    "rubble",
    "running_bond",
]
