"""Rectangles cut by straight lines: limit analysis and micro-FE where four stones meet in a point, and tips are thin.

    python docs/studies/cut_walls.py [first seed, default 1] [seed after the last, default 141]

writes cut_walls.csv and cut_walls.md beside this file, both directions of every wall. Two to five lines cross a
rectangle of 0.8 to 2.5 m; no line is a course. A pushover is left after LIMIT s of CPU time.
"""

from __future__ import annotations

import sys
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
import shapely
from shapely.geometry import LineString, box
from shapely.ops import polygonize, unary_union

FOLDER = Path(__file__).parent
sys.path[:0] = [str(FOLDER)]

import path as study
from stored import table

from orchestrator import JointSettings, LoadSettings, analyse, find_joints, one_body_per_block, push
from orchestrator.app.progress import IncrementDone
from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.errors import CaseError, CollapseError, ConvergenceError
from orchestrator.loads import loads_on
from orchestrator.masonry.wall import Block, Wall

LIMIT = 120.0
COLUMNS = ("seed", "direction", "stones", "friction", "associative", "low", "headline", "high", "come loose")
COLUMNS += ("micro-FE", "fall", "ended", "s")
NEAR = 0.03
"""part of the headline, or of the ends of its interval, by which a peak may differ before it is listed"""


def wall_of(seed: int) -> Wall:
    """Return the wall of a seed."""
    random = np.random.default_rng(seed)
    width, height = random.uniform(0.8, 2.5), random.uniform(0.8, 2.5)
    whole = box(0.0, 0.0, width, height)
    lines = [whole.exterior, *(_line(random, width, height) for _ in range(random.integers(2, 6)))]
    pieces = [piece for piece in polygonize(unary_union(lines)) if whole.contains(piece.representative_point())]
    stones = [shapely.geometry.polygon.orient(piece.simplify(1e-9)) for piece in pieces]
    ground = np.array([(-0.3, -0.2), (width + 0.3, -0.2), (width + 0.3, 0.0), (-0.3, 0.0)])
    outlines: list[FloatArray] = [ground, *(np.round(np.array(stone.exterior.coords)[:-1], 6) for stone in stones)]
    blocks = tuple(Block(number, outline, not number, 22e3) for number, outline in enumerate(outlines))
    return Wall(f"cut {seed}", blocks, 0.5, float(random.uniform(0.35, 0.75)))


def _line(random: np.random.Generator, width: float, height: float) -> LineString:
    """Return a line across the rectangle, three of four from side to side, in m."""
    if random.random() < 0.75:
        left = random.uniform(0.1, 0.95) * height
        right = np.clip(left + random.uniform(-0.25, 0.25) * width, 0.02 * height, 0.98 * height)
        slope = (right - left) / width
        return LineString([(-1.0, left - slope), (width + 1.0, right + slope)])
    bottom = random.uniform(0.1, 0.9) * width
    top = np.clip(bottom + random.uniform(-0.3, 0.3) * height, 0.05 * width, 0.95 * width)
    slope = (top - bottom) / height
    return LineString([(bottom - slope, -1.0), (top + slope, height + 1.0)])


def compared(seed: int, direction: str) -> dict[str, Any]:
    """Return the row of one wall in one direction."""
    wall, load, began = wall_of(seed), LoadSettings(direction), process_time()
    row: dict[str, Any] = dict.fromkeys(COLUMNS, "")
    row |= {"seed": seed, "direction": direction, "stones": len(wall.blocks) - 1, "friction": f"{wall.friction:.3f}"}

    def in_time(_: IncrementDone) -> None:
        if process_time() - began > LIMIT:
            raise TimeoutError(f"left after {LIMIT:g} s")

    try:
        assemblage = find_joints(wall, JointSettings())
        analysis = analyse(assemblage, loads=loads_on(wall, load))
        low, high = analysis.interval or (analysis.headline.load_multiplier,) * 2
        states = {"associative": analysis.associative, "headline": analysis.headline}
        row |= {name: f"{state.load_multiplier:.4f}" for name, state in states.items()}
        row |= {"low": f"{low:.4f}", "high": f"{high:.4f}"}
        row["come loose"] = " ".join(str(stone) for failure in analysis.local_failures for stone in failure.stones)
        done = push(assemblage, analysis, one_body_per_block(assemblage), load, report=in_time)
    except (CaseError, CollapseError, ConvergenceError, TimeoutError) as error:
        return row | {"ended": f"NO CURVE: {error}".split(": blocks")[0]}
    fallen = [body for event in done.summary.events for body in event.bodies]
    ended = done.summary.stopped_because if done.summary.valid else f"NOT VALID: {done.summary.complaint}"
    peak = f"{done.capacity.peak_multiplier:.4f}"
    return row | {"micro-FE": peak, "fall": " ".join(fallen), "ended": ended, "s": f"{process_time() - began:.1f}"}


def off(row: dict[str, Any]) -> float:
    """Return how far micro-FE is from headline and interval, over the nearest of them; infinite without a curve."""
    if not row["micro-FE"] or row["ended"].startswith("NOT VALID"):
        return np.inf
    peak, low, headline, high = (float(row[name]) for name in ("micro-FE", "low", "headline", "high"))
    low, high = min(low, headline), max(high, headline)
    return peak / high - 1 if peak > high else min(peak / low - 1, 0.0)


def main(first: int, after: int) -> None:
    """Analyse and push the walls one after the other and write the tables."""
    rows = list[dict[str, Any]]()
    for seed in range(first, after):
        for direction in ("+x", "-x"):
            rows.append(compared(seed, direction))
            print(", ".join(f"{key} {value}" for key, value in rows[-1].items()), flush=True)
    study.write_table(FOLDER / "cut_walls.csv", rows)
    far = [row for row in rows if abs(off(row)) > NEAR]
    without = sum(np.isinf(off(row)) for row in rows)
    said = (
        f"Of {len(rows)} pushovers {len(rows) - len(far)} reach a peak within {NEAR:.0%} of the headline or its "
        f"interval, {len(far) - without} reach another, and {without} have no valid curve. These others are:"
    )
    head = (FOLDER / "cut_walls_head.md").read_text()
    (FOLDER / "cut_walls.md").write_text(f"{head}\n{said}\n\n{table(far) if far else 'none.'}\n")


if __name__ == "__main__":
    main(*(int(number) for number in sys.argv[1:3] or ("1", "141")))
