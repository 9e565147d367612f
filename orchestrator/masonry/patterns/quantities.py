"""Quantities of patterns, and what a range and the edges of an opening must be."""

from __future__ import annotations

from typing import Annotated

from annotated_types import Ge, Gt, Le

from orchestrator.basis.errors import CaseError
from orchestrator.basis.units import Unit
from orchestrator.masonry.wall import LARGEST_COUNT

Place = Annotated[float, Unit("m")]
Length = Annotated[float, Gt(0), Unit("m")]
LengthOrNone = Annotated[float, Ge(0), Unit("m")]
UnitWeight = Annotated[float, Gt(0), Unit("N/m3")]
Number = Annotated[int, Gt(0), Le(LARGEST_COUNT)]
"""of blocks"""
Seed = Annotated[int, Ge(0)]
Rectangle = tuple[Place, Place, Place, Place]
"""left, right, bottom, top in m"""


def refuse_reversed(ends: tuple[float, float], key: str) -> None:
    """Raise CaseError for a range (least, largest) whose least is above its largest."""
    if ends[0] > ends[1]:
        raise CaseError(key, f"{ends[0]:g} to {ends[1]:g} m is not a range", "give the least and then the largest")


def refuse_swapped_edges(openings: tuple[Rectangle, ...], key: str) -> None:
    """Raise CaseError for an opening without a width or a height."""
    for number, (left, right, bottom, top) in enumerate(openings):
        if not (left < right and bottom < top):
            given = f"({left:g}, {right:g}, {bottom:g}, {top:g}) m has no area"
            raise CaseError(f"{key}[{number}]", given, "give left, right, bottom and top")


def refuse_too_many(blocks: float, key: str) -> None:
    """Raise CaseError for a pattern of about so many blocks, where these are more than a drawing may have."""
    if blocks > LARGEST_COUNT:
        raise CaseError(key, f"about {blocks:.2g} blocks, more than {LARGEST_COUNT}", "give larger ones, or fewer")
