"""Case file (TOML) -> Case: everything the user asked, defaults filled in, units converted, bounds checked.

Each section is a settings dataclass declared beside the mechanics that use it; this module nests them, sections.py
checks each against its dataclass. `inf` (or "none") switches a macroblock tolerance off.
"""

from __future__ import annotations

import shlex
import tomllib
import typing
from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from os import PathLike
from pathlib import Path
from typing import Annotated, Any, Literal

import tomli_w
from annotated_types import MinLen

from orchestrator.assessment.seismic.control import named_point
from orchestrator.assessment.seismic.settings import SeismicSettings, limit_states, refuse_building
from orchestrator.assessment.seismic.settings import refuse_ties as refuse_ties_verified
from orchestrator.assessment.seismic.spectrum import spectrum_of
from orchestrator.assessment.sensitivity import SensitivitySettings, given_ranges
from orchestrator.basis.checked import Checked, checked, row_type
from orchestrator.basis.errors import CaseError, naming, refuse_other_kind
from orchestrator.limit_analysis import LimitAnalysisSettings
from orchestrator.loads import LoadSettings
from orchestrator.macroblocks.criteria import TOLERANCES, MacroblockSettings
from orchestrator.macroblocks.tolerance_grid import StudySettings
from orchestrator.masonry.block_classes import BlockClass, with_classes
from orchestrator.masonry.joints import JointSettings
from orchestrator.masonry.sources import DRAWINGS, PICTURES, ROWS, VECTORS
from orchestrator.masonry.sources.block_files import (
    read_blocks,
    refuse_what_is_no_file,
    refuse_what_is_no_name,
    refuse_what_is_not_utf8,
    unreadable,
)
from orchestrator.masonry.ties import TieSettings
from orchestrator.masonry.wall import Friction, Thickness, UnitWeight, Wall
from orchestrator.pushover.meshing import MeshSettings
from orchestrator.pushover.settings import ContactSettings, ElasticSettings, NewtonSettings, SteppingSettings
from orchestrator.pushover.solids.nodal_loads import refuse_upright
from orchestrator.pushover.solids.tie_bars import refuse_rigid
from orchestrator.settings.project import ProjectSettings
from orchestrator.settings.sections import settings_from

ModelName = Literal["macro", "micro"]
LARGEST_FILE = 1_000_000
"""bytes of a case file"""
IMPORTED = (
    dict.fromkeys(DRAWINGS + VECTORS, "a drawing")
    | dict.fromkeys(ROWS, "row notation, not a case file")
    | dict.fromkeys(PICTURES, "a picture")
)
"""what a file that is no case file is, by its ending"""
NOT_DRAWN = dict.fromkeys(DRAWINGS + VECTORS, ("--thickness", "300 mm")) | dict.fromkeys(
    PICTURES, ("--thickness", "300 mm", "--scale", "2 mm")
)
"""what `import` has to be given with such a file, as an example"""


@dataclass(frozen=True, slots=True)
class WallSettings(Checked):
    """Where the blocks come from; the other values, where given, replace the block file's."""

    blocks: Annotated[str, MinLen(1)]
    """path of the block file, relative to the case file"""
    thickness: Thickness | None = None
    """of the wall, out of its plane"""
    unit_weight: UnitWeight | None = None
    """of every block, those with a value of their own too"""
    friction: Friction | None = None
    """coefficient of friction (tangent of the friction angle) of every joint; [joints] may change some"""
    classes: tuple[BlockClass, ...] = ()
    """blocks of one material, each a table [[wall.classes]] with `material` (blocks have it in the block file) and what
    it has of its own: `unit_weight`, `thickness`, `friction`, `elastic_modulus`, `poisson_ratio`"""


@dataclass(frozen=True, slots=True)
class RunSettings(Checked):
    """Which partitions the FE pushover is run on: macroblocks, every stone (micro), or both."""

    models: Annotated[tuple[ModelName, ...], MinLen(1)] = ("macro", "micro")
    """"macro": macroblocks; "micro": every stone is a body; they run in this order"""


@dataclass(frozen=True, slots=True)
class CaseFile:
    """What a case file holds."""

    wall: WallSettings
    name: str = ""
    project: ProjectSettings = field(default_factory=ProjectSettings)
    load: LoadSettings = field(default_factory=LoadSettings)
    joints: JointSettings = field(default_factory=JointSettings)
    reinforcement: TieSettings = field(default_factory=TieSettings)
    limit_analysis: LimitAnalysisSettings = field(default_factory=LimitAnalysisSettings)
    macroblocks: MacroblockSettings = field(default_factory=MacroblockSettings)
    mesh: MeshSettings = field(default_factory=MeshSettings)
    elastic: ElasticSettings = field(default_factory=ElasticSettings)
    contact: ContactSettings = field(default_factory=ContactSettings)
    newton: NewtonSettings = field(default_factory=NewtonSettings)
    stepping: SteppingSettings = field(default_factory=SteppingSettings)
    run: RunSettings = field(default_factory=RunSettings)
    study: StudySettings = field(default_factory=StudySettings)
    sensitivity: SensitivitySettings = field(default_factory=SensitivitySettings)
    seismic: SeismicSettings = field(default_factory=SeismicSettings)


@dataclass(frozen=True, slots=True)
class Case(CaseFile):
    """A case as read; `file` is where it came from."""

    file: Path = field(default=Path(), compare=False)

    @property
    def block_file(self) -> Path:
        """Path of the block file."""
        return self.file.parent / self.wall.blocks


def read(path: str | PathLike[str], overrides: Sequence[str] = ()) -> Case:
    """Return the case in `path`: a case file, or a block file (.json) with the default of every setting.

    overrides: "section.key=value" each. Raises CaseError.
    """
    path = Path(path)
    try:
        refuse_what_is_not_utf8(str(path), "")
        case = _case(record_in(path, overrides))
        refuse_what_is_no_name(case.name, "name")
    except CaseError as error:
        raise error.in_file(str(path)) from None
    return replace(case, file=path, name=case.name or path.stem)


def read_wall(case: Case) -> Wall:
    """Return the wall of a case, by its name: its block file with the replacements and block classes of [wall].

    A block file that is the case keeps its own name. Raises CaseError.
    """
    refuse_other_kind("case", case, Case, "write read_wall(read_case(path)), or read_blocks(path) of a block file")
    if case.file != case.block_file and not case.block_file.is_file():
        remedy = "give the path of a JSON block file, from the folder of the case file"
        what = "is a folder" if case.block_file.is_dir() else "no such file"
        raise CaseError("wall.blocks", f"{case.block_file}: {what}", remedy, str(case.file))
    wall, replacements = read_blocks(case.block_file), case.wall
    if case.file != case.block_file:
        wall = replace(wall, name=case.name)
    if replacements.unit_weight is not None:
        wall = replace(
            wall, blocks=tuple(replace(block, unit_weight=replacements.unit_weight) for block in wall.blocks)
        )
    replaced = {name: value for name in ("thickness", "friction") if (value := getattr(replacements, name)) is not None}
    with naming(case.file):
        return with_classes(replace(wall, **replaced), replacements.classes)


def refuse_what_only_limit_analysis_takes(case: Case) -> None:
    """Raise CaseError for loads that the FE pushover would silently leave out."""
    with naming(case.file):
        refuse_upright(case.load)


def refuse_ties(case: Case, command: str) -> None:
    """Raise CaseError for ties that `command` would leave out."""
    if case.reinforcement.ties:
        remedy = "use the commands check, limit, segment, run and sensitivity, or leave them out"
        raise CaseError("reinforcement.ties", f"{command} takes no ties yet", remedy, str(case.file))


def refuse_ties_of_run(case: Case) -> None:
    """Raise CaseError for ties without stiffness, or in a wall that is to be verified."""
    with naming(case.file):
        refuse_rigid(case.reinforcement.ties)
        refuse_ties_verified(case.seismic, len(case.reinforcement.ties))


def refuse_seismic(case: Case) -> None:
    """Raise CaseError for a verification that lacks a setting or names what is not there, before anything is run."""
    with naming(case.file):
        states = limit_states(case.seismic)
        for state in states:
            spectrum_of(case.seismic, state, state.peak_ground_acceleration, case.seismic.damping)
        if states:
            refuse_building(case.seismic)
            named_point(case.seismic, read_wall(case))


def refuse_verification(case: Case) -> None:
    """Raise CaseError for a verification that is not made, as `refuse_seismic`, of a wall with ties too."""
    with naming(case.file):
        refuse_ties_verified(case.seismic, len(case.reinforcement.ties))
    refuse_seismic(case)


def as_record(case: Case, block_file: str) -> dict[str, Any]:
    """Return what a case file holds that reads back as `case` with its blocks in `block_file`; all defaults filled
    in."""
    record: dict[str, Any] = checked(CaseFile).dump_python(case, exclude_none=True)
    record["wall"]["blocks"] = block_file
    return record


def as_toml(case: Case, block_file: str) -> str:
    """Return the case file with `as_record`."""
    return tomli_w.dumps(as_record(case, block_file))


def section_types() -> dict[str, type]:
    """Return the settings dataclass of each section of a case file."""
    return {name: kind for name, kind in typing.get_type_hints(CaseFile).items() if name != "name"}


def table_types() -> dict[str, type]:
    """Return the settings dataclass of each list of tables, as in "load.dead", those within tables too."""
    types: dict[str, type] = {}
    waiting = list(section_types().items())
    while waiting:
        name, kind = waiting.pop(0)
        hints = typing.get_type_hints(kind)
        rows = [(f"{name}.{f.name}", row) for f in fields(kind) if (row := row_type(hints[f.name]))]
        types |= dict(rows)
        waiting += rows
    return types


def record_in(path: Path, overrides: Sequence[str]) -> dict[str, Any]:
    """Return what a case holds, unchecked. Raises CaseError."""
    suffix = path.suffix.lower()
    try:
        record: dict[str, Any] = {"wall": {"blocks": path.name}} if suffix == ".json" else _toml_record(path)
    except CaseError:
        if suffix not in IMPORTED or not path.is_file():
            raise
        words = shlex.join(["import", str(path), *NOT_DRAWN.get(suffix, ()), "--output", f"{path.stem}.json"])
        remedy = f"`python -m orchestrator {words}` makes a wall of it"
        raise CaseError("", f"is {IMPORTED[suffix]}", remedy) from None
    for override in overrides:
        _override(record, override)
    return record


def _toml_record(path: Path) -> dict[str, Any]:
    """Return what a case file holds, unchecked. Raises CaseError."""
    try:
        refuse_what_is_no_file(path, LARGEST_FILE, "is this a case file?")
        return tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except FileNotFoundError:
        raise CaseError("", "no such file", "give the path of a case file (.toml) or a block file (.json)") from None
    except (OSError, UnicodeDecodeError) as error:
        raise unreadable(error, "give the path of a case file") from None
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
    """Return the case that a record of a case file describes. Raises CaseError (key only)."""
    if record.get("seismic") == {}:
        problem = "is empty: without a ground acceleration nothing is verified"
        raise CaseError("seismic", problem, 'give peak_ground_acceleration = "0.15 g", or leave the section out')
    stated = settings_from(CaseFile, record)
    case = Case(**{one.name: getattr(stated, one.name) for one in fields(CaseFile)})
    macroblocks = record.get("macroblocks", {})
    if "choose" not in macroblocks and any(name in macroblocks for name in TOLERANCES):
        case = replace(case, macroblocks=replace(case.macroblocks, choose="tolerances"))
    _refuse_contradictions(case)
    return case


def _refuse_contradictions(case: Case) -> None:
    """Raise CaseError (key only) for settings that each may be, but not together: numbers in the wrong order, and
    values given twice."""
    fewest, most = case.limit_analysis.minimum_iterations, case.limit_analysis.maximum_iterations
    if fewest > most:
        problem = f"{fewest} is more than maximum_iterations, {most}"
        raise CaseError("limit_analysis.minimum_iterations", problem, "give at most as many, or raise the maximum")
    given_ranges(case.sensitivity)
    for key, values in (
        ("run.models", case.run.models),
        ("study.tol_n", case.study.tol_n),
        ("study.tol_d", case.study.tol_d),
    ):
        if twice := [value for k, value in enumerate(values) if value in values[:k]]:
            raise CaseError(key, f"has {twice[0]!r} twice", "give every value once")
