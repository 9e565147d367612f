"""200 random walls, one after the other, as a user starts them: does any of them crash, hang, or end without a reason?

    python docs/studies/soak.py [number of walls] [seconds in all]

appends to soak.csv beside this file, where it goes on after the walls that stand there already, and writes soak.md.
Each wall of 10 to 40 stones goes through micro limit analysis, macroblocks and their FE pushover to 2 mm in a process
of its own, which is ended after LIMIT s.
"""

from __future__ import annotations

import csv
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path
from time import perf_counter

import numpy as np

from orchestrator.basis.errors import CaseError
from orchestrator.masonry.patterns import IrregularCourses, irregular_courses
from orchestrator.storage import write_csv, write_json, write_text
from orchestrator.storage.values import blocks_record

FOLDER = Path(__file__).parent
LIMIT = 90.0
COLUMNS = ("wall", "stones", "length_m", "height_m", "thickness_m", "friction", "direction", "opening", "outcome",
           "seconds", "reason")  # fmt: skip
OUTCOMES = {0: "converged", 1: "stopped with a reason", 2: "refused with a reason", 3: "not valid with a reason"}
HEAD = """# Soak

`docs/studies/soak.py` (part of `make verify`): random walls of 10 to 40 stones, with and without an opening, pushed
either way; micro limit analysis, macroblocks, FE pushover to 2 mm, every wall in a process of its own, which is ended
after {limit:g} s. A crash is a traceback, a signal, or an exit code without one line that says why; a hang is a process
that had to be ended.

| outcome | walls |
| --- | ---: |
"""


def pattern(number: int) -> tuple[IrregularCourses, str]:
    """Return wall `number` and the direction of its load; drawn again until it has 10 to 40 stones."""
    random = np.random.default_rng(number)
    while True:
        length, height = random.uniform(0.5, 1.8), random.uniform(0.4, 2.0)
        openings = ()
        if random.random() < 0.4:
            left, sill = random.uniform(0.25, 0.5) * length, random.choice([0.0, 0.3]) * height
            openings = ((left, left + random.uniform(0.2, 0.4) * length, sill, sill + 0.4 * height),)
        drawn = IrregularCourses(
            length=length,
            height=height,
            thickness=random.uniform(0.1, 0.6),
            widths=(0.15, random.uniform(0.35, 0.5)),
            heights=(0.12, random.uniform(0.14, 0.25)),
            openings=openings,
            friction=random.uniform(0.2, 1.0),
            seed=int(random.integers(10_000)),
        )
        direction = str(random.choice(["+x", "-x"]))
        try:
            if 10 <= len(irregular_courses(drawn).blocks) - 1 <= 40:
                return drawn, direction
        except CaseError:  # no stones fit
            continue


def outcome(wall: IrregularCourses, direction: str) -> tuple[str, str]:
    """Run a wall; return what became of it, and the reason it gives."""
    with tempfile.TemporaryDirectory() as name:
        file = Path(name) / "wall.json"
        write_json(file, blocks_record(irregular_courses(wall)))
        settings = ["stepping.final_displacement=2mm", f"load.direction={direction}"]
        command = [sys.executable, "-m", "orchestrator", "run", file, "--model", "macro", "--quiet", "--output", name]
        command += [word for setting in settings for word in ("--set", setting)]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT)
        except subprocess.TimeoutExpired:
            return "HANGS", f"ended after {LIMIT:g} s"
    said = done.stderr.strip().replace(name, "")
    explained = len(said.splitlines()) == (done.returncode != 0)
    return OUTCOMES.get(done.returncode if explained else -1, "CRASHES"), said.splitlines()[-1] if said else ""


def main(walls: int = 200, seconds: float = 7200.0) -> int:
    """Go on with the table; return 1 if a wall crashes or hangs."""
    began = perf_counter()
    path = FOLDER / "soak.csv"
    rows = list(csv.DictReader(path.open())) if path.exists() else []
    for number in range(len(rows), walls):
        if perf_counter() - began > seconds:
            break
        wall, direction = pattern(number)
        start = perf_counter()
        found, reason = outcome(wall, direction)
        stones = len(irregular_courses(wall).blocks) - 1
        figures = [f"{value:.2f}" for value in (wall.length, wall.height, wall.thickness, wall.friction)]
        took = f"{perf_counter() - start:.1f}"
        opening = "yes" if wall.openings else "no"
        row = (str(number), str(stones), *figures, direction, opening, found, took, reason)
        rows.append(dict(zip(COLUMNS, row, strict=True)))
        write_csv(path, COLUMNS, [[row[name] for name in COLUMNS] for row in rows])
        print(number, found, reason, flush=True)
    counted = Counter(row["outcome"] for row in rows)
    lines = [f"| {name} | {count} |" for name, count in counted.most_common()]
    slowest = max(float(row["seconds"]) for row in rows)
    reasons = [f"- wall {row['wall']}: {row['outcome']}: {row['reason']}" for row in rows if row["reason"]]
    tail = [
        f"| all | {len(rows)} |",
        "",
        f"The slowest took {slowest:.0f} s of wall-clock time on a shared machine.",
        "",
    ]
    write_text(FOLDER / "soak.md", HEAD.format(limit=LIMIT) + "\n".join([*lines, *tail, *reasons]) + "\n")
    return int(any(name in counted for name in ("CRASHES", "HANGS")))


if __name__ == "__main__":
    raise SystemExit(main(*(kind(text) for kind, text in zip((int, float), sys.argv[1:], strict=False))))
