"""Cost of micro limit analysis against blocks: running bond walls, everything that `analyse` does.

    python benchmarks/limit_analysis.py [--quick]

writes limit_analysis.csv and limit_analysis.png beside this file and prints the exponents. Each wall runs in a process
of its own, so that its peak memory is its own.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import resource
import subprocess
import sys
from pathlib import Path
from time import process_time

import numpy as np

FOLDER = Path(__file__).parent
SIZES = {105: (10, 10), 291: (14, 20), 997: (28, 35), 3018: (50, 59), 4235: (60, 70), 6440: (80, 80), 10050: (100, 100)}
"""free blocks, nearly: (blocks per course, courses)"""
COSTS = {
    "joints_s": "joints, s of processor time",
    "analysis_cpu_s": "analysis, s of processor time",
    "peak_memory_MB": "peak memory, MB",
}


def measured(blocks: int) -> dict[str, float | str]:
    """Analyse one wall."""
    from orchestrator.limit_analysis import analyse
    from orchestrator.masonry.joints import JointSettings, find_joints
    from orchestrator.masonry.patterns import running_bond

    wall = running_bond(*SIZES[blocks])
    began = process_time()
    assemblage = find_joints(wall, JointSettings())
    found_joints = process_time()
    found = analyse(assemblage)
    analysed = process_time()
    return {
        "blocks": sum(not block.fixed for block in wall.blocks),
        "joints": assemblage.joints.count,
        "associative": found.associative.load_multiplier,
        "headline": found.headline.load_multiplier,
        "found_by": found.headline.flow_rule,
        "joints_s": found_joints - began,
        "analysis_cpu_s": analysed - found_joints,
        "analysis_s": found.seconds,
        "peak_memory_MB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }


def in_own_process(blocks: int) -> dict[str, float | str]:
    """Run this file for one wall and return what it prints."""
    command = [sys.executable, __file__, "--blocks", str(blocks)]
    done = subprocess.run(
        command, env=os.environ | {"OMP_NUM_THREADS": "1"}, capture_output=True, text=True, check=True
    )
    return json.loads(done.stdout.splitlines()[-1])


def exponent(rows: list[dict], name: str) -> float:
    """Return the slope of log(name) over log(blocks), least squares."""
    return float(np.polyfit(np.log([row["blocks"] for row in rows]), np.log([row[name] for row in rows]), 1)[0])


def draw(rows: list[dict]) -> None:
    """Draw cost against blocks, logarithmic."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axes = figure.subplots()
    for name, label in COSTS.items():
        label = f"{label} (exponent {exponent(rows, name):.2f})"
        axes.loglog([row["blocks"] for row in rows], [row[name] for row in rows], "o-", label=label)
    axes.set_xlabel("blocks")
    axes.set_ylabel("cost")
    axes.set_title("Micro limit analysis of running bond walls")
    axes.grid(visible=True, which="both", alpha=0.3)
    axes.legend()
    figure.savefig(FOLDER / "limit_analysis.png", dpi=150)


def main() -> None:
    """Measure all walls, or one as a process of its own."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="the three smallest walls only")
    parser.add_argument("--blocks", type=int, choices=SIZES, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.blocks:
        print(json.dumps(measured(arguments.blocks)))
        return
    rows = []
    for blocks in list(SIZES)[:3] if arguments.quick else SIZES:
        rows.append(in_own_process(blocks))
        print(
            ", ".join(f"{k} {v:.4g}" if isinstance(v, float) else f"{k} {v}" for k, v in rows[-1].items()), flush=True
        )
        with (FOLDER / "limit_analysis.csv").open("w", newline="") as file:
            writer = csv.DictWriter(file, rows[0], lineterminator="\n")
            writer.writeheader()
            writer.writerows({k: f"{v:.6g}" if isinstance(v, float) else v for k, v in row.items()} for row in rows)
    if len(rows) > 1:
        draw(rows)
        for name, label in COSTS.items():
            print(f"exponent of {label} over blocks: {exponent(rows, name):.2f}")


if __name__ == "__main__":
    main()
