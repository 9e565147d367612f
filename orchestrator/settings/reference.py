"""What the case file may say, written out from the settings themselves: commented file, JSON schema, reference page."""

from __future__ import annotations

import ast
import inspect
import math
import textwrap
import types
import typing
from collections.abc import Iterator, Sequence
from dataclasses import MISSING, Field, dataclass, fields, replace
from typing import Any, Literal

import annotated_types as bounds

from orchestrator.basis.units import FACTORS, quantity
from orchestrator.settings import case as cases
from orchestrator.settings.sections import unit_of

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
QUANTITY = r"^\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*({units})\s*$"


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
    return tuple(
        CaseSection(name, " ".join(inspect.cleandoc(kind.__doc__ or "").split()), tuple(settings_of(kind)))
        for name, kind in cases.section_types().items()
    )


def tables() -> tuple[CaseSection, ...]:
    """Return every list of tables of a case file, named as in "load.dead", with the keys of one table."""
    return tuple(
        CaseSection(name, " ".join(inspect.cleandoc(kind.__doc__ or "").split()), tuple(settings_of(kind)))
        for name, kind in cases.table_types().items()
    )


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
            lines.append(f"{setting.key} = {value}" if value else f"# {setting.key} =   (left out)")
    return "\n".join(lines) + "\n"


def schema() -> dict[str, Any]:
    """Return the JSON schema (draft 2020-12) of a case file, for editors; quantities are numbers or texts with unit."""
    described = cases.json_schema()
    parts = described["$defs"]
    kinds = [*cases.section_types().values(), *cases.table_types().values()]
    for kind, section in dict(zip(kinds, (*sections(), *tables()), strict=True)).items():
        part = parts[kind.__name__]
        part["description"] = section.meaning
        for setting in section.settings:
            part["properties"][setting.key] = _described(part["properties"][setting.key], section.name, setting)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **_finite(described), "title": "Case file"}


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
    """Yield every setting of a dataclass, in order."""
    hints = typing.get_type_hints(kind, include_extras=True)
    meanings = _meanings(kind)
    for one in fields(kind):
        unit = unit_of(hints[one.name])
        symbol = unit.symbol if unit else ""
        yield Setting(one.name, _default(one, symbol), symbol, _range(hints[one.name]), meanings.get(one.name, ""))


def _meanings(kind: type[Any]) -> dict[str, str]:
    """Return the text below each field of a dataclass (Python keeps it in the source only)."""
    (definition,) = ast.parse(textwrap.dedent(inspect.getsource(kind))).body
    assert isinstance(definition, ast.ClassDef)
    found = {}
    for above, below in zip(definition.body, definition.body[1:], strict=False):
        if isinstance(above, ast.AnnAssign) and isinstance(above.target, ast.Name) and isinstance(below, ast.Expr):
            found[above.target.id] = " ".join(str(ast.literal_eval(below.value)).split())
    return found


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


def _range(hint: Any) -> str:
    """Return the bounds and choices of a type hint in words."""
    origin, members = typing.get_origin(hint), typing.get_args(hint)
    if origin is Literal:
        return "one of " + ", ".join(_toml(member) for member in members)
    if origin is typing.Union or origin is types.UnionType:
        return ", ".join(filter(None, (_range(member) for member in members if member is not type(None))))
    if origin is typing.Annotated:
        words = [_range(members[0]), *(_bound(member) for member in members[1:])]
        return ", ".join(word for word in words if word)
    if origin is tuple:
        return f"list, each {_range(members[0])}" if _range(members[0]) else "list"
    return {bool: "true or false", int: "whole number"}.get(hint, "")


def _bound(member: Any) -> str:
    limits = {bounds.Gt: ("gt", ">"), bounds.Ge: ("ge", "≥"), bounds.Lt: ("lt", "<"), bounds.Le: ("le", "≤")}
    for kind, (name, sign) in limits.items():
        if isinstance(member, kind):
            return f"{sign} {getattr(member, name):g}"
    return ""


def _described(found: dict[str, Any], section: str, setting: Setting) -> dict[str, Any]:
    """Return a property of the schema with its meaning, and with the texts that stand for its value."""
    about = {"description": "; ".join(part for part in (setting.meaning, setting.unit, setting.range) if part)}
    texts: list[dict[str, Any]] = []
    if setting.unit:
        texts.append({"type": "string", "pattern": QUANTITY.format(units="|".join(FACTORS[setting.unit]))})
    if section in cases.MAY_BE_INFINITE:
        texts.append({"const": "none"})
    if not texts:
        return found | about
    default = {"default": found["default"]} if found.get("default") is not None else {}
    plain = {key: value for key, value in found.items() if key not in ("default", "title")}
    if plain.get("type") == "array":
        return plain | {"items": {"anyOf": [plain["items"], *texts]}} | about | default
    return {"anyOf": [plain, *texts], **about, **default}


def _finite(value: Any) -> Any:
    """Return a value without infinite numbers, which JSON does not know."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    return "none" if isinstance(value, float) and math.isinf(value) else value


def _comment(text: str) -> list[str]:
    return [f"# {line}" for line in textwrap.wrap(text, 108)]
