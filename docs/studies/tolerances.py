"""How many macroblocks a wall needs: criteria (3) and (4) against the automatic choice, by limit analysis and FE.

    python docs/studies/tolerances.py

writes tolerances.csv and tolerances.md (tolerances_head.md with the tables put in) beside this file: walls of Ferris
and Tin-Loi, benchmarks 1 and 2, five random walls. The multiplier of the macroblocks as rigid bodies is that of the
full sequence of limit analysis; its excess over micro-LA's is what merging costs rigid bodies. Every partition is then
pushed (20 mm of the top, defaults of the case file, large displacements), a run is left after LIMIT s.
Times are CPU seconds of one rank: of choosing, without the limit analysis of every stone before it, and of the finite
elements. A run is kept in results/tolerances as soon as it is done and not run again: delete that folder when the
mechanics change.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path
from time import process_time
from typing import Any

from stored import RESULTS, followed, markdown, stored

from orchestrator import (
    Assemblage,
    JointSettings,
    LimitAnalysis,
    MacroblockSettings,
    MeshSettings,
    Partition,
    SteppingSettings,
    analyse,
    find_joints,
    make_bodies,
    merged,
    one_body_per_block,
    pushover_increments,
    read_blocks,
)
from orchestrator.macroblocks.automatic import chosen
from orchestrator.macroblocks.merged_blocks import merged_multiplier
from orchestrator.masonry.patterns import IrregularCourses, irregular_courses
from orchestrator.masonry.wall import Wall
from orchestrator.storage import write_csv, write_text

FOLDER = Path(__file__).parent
PROJECT = FOLDER.parents[1]
FILES = {
    **{f"Ferris and Tin-Loi, wall {number}": f"tests/data/ferris_tinloi_wall{number}.json" for number in (1, 3, 4)},
    "benchmark 1": "meshes/ferris_tinloi_wall6.json",
    "benchmark 2": "meshes/benchmark2.json",
}
OPENING = ((0.475, 0.925, 1.0, 1.7),)
TWO = ((0.5, 1.0, 0.0, 1.2), (1.6, 2.1, 0.6, 1.3))
RANDOM = (
    IrregularCourses(0.7, 1.4, seed=2),
    IrregularCourses(1.4, 1.0, widths=(0.2, 0.4), heights=(0.15, 0.2), friction=0.6, seed=4),
    IrregularCourses(2.0, 1.2, widths=(0.2, 0.4), heights=(0.15, 0.2), friction=0.5, seed=5),
    IrregularCourses(1.4, 2.8, openings=OPENING, widths=(0.18, 0.36), heights=(0.12, 0.18), seed=6),
    IrregularCourses(2.6, 1.8, openings=TWO, widths=(0.2, 0.4), heights=(0.15, 0.2), seed=7),
)
MARGINS = (0.01, 0.02, 0.05)
"""the first is the default"""
PAPER = MacroblockSettings(scale="unit_power", tol_n=2.5e-6, tol_d=0.45)
MESH = MeshSettings(size=0.2)
LIMIT = 240.0
"""CPU seconds of a pushover; micro-FE of benchmark 2 takes 50"""
COLUMNS = (
    "wall", "stones", "joints_of_wall", "macroblocks", "bodies", "joints", "contacts",
    "micro_LA", "micro_LA_range", "rigid_sequence", "peak", "peak_mm", "peak_over_micro",
    "contacts_over_micro", "choosing_s", "FE_s", "time_over_micro", "micro_LA_s", "end",
)  # fmt: skip
HEADS = (
    "wall", "macroblocks", "bodies", "joints", "contacts", "as rigid bodies: sequence", "FE peak",
    "of micro-FE", "choosing, s", "FE, s", "time of micro-FE",
)  # fmt: skip
HEADS_WORST = (
    "macroblocks", "bodies", "fewer bodies", "contacts of micro-FE", "peak of micro-FE", "largest error",
    "time of micro-FE",
)  # fmt: skip


def walls() -> Iterator[tuple[str, Wall]]:
    """Yield name and blocks of every wall."""
    for name, file in FILES.items():
        yield name, read_blocks(PROJECT / file)
    for pattern in RANDOM:
        yield f"random, seed {pattern.seed}", irregular_courses(pattern)


def partitions(assemblage: Assemblage, analysis: LimitAnalysis) -> Iterator[tuple[str, Partition, float]]:
    """Yield what is compared on one wall: name, partition, CPU seconds of choosing; every stone first."""
    yield "every stone", one_body_per_block(assemblage), 0.0
    mechanism = analysis.headline.mechanism
    yield "1e-3, 450 mm", merged(assemblage, mechanism, MacroblockSettings()), 0.0
    yield "2.5e-6 (N, m), 450 mm", merged(assemblage, mechanism, PAPER), 0.0
    for margin in MARGINS:
        began = process_time()
        partition = chosen(assemblage, analysis, margin)
        yield f"automatic, {margin:.0%}", partition, process_time() - began


def pushed(assemblage: Assemblage, partition: Partition) -> dict[str, Any]:
    """Return the figures of a partition's pushover, from results/tolerances if they are there."""

    def compute() -> dict[str, Any]:
        stepping = SteppingSettings(final_displacement=0.02)
        increments = pushover_increments(make_bodies(assemblage, partition), MESH, stepping=stepping)
        curve, contacts, seconds = followed(increments, stepping, LIMIT)
        moved = curve.control_displacement_m - curve.control_displacement_m[0]
        peak = int(curve.base_shear_N.argmax())
        return {
            "contacts": contacts,
            "peak_N": float(curve.base_shear_N[peak]),
            "peak_mm": 1e3 * float(moved[peak]),
            "FE_s": seconds,
            "end": curve.stopped_because,
        }

    return stored(kept_file(assemblage, partition), compute)


def kept_file(assemblage: Assemblage, partition: Partition) -> Path:
    """Return where the figures are kept: the name is a hash of the wall and of which stones make a body."""
    total = hashlib.sha256(partition.body_of_block.tobytes())
    for block in assemblage.wall.blocks:
        total.update(block.polygon.tobytes())
    total.update(repr((assemblage.wall.thickness, assemblage.joints.friction.tolist())).encode())
    return RESULTS / "tolerances" / f"{total.hexdigest()[:16]}.json"


def rows_of(name: str, wall: Wall) -> Iterator[dict[str, Any]]:
    """Yield the rows of one wall, that of every stone first."""
    assemblage = find_joints(wall, JointSettings())
    began = process_time()
    analysis = analyse(assemblage)
    analysed = process_time() - began
    micro = analysis.headline
    least, largest = analysis.non_associative_range or (micro.load_multiplier,) * 2
    reference: dict[str, Any] = {}
    for macroblocks, partition, choosing in partitions(assemblage, analysis):
        found = pushed(assemblage, partition)
        reference = reference or found
        rigid = merged_multiplier(assemblage, partition.body_of_block, "sequence")
        yield {
            "wall": name,
            "stones": sum(not block.fixed for block in wall.blocks),
            "joints_of_wall": assemblage.joints.count,
            "macroblocks": macroblocks,
            "bodies": partition.count,
            "joints": assemblage.joints.count - len(partition.vanished_joints),
            "contacts": found["contacts"],
            "micro_LA": micro.load_multiplier,
            "micro_LA_range": f"{least:.4f}-{largest:.4f}",
            "rigid_sequence": "" if rigid is None else rigid,
            "peak": found["peak_N"] / analysis.weight,
            "peak_mm": found["peak_mm"],
            "peak_over_micro": found["peak_N"] / reference["peak_N"],
            "contacts_over_micro": found["contacts"] / reference["contacts"],
            "choosing_s": choosing,
            "FE_s": found["FE_s"],
            "time_over_micro": (choosing + found["FE_s"]) / reference["FE_s"],
            "micro_LA_s": analysed,
            "end": found["end"],
        }


def worst(rows: list[dict[str, Any]]) -> list[list[str]]:
    """Return a line for each rule but every stone: least and largest of what is compared, over all walls."""
    lines = []
    for rule in dict.fromkeys(row["macroblocks"] for row in rows[1:] if row["bodies"] < row["stones"]):
        of_rule = [row for row in rows if row["macroblocks"] == rule]
        fewer = [1 - row["bodies"] / row["stones"] for row in of_rule]
        figures = [[row[name] for row in of_rule] for name in ("peak_over_micro", "contacts_over_micro")]
        ranges = [f"{min(found):.3f} to {max(found):.3f}" for found in figures]
        times = [row["time_over_micro"] for row in of_rule]
        bodies = [row["bodies"] for row in of_rule]
        lines.append(
            [
                rule,
                f"{min(bodies)} to {max(bodies)}",
                f"{min(fewer):.0%} to {max(fewer):.0%}",
                ranges[1],
                ranges[0],
                f"{max(abs(ratio - 1) for ratio in figures[0]):.1%}",
                f"{min(times):.2f} to {max(times):.2f}",
            ]
        )
    return lines


def line(row: dict[str, Any]) -> list[str]:
    """Return a row of the table of all walls."""
    rigid = "not settled" if row["rigid_sequence"] == "" else f"{row['rigid_sequence']:.4f}"
    return [
        row["wall"],
        row["macroblocks"],
        f"{row['bodies']} of {row['stones']}",
        f"{row['joints']} of {row['joints_of_wall']}",
        f"{row['contacts']}",
        f"{row['micro_LA']:.4f} ({row['micro_LA_range']})" if row["bodies"] == row["stones"] else rigid,
        f"{row['peak']:.4f}",
        f"{row['peak_over_micro']:.3f}",
        f"{row['choosing_s']:.1f}",
        f"{row['FE_s']:.1f}",
        f"{row['time_over_micro']:.2f}",
    ]


def write(rows: list[dict[str, Any]]) -> None:
    """Write tolerances.csv and tolerances.md."""
    write_csv(FOLDER / "tolerances.csv", COLUMNS, [[row[name] for name in COLUMNS] for row in rows])
    page = (FOLDER / "tolerances_head.md").read_text()
    page = page.replace("{{worst}}", markdown(HEADS_WORST, worst(rows)))
    write_text(FOLDER / "tolerances.md", page.replace("{{all}}", markdown(HEADS, [line(row) for row in rows])))


def main() -> None:
    """Write both anew after each row."""
    rows: list[dict[str, Any]] = []
    for name, wall in walls():
        for row in rows_of(name, wall):
            rows.append(row)
            print(" | ".join(line(row)), flush=True)
            write(rows)


if __name__ == "__main__":
    main()
