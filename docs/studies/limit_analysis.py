"""Micro limit analysis of all walls we have, seen from both sides and pushed both ways: how far is the answer unique?

    python docs/studies/limit_analysis.py [number of random walls]

writes limit_analysis.csv and limit_analysis.md beside this file once all walls are done. Each row is kept in
build/limit_analysis under the hash of the code that made it: a study that was stopped goes on, one of other code begins
anew, and the table never mixes the two. Every non-associative state that has converged is checked without the solver
(limit_analysis/validation.py); `mirror` is the difference between the headline of a wall and that of its mirror image
under the opposite load.
"""

from __future__ import annotations

import csv
import hashlib
import json
import sys
from dataclasses import replace
from pathlib import Path
from time import perf_counter

import numpy as np
import scipy.sparse as sp
from scipy.optimize import linprog

from orchestrator.basis.arrays import read_only
from orchestrator.basis.errors import CaseError, ConvergenceError
from orchestrator.limit_analysis import LimitAnalysis, LimitState, analyse
from orchestrator.limit_analysis.paper.equilibrium import assemble_equilibrium
from orchestrator.limit_analysis.paper.yield_conditions import coulomb, yield_matrix
from orchestrator.limit_analysis.validation import validate
from orchestrator.loads import Loads, LoadSettings, loads_on
from orchestrator.masonry.joints import Assemblage, JointSettings, find_joints
from orchestrator.masonry.patterns import IrregularCourses, irregular_courses
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.masonry.wall import Wall

FOLDER = Path(__file__).parent
ROOT = FOLDER.parents[1]
FILES = sorted([*(ROOT / "tests" / "data").glob("*.json"), ROOT / "meshes" / "ferris_tinloi_wall6.json"])
PUBLISHED = {
    "ferris_tinloi_wall1": "0.643, 0.640", "ferris_tinloi_wall3": "0.404, 0.356",
    "ferris_tinloi_wall4": "0.332, 0.264", "ferris_tinloi_wall6": "0.347, 0.297",
    "orduna_panel_set11": "-, 0.69", "orduna_panel_set13": "-, 0.49",
}  # fmt: skip
"""associative, non-associative (sources in the block files)"""
RANDOM_WALLS = 50
MEAN_STONE = 0.19 * 0.11
"""m2, of the default pattern"""
STATES = ("sequence", "path", "lowest")


def random_wall(seed: int) -> Wall:
    """Return an irregular wall of 20-500 blocks, mu 0.3-0.9, as high as long to within a factor of 2.

    Odd seeds above 60 blocks have an opening.
    """
    random = np.random.default_rng(1000 + seed)
    blocks, friction = 20 * 25 ** random.uniform(), round(float(random.uniform(0.3, 0.9)), 2)
    aspect = random.uniform(0.5, 2.0)
    with_opening = bool(seed % 2) and blocks > 60
    length = float(np.sqrt(blocks * MEAN_STONE / aspect)) * (1.08 if with_opening else 1.0)
    height = round(length * aspect, 3)
    length = round(length, 3)
    opening = tuple(round(part, 3) for part in (0.38 * length, 0.6 * length, 0.25 * height, 0.65 * height))
    openings = (opening,) if with_opening else ()
    pattern = IrregularCourses(length, height, openings=openings, bearing=0.1, friction=friction, seed=seed)
    try:
        return irregular_courses(pattern)
    except CaseError:  # a long course for which 2000 draws found no stones (seed 34): let head joints come nearer
        return irregular_courses(replace(pattern, overlap=0.5 * pattern.overlap))


def mirrored(wall: Wall) -> Wall:
    """Return the wall seen from behind."""
    blocks = tuple(replace(b, polygon=read_only((b.polygon * [-1.0, 1.0])[::-1])) for b in wall.blocks)
    return replace(wall, blocks=blocks)


def row(name: str, wall: Wall, direction: int) -> dict[str, object]:
    """Analyse a wall and its mirror image; return their row of the table."""
    began = perf_counter()
    assemblage = find_joints(wall, JointSettings())
    free = sum(not block.fixed for block in wall.blocks)
    start: dict[str, object] = {"wall": name, "blocks": free, "friction": wall.friction, "direction": f"{direction:+d}"}
    image = find_joints(mirrored(wall), JointSettings())
    loads = loads_on(assemblage.wall, LoadSettings("+x" if direction > 0 else "-x"))
    mirrored_loads = loads_on(image.wall, LoadSettings("-x" if direction > 0 else "+x"))
    try:
        found = analyse(assemblage, loads=loads)
        seconds = perf_counter() - began
        behind = analyse(image, loads=mirrored_loads)
    except (CaseError, ConvergenceError) as error:
        return {**start, "remark": str(error).split(":", 1)[1][:60].strip()}
    if found.non_associative_range is None:
        found = replace(found, remarks=(falls_alone(assemblage, loads, found.associative),))
    whole = ("sequence",) if found.local_failures else STATES  # the others are states of what is left
    complaints = [text for state in whole for text in invalid(assemblage, loads, state, getattr(found, state))]
    loose = f"{len(found.local_failures)} local failures first" if found.local_failures else ""
    return {
        **start,
        "associative": shown(found.associative),
        "sequence": shown(found.sequence),
        "met by loading": shown(found.path),
        "lowest found": shown(found.lowest),
        "published": PUBLISHED.get(name, ""),
        "headline": found.headline.flow_rule.replace("_", " "),
        "mirror": f"{abs(found.headline.load_multiplier - behind.headline.load_multiplier):.0e}",
        "linear programs": "+".join(str(len(s.records)) for s in states_of(found)),
        "time, s": f"{seconds:.1f}",
        "converged": "yes" if found.non_associative_range and not complaints else "no",
        "remark": "; ".join(complaints) or (loose if found.non_associative_range else found.remarks[0]),
    }


def falls_alone(assemblage: Assemblage, loads: Loads, state: LimitState) -> str:
    """Say at which multipliers the fastest block of a state may slide down alone, for which the live load does nothing.

    All joint forces within Coulomb's law that balance and from which friction takes the block's weight while it falls:
    the least and the largest multiplier among them, with HiGHS.
    """
    equilibrium, friction = assemble_equilibrium(assemblage, loads), coulomb(assemblage)
    fastest = int(np.argmax(np.hypot(*state.mechanism.velocities[equilibrium.free_blocks, :2].T)))
    falls = np.zeros(len(equilibrium.dead_load))
    falls[3 * fastest + 1] = -1.0
    resisted = np.zeros((len(friction.slope), 3))
    resisted[:, :2] = (friction.slope * np.abs(equilibrium.joint_rates(falls)[:, 2]))[:, None]
    balance = sp.hstack([equilibrium.matrix, -sp.csc_matrix(equilibrium.live_load[:, None])])
    power = sp.csc_matrix(np.append(resisted.ravel(), 0.0))
    equal, values = sp.vstack([balance, power]), np.append(equilibrium.dead_load, equilibrium.dead_load @ falls)
    C_T = yield_matrix(friction)
    within = sp.hstack([-C_T, sp.csc_matrix((C_T.shape[0], 1))])
    ends = []
    for sign in (1.0, -1.0):
        objective = np.append(np.zeros(resisted.size), sign)
        end = linprog(objective, within, np.zeros(C_T.shape[0]), equal, values, bounds=(None, None), method="highs")
        if end.status != 0:
            return ""
        ends.append(float(end.x[-1]))
    block = assemblage.wall.blocks[equilibrium.free_blocks[fastest]].id
    return f"block {block} may fall alone at any multiplier from {ends[0]:.4f} to {ends[1]:.4f}"


def states_of(found: LimitAnalysis) -> list[LimitState]:
    """Return the states that have programs of their own."""
    states = (found.associative, found.sequence, found.path)
    return [state for state in states if state is not None]


def invalid(assemblage: Assemblage, loads: Loads, name: str, state: LimitState | None) -> list[str]:
    """Return what is wrong with a state that claims to have converged."""
    if state is None or not state.converged:
        return []
    equilibrium = assemble_equilibrium(assemblage, loads)
    return [f"{name}: {text}" for text in validate(assemblage, equilibrium, coulomb(assemblage), state).complaints]


def shown(state: LimitState | None) -> str:
    """Return a multiplier; in brackets when it has not converged."""
    if state is None:
        return "none"
    return f"{state.load_multiplier:.5f}" if state.converged else f"({state.load_multiplier:.5f})"


def main() -> None:
    """Run all walls."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else RANDOM_WALLS
    kept = ROOT / "build" / "limit_analysis" / code_version()
    kept.mkdir(parents=True, exist_ok=True)
    rows: list[dict[str, object]] = []
    walls = [(path.stem, lambda path=path: read_blocks(path)) for path in FILES]
    walls += [(f"random {seed}", lambda seed=seed: random_wall(seed)) for seed in range(count)]
    for name, made in walls:
        for direction in (1, -1):
            file = kept / f"{name.replace(' ', '_')}{direction:+d}.json"
            if not file.exists():
                file.write_text(json.dumps(row(name, made(), direction)))
            rows.append(json.loads(file.read_text()))
            print(", ".join(f"{key} {value}" for key, value in rows[-1].items()), flush=True)
    write(rows)


def code_version() -> str:
    """Return a hash of this file and of all code that the analysis of a wall runs through."""
    package = ROOT / "orchestrator"
    rooms = ("basis", "geometry", "masonry", "loads", "limit_analysis")
    files = [Path(__file__), *sorted(file for room in rooms for file in (package / room).rglob("*.py"))]
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()[:12]


def write(rows: list[dict[str, object]]) -> None:
    """Write limit_analysis.csv, and limit_analysis.md below the text of limit_analysis_head.md."""
    names = list(max(rows, key=len))
    with (FOLDER / "limit_analysis.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, names, restval="", lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    lines = [names, ["---"] * len(names), *([str(row.get(name, "")) for name in names] for row in rows)]
    table = "\n".join(f"| {' | '.join(line)} |" for line in lines)
    answered = [row for row in rows if "converged" in row]
    settled = [row for row in answered if row["converged"] == "yes"]
    same = sum(float(str(row["mirror"])) <= 1e-5 for row in answered)
    summary = (
        f"{len(settled)} of {len(answered)} analyses end with valid converged non-associative states; "
        f"{same} have the headline of their mirror image to 1e-5."
    )
    head = (FOLDER / "limit_analysis_head.md").read_text()
    (FOLDER / "limit_analysis.md").write_text(f"{head}\n{summary}\n\n{table}\n")


if __name__ == "__main__":
    main()
