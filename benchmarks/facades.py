"""What facades of about 500 and 1,100 irregular stones cost: limit analysis, macroblocks, every stone (CPU seconds).

    python benchmarks/facades.py

Each facade has openings in two storeys and is pushed along +x with the defaults and the meshes of `run`, to its default
end. (That the base shear is 2 % below its largest is no sign of a peak: every stone of the larger one falls by 6 % at
0.273, and goes on to 0.284.) Writes facades.csv beside this file.
"""

from __future__ import annotations

import csv
from pathlib import Path
from time import process_time
from typing import Any

from mpi4py import MPI

from orchestrator import (
    ContactSettings,
    ElasticSettings,
    JointSettings,
    MeshSettings,
    NewtonSettings,
    SteppingSettings,
    analyse,
    find_joints,
    macroblocks_of,
    make_bodies,
    one_body_per_block,
    push,
    push_and_refine,
)
from orchestrator.limit_analysis import LimitAnalysis
from orchestrator.limit_analysis.turning_joints import pressed_at_hinges
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.patterns import IrregularCourses, irregular_courses
from orchestrator.pushover.increments import end_of_curve
from orchestrator.pushover.meshing import mesh_bodies
from orchestrator.pushover.model import build_model
from orchestrator.pushover.path.stepping import Pushover
from orchestrator.pushover.solve.linear_system import LinearSystem

HERE = Path(__file__).resolve().parent
OF_500 = ((1.2, 2.2, 1.1, 2.7), (3.2, 4.2, 0.0, 2.4), (5.2, 6.2, 1.1, 2.7), (1.2, 2.2, 3.8, 5.2), (5.2, 6.2, 3.8, 5.2))
OF_1100 = (
    (1.4, 2.4, 1.1, 2.8), (5.0, 6.0, 0.0, 2.6), (8.6, 9.6, 1.1, 2.8), (1.4, 2.4, 4.3, 5.9), (5.0, 6.0, 4.3, 5.9),
    (8.6, 9.6, 4.3, 5.9),
)  # fmt: skip
STONES: dict[str, Any] = {"widths": (0.2, 0.5), "heights": (0.15, 0.25), "seed": 1}
FACADES = {
    "two storeys": IrregularCourses(7.4, 6.2, openings=OF_500, **STONES),
    "two high storeys": IrregularCourses(11.0, 8.4, openings=OF_1100, **STONES),
}


def every_stone(assemblage: Assemblage, analysis: LimitAnalysis) -> dict[str, Any]:
    """Push every stone; return CPU seconds in all and to the peak, Newton iterations, peak over the weight, and what
    ended it."""
    began, expected = process_time(), analysis.expected_multiplier
    forces, hinges = analysis.headline.joint_forces, pressed_at_hinges(assemblage, analysis)
    bodies = make_bodies(assemblage, one_body_per_block(assemblage), forces, hinges=hinges)
    model = build_model(bodies, mesh_bodies(bodies, MeshSettings(), None), ElasticSettings(), ContactSettings(), True)
    iterations, stepping, peak, to_peak = 0, SteppingSettings(), 0.0, 0.0
    with LinearSystem(model, MPI.COMM_SELF) as system:
        for here in Pushover(model, system, NewtonSettings(), stepping, expected).increments():
            iterations += here.iterations + sum(attempt.iterations for attempt in here.attempts)
            if here.largest_base_shear > peak:
                peak, to_peak = here.largest_base_shear, process_time() - began
    return {
        "every_stone_s": process_time() - began,
        "to_the_peak_s": to_peak,
        "iterations": iterations,
        "peak": peak / model.weight,
        "every_stone_ended": end_of_curve(here, stepping, model.height) or "",
    }


def measured(name: str) -> dict[str, Any]:
    """Return the row of a facade."""
    assemblage, began = find_joints(irregular_courses(FACADES[name]), JointSettings()), process_time()
    analysis = analyse(assemblage)
    analysed = process_time()
    partition = macroblocks_of(assemblage, analysis)
    chosen = process_time()
    partition, done = push_and_refine(
        assemblage, analysis, partition, lambda bodies, suffices: push(assemblage, analysis, bodies, suffices=suffices)
    )
    row = {
        "facade": name,
        "stones": sum(not block.fixed for block in assemblage.wall.blocks),
        "limit_analysis_s": analysed - began,
        "choice_s": chosen - analysed,
        "macroblocks": partition.count,
        "macroblocks_s": process_time() - chosen,
        "headline": analysis.headline.load_multiplier,
        "macroblocks_peak": done.capacity.peak_base_shear / analysis.weight,
        "valid": done.summary.valid,
    }
    return row | every_stone(assemblage, analysis)


def main() -> None:
    """Measure both facades and write their table after each."""
    rows = list[dict[str, Any]]()
    for name in FACADES:
        rows.append(measured(name))
        print(rows[-1], flush=True)
        with (HERE / "facades.csv").open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
            writer.writeheader()
            writer.writerows({key: f"{v:.4g}" if isinstance(v, float) else v for key, v in row.items()} for row in rows)


if __name__ == "__main__":
    main()
