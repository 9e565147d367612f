"""How many macroblocks a wall needs: criteria (3) and (4) against the automatic choice, by the rigid-body multiplier.

    python docs/studies/tolerances.py

writes tolerances.csv and tolerances.md beside this file: benchmarks 1 and 2 and five random walls. The multiplier of
the macroblocks as rigid bodies is that of the full sequence of limit analysis; its excess over micro-LA's is what
merging costs; the dilation shift may find another state of the same bodies. Times are those of choosing, without the
limit analysis of every stone before it (last column).
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path
from time import perf_counter

from orchestrator import case as cases
from orchestrator import driver
from orchestrator.automatic import chosen
from orchestrator.joints import Assemblage, JointSettings, find_joints
from orchestrator.limit_analysis import LimitAnalysis, LimitAnalysisSettings, analyse
from orchestrator.limit_analysis.merged_blocks import merged_multiplier
from orchestrator.macroblocks import MacroblockSettings, Partition, merged
from orchestrator.masonry.patterns import IrregularCourses, irregular_courses

FOLDER = Path(__file__).parent
TEMPLATES = FOLDER.parents[1] / "templates"
OPENING = ((0.475, 0.925, 1.0, 1.7),)
TWO = ((0.5, 1.0, 0.0, 1.2), (1.6, 2.1, 0.6, 1.3))
RANDOM = [
    IrregularCourses(0.7, 1.4, seed=2),
    IrregularCourses(1.4, 1.0, widths=(0.2, 0.4), heights=(0.15, 0.2), friction=0.6, seed=4),
    IrregularCourses(2.0, 1.2, widths=(0.2, 0.4), heights=(0.15, 0.2), friction=0.5, seed=5),
    IrregularCourses(1.4, 2.8, openings=OPENING, widths=(0.18, 0.36), heights=(0.12, 0.18), seed=6),
    IrregularCourses(2.6, 1.8, openings=TWO, widths=(0.2, 0.4), heights=(0.15, 0.2), seed=7),
]
MARGINS = (0.01, 0.02, 0.05)
PAPER = MacroblockSettings(scale="unit_power", normal=2.5e-6, centre_distance=0.45)


def walls() -> Iterator[tuple[str, Assemblage, LimitAnalysis]]:
    """Yield name, joints and micro limit analysis of every wall."""
    for name in ("benchmark1", "benchmark2"):
        yield name, *driver.limit(cases.read(TEMPLATES / f"{name}.toml"))
    for pattern in RANDOM:
        assemblage = find_joints(irregular_courses(pattern), JointSettings())
        yield f"random, seed {pattern.seed}", assemblage, analyse(assemblage)


def row(
    wall: str, rule: str, assemblage: Assemblage, analysis: LimitAnalysis, partition: Partition, seconds: float
) -> dict[str, object]:
    """Return one row of the table."""
    micro = analysis.headline
    rigid, shift = (
        merged_multiplier(assemblage, partition.body_of_block, 1, rule) for rule in (micro.flow_rule, "dilation_shift")
    )
    return {
        "wall": wall,
        "stones": sum(not block.fixed for block in assemblage.wall.blocks),
        "joints": len(assemblage.block_i),
        "micro-LA": f"{micro.load_multiplier:.4f} ({micro.flow_rule.replace('_', ' ')})",
        "macroblocks": rule,
        "bodies": partition.count,
        "joints left": len(assemblage.block_i) - len(partition.vanished_joints),
        "rigid multiplier": f"{rigid:.4f}" if rigid is not None else "not settled",
        "excess, %": f"{100 * (rigid / micro.load_multiplier - 1):+.2f}" if rigid is not None else "",
        "by the dilation shift": f"{shift:.4f}" if shift is not None else "not settled",
        "time, s": f"{seconds:.1f}",
        "micro-LA, s": f"{analysis.seconds:.1f}",
    }


def rows() -> Iterator[dict[str, object]]:
    """Yield all rows, wall by wall."""
    for wall, assemblage, analysis in walls():
        mechanism = analysis.headline.mechanism
        for rule, criteria in (("defaults", MacroblockSettings()), ("2.5e-6 (N, m), 450 mm", PAPER)):
            yield row(wall, rule, assemblage, analysis, merged(assemblage, mechanism, criteria), 0.0)
        for margin in MARGINS:
            began = perf_counter()
            partition = chosen(assemblage, analysis, LimitAnalysisSettings(), margin)
            seconds = perf_counter() - began
            yield row(wall, f"automatic, {margin:.0%}", assemblage, analysis, partition, seconds)


def main() -> None:
    """Write both tables anew after each row."""
    done: list[dict[str, object]] = []
    for found in rows():
        done.append(found)
        print(", ".join(f"{name} {value}" for name, value in found.items()), flush=True)
        write(done)


def write(done: list[dict[str, object]]) -> None:
    """Write tolerances.csv and tolerances.md."""
    with (FOLDER / "tolerances.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, done[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(done)
    names = list(done[0])
    lines = [names, ["---"] * len(names), *([str(line[name]) for name in names] for line in done)]
    table = "\n".join(f"| {' | '.join(line)} |" for line in lines)
    title = "# Macroblocks by tolerances and by themselves\n\nMade by `python docs/studies/tolerances.py`."
    (FOLDER / "tolerances.md").write_text(f"{title}\n\n{table}\n")


if __name__ == "__main__":
    main()
