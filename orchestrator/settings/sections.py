"""What a case file holds <-> the settings dataclasses of the stages: units converted, bounds checked, complaints in one
line.

What the dataclass says by the types of its fields holds in Python too (basis/checked.py). A case file is read as JSON,
as only there is a list a tuple, and a table a dataclass, while no text and no truth is taken for a number.
"""

from __future__ import annotations

import json
import math
from typing import Any

from pydantic import ValidationError

from orchestrator.basis.checked import checked, complaint

LARGEST_WHOLE = 1e9
"""largest whole number where one is asked for"""
LARGEST_BITS = 1023
"""bits of the largest whole number that a float holds"""


def settings_from(kind: Any, values: Any, section: str = "") -> Any:
    """Return settings of the dataclass `kind` from values as a case file has them, in a section of it or at its top.

    Raises CaseError (key only).
    """
    try:
        return checked(kind).validate_json(json.dumps(_plain(values), default=str))
    except ValidationError as error:
        raise complaint(error, kind, section) from None


def number_or_text(text: str) -> float | str:
    """Return what stands behind an option of the command line as a case file would have it."""
    try:
        return float(text)
    except ValueError:
        return text


def _plain(value: Any) -> Any:
    """Return what a case file holds with whole numbers as int, however written, and others as float."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, bool) or not isinstance(value, int | float):
        return value
    if isinstance(value, int) and value.bit_length() > LARGEST_BITS:
        return math.inf
    return int(value) if abs(value) < LARGEST_WHOLE and value == int(value) else float(value)
