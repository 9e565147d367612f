"""What the case file may say, written out from the settings themselves: commented file, JSON schema, reference page."""

from __future__ import annotations

import inspect
import math
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import MISSING, Field, dataclass, fields, replace
from functools import cache
from typing import Any

from orchestrator.basis.checked import checked
from orchestrator.basis.units import quantity
from orchestrator.settings import case as cases

REQUIRED = "required"
USUAL = {
    "wall": ("blocks", "thickness", "unit_weight", "friction"),
    "project": ("client", "author", "date", "place", "language"),
    "load": ("direction", "distribution", "dead"),
    "mesh": ("size",),
    "elastic": ("elastic_modulus", "poisson_ratio"),
    "stepping": ("final_displacement",),
    "run": ("models",),
    "seismic": ("peak_ground_acceleration", "spectrum", "ground"),
}
"""sections and keys of a short case file"""
BOUNDS = {"exclusiveMinimum": ">", "minimum": "≥", "exclusiveMaximum": "<", "maximum": "≤"}


@dataclass(frozen=True, slots=True)
class Setting:
    """One key of a section. default: as written in a case file, REQUIRED, or "" where leaving it out means something.

    unit: SI symbol or ""; range: such as "> 0"; meaning: "" where the section's own text says it.
    """

    key: str
    default: str
    unit: str
    range: str
    meaning: str


@dataclass(frozen=True, slots=True)
class CaseSection:
    """One section of the case file, its meaning and keys."""

    name: str
    meaning: str
    settings: tuple[Setting, ...]


def sections() -> tuple[CaseSection, ...]:
    """Return every section of a case file, in order."""
    return tuple(_section(name, kind) for name, kind in cases.section_types().items())


def tables() -> tuple[CaseSection, ...]:
    """Return every list of tables of a case file, named as in "load.dead", with the keys of one table."""
    return tuple(_section(name, kind) for name, kind in cases.table_types().items())


def _section(name: str, kind: type[Any]) -> CaseSection:
    return CaseSection(name, _line(inspect.getdoc(kind)), tuple(settings_of(kind)))


def commented_case(name: str, block_file: str) -> str:
    """Return a case file for the wall in `block_file` that states every default, its unit and its meaning."""
    opening = "Every setting has its default: what you do not change may be deleted."
    return _stated(name, block_file, opening, sections())


def short_case(name: str, block_file: str) -> str:
    """Return a case file for the wall in `block_file` with the settings that most walls change (`USUAL`) alone."""
    usual = [
        replace(section, settings=tuple(one for one in section.settings if one.key in USUAL[section.name]))
        for section in sections()
        if section.name in USUAL
    ]
    where = "`new NAME --all-keys` writes all settings, and the page Settings of the documentation explains them."
    return _stated(name, block_file, f"What most walls change; {where}", usual)


def _stated(name: str, block_file: str, opening: str, shown: Sequence[CaseSection]) -> str:
    """Return a case file with the settings of some sections, each under its meaning, unit and range."""
    lines = [
        *_comment(f"{name}. {opening}"),
        '# A value with a unit is text, as in "450 mm"; a bare number is in the SI unit. Check it with',
        f"#     python -m orchestrator check {name}.toml",
        "",
        f"name = {_toml(name)}",
    ]
    for section in shown:
        lines += ["", *_comment(section.meaning), f"[{section.name}]"]
        for setting in section.settings:
            about = [setting.meaning, f"unit {setting.unit}" if setting.unit else "", setting.range]
            lines += _comment("; ".join(part for part in about if part))
            value = _toml(block_file) if setting.default == REQUIRED else setting.default
            stated = value and f"{section.name}.{setting.key}" not in cases.table_types()  # TOML: a list or its tables
            lines.append(f"{setting.key} = {value}" if stated else f"# {setting.key} =   (left out)")
    return "\n".join(lines) + "\n"


def schema() -> dict[str, Any]:
    """Return the JSON schema (draft 2020-12) of a case file of a plane wall, for editors.

    Quantities are numbers or texts with unit.
    """
    parts = {name: part | {"properties": dict(part["properties"])} for name, part in _described().items()}
    kinds = [*cases.section_types().values(), *cases.table_types().values()]
    for kind, section in zip(kinds, (*sections(), *tables()), strict=True):
        part = parts[kind.__name__]
        part |= {"description": section.meaning, "additionalProperties": False}
        for one in section.settings:
            about = "; ".join(filter(None, (one.meaning, one.unit, one.range)))
            part["properties"][one.key] = part["properties"][one.key] | {"description": about}
    top = parts.pop(cases.CaseFile.__name__)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$defs": parts,
        **top,
        "title": "Case file of a plane wall",
    }


@cache
def _described() -> dict[str, Any]:
    """Return the JSON schema of every settings dataclass by its name, as pydantic knows it."""
    parts: dict[str, Any] = _finite(checked(cases.CaseFile, described=True).json_schema())["$defs"]
    return parts


def reference_page() -> str:
    """Return the settings reference (Markdown): a table per section, and per list of tables."""
    lines = ["# Settings", "", "Every section and key of a case file, written from the program itself.", ""]
    headed = [(f"[{section.name}]", section) for section in sections()]
    headed += [(f"[[{table.name}]]", table) for table in tables() if table.name.count(".") == 1]
    for heading, section in headed:
        lines += [f"## `{heading}`", "", section.meaning, ""]
        lines += ["| key | default | unit | range | meaning |", "|---|---|---|---|---|"]
        for one in section.settings:
            default = f"`{one.default}`" if one.default else "left out"
            cells = (f"`{one.key}`", default, one.unit, one.range.replace("|", "\\|"), one.meaning.replace("|", "\\|"))
            lines.append(f"| {' | '.join(cells)} |")
        lines.append("")
    return "\n".join(lines)


def settings_of(kind: type[Any]) -> Iterator[Setting]:
    """Yield every setting of a dataclass of the case file, in order."""
    properties = _described()[kind.__name__]["properties"]
    for one in fields(kind):
        part = properties[one.name]
        unit = _unit(part)
        yield Setting(one.name, _default(one, unit), unit, _range(part), _line(part.get("description")))


def _line(text: str | None) -> str:
    return " ".join((text or "").split())


def _unit(part: Mapping[str, Any]) -> str:
    """Return the unit of a property of the schema, of the members where it is a list."""
    members = [*part.get("anyOf", ()), part.get("items", {})]
    return part.get("unit", "") or next(filter(None, (_unit(member) for member in members if member)), "")


def _default(one: Field[Any], unit: str) -> str:
    if one.default is MISSING and one.default_factory is MISSING:
        return REQUIRED
    value = one.default_factory() if one.default_factory is not MISSING else one.default
    return "" if value is None else _toml(value, unit)


def _toml(value: Any, unit: str = "") -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple | list):
        return f"[{', '.join(_toml(item, unit) for item in value)}]"
    if isinstance(value, float) and math.isinf(value):
        return '"none"'
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    return f'"{quantity(value, unit)}"' if unit else repr(value)


def _range(part: Mapping[str, Any]) -> str:
    """Return the bounds and choices of a property of the schema in words."""
    if "enum" in part:
        return "one of " + ", ".join(_toml(member) for member in part["enum"])
    if "items" in part:
        return ", each ".join(filter(None, ("list", _range(part["items"]))))
    words = [{"boolean": "true or false", "integer": "whole number"}.get(part.get("type", ""), "")]
    words += [_range(member) for member in part.get("anyOf", ())]
    words += [f"{sign} {part[name]:g}" for name, sign in BOUNDS.items() if name in part]
    return ", ".join(filter(None, words))


def _finite(value: Any) -> Any:
    """Return a schema without infinite numbers, which JSON does not know."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    return "none" if isinstance(value, float) and math.isinf(value) else value


def _comment(text: str) -> list[str]:
    return [f"# {line}" for line in textwrap.wrap(text, 108)]
