"""Walls of all families, pushed stone by stone both ways: what other studies are made on.

A quarter of the pushovers are of irregular courses, half of rubble and arched walls that were drawn with errors and
imported (any_wall.py), a quarter of larger rubble. The end of a curve is a base shear 20 % below the peak, a top
displacement of a thirtieth of the height, or the fall of the wall; nothing is set by hand, and elements are those of
`run`: short ones where limit analysis finds that stones turn. path.md is written by macroblock_peaks.py, which pushes
all of them.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

import numpy as np

from orchestrator.loads import LoadSettings
from orchestrator.pushover.solids.nodal_loads import own_weight

PROJECT, FOLDER = Path(__file__).parents[2], Path(__file__).parent
sys.path[:0] = [str(PROJECT), str(FOLDER)]

import any_wall
from mpi4py import MPI
from stored import markdown

from orchestrator.basis.errors import CollapseError, ConvergenceError
from orchestrator.limit_analysis import LimitAnalysis, analyse
from orchestrator.limit_analysis.turning_joints import pressed_at_hinges
from orchestrator.loads.block_loads import loads_on
from orchestrator.macroblocks.bodies import make_bodies
from orchestrator.macroblocks.criteria import one_body_per_block
from orchestrator.masonry.joints import Assemblage, JointSettings, find_joints
from orchestrator.masonry.patterns import IrregularCourses, Rubble, irregular_courses, rubble
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.masonry.wall import Wall
from orchestrator.pushover.increments import Increment, end_of_curve
from orchestrator.pushover.meshing import MeshSettings, mesh_bodies
from orchestrator.pushover.model import build_model
from orchestrator.pushover.path.stepping import Pushover
from orchestrator.pushover.settings import ContactSettings, ElasticSettings, NewtonSettings, SteppingSettings
from orchestrator.pushover.solve.linear_system import LinearSystem
from orchestrator.storage.effort import effort_of

PUSHOVERS, LIMIT = 100, 600.0
COURSES, DRAWN = 24, 50
"""pushovers of irregular courses, and of walls that were drawn; the rest are of larger rubble"""
OPENING = ((0.475, 0.925, 1.0, 1.7),)
TWO = ((0.5, 1.0, 0.0, 1.2), (1.6, 2.1, 0.6, 1.3))
WALLS = [
    IrregularCourses(0.8, 0.6, seed=1),
    IrregularCourses(0.7, 1.4, seed=2),
    IrregularCourses(1.4, 1.0, widths=(0.2, 0.4), heights=(0.15, 0.2), friction=0.6, seed=4),
    IrregularCourses(2.0, 1.2, widths=(0.2, 0.4), heights=(0.15, 0.2), friction=0.5, seed=5),
    IrregularCourses(1.4, 2.8, openings=OPENING, widths=(0.18, 0.36), heights=(0.12, 0.18), seed=6),
    IrregularCourses(2.6, 1.8, openings=TWO, widths=(0.2, 0.4), heights=(0.15, 0.2), seed=7),
    IrregularCourses(2.6, 1.8, openings=TWO, widths=(0.2, 0.4), heights=(0.15, 0.2), friction=0.5, seed=8),
    IrregularCourses(1.4, 2.8, openings=OPENING, seed=9),
    IrregularCourses(2.0, 1.4, seed=10),
    IrregularCourses(2.6, 1.8, openings=TWO, widths=(0.15, 0.3), heights=(0.1, 0.15), seed=11),
    IrregularCourses(3.0, 2.4, openings=TWO, widths=(0.12, 0.3), heights=(0.1, 0.14), seed=12),
    IrregularCourses(1.4, 1.0, seed=3),
]


def wall_of(number: int) -> tuple[str, Wall]:
    """Return family and wall of a pair of pushovers."""
    if number < COURSES // 2:
        return "irregular courses", irregular_courses(WALLS[number])
    number -= COURSES // 2
    if number < DRAWN // 2:
        family, wall = any_wall.wall_of(number)
        with TemporaryDirectory() as folder:
            errors = any_wall.ERRORS[number % len(any_wall.ERRORS)]
            any_wall._read(wall, errors, Path(folder), number)
            return f"{family}, drawn", read_blocks(Path(folder) / "wall.json")
    number -= DRAWN // 2
    random = np.random.default_rng(number)
    stone, flatness = random.uniform(0.24, 0.34), random.uniform(1.2, 2.4)
    return "larger rubble", rubble(Rubble(2.6, 2.2, stone=stone, flatness=flatness, seed=number))


def analysed_run(run: int) -> tuple[str, Assemblage, LimitAnalysis]:
    """Return the family of a pushover, its wall and limit analysis."""
    family, wall = wall_of(run // 2)
    assemblage = find_joints(wall, JointSettings())
    return family, assemblage, analyse(assemblage, loads=loads_on(wall, LoadSettings("-x" if run % 2 else "+x")))


def pushed_stones(
    assemblage: Assemblage, analysis: LimitAnalysis, limit: float = LIMIT, size_over_default: float = 1.0
) -> dict[str, Any]:
    """Return the row of a wall pushed stone by stone under the loads of its limit analysis, left after `limit` s of CPU
    time."""
    forces, hinges, began = analysis.headline.joint_forces, pressed_at_hinges(assemblage, analysis), process_time()
    bodies = make_bodies(assemblage, one_body_per_block(assemblage), forces, hinges=hinges)
    meshes = mesh_bodies(bodies, MeshSettings(size=size_over_default * MeshSettings().size_of(bodies)), None)
    direction = np.sign(analysis.loads.live[:, 0].sum())
    along = own_weight(meshes, np.array([direction, 0.0]))
    model = build_model(bodies, meshes, ElasticSettings(), ContactSettings(), True, along)
    stepping, expected = SteppingSettings(), analysis.expected_multiplier
    ended, kept = "", list[Increment]()
    try:
        with LinearSystem(model, MPI.COMM_SELF) as system:
            for increment in Pushover(model, system, NewtonSettings(), stepping, expected).increments():
                kept.append(increment)
                if process_time() - began > limit:
                    ended = f"left after {limit:g} s"
                    break
                ended = end_of_curve(increment, stepping, model.height) or ended
    except CollapseError as error:
        ended = str(error)
    except ConvergenceError as error:
        ended = f"STOPPED: {error}"
    effort = effort_of(kept, model.body_names, model.body_mass)
    return {
        "direction": "+x" if direction > 0 else "-x",
        "stones": model.bodies,
        "peak": kept[-1].largest_base_shear / model.horizontal_load,
        "iterations": effort.newton_iterations,
        "rescues": sum(effort.rescues.values()),
        "fallen_share": sum(event.dead_load_share for event in effort.events),
        "energy_error": effort.energy_error,
        "seconds": round(process_time() - began, 1),
        "ended": ended,
    }


def write_table(path: Path, rows: list[dict[str, Any]]) -> None:
    """Write rows with the columns that any of them has; 0 where one has none."""
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(dict.fromkeys(key for row in rows for key in row)), restval=0)
        writer.writeheader()
        writer.writerows(rows)


def write(rows: list[dict[str, Any]]) -> None:
    """Write path.md of the rows of macroblock_peaks.csv that have a curve of every stone."""
    rows = [row for row in rows if "micro_iterations" in row]
    families = [row["family"].split(",")[0] for row in rows]
    lines = []
    for family in [*dict.fromkeys(families), "all"]:
        of = [row for row, name in zip(rows, families, strict=True) if family in (name, "all")]
        work = [row["micro_iterations"] for row in of]
        ended = sum(not row["micro_ended"].startswith("NOT VALID") for row in of)
        moving, steps, events, rescues = (
            sum(row[f"micro_{name}"] for row in of) for name in ("in_motion", "steps", "events", "rescues")
        )
        lines.append(
            [family, f"{len(of)}", f"{ended}", f"{np.median(work):.0f}", f"{np.quantile(work, 0.95):.0f}"]
            + [f"{max(work)}", f"{moving} of {steps}", f"{events}", f"{rescues}"]
        )
    names = ["family", "pushovers", "reach their end", "iterations, median", "95 %", "most", "in motion", "events"]
    head = (FOLDER / "path_head.md").read_text()
    (FOLDER / "path.md").write_text(head.replace("{{table}}", markdown([*names, "rescues"], lines)))
