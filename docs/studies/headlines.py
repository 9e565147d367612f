"""What studies share: the headline of limit analysis beside the peak of micro-FE, and the peaks of path.csv."""

from __future__ import annotations

import csv
from pathlib import Path
from time import process_time

import numpy as np

from orchestrator.limit_analysis import analyse
from orchestrator.limit_analysis.remarks import closes_joints
from orchestrator.loads import LoadSettings, loads_on
from orchestrator.masonry.joints import Assemblage

FOLDER = Path(__file__).parent
NEAR, ABOVE = 0.015, 0.03
"""Parts of the peak: a headline this near counts as right; no headline may lie further above."""


def compared(wall: str, assemblage: Assemblage, direction: int, peak: float) -> dict[str, object]:
    """Analyse one wall in one direction and return its row of the table."""
    began = process_time()
    loads = loads_on(assemblage.wall, LoadSettings("+x" if direction > 0 else "-x"))
    found = analyse(assemblage, loads=loads)
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


def peaks_of_path() -> dict[int, float]:
    """Return the peaks of path.csv by the number of the run, without curves that were left before their end."""
    with (FOLDER / "path.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if not row["ended"].startswith(("left", "STOPPED"))]
    return {int(row["run"]): float(row["peak"]) for row in sorted(rows, key=lambda row: int(row["run"]))}


def markdown(rows: list[dict[str, object]]) -> str:
    """Return rows as a table in Markdown."""
    names = list(rows[0])
    lines = [names, ["---"] * len(names), *([str(row[name]) for name in names] for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
