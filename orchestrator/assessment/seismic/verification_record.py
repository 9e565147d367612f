"""Reading the record of a verification (`seismic` of summary.json): its notes, numbered, and values with their unit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from orchestrator.basis.printed import Figure, printed

UNITS: dict[str, tuple[Figure, str]] = {
    "m": ("displacement", "mm"), "m/s2": ("acceleration", "m/s²"), "drift": ("drift", "%")
}  # fmt: skip
"""of demand and capacity in the record: which figure they are, and the unit it is printed in"""


def notes(record: Mapping[str, Any]) -> list[str]:
    """Return every remark and refusal once, in order; a note's number is its place from 1."""
    return list(dict.fromkeys(text for row in record["checks"] for text in said(row)))


def said(row: Mapping[str, Any]) -> list[str]:
    """Return the remarks of a row, or why it was refused."""
    return [row["refused"]] if "refused" in row else list(row["remarks"])


def numbers(row: Mapping[str, Any], of: list[str]) -> str:
    """Return the numbers of a row's notes in order, as in "1, 3"."""
    return ", ".join(map(str, sorted(of.index(text) + 1 for text in said(row))))


def in_its_unit(value: float, unit: str) -> str:
    """Return a displacement (m) in mm, an acceleration in m/s2, a drift in per cent, with its unit."""
    figure, shown = UNITS[unit]
    return f"{printed(figure, value)} {shown}"


def verdict(record: Mapping[str, Any]) -> str:
    """Return in a line how many checks pass, which is the least, and how many could not be made."""
    made = [row for row in record["checks"] if "refused" not in row]
    refused = len(record["checks"]) - len(made)
    parts = ["nothing could be verified"]
    if made:
        least = min(made, key=lambda row: float(row["safety_ratio"]))
        passed = sum(row["safety_ratio"] >= 1.0 for row in made)
        of = f"{least['approach']}, {least['limit_state']}"
        parts = [
            f"{passed} of {len(made)} checks pass",
            f"least safety ratio {printed('ratio', least['safety_ratio'])} ({of})",
        ]
    if refused:
        parts.append(f"{refused} could not be made")
    return "; ".join(parts)


def ratio(row: Mapping[str, Any]) -> str:
    """Return the safety ratio, and in brackets that with e* = 1 where the row has one."""
    without = row.get("safety_ratio_without_e_star")
    return printed("ratio", row["safety_ratio"]) + ("" if without is None else f" ({printed('ratio', without)})")
