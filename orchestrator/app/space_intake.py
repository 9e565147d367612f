"""`import` of walls in space: which reader a file goes to, what it needs, and the block file that is written."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.basis.atomic_files import together
from orchestrator.basis.errors import CaseError, naming
from orchestrator.basis.printed import counted
from orchestrator.basis.units import FACTORS, Unit
from orchestrator.geometry.polyhedra import Polyhedron
from orchestrator.masonry.sources.block_files import LARGEST_FILE, json_in
from orchestrator.present.in_space import space_pictures
from orchestrator.settings.sections import number_or_text, settings_from
from orchestrator.settings.unusual import unusual_material
from orchestrator.space.block_files import UP
from orchestrator.space.contacts import FaceContactSettings, find_joints
from orchestrator.space.sources.compas import is_compas, read_compas
from orchestrator.space.sources.material import SpaceMaterial, with_supports
from orchestrator.space.sources.meshes import SUFFIXES as MESHES
from orchestrator.space.sources.meshes import read_meshes
from orchestrator.space.sources.plans import read_plans
from orchestrator.space.sources.step import SUFFIXES as SOLIDS
from orchestrator.space.sources.step import read_step
from orchestrator.space.wall import SpaceWall, check_wall
from orchestrator.storage.files import write_json

TAKEN = ("unit", "unit_weight", "friction", "supports", "height", "up")


def takes(path: Path, options: Mapping[str, str]) -> bool:
    """Return whether a file is one of blocks in space: by its suffix, a folder of meshes, COMPAS JSON, or a drawing for
    which a course's height is given."""
    suffix = path.suffix.lower()
    if suffix in (*MESHES, *SOLIDS) or path.is_dir() or (suffix == ".dxf" and "height" in options):
        return True
    if suffix != ".json" or not path.is_file():
        return False
    try:
        return is_compas(json_in(path, "", LARGEST_FILE, ""))
    except CaseError:
        return False


def read_file(path: Path, options: Mapping[str, str], say: Callable[[str], None] = lambda _: None) -> SpaceWall:
    """Return the wall in a file, supports included, not yet checked; say what was left out. Raises CaseError."""
    for key in options:
        if key not in TAKEN:
            known = ", ".join(f"--{name.replace('_', '-')}" for name in TAKEN)
            raise CaseError(f"--{key.replace('_', '-')}", "does not go with blocks in space", f"use {known}")
    material = _material(options)
    suffix, unit = path.suffix.lower(), options.get("unit")
    length = _length(unit) if unit else None
    if not path.exists():
        raise CaseError("", "no such file", "give the path of a mesh, a solid, a drawing or a COMPAS file")
    if suffix in SOLIDS:
        wall = read_step(path, length, material)
    elif suffix == ".dxf":
        if "up" in options:
            raise CaseError(
                "--up", "does not go with plans of courses", "leave it out: courses lie on one another along z"
            )
        height = _quantity("height", options["height"]) if "height" in options else None
        wall = read_plans(path, length, height, material, say)
    elif length is None:
        raise CaseError("--unit", "the file has no unit of length", "give it, as in --unit mm")
    else:
        wall = (read_compas if suffix == ".json" else read_meshes)(path, length, material)
    return with_supports(replace(wall, up=_axis(options.get("up", "z"))), _ids(options.get("supports", "")))


def import_wall(path: Path, options: Mapping[str, str], output: Path, picture: Path, console: Console) -> int:
    """Read a file, check it, write a block file and its picture (named without suffix); return the exit code."""
    if output.suffix.lower() != ".json":
        raise CaseError("--output", f"{output} is not a block file", "end its name in .json")
    with naming(path):
        wall = read_file(path, options, lambda text: console.print(f"{path}: {text}", soft_wrap=True))
        check_wall(wall, FaceContactSettings().gap)
        assemblage = find_joints(wall)
    stones = [block for block in wall.blocks if not block.fixed]
    for remark in unusual_material((block.unit_weight for block in stones), [wall.friction]):
        console.print(f"{path}: {remark}", soft_wrap=True)
    with together():
        write_json(output, as_record(wall))
        png = space_pictures.save_wall(assemblage, -np.eye(3)[1], picture.with_name(f"{picture.name}.png"))
    counts = f"{counted(len(wall.blocks), 'block')} in space, {int(wall.fixed.sum())} of them supports"
    joints = counted(assemblage.joints.count, "joint")
    text = f"{output}: {counts}, {joints}; {as_record(wall)['up']} is upwards; {png}"
    console.print(text, soft_wrap=True)
    return 0


def as_record(wall: SpaceWall) -> dict[str, Any]:
    """Return a wall as a block file holds it."""
    axis = "xyz"[int(np.argmax(wall.up))]
    return {
        "name": wall.name,
        "units": {"length": "m", "unit_weight": "N/m3"},
        "up": axis,
        "unit_weight": wall.blocks[0].unit_weight,
        "friction": wall.friction,
        "blocks": [
            {"id": block.id, **_shape(block.shape), "unit_weight": block.unit_weight}
            | ({"fixed": True} if block.fixed else {})
            for block in wall.blocks
        ],
    }


def _shape(body: Polyhedron) -> dict[str, Any]:
    return {"vertices": body.vertices, "faces": [list(face) for face in body.faces]}


def _material(options: Mapping[str, str]) -> SpaceMaterial:
    values = {key: number_or_text(options[key]) for key in ("unit_weight", "friction") if key in options}
    try:
        material: SpaceMaterial = settings_from(SpaceMaterial, values)
    except CaseError as error:
        raise CaseError(f"--{error.key.replace('_', '-')}", error.problem, error.remedy) from None
    return material


def _length(unit: str) -> float:
    known = FACTORS["m"]
    if unit not in known:
        raise CaseError("--unit", f"{unit!r} is no unit of length", f"use one of {', '.join(known)}")
    return known[unit]


def _axis(name: str) -> FloatArray:
    if name not in UP:
        raise CaseError("--up", f"{name!r} is no axis", "write x, y or z, the axis that points upwards")
    return read_only(UP[name])


def _quantity(key: str, text: str) -> float:
    try:
        return Unit("m").parse(text)
    except ValueError as error:
        problem, _, remedy = str(error).partition("; ")
        raise CaseError(f"--{key}", problem, remedy) from None


def _ids(text: str) -> list[int]:
    try:
        return [int(part) for part in text.split(",") if part.strip()]
    except ValueError:
        raise CaseError("--supports", f"{text!r} does not name blocks", "give ids, as in 1,2,3") from None
