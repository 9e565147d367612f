"""How much the settings matter: elements, slip tolerance, load rate, increments, on a 5 x 10 running-bond wall.

    make verify        (or: .venv/bin/python docs/studies/sensitivity.py)

writes sensitivity.csv and, below sensitivity_head.md, sensitivity.md beside this file. Base shear over weight at 1 mm
and 5 mm of the top and its peak up to 10 mm in small displacements, initial stiffness as capacity.py defines it;
"change" is against the default settings. The limits of the mesh rows are Richardson's, from the two finest meshes,
error proportional to size squared.
"""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path
from time import perf_counter

import numpy as np
from mpi4py import MPI

from orchestrator.assessment.capacity import initial_stiffness
from orchestrator.macroblocks.bodies import make_bodies
from orchestrator.macroblocks.criteria import one_body_per_block
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.patterns import running_bond
from orchestrator.pushover.increments import PushoverCurve
from orchestrator.pushover.meshing import MeshSettings, mesh_bodies
from orchestrator.pushover.model import build_model
from orchestrator.pushover.path.stepping import Pushover
from orchestrator.pushover.settings import ContactSettings, ElasticSettings, NewtonSettings, SteppingSettings
from orchestrator.pushover.solve.linear_system import LinearSystem

HERE = Path(__file__).parent
BLOCK_HEIGHT = 0.175
DEFAULT = {
    "mesh": MeshSettings(size=0.2),
    "elastic": ElasticSettings(),
    "contact": ContactSettings(slip_tolerance=1e-6),
    "stepping": SteppingSettings(final_displacement=0.01),
}
QUADRATIC = {"elastic.element_order": 2}
MESHES = [{"mesh.size": BLOCK_HEIGHT / n} for n in (1, 2, 3, 4)]
VARIATIONS = [
    *MESHES,
    QUADRATIC,
    *(mesh | QUADRATIC for mesh in MESHES[:3]),
    {"mesh.matching_faces": True},
    *({"contact.slip_tolerance": value} for value in (1e-7, 1e-5, 1e-4)),
    *({"stepping.load_increment": value} for value in (0.01, 0.1)),
    *({"stepping.displacement_increment": value} for value in (0.005, 0.1)),
    *({"stepping.proximal_share": value} for value in (2e-5, 1e-3)),
]
"""what differs from the default, in case-file keys and SI units"""
COLUMNS = ("setting", "unknowns", "at 1 mm", "at 5 mm", "peak", "stiffness_kN_per_mm", "iterations", "seconds")


def curve_of(settings: dict) -> tuple[PushoverCurve, float, int]:
    """Return the curve, the weight in N and the number of unknowns."""
    assemblage = find_joints(running_bond(5, 10), JointSettings())
    bodies = make_bodies(assemblage, one_body_per_block(assemblage))
    meshes = mesh_bodies(bodies, settings["mesh"], None)
    model = build_model(bodies, meshes, settings["elastic"], settings["contact"])
    with LinearSystem(model, MPI.COMM_SELF) as system:
        increments = Pushover(model, system, NewtonSettings(), settings["stepping"]).increments()
        return PushoverCurve.from_increments(increments, "10 mm"), model.weight, model.unknowns


def row(changes: dict[str, float]) -> tuple:
    """Run once and return one row of the table."""
    began = perf_counter()
    settings = dict(DEFAULT)
    for key, value in changes.items():
        group, name = key.split(".")
        settings[group] = replace(settings[group], **{name: value})
    curve, weight, unknowns = curve_of(settings)
    moved = curve.control_displacement_m - curve.control_displacement_m[0]
    at = [float(np.interp(place, moved, curve.base_shear_N)) / weight for place in (1e-3, 5e-3)]
    peak = float(curve.base_shear_N[moved <= 0.0101].max()) / weight
    stiffness = initial_stiffness(curve.base_shear_N, moved) / 1e6
    label = ", ".join(f"{key} = {value:.4g}" for key, value in changes.items()) or "default"
    iterations = int(curve.newton_iterations.sum())
    return (label, unknowns, *at, peak, stiffness, iterations, perf_counter() - began)


def extrapolated(label: str, coarse: tuple, fine: tuple, ratio: float) -> tuple:
    """Return Richardson's limit of two mesh rows whose sizes are as `ratio`, error proportional to size squared."""
    limits = [f + (f - c) / (ratio**2 - 1) for c, f in zip(coarse[2:6], fine[2:6], strict=True)]
    return (label, "", *limits, "", "")


def main() -> None:
    """Run everything and write the tables."""
    rows = [row({})]
    for changes in VARIATIONS:
        rows.append(row(changes))
        print(rows[-1], flush=True)
    linear, quadratic = rows[1:5], rows[6:9]
    rows.insert(9, extrapolated("10-node, size to 0", *quadratic[-2:], 3 / 2))
    rows.insert(5, extrapolated("4-node, size to 0", *linear[-2:], 4 / 3))
    with (HERE / "sensitivity.csv").open("w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([COLUMNS, *rows])
    head = (HERE / "sensitivity_head.md").read_text()
    (HERE / "sensitivity.md").write_text(head + "\n".join(table(rows)) + "\n")


def table(rows: list[tuple]) -> list[str]:
    """Return the table as Markdown."""
    default = rows[0]
    lines = [
        "| setting | unknowns | V/W at 1 mm | at 5 mm | peak | change | stiffness kN/mm | change | iterations | s |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for label, unknowns, at_1, at_5, peak, stiffness, iterations, seconds in rows:
        changes = f"{peak / default[4] - 1:+.1%}", f"{stiffness / default[5] - 1:+.1%}"
        took = f"{seconds:.0f}" if seconds != "" else ""
        lines.append(
            f"| {label} | {unknowns} | {at_1:.4f} | {at_5:.4f} | {peak:.4f} | {changes[0]} | {stiffness:.2f} "
            f"| {changes[1]} | {iterations} | {took} |"
        )
    return lines


if __name__ == "__main__":
    main()
