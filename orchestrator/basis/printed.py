"""How a figure is printed: one form for terminal, report and pictures, so that no figure stands in two roundings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

Figure = Literal[
    "multiplier", "limit multiplier", "ratio", "force", "displacement", "acceleration", "drift", "stiffness", "stress",
    "weight", "seconds", "memory",
]  # fmt: skip
FORMS: dict[Figure, tuple[float, str]] = {
    "multiplier": (1.0, ".4f"),
    "limit multiplier": (1.0, ".5f"),
    "ratio": (1.0, ".3f"),
    "force": (1e-3, "#.4g"),
    "displacement": (1e3, "#.4g"),
    "acceleration": (1.0, "#.4g"),
    "drift": (1e2, "#.4g"),
    "stiffness": (1e-6, "#.4g"),
    "stress": (1e-6, ".2g"),
    "weight": (1e-3, ".3f"),
    "seconds": (1.0, "#.3g"),
    "memory": (1e-6, ".0f"),
}
"""factor from SI to -, kN, mm, m/s2, %, kN/mm, MPa, s or MB, and form of each kind of figure"""
FIXED = ("multiplier", "limit multiplier", "weight")
"""figures with as many decimals, however small they are"""
LEAST_FIXED = 1e-2
"""below which these have four digits: the unit of a multiplier is what the user says, 1 kN or 1 MN"""
FEW = 3
"""things that a complaint lists"""


def printed(figure: Figure, value: float | None) -> str:
    """Return a figure given in SI as it is printed, without its unit; a dash for none."""
    if value is None:
        return "–"
    factor, form = FORMS[figure]
    if figure in FIXED and 0.0 < abs(value * factor) < LEAST_FIXED:
        form = "#.4g"
    text = format(value * factor, form).removesuffix(".")
    return format(value * factor, ".0f") if "e+" in text else text


def as_lambda(value: float) -> str:
    """Return a load multiplier as it is printed."""
    return printed("multiplier", value)


def as_place(x: float, y: float) -> str:
    """Return a place (m) in four digits, or to the millimetre where coordinates are large, as those of a survey."""

    def of(value: float) -> str:
        return f"{value:.4g}" if abs(value) < 10.0 else f"{value:.3f}".rstrip("0").rstrip(".")

    return f"({of(x)}, {of(y)})"


def counted(number: int, name: str) -> str:
    """Return how many there are of what `name` is one of, as in "1 joint"."""
    return f"{number} {name}" if number == 1 else f"{number} {name}s"


def millimetres(length: float) -> str:
    """Return a length (m) in mm with two digits, without its sign."""
    return f"{float(f'{1e3 * abs(length):.2g}'):g} mm"


def percent_of(share: float) -> str:
    """Return a share in per cent with two digits."""
    return f"{float(f'{100 * share:.2g}'):g} %"


def percent_more(value: float, than: float) -> str:
    """Return by how much a value is more (+) or less (-) than another, as in "+5.0%"; rounded to nothing +0.0%."""
    return f"{round(100 * (value / than - 1.0), 1) + 0.0:+.1f}%"


def marked(figure: Figure, value: float | None, closed: bool) -> str:
    """Return a figure as it is printed, in brackets where it is of a state that was not closed."""
    return printed(figure, value) if closed or value is None else f"({printed(figure, value)})"


def few(things: Sequence[object], separator: str = ", ") -> str:
    """Return the first things of a list in one line, and how many more there are."""
    return separator.join(map(str, things[:FEW])) + f" and {len(things) - FEW} more" * (len(things) > FEW)


def wedged_words(stones: Sequence[int]) -> str:
    """Return that stones, by their ids, go down under the dead load unless something presses them."""
    ids = ", ".join(map(str, stones))
    return f"{f'stones {ids} go' if len(stones) > 1 else f'stone {ids} goes'} down under the dead load unless wedged"
