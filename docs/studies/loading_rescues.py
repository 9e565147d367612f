"""What each retry, threshold and fallback of loading earns: limit analyses with each of them taken away.

    python docs/studies/loading_rescues.py [number of processes, default 2]

One of three of the walls and directions of macroblock_peaks.py, against micro-FE there. Writes loading_rescues.csv and
loading_rescues.md beside this file.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

FOLDER = Path(__file__).parent
sys.path[:0] = [str(FOLDER)]

import path as study
from stored import ABOVE, NEAR

from orchestrator import JointSettings, LoadSettings, analyse, find_joints, loads_on
from orchestrator.basis.errors import CaseError, ConvergenceError
from orchestrator.limit_analysis import analysis, turning_joints
from orchestrator.limit_analysis.search import (
    implicit_step,
    loading,
    loading_path,
    nearest_state,
    overdamped,
    pushing,
    rigid_pushover,
)

PEAKS = FOLDER / "macroblock_peaks.csv"
ANOTHER = 1e-3
"""part by which a headline differs from the one with nothing taken away to count as another"""


def _set(module: Any, **values: Any) -> Callable[[], None]:
    def away() -> None:
        for name, value in values.items():
            assert hasattr(module, name), name
            setattr(module, name, value)

    return away


def _interior_alone() -> None:
    interior = implicit_step.interior_step

    def step(wall: Any, before: Any, task: Any, expected: Any) -> Any:
        found = interior(wall, before, task, float(np.abs(expected).max()))
        return replace(found, effort=found.factorisations // 2)

    for module in (overdamped, rigid_pushover):
        _set(module, implicit_step=step)()


def _newton_alone() -> None:
    for module in (overdamped, rigid_pushover):
        _set(module, implicit_step=implicit_step.newton_step)()


def _held_by_little() -> None:
    held = pushing.Pushing.held
    _set(pushing.Pushing, held=lambda self, peak, last, _more, fine: held(self, peak, last, fine, fine))()


def _no_further_than_followed() -> None:
    whole = turning_joints._curve

    def curve(assemblage: Any, found: Any) -> Any:
        known = whole(assemblage, found)
        return (known[0][: known[1]], known[1]) if known and known[1] else known

    _set(turning_joints, _curve=curve)()


def _stones_that_fall_stay() -> None:
    road = loading.road
    _set(loading, road=lambda stiffness: replace(road(stiffness), falling=lambda _problem: ()))()


WITHOUT: dict[str, Callable[[], None]] = {
    "nothing": lambda: None,
    "Newton's method": _interior_alone,
    "the interior-point method": _newton_alone,
    "joints of another stiffness": _set(loading, STIFFNESSES=loading.STIFFNESSES[:1]),
    "a first rest under less load": _set(pushing, FIRST_LOADS=pushing.FIRST_LOADS[:1]),
    "more is held where that led to a rest only": _held_by_little,
    "a step that turns is made shorter": _set(pushing, TURNED=1e300),
    "a step whose load leaps is made shorter": _set(pushing, LEAP=np.inf),
    "a first step is ten times the shortest": _set(pushing, FIRST=1.0),
    "steps too short end it": _set(pushing, SHORTEST=(1e-9, 1e-9)),
    "the nearest state": _set(loading_path.StateSearch, closed=lambda *_: None),
    "the nearest state at the lower end of a face": _set(nearest_state, FACE_WEIGHTS=()),
    "a state far below the load that let it go": _set(loading_path, LETS_GO=0.0),
    "a state below a rest counts if nothing more is borne": _set(loading, settled=lambda found, _: found),
    "the curve goes on beyond its end": _no_further_than_followed,
    "states that the path passed": _set(analysis, touched=lambda *_: None),
    "states of the search that close a last rest": _set(analysis, closing_state=lambda *_: None),
    "stones missed that the bound excludes": _set(loading, MISSED=np.inf),
    "stones that fall go, too": _stones_that_fall_stay,
    "motions are left a thousand times as far": _set(overdamped, LOST=np.inf),
    "forces that go on": _set(
        rigid_pushover, going_on=lambda _wall, _before, task, expected: (expected, task.multiplier)
    ),
    "no motion against what drives it": _set(rigid_pushover.DisplacedWallSearch, goes_back=lambda *_: False),
    "all that is left for the last load held": _set(pushing.Pushing, budget_held=lambda *_: overdamped.REST_BUDGET),
    "a wall that bears less as it moves is left": _set(
        rigid_pushover.DisplacedWallSearch, too_little=lambda *_: -np.inf
    ),
    "steps no longer than a fiftieth of a block": _set(rigid_pushover, LONGEST=np.inf),
    "a thirtieth of the height is far": _set(rigid_pushover, DRIFT=np.inf),
}
"""what is taken away -> how"""


def analysed_without(without: str) -> list[dict[str, Any]]:
    """Return the rows of all analyses without one thing, which stays away in this process."""
    WITHOUT[without]()
    rows = []
    with PEAKS.open(encoding="utf-8") as file:
        peaks = {int(row["run"]): float(row["micro-FE"]) for row in csv.DictReader(file)}
    for run in sorted(number for number in peaks if number % 3 == 0):
        family, wall = study.wall_of(run // 2)
        row = {"without": without, "run": run, "family": family, "micro-FE": peaks[run]}
        assemblage, began = find_joints(wall, JointSettings()), process_time()
        try:
            found = analyse(assemblage, loads=loads_on(wall, LoadSettings("-x" if run % 2 else "+x")))
        except (CaseError, ConvergenceError) as error:
            rows.append(row | {"failed": str(error)})
            continue
        left = found.headline.horizontal_load / found.horizontal_load
        low, high = found.interval or (found.headline.load_multiplier,) * 2
        row |= {"headline": left * found.headline.load_multiplier, "low": left * low, "high": left * high}
        row |= {"by": found.headline.flow_rule, "closed": (found.drawn or found.headline).converged}
        row |= {"moved": found.rigid_peak and left * found.rigid_peak}
        row |= {"pressed": found.pressed_peak and left * found.pressed_peak}
        row |= {"local": len(found.local_failures), "factorisations": found.factorisations}
        rows.append(row | {"seconds": process_time() - began})
    print(without, summarised(rows, rows), flush=True)
    return rows


def summarised(rows: list[dict[str, Any]], whole: list[dict[str, Any]]) -> list[str]:
    """Return the cells of a line of the table."""
    found = {row["run"]: row for row in rows if "headline" in row}
    before = {row["run"]: row for row in whole if "headline" in row}
    off = np.array([row["headline"] / row["micro-FE"] - 1.0 for row in found.values()])
    left = np.array([(row["pressed"] or np.nan) / row["micro-FE"] - 1.0 for row in found.values()])
    changed = [abs(row["headline"] / before[run]["headline"] - 1.0) for run, row in found.items() if run in before]
    work, of_whole = (sum(row["factorisations"] for row in of.values()) for of in (found, before))
    return [
        f"{len(found)}", f"{sum(row['closed'] for row in found.values())}",
        f"{sum(row['moved'] is not None for row in found.values())}", f"{np.sum(np.abs(off) <= NEAR)}",
        f"{np.sum(off > ABOVE)}", f"{np.sum(np.abs(left) <= NEAR)}", f"{np.sum(np.array(changed) > ANOTHER)}",
        f"{max(changed, default=0.0):.1%}", f"{work / of_whole - 1.0:+.0%}",
    ]  # fmt: skip


def write(rows: list[dict[str, Any]]) -> None:
    """Write loading_rescues.csv and loading_rescues.md."""
    study.write_table(FOLDER / "loading_rescues.csv", rows)
    whole = [row for row in rows if row["without"] == "nothing"]
    names = [
        "without", "analyses", "states closed", "peaks passed", f"within {NEAR:.1%}", f"above {ABOVE:.0%}",
        "pressed within", "others", "farthest", "factorisations",
    ]  # fmt: skip
    lines = [names, ["---"] * len(names)]
    for without in dict.fromkeys(row["without"] for row in rows):
        lines.append([without, *summarised([row for row in rows if row["without"] == without], whole)])
    table = "\n".join(f"| {' | '.join(cells)} |" for cells in lines)
    head = (FOLDER / "loading_rescues_head.md").read_text(encoding="utf-8")
    (FOLDER / "loading_rescues.md").write_text(f"{head}\n{table}\n", encoding="utf-8")


def main(processes: int) -> None:
    """Run all and write the table."""
    rows: list[dict[str, Any]] = []
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn"), max_tasks_per_child=1) as pool:
        for of in pool.map(analysed_without, WITHOUT):
            rows.extend(of)
            write(rows)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 2)
