"""Cost of limit analysis in space against the number of blocks: U-shaped walls from 50 to about 2,000 blocks, and a
facade with openings and returns of about 1,000.

    .venv/bin/python benchmarks/space.py [SECONDS]

Writes benchmarks/space.csv: blocks, joints, seconds of processor time for check, joints, associative program (corners)
and the search without dilation (of which wall time is at most SECONDS, default 100), multipliers, error of what was
found nearest to a state, peak memory. Prints the exponents of a power law through the U-shaped walls.
"""

from __future__ import annotations

import csv
import resource
import sys
from pathlib import Path
from time import process_time

import numpy as np

from orchestrator.space.analysis import SpaceLimitSettings, analyse
from orchestrator.space.conic_program import solve_associative
from orchestrator.space.contacts import find_joints
from orchestrator.space.equilibrium import equilibrium_of
from orchestrator.space.generators.shapes import Plan, Stones, u_wall
from orchestrator.space.generators.walls import Openings, wall_with_openings
from orchestrator.space.loads import SpaceLoadSettings, loads_on
from orchestrator.space.wall import SpaceWall, check_wall

SIZES = ((4, 2, 6), (4, 2, 8), (6, 4, 12), (8, 5, 18), (10, 6, 24), (14, 8, 34), (20, 12, 45))
"""stones of the facade, stones of a return, courses"""


def walls() -> dict[str, SpaceWall]:
    """Return the walls by name, smallest first."""
    facade = wall_with_openings(Plan(20, 8, 30), Openings(3, 2.5, 6, 12), Stones())
    return {f"U{size}": u_wall(Plan(*size), Stones()) for size in SIZES} | {"openings": facade}


def measured(name: str, wall: SpaceWall, seconds: float) -> dict[str, str | float]:
    """Run one wall; return a row of the table."""
    started = process_time()
    check_wall(wall)
    checked = process_time()
    assemblage = find_joints(wall)
    found = process_time()
    loads = loads_on(wall, SpaceLoadSettings(direction="-y"))
    associative = solve_associative(equilibrium_of(assemblage, loads))
    solved = process_time()
    analysis = analyse(assemblage, loads, SpaceLimitSettings(time=seconds))
    nearest = min(analysis.states, key=lambda state: state.validation.flow)
    shown = analysis.headline or nearest
    low, high = analysis.range or (np.nan, np.nan)
    return {
        "wall": name,
        "blocks": len(wall.blocks) - 1,
        "joints": assemblage.joints.count,
        "check_s": checked - started,
        "joints_s": found - checked,
        "associative_s": solved - found,
        "without_dilation_s": process_time() - solved,
        "associative": associative.load_multiplier,
        "without_dilation": shown.load_multiplier,
        "is_state": float(shown.valid),
        "flow_error": shown.validation.flow,
        "lowest": low,
        "highest": high,
        "peak_memory_MB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3,
    }


def main() -> None:
    """Measure all walls, smallest first, and write after each."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 100.0
    rows = []
    for name, wall in walls().items():
        row = measured(name, wall, seconds)
        rows.append({key: value if isinstance(value, str) else round(value, 7) for key, value in row.items()})
        print(rows[-1], flush=True)
        with (Path(__file__).parent / "space.csv").open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, list(rows[0]))
            writer.writeheader()
            writer.writerows(rows)
    of_u = rows[: len(SIZES)]
    blocks = np.log([float(row["blocks"]) for row in of_u])
    for name in ("joints_s", "associative_s"):
        exponent = np.polyfit(blocks, np.log([float(row[name]) for row in of_u]), 1)[0]
        print(name, "~ blocks ^", round(float(exponent), 2))


if __name__ == "__main__":
    main()
