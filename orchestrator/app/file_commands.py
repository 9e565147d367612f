"""Commands that turn files into files: import, new, schema, export, report. They print.

What only one of them needs is imported in it.
"""

from __future__ import annotations

import argparse
import json
import os
import shlex
from pathlib import Path
from typing import Any

from rich.console import Console

from orchestrator import storage
from orchestrator.app.terminal import shown
from orchestrator.basis.atomic_files import locked, together
from orchestrator.basis.errors import CaseError
from orchestrator.basis.installed import refuse_missing
from orchestrator.masonry.sources.block_files import refuse_what_is_not_utf8

LISTED_REMARKS = 20
"""remarks that are printed; all stand in the block file"""


def import_wall(options: argparse.Namespace, console: Console) -> int:
    """Turn a drawing, a picture or a list of blocks into a block file; return the exit code."""
    texts = {name: getattr(options, name) for name in options.reading}
    refused, picture = (options.output.with_name(f"{options.output.stem}_{name}") for name in ("refused", "imported"))
    written = (options.output, *_drawn(picture))
    storage.refuse_input((*written, *_drawn(refused)), [options.file])
    for path in written:
        storage.try_file(path, options.force)
    from orchestrator.app import space_intake as in_space

    given_in_space = {name: value for name, value in texts.items() if value is not None}
    if in_space.takes(options.file, given_in_space):
        return in_space.import_wall(options.file, given_in_space, options.output, picture, console)
    import numpy as np

    from orchestrator.app import intake

    intake.refuse_output(options.output)
    with shown(console, "import", "outlines, gaps and overlaps, joints"):
        taken = intake.import_wall(options.file, texts, refused)
    wall, remarks = taken.wall, taken.remarks
    with shown(console, "import", "block file and pictures"):
        intake.write_wall(taken, options.output, picture)
    for remark in remarks[:LISTED_REMARKS]:
        console.print(remark, soft_wrap=True)
    if len(remarks) > LISTED_REMARKS:
        console.print(f"and {len(remarks) - LISTED_REMARKS} more, all in {options.output}", soft_wrap=True)
    free = sum(not block.fixed for block in wall.blocks)
    files = ", ".join(str(path) for path in written)
    supports = len(wall.blocks) - free
    counted = f"{free} block{'s' * (free != 1)}, {supports} support{'s' * (supports != 1)}"
    width, height = np.ptp(np.vstack([block.polygon for block in wall.blocks if not block.fixed]), axis=0)
    size = f"{width:.4g} x {height:.4g} m, {wall.thickness:.4g} m thick"
    console.print(f"{counted}, {size}: {files}", soft_wrap=True)
    return 0


def _drawn(picture: Path) -> list[Path]:
    """Return the files that a picture of this name is written to."""
    return [picture.with_name(f"{picture.name}{suffix}") for suffix in (".png", ".svg")]


def new(options: argparse.Namespace, console: Console) -> int:
    """Write a commented case file; return the exit code."""
    from orchestrator.settings import reference

    name = options.name.removesuffix(".toml")
    refuse_what_is_not_utf8(name, "NAME")
    if not name or Path(name).name != name or not name.isprintable():
        raise CaseError("NAME", f"{name!r} is not a name", "give a name without folder, as in new my_wall")
    example = options.output / f"{name}.json"
    refuse_what_is_not_utf8(options.blocks or "", "--blocks")
    blocks = _from_folder(options.output, options.blocks) if options.blocks else example.name
    case_file = options.output / f"{name}.toml"
    for path in (case_file, *(() if options.blocks else (example,))):
        storage.try_file(path, options.force)
    stated = reference.commented_case if options.all_keys else reference.short_case
    with together():
        storage.write_text(case_file, stated(name, blocks))
        if not options.blocks:
            storage.write_json(example, EXAMPLE | {"name": name})
    if options.blocks and not Path(options.blocks).is_file():
        console.print(f"--blocks: {options.blocks} is not there yet: `check` reads it", soft_wrap=True)
    next_one = shlex.join(["python", "-m", "orchestrator", "check", str(case_file)])
    console.print(f"{case_file}; next: {next_one}", soft_wrap=True)
    return 0


def _from_folder(folder: Path, file: str) -> str:
    """Return the path of a file as a case in a folder has it, which is from there; an absolute one stays."""
    return file if os.path.isabs(file) else os.path.relpath(file, os.path.realpath(folder))


def export(options: argparse.Namespace, console: Console) -> int:
    """Write the bodies of a case for another program; return the exit code."""
    from orchestrator.settings import case as cases
    from orchestrator.settings.plane_or_space import refuse_space

    refuse_missing("export", ("gmsh",))
    source = options.case / "case.toml" if options.case.is_dir() else options.case
    refuse_space(source, options.set, "export")
    case = cases.read(source, options.set)
    from orchestrator.app import driver, load_cases
    from orchestrator.app import export as exports

    load_cases.refuse_several(case, "export")
    cases.refuse_ties(case, "export")
    name = options.case.resolve().name if options.case.is_dir() else options.case.stem
    kind = options.format or exports.kind_of(options.output)
    output = options.output or Path(f"{name}_{options.model}{exports.SUFFIX[kind]}")
    refuse_what_is_not_utf8(str(output), "--output")
    if options.multiplier is not None:
        if kind not in exports.DECKS:
            problem = f"is of the steps of a deck, and a mesh ({kind}) has none"
            raise CaseError("--multiplier", problem, f"leave it out, or give --format {' or '.join(exports.DECKS)}")
        if not 0 <= options.multiplier < 1e3:
            problem = f"{options.multiplier:g} is not a multiplier"
            raise CaseError("--multiplier", problem, "give one from 0 on, as in 0.3")
    storage.refuse_input([output], (case.file, case.block_file))
    storage.try_file(output, options.force)
    with shown(console, "export", "limit analysis, meshes and file"):
        exports.export(case, driver.segment(case), options.model, kind, options.multiplier, output)
    console.print(str(output), soft_wrap=True)
    return 0


def report(options: argparse.Namespace, console: Console) -> int:
    """Draw a finished run again; return the exit code."""
    from orchestrator.app import driver, load_case_runs

    rebuild = load_case_runs.rebuild if load_case_runs.are_in(options.run) else driver.rebuild_report
    if options.run.is_dir():
        storage.try_folder(options.run, "", "give a copy of it elsewhere")
    with locked(*[options.run][: options.run.is_dir()]), shown(console, "report", "pictures and pages"):
        page = rebuild(options.run)
    console.print(str(page), soft_wrap=True)
    return 0


def schema(options: argparse.Namespace, console: Console) -> int:
    """Write the JSON schema of the case file; return the exit code."""
    from orchestrator.settings import reference

    if options.output:
        storage.try_file(options.output, options.force)
        storage.write_json(options.output, reference.schema())
        console.print(str(options.output), soft_wrap=True)
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

ACTIONS = {"import": import_wall, "new": new, "schema": schema, "export": export, "report": report}
