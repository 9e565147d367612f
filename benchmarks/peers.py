"""Other programs on the same walls, one after the other in one run: CPU seconds of each.

    python benchmarks/peers.py                              CalculiX (Debian's calculix-ccx), as `make bench` does
    python benchmarks/peers.py build/lmgc90/bin/python      LMGC90, too (see lmgc90_plane.py)

CalculiX takes the deck that `export` writes for wall 1 of Ferris and Tin-Loi, every stone a body, on our mesh and in
small displacements: its weight, then a load of SHARE of that. Ours ends with the first increment that carries as much.
LMGC90 takes the stones of wall 6 as rigid prisms, whose load grows until their centre of mass has moved by half of what
the top of ours does to the end of its curve. Writes peers.csv beside this file.
"""

from __future__ import annotations

import csv
import resource
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

from lmgc90 import simulated
from lmgc90_plane import REST, as_prisms
from mpi4py import MPI

from orchestrator import (
    ContactSettings,
    ElasticSettings,
    JointSettings,
    MeshSettings,
    NewtonSettings,
    SteppingSettings,
    find_joints,
    make_bodies,
    one_body_per_block,
)
from orchestrator.app.cli import main as command
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.pushover.meshing import mesh_bodies
from orchestrator.pushover.model import build_model
from orchestrator.pushover.path.stepping import Pushover
from orchestrator.pushover.solve.linear_system import LinearSystem

WALL_1 = HERE.parent / "tests" / "data" / "ferris_tinloi_wall1.json"
WALL_6 = HERE.parent / "meshes" / "ferris_tinloi_wall6.json"
SHARE = 0.6
"""load of wall 1 over its weight; it bears 0.64"""
FARTHEST = 0.02
"""displacement of the top of wall 6 at the end, m"""
MULTIPLIER, SECONDS = 0.38, 1.5
"""LMGC90's load of wall 6 grows to this, 1.1 times what it bears with dilatancy, in so many s"""


def seconds_of(work: Callable[[], Any], whose: int) -> float:
    """Return the CPU seconds that work takes: of this process, or of those that it starts."""
    before = resource.getrusage(whose)
    work()
    after = resource.getrusage(whose)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def ours(file: Path, large: bool, share: float = np.inf) -> float:
    """Push every stone until the top has moved by FARTHEST, or a share of the weight is carried; return CPU seconds.

    Meshing is left out: CalculiX is given the mesh.
    """
    assemblage = find_joints(read_blocks(file), JointSettings())
    bodies = make_bodies(assemblage, one_body_per_block(assemblage))
    meshes = mesh_bodies(bodies, MeshSettings(), None)

    def push() -> None:
        model = build_model(bodies, meshes, ElasticSettings(), ContactSettings(), large)
        stepping = SteppingSettings(final_displacement=FARTHEST, large_displacement=large)
        with LinearSystem(model, MPI.COMM_SELF) as system:
            for here in Pushover(model, system, NewtonSettings(), stepping).increments():
                if here.base_shear >= share * model.weight:
                    break

    return seconds_of(push, resource.RUSAGE_SELF)


def calculix(folder: Path) -> None:
    """Run CalculiX on the deck in a folder."""
    done = subprocess.run(["ccx", "deck"], cwd=folder, capture_output=True, text=True, check=True)
    if "Job finished" not in done.stdout:
        raise SystemExit(done.stdout[-500:])


def lmgc90(python: str) -> None:
    """Push wall 6 in LMGC90."""
    wall = as_prisms(read_blocks(WALL_6))
    simulated(python, "wall_6", wall, (1.0, 0.0, 0.0), MULTIPLIER, SECONDS, REST, 0.5 * FARTHEST)


def compared(python: str | None) -> list[dict[str, Any]]:
    """Return a row for each program and wall: CPU seconds, and how many times those of ours."""
    started = resource.RUSAGE_CHILDREN
    with TemporaryDirectory() as name:
        deck = str(Path(name) / "deck.inp")
        arguments = ["--model", "micro", "--format", "calculix", "--multiplier", str(SHARE), "--output", deck]
        if command(["export", str(WALL_1), *arguments]):
            raise SystemExit(f"no deck of {WALL_1}")
        theirs = seconds_of(lambda: calculix(Path(name)), started)
    of_ours = ours(WALL_1, False, SHARE)
    rows = [{"wall": f"wall 1, to {SHARE:g} of its weight", "program": "CalculiX", "seconds": theirs, "ours": of_ours}]
    if python:
        theirs, of_ours = seconds_of(lambda: lmgc90(python), started), ours(WALL_6, large=True)
        rows += [{"wall": "wall 6, to 20 mm", "program": "LMGC90", "seconds": theirs, "ours": of_ours}]
    return [row | {"times": row["seconds"] / row["ours"]} for row in rows]


if __name__ == "__main__":
    rows = compared(sys.argv[1] if len(sys.argv) > 1 else None)
    with (HERE / "peers.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows({name: f"{v:.3g}" if isinstance(v, float) else v for name, v in row.items()} for row in rows)
    for row in rows:
        print(row)
