"""Peak of the macroblocks against that of micro-FE, on the walls of path.py.

    python docs/studies/macroblock_peaks.py [number of pushovers]
    python docs/studies/macroblock_peaks.py held-out    on the walls of held_out.py, on which no rule was ever tried

writes macroblock_peaks.csv and macroblock_peaks.md (after macroblock_peaks_head.md) beside this file, or
macroblock_peaks_held_out.csv. Micro-FE and macroblocks, those of the automatic choice, refined as `run` does, are
pushed with the meshes of `run` to a thirtieth of the height; peaks are base shear over the weight of the wall as drawn.
Two runs go side by side.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import repeat
from multiprocessing import get_context
from pathlib import Path
from time import process_time
from typing import Any

import held_out
import numpy as np
import path
from stored import ABOVE as HEADLINE_ABOVE
from stored import NEAR as HEADLINE_NEAR
from stored import table as in_markdown

from orchestrator import (
    CaseError,
    ConvergenceError,
    JointSettings,
    LoadSettings,
    Pushed,
    analyse,
    find_joints,
    loads_on,
    macroblocks_of,
    one_body_per_block,
    push,
    push_and_refine,
)
from orchestrator.limit_analysis.turning_joints import left_at_hinges
from orchestrator.masonry.wall import Wall

FOLDER = Path(__file__).parent
NEAR, ABOVE, FEWER = 0.02, 0.04, 0.8
"""what macroblocks are to reach: a peak this near to micro-FE's, never further above, so many fewer bodies"""


def compared(run: int, of: Callable[[int], tuple[str, Wall]] = path.wall_of) -> dict[str, Any]:
    """Return the row of one pushover, a wall along +x or -x: micro-FE, limit analysis, macroblocks and their peaks."""
    family, wall = of(run // 2)
    load, began = LoadSettings("-x" if run % 2 else "+x"), process_time()
    assemblage = find_joints(wall, JointSettings())
    row: dict[str, Any] = {"run": run, "family": family, "direction": load.direction}
    try:
        analysis = analyse(assemblage, loads=loads_on(wall, load))
        analysed = process_time()
        partition = macroblocks_of(assemblage, analysis)
        left = analysis.headline.horizontal_load / analysis.horizontal_load
        low, high = analysis.interval or (analysis.headline.load_multiplier,) * 2
        row |= {
            "headline": f"{left * analysis.headline.load_multiplier:.4f}",
            "low": f"{left * low:.4f}",
            "high": f"{left * high:.4f}",
            "moved": "" if analysis.rigid_peak is None else f"{left * analysis.rigid_peak:.4f}",
            "pressed": "" if (pressed := left_at_hinges(assemblage, analysis)) is None else f"{left * pressed:.4f}",
            "blocks": sum(not block.fixed for block in wall.blocks),
            "chosen": partition.count,
            "local": sum(len(failure.stones) for failure in analysis.local_failures),
            "analysis_s": round(analysed - began, 1),
            "choice_s": round(process_time() - analysed, 1),
        }
        began = process_time()
        micro = push(assemblage, analysis, one_body_per_block(assemblage), load)
        peak = micro.capacity.peak_base_shear / analysis.horizontal_load
        row |= {
            "micro-FE": f"{peak:.4f}",
            "micro_s": round(process_time() - began, 1),
            "micro_ended": _ended(micro),
            "micro_iterations": micro.summary.newton_iterations,
            "micro_steps": micro.summary.steps,
            "micro_in_motion": micro.summary.moving_steps,
            "micro_events": len(micro.summary.events),
            "micro_rescues": sum(micro.summary.rescues.values()),
        }
        began = process_time()
        partition, done = push_and_refine(
            assemblage,
            analysis,
            partition,
            lambda bodies, suffices: push(assemblage, analysis, bodies, load, suffices=suffices),
        )
    except (CaseError, ConvergenceError) as error:
        return row | {"ended": f"STOPPED: {error}"}
    shear = done.capacity.peak_base_shear / analysis.horizontal_load
    return row | {
        "bodies": partition.count,
        "macroblocks": f"{shear:.4f}",
        "off": f"{shear / peak - 1:+.2%}",
        "iterations": done.summary.newton_iterations,
        "finite_elements_s": round(process_time() - began, 1),
        "ended": _ended(done),
        "why": "; ".join(partition.remarks),
    }


def _ended(done: Pushed) -> str:
    return done.summary.stopped_because if done.summary.valid else f"NOT VALID: {done.summary.complaint}"


def said(rows: Sequence[dict[str, Any]]) -> str:
    """Return in a few sentences how near the macroblocks come, and how many bodies they save."""
    pushed = [row for row in rows if "macroblocks" in row]
    off = np.array([float(row["macroblocks"]) / float(row["micro-FE"]) - 1 for row in pushed])
    fewer = np.array([1 - row["bodies"] / row["blocks"] for row in pushed])
    headline, low, high = (
        np.array([float(row[name]) / float(row["micro-FE"]) - 1 for row in pushed])
        for name in ("headline", "low", "high")
    )
    near, within = np.abs(headline) <= HEADLINE_NEAR, (low <= HEADLINE_NEAR) & (high >= -HEADLINE_NEAR)
    moved = np.array([float(row["moved"] or row["headline"]) / float(row["micro-FE"]) - 1 for row in pushed])
    like = np.abs(moved) <= HEADLINE_NEAR
    pressed = np.array([float(row["pressed"] or row["headline"]) / float(row["micro-FE"]) - 1 for row in pushed])
    down = (np.minimum(low, pressed) <= HEADLINE_NEAR) & (high >= -HEADLINE_NEAR)
    analysis, choice, solving, micro = (
        sum(row[name] for row in pushed) for name in ("analysis_s", "choice_s", "finite_elements_s", "micro_s")
    )
    return (
        f"{len(pushed)} of {len(rows)} pushovers have a curve. Of these {np.sum(np.abs(off) <= NEAR)} have a peak "
        f"within {NEAR:.0%} of micro-FE, {np.sum(off > ABOVE)} one more than {ABOVE:.0%} above it; the highest is "
        f"{off.max():+.1%}, the lowest {off.min():+.1%}, the mean distance {np.abs(off).mean():.1%}. "
        f"{np.sum(fewer >= FEWER)} have at least {FEWER:.0%} fewer bodies than stones; the median is "
        f"{np.median(fewer):.0%} fewer. The valid ones are {sum('NOT VALID' not in row['ended'] for row in pushed)}. "
        f"The headline of limit analysis is within {HEADLINE_NEAR:.1%} of micro-FE in {near.sum()}, itself or its "
        f"interval in {within.sum()}, more than {HEADLINE_ABOVE:.0%} above in {np.sum(headline > HEADLINE_ABOVE)} "
        f"(highest {headline.max():+.1%}, lowest {headline.min():+.1%}). Rigid blocks in large displacements, "
        f"as micro-FE moves (where their peak was passed, else the headline), are within {HEADLINE_NEAR:.1%} in "
        f"{like.sum()}, more than {HEADLINE_ABOVE:.0%} above in {np.sum(moved > HEADLINE_ABOVE)}; one of the three in "
        f"{np.sum(within | like)}. What pressed edges leave is within {HEADLINE_NEAR:.1%} in "
        f"{np.sum(np.abs(pressed) <= HEADLINE_NEAR)}, more than {HEADLINE_ABOVE:.0%} above in "
        f"{np.sum(pressed > HEADLINE_ABOVE)}; headline, interval or all from there to them in {down.sum()}. Limit "
        f"analysis took {analysis:.0f} s, the "
        f"choice of bodies {choice:.0f} s, all pushovers of macroblocks {solving:.0f} s, micro-FE {micro:.0f} s."
    )


def write(rows: list[dict[str, Any]]) -> None:
    """Write macroblock_peaks.csv and macroblock_peaks.md, and path.md."""
    path.write(rows)
    names = write_csv(rows, "macroblock_peaks.csv")
    head = (FOLDER / "macroblock_peaks_head.md").read_text()
    table = in_markdown([{name: row.get(name, "") for name in names} for row in rows])
    (FOLDER / "macroblock_peaks.md").write_text(f"{head}\n{said(rows)}\n\n{table}\n")


def write_csv(rows: list[dict[str, Any]], name: str) -> list[str]:
    """Write a table beside this file; return the names of its columns."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    with (FOLDER / name).open("w", newline="") as file:
        writer = csv.DictWriter(file, names, restval="", lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    return names


def each(order: Sequence[int], of: Callable[[int], tuple[str, Wall]]) -> Iterator[list[dict[str, Any]]]:
    """Push all runs in this order; yield the rows so far after each."""
    rows: list[dict[str, Any]] = []
    context = get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=context, max_tasks_per_child=1) as pool:
        for row in pool.map(compared, order, repeat(of)):
            rows.append(row)
            print(row, flush=True)
            yield rows


def main(most: int | None) -> None:
    """Run all and write the tables after each."""
    for rows in each(sorted(range(path.PUSHOVERS), key=lambda run: 37 * run % path.PUSHOVERS)[:most], path.wall_of):
        write(rows)


def main_held_out() -> None:
    """Run the walls of held_out.py and write their table after each."""
    for rows in each(range(2 * held_out.WALLS), held_out.wall_of):
        write_csv(rows, "macroblock_peaks_held_out.csv")
    print(said(rows))


if __name__ == "__main__":
    if sys.argv[1:] == ["held-out"]:
        main_held_out()
    else:
        main(int(sys.argv[1]) if len(sys.argv) > 1 else None)
