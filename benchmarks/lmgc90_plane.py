"""Micro-FE against LMGC90 (rigid blocks, dynamic, exact Coulomb friction): onset of rubble, an arch, walls that slide.

    python -m venv build/lmgc90 && build/lmgc90/bin/pip install compas_lmgc90
    .venv/bin/python benchmarks/lmgc90_plane.py build/lmgc90/bin/python [names of `walls`, default all]

Every wall is pushed along +x. Micro-FE: every stone a body, default mode (large displacements); its onset is the
largest load multiplier of a static state. LMGC90 gets the stones as prisms (they must be convex), REST s under their
weight, then forces that grow with time, in SECONDS to 1.1 times the associative multiplier; walls of SLOWLY at half
that rate too.

How LMGC90's onset is read: what the load has more than the wall bears accelerates a rigid mechanism, so under a load
that grows steadily the root of its speed grows linearly with the multiplier, whatever the rate. The run ends when the
centre of mass has gone by MOVED of the wall's height. The part that moves are then all blocks at a tenth of the mean
speed sum m v^2 / sum m v or more; its participation is (sum m v)^2 / (M sum m v^2), as in docs/theory.md. The line
through the root of that part's mean speed, from a tenth of the last speed on, meets zero at the onset. Writes
benchmarks/lmgc90_plane.csv.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import shapely

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent), str(HERE.parent / "docs" / "studies")]

from lmgc90 import STEP, simulated
from rigid_limit import column, pushed
from stored import RESULTS, stored

from orchestrator.basis.arrays import read_only
from orchestrator.geometry.polyhedra import prism
from orchestrator.limit_analysis.gravity import refuse_what_cannot_be_analysed
from orchestrator.loads.block_loads import loads_on
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.patterns import (
    Arch,
    IrregularCourses,
    Rubble,
    arch_on_piers,
    irregular_courses,
    rubble,
)
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.masonry.wall import Wall
from orchestrator.space.wall import UPRIGHT, SpaceBlock, SpaceWall

REST, SECONDS = 0.1, 1.5
"""s under the weight alone, and of the ramp"""
SLOWLY = ("block", "arch")
"""walls that are also pushed at half the rate"""
MOVED = 1e-3
"""share of its height by which a wall has moved when a run ends"""
SMOOTH = 5
"""steps over which a speed is taken"""


def walls() -> dict[str, Wall]:
    """Return the walls: a block that rocks at 0.2, rubble of 24, 28 and 30 stones, 13 voussoirs over 2.4 rad.

    And four whose sliding decides: the first rubble and a coursed wall with little friction, wall 4 of Ferris and
    Tin-Loi, whose published multipliers are 0.331 with dilatancy and 0.264 without, and a panel of squares on their
    corners between two piers.
    """
    flatness = {1: 1.3, 2: 1.6, 4: 1.6}
    walls = {k: rubble(Rubble(1.5, 1.2, stone=0.32, flatness=f, seed=k)) for k, f in flatness.items()}
    return {
        "block": column(0.2, 1.0, 1),
        **{f"rubble {k}": wall for k, wall in walls.items()},
        "rubble 1 friction 0.4": replace(walls[1], friction=0.4),
        "coursed friction 0.45": irregular_courses(IrregularCourses(0.8, 0.6, seed=2, friction=0.45)),
        "wall 4": read_blocks(HERE.parent / "tests" / "data" / "ferris_tinloi_wall4.json"),
        "panel": read_blocks(HERE.parent / "tests" / "data" / "reticulated_97_stones.json"),
        "arch": arch_on_piers(Arch(13, 1.0, 0.15, angle=2.4, friction=0.7, thickness=0.3)),
    }


def as_prisms(wall: Wall) -> SpaceWall:
    """Return the wall with its thickness along y."""
    axes = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, wall.thickness, 0.0]])
    blocks = tuple(
        SpaceBlock(k, prism(block.polygon, np.zeros(3), axes), block.fixed, block.unit_weight)
        for k, block in enumerate(wall.blocks)
    )
    return SpaceWall(wall.name, blocks, wall.friction, read_only(UPRIGHT))


def onset(motion: dict[str, np.ndarray], mass: np.ndarray) -> dict[str, float]:
    """Return onset (multiplier), participation and mass share of what moves, and how far from a line the root is.

    mass (b,) of the blocks, 0 for supports.
    """
    centre, multiplier = motion["centre"], motion["multiplier"]
    speed = np.linalg.norm(centre[SMOOTH:] - centre[:-SMOOTH], axis=2) / (SMOOTH * STEP)
    multiplier = 0.5 * (multiplier[SMOOTH:] + multiplier[:-SMOOTH])
    last = speed[-1]
    mean = mass @ last**2 / (mass @ last)
    part = np.where(last >= 0.1 * mean, mass, 0.0)
    root = np.sqrt(speed @ part / part.sum())
    first = np.flatnonzero(root < np.sqrt(0.1) * root[-1])[-1] + 1
    slope, start = np.polyfit(multiplier[first:], root[first:], 1)
    off = root[first:] - (slope * multiplier[first:] + start)
    return {
        "onset": -start / slope,
        "participation": (mass @ last) ** 2 / (mass.sum() * (mass @ last**2)),
        "mass_share": part.sum() / mass.sum(),
        "off_the_line": float(np.abs(off).max() / root[-1]),
    }


def compared(name: str, wall: Wall, python: str) -> Iterator[dict[str, Any]]:
    """Yield the rows of a wall: one for each ramp."""
    expected = refuse_what_cannot_be_analysed(find_joints(wall, JointSettings()), loads_on(wall)).load_multiplier
    found = stored(RESULTS / "lmgc90_plane" / f"{name}.json", lambda: pushed(wall, {}, expected))
    curve = np.array(found["curve"])
    highest = float(curve[curve[:, 3] == 0, 2].max())
    solid = as_prisms(wall)
    mass = np.where(solid.fixed, 0.0, solid.weights)
    until = MOVED * float(np.ptp([y for block in wall.blocks for y in block.polygon[:, 1]]))
    for seconds in (SECONDS, 2 * SECONDS) if name in SLOWLY else (SECONDS,):
        case = f"{name}_{seconds:g}".replace(" ", "_")
        motion = simulated(python, case, solid, (1.0, 0.0, 0.0), 1.1 * expected, seconds, REST, until)
        read = onset(motion, mass)
        yield {
            "wall": name,
            "stones": int((~solid.fixed).sum()),
            "not_convex": sum(not is_convex(block.polygon) for block in wall.blocks),
            "associative": round(expected, 5),
            "micro_FE": round(highest, 5),
            "micro_FE_fallen": found["fallen"],
            "micro_FE_first_fall": found["first_fall"],
            "micro_FE_end": found["end"],
            "ramp_s": f"{seconds:g}",
            "LMGC90": round(read["onset"], 5),
            "difference": round(highest / read["onset"] - 1.0, 5),
            "largest_base_shear": round(float(motion["shear"].max()), 5),
            "last_multiplier": round(float(motion["multiplier"][-1]), 5),
            "participation": round(read["participation"], 3),
            "mass_share": round(read["mass_share"], 3),
            "off_the_line": round(read["off_the_line"], 4),
        }


def is_convex(polygon: np.ndarray) -> bool:
    """Return whether a polygon (n, 2) has the area of its convex hull, to rounding."""
    shape = shapely.Polygon(polygon)
    return bool(shape.area > (1 - 1e-9) * shape.convex_hull.area)


def main() -> None:
    """Compare all walls named, or all; rows of other walls stay as they are."""
    file, of = HERE / "lmgc90_plane.csv", walls()
    rows: dict[tuple[str, str], dict[str, Any]] = {}
    if file.exists() and sys.argv[2:]:
        rows = {(row["wall"], row["ramp_s"]): row for row in csv.DictReader(file.open(encoding="utf-8"))}
    for name in sys.argv[2:] or list(of):
        for row in compared(name, of[name], sys.argv[1]):
            rows[name, row["ramp_s"]] = row
            print(row, flush=True)
            with file.open("w", newline="", encoding="utf-8") as out:
                writer = csv.DictWriter(out, list(row))
                writer.writeheader()
                writer.writerows(
                    sorted(rows.values(), key=lambda row: (list(of).index(row["wall"]), float(row["ramp_s"])))
                )


if __name__ == "__main__":
    main()
