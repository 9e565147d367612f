"""Command line: arguments -> options of one command, which commands.py carries out.

Nothing is imported here that takes time: --help and misspelt options need no more than this module.
"""

from __future__ import annotations

import argparse
from importlib.metadata import version
from pathlib import Path
from typing import Any, NoReturn

PACKAGE = Path(__file__).resolve().parents[1]
SHIPPED = PACKAGE / "shipped" if (PACKAGE / "shipped").exists() else PACKAGE.parent
"""folder of templates/ and meshes/: within a wheel (setup.py), or a clone"""
DEFAULT_CASE = SHIPPED / "templates" / "benchmark1.toml"
"""what `python -m orchestrator` runs without arguments"""
EXPORT_FORMATS = ("vtu", "msh", "calculix", "abaqus")
EXIT_CODES = "0 done, 1 failed while running, 2 bad input, 3 finished but not valid, 130 interrupted"
IMPORT_OPTIONS = {
    "thickness": ('"300 mm"', "of the wall; needed for drawings and pictures"),
    "unit-weight": ('"20 kN/m3"', "of every block (default 20 kN/m3)"),
    "friction": ("0.6", "coefficient in every joint (default 0.6)"),
    "tolerance": (
        '"1 mm"',
        "largest gap or overlap that is closed (default 1 mm; pictures: 1.5 pixels at least; block files: none)",
    ),
    "mortar": ('"10 mm"', "widest mortar joint drawn as a gap: closed to its middle (pictures: default 20 mm)"),
    "loose": ("drop", "stones that would fall out of dry joints: keep (default), drop, or glue to a neighbour"),
    "ground": ('"200 mm"', "put a support under the wall, reaching this far beyond it"),
    "unit": ("mm", "DXF, SVG: unit of the coordinates, instead of the file's; OBJ, PLY, STL, COMPAS: needed"),
    "up": ("y", "OBJ, PLY, STL, STEP, COMPAS: axis that points upwards (default z; Blender writes OBJ with y)"),
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


def main(arguments: list[str] | None = None) -> int:
    """Run one command and return its exit code."""
    options = argument_parser().parse_args(arguments)
    from orchestrator.app.commands import execute

    return execute(options)


class _Completion(argparse.Action):
    """Prints the completion of the command `orchestrator` for a shell."""

    def __call__(self, parser: argparse.ArgumentParser, _: object, values: Any, __: str | None = None) -> None:
        import shtab

        parser.prog = "orchestrator"  # what is completed is a command, not `python -m`
        print(shtab.complete(parser, values))
        parser.exit(0)


class _Version(argparse.Action):
    """Prints version and commit, what two wheels of one version differ by."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from orchestrator.basis.program import commit

        known = commit()
        print(f"orchestrator {version('orchestrator')}" + f", commit {known}" * bool(known))
        parser.exit(0)


class _Parser(argparse.ArgumentParser):
    """Complains in one line."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {message}; --help lists what there is\n")


def argument_parser() -> argparse.ArgumentParser:
    """Return what reads the command line."""
    parser = _Parser(
        prog="python -m orchestrator",
        description="Pushover analysis of masonry, stone by stone. Without a command: run the shipped benchmark 1"
        " into results/benchmark1, unless results are there.",
        epilog=_epilog("run templates/benchmark1.toml --output results/benchmark1"),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    about = "print what completes commands (docs/runs.md)"
    parser.add_argument("--print-completion", choices=("bash", "zsh"), action=_Completion, help=about)
    parser.add_argument("--version", action=_Version, nargs=0, help="print version and commit")
    parser.set_defaults(
        command=None, case=DEFAULT_CASE, output=None, resume=False, force=False, model=None, set=[], quiet=False
    )
    commands = parser.add_subparsers(dest="command", metavar="COMMAND")
    _add_wall_commands(commands)
    _add_file_commands(commands)
    _add_study_commands(commands)
    return parser


def _add_wall_commands(commands: Any) -> None:
    run = _command(
        commands, "run", "the whole chain: micro-LA, macroblocks, FE pushover, pictures", "--set mesh.size=100mm"
    )
    run.add_argument("--output", type=_path, help="run folder (default: results/NAME OF THE CASE FILE)")
    run.add_argument("--resume", action="store_true", help="go on after the last stored increment")
    run.add_argument("--model", choices=("macro", "micro", "both"), help="instead of the case file's [run] models")
    run.add_argument("-q", "--quiet", action="store_true", help="print nothing but errors")
    check = _command(
        commands,
        "check",
        "what a case holds: loads, materials, joints, what is unusual, whether it stands; a picture with block numbers",
        "--output results/look",
    )
    check.add_argument(
        "--output", type=_path, help="run folder for the picture (default: results/NAME OF THE CASE FILE)"
    )
    limit = _command(commands, "limit", "stop after micro limit analysis", "--set wall.friction=0.7")
    limit.add_argument("--output", type=_path, help="folder of the picture (default: results/NAME OF THE CASE FILE)")
    limit.add_argument("--settle", type=int, metavar="ID", help="instead of the live load, let this support give way")
    limit.add_argument("--settle-angle", type=float, help="degrees from +x (default: -90, downwards)")
    limit.add_argument("--json", action="store_true", help="print the limit_analysis part of the summary, nothing else")
    example = "--set macroblocks.tol_d=300mm"
    segment = _command(commands, "segment", "stop after the macroblocks", example)
    segment.add_argument("--output", type=_path, help="folder of the pictures (default: results/NAME OF THE CASE FILE)")
    for command in (run, limit, segment):
        command.add_argument("--force", action="store_true", help="overwrite the results of an earlier run")


def _path(text: str) -> Path:
    """Return the path that an option names; an empty one would be the folder one is in."""
    if not text:
        raise argparse.ArgumentTypeError("is empty; give a name, or . for the folder you are in")
    return Path(text)


def _command(commands: Any, name: str, summary: str, example: str) -> argparse.ArgumentParser:
    """Add a command that takes a case."""
    parser = _file_command(commands, name, summary, f"{name} templates/benchmark1.toml {example}")
    parser.add_argument("case", type=Path, metavar="CASE", help="case file (.toml) or block file (.json)")
    parser.add_argument("--set", action="append", default=[], metavar="SECTION.KEY=VALUE", help="override one setting")
    return parser


def _file_command(commands: Any, name: str, summary: str, example: str) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = commands.add_parser(
        name,
        help=summary,
        description=summary,
        epilog=_epilog(example),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    return parser


def _add_file_commands(commands: Any) -> None:
    _add_import(commands)
    new = _file_command(
        commands, "new", "write a commented case file with what most walls change", "new my_wall --output build"
    )
    new.add_argument("name", metavar="NAME", help="name of the case; the file is NAME.toml")
    new.add_argument(
        "--blocks", metavar="FILE", help="block file of the wall, from here (default: a wall of two blocks is written)"
    )
    new.add_argument("--all-keys", action="store_true", help="with every setting, its default and its meaning")
    new.add_argument("--output", type=_path, default=Path(), metavar="FOLDER", help="where to (default: here)")
    _add_force(new)
    schema = _file_command(commands, "schema", "write the case file's JSON schema", "schema --output build/case.json")
    schema.add_argument("--output", type=_path, metavar="FILE", help="default: standard output")
    _add_force(schema)
    _add_export(commands)
    rebuilding = _file_command(
        commands,
        "report",
        "rebuild pictures and report.html of a finished run, from its stored results alone",
        "report results/benchmark1",
    )
    rebuilding.add_argument("run", type=Path, metavar="RUN", help="run folder")


def _add_force(command: argparse.ArgumentParser) -> None:
    command.add_argument("--force", action="store_true", help="overwrite what exists already")


def _add_export(commands: Any) -> None:
    exporting = _file_command(
        commands,
        "export",
        "write the bodies for another program: mesh (vtu, msh) or deck with contacts and steps (calculix, abaqus)",
        "export templates/benchmark1.toml --format calculix --output build/benchmark1.inp",
    )
    exporting.add_argument("case", type=Path, metavar="RUN_OR_CASE", help="run folder, case file or block file")
    exporting.add_argument("--format", choices=EXPORT_FORMATS, help="default: by the name of the file, vtu without one")
    exporting.add_argument("--model", choices=("macro", "micro"), default="macro", help="macroblocks or every stone")
    exporting.add_argument("--multiplier", type=float, help="horizontal load over weight (default: micro-LA's)")
    exporting.add_argument("--output", type=_path, metavar="FILE", help="default: NAME_MODEL.vtu, .msh or .inp")
    _add_force(exporting)
    exporting.add_argument("--set", action="append", default=[], metavar="SECTION.KEY=VALUE", help="override a setting")


def _add_import(commands: Any) -> None:
    reading = _file_command(
        commands,
        "import",
        "read a wall from a drawing (DXF, SVG), row notation, a block file, a picture or annotations (COCO), or blocks "
        "in space from meshes, STEP, COMPAS JSON or plans of courses; write a block file and its picture",
        "import templates/wall1.txt --output build/wall1.json",
    )
    plane, space = (
        ".dxf .svg, .txt .rows, .json, .png .jpg .tif .bmp .gif",
        ".obj .ply .stl .step or a folder of meshes",
    )
    reading.add_argument("file", type=Path, metavar="FILE", help=f"{plane}; in space {space}")
    reading.add_argument("--output", type=_path, default=Path("blocks.json"), help="block file (default: blocks.json)")
    _add_force(reading)
    for name, (value, text) in IMPORT_OPTIONS.items():
        reading.add_argument(f"--{name}", metavar=value, help=text)
    reading.set_defaults(reading=tuple(name.replace("-", "_") for name in IMPORT_OPTIONS))


def _add_study_commands(commands: Any) -> None:
    table = _command(
        commands,
        "study",
        "pushover of a grid of macroblock tolerances, and of every stone",
        "--output results/table1",
    )
    table.add_argument("--output", type=_path, help="folder (default: results/NAME OF THE CASE FILE-study)")
    vary = _command(
        commands,
        "sensitivity",
        "tornado of the ranges of [sensitivity], and fragility by Latin hypercube",
        "--set sensitivity.friction=[0.5,0.7] --set sensitivity.samples=0",
    )
    vary.add_argument("--output", type=_path, help="folder (default: results/NAME OF THE CASE FILE-sensitivity)")
    for command in (table, vary):
        command.add_argument("--force", action="store_true", help="overwrite the tables and pictures of other settings")


def _epilog(example: str) -> str:
    """Return the end of a command's help: an example on a line of its own, to be pasted, and the exit codes."""
    return f"example:\n  .venv/bin/python -m orchestrator {example}\n\nexit codes: {EXIT_CODES}"
