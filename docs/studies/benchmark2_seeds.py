"""Benchmark 2 drawn with other seeds: what limit analysis, the automatic macroblocks and finite elements say.

    python docs/studies/benchmark2_seeds.py [seeds to push]

writes benchmark2_seeds.md (benchmark2_seeds_head.md with the table put in) beside this file. Finite elements as in
tolerances.py, kept in results/tolerances; only seeds that are named are pushed (a minute each), or were before. The
walls are those of meshes/make_benchmark2.py, not rounded; templates/benchmark2.toml has seed 4, rounded to 0.1 mm.
"""

from __future__ import annotations

import runpy
import sys
from collections.abc import Iterable
from dataclasses import replace

from stored import markdown
from tolerances import FOLDER, MARGINS, PROJECT, kept_file, pushed

from orchestrator import Assemblage, JointSettings, Partition, analyse, find_joints, one_body_per_block
from orchestrator.macroblocks.automatic import chosen
from orchestrator.masonry.patterns import irregular_courses
from orchestrator.storage import write_text

SEEDS = (1, 2, 3, 4, 5)
HEADS = (
    "seed", "stones", "associative", "sequence", "met by loading", "non-associative range", "bodies chosen",
    "FE peak, every stone", "of the bodies", "ratio",
)  # fmt: skip


def row(seed: int, push: bool) -> list[str]:
    """Return the line of one seed."""
    pattern = runpy.run_path(str(PROJECT / "meshes" / "make_benchmark2.py"))["PATTERN"]
    assemblage = find_joints(irregular_courses(replace(pattern, seed=seed)), JointSettings())
    analysis = analyse(assemblage)
    partition = chosen(assemblage, analysis, MARGINS[0])
    settled = [
        f"{state.load_multiplier:.4f}" if state is not None and state.converged else "not settled"
        for state in (analysis.sequence, analysis.path)
    ]
    least, largest = analysis.non_associative_range or (analysis.headline.load_multiplier,) * 2
    stones = sum(not block.fixed for block in assemblage.wall.blocks)
    found = [str(seed), str(stones), f"{analysis.associative.load_multiplier:.4f}", *settled]
    found += [f"{least:.4f}-{largest:.4f}", str(partition.count)]
    micro, macro = (
        _peak(assemblage, some, push, analysis.weight) for some in (one_body_per_block(assemblage), partition)
    )
    ratio = f"{macro / micro:.3f}" if micro and macro else ""
    return [*found, *(f"{peak:.4f}" if peak else "" for peak in (micro, macro)), ratio]


def _peak(assemblage: Assemblage, partition: Partition, push: bool, weight: float) -> float | None:
    known = push or kept_file(assemblage, partition).exists()
    return pushed(assemblage, partition)["peak_N"] / weight if known else None


def main(named: Iterable[str]) -> None:
    """Write the page anew after each seed."""
    lines = []
    for seed in SEEDS:
        lines.append(row(seed, str(seed) in named))
        print(" | ".join(lines[-1]), flush=True)
        page = (FOLDER / "benchmark2_seeds_head.md").read_text()
        write_text(FOLDER / "benchmark2_seeds.md", page.replace("{{seeds}}", markdown(HEADS, lines)))


if __name__ == "__main__":
    main(sys.argv[1:])
