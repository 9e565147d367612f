"""How much the settings matter: mesh, slip tolerance, load rate, increments, on a 5 x 10 running-bond wall.

    make verify        (or: .venv/bin/python docs/studies/sensitivity.py)

writes sensitivity.csv and sensitivity.md beside this file. Base shear over weight at 1 mm and 5 mm of the top and its
peak up to 10 mm, initial stiffness as capacity.py defines it; "change" is against the default settings.
"""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path
from time import perf_counter

import numpy as np
from mpi4py import MPI

from orchestrator.bodies import make_bodies
from orchestrator.capacity import initial_stiffness
from orchestrator.joints import JointSettings, find_joints
from orchestrator.macroblocks import one_body_per_block
from orchestrator.masonry.patterns import running_bond
from orchestrator.meshing import MeshSettings, mesh_bodies
from orchestrator.pushover.linear_system import LinearSystem
from orchestrator.pushover.model import build_model
from orchestrator.pushover.settings import ContactSettings, ElasticSettings, NewtonSettings, SteppingSettings
from orchestrator.pushover.state import PushoverCurve
from orchestrator.pushover.stepping import Pushover

HERE = Path(__file__).parent
BLOCK_HEIGHT = 0.175
DEFAULT = {
    "mesh": MeshSettings(size=0.2),
    "contact": ContactSettings(),
    "stepping": SteppingSettings(final_displacement=0.01),
}
VARIATIONS = [
    *(("mesh", "size", f"{n} per block height", BLOCK_HEIGHT / n) for n in (1, 2, 3, 4)),
    *(("contact", "slip_tolerance", f"{value:g} mm", value * 1e-3) for value in (1e-4, 1e-2, 1e-1)),
    *(("stepping", "load_rate", f"{value:g} 1/s", value) for value in (0.05, 0.8)),
    *(("stepping", "displacement_increment", f"{value:g} mm", value * 1e-3) for value in (0.1, 2.0)),
    *(("stepping", "proximal_time", f"{value:g} s", value) for value in (0.3, 3.0)),
]
COLUMNS = ("setting", "value", "nodes", "at 1 mm", "at 5 mm", "peak", "stiffness_kN_per_mm", "iterations", "seconds")


def curve_of(settings: dict) -> tuple[PushoverCurve, float, int]:
    """Return the curve, the weight in N and the number of nodes."""
    assemblage = find_joints(running_bond(5, 10), JointSettings())
    bodies = make_bodies(assemblage, one_body_per_block(assemblage))
    meshes = mesh_bodies(bodies, settings["mesh"], None)
    model = build_model(bodies, meshes, ElasticSettings(), settings["contact"], 1, MPI.COMM_SELF)
    with LinearSystem(model, MPI.COMM_SELF) as system:
        increments = Pushover(model, system, NewtonSettings(), settings["stepping"]).increments()
        return PushoverCurve.from_increments(increments, "10 mm"), model.weight, len(meshes.nodes)


def row(setting: str, value: str, settings: dict) -> tuple:
    """Run once and return one row of the table."""
    began = perf_counter()
    curve, weight, nodes = curve_of(settings)
    moved = curve.control_displacement_m - curve.control_displacement_m[0]
    at = [float(np.interp(place, moved, curve.base_shear_N)) / weight for place in (1e-3, 5e-3)]
    peak = float(curve.base_shear_N[moved <= 0.0101].max()) / weight
    stiffness = initial_stiffness(curve.base_shear_N, moved) / 1e6
    return (setting, value, nodes, *at, peak, stiffness, int(curve.newton_iterations.sum()), perf_counter() - began)


def extrapolated(rows: list[tuple], column: int) -> float:
    """Return Richardson's limit of the mesh rows, error proportional to size squared (two finest meshes)."""
    coarse, fine = rows[-2][column], rows[-1][column]
    ratio = (4 / 3) ** 2
    return fine + (fine - coarse) / (ratio - 1)


def main() -> None:
    """Run everything and write the tables."""
    rows = [row("default", "", DEFAULT)]
    for group, name, label, value in VARIATIONS:
        rows.append(row(f"{group}.{name}", label, DEFAULT | {group: replace(DEFAULT[group], **{name: value})}))
        print(rows[-1], flush=True)
    mesh = [r for r in rows if r[0] == "mesh.size"]
    limits = [extrapolated(mesh, column) for column in range(3, 7)]
    rows.append(("mesh.size", "extrapolated to 0", "", *limits, "", ""))
    with (HERE / "sensitivity.csv").open("w", newline="") as file:
        csv.writer(file).writerows([COLUMNS, *rows])
    (HERE / "sensitivity.md").write_text("\n".join(table(rows)) + "\n")


def table(rows: list[tuple]) -> list[str]:
    """Return the table as Markdown."""
    default = rows[0]
    lines = [
        "| setting | value | nodes | V/W at 1 mm | at 5 mm | peak | change of peak | stiffness kN/mm | change | s |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for r in rows:
        seconds = f"{r[8]:.0f}" if r[8] != "" else ""
        lines.append(
            f"| {r[0]} | {r[1]} | {r[2]} | {r[3]:.4f} | {r[4]:.4f} | {r[5]:.4f} | {r[5] / default[5] - 1:+.1%} "
            f"| {r[6]:.2f} | {r[6] / default[6] - 1:+.1%} | {seconds} |"
        )
    return lines


if __name__ == "__main__":
    main()
