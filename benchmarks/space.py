"""Cost of limit analysis in space against the number of blocks: U-shaped walls from 52 to about 2,000 blocks.

    .venv/bin/python benchmarks/space.py [SECONDS]

Writes benchmarks/space.csv: blocks, joints, seconds for check, joints, associative program (corners), the push to the
headline (with at most SECONDS, default 100), multipliers, flow error of the push, peak memory. Prints the exponents of
a power law through the walls.
"""

from __future__ import annotations

import csv
import resource
import sys
from pathlib import Path
from time import perf_counter

import numpy as np

from orchestrator.space.conic_program import gravity_forces, solve_associative
from orchestrator.space.contacts import find_joints
from orchestrator.space.elastic_joints import depth_stiffness, push
from orchestrator.space.equilibrium import equilibrium_of
from orchestrator.space.generators.shapes import Plan, Stones, u_wall
from orchestrator.space.loads import SpaceLoadSettings, loads_on
from orchestrator.space.wall import check_wall

SIZES = ((4, 2, 6), (4, 2, 8), (6, 4, 12), (8, 5, 18), (10, 6, 24), (14, 8, 34), (20, 12, 45))
"""stones of the facade, stones of a return, courses"""


def measured(plan: Plan, seconds: float) -> dict[str, float]:
    """Run one wall; return a row of the table."""
    started = perf_counter()
    wall = u_wall(plan, Stones())
    check_wall(wall)
    checked = perf_counter()
    assemblage = find_joints(wall)
    found = perf_counter()
    equilibrium = equilibrium_of(assemblage, loads_on(wall, SpaceLoadSettings(direction="-y")))
    associative = solve_associative(equilibrium)
    solved = perf_counter()
    stiffness = depth_stiffness(assemblage)
    pushed = push(assemblage, equilibrium, gravity_forces(equilibrium, stiffness), stiffness, seconds)
    return {
        "blocks": len(wall.blocks) - 1,
        "joints": assemblage.joints.count,
        "check_s": checked - started,
        "joints_s": found - checked,
        "associative_s": solved - found,
        "headline_s": perf_counter() - solved,
        "associative": associative.load_multiplier,
        "headline": pushed.load_multiplier,
        "flow_error": pushed.flow,
        "factorisations": pushed.factorisations,
        "peak_memory_MB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3,
    }


def main() -> None:
    """Measure all walls, smallest first, and write after each."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 100.0
    rows = []
    for size in SIZES:
        rows.append({name: round(value, 7) for name, value in measured(Plan(*size), seconds).items()})
        print(rows[-1], flush=True)
        with (Path(__file__).parent / "space.csv").open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, list(rows[0]))
            writer.writeheader()
            writer.writerows(rows)
    blocks = np.log([row["blocks"] for row in rows])
    for name in ("joints_s", "associative_s"):
        print(name, "~ blocks ^", round(float(np.polyfit(blocks, np.log([row[name] for row in rows]), 1)[0]), 2))


if __name__ == "__main__":
    main()
