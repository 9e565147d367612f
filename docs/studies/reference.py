"""How sure the reference is: micro-FE with elements of half the default's size, on the walls of path.py, both ways.

    python docs/studies/reference.py [number of pushovers]

writes reference.csv and reference.md (reference_head.md with both put in) beside this file. What limit analysis and the
default elements of `run` say is read from macroblock_peaks.csv. A run is left after LIMIT s of CPU time, and kept in
results/reference as soon as it is done: delete that folder when the mechanics change. One process.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import path
from stored import ABOVE, NEAR, RESULTS, markdown, stored, written_after_each

from orchestrator.pushover.path.curve_checks import ENERGY
from orchestrator.storage import write_csv, write_text

FOLDER = Path(__file__).parent
LIMIT = 600.0
UNFINISHED = ("left", "STOPPED", "limit", "NOT VALID")
"""how the end of a run begins that tells no peak"""
COLUMNS = ("run", "family", "direction", "stones", "default", "finer", "headline", "low", "high", "moved")
COLUMNS += ("pressed", "ended")


def row_of(known: dict[str, str]) -> dict[str, Any]:
    """Return the row of one pushover: base shears over the horizontal load of the wall as drawn."""
    run = int(known["run"])
    family, assemblage, analysis = path.analysed_run(run)
    finer = path.pushed_stones(assemblage, analysis, LIMIT, size_over_default=0.5)
    row = {"run": run, "family": family, "direction": known["direction"], "stones": finer["stones"]}
    row |= {"default": float(known["micro-FE"])}
    row |= {name: float(known[name] or known["headline"]) for name in ("headline", "low", "high", "moved", "pressed")}
    missing = f"NOT VALID: {finer['energy_error']:.1%} of energy missing, {finer['fallen_share']:.0%} fell"
    return row | {"finer": finer["peak"], "ended": finer["ended"] if finer["energy_error"] <= ENERGY else missing}


def rows(most: int | None) -> Iterator[dict[str, Any]]:
    """Yield a row for every pushover of macroblock_peaks.csv, in its order: all families early."""
    with (FOLDER / "macroblock_peaks.csv").open() as file:
        known = [row for row in csv.DictReader(file) if row["micro-FE"]]
    for row in known[:most]:
        yield stored(RESULTS / "reference" / f"{row['run']}.json", partial(row_of, row))


def said(done: list[dict[str, Any]]) -> str:
    """Return in a few sentences how far the two references are apart, and how near limit analysis comes to them."""
    whole = [row for row in done if not row["ended"].startswith(UNFINISHED)]
    default, finer, headline, low, high, moved, pressed = (
        np.array([row[name] for row in whole])
        for name in ("default", "finer", "headline", "low", "high", "moved", "pressed")
    )
    apart, lower, upper = finer / default - 1.0, np.minimum(default, finer), np.maximum(default, finer)
    between = (headline >= lower * (1.0 - NEAR)) & (headline <= upper * (1.0 + NEAR))
    interval = (high >= lower * (1.0 - NEAR)) & (low <= upper * (1.0 + NEAR))

    def near(value: np.ndarray, reference: np.ndarray) -> int:
        return int(np.sum(np.abs(value / reference - 1.0) <= NEAR))

    far, farther = int(np.sum(np.abs(apart) > NEAR)), int(np.sum(np.abs(apart) > ABOVE))
    return (
        f"{len(whole)} of {len(done)} pushovers reach their end with both meshes, valid. The finer elements bear "
        f"{apart.mean():+.1%} in the mean, {apart.min():+.1%} to {apart.max():+.1%}; in {far} the two are more than "
        f"{NEAR:.1%} apart, in {farther} more than {ABOVE:.0%}. The headline is within {NEAR:.1%} of the default's "
        f"elements in {near(headline, default)}, of the finer ones in {near(headline, finer)}, of one of the two or "
        f"between them in {between.sum()}, itself or its interval in {interval.sum()}; it is more than {ABOVE:.0%} "
        f"above both in {np.sum(headline > (1.0 + ABOVE) * upper)}. Rigid blocks in large displacements are within "
        f"{NEAR:.1%} of the default's in {near(moved, default)}, of the finer ones in {near(moved, finer)}; what "
        f"pressed edges leave in {near(pressed, default)} and {near(pressed, finer)}."
    )


def write(done: list[dict[str, Any]]) -> None:
    """Write reference.csv and reference.md."""
    write_csv(FOLDER / "reference.csv", COLUMNS, [[row.get(name, "") for name in COLUMNS] for row in done])
    named = ("run", "family", "direction", "stones", "default")
    beside = ("finer", "headline", "low", "high", "moved", "pressed")
    lines = [
        [f"{row[name]:.4f}" if name == "default" else str(row[name]) for name in named]
        + [f"{row[name] / row['default'] - 1.0:+.1%}" if name in row else "" for name in beside]
        + [row["ended"] if row["ended"].startswith(UNFINISHED) else ""]
        for row in done
    ]
    page, table = (FOLDER / "reference_head.md").read_text(), markdown([*named, *beside, "finer elements"], lines)
    write_text(FOLDER / "reference.md", page.replace("{{said}}", said(done)).replace("{{table}}", table))


if __name__ == "__main__":
    written_after_each(rows(int(sys.argv[1]) if len(sys.argv) > 1 else None), COLUMNS, write)
