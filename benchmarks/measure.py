"""What a pushover costs: against the number of blocks, on two ranks, and on benchmark 1 (`make bench`).

Every measurement is a process of its own, so that peak memory is its own too. The scaling runs take gravity and a
fixed number of further increments of running bond walls of the same stones; three of the walls then go to 20 mm (the
largest takes three minutes). `--quick` measures the two smallest only, without that. Times are CPU seconds of one
process. Two ranks are compared with one by wall-clock, which needs a quiet machine, and by the CPU seconds of the
slower rank without waiting: what a rank does for itself is measured, MUMPS takes the time of one rank x the share of
the operations that the rank has (`--ranks BLOCKS` measures this only). `--meshes` pushes benchmark 1 with elements of a
half and a quarter of their size only. Writes scaling.csv, whole.csv, walls.csv, meshes.csv and scaling.png beside this
file. Timings of one run may be compared, as ratios, with one another; not with those of
another day.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import resource
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from statistics import median
from time import perf_counter, process_time

import numpy as np

from orchestrator.pushover.solids.nodal_loads import own_weight

FOLDER = Path(__file__).parent
SIZES = {33: (5, 6), 147: (10, 14), 512: (20, 25), 1012: (40, 25), 2012: (80, 25)}
"""blocks: (blocks per course, courses) of a running bond wall"""
INCREMENTS = 25
"""increments of the scaling runs, gravity included"""
WHOLE = (33, 147, 512)
"""blocks of the walls that are pushed to 20 mm, through their peak"""


def scaling(blocks: int, increments: int | None = INCREMENTS) -> dict[str, float]:
    """Push one wall for so many increments, or to 20 mm, on all ranks of this process group.

    alone_ms, together_ms: CPU per iteration of what a rank does for itself (the slowest one) and of what all do
    together (MUMPS, with waiting); largest_share: largest part of the factorisation that a rank does.
    """
    from mpi4py import MPI

    seconds = process_time if MPI.COMM_WORLD.size == 1 else perf_counter

    from orchestrator.macroblocks.bodies import make_bodies
    from orchestrator.macroblocks.criteria import one_body_per_block
    from orchestrator.masonry.joints import JointSettings, find_joints
    from orchestrator.masonry.patterns import running_bond
    from orchestrator.pushover.meshing import MeshSettings, mesh_bodies
    from orchestrator.pushover.model import build_model
    from orchestrator.pushover.path.stepping import Pushover
    from orchestrator.pushover.settings import ContactSettings, ElasticSettings, NewtonSettings, SteppingSettings
    from orchestrator.pushover.solve.linear_system import LinearSystem

    began = seconds()
    assemblage = find_joints(running_bond(*SIZES[blocks]), JointSettings())
    bodies = make_bodies(assemblage, one_body_per_block(assemblage))
    meshes = mesh_bodies(bodies, MeshSettings(), None)
    model = build_model(bodies, meshes, ElasticSettings(), ContactSettings(), True)
    built, started = seconds(), process_time()
    stepping = SteppingSettings(largest_increments=increments) if increments else SteppingSettings()
    iterations = failed = 0
    with LinearSystem(model, MPI.COMM_WORLD) as system:
        pushover = Pushover(model, system, NewtonSettings(), stepping)
        for increment in pushover.increments():
            iterations += increment.iterations + sum(attempt.iterations for attempt in increment.attempts)
            failed += len(increment.attempts)
        share = MPI.COMM_WORLD.allreduce(system.share, MPI.MAX)
        alone = MPI.COMM_WORLD.allreduce(process_time() - started - system.together, MPI.MAX)
    total = seconds() - began
    return {
        "blocks": blocks,
        "unknowns": model.unknowns,
        "contacts": len(model.contacts),
        "iterations": iterations,
        "failed_attempts": failed,
        "displacement_mm": 1e3 * increment.control_displacement,
        "set_up_s": built - began,
        "total_s": total,
        "per_iteration_ms": 1e3 * (total - (built - began)) / iterations,
        "alone_ms": 1e3 * alone / iterations,
        "together_ms": 1e3 * system.together / iterations,
        "largest_share": share,
        "peak_memory_MB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }


def benchmark1(large: bool, finer: float = 1.0) -> dict[str, dict[str, float]]:
    """Push benchmark 1 in macroblocks and stone by stone to its end, as `make benchmark1` does, without pictures.

    finer: divides the size of elements.
    """
    from mpi4py import MPI

    from orchestrator.app import driver
    from orchestrator.pushover.meshing import mesh_bodies
    from orchestrator.pushover.model import build_model
    from orchestrator.pushover.path.stepping import Pushover
    from orchestrator.pushover.solve.linear_system import LinearSystem
    from orchestrator.settings import case as cases

    case = cases.read(FOLDER.parent / "templates" / "benchmark1.toml")
    segmented = driver.segment(case)
    rows = {}
    for name, bodies in (("macroblocks", segmented.bodies), ("micro-FE", segmented.bodies_of("micro"))):
        began = process_time()
        meshes = mesh_bodies(bodies, replace(case.mesh, size=case.mesh.size / finer), None)
        loads = own_weight(meshes, case.load.vector)
        model = build_model(bodies, meshes, case.elastic, case.contact, large, loads)
        iterations = failed = 0
        with LinearSystem(model, MPI.COMM_SELF) as system:
            for last in Pushover(model, system, case.newton, case.stepping).increments():
                iterations += last.iterations + sum(attempt.iterations for attempt in last.attempts)
                failed += len(last.attempts)
        rows[name] = {
            "bodies": model.bodies,
            "unknowns": model.unknowns,
            "iterations": iterations,
            "failed_attempts": failed,
            "peak_multiplier": last.largest_base_shear / model.weight,
            "displacement_mm": 1e3 * last.control_displacement,
            "total_s": process_time() - began,
        }
    return rows


def on_first_rank(row: dict) -> None:
    """Print what a process measured, once."""
    from mpi4py import MPI

    if MPI.COMM_WORLD.rank == 0:
        print(json.dumps(row))


def in_own_process(*arguments: str, ranks: int = 1) -> dict:
    """Run this file with `arguments` and return what it prints."""
    command = [sys.executable, __file__, *arguments]
    if ranks > 1:
        command = ["mpirun", "--oversubscribe", "-n", str(ranks), *command]
    environment = os.environ | {
        "OMP_NUM_THREADS": "1",
        "OMPI_ALLOW_RUN_AS_ROOT": "1",
        "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    }
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return json.loads(done.stdout.splitlines()[-1])


def exponent(rows: list[dict[str, float]], name: str, least: int = 100) -> float:
    """Return the slope of log(name) over log(blocks), least squares over the walls of at least so many blocks."""
    used = [row for row in rows if row["blocks"] >= least] if len(rows) > 2 else rows
    return float(np.polyfit(np.log([r["blocks"] for r in used]), np.log([r[name] for r in used]), 1)[0])


def write(name: str, rows: list[dict]) -> None:
    """Write rows as CSV beside this file and print them as a table."""
    with (FOLDER / name).open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(
            {key: f"{value:.4g}" if isinstance(value, float) else value for key, value in row.items()} for row in rows
        )
    from rich.console import Console
    from rich.table import Table

    table = Table(*rows[0], title=name)
    for row in rows:
        table.add_row(*(f"{value:.4g}" if isinstance(value, float) else str(value) for value in row.values()))
    Console(width=160).print(table)


def draw(rows: list[dict[str, float]]) -> None:
    """Draw cost against blocks, logarithmic."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axes = figure.subplots()
    blocks = [row["blocks"] for row in rows]
    names = {"total_s": "total, s", "per_iteration_ms": "per iteration, ms", "peak_memory_MB": "peak memory, MB"}
    for name, label in names.items():
        slope = exponent(rows, name)
        axes.loglog(blocks, [row[name] for row in rows], "o-", label=f"{label} (exponent {slope:.2f})")
    axes.set_xlabel("blocks")
    axes.set_ylabel("cost")
    axes.set_title(f"Micro-FE of running bond walls, {INCREMENTS} increments")
    axes.grid(visible=True, which="both", alpha=0.3)
    axes.legend()
    figure.savefig(FOLDER / "scaling.png", dpi=150)


def compare_ranks(blocks: int) -> None:
    """Print how much faster two ranks are than one, by both clocks."""
    runs, seconds = [], []
    for ranks in (1, 2):
        began = perf_counter()
        runs.append(in_own_process("--scaling", str(blocks), ranks=ranks))
        seconds.append(perf_counter() - began)
    one, two = runs
    critical = two["alone_ms"] + one["together_ms"] * two["largest_share"]
    print(
        f"{blocks} blocks, CPU of an iteration without waiting: one rank {one['alone_ms']:.3g} + MUMPS "
        f"{one['together_ms']:.3g} ms; two {two['alone_ms']:.3g} ms + {100 * two['largest_share']:.0f} % of it: "
        f"at most {(one['alone_ms'] + one['together_ms']) / critical:.2f} times the speed of one; "
        f"by wall-clock {seconds[0] / seconds[1]:.2f} times"
    )


def main() -> None:
    """Measure everything, or one thing as a process of its own."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="the two smallest walls only")
    parser.add_argument("--ranks", type=int, metavar="BLOCKS", help="compare two ranks with one on this wall only")
    parser.add_argument("--repeat", type=int, default=3, help="runs of benchmark 1, medians are shown (default 3)")
    parser.add_argument("--scaling", type=int, help=argparse.SUPPRESS)
    parser.add_argument("--to-the-end", type=int, help=argparse.SUPPRESS)
    parser.add_argument("--meshes", action="store_true", help="finer meshes of benchmark 1 only")
    parser.add_argument("--benchmark1", choices=("small", "large"), help=argparse.SUPPRESS)
    parser.add_argument("--finer", type=float, default=1.0, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.scaling:
        on_first_rank(scaling(arguments.scaling))
    elif arguments.to_the_end:
        on_first_rank(scaling(arguments.to_the_end, None))
    elif arguments.ranks:
        compare_ranks(arguments.ranks)
    elif arguments.benchmark1:
        on_first_rank(benchmark1(arguments.benchmark1 == "large", arguments.finer))
    elif arguments.meshes:
        measure_meshes()
    else:
        measure(arguments.quick, arguments.repeat)


def measure_meshes() -> None:
    """Push benchmark 1 with finer and finer meshes, and write their table."""
    rows = []
    for finer in (1, 2, 4):
        run = in_own_process("--benchmark1", "large", "--finer", str(finer))
        rows += [{"benchmark 1": model, "mesh.size over": finer, **figures} for model, figures in run.items()]
    write("meshes.csv", rows)


def measure(quick: bool, repeat: int) -> None:
    """Run all measurements and write their tables."""
    sizes = list(SIZES)[:2] if quick else list(SIZES)
    rows = [in_own_process("--scaling", str(blocks)) for blocks in sizes]
    write("scaling.csv", rows)
    draw(rows)
    for name in ("total_s", "per_iteration_ms", "peak_memory_MB"):
        print(f"exponent of {name} over blocks: {exponent(rows, name):.2f}")
    largest = rows[-1] if quick else next(row for row in rows if row["blocks"] == 1012)
    compare_ranks(largest["blocks"])
    if quick:
        return
    whole = [in_own_process("--to-the-end", str(blocks)) for blocks in WHOLE]
    write("whole.csv", whole)
    for name in ("iterations", "total_s", "peak_memory_MB"):
        print(f"to 20 mm, exponent of {name} over blocks: {exponent(whole, name, WHOLE[0]):.2f}")
    measure_walls(repeat)
    measure_meshes()


def measure_walls(repeat: int) -> None:
    """Push benchmark 1 so many times and write medians."""
    walls = []
    for kinematics in ("small", "large"):
        runs = [in_own_process("--benchmark1", kinematics) for _ in range(repeat)]
        for model in runs[0]:
            figures = {name: median(run[model][name] for run in runs) for name in runs[0][model]}
            walls.append({"benchmark 1": model, "displacements": kinematics, **figures})
    write("walls.csv", walls)


if __name__ == "__main__":
    main()
