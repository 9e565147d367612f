"""Case file of a wall in space -> SpaceCase. Same form as a plane wall's, with sections of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from orchestrator.basis.checked import Checked
from orchestrator.basis.errors import CaseError, naming
from orchestrator.masonry.sources.block_files import refuse_what_is_no_name, refuse_what_is_not_utf8
from orchestrator.masonry.wall import Friction, UnitWeight
from orchestrator.settings.case import record_in
from orchestrator.settings.project import ProjectSettings
from orchestrator.settings.sections import settings_from
from orchestrator.space.analysis import SpaceLimitSettings
from orchestrator.space.block_files import read_wall
from orchestrator.space.contacts import FaceContactSettings
from orchestrator.space.floors import FloorSettings, with_floors
from orchestrator.space.generators import GENERATORS, build
from orchestrator.space.loads import SpaceLoadSettings
from orchestrator.space.ties import TieSettings
from orchestrator.space.wall import SpaceWall, check_wall

SECTIONS = {
    "project": ProjectSettings,
    "load": SpaceLoadSettings,
    "contact": FaceContactSettings,
    "reinforcement": TieSettings,
    "limit_analysis": SpaceLimitSettings,
}
LOOSER = ", or give contact.gap what the drawing is off"
"""what helps, too, where bodies are no bodies or go into each other"""
STRENGTHS = ("cohesion", "tensile_strength", "compressive_strength")
"""of joints, which only plane walls have"""


@dataclass(frozen=True, slots=True)
class Replaced(Checked):
    """What a case file may change in its block file."""

    friction: Friction | None = None
    """coefficient of friction of every joint"""
    unit_weight: UnitWeight | None = None
    """of every block"""


@dataclass(frozen=True, eq=False, slots=True)
class SpaceCase:
    """A case in space as read; `file` is where it came from."""

    name: str
    wall: SpaceWall
    file: Path
    project: ProjectSettings = field(default_factory=ProjectSettings)
    load: SpaceLoadSettings = field(default_factory=SpaceLoadSettings)
    contact: FaceContactSettings = field(default_factory=FaceContactSettings)
    reinforcement: TieSettings = field(default_factory=TieSettings)
    limit_analysis: SpaceLimitSettings = field(default_factory=SpaceLimitSettings)


def read(path: Path, overrides: Sequence[str] = ()) -> SpaceCase:
    """Return the case in `path`, its wall made or read, and checked. Raises CaseError."""
    try:
        refuse_what_is_not_utf8(str(path), "")
        record = record_in(path, overrides)
        refuse_what_is_no_name(record.get("name", ""), "name")
        _refuse_what_only_plane_walls_take(record)
        sections = {name: settings_from(kind, record.get(name, {}), name) for name, kind in SECTIONS.items()}
        wall = _wall(record.get("wall"), path, sections["contact"].gap)
    except CaseError as error:
        raise error.in_file(str(path)) from None
    name = record.get("name") or wall.name or path.stem
    return SpaceCase(name, replace(wall, name=name), path, **sections)


def _refuse_what_only_plane_walls_take(record: dict[str, Any]) -> None:
    known = ("name", "wall", *SECTIONS)
    for key, values in record.items():
        if key not in known:
            lacking = "joints have friction only, no strengths" if key == "joints" else "there is limit analysis only"
            raise CaseError(key, f"is not a section of a wall in space: {lacking}", f"use {', '.join(known)}")
        for strength in STRENGTHS:
            if isinstance(values, dict) and strength in values:
                problem = "is not for walls in space: their joints have friction only, no strengths"
                raise CaseError(f"{key}.{strength}", problem, "leave it out, or load the wall in its plane")


def _wall(values: Any, path: Path, gap: float) -> SpaceWall:
    """Return the wall, checked to `gap`, of a generator or of a block file with its replacements."""
    if not isinstance(values, dict) or ("generator" in values) == ("blocks" in values):
        raise CaseError("wall", "needs a generator or a block file", 'write generator = "u" or blocks = "FILE.json"')
    keys = dict(values)
    floors: FloorSettings = settings_from(FloorSettings, _part(keys, FloorSettings), "wall")
    keys.pop("floors", None)
    wall = _without_floors(keys, path)
    if "blocks" in values:
        with naming(path.parent / str(values["blocks"])):
            check_wall(wall, gap, LOOSER)
    if floors.floors or "generator" in values:
        wall = with_floors(wall, floors.floors)
        check_wall(wall, gap, LOOSER)
    return wall


def _without_floors(keys: dict[str, Any], path: Path) -> SpaceWall:
    if "generator" in keys:
        kind = keys.pop("generator")
        if kind not in GENERATORS:
            raise CaseError("wall.generator", f"{kind!r} is none", f"use {', '.join(GENERATORS)}")
        kinds = GENERATORS[kind].settings
        known = [name for one in kinds for name in one.__dataclass_fields__]
        for key in keys:
            if key not in known:
                raise CaseError(f"wall.{key}", f"is not a key of the generator {kind!r}", f"use {', '.join(known)}")
        return build(kind, [settings_from(one, _part(keys, one), "wall") for one in kinds])
    wall = read_wall(path.parent / str(keys.pop("blocks")))
    changed: Replaced = settings_from(Replaced, keys, "wall")
    if changed.unit_weight is not None:
        wall = replace(wall, blocks=tuple(replace(b, unit_weight=changed.unit_weight) for b in wall.blocks))
    if changed.friction is not None:
        blocks = tuple(replace(block, friction=None) for block in wall.blocks)
        wall = replace(wall, blocks=blocks, friction=changed.friction)
    return wall


def _part(values: dict[str, Any], kind: Any) -> dict[str, Any]:
    return {name: value for name, value in values.items() if name in kind.__dataclass_fields__}
