"""The tolerance study as a page: table1.md = table1_head.md with the tables of finished studies put in.

    make table1 benchmark2
    python docs/studies/table1.py [STUDY FOLDER OF BENCHMARK 1] [OF BENCHMARK 2]

Reads table.csv and the runs' macroblocks.json of each folder (default: results/table1, results/benchmark2), computes
the multiplier of the macroblocks as rigid bodies by the sequence, and copies the figures to
docs/figures. The table of macroblocks that choose themselves comes from tolerances.csv beside this file. The words
around the tables are written by hand: read them again when a number changes.
"""

from __future__ import annotations

import csv
import json
import shutil
import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

import numpy as np

from orchestrator import Assemblage, find_joints, read_case, read_wall
from orchestrator.loads import Loads, loads_on
from orchestrator.macroblocks.merged_blocks import merged_multiplier

FOLDER = Path(__file__).parent
PROJECT = FOLDER.parents[1]
COLUMNS = (
    "tol_n", "tol_D, mm", "bodies", "of micro", "joints", "peak multiplier", "of micro",
    "as rigid bodies: sequence", "stiffness, kN/mm", "of micro", "time, s", "of micro",
)  # fmt: skip
STUDIES = {"table1": "benchmark1", "benchmark2": "benchmark2"}
"""folder of the study and name of its tables and figures -> case file in templates"""
BENCHMARKS = ("benchmark 1", "benchmark 2")
SHOWN = ("every stone", "automatic, 1%", "automatic, 2%", "automatic, 5%")
AUTOMATIC = (
    "wall", "margin", "bodies", "joints", "FE peak", "of micro-FE", "choosing, s", "FE, s", "time of micro-FE",
)  # fmt: skip
JUMPS = (
    "curve", "increments", "largest fall between two, % of the peak", "from, to, mm",
    "falls above 0.1 %", "above 0.5 %",
)  # fmt: skip
FIGURES = {"table": "sheet", "curves": "curves", "mechanisms": "mechanisms"}
"""picture of a study -> its name in docs/figures"""


def main() -> None:
    """Write table1.md from the studies that are there; stop when one is missing."""
    given = [Path(folder) for folder in sys.argv[1:]]
    page = (FOLDER / "table1_head.md").read_text()
    for number, (name, case) in enumerate(STUDIES.items()):
        folder = given[number] if number < len(given) else PROJECT / "results" / name
        if not (folder / "table.csv").exists():
            raise SystemExit(f"{folder}: no finished study; run make {name} first")
        page = page.replace(f"{{{{{name}}}}}", table(folder, rigid_multipliers(folder, case)))
        copy_figures(folder, name, page)
    page = page.replace("{{automatic}}", automatic(FOLDER / "tolerances.csv"))
    (FOLDER / "table1.md").write_text(page.replace("{{jumps}}", jumps(PROJECT / "tests" / "regression")))


def jumps(folder: Path) -> str:
    """Return how much the base shear of the stored curves falls from one increment to the next, in a table."""
    rows = []
    for name in ("benchmark1", "benchmark2"):
        for model in ("macro", "micro"):
            curve = np.genfromtxt(folder / name / f"{model}.csv", delimiter=",", names=True)
            shear, moved = curve["base_shear_N"] / curve["base_shear_N"].max(), curve["control_displacement_m"]
            steps = np.diff(shear)
            place = int(steps.argmin())
            between = f"{1e3 * (moved[place] - moved[0]):.2f} to {1e3 * (moved[place + 1] - moved[0]):.2f}"
            falls = [f"{np.sum(steps < -part)}" for part in (1e-3, 5e-3)]
            rows.append([f"{name}, {model}", str(len(shear)), f"{-100 * steps.min():.2f}", between, *falls])
    lines = [JUMPS, ["---"] * len(JUMPS), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def automatic(file: Path) -> str:
    """Return the table of macroblocks that choose themselves, benchmarks 1 and 2, from that of all walls."""
    with file.open(newline="") as opened:
        records = [r for r in csv.DictReader(opened) if r["wall"] in BENCHMARKS and r["macroblocks"] in SHOWN]
    rows = [
        [
            f"{record['wall']} ({record['stones']} stones)",
            record["macroblocks"].removeprefix("automatic, "),
            record["bodies"],
            record["joints"],
            f"{float(record['peak']):.4f}",
            f"{float(record['peak_over_micro']):.3f}",
            f"{float(record['choosing_s']):.1f}",
            f"{float(record['FE_s']):.1f}",
            f"{float(record['time_over_micro']):.2f}",
        ]
        for record in records
    ]
    lines = [AUTOMATIC, ["---"] * len(AUTOMATIC), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def table(folder: Path, rigid: Callable[[str], str]) -> str:
    """Return the table of a study in Markdown; `rigid` tells the multiplier as rigid bodies by the name of a run."""
    with (folder / "table.csv").open(newline="") as file:
        rows = [_row(record, rigid(record["run"])) for record in csv.DictReader(file)]
    lines = [COLUMNS, ["---"] * len(COLUMNS), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _row(record: dict[str, str], rigid: str) -> list[str]:
    def number(key: str, form: str, factor: float = 1.0) -> str:
        return format(float(record[key]) * factor, form) if record[key] else ""

    distance = record["tol_D_m"]
    return [
        record["tol_n"],
        distance if distance in ("none", "") else number("tol_D_m", "g", 1e3),
        record["bodies"],
        number("bodies_over_micro", ".3f"),
        record["joints"],
        number("peak_multiplier", ".4f"),
        number("peak_over_micro", ".3f"),
        rigid,
        number("initial_stiffness_N_per_m", ".2f", 1e-6),
        number("stiffness_over_micro", ".2f"),
        number("seconds", ".1f"),
        number("seconds_over_micro", ".2f"),
    ]


def rigid_multipliers(folder: Path, name: str) -> Callable[[str], str]:
    """Return what gives "sequence" for a run of the study of templates/NAME.toml, each run once."""
    case = read_case(PROJECT / "templates" / f"{name}.toml")
    assemblage = find_joints(read_wall(case), case.joints)

    loads = loads_on(assemblage.wall, case.load)

    @cache
    def multiplier(run: str) -> str:
        return " / ".join(_multipliers(assemblage, folder / "runs" / run / "macroblocks.json", loads))

    return multiplier


def _multipliers(assemblage: Assemblage, file: Path, loads: Loads) -> Iterator[str]:
    bodies = np.array([entry["body"] for entry in json.loads(file.read_text())["body_of_block"]])
    found = merged_multiplier(assemblage, bodies, "sequence", loads=loads)
    yield "not settled" if found is None else f"{found:.4f}"


def copy_figures(folder: Path, name: str, page: str) -> None:
    """Copy the pictures that the page shows to docs/figures."""
    for picture, shown in FIGURES.items():
        target = f"{name}_{shown}.png"
        if target in page:
            shutil.copyfile(folder / "figures" / f"{picture}.png", FOLDER.parent / "figures" / target)


if __name__ == "__main__":
    main()
