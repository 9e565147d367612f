"""Case file (TOML) -> Case: everything the user asked, defaults filled in, units converted, bounds checked.

Each section is a settings dataclass declared beside the mechanics that use it; this module nests them, and turns every
complaint into one line with file, key and remedy. `inf` (or "none") switches a macroblock tolerance off.
"""

from __future__ import annotations

import difflib
import math
import tomllib
import typing
from collections.abc import Sequence
from dataclasses import MISSING, dataclass, field, fields, is_dataclass, replace
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal

import tomli_w
from annotated_types import Gt, MinLen
from pydantic import BaseModel, BeforeValidator, ConfigDict, ValidationError, create_model

from orchestrator.errors import CaseError, naming
from orchestrator.joints import JointSettings
from orchestrator.limit_analysis import LimitAnalysisSettings, LoadSettings
from orchestrator.macroblocks import TOLERANCES, MacroblockSettings
from orchestrator.masonry.classes import BlockClass, with_classes
from orchestrator.masonry.readers import read_blocks, refuse_what_is_no_file, refuse_what_is_not_utf8
from orchestrator.masonry.wall import Wall
from orchestrator.meshing import MeshSettings
from orchestrator.pushover.nodal_loads import refuse_upright
from orchestrator.pushover.settings import ContactSettings, ElasticSettings, NewtonSettings, SteppingSettings
from orchestrator.seismic import SeismicSettings, spectrum_of
from orchestrator.study import StudySettings
from orchestrator.units import Unit, as_number

ModelName = Literal["macro", "micro"]
MAY_BE_INFINITE = ("macroblocks", "study", "seismic")
LARGEST_FILE = 1_000_000  # bytes
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


@dataclass(frozen=True, slots=True)
class WallSettings:
    """Where the blocks come from; the other values, where given, replace the block file's."""

    blocks: Annotated[str, MinLen(1)]
    """path of the block file, relative to the case file"""
    thickness: Annotated[float, Unit("m"), Gt(0)] | None = None
    """of the wall, out of its plane"""
    unit_weight: Annotated[float, Unit("N/m3"), Gt(0)] | None = None
    """of every block, those with a value of their own too"""
    friction: Annotated[float, Gt(0)] | None = None
    """coefficient of friction (tangent of the friction angle) of every joint; [joints] may change some"""
    classes: tuple[BlockClass, ...] = ()
    """blocks of one material, each a table [[wall.classes]] with `material` (blocks have it in the block file) and what
    it has of its own: `unit_weight`, `thickness`, `friction`, `elastic_modulus`, `poisson_ratio`"""


@dataclass(frozen=True, slots=True)
class RunSettings:
    """Which partitions the FE pushover is run on: macroblocks, every stone (micro), or both."""

    models: Annotated[tuple[ModelName, ...], MinLen(1)] = ("macro", "micro")
    """"macro": macroblocks; "micro": every stone is a body; they run in this order"""


@dataclass(frozen=True, slots=True)
class Case:
    """A case as read; `file` is where it came from."""

    wall: WallSettings
    name: str = ""
    load: LoadSettings = field(default_factory=LoadSettings)
    joints: JointSettings = field(default_factory=JointSettings)
    limit_analysis: LimitAnalysisSettings = field(default_factory=LimitAnalysisSettings)
    macroblocks: MacroblockSettings = field(default_factory=MacroblockSettings)
    mesh: MeshSettings = field(default_factory=MeshSettings)
    elastic: ElasticSettings = field(default_factory=ElasticSettings)
    contact: ContactSettings = field(default_factory=ContactSettings)
    newton: NewtonSettings = field(default_factory=NewtonSettings)
    stepping: SteppingSettings = field(default_factory=SteppingSettings)
    run: RunSettings = field(default_factory=RunSettings)
    study: StudySettings = field(default_factory=StudySettings)
    seismic: SeismicSettings = field(default_factory=SeismicSettings)
    file: Path = field(default=Path(), compare=False)

    @property
    def block_file(self) -> Path:
        """Path of the block file."""
        return self.file.parent / self.wall.blocks


def read(path: Path, overrides: Sequence[str] = ()) -> Case:
    """Return the case in `path`: a case file, or a block file (.json) with the default of every setting.

    overrides: "section.key=value" each. Raises CaseError.
    """
    try:
        refuse_what_is_not_utf8(str(path), "")
        record = {"wall": {"blocks": path.name}} if path.suffix.lower() == ".json" else _toml(path)
        for override in overrides:
            _override(record, override)
        case = _case(record)
    except CaseError as error:
        raise error.in_file(str(path)) from None
    return replace(case, file=path, name=case.name or path.stem)


def read_wall(case: Case) -> Wall:
    """Return the wall of a case: its block file with the replacements and block classes of [wall]. Raises CaseError."""
    wall, given = read_blocks(case.block_file), case.wall
    if given.unit_weight is not None:
        wall = replace(wall, blocks=tuple(replace(block, unit_weight=given.unit_weight) for block in wall.blocks))
    replaced = {name: value for name in ("thickness", "friction") if (value := getattr(given, name)) is not None}
    with naming(case.file):
        return with_classes(replace(wall, **replaced), given.classes)


def refuse_what_only_limit_analysis_takes(case: Case) -> None:
    """Raise CaseError for loads and strengths that the FE pushover would silently leave out."""
    with naming(case.file):
        refuse_upright(case.load)
    for number, given in enumerate(case.joints.classes):
        if given.compressive_strength is not None:
            key, problem = f"joints.classes.{number}.compressive_strength", "the FE pushover knows no crushing"
            raise CaseError(key, problem, "use the commands limit or segment, or leave it out", str(case.file))


def refuse_spectrum(case: Case) -> None:
    """Raise CaseError for a spectrum that lacks a setting, before anything is computed."""
    if case.seismic.peak_ground_acceleration is not None:
        with naming(case.file):
            spectrum_of(case.seismic, case.seismic.peak_ground_acceleration)


def as_toml(case: Case, block_file: str) -> str:
    """Return a case file that reads back as `case` with its blocks in `block_file`; all defaults filled in."""
    record: dict[str, Any] = {"name": case.name}
    for section in _sections():
        record[section] = _written_settings(getattr(case, section))
    record["wall"]["blocks"] = block_file
    return tomli_w.dumps(record)


def _written_settings(settings: Any) -> dict[str, Any]:
    """Return settings as they stand in a case file; what is None is left out."""
    values = {f.name: getattr(settings, f.name) for f in fields(settings)}
    return {name: _written(settings, name, value) for name, value in values.items() if value is not None}


def _written(settings: Any, name: str, value: Any) -> Any:
    """Return a value as it stands in a case file, with its unit."""
    unit = _unit(typing.get_type_hints(type(settings), include_extras=True)[name])
    if isinstance(value, tuple):
        return [_written_settings(item) if is_dataclass(item) else _with_unit(item, unit) for item in value]
    return _with_unit(value, unit)


def _with_unit(value: Any, unit: Unit | None) -> Any:
    if unit is None or value is None:
        return value
    return value if math.isinf(value) else f"{value!r} {unit.symbol}"


def settings_from(kind: type, values: dict[str, Any]) -> Any:
    """Return settings of the dataclass `kind` from values as a case file has them. Raises CaseError (key only)."""
    try:
        return kind(**_section_model("", kind).model_validate(values).model_dump())
    except ValidationError as error:
        raise _first_complaint(error) from None


def section_types() -> dict[str, type]:
    """Return the settings dataclass of each section of a case file."""
    return _sections()


def table_types() -> dict[str, type]:
    """Return the settings dataclass of each list of tables, as in "load.dead", those within tables too."""
    found: dict[str, type] = {}
    waiting = list(_sections().items())
    while waiting:
        name, kind = waiting.pop(0)
        hints = typing.get_type_hints(kind)
        rows = [(f"{name}.{f.name}", row) for f in fields(kind) if (row := _row(hints[f.name]))]
        found |= dict(rows)
        waiting += rows
    return found


def unit_of(hint: Any) -> Unit | None:
    """Return the unit that a type hint carries."""
    return _unit(hint)


def json_schema() -> dict[str, Any]:
    """Return the JSON schema of the case file as pydantic knows it: quantities as numbers in SI."""
    return _model().model_json_schema()


def _toml(path: Path) -> dict[str, Any]:
    try:
        refuse_what_is_no_file(path, LARGEST_FILE, "is this a case file?")
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise CaseError("", "no such file", "give the path of a case file (.toml) or a block file (.json)") from None
    except (OSError, UnicodeDecodeError) as error:
        raise CaseError("", f"cannot be read ({error})", "give the path of a case file") from None
    except (ValueError, RecursionError) as error:  # not only TOMLDecodeError: numbers of 5000 digits
        raise CaseError("", f"is not TOML ({error})", "see templates/benchmark1.toml for an example") from None


def _override(record: dict[str, Any], override: str) -> None:
    """Set section.key in the record; the value is TOML where it can be, else text."""
    key, equals, text = override.partition("=")
    *sections, name = key.strip().split(".")
    if not equals or len(sections) > 1 or not all((*sections, name)):
        raise CaseError("--set", f"{override!r} is not of the form section.key=value", "as in --set mesh.size=100mm")
    try:
        value = tomllib.loads(f"value = {text}")["value"]
    except (ValueError, RecursionError):
        value = text.strip()
    target = record
    for section in sections:
        target = target.setdefault(section, {})
        if not isinstance(target, dict):
            raise CaseError(section, "is not a section", f"write [{section}]")
    target[name] = value


def _case(record: dict[str, Any]) -> Case:
    try:
        validated = _model().model_validate(record)
    except ValidationError as error:
        raise _first_complaint(error) from None
    sections = {name: _settings(cls, getattr(validated, name)) for name, cls in _sections().items()}
    given = validated.macroblocks.model_fields_set  # type: ignore[attr-defined]
    if "choose" not in given and given & set(TOLERANCES):
        sections["macroblocks"] = replace(sections["macroblocks"], choose="tolerances")
    return Case(name=validated.name, **sections)  # type: ignore[attr-defined]


def _settings(cls: type, validated: BaseModel) -> Any:
    """Return the settings dataclass of a validated section, the tables in its lists too."""
    hints = typing.get_type_hints(cls)

    def plain(name: str, value: Any) -> Any:
        rows = isinstance(value, tuple) and _row(hints[name])
        return tuple(_settings(rows, member) for member in value) if rows else value

    return cls(**{f.name: plain(f.name, getattr(validated, f.name)) for f in fields(cls)})


def _row(hint: Any) -> Any:
    """Return the settings dataclass that a list of tables is made of (`tuple[DeadLoad, ...]`), else None."""
    member = next(iter(typing.get_args(hint)), None)
    return member if typing.get_origin(hint) is tuple and is_dataclass(member) else None


def _sections() -> dict[str, type]:
    hints = typing.get_type_hints(Case)
    return {f.name: hints[f.name] for f in fields(Case) if f.name not in ("name", "file")}


@cache
def _model() -> type[BaseModel]:
    """Return the pydantic model of a case file, made from the settings dataclasses."""
    parts: dict[str, Any] = {"name": (str, "")}
    for name, settings in _sections().items():
        part = _section_model(name, settings)
        parts[name] = (part, ...) if name == "wall" else (part, part())
    return create_model("CaseFile", __config__=ConfigDict(extra="forbid"), **parts)


@cache
def _section_model(section: str, settings: type) -> type[BaseModel]:
    hints = typing.get_type_hints(settings, include_extras=True)
    parts: dict[str, Any] = {
        f.name: (_validated(hints[f.name], section in MAY_BE_INFINITE), ... if f.default is MISSING else f.default)
        for f in fields(settings)
    }
    return create_model(settings.__name__, __config__=ConfigDict(extra="forbid", strict=False), **parts)


def _validated(hint: Any, may_be_infinite: bool) -> Any:
    """Return the type hint with the conversion of its unit and the refusal of nan (and inf) in front."""
    if row := _row(hint):
        return tuple[_section_model("", row), ...]  # type: ignore[misc]
    if typing.get_origin(_plain_type(hint)) is tuple:
        return _validated_list(hint, may_be_infinite)
    if _plain_type(hint) is not float:
        return Annotated[hint, BeforeValidator(_whole_number)] if _plain_type(hint) is int else hint
    unit = _unit(hint)

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


def _unit(hint: Any) -> Unit | None:
    for member in typing.get_args(hint):
        found = member if isinstance(member, Unit) else _unit(member)
        if found is not None:
            return found
    return None


def _first_complaint(error: ValidationError) -> CaseError:
    """Return the first complaint as key, problem, remedy."""
    first = error.errors()[0]
    place = [str(part) for part in first["loc"]]
    key = ".".join(place)
    if first["type"] == "extra_forbidden":
        known = _known_keys(place[:-1])
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


def _known_keys(place: list[str]) -> list[str]:
    if not place:
        return ["name", *_sections()]
    section: Any = _sections().get(place[0])
    for key in place[1:]:
        section = section if key.isdigit() else _row(typing.get_type_hints(section).get(key))
    return [f.name for f in fields(section)] if section else []
