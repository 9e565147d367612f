"""Units: what a quantity is stored in, and how "25 kN/m3" becomes 25000.0. Nothing else knows about units."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

FACTORS = {
    "m": {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "km": 1e3, "in": 0.0254, "ft": 0.3048},
    "s": {"s": 1.0, "ms": 1e-3, "min": 60.0},
    "1/s": {"1/s": 1.0},
    "m/s2": {"m/s2": 1.0, "g": 9.81},
    "Pa": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "N/m2": 1.0, "kN/m2": 1e3, "N/mm2": 1e6},
    "N": {"N": 1.0, "kN": 1e3, "MN": 1e6},
    "N/m": {"N/m": 1.0, "kN/m": 1e3, "N/mm": 1e3, "MN/m": 1e6, "kN/mm": 1e6},
    "rad": {"rad": 1.0, "deg": math.pi / 180},
    "N/m3": {"N/m3": 1.0, "kN/m3": 1e3, "MN/m3": 1e6, "GN/m3": 1e9, "N/mm3": 1e9},
}
"""units that may be written, by the SI unit a quantity is stored in"""

TURN = 2.0 * math.pi
"""rad; a larger angle is one of degrees that was written without its unit"""
READ_AT_A_GLANCE = ("mm", "MPa", "GPa", "kN", "kN/m", "kN/m3", "deg")
"""units that values are stated in beside those of the SI"""
QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|[-+]?inf)\s*([A-Za-z0-9/]*)\s*")


@dataclass(frozen=True, slots=True)
class Unit:
    """Marks a settings field with the SI unit it is stored in: `Annotated[float, Unit("m")]`.

    symbol: "" for a pure number. may_be_infinite: whether `inf` or "none" switches off what the field limits.
    """

    symbol: str
    may_be_infinite: bool = False

    def parse(self, value: object) -> float:
        """Return a number (already SI) or a text with its unit ("450 mm") in the SI unit.

        Raises ValueError, saying which units would be right.
        """
        if isinstance(value, int | float) and not isinstance(value, bool):
            return self._within_a_turn(as_number(value), f'write degrees with their unit, as in "{value:g} deg"')
        if value == "none" and self.may_be_infinite:
            return math.inf
        if not self.symbol:
            raise ValueError(f"{value!r} is not a number; write a number without unit")
        match = QUANTITY.fullmatch(value) if isinstance(value, str) else None
        if match is None:
            raise ValueError(f'{value!r} is not a quantity; write a number and its unit, as in "1 {self.symbol}"')
        return self._within_a_turn(as_number(float(match[1])) * self.factor(match[2]), "write an angle within one")

    def _within_a_turn(self, value: float, remedy: str) -> float:
        """Return a value in the SI unit. Raises ValueError for an angle beyond a turn."""
        if self.symbol == "rad" and abs(value) > TURN:
            raise ValueError(f"{value:g} rad is more than a turn; {remedy}")
        return value

    def written(self, value: float) -> float | str:
        """Return a value in the SI unit as a case file has it, which `parse` reads back as it is."""
        return f"{value!r} {self.symbol}" if self.symbol and math.isfinite(value) else value

    def __get_pydantic_core_schema__(self, source: object, handler: Callable[[object], dict[str, Any]]) -> Any:
        """Tell pydantic, where it checks a case file, to read such a number by `parse` and to write it by `written`."""
        return {
            "type": "function-before",
            "function": {"type": "no-info", "function": self.parse},
            "schema": handler(source) | {"allow_inf_nan": self.may_be_infinite},
            "serialization": {"type": "function-plain", "function": self.written},
        }

    def __get_pydantic_json_schema__(self, schema: object, handler: Callable[[object], dict[str, Any]]) -> Any:
        """Tell pydantic, where it describes a case file, which texts stand for such a number."""
        pattern = rf"^\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*({'|'.join(FACTORS.get(self.symbol, ()))})\s*$"
        texts = [{"type": "string", "pattern": pattern}] if self.symbol else []
        texts += [{"const": "none"}] if self.may_be_infinite else []
        return {"anyOf": [handler(schema), *texts], "unit": self.symbol}

    def factor(self, symbol: str) -> float:
        """Return the factor from `symbol` to the SI unit. Raises ValueError for a unit of another kind."""
        known = FACTORS[self.symbol]
        if symbol not in known:
            written = f"unit {symbol!r}" if symbol else "a text without a unit"
            raise ValueError(f"{written} does not fit; use one of {', '.join(known)}")
        return known[symbol]


def quantity(value: float, unit: str) -> str:
    """Return a value given in the SI unit, in that of its units which makes the shortest text without an exponent."""
    texts = [f"{value:g} {unit}" if float(f"{value:g}") == value else f"{value!r} {unit}"]
    for other, factor in FACTORS[unit].items():
        number = f"{value / factor:g}"
        if other in READ_AT_A_GLANCE and float(number) * factor == value:
            texts.append(f"{number} {other}")
    return min(texts, key=lambda text: ("e" in text.split()[0], len(text)))


def as_number(value: float) -> float:
    """Return a number (or inf) as float. Raises ValueError for nan and for a whole number that no float holds."""
    try:
        number = float(value)
    except OverflowError:
        raise ValueError("a number of more than 300 digits; write a smaller one") from None
    if math.isnan(number):
        raise ValueError("nan is not a number; write a finite one")
    return number
