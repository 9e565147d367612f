"""Are macroblocks stiffer before the peak because micro-FE has more joints that open, and does cohesion remove that?

    .venv/bin/python docs/studies/cohesion.py [wall1 wall1_tenth benchmark1]

writes cohesion_WALL.csv and the tables in cohesion.md beside this file. One wall, macroblocks and every stone, with
joints of growing cohesion and a tensile strength of half of it, which soften over 0.2 mm. The macroblocks are those of
the dry wall throughout, so that nothing but the joints differs. Base shear over weight, displacements of the top from
the state under gravity; "secant" is at the base shear that half the dry wall's multiplier of limit analysis makes.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path
from time import perf_counter

import numpy as np
from mpi4py import MPI

from orchestrator import case as cases
from orchestrator import driver
from orchestrator.bodies import make_bodies
from orchestrator.capacity import initial_stiffness
from orchestrator.errors import CollapseError, ConvergenceError
from orchestrator.joints import JointClass, JointSettings, find_joints
from orchestrator.macroblocks import Partition, one_body_per_block
from orchestrator.masonry.wall import Wall
from orchestrator.meshing import mesh_bodies
from orchestrator.pushover.linear_system import LinearSystem
from orchestrator.pushover.model import build_model
from orchestrator.pushover.settings import SteppingSettings
from orchestrator.pushover.state import Increment, PushoverCurve
from orchestrator.pushover.stepping import Pushover

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
WALL_1 = ROOT / "tests/data/ferris_tinloi_wall1.json"
WALLS = {
    "wall1": ("Wall 1", WALL_1, (), (0.0, 1e3, 5e3, 20e3, 100e3)),
    "wall1_tenth": (
        "Wall 1, slip tolerance 0.0001 mm",
        WALL_1,
        ("contact.slip_tolerance=0.0001 mm",),
        (0.0, 5e3, 20e3),
    ),
    "benchmark1": ("Benchmark 1 (wall 6)", ROOT / "templates/benchmark1.toml", (), (0.0, 1e3, 5e3)),
}
"""title, file, overrides, cohesions in Pa"""
END = 2e-3
"""m"""
PLACES = (1e-4, 2e-4, 5e-4, 1e-3)
"""displacements of the top at which the base shear is compared, m"""
COLUMNS = (
    "cohesion_kPa", "model", "bodies", "initial_kN_per_mm", "secant_kN_per_mm",
    *(f"at_{1e3 * place:g}_mm" for place in PLACES), "peak", "peak_at_mm", "ended_at_mm", "increments", "seconds",
)  # fmt: skip


def curve_of(case: cases.Case, wall: Wall, partition: Partition, cohesion: float) -> tuple[PushoverCurve, float]:
    """Return the curve and the weight in N of a wall with bonded joints; the curve may stop early."""
    bond = JointClass(cohesion=cohesion, tensile_strength=cohesion / 2)
    assemblage = find_joints(wall, JointSettings(classes=(bond,)))
    bodies = make_bodies(assemblage, partition)
    meshes = mesh_bodies(bodies, case.mesh, None)
    stepping = SteppingSettings(final_displacement=END)
    model = build_model(bodies, meshes, case.elastic, case.contact, case.load.sign, MPI.COMM_SELF, True)
    increments: list[Increment] = []
    with LinearSystem(model, MPI.COMM_SELF) as system:
        try:
            for increment in Pushover(model, system, case.newton, stepping).increments():
                increments.append(increment)
        except (ConvergenceError, CollapseError) as error:
            print(f"  {error}")
    return PushoverCurve.from_increments(increments, "end"), model.weight


def row(cohesion: float, name: str, bodies: int, curve: PushoverCurve, weight: float, level: float) -> dict:
    """Return one row of the table; `level` of base shear over weight where the secant is taken."""
    moved = curve.control_displacement_m - curve.control_displacement_m[0]
    shear = curve.base_shear_N
    peak = int(shear.argmax())
    reached = float(np.interp(level * weight, shear[: peak + 1], moved[: peak + 1]))
    at = [float(np.interp(place, moved, shear)) / weight if moved[-1] >= place else None for place in PLACES]
    values = (
        cohesion / 1e3, name, bodies, initial_stiffness(shear, moved) / 1e6, level * weight / reached / 1e6,
        *at, shear[peak] / weight, 1e3 * moved[peak], 1e3 * moved[-1], len(shear),
    )  # fmt: skip
    return dict(zip(COLUMNS, values, strict=False))


def study(name: str) -> list[dict]:
    """Run one wall with every cohesion, macroblocks and every stone."""
    _, file, overrides, cohesions = WALLS[name]
    case = cases.read(file, overrides)
    segmented = driver.segment(case)
    wall = segmented.assemblage.wall
    level = segmented.analysis.headline.load_multiplier / 2
    partitions = {"macro": segmented.partition, "micro": one_body_per_block(segmented.assemblage)}
    rows = []
    for cohesion in cohesions:
        for model, partition in partitions.items():
            began = perf_counter()
            curve, weight = curve_of(case, wall, partition, cohesion)
            rows.append(row(cohesion, model, partition.count, curve, weight, level))
            rows[-1]["seconds"] = round(perf_counter() - began)
            print(name, rows[-1], flush=True)
            with (HERE / f"cohesion_{name}.csv").open("w", newline="") as file:
                writer = csv.DictWriter(file, COLUMNS)
                writer.writeheader()
                writer.writerows(rows)
    return rows


def table(name: str) -> str:
    """Return the table of a wall in Markdown from its CSV file."""
    with (HERE / f"cohesion_{name}.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    heads = ["cohesion kPa", "model", "bodies", "initial kN/mm", "secant kN/mm"]
    heads += [f"V/W at {1e3 * place:g} mm" for place in PLACES] + ["peak", "at mm", "increments", "s"]
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    for found in rows:
        numbers = [f"{float(found[c]):.4f}" if found[c] else "" for c in (*COLUMNS[5:9], "peak")]
        cells = [
            f"{float(found['cohesion_kPa']):g}", found["model"], found["bodies"],
            f"{float(found['initial_kN_per_mm']):.1f}", f"{float(found['secant_kN_per_mm']):.2f}", *numbers,
            f"{float(found['peak_at_mm']):.2f}", found["increments"], found["seconds"],
        ]  # fmt: skip
        lines.append("| " + " | ".join(cells) + " |")
    lines += [
        "",
        "| cohesion kPa | initial, macro/micro | secant, macro/micro | peak, macro/micro |",
        "|---|---|---|---|",
    ]
    for macro, micro in zip(rows[::2], rows[1::2], strict=False):
        shares = [float(macro[c]) / float(micro[c]) for c in ("initial_kN_per_mm", "secant_kN_per_mm", "peak")]
        lines.append(f"| {float(macro['cohesion_kPa']):g} | " + " | ".join(f"{share:.3f}" for share in shares) + " |")
    return "\n".join(lines)


def main(names: list[str]) -> None:
    """Run the walls named, or all, and write the page."""
    for name in names:
        study(name)
    parts = [(HERE / "cohesion_head.md").read_text()]
    for name, (title, *_) in WALLS.items():
        if (HERE / f"cohesion_{name}.csv").exists():
            parts.append(f"## {title}\n\n{table(name)}\n")
    (HERE / "cohesion.md").write_text("\n".join(parts))


if __name__ == "__main__":
    main(sys.argv[1:] or list(WALLS))
