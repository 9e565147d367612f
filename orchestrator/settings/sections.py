"""What a case file holds <-> the settings dataclasses of the stages: units converted, bounds checked, complaints in one
line.

The dataclass says everything by its type hints, `Annotated[float, Gt(0), Unit("m")]`; pydantic makes it by them. It
reads JSON, as only there is a list a tuple, and a table a dataclass, while no text and no truth is taken for a number.
"""

from __future__ import annotations

import difflib
import json
import math
import typing
from collections.abc import Sequence
from dataclasses import is_dataclass
from functools import cache
from typing import Any

from pydantic import ConfigDict, TypeAdapter, ValidationError

from orchestrator.basis.errors import CaseError

COMPLAINTS = {
    "dataclass_type": ("", "it is a section: write [{key}] and its keys below"),
    "tuple_type": ("", "write a list, in square brackets"),
    "too_short": ("", "write a list of at least one"),
    "string_too_short": ("", "write a text that is not empty"),
    "string_type": ("", 'write a text, in "quotes"'),
    "bool_type": ("", "write true or false"),
    "float_type": ("is not a number", "write a number without unit"),
    "finite_number": ("is not a finite number", "write a finite one"),
    "int_type": ("is not a whole number", "write one, without unit, below 1e9"),
}
"""problem ("": is not accepted) and remedy by pydantic's kinds of complaint, where its own words are a programmer's"""
RENAMED = {"normal": "tol_n", "tangential": "tol_s", "rotation": "tol_r", "centre_distance": "tol_d"}
"""keys of version 0.1 by what they are called now"""
LARGEST_WHOLE = 1e9
"""largest whole number where one is asked for"""
LARGEST_BITS = 1023
"""bits of the largest whole number that a float holds"""


@cache
def checked(kind: Any, *, described: bool = False) -> TypeAdapter[Any]:
    """Return pydantic's reader and writer of a settings dataclass; described: with the texts below the fields.

    It takes rules beside a dataclass only where this may be None.
    """
    rules = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False, use_attribute_docstrings=described)
    return TypeAdapter(kind | None, config=rules)


def settings_from(kind: Any, values: Any, section: str = "") -> Any:
    """Return settings of the dataclass `kind` from values as a case file has them, in a section of it or at its top.

    Raises CaseError (key only).
    """
    try:
        return checked(kind).validate_json(json.dumps(_plain(values), default=str))
    except ValidationError as error:
        raise _complaint(error, kind, section) from None


def number_or_text(text: str) -> float | str:
    """Return what stands behind an option of the command line as a case file would have it."""
    try:
        return float(text)
    except ValueError:
        return text


def row_type(hint: Any) -> Any:
    """Return the settings dataclass that a list of tables is made of (`tuple[DeadLoad, ...]`), else None."""
    member = next(iter(typing.get_args(hint)), None)
    return member if typing.get_origin(hint) is tuple and is_dataclass(member) else None


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


def _complaint(error: ValidationError, kind: Any, section: str) -> CaseError:
    """Return the first complaint as key, problem, remedy: a misspelt key before the one that it leaves missing."""
    first = min(error.errors(), key=lambda one: one["type"] == "missing")
    place, value = first["loc"], first["input"]
    shown = f"{float(f'{value:.12g}') if isinstance(value, float) else value!r:.60}"
    key = ".".join(filter(None, (section, *map(str, place))))
    if first["type"] == "unexpected_keyword_argument":
        known = _known_keys(kind, place[:-1])
        if (name := RENAMED.get(str(place[-1]))) in known:
            return CaseError(key, "has another name since version 0.2", f"write {name}")
        near = difflib.get_close_matches(str(place[-1]), known, 1)
        return CaseError(key, "is not a known key", f"did you mean {near[0]}?" if near else f"use {', '.join(known)}")
    if first["type"] == "missing":
        return CaseError(key, "is missing", "see templates/benchmark1.toml for an example")
    message = first["msg"].removeprefix("Value error, ")
    if first["type"] == "value_error" and "; " in message:
        return CaseError(key, *message.split("; ", 1))
    problem, remedy = COMPLAINTS.get(first["type"], ("", message[:1].lower() + message[1:]))
    return CaseError(key, f"{shown} {problem or 'is not accepted'}", remedy.format(key=key))


def _known_keys(kind: Any, place: Sequence[str | int]) -> list[str]:
    """Return the keys that may stand at a place such as `load`, `dead`, 0; numbers count the tables of a list."""
    for key in place:
        if isinstance(key, str):
            hint = typing.get_type_hints(kind)[key]
            kind = row_type(hint) or hint
    return list(typing.get_type_hints(kind))
