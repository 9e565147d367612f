"""A wall in any of the files that are read -> a block file and a picture with block numbers to check it by."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from orchestrator import plots
from orchestrator.errors import CaseError
from orchestrator.joints import JointSettings, check_assemblage, find_joints
from orchestrator.masonry.drawing import HealingSettings, Material, implausible, wall_of
from orchestrator.masonry.dxf import Layers, read_dxf
from orchestrator.masonry.picture import PictureSettings, read_picture
from orchestrator.masonry.readers import read_blocks, refuse_what_is_not_utf8
from orchestrator.masonry.rows import read_rows
from orchestrator.masonry.wall import Wall, check_wall
from orchestrator.results.files import write_json
from orchestrator.results.values import blocks_record
from orchestrator.sections import settings_from

DRAWINGS, ROWS, BLOCK_FILES = (".dxf",), (".txt", ".rows"), (".json",)
PICTURES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".gif")
PIXELS_HEALED = 1.5
"""pixels: each of two outlines is off by half a pixel, and a joint of odd width goes by half a pixel to either side"""


def import_wall(path: Path, options: Mapping[str, str]) -> tuple[Wall, list[str]]:
    """Return the wall in `path`, checked down to its joints, and remarks on how it was read.

    options: text by name (thickness, unit_weight, friction, tolerance, ground, unit, blocks, supports, openings, scale,
    mortar, stones, smallest), each as in the settings of masonry/drawing, dxf and picture. Raises CaseError.
    """
    refuse_what_is_not_utf8(str(path), "")
    try:
        wall, remarks = _read(path, {key: value for key, value in options.items() if value})
        check_wall(wall)
        check_assemblage(find_joints(wall, JointSettings()))
    except CaseError as error:
        raise error.in_file(str(path)) from None
    return wall, remarks


def write_wall(wall: Wall, remarks: list[str], output: Path) -> list[Path]:
    """Write the block file `output` (.json) and beside it pictures with block numbers; return what was written."""
    if output.suffix.lower() != ".json":
        raise CaseError("--output", f"{output} is not a block file", "end its name in .json")
    refuse_what_is_not_utf8(str(output), "--output")
    write_json(output, blocks_record(wall) | ({"remark": "; ".join(remarks)} if remarks else {}))
    return [output, *plots.save(plots.blocks(wall, numbered=True), output.parent, output.stem)]


def _read(path: Path, options: dict[str, str]) -> tuple[Wall, list[str]]:
    suffix = path.suffix.lower()
    if suffix in BLOCK_FILES + ROWS:
        _refuse(options, f"states everything itself: change it in {path.name}")
        wall = (read_blocks if suffix in BLOCK_FILES else read_rows)(path)
        return wall, implausible(wall)
    if suffix not in DRAWINGS + PICTURES:
        known = " ".join(DRAWINGS + ROWS + BLOCK_FILES + PICTURES)
        raise CaseError("", f"files ending in {suffix!r} are not read", f"give one of {known}")
    material = _settings(Material, options, thickness='--thickness "300 mm"')
    healing = _settings(HealingSettings, options)
    if suffix in DRAWINGS:
        layers = _settings(Layers, options)
        unit = options.pop("unit", "")
        _refuse(options, "does not go with a drawing")
        return wall_of(read_dxf(path, layers, healing.tolerance, unit), path.stem, material, healing)
    picture = _settings(PictureSettings, options, scale='the side of a pixel, --scale "2 mm"')
    _refuse(options, "does not go with a picture")
    healing = replace(healing, tolerance=max(healing.tolerance, PIXELS_HEALED * picture.scale))
    return wall_of(read_picture(path, picture), path.stem, material, healing)


def _settings(kind: type[Any], options: dict[str, str], **needed: str) -> Any:
    """Return settings of `kind`, taking their keys out of `options`; `needed` says how to give what has no default."""
    given = {key: options.pop(key) for key in kind.__dataclass_fields__ if key in options}
    for key, example in needed.items():
        if key not in given:
            raise CaseError(f"--{key}", "is missing, the file does not say it", f"give it, as in {example}")
    try:
        return settings_from(kind, {key: _number_or_text(value) for key, value in given.items()})
    except CaseError as error:
        raise CaseError(f"--{error.key.replace('_', '-')}", error.problem, error.remedy) from None


def _number_or_text(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


def _refuse(options: dict[str, str], reason: str) -> None:
    for key in options:
        raise CaseError(f"--{key.replace('_', '-')}", reason, "leave it out")
