"""Limit analysis against micro-FE of stones ten times as stiff, on the walls of macroblock_peaks.py.

    python docs/studies/stiff_stones.py

writes stiff_stones.csv and stiff_stones.md (stiff_stones_head.md with the table put in) beside this file. Limit
analysis and finite elements have the same modulus. Curves end at END of the height, as stiff stones peak early; all
else is as macroblock_peaks.py has it, whose table gives the walls, their order, and headline and micro-FE of default
stones.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
import path
from stored import ABOVE, NEAR, markdown, written_after_each

from orchestrator import (
    CollapseError,
    ConvergenceError,
    ElasticSettings,
    JointSettings,
    LoadSettings,
    SteppingSettings,
    analyse,
    find_joints,
    loads_on,
    one_body_per_block,
    push,
)
from orchestrator.storage import write_csv, write_text

FOLDER = Path(__file__).parent
MODULUS = 35e9
"""of the stones, Pa: that of a limestone or granite"""
END = 0.01
"""displacement of the top over the height of the wall with which a curve ends"""
COLUMNS = ("run", "family", "direction", "headline", "low", "high", "moved", "micro_FE", "off", "seconds", "ended")
COLUMNS += ("default_headline", "default_micro_FE", "default_off")


def compared(default: dict[str, str]) -> dict[str, Any]:
    """Return the row of a row of macroblock_peaks.csv; multipliers are base shear over the weight of the wall."""
    run, began = int(default["run"]), process_time()
    wall, load = path.wall_of(run // 2)[1], LoadSettings("-x" if run % 2 else "+x")
    height = float(np.ptp(np.vstack([block.polygon for block in wall.blocks if not block.fixed])[:, 1]))
    assemblage = find_joints(wall, JointSettings())
    analysis = analyse(assemblage, loads=loads_on(wall, load), elastic_modulus=MODULUS)
    left = analysis.headline.horizontal_load / analysis.horizontal_load
    headline = left * analysis.headline.load_multiplier
    low, high = (left * end for end in analysis.interval or (analysis.headline.load_multiplier,) * 2)
    row = {
        "run": run, "family": default["family"], "direction": load.direction,
        "headline": f"{headline:.4f}", "low": f"{low:.4f}", "high": f"{high:.4f}",
        "moved": "" if analysis.rigid_peak is None else f"{left * analysis.rigid_peak:.4f}",
        "default_headline": default["headline"], "default_micro_FE": default["micro-FE"],
        "default_off": f"{float(default['headline']) / float(default['micro-FE']) - 1:+.2%}",
    }  # fmt: skip
    try:
        micro = push(
            assemblage,
            analysis,
            one_body_per_block(assemblage),
            load,
            elastic=ElasticSettings(elastic_modulus=MODULUS),
            stepping=SteppingSettings(final_displacement=END * height),
        )
    except (CollapseError, ConvergenceError) as error:
        return row | {"micro_FE": "", "off": "", "seconds": 0.0, "ended": f"STOPPED: {error}"}
    peak = micro.capacity.peak_base_shear / analysis.horizontal_load
    ended = micro.summary.stopped_because if micro.summary.valid else f"NOT VALID: {micro.summary.complaint}"
    return row | {
        "micro_FE": f"{peak:.4f}",
        "off": f"{headline / peak - 1:+.2%}",
        "seconds": round(process_time() - began, 1),
        "ended": ended,
    }


def rows() -> Iterator[dict[str, Any]]:
    """Yield a row for every pushover of macroblock_peaks.csv."""
    with (FOLDER / "macroblock_peaks.csv").open() as file:
        for default in csv.DictReader(file):
            yield compared(default)


def said(done: list[dict[str, Any]]) -> str:
    """Return how near limit analysis comes to finite elements of stiff stones, and of default ones."""

    def counted(headline: str, micro: str) -> str:
        off = np.array([float(row[headline]) / float(row[micro]) - 1.0 for row in done if row[micro]])
        return (
            f"within {NEAR:.1%} in {np.sum(np.abs(off) <= NEAR)} of {len(off)}, more than "
            f"{ABOVE:.0%} above in {np.sum(off > ABOVE)}, more than {NEAR:.1%} below in "
            f"{np.sum(off < -NEAR)} (highest {off.max():+.1%}, lowest {off.min():+.1%})"
        )

    return (
        f"The headline is, of stiff stones, {counted('headline', 'micro_FE')}. Of default stones it is "
        f"{counted('default_headline', 'default_micro_FE')}."
    )


def write(done: list[dict[str, Any]]) -> None:
    """Write stiff_stones.csv and stiff_stones.md."""
    cells = [[str(row[name]) for name in COLUMNS] for row in done]
    write_csv(FOLDER / "stiff_stones.csv", COLUMNS, cells)
    page = (FOLDER / "stiff_stones_head.md").read_text()
    write_text(FOLDER / "stiff_stones.md", page.replace("{{table}}", f"{said(done)}\n\n{markdown(COLUMNS, cells)}"))


if __name__ == "__main__":
    written_after_each(rows(), COLUMNS, write)
