"""A section of a case file <-> its settings dataclass: units converted, bounds checked, complaints in one line.

The dataclass says everything by its type hints, `Annotated[float, Unit("m"), Gt(0)]`; pydantic checks by them. A list
of tables is a tuple of such dataclasses.
"""

from __future__ import annotations

import difflib
import math
import typing
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, fields, is_dataclass
from functools import cache
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, ValidationError, create_model

from orchestrator.basis.errors import CaseError
from orchestrator.basis.units import Unit, as_number

REMEDIES = {
    "model_type": "it is a section: write [{key}] and its keys below",
    "tuple_type": "write a list, in square brackets",
    "too_short": "write a list of at least one",
    "string_too_short": "write a text that is not empty",
    "string_type": 'write a text, in "quotes"',
    "float_type": "write a number",
    "float_parsing": "write a number",
}
"""what to do, by pydantic's kinds of complaint, where its own words are a programmer's"""


def settings_from(kind: type, values: dict[str, Any]) -> Any:
    """Return settings of the dataclass `kind` from values as a case file has them. Raises CaseError (key only)."""
    try:
        return as_settings(kind, section_model(kind).model_validate(values))
    except ValidationError as error:
        raise first_complaint(error, typing.get_type_hints(kind)) from None


def as_settings(kind: type, validated: BaseModel) -> Any:
    """Return the settings dataclass of a validated section, the tables in its lists too."""
    hints = typing.get_type_hints(kind)

    def plain(name: str, value: Any) -> Any:
        rows = isinstance(value, tuple) and row_type(hints[name])
        return tuple(as_settings(rows, member) for member in value) if rows else value

    return kind(**{f.name: plain(f.name, getattr(validated, f.name)) for f in fields(kind)})


def row_type(hint: Any) -> Any:
    """Return the settings dataclass that a list of tables is made of (`tuple[DeadLoad, ...]`), else None."""
    member = next(iter(typing.get_args(hint)), None)
    return member if typing.get_origin(hint) is tuple and is_dataclass(member) else None


def unit_of(hint: Any) -> Unit | None:
    """Return the unit that a type hint carries."""
    for member in typing.get_args(hint):
        found = member if isinstance(member, Unit) else unit_of(member)
        if found is not None:
            return found
    return None


@cache
def section_model(kind: type, may_be_infinite: bool = False) -> type[BaseModel]:
    """Return the pydantic model of a settings dataclass; `may_be_infinite`: its floats, by `inf` or "none"."""
    hints = typing.get_type_hints(kind, include_extras=True)
    parts: dict[str, Any] = {
        f.name: (_validated(hints[f.name], may_be_infinite), ... if f.default is MISSING else f.default)
        for f in fields(kind)
    }
    return create_model(kind.__name__, __config__=ConfigDict(extra="forbid", strict=False, defer_build=True), **parts)


def _validated(hint: Any, may_be_infinite: bool) -> Any:
    """Return the type hint with the conversion of its unit and the refusal of nan (and inf) in front."""
    if row := row_type(hint):
        return tuple[section_model(row), ...]  # type: ignore[misc]
    if typing.get_origin(_plain_type(hint)) is tuple:
        return _validated_list(hint, may_be_infinite)
    if _plain_type(hint) is not float:
        return Annotated[hint, BeforeValidator(_whole_number)] if _plain_type(hint) is int else hint
    unit = unit_of(hint)

    def number(value: Any) -> Any:
        if value is None:
            return None
        if value == "none" and may_be_infinite:
            return math.inf
        if unit is None and (isinstance(value, bool) or not isinstance(value, int | float)):
            raise ValueError(f"{value!r} is not a number; write a number without unit")
        result = as_number(value) if unit is None else unit.parse(value)
        if math.isnan(result) or (math.isinf(result) and not may_be_infinite):
            raise ValueError(f"{value!r} is not a finite number; write a finite one")
        return result

    return Annotated[hint, BeforeValidator(number)]


def _validated_list(hint: Any, may_be_infinite: bool) -> Any:
    """Return the type hint of a list with `_validated` members."""
    member, *_ = typing.get_args(_plain_type(hint))
    members = tuple.__class_getitem__((_validated(member, may_be_infinite), ...))
    conditions = typing.get_args(hint)[1:] if typing.get_origin(hint) is Annotated else ()
    return Annotated[members, *conditions] if conditions else members


def _whole_number(value: Any) -> Any:
    whole = (isinstance(value, int) and not isinstance(value, bool)) or (
        isinstance(value, float) and value.is_integer()
    )
    if not whole or abs(value) >= 1e9:
        raise ValueError(f"{str(value)[:40]} is not a whole number; write one, without unit, below 1e9")
    return value


def _plain_type(hint: Any) -> Any:
    """Return float for `Annotated[float, ...]` and `Annotated[float, ...] | None`, else the bare type."""
    members = [member for member in typing.get_args(hint) if member is not type(None)]
    if typing.get_origin(hint) is Annotated or type(None) in typing.get_args(hint):
        return _plain_type(members[0])
    return hint


def written(settings: Any) -> dict[str, Any]:
    """Return settings as they stand in a case file; what is None is left out."""
    values = {f.name: getattr(settings, f.name) for f in fields(settings)}
    return {name: _written_value(settings, name, value) for name, value in values.items() if value is not None}


def _written_value(settings: Any, name: str, value: Any) -> Any:
    """Return a value as it stands in a case file, with its unit."""
    unit = unit_of(typing.get_type_hints(type(settings), include_extras=True)[name])
    if isinstance(value, tuple):
        return [written(item) if is_dataclass(item) else _with_unit(item, unit) for item in value]
    return _with_unit(value, unit)


def _with_unit(value: Any, unit: Unit | None) -> Any:
    if unit is None or value is None:
        return value
    return value if math.isinf(value) else f"{value!r} {unit.symbol}"


def first_complaint(error: ValidationError, hints: Mapping[str, Any]) -> CaseError:
    """Return the first complaint as key, problem, remedy; `hints`: the types of what may stand at the top, by key."""
    first = error.errors()[0]
    place = [str(part) for part in first["loc"]]
    key = ".".join(place)
    if first["type"] == "extra_forbidden":
        known = _known_keys(hints, place[:-1])
        near = difflib.get_close_matches(place[-1], known, 1)
        return CaseError(key, "is not a known key", f"did you mean {near[0]}?" if near else f"use {', '.join(known)}")
    if first["type"] == "missing":
        return CaseError(key, "is missing", "see templates/benchmark1.toml for an example")
    if first["type"] in REMEDIES:
        return CaseError(key, f"{first['input']!r} is not accepted", REMEDIES[first["type"]].format(key=key))
    message = first["msg"].removeprefix("Value error, ")
    if "; " in message:
        problem, _, remedy = message.partition("; ")
        return CaseError(key, problem, remedy)
    return CaseError(key, f"{first['input']!r} is not accepted", message[:1].lower() + message[1:])


def _known_keys(hints: Mapping[str, Any], place: Sequence[str]) -> list[str]:
    """Return the keys that may stand at a place such as `load`, `dead`, `0`; numbers count the tables of a list."""
    for key in place:
        if not key.isdigit():
            kind = hints[key] if is_dataclass(hints[key]) else row_type(hints[key])
            hints = typing.get_type_hints(kind)
    return list(hints)
