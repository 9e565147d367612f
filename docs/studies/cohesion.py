"""Are macroblocks stiffer before the peak because micro-FE has more joints that open, and does cohesion remove that?

    python docs/studies/cohesion.py

writes cohesion_WALL.csv and cohesion.md (cohesion_head.md and the tables) beside this file. One wall, macroblocks and
every stone, with joints of growing cohesion and a tensile strength of half of it, which soften over 0.2 mm. The
macroblocks are those of the dry wall throughout, so that nothing but the joints differs. Base shear over weight,
displacements of the top from the state under gravity; "secant" is at the base shear that half the dry wall's multiplier
of limit analysis makes; times are CPU seconds. A run is kept in results/cohesion as soon as it is done and not run
again: delete that folder when the mechanics change.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
from stored import RESULTS, followed, markdown, stored

from orchestrator import (
    Case,
    JointClass,
    JointSettings,
    Partition,
    SteppingSettings,
    find_joints,
    make_bodies,
    one_body_per_block,
    pushover_increments,
    read_case,
)
from orchestrator.app.driver import segment
from orchestrator.app.segmented import Segmented
from orchestrator.assessment.capacity import initial_stiffness
from orchestrator.storage import write_csv, write_text

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
TOLERANCES = ("macroblocks.tol_n=1e-3", "macroblocks.tol_d=450 mm")
END = 2e-3
"""m"""
PLACES = (1e-4, 2e-4, 5e-4, 1e-3)
"""displacements of the top at which the base shear is compared, m"""
COLUMNS = (
    "cohesion_kPa", "model", "bodies", "initial_kN_per_mm", "secant_kN_per_mm",
    *(f"at_{1e3 * place:g}_mm" for place in PLACES), "peak", "peak_at_mm", "ended_at_mm", "increments", "seconds",
    "end",
)  # fmt: skip
RATIOS = ("initial_kN_per_mm", "secant_kN_per_mm", "peak")


def run(case: Case, segmented: Segmented, model: str, partition: Partition, cohesion: float) -> dict[str, object]:
    """Push the wall with bonded joints (cohesion in Pa) and return its row of the table; the curve may stop early."""
    bond = JointClass(cohesion=cohesion, tensile_strength=cohesion / 2)
    bodies = make_bodies(find_joints(segmented.assemblage.wall, JointSettings(classes=(bond,))), partition)
    stepping = SteppingSettings(final_displacement=END)
    increments = pushover_increments(
        bodies, case.mesh, case.elastic, case.contact, case.newton, stepping, tuple(case.load.vector)
    )
    curve, _, seconds = followed(increments, stepping)
    weight, level = segmented.analysis.weight, segmented.analysis.headline.load_multiplier / 2
    moved = curve.control_displacement_m - curve.control_displacement_m[0]
    shear = curve.base_shear_N
    peak = int(shear.argmax())
    reached = float(np.interp(level * weight, shear[: peak + 1], moved[: peak + 1]))
    at = [float(np.interp(place, moved, shear)) / weight if moved[-1] >= place else "" for place in PLACES]
    values = (
        cohesion / 1e3, model, partition.count, initial_stiffness(shear, moved) / 1e6, level * weight / reached / 1e6,
        *at, float(shear[peak]) / weight, 1e3 * float(moved[peak]), 1e3 * float(moved[-1]), len(shear), seconds,
        curve.stopped_because,
    )  # fmt: skip
    return dict(zip(COLUMNS, values, strict=True))


def study(name: str) -> list[dict[str, object]]:
    """Return the rows of one wall: every cohesion, macroblocks and every stone."""
    _, file, overrides, cohesions = WALLS[name]
    case = read_case(file, (*TOLERANCES, *overrides))
    segmented = segment(case)
    partitions = {"macro": segmented.partition, "micro": one_body_per_block(segmented.assemblage)}
    rows = []
    for cohesion in cohesions:
        for model, partition in partitions.items():
            kept = RESULTS / "cohesion" / f"{name}_{cohesion / 1e3:g}_kPa_{model}.json"
            compute = partial(run, case, segmented, model, partition, cohesion)
            rows.append(stored(kept, compute))
            print(name, rows[-1], flush=True)
    return rows


def tables(rows: list[dict[str, object]]) -> str:
    """Return the table of a wall and that of its ratios in Markdown."""
    heads = ["cohesion kPa", "model", "bodies", "initial kN/mm", "secant kN/mm"]
    heads += [f"V/W at {1e3 * place:g} mm" for place in PLACES] + ["peak", "at mm", "ended at mm", "increments", "s"]
    forms = ("g", "", "", ".1f", ".2f", *[".4f"] * (len(PLACES) + 1), ".2f", ".2f", "", ".1f")
    lines = [
        [format(row[name], form) if row[name] != "" else "" for name, form in zip(COLUMNS, forms, strict=False)]
        for row in rows
    ]
    ratios = [
        [f"{macro['cohesion_kPa']:g}", *(f"{macro[name] / micro[name]:.3f}" for name in RATIOS)]
        for macro, micro in zip(rows[::2], rows[1::2], strict=True)
    ]
    heads_of_ratios = ["cohesion kPa", "initial, macro/micro", "secant, macro/micro", "peak, macro/micro"]
    return f"{markdown(heads, lines)}\n\n{markdown(heads_of_ratios, ratios)}"


def main() -> None:
    """Run all walls and write the page."""
    page = (HERE / "cohesion_head.md").read_text()
    for name, (title, *_) in WALLS.items():
        rows = study(name)
        write_csv(HERE / f"cohesion_{name}.csv", COLUMNS, [list(row.values()) for row in rows])
        page += f"\n## {title}\n\n{tables(rows)}\n"
    write_text(HERE / "cohesion.md", page)


if __name__ == "__main__":
    main()
