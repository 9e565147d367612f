"""A wall in any of the files that are read -> a block file and a picture with block numbers to check it by."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, get_type_hints

from orchestrator.basis.arrays import IntArray
from orchestrator.basis.atomic_files import together
from orchestrator.basis.checked import Checked
from orchestrator.basis.errors import CaseError, naming
from orchestrator.basis.printed import as_place, few, millimetres
from orchestrator.basis.units import Unit
from orchestrator.limit_analysis.gravity import falling_blocks, problem_of
from orchestrator.macroblocks.bodies import glued
from orchestrator.masonry.joint_warnings import lost_joints
from orchestrator.masonry.joints import JointSettings, blocks_without_support, check_assemblage, find_joints
from orchestrator.masonry.sources import DRAWINGS, PICTURES, ROWS, VECTORS
from orchestrator.masonry.sources.block_files import read_blocks, refuse_what_is_not_utf8
from orchestrator.masonry.sources.closed_outlines import Layers
from orchestrator.masonry.sources.coco import CocoSettings, holds_annotations, read_coco
from orchestrator.masonry.sources.copies import drawn_once
from orchestrator.masonry.sources.drawing import (
    Drawing,
    HealingSettings,
    Material,
    RefusedWallError,
    closed,
    implausible,
    wall_of,
)
from orchestrator.masonry.sources.dxf import read_dxf
from orchestrator.masonry.sources.holes import said_holes
from orchestrator.masonry.sources.mended_outlines import mended
from orchestrator.masonry.sources.picture import PictureSettings, read_picture
from orchestrator.masonry.sources.rows import read_rows, uneven_courses
from orchestrator.masonry.sources.svg import read_svg
from orchestrator.masonry.wall import LARGEST_TOLERANCE, Wall, check_blocks, check_wall, doubted_size, size_of
from orchestrator.present import plots
from orchestrator.settings.sections import number_or_text, settings_from
from orchestrator.settings.unusual import THICKEST, unusual_material
from orchestrator.storage.files import read_json, write_json
from orchestrator.storage.values import blocks_record

BLOCK_FILES = (".json",)
KNOWN = " ".join(DRAWINGS + VECTORS + ROWS + BLOCK_FILES + PICTURES)
"""endings of the files that are read"""
DOUBTS = re.compile("WARNING|UNUSUAL")
"""words in the remarks that come first"""
MOST_LOOSE = 0.25
"""part of the blocks that may be loose: where more fall, the wall was misread"""
MISREAD = "check the supports, and whether the drawing stands upright"
"""what to do about such a wall"""
LISTED_BLOCKS = 20
"""blocks that a remark names"""
PIXELS_HEALED = 1.5
"""pixels: each of two outlines is off by half a pixel, and a joint of odd width goes by half a pixel to either side"""


@dataclass(frozen=True, slots=True)
class LooseSettings(Checked):
    """What becomes of stones that hang in mortar only, and would fall out of dry joints."""

    loose: Literal["keep", "drop", "glue"] = "keep"
    """keep: they stay, and the wall cannot stand; drop: they are left out; glue: each becomes one with the neighbour
    that it has the longest joint with"""


ABOUT = ("source", "licence", "license", "remark")
"""keys of a block file that stay when it is imported"""


@dataclass(frozen=True, eq=False, slots=True)
class Intake:
    """The wall as read, remarks on how (warnings first), the wall before loose stones were left out or glued, if any
    were, and what a block file says for people (`ABOUT`)."""

    wall: Wall
    remarks: list[str]
    before: Wall | None = None
    about: Mapping[str, str] = field(default_factory=dict)


def import_wall(path: Path, options: Mapping[str, str], picture: Path | None = None) -> Intake:
    """Return the wall in `path`, checked down to its joints, and remarks on how it was read.

    options: text by name (thickness, unit_weight, friction, tolerance, mortar, ground, unit, blocks, supports,
    openings, scale, stones, threshold, split, background, smallest, loose), each as in the settings of masonry/drawing,
    dxf, picture, coco and svg. Raises CaseError; a wall that is refused is drawn into `picture` first, blocks marked.
    """
    refuse_what_is_not_utf8(str(path), "")
    with naming(path):
        if not path.exists():
            raise CaseError("", "no such file", f"give one that ends in {KNOWN}")
        block_file = path.suffix.lower() in BLOCK_FILES and not holds_annotations(path)
        texts = {key: value for key, value in options.items() if value}
        loose = _settings(LooseSettings, texts)
        try:
            wall, remarks = _read(path, texts)
            remarks = [*_thick(wall), *_of_other_material(wall), *remarks]
            if path.suffix.lower() not in ROWS:  # there every hole is an opening with its width
                remarks += said_holes(wall)
        except RefusedWallError as error:
            said = CaseError(error.key, error.problem, _likely_cause(error.remarks) + error.remedy)
            raise _drawn(said, error.wall, picture) from None
        try:
            kept, before, more = _without_loose(wall, loose.loose)
            assemblage = find_joints(kept, JointSettings())
            check_assemblage(assemblage)
        except CaseError as error:
            said = CaseError(error.key, error.problem, doubted_size(wall) or _likely_cause(remarks) + error.remedy)
            raise _drawn(said, wall, picture) from None
    if block_file and not (options.get("tolerance") or options.get("mortar")):  # what was healed has its own remarks
        remarks += lost_joints(assemblage, JointSettings())
    about = _about(path) if block_file else {}
    return Intake(kept, sorted([*more, *remarks], key=lambda remark: not DOUBTS.search(remark)), before, about)


def _likely_cause(remarks: Sequence[str]) -> str:
    """Return the warnings of reading a drawing, as what a remedy begins with; nothing where there are none."""
    warned = few([remark.replace("WARNING: ", "") for remark in remarks if "WARNING" in remark], "; ")
    return f"reading it warned of a likely cause: {warned}; else " if warned else ""


def _about(block_file: Path) -> dict[str, str]:
    """Return what a block file says for people."""
    record = read_json(block_file)
    return {key: str(record[key]) for key in ABOUT if key in record}


def _thick(wall: Wall) -> list[str]:
    """Return a warning of a wall whose thickness is more than usual beside its length and height, or none."""
    thickness, size = wall.thickness, size_of(wall)
    said = f"WARNING: the wall is {thickness:.4g} m thick, and measures {size:.4g} m: is the unit right?"
    return [said] if thickness > THICKEST * size else []


def _of_other_material(wall: Wall) -> list[str]:
    """Return what is unusual about the unit weight and the friction of the stones of a wall."""
    stones = [block for block in wall.blocks if not block.fixed]
    frictions = (wall.friction if block.friction is None else block.friction for block in stones)
    return unusual_material((block.unit_weight for block in stones), frictions)


def _drawn(error: CaseError, wall: Wall, picture: Path | None) -> CaseError:
    """Draw a wall that is refused, the blocks that are complained about marked; return the error that says where."""
    if picture is None:
        return error
    marked = [int(number) for number in re.findall(r"\d+", error.key.partition(" at ")[0])]
    written = plots.save(plots.blocks(wall, numbered=True, marked=marked), picture.parent, picture.name)[0]
    return CaseError(error.key, error.problem, f"{error.remedy}; see {written}", error.file)


def _without_loose(wall: Wall, how: str) -> tuple[Wall, Wall | None, list[str]]:
    """Return the wall without the stones that fall out of its dry joints, left out or glued; the wall before, if any
    did; and what was done.

    Stones may hold others, so it is asked again until nothing falls.
    """
    before, dropped, stuck = wall, list[int](), list[int]()
    while True:
        assemblage = find_joints(wall, JointSettings())
        apart = blocks_without_support(assemblage)
        falling = apart if len(apart) else falling_blocks(problem_of(assemblage))[1]
        if not len(falling):
            break
        ids = [wall.blocks[k].id for k in falling]
        if how == "keep":
            return wall, None, [] if len(apart) else [_hanging(wall, falling)]
        if len({*dropped, *stuck, *ids}) > MOST_LOOSE * len(wall.blocks) or {*ids} <= {*stuck}:
            problem = f"{len({*dropped, *stuck, *ids})} blocks of {len(before.blocks)} fall: not single loose stones"
            instead = ", or try --loose drop" if stuck else ""
            raise CaseError("--loose", problem, f"{MISREAD}; else friction and --tolerance{instead}")
        if how == "drop" or len(apart):
            dropped += ids
            wall = _left_out(wall, falling)
        else:
            stuck += ids
            wall = glued(assemblage, falling)
    check_wall(wall)
    said = [f"{_stones(dropped)} that hung in mortar left out: {_listed(dropped)}"] if dropped else []
    if stuck:
        lost = sorted({block.material for block in before.blocks if block.id in stuck and block.material})
        of_what = f", of {', '.join(lost)}: now of the neighbour's material" if lost else ""
        said.append(f"{_stones(stuck)} that hung in mortar glued to a neighbour: {_listed(stuck)}{of_what}")
    return wall, before if said else None, said


def _hanging(wall: Wall, falling: IntArray) -> str:
    ids = [wall.blocks[k].id for k in falling]
    x, y = wall.blocks[falling[0]].polygon.mean(axis=0)
    remedy = "--loose drop leaves them out, --loose glue unites them with a neighbour"
    remedy = MISREAD if len(ids) > MOST_LOOSE * len(wall.blocks) else remedy
    return (
        f"WARNING: {_stones(ids)} would fall out of dry joints, block {ids[0]} at {as_place(x, y)} m first: "
        f"{_listed(ids)}; {remedy}"
    )


def _stones(ids: list[int]) -> str:
    return f"{len(ids)} stone{'s' * (len(ids) != 1)}"


def _listed(ids: list[int]) -> str:
    return ", ".join(map(str, ids[:LISTED_BLOCKS])) + (" ..." if len(ids) > LISTED_BLOCKS else "")


def _left_out(wall: Wall, positions: IntArray) -> Wall:
    out = {*positions.tolist()}
    kept = tuple(block for k, block in enumerate(wall.blocks) if k not in out)
    ids = {block.id for block in kept}
    return replace(wall, blocks=kept, mortar=tuple(m for m in wall.mortar if {m.i, m.j} <= ids))


def write_wall(taken: Intake, output: Path, picture: Path | None = None) -> None:
    """Write the block file `output` (.json), and pictures with block numbers, loose stones left out or glued in red:
    `picture`, without its suffix, or none."""
    refuse_output(output)
    wall, remarks = taken.wall, taken.remarks
    kept = {block.id for block in wall.blocks}
    loose = [block.polygon for block in taken.before.blocks if block.id not in kept] if taken.before else []
    with together():
        said = "; ".join(filter(None, (taken.about.get("remark"), *remarks)))
        write_json(output, blocks_record(wall) | dict(taken.about) | ({"remark": said} if said else {}))
        if picture is not None:
            plots.save(plots.blocks(wall, numbered=True, loose=loose), picture.parent, picture.name)


def refuse_output(output: Path) -> None:
    """Raise CaseError for an output that is not named like a block file."""
    if output.suffix.lower() != ".json":
        raise CaseError("--output", f"{output} is not a block file", "end its name in .json")
    refuse_what_is_not_utf8(str(output), "--output")


def _read(path: Path, options: dict[str, str]) -> tuple[Wall, list[str]]:
    suffix = path.suffix.lower()
    if suffix in ROWS:
        _refuse(options, f"states everything itself: change it in {path.name}")
        wall = read_rows(path)
        check_blocks(wall, 0.0)
        return wall, [*uneven_courses(wall), *implausible(wall)]
    if suffix in BLOCK_FILES and not holds_annotations(path):
        healing = _settings(HealingSettings, options) if {"tolerance", "mortar"} & options.keys() else None
        _refuse(options, f"states everything itself: change it in {path.name}")
        wall, said = read_blocks(path), list[str]()
        if healing:
            outlines, said = mended([block.polygon for block in wall.blocks], healing.tolerance)
            blocks = (replace(block, polygon=outline) for block, outline in zip(wall.blocks, outlines, strict=True))
            wall, twice = drawn_once(replace(wall, blocks=tuple(blocks)), healing.tolerance)
            said = [*said, *twice]
        check_blocks(wall, 0.0)
        wall, more = closed(wall, healing) if healing else (wall, [])
        return wall, [*wall.remarks, *said, *more, *implausible(wall)]
    if suffix not in DRAWINGS + VECTORS + PICTURES + BLOCK_FILES:
        raise CaseError("", f"files ending in {suffix!r} are not read", f"give one that ends in {KNOWN}")
    material = _settings(Material, options, thickness='--thickness "300 mm"')
    if suffix in DRAWINGS + VECTORS:
        healing, layers = _settings(HealingSettings, options), _settings(Layers, options)
        drawing = _dxf(path, options, layers, healing) if suffix in DRAWINGS else _svg(path, options, layers, healing)
        return wall_of(drawing, path.stem, material, healing)
    pixels = '--scale "2 mm"'
    if suffix in BLOCK_FILES:
        coco = _settings(CocoSettings, options, scale=f"the side of a pixel, {pixels}")
        drawing, scale = read_coco(path, _settings(Layers, options), coco), coco.scale
    else:
        settings = _settings(PictureSettings, options, scale=f"the side of a pixel, {pixels}")
        drawing, scale = read_picture(path, settings), settings.scale
    healing = _settings(HealingSettings, options)
    _refuse(options, "does not go with a picture")
    if PIXELS_HEALED * scale > LARGEST_TOLERANCE:
        coarse = f"a pixel of {millimetres(scale)} is too coarse for joints"
        raise CaseError("--scale", coarse, f'give at most "{1e3 * LARGEST_TOLERANCE / PIXELS_HEALED:.0f} mm"')
    healing = replace(healing, tolerance=max(healing.tolerance, PIXELS_HEALED * scale))
    return wall_of(drawing, path.stem, material, healing)


def _dxf(path: Path, options: dict[str, str], layers: Layers, healing: HealingSettings) -> Drawing:
    unit = options.pop("unit", "")
    _refuse(options, "does not go with a drawing")
    return read_dxf(path, layers, healing.tolerance, unit)


def _svg(path: Path, options: dict[str, str], layers: Layers, healing: HealingSettings) -> Drawing:
    scale = options.pop("scale", options.pop("unit", ""))
    _refuse(options, "does not go with a drawing")
    try:
        factor = Unit("m").parse(scale if scale[:1].isdigit() else f"1 {scale}") if scale else None
    except ValueError as error:
        problem, _, remedy = str(error).partition("; ")
        raise CaseError("--scale", problem, remedy) from None
    return read_svg(path, layers, healing.tolerance, factor)


def _settings(kind: type[Any], options: dict[str, str], **needed: str) -> Any:
    """Return settings of `kind`, taking their keys out of `options`; `needed` says how to give what has no default."""
    texts = {key: options.pop(key) for key in kind.__dataclass_fields__ if key in options}
    for key, example in needed.items():
        if key not in texts:
            raise CaseError(f"--{key}", "is missing, the file does not say it", f"give it, as in {example}")
    try:
        hints = get_type_hints(kind)
        return settings_from(kind, {k: text if hints[k] is str else number_or_text(text) for k, text in texts.items()})
    except CaseError as error:
        raise CaseError(f"--{error.key.replace('_', '-')}", error.problem, error.remedy) from None


def _refuse(options: dict[str, str], reason: str) -> None:
    for key in options:
        raise CaseError(f"--{key.replace('_', '-')}", reason, "leave it out")
