"""Headline of limit analysis against the peak of micro-FE on walls that nothing was ever tried on, both ways.

    python docs/studies/held_out.py push    every stone a body, in large displacements: held_out_peaks.csv (one process)
    python docs/studies/held_out.py         limit analysis of the walls pushed: held_out.csv, held_out.md

Seeds from FIRST on, which no other study, test or example uses. Families take turns, so that a run that is ended early
has all of them. A pushover is left after LIMIT s of CPU time, and none is begun after BUDGET s of all.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path
from time import process_time

import any_wall
import headlines
import path as path_study

from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.patterns import IrregularCourses, irregular_courses
from orchestrator.masonry.wall import Wall

FOLDER = Path(__file__).parent
FIRST, WALLS, LIMIT, BUDGET = 5000, 30, 90.0, 2400.0
LARGE = {"widths": (0.2, 0.4), "heights": (0.15, 0.2)}
COURSES = (
    IrregularCourses(0.8, 0.6, seed=FIRST),
    IrregularCourses(2.0, 1.2, friction=0.5, seed=FIRST + 1, **LARGE),
    IrregularCourses(0.7, 1.4, seed=FIRST + 2),
    IrregularCourses(1.4, 2.0, openings=((0.475, 0.925, 0.8, 1.4),), seed=FIRST + 3, **LARGE),
    IrregularCourses(1.4, 1.0, friction=0.6, seed=FIRST + 4, **LARGE),
)


def wall_of(number: int) -> tuple[str, Wall]:
    """Return family and wall of a number from 0 on."""
    families = len(any_wall.FAMILIES) + 1
    turn, family = divmod(number, families)
    if family == 0:
        return "irregular courses", irregular_courses(COURSES[turn])
    return any_wall.wall_of((FIRST + turn) * len(any_wall.FAMILIES) + family - 1)


def push() -> None:
    """Push the walls one after the other and write the table after each."""
    rows = list[dict[str, object]]()
    for number in range(WALLS):
        for direction in (1, -1):
            if process_time() > BUDGET:
                return
            family, wall = wall_of(number)
            rows.append({"wall": number} | path_study.pushed_wall(family, wall, direction, LIMIT))
            print(rows[-1], flush=True)
            write(rows, FOLDER / "held_out_peaks.csv")


def write(rows: list[dict[str, object]], file: Path) -> None:
    """Write a table; what a row does not have is empty."""
    with file.open("w", newline="") as opened:
        writer = csv.DictWriter(opened, dict.fromkeys(key for row in rows for key in row), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def compare() -> None:
    """Analyse the walls that were pushed and write the tables."""
    with (FOLDER / "held_out_peaks.csv").open() as file:
        pushed = list(csv.DictReader(file))
    rows = list[dict[str, object]]()
    for row in pushed:
        family, wall = wall_of(int(row["wall"]))
        direction = 1 if row["direction"] == "+x" else -1
        name = f"{family} {row['wall']}"
        rows.append(headlines.compared(name, find_joints(wall, JointSettings()), direction, float(row["peak"])))
        rows[-1]["end of micro-FE"] = row["ended"]
        print(", ".join(f"{key} {value}" for key, value in rows[-1].items()), flush=True)
        write(rows, FOLDER / "held_out.csv")
    ended = [row for row in rows if not str(row["end of micro-FE"]).startswith(("left", "STOPPED"))]
    said = (
        f"All {len(rows)} pushovers of {len({row['wall'] for row in pushed})} walls. {headlines.summarised(rows)}\n\n"
        f"The {len(ended)} that reached the end of their curve. {headlines.summarised(ended)}\n\n"
        f"Without a state that passed the check: {sum(row['met by'] == 'last_rest' for row in rows)} of {len(rows)}."
    )
    head = (FOLDER / "held_out_head.md").read_text()
    (FOLDER / "held_out.md").write_text(f"{head}\n{said}\n\n{headlines.markdown(rows)}\n")


if __name__ == "__main__":
    push() if sys.argv[1:] == ["push"] else compare()
