"""Commands that turn files into files: import, new, schema, export, report. Beside cli.py alone in printing."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from rich.console import Console

from orchestrator import storage
from orchestrator.app import driver, load_case_runs
from orchestrator.app import export as exports
from orchestrator.basis.errors import CaseError
from orchestrator.basis.installed import refuse_missing
from orchestrator.masonry.sources.block_files import refuse_what_is_not_utf8
from orchestrator.settings import case as cases
from orchestrator.settings import reference

LISTED = 20
"""remarks that are printed; all stand in the block file"""
EXIT_CODES = "0 done, 1 failed while running, 2 bad input, 3 finished but not valid, 130 interrupted"
IMPORT_OPTIONS = {
    "thickness": ('"300 mm"', "of the wall; needed for drawings and pictures"),
    "unit-weight": ('"20 kN/m3"', "of every block (default 20 kN/m3)"),
    "friction": ("0.6", "coefficient in every joint (default 0.6)"),
    "tolerance": ('"1 mm"', "largest gap or overlap that is closed (default 1 mm; pictures at least 1.5 pixels)"),
    "mortar": ('"10 mm"', "widest mortar joint drawn as a gap: closed to its middle (pictures: default 20 mm)"),
    "loose": ("drop", "stones that would fall out of dry joints: keep (default), drop, or glue to a neighbour"),
    "ground": ('"200 mm"', "put a support under the wall, reaching this far beyond it"),
    "unit": ("mm", "DXF, SVG: unit of the coordinates, instead of the file's; OBJ, PLY, STL, COMPAS: needed"),
    "height": ('"250 mm"', "DXF of courses in plan: height of a course whose layer does not say it"),
    "blocks": (
        "LAYERS",
        "DXF layers, SVG groups or COCO categories of the blocks, as in stone,timber (default blocks; * and ? stand "
        "for any letters)",
    ),
    "supports": (
        "LAYER",
        "layer, group or category of the supports (default supports); of blocks in space their ids, as in 1,2",
    ),
    "openings": ("LAYER", "layer, group or category of the openings (default openings)"),
    "scale": ('"2 mm"', "picture, COCO: side of a pixel (needed); SVG: length of a user unit, instead of the file's"),
    "stones": (
        "black",
        "picture: black, white or colours, one colour a stone (default auto: black, or colours if plain)",
    ),
    "threshold": ("128", "picture: lightness 1 to 255 from which a pixel is white (default 128)"),
    "split": ("2", "picture: part stones that run together over bridges up to twice this many pixels (default 0: off)"),
    "background": (
        '"#000000"',
        "picture of colours: what is no stone, several with commas, a number in a label image, or none (default: "
        "transparent, else black or white, else 0)",
    ),
    "smallest": ('"20 mm"', "picture, COCO: smaller patches are dirt (default 20 mm square)"),
}


def add_commands(commands: Any) -> None:
    """Add the commands of this module to argparse's sub-parsers."""
    _add_import(commands)
    new = _command(
        commands, "new", _new, "write a commented case file with what most walls change", "new my_wall --output build"
    )
    new.add_argument("name", metavar="NAME", help="name of the case; the file is NAME.toml")
    new.add_argument(
        "--blocks", metavar="FILE", help="block file of the wall (default: a wall of two blocks is written)"
    )
    new.add_argument("--all-keys", action="store_true", help="with every setting, its default and its meaning")
    new.add_argument("--output", type=Path, default=Path(), metavar="FOLDER", help="where to (default: here)")
    _add_force(new)
    schema = _command(
        commands, "schema", _schema, "write the case file's JSON schema", "schema --output build/case.json"
    )
    schema.add_argument("--output", type=Path, metavar="FILE", help="default: standard output")
    _add_force(schema)
    _add_export(commands)
    rebuilding = _command(
        commands,
        "report",
        _report,
        "rebuild pictures and report.html of a finished run, from its stored results alone",
        "report results/benchmark1",
    )
    rebuilding.add_argument("run", type=Path, metavar="RUN", help="run folder")


def _add_force(command: argparse.ArgumentParser) -> None:
    command.add_argument("--force", action="store_true", help="overwrite what exists already")


def _add_export(commands: Any) -> None:
    exporting = _command(
        commands,
        "export",
        _export,
        "write the bodies for another program: mesh (vtu, msh) or deck with contacts and steps (calculix, abaqus)",
        "export templates/benchmark1.toml --format calculix --output build/benchmark1.inp",
    )
    exporting.add_argument("case", type=Path, metavar="RUN_OR_CASE", help="run folder, case file or block file")
    exporting.add_argument("--format", choices=tuple(exports.SUFFIX), default="vtu", help="default: vtu")
    exporting.add_argument("--model", choices=("macro", "micro"), default="macro", help="macroblocks or every stone")
    exporting.add_argument("--multiplier", type=float, help="horizontal load over weight (default: micro-LA's)")
    exporting.add_argument("--output", type=Path, metavar="FILE", help="default: NAME_MODEL.vtu, .msh or .inp")
    _add_force(exporting)
    exporting.add_argument("--set", action="append", default=[], metavar="SECTION.KEY=VALUE", help="override a setting")


def _add_import(commands: Any) -> None:
    reading = _command(
        commands,
        "import",
        _import,
        "read a wall from a drawing (DXF, SVG), row notation, a block file, a picture or annotations (COCO), or blocks "
        "in space from meshes, STEP, COMPAS JSON or plans of courses; write a block file and its picture",
        "import templates/wall1.txt --output build/wall1.json",
    )
    plane, space = (
        ".dxf .svg, .txt .rows, .json, .png .jpg .tif .bmp .gif",
        ".obj .ply .stl .step or a folder of meshes",
    )
    reading.add_argument("file", type=Path, metavar="FILE", help=f"{plane}; in space {space}")
    reading.add_argument("--output", type=Path, default=Path("blocks.json"), help="block file (default: blocks.json)")
    _add_force(reading)
    for name, (value, text) in IMPORT_OPTIONS.items():
        reading.add_argument(f"--{name}", metavar=value, help=text)


def epilog(example: str) -> str:
    """Return the end of a command's help: an example on a line of its own, to be pasted, and the exit codes."""
    return f"example:\n  .venv/bin/python -m orchestrator {example}\n\nexit codes: {EXIT_CODES}"


def _command(commands: Any, name: str, action: Any, summary: str, example: str) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = commands.add_parser(
        name,
        help=summary,
        description=summary,
        epilog=epilog(example),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.set_defaults(action=action)
    return parser


def _import(options: argparse.Namespace, _: None, console: Console) -> int:
    given = {name.replace("-", "_"): getattr(options, name.replace("-", "_")) for name in IMPORT_OPTIONS}
    if options.output.exists() and options.file.exists() and options.output.samefile(options.file):
        raise CaseError("--output", f"{options.output} is the file to import", "give another name")
    if not options.force:
        storage.refuse_overwriting_file(options.output)
    from orchestrator.app import space_intake as in_space

    given_in_space = {name: value for name, value in given.items() if value is not None}
    if in_space.takes(options.file, given_in_space):
        return in_space.import_wall(options.file, given_in_space, options.output, console)
    from orchestrator.app import intake  # drawings and pictures cost 0.1 s that other commands need not wait for

    intake.refuse_output(options.output)
    refused = options.output.with_name(f"{options.output.stem}_refused")
    taken = intake.import_wall(options.file, given, refused)
    wall, remarks = taken.wall, taken.remarks
    written = intake.write_wall(taken, options.output)
    for remark in remarks[:LISTED]:
        console.print(remark, soft_wrap=True, markup=False)
    if len(remarks) > LISTED:
        console.print(f"and {len(remarks) - LISTED} more, all in {options.output}", soft_wrap=True, markup=False)
    free = sum(not block.fixed for block in wall.blocks)
    files = ", ".join(str(path) for path in written)
    console.print(f"{free} blocks, {len(wall.blocks) - free} supports: {files}", soft_wrap=True, markup=False)
    return 0


def _new(options: argparse.Namespace, _: None, console: Console) -> int:
    name = options.name
    refuse_what_is_not_utf8(name, "NAME")
    if not name or Path(name).name != name or not name.isprintable():
        raise CaseError("NAME", f"{name!r} is not a name", "give a name without folder, as in new my_wall")
    blocks, example = options.blocks or f"{name}.json", options.output / f"{name}.json"
    refuse_what_is_not_utf8(blocks, "--blocks")
    case_file = options.output / f"{name}.toml"
    for path in (case_file, *(() if options.blocks else (example,))):
        if not options.force:
            storage.refuse_overwriting_file(path)
    stated = reference.commented_case if options.all_keys else reference.short_case
    storage.write_text(case_file, stated(name, blocks))
    if not options.blocks:
        storage.write_json(example, EXAMPLE | {"name": name})
    console.print(f"{case_file}; next: python -m orchestrator check {case_file}", soft_wrap=True, markup=False)
    return 0


def _export(options: argparse.Namespace, _: None, console: Console) -> int:
    refuse_missing("export", ("gmsh",))
    source = options.case / "case.toml" if options.case.is_dir() else options.case
    case = cases.read(source, options.set)
    load_case_runs.refuse_several(case, "export")
    cases.refuse_ties(case, "export")
    name = options.case.resolve().name if options.case.is_dir() else options.case.stem
    output = options.output or Path(f"{name}_{options.model}{exports.SUFFIX[options.format]}")
    refuse_what_is_not_utf8(str(output), "--output")
    if options.multiplier is not None and not 0 <= options.multiplier < 1e3:
        raise CaseError("--multiplier", f"{options.multiplier:g} is not a multiplier", "give one from 0 on, as in 0.3")
    if not options.force:
        storage.refuse_overwriting_file(output)
    exports.export(case, driver.segment(case), options.model, options.format, options.multiplier, output)
    console.print(str(output), soft_wrap=True, markup=False)
    return 0


def _report(options: argparse.Namespace, _: None, console: Console) -> int:
    rebuild = load_case_runs.rebuild if load_case_runs.are_in(options.run) else driver.rebuild_report
    console.print(str(rebuild(options.run)), soft_wrap=True, markup=False)
    return 0


def _schema(options: argparse.Namespace, _: None, console: Console) -> int:
    if options.output:
        if not options.force:
            storage.refuse_overwriting_file(options.output)
        storage.write_json(options.output, reference.schema())
        console.print(str(options.output), soft_wrap=True, markup=False)
    else:
        print(json.dumps(reference.schema(), indent=1, ensure_ascii=False))
    return 0


EXAMPLE: dict[str, Any] = {
    "units": {"length": "m", "unit_weight": "kN/m3"},
    "thickness": 0.3,
    "unit_weight": 20.0,
    "friction": 0.6,
    "remark": "two blocks on the ground, to be replaced by your own wall",
    "blocks": [
        {"id": 0, "polygon": [[-0.2, -0.2], [1.2, -0.2], [1.2, 0.0], [-0.2, 0.0]], "fixed": True},
        {"id": 1, "polygon": [[0.0, 0.0], [0.5, 0.0], [0.5, 0.3], [0.0, 0.3]]},
        {"id": 2, "polygon": [[0.5, 0.0], [1.0, 0.0], [1.0, 0.3], [0.5, 0.3]]},
    ],
}
