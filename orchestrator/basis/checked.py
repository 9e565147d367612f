"""Settings that hold what the types of their fields say, made in Python as well as read from a case file.

A field says everything by its type, `Annotated[float, Gt(0), Unit("m")]`; pydantic makes it by that, here alone.
"""

from __future__ import annotations

import difflib
import typing
from collections.abc import Sequence
from dataclasses import fields, is_dataclass
from functools import cache
from typing import Any

import numpy as np
from pydantic import ConfigDict, TypeAdapter, ValidationError

from orchestrator.basis.errors import CaseError
from orchestrator.basis.units import Unit, quantity

COMPLAINTS = {
    "dataclass_type": ("", "it is a section: write [{key}] and its keys below"),
    "tuple_type": ("", "write a list, in square brackets"),
    "too_short": ("", "write a list of at least {min_length}"),
    "too_long": ("", "write a list of at most {max_length}"),
    "string_too_short": ("", "write a text that is not empty"),
    "string_type": ("", 'write a text, in "quotes"'),
    "bool_type": ("", "write true or false"),
    "float_type": ("is not a number", "write a number without unit"),
    "finite_number": ("is not a finite number", "write a finite one"),
    "int_type": ("is not a whole number", "write one, without unit, below 1e9"),
}
"""problem ("": is not accepted) and remedy by pydantic's kinds of complaint, where its own words are a programmer's"""
BOUNDS = {
    "greater_than": ("gt", "more than"),
    "greater_than_equal": ("ge", "at least"),
    "less_than": ("lt", "less than"),
    "less_than_equal": ("le", "at most"),
}
"""which bound a number is beyond, by pydantic's kinds of complaint, and what is said of it"""
OTHER_EXAMPLES = "docs/your_wall.md"
"""file with an example of most tables of a case file"""
EXAMPLES = {
    "wall.classes": OTHER_EXAMPLES,
    "wall.floors": "docs/space.md",
    "wall": "templates/benchmark1.toml",
    "seismic": "docs/seismic.md",
}
"""file with an example of what is missing, by how its key begins: the first one that does counts"""
RENAMED = {"normal": "tol_n", "tangential": "tol_s", "rotation": "tol_r", "centre_distance": "tol_d"}
"""keys of version 0.1 by what they are called now"""


class Checked:
    """Settings, a frozen dataclass, whose fields are checked wherever they are made.

    Raises CaseError naming class and field. A quantity may be a text with its unit, as in "25 mm".
    """

    __slots__ = ()

    def __post_init__(self) -> None:
        kind: Any = type(self)
        for name, hint in _hints_of(kind).items():
            object.__setattr__(self, name, accepted(hint, getattr(self, name), f"{kind.__name__}.{name}"))


@cache
def checked(kind: Any, *, described: bool = False) -> TypeAdapter[Any]:
    """Return pydantic's reader and writer of a type; described: with the texts below the fields of dataclasses.

    It takes rules beside a dataclass only as one of several types.
    """
    rules = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False, use_attribute_docstrings=described)
    return TypeAdapter(kind | None if is_dataclass(kind) else kind, config=rules)


def accepted(hint: Any, value: Any, key: str) -> Any:
    """Return a value as its type has it: quantities in SI, arrays as tuples. Raises CaseError for `key`."""
    try:
        return checked(hint).validate_python(_without_arrays(value))
    except ValidationError as error:
        raise complaint(error, hint, key) from None


def row_type(hint: Any) -> Any:
    """Return the settings dataclass that a list of tables is made of (`tuple[DeadLoad, ...]`), else None."""
    member = next(iter(typing.get_args(hint)), None)
    return member if typing.get_origin(hint) is tuple and is_dataclass(member) else None


@cache
def _hints_of(kind: Any) -> dict[str, Any]:
    hints = typing.get_type_hints(kind, include_extras=True)
    return {one.name: hints[one.name] for one in fields(kind)}


def _without_arrays(value: Any) -> Any:
    """Return numbers and arrays of numpy as Python's, and lists as tuples."""
    value = value.tolist() if isinstance(value, np.ndarray | np.generic) else value
    return tuple(map(_without_arrays, value)) if isinstance(value, list | tuple) else value


def complaint(error: ValidationError, kind: Any, section: str) -> CaseError:
    """Return the first complaint as key, problem, remedy: a misspelt key before the one that it leaves missing."""
    first = min(error.errors(), key=lambda one: one["type"] == "missing")
    place = first["loc"]
    if place and place[-1] == "str":  # one of several types was asked for: the one that fits farthest is meant
        alternatives = [one for one in error.errors() if one["loc"][: len(place) - 1] == place[:-1]]
        first = max(alternatives, key=lambda one: len(one["loc"]))
        place = tuple(part for part in first["loc"] if part != "str" and "[" not in str(part))
    value = first["input"]
    shown = f"{float(f'{value:.12g}') if isinstance(value, float) else value!r:.60}"
    key = ".".join(filter(None, (section, *map(str, place))))
    if first["type"] == "unexpected_keyword_argument":
        known = _known_keys(kind, place[:-1])
        if (name := RENAMED.get(str(place[-1]))) in known:
            return CaseError(key, "has another name since version 0.2", f"write {name}")
        near = difflib.get_close_matches(str(place[-1]), known, 1)
        return CaseError(key, "is not a known key", f"did you mean {near[0]}?" if near else f"use {', '.join(known)}")
    if first["type"] == "missing":
        shown_in = next((file for start, file in EXAMPLES.items() if key.startswith(start)), OTHER_EXAMPLES)
        return CaseError(key, "is missing", f"see {shown_in} for an example")
    if first["type"] in BOUNDS:
        name, words = BOUNDS[first["type"]]
        bound = _quantity(first["ctx"][name], kind, place)
        try:
            said = _quantity(value, kind, place)
        except OverflowError:  # a whole number that no float holds
            said = shown
        return CaseError(key, f"{repr(value) if said == bound else said} is not accepted", f"write {words} {bound}")
    message = first["msg"].removeprefix("Value error, ")
    if first["type"] == "value_error" and "; " in message:
        return CaseError(key, *message.split("; ", 1))
    problem, remedy = COMPLAINTS.get(first["type"], ("", message[:1].lower() + message[1:]))
    return CaseError(key, f"{shown} {problem or 'is not accepted'}", remedy.format(key=key, **first.get("ctx", {})))


def _quantity(number: float, kind: Any, place: Sequence[str | int]) -> str:
    """Return the number of a field at a place such as `load`, `dead`, 0, `force` in the unit it is given in."""
    for key in place:
        if isinstance(key, str):
            hint = typing.get_type_hints(kind, include_extras=True).get(key)
            kind = row_type(hint) or hint
    short, parts = f"{number:.12g}", [kind]
    while parts:
        part = parts.pop()
        if isinstance(part, Unit) and part.symbol:
            return min((quantity(one, part.symbol) for one in (number, float(short))), key=len)
        parts += [*typing.get_args(part), *getattr(part, "__metadata__", ())]
    return short


def _known_keys(kind: Any, place: Sequence[str | int]) -> list[str]:
    """Return the keys that may stand at a place such as `load`, `dead`, 0; numbers count the tables of a list."""
    for key in place:
        if isinstance(key, str):
            hint = typing.get_type_hints(kind)[key]
            kind = row_type(hint) or hint
    return list(typing.get_type_hints(kind))
