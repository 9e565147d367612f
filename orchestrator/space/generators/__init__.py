"""Walls in space from a few numbers: each generator returns blocks and supports as one SpaceWall."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from orchestrator.space.generators.shapes import Plan, Stones, box_wall, l_wall, straight_wall, t_wall, u_wall
from orchestrator.space.generators.vaults import Barrel, Column, Dome, VaultMaterial, barrel_vault, dome, drum_column
from orchestrator.space.generators.walls import (
    Gable,
    Leaves,
    Openings,
    Setbacks,
    buttressed_wall,
    gable,
    two_leaf_wall,
    wall_with_openings,
)
from orchestrator.space.wall import SpaceWall


@dataclass(frozen=True, slots=True)
class Generator:
    """A function that makes a wall, and the settings dataclasses it takes, in order."""

    make: Callable[..., SpaceWall]
    settings: tuple[Any, ...]


GENERATORS = {
    "straight": Generator(straight_wall, (Plan, Stones)),
    "l": Generator(l_wall, (Plan, Stones)),
    "u": Generator(u_wall, (Plan, Stones)),
    "t": Generator(t_wall, (Plan, Stones)),
    "box": Generator(box_wall, (Plan, Stones)),
    "openings": Generator(wall_with_openings, (Plan, Openings, Stones)),
    "gable": Generator(gable, (Gable, Stones)),
    "buttress": Generator(buttressed_wall, (Plan, Setbacks, Stones)),
    "two_leaf": Generator(two_leaf_wall, (Leaves, Stones)),
    "column": Generator(drum_column, (Column, VaultMaterial)),
    "barrel": Generator(barrel_vault, (Barrel, VaultMaterial)),
    "dome": Generator(dome, (Dome, VaultMaterial)),
}
"""generators by the name that a case file gives them"""


def build(kind: str, settings: Sequence[object]) -> SpaceWall:
    """Return the wall of one generator. Raises CaseError for numbers that make none."""
    return GENERATORS[kind].make(*settings)
