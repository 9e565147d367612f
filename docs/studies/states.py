"""Headline of limit analysis against the peak of micro-FE: walls of robustness.py both ways, and of path.py.

    python docs/studies/states.py [number of walls] [--without-geometry]

writes states.csv and states.md (after states_head.md) beside this file; without large displacements it says the outcome
only. Peaks are read from robustness.csv and path.csv, where they were computed.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterator
from itertools import chain, islice
from pathlib import Path
from time import process_time

import numpy as np
import path
from robustness import WALLS

from orchestrator.limit_analysis import LimitAnalysisSettings, analyse
from orchestrator.limit_analysis.remarks import closes_joints
from orchestrator.loads import LoadSettings, loads_on
from orchestrator.masonry.joints import Assemblage, JointSettings, find_joints
from orchestrator.masonry.patterns import irregular_courses

FOLDER = Path(__file__).parent
NEAR, ABOVE = 0.015, 0.03
"""Parts of the peak: a headline this near counts as right; no headline may lie further above."""


def compared(wall: str, assemblage: Assemblage, direction: int, peak: float) -> dict[str, object]:
    """Analyse one wall in one direction and return its row of the table."""
    began = process_time()
    loads = loads_on(assemblage.wall, LoadSettings("+x" if direction > 0 else "-x"))
    found = analyse(assemblage, LimitAnalysisSettings(large_displacements="--without-geometry" not in sys.argv), loads)
    headline = found.headline.load_multiplier
    left = 1.0 - sum(failure.share for failure in found.local_failures)
    return {
        "wall": wall,
        "blocks": len(found.headline.mechanism.velocities) - 1,
        "direction": f"{direction:+d}",
        "micro-FE": f"{peak:.4f}",
        "headline": f"{headline:.4f}",
        "base shear / weight": f"{left * headline:.4f}",
        "off": f"{left * headline / peak - 1:+.2%}",
        "met by": found.headline.flow_rule,
        "closes": "yes" if closes_joints(found.headline) else "",
        "rest": "" if found.last_rest is None else f"{found.last_rest:.4f}",
        "interval": "" if found.interval is None else "{:.4f} to {:.4f}".format(*found.interval),
        "soft": "" if found.soft_from is None else f"{found.soft_from:.4f}",
        "large displacements": "" if found.rigid_curve is None else f"{found.rigid_curve[:, 1].max():.4f}",
        "local": len(found.local_failures),
        "ways out": ", ".join(f"{name} {times}" for name, times in found.ways_out.items() if times),
        "the paper's value": "" if found.sequence is None else f"{found.sequence.load_multiplier:.4f}",
        "lowest": "" if found.lowest is None else f"{found.lowest.load_multiplier:.4f}",
        "associative": f"{found.associative.load_multiplier:.4f}",
        "seconds": f"{process_time() - began:.1f}",
    }


def summarised(rows: list[dict[str, object]]) -> str:
    """Return in one sentence how near headline and the paper's value are to micro-FE."""
    off = np.array([float(str(row["base shear / weight"])) / float(str(row["micro-FE"])) - 1 for row in rows])
    with_value = [row for row in rows if row["the paper's value"]]
    paper = np.array([float(str(r["the paper's value"])) / float(str(r["micro-FE"])) - 1 for r in with_value])
    said = (
        f"Of {len(rows)} analyses {np.sum(np.abs(off) <= NEAR)} have a headline within {NEAR:.1%} of micro-FE and "
        f"{np.sum(off > ABOVE)} one more than {ABOVE:.0%} above it; the highest is {off.max():+.1%}, the lowest "
        f"{off.min():+.1%}, the mean distance {np.abs(off).mean():.1%}. The paper's value exists for {len(paper)}"
    )
    if not len(paper):
        return f"{said}."
    return (
        f"{said}: "
        f"{np.sum(np.abs(paper) <= NEAR)} within {NEAR:.1%}, highest {paper.max():+.1%}, lowest {paper.min():+.1%}."
    )


def random_walls() -> Iterator[tuple[str, Assemblage, int, float]]:
    """Yield name, assemblage, direction and micro-FE's peak of the walls of robustness.py.

    The peak is that of path.csv where the wall was pushed again with the path as it is.
    """
    with (FOLDER / "robustness.csv").open() as file:
        before = {(row["seed"], row["direction"]): float(row["peak multiplier"]) for row in csv.DictReader(file)}
    again = peaks_of_path()
    for number, pattern in enumerate(WALLS):
        for turn, direction in enumerate((1, -1)):
            assemblage = find_joints(irregular_courses(pattern), JointSettings())
            peak = again.get(2 * number + turn, before[str(pattern.seed), f"{direction:+d}"])
            yield f"random {pattern.seed}", assemblage, direction, peak


def drawn_walls() -> Iterator[tuple[str, Assemblage, int, float]]:
    """Yield the same of the walls of path.py that were pushed so far and are no random walls."""
    for run, peak in peaks_of_path().items():
        if run >= 2 * len(WALLS):
            family, wall = path.wall_of(run // 2)
            yield f"{family} {run}", find_joints(wall, JointSettings()), 1 - 2 * (run % 2), peak


def peaks_of_path() -> dict[int, float]:
    """Return the peaks of path.csv by the number of the run, without curves that were left before their end."""
    with (FOLDER / "path.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if not row["ended"].startswith(("left", "STOPPED"))]
    return {int(row["run"]): float(row["peak"]) for row in sorted(rows, key=lambda row: int(row["run"]))}


def main() -> None:
    """Run all walls; the table is written anew after each."""
    rows: list[dict[str, object]] = []
    without = [option for option in sys.argv[1:] if option.startswith("--without")]
    numbers = [int(option) for option in sys.argv[1:] if option not in without]
    for wall in islice(chain(random_walls(), drawn_walls()), numbers[0] if numbers else None):
        rows.append(compared(*wall))
        print(", ".join(f"{name} {value}" for name, value in rows[-1].items()), flush=True)
        if not without:
            write(rows)
    print(summarised(rows))


def write(rows: list[dict[str, object]]) -> None:
    """Write states.csv and states.md."""
    with (FOLDER / "states.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    head = (FOLDER / "states_head.md").read_text()
    random = [row for row in rows if str(row["wall"]).startswith("random")]
    drawn = [row for row in rows if row not in random]
    said = f"Random walls. {summarised(random)}" + (f"\n\nDrawn walls. {summarised(drawn)}" if drawn else "")
    (FOLDER / "states.md").write_text(f"{head}\n{said}\n\n{markdown(rows)}\n")


def markdown(rows: list[dict[str, object]]) -> str:
    """Return rows as a table in Markdown."""
    names = list(rows[0])
    lines = [names, ["---"] * len(names), *([str(row[name]) for name in names] for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


if __name__ == "__main__":
    main()
