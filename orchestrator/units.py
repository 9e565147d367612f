"""Units: what a quantity is stored in, and how "25 kN/m3" becomes 25000.0. Nothing else knows about units."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Unit:
    """Marks a settings field with the SI unit it is stored in: `Annotated[float, Unit("m")]`."""

    symbol: str
