"""How a figure is printed: one form for terminal, report and pictures, so that no figure stands in two roundings."""

from __future__ import annotations

from typing import Literal

Figure = Literal[
    "multiplier", "limit multiplier", "ratio", "force", "displacement", "stiffness", "weight", "seconds", "memory"
]
FORMS: dict[Figure, tuple[str, float, str]] = {
    "multiplier": ("", 1.0, ".4f"),
    "limit multiplier": ("", 1.0, ".5f"),
    "ratio": ("", 1.0, ".3f"),
    "force": ("kN", 1e-3, "#.4g"),
    "displacement": ("mm", 1e3, "#.4g"),
    "stiffness": ("kN/mm", 1e-6, "#.4g"),
    "weight": ("kN", 1e-3, ".3f"),
    "seconds": ("s", 1.0, "#.3g"),
    "memory": ("MB", 1e-6, ".0f"),
}
"""unit, factor from SI, and form of each kind of figure"""


def printed(figure: Figure, value: float | None) -> str:
    """Return a figure given in SI as it is printed, without its unit; a dash for none."""
    if value is None:
        return "–"
    _, factor, form = FORMS[figure]
    text = format(value * factor, form).removesuffix(".")
    return format(value * factor, ".0f") if "e+" in text else text
