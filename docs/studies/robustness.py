"""Random irregular walls, every stone a body, pushed both ways in large displacements: how many reach their end.

    python docs/studies/robustness.py [number of walls]

writes robustness.csv and robustness.md beside this file. The end of a curve is a base shear 20 % below the peak, a
fallen stone, or a top displacement of a thirtieth of the height; nothing is set by hand. A run is left after LIMIT s of
CPU time (one core). Two runs go side by side.
"""

from __future__ import annotations

import csv
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from time import process_time

import numpy as np
from mpi4py import MPI

from orchestrator.basis.errors import CollapseError, ConvergenceError
from orchestrator.macroblocks.bodies import make_bodies
from orchestrator.macroblocks.criteria import one_body_per_block
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.patterns import IrregularCourses, irregular_courses
from orchestrator.pushover.increments import end_of_curve
from orchestrator.pushover.meshing import MeshSettings, mesh_bodies
from orchestrator.pushover.model import build_model
from orchestrator.pushover.path.stepping import Pushover
from orchestrator.pushover.settings import ContactSettings, ElasticSettings, NewtonSettings, SteppingSettings
from orchestrator.pushover.solids.nodal_loads import own_weight
from orchestrator.pushover.solve.linear_system import LinearSystem

FOLDER = Path(__file__).parent
LIMIT = 900.0
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


def pushed(pattern: IrregularCourses, direction: int) -> dict[str, object]:
    """Run one wall in one direction and return its row of the table."""
    began = process_time()
    assemblage = find_joints(irregular_courses(pattern), JointSettings())
    bodies = make_bodies(assemblage, one_body_per_block(assemblage))
    meshes = mesh_bodies(bodies, MeshSettings(), None)
    along = own_weight(meshes, np.array([direction, 0.0]))
    model = build_model(bodies, meshes, ElasticSettings(), ContactSettings(), True, along)
    stepping = SteppingSettings()
    iterations = failed = moving = fallen = 0
    last = None
    with LinearSystem(model, MPI.COMM_SELF) as system:
        try:
            for last in Pushover(model, system, NewtonSettings(), stepping).increments():
                iterations += last.iterations + sum(attempt.iterations for attempt in last.attempts)
                failed += len(last.attempts)
                moving, fallen = moving + last.moving, int(last.fallen.sum())
                if process_time() - began > LIMIT:
                    break
            end = end_of_curve(last, stepping, model.height) or f"left after {LIMIT:g} s of CPU time"
        except (CollapseError, ConvergenceError) as error:
            end = str(error)[:120]
    return {
        "seed": pattern.seed,
        "openings": len(pattern.openings),
        "blocks": model.bodies,
        "friction": pattern.friction,
        "direction": f"{direction:+d}",
        "peak multiplier": f"{last.largest_base_shear / model.weight:.4f}" if last else "",
        "last multiplier": f"{last.base_shear / model.weight:.4f}" if last else "",
        "last displacement, mm": f"{1e3 * last.control_displacement:.2f}" if last else "",
        "iterations": iterations,
        "failed attempts": failed,
        "rows in motion": moving,
        "fallen stones": fallen,
        "CPU time, s": f"{process_time() - began:.1f}",
        "end of the curve": end,
    }


def main() -> None:
    """Run all walls; both tables are written anew after each."""
    rows: list[dict[str, object]] = []
    walls = WALLS[: int(sys.argv[1]) if len(sys.argv) > 1 else len(WALLS)]
    runs = [(pattern, direction) for pattern in walls for direction in (1, -1)]
    with ProcessPoolExecutor(2, get_context("spawn")) as pool:
        for row in pool.map(pushed, *zip(*runs, strict=True)):
            rows.append(row)
            print(", ".join(f"{name} {value}" for name, value in row.items()), flush=True)
            write(rows)


def write(rows: list[dict[str, object]]) -> None:
    """Write robustness.csv and robustness.md."""
    with (FOLDER / "robustness.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    names = list(rows[0])
    lines = [names, ["---"] * len(names), *([str(row[name]) for name in names] for row in rows)]
    table = "\n".join(f"| {' | '.join(line)} |" for line in lines)
    title = "# Random irregular walls in large displacements\n\nMade by `python docs/studies/robustness.py`."
    (FOLDER / "robustness.md").write_text(f"{title}\n\n{table}\n")


if __name__ == "__main__":
    main()
