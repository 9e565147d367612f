"""Whether a case is one of a wall in its plane or in space, before it is checked.

A case is one in space where its [wall] has a `generator`, its block file has blocks in space, whatever its load, or its
load points out of the plane: a vector, "+y", "-z" and so on, or an angle in plan. Everything else goes the plane's way.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from orchestrator.basis.errors import CaseError
from orchestrator.masonry.sources.block_files import json_in
from orchestrator.settings.case import record_in
from orchestrator.space.block_files import LARGEST_FILE, is_in_space


def spatial(path: Path, overrides: Sequence[str] = ()) -> bool:
    """Return whether a case is one in space; False, too, for what cannot be read: the plane's reader then says why."""
    try:
        record = record_in(path, overrides)
        wall, load = record.get("wall", {}), record.get("load", {})
        if not isinstance(wall, dict) or not isinstance(load, dict):
            return False
        if "generator" in wall or _is_direction(load):
            return True
        file = path.parent / str(wall.get("blocks", ""))
        return file.is_file() and is_in_space(json_in(file, "a block file", LARGEST_FILE, "see docs/space.md"))
    except (CaseError, OSError, ValueError):
        return False


def refuse_space(path: Path, overrides: Sequence[str], command: str) -> None:
    """Raise CaseError for a case in space, which `command` does not take."""
    if spatial(path, overrides):
        problem = f"is a wall in space, which {command} does not take"
        remedy = f"use check or limit; {command} takes plane walls under a load in their plane"
        remedy += ' (upwards and downwards: load.inclination, as in "-90 deg")'
        raise CaseError("", problem, remedy, str(path))


def _is_direction(load: dict[str, Any]) -> bool:
    """Return whether the load is one that only a wall in space can have; a misspelt one stays with the plane."""
    direction = load.get("direction")
    is_vector = isinstance(direction, list) and len(direction) == 3
    return "angle" in load or is_vector or direction in ("+y", "-y", "+z", "-z")
