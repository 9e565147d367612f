"""One arched facade in nine drawings, with the errors of draughtsmen and surveys: the same joints and peak?

    python docs/studies/arched_facade.py

writes arched_facade.csv and arched_facade.md beside this file. The wall is templates/arched_facade.toml; each drawing
is imported, checked, analysed and its macroblocks are pushed to 5 mm, or left after LIMIT s of CPU time.
"""

from __future__ import annotations

import csv
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

PROJECT = Path(__file__).parents[2]
sys.path.insert(0, str(PROJECT))

from mpi4py import MPI

from orchestrator.app import driver
from orchestrator.app.intake import import_wall, write_wall
from orchestrator.masonry.patterns import ARCHED_FACADE, arched_wall
from orchestrator.pushover.meshing import mesh_bodies
from orchestrator.pushover.model import build_model
from orchestrator.pushover.path.stepping import Pushover
from orchestrator.pushover.solids.nodal_loads import nodal_loads
from orchestrator.pushover.solve.linear_system import LinearSystem
from orchestrator.settings import case as cases
from tests.support.drawings import CENTIMETRES, lines_and_arcs, polylines

FOLDER = Path(__file__).parent
CASE = PROJECT / "templates" / "arched_facade.toml"
DISPLACEMENT, LIMIT = 5e-3, 60.0
DRAWINGS: dict[str, dict[str, Any]] = {
    "block file, exact": {},
    "closed polylines in mm": {"polylines": {}},
    "closed polylines in cm": {"polylines": {"unit": CENTIMETRES}},
    "lines and arcs": {"lines": {}},
    "lines and arcs, 0.3 mm off": {"lines": {"error": 3e-4}},
    "lines and arcs, 3 mm off": {"lines": {"error": 3e-3}, "tolerance": "8 mm"},
    "closed polylines, 0.4 mm off": {"polylines": {"error": 4e-4}},
    "gaps of 3 mm": {"polylines": {"gap": 3e-3}, "mortar": "3 mm"},
    "gaps of 10 mm": {"polylines": {"gap": 1e-2}, "mortar": "10 mm"},
}
"""how the wall is drawn, and the options of its import beside those by default"""


def studied(name: str) -> dict[str, Any]:
    """Return the row of one drawing."""
    options = dict(DRAWINGS[name])
    case = cases.read(CASE)
    with TemporaryDirectory() as folder:
        drawn, began = Path(folder) / "wall.dxf", process_time()
        if options:
            wall = arched_wall(ARCHED_FACADE)
            if "lines" in options:
                openings = ARCHED_FACADE.courses.openings
                lines_and_arcs(drawn, wall, ARCHED_FACADE.arches, openings, **options.pop("lines"))
            else:
                polylines(drawn, wall, **options.pop("polylines"))
            began = process_time()
            options |= {"thickness": f"{wall.thickness} m", "friction": str(wall.friction)}
            write_wall(import_wall(drawn, options), Path(folder) / "wall.json")
            read = cases.read(Path(folder) / "wall.json")
            case = replace(read, elastic=case.elastic, load=case.load)
        said = driver.examine(case, driver.check(case))
        reading = process_time() - began
        segmented = driver.segment(case)
    analysis, partition = segmented.analysis, segmented.partition
    row: dict[str, Any] = {
        "drawing": name,
        "stones": len(segmented.assemblage.wall.blocks) - 1,
        "joints": segmented.assemblage.joints.count,
        "associative": analysis.associative.load_multiplier,
        "headline": analysis.headline.load_multiplier,
        "macroblocks": partition.count,
        "warnings": len(said),
        "seconds_import_and_check": round(reading, 2),
    }
    return row | _pushed(case, segmented)


def _pushed(case: cases.Case, segmented: driver.Segmented) -> dict[str, Any]:
    bodies, peak, iterations = segmented.bodies, 0.0, 0
    meshes = mesh_bodies(bodies, case.mesh, None)
    loads = nodal_loads(segmented.assemblage.wall, bodies, meshes, case.load)
    model = build_model(bodies, meshes, case.elastic, case.contact, True, loads)
    stepping = replace(case.stepping, final_displacement=DISPLACEMENT)
    began, moved = process_time(), 0.0
    with LinearSystem(model, MPI.COMM_SELF) as system:
        for increment in Pushover(model, system, case.newton, stepping).increments():
            iterations, moved = iterations + increment.iterations, increment.control_displacement
            peak = increment.largest_base_shear / model.horizontal_load
            if process_time() - began > LIMIT:
                break
    return {
        "peak": peak,
        "iterations": iterations,
        "moved_mm": 1e3 * moved,
        "left": moved < 0.99 * DISPLACEMENT,
        "seconds_pushover": round(process_time() - began, 1),
    }


def main() -> None:
    """Study all drawings and write the table and the page."""
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        rows = list(pool.map(studied, DRAWINGS))
    with (FOLDER / "arched_facade.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    exact = rows[0]
    lines = [
        [
            row["drawing"], str(row["joints"]), f"{row['associative']:.4f}",
            f"{100 * (row['associative'] / exact['associative'] - 1):+.2f} %", f"{row['headline']:.4f}",
            str(row["macroblocks"]), f"{row['peak']:.4f}", f"{100 * (row['peak'] / exact['peak'] - 1):+.2f} %",
            f"{row['moved_mm']:.3g}" + (" (ended)" if row["left"] else ""), str(row["iterations"]),
        ]
        for row in rows
    ]  # fmt: skip
    heads = [
        "drawing", "joints", "associative", "off", "headline", "macroblocks", "FE peak", "off", "moved, mm",
        "iterations",
    ]  # fmt: skip
    table = "\n".join(f"| {' | '.join(line)} |" for line in (heads, ["---"] * len(heads), *lines))
    head = (FOLDER / "arched_facade_head.md").read_text()
    (FOLDER / "arched_facade.md").write_text(f"{head}\n{table}\n")
    print(table)


if __name__ == "__main__":
    main()
