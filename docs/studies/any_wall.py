"""Walls of rubble and with arches, drawn with errors: how many come through import, check, limit, segment and run.

    python docs/studies/any_wall.py [number of walls, default 200]

writes any_wall.csv and any_wall.md beside this file. Every wall is drawn as closed polylines (DXF) with eight kinds of
error, imported with a tolerance of three times the error, and checked, and its joints and associative multiplier are
compared with those of the exact wall. One of the eight drawings goes on to limit analysis and macroblocks; of every
third wall the macroblocks are pushed, of every ninth one every stone. Two walls go side by side; a pushover is left
after LIMIT s of CPU time.
"""

from __future__ import annotations

import csv
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

import numpy as np

PROJECT = Path(__file__).parents[2]
sys.path.insert(0, str(PROJECT))

from mpi4py import MPI

from orchestrator.app import driver
from orchestrator.app.intake import import_wall
from orchestrator.basis.errors import CaseError, CollapseError, ConvergenceError
from orchestrator.limit_analysis.gravity import refuse_what_cannot_be_analysed
from orchestrator.loads import loads_on
from orchestrator.macroblocks.bodies import make_bodies
from orchestrator.macroblocks.criteria import Partition, one_body_per_block
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.patterns import ArchedOpening, ArchedWall, IrregularCourses, Rubble, arched_wall, rubble
from orchestrator.masonry.wall import Wall
from orchestrator.pushover.increments import end_of_curve
from orchestrator.pushover.meshing import mesh_bodies
from orchestrator.pushover.model import build_model
from orchestrator.pushover.path.stepping import Pushover
from orchestrator.pushover.solids.nodal_loads import nodal_loads
from orchestrator.pushover.solve.linear_system import LinearSystem
from orchestrator.settings import case as cases
from orchestrator.storage.files import write_json
from orchestrator.storage.values import blocks_record
from tests.support.drawings import polylines

FOLDER = Path(__file__).parent
LIMIT = 240.0
ERRORS: list[dict[str, float]] = [
    {},
    *({"error": 1e-3 * mm} for mm in (0.001, 0.1, 1.0, 3.0)),
    *({"rounding": 1e-3 * mm} for mm in (0.001, 0.1, 1.0)),
]
TOLERANCE, LEAST = 3.0, 1e-5
"""tolerance of the import over the error; and at least, m"""
MACRO, MICRO = 3, 9
"""of every so-many-th wall the macroblocks, every stone, are pushed"""
FAMILIES = ("rubble", "rubble with window", "semicircular arch", "segmental arch", "flat arch")


def wall_of(number: int) -> tuple[str, Wall]:
    """Return family and wall of a number."""
    family, seed = FAMILIES[number % len(FAMILIES)], number // len(FAMILIES)
    random = np.random.default_rng(seed)
    if family == "rubble":
        return family, rubble(
            Rubble(1.8, 1.6, stone=random.uniform(0.25, 0.4), flatness=random.uniform(1.0, 2.5), seed=seed)
        )
    if family == "rubble with window":
        return family, rubble(Rubble(2.2, 1.8, stone=0.32, flatness=1.7, openings=((0.8, 1.4, 0.5, 1.2),), seed=seed))
    rise, voussoirs = {"semicircular arch": (None, 9), "segmental arch": (0.2, 7), "flat arch": (0.0, 7)}[family]
    arch = ArchedOpening(0.95, 1.85, 0.0, 1.0, rise=rise, depth=0.25, voussoirs=voussoirs)
    quoins = (0.6, 0.4) if seed % 2 else None
    while True:
        courses = IrregularCourses(
            2.8, 2.2, thickness=0.4, widths=(0.35, 0.6), heights=(0.22, 0.32), overlap=0.07, friction=0.7, seed=seed
        )
        try:
            return family, arched_wall(ArchedWall(courses, (arch,), quoins=quoins))
        except CaseError:  # no stones of these widths fit into a course: the next wall
            seed += 1000


def studied(number: int) -> list[dict[str, Any]]:
    """Return the rows of one wall, one for each of its drawings."""
    family, wall = wall_of(number)
    rows = []
    with TemporaryDirectory() as folder:
        exact: tuple[int, float] | None = None
        for k, errors in enumerate(ERRORS):
            whole = number % len(ERRORS) == k
            row = {"wall": number, "family": family, "stones": len(wall.blocks) - 1, "drawn": _words(errors)}
            row |= _read(wall, errors, Path(folder), number)
            if "joints" in row:
                found = (int(row["joints"]), float(row["associative"]))
                exact = exact or found
                row["joints_off"] = found[0] - exact[0]
                row["associative_off"] = found[1] / exact[1] - 1.0
                if whole:
                    row |= _chain(Path(folder) / "wall.json", number)
            rows.append(row)
    return rows


def _words(errors: dict[str, float]) -> str:
    return ", ".join(f"{name} {1e3 * value:g} mm" for name, value in errors.items()) or "exact"


def _read(wall: Wall, errors: dict[str, float], folder: Path, seed: int) -> dict[str, Any]:
    """Import and check one drawing; joints and associative multiplier, or why it was refused."""
    began = process_time()
    tolerance = max(LEAST, TOLERANCE * sum(errors.values()))
    options = {"thickness": f"{wall.thickness} m", "friction": str(wall.friction), "tolerance": f"{tolerance} m"}
    try:
        taken = import_wall(polylines(folder / "wall.dxf", wall, **errors, seed=seed), options)
        write_json(folder / "wall.json", blocks_record(taken.wall))
        case = cases.read(folder / "wall.json")
        assemblage = driver.check(case)
        loads = loads_on(assemblage.wall, case.load)
        multiplier = refuse_what_cannot_be_analysed(assemblage, loads).load_multiplier
        said = driver.lost_joints(assemblage, case.joints)
    except CaseError as error:
        return {"refused": str(error).replace(f"{folder}/", "")}
    except Exception as error:  # what this study is to find
        return {"refused": f"TRACEBACK {type(error).__name__}: {error}"}
    seconds = process_time() - began
    joints = assemblage.joints.count
    return {"joints": joints, "associative": multiplier, "warned": bool(said), "seconds_read": round(seconds, 3)}


def _chain(file: Path, number: int) -> dict[str, Any]:
    """Limit analysis, macroblocks and, of some walls, the pushovers of one imported drawing."""
    began = process_time()
    try:
        case = cases.read(file)
        segmented = driver.segment(case)
    except CaseError as error:
        return {"refused": str(error)}
    except Exception as error:
        return {"refused": f"TRACEBACK {type(error).__name__}: {error}"}
    row: dict[str, Any] = {
        "headline": segmented.analysis.headline.load_multiplier,
        "macroblocks": segmented.partition.count,
        "seconds_segment": round(process_time() - began, 2),
    }
    assemblage = segmented.assemblage
    if number % MACRO == 0:
        row |= _pushed("macro", case, assemblage, segmented.partition)
    if number % MICRO == 0:
        row |= _pushed("micro", case, assemblage, one_body_per_block(assemblage))
    return row


def _pushed(name: str, case: cases.Case, assemblage: Assemblage, partition: Partition) -> dict[str, Any]:
    began = process_time()
    bodies = make_bodies(assemblage, partition)
    ended, peak, iterations, moved = "", 0.0, 0, 0.0
    try:
        meshes = mesh_bodies(bodies, case.mesh, None)
        loads = nodal_loads(assemblage.wall, bodies, meshes, case.load)
        model = build_model(bodies, meshes, case.elastic, case.contact, True, loads)
        with LinearSystem(model, MPI.COMM_SELF) as system:
            for increment in Pushover(model, system, case.newton, case.stepping).increments():
                iterations += increment.iterations
                moved = increment.control_displacement
                peak = increment.largest_base_shear / model.horizontal_load
                if process_time() - began > LIMIT:
                    ended = f"left after {LIMIT:g} s"
                    break
                ended = end_of_curve(increment, case.stepping, model.height) or ended
    except CollapseError as error:
        ended = str(error)
    except ConvergenceError as error:
        ended = f"STOPPED: {error}"
    except Exception as error:
        ended = f"TRACEBACK {type(error).__name__}: {error}"
    figures = {"peak": peak, "iterations": iterations, "moved_mm": 1e3 * moved, "ended": ended}
    return {f"{name}_{key}": value for key, value in figures.items()} | {
        f"{name}_seconds": round(process_time() - began, 1)
    }


def main(count: int) -> None:
    """Study `count` walls and write the table and the page."""
    rows: list[dict[str, Any]] = []
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        for number, of_wall in enumerate(pool.map(studied, range(count))):
            rows += of_wall
            whole = next((row for row in of_wall if "headline" in row), {})
            said = {
                key: whole.get(key) for key in ("headline", "macroblocks", "macro_peak", "macro_ended", "micro_ended")
            }
            print(number, of_wall[0]["family"], of_wall[0]["stones"], said, flush=True)
            write(rows)


def write(rows: list[dict[str, Any]]) -> None:
    """Write any_wall.csv and the tables of any_wall.md."""
    columns = list(dict.fromkeys(key for row in rows for key in row))
    with (FOLDER / "any_wall.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, columns)
        writer.writeheader()
        writer.writerows(rows)
    head = (FOLDER / "any_wall_head.md").read_text()
    (FOLDER / "any_wall.md").write_text(f"{head}\n{read_table(rows)}\n\n{push_table(rows)}\n")


def read_table(rows: list[dict[str, Any]]) -> str:
    """Return the table of what became of the drawings, by kind of error."""
    lines = []
    for drawn in dict.fromkeys(row["drawn"] for row in rows):
        of_kind = [row for row in rows if row["drawn"] == drawn]
        read = [row for row in of_kind if "joints" in row]
        off = np.abs([row["associative_off"] for row in read]) if read else np.zeros(1)
        same = sum(row["joints_off"] == 0 for row in read)
        lines.append(
            [
                drawn, str(len(of_kind)), str(len(read)), str(same), f"{100 * np.median(off):.2g} %",
                f"{100 * np.mean(off <= 0.01):.0f} %", f"{100 * off.max():.2g} %",
                str(sum("TRACEBACK" in row.get("refused", "") for row in of_kind)),
            ]
        )  # fmt: skip
    heads = (
        "drawn", "drawings", "through check", "with the joints of the exact wall", "associative off, median",
        "within 1 %", "largest", "tracebacks",
    )  # fmt: skip
    return markdown(heads, lines)


def push_table(rows: list[dict[str, Any]]) -> str:
    """Return the table of the pushovers, by family."""
    lines = []
    for family in dict.fromkeys(row["family"] for row in rows):
        of_family = [row for row in rows if row["family"] == family]
        chain = [row for row in of_family if "headline" in row]
        cells = [family, str(len(chain)), str(sum("TRACEBACK" in row.get("refused", "") for row in of_family))]
        for name in ("macro", "micro"):
            pushed = [row for row in chain if f"{name}_ended" in row]
            ended = [row for row in pushed if _ended(str(row[f"{name}_ended"]))]
            work = [row[f"{name}_iterations"] for row in pushed]
            cells += [f"{len(ended)} of {len(pushed)}", f"{np.median(work):.0f}" if work else "-"]
        lines.append(cells)
    heads = (
        "family", "limit and segment", "tracebacks", "macroblocks to the end of the curve", "iterations, median",
        "every stone to the end", "iterations, median",
    )  # fmt: skip
    return markdown(heads, lines)


def _ended(words: str) -> bool:
    return not any(words.startswith(bad) for bad in ("STOPPED", "left", "TRACEBACK")) and words != ""


def markdown(heads: tuple[str, ...], rows: list[list[str]]) -> str:
    """Return a table in Markdown."""
    return "\n".join(f"| {' | '.join(line)} |" for line in (list(heads), ["---"] * len(heads), *rows))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 200)
