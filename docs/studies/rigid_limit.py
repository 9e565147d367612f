"""Rigid limit: what stiffness, slip tolerance, rate and increments do to the peak of five small walls, one at a time.

    python docs/studies/rigid_limit.py

writes rigid_limit.csv and rigid_limit.md (rigid_limit_head.md with the table put in) beside this file. Every stone is a
body, pushed along +x in large displacements with the defaults but for one factor; a curve ends 20 % below its peak, at
a top displacement of a thirtieth of the height, or with the fall of the wall. A run is left after LIMIT s of CPU time;
it is kept, with its curve, in results/rigid_limit as soon as it is done and not run again: delete that folder when the
mechanics change.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from stored import RESULTS, followed, markdown, stored, written_after_each

from orchestrator import (
    ContactSettings,
    ElasticSettings,
    JointSettings,
    SteppingSettings,
    analyse,
    find_joints,
    make_bodies,
    one_body_per_block,
    pushover_increments,
)
from orchestrator.basis.arrays import read_only
from orchestrator.masonry.patterns import (
    Arch,
    IrregularCourses,
    Rubble,
    arch_on_piers,
    irregular_courses,
    rubble,
    running_bond,
)
from orchestrator.masonry.wall import Block, Wall
from orchestrator.pushover.solids.elastic_constants import slip_tolerance_of
from orchestrator.storage import write_csv, write_text

FOLDER = Path(__file__).parent
Settings = TypeVar("Settings", ElasticSettings, ContactSettings, SteppingSettings)
LIMIT = 30.0
BOUND = 0.005
"""what the peak may depend on a factor by, as a share of it"""
FACTORS: dict[str, dict[str, float]] = {
    "default": {},
    "E × 10": {"elastic_modulus": 10.0},
    "E × 100": {"elastic_modulus": 100.0},
    "slip tolerance × 0.1": {"slip_tolerance": 0.1},
    "slip tolerance × 10": {"slip_tolerance": 10.0},
    "displacement increment × 0.5": {"displacement_increment": 0.5},
    "displacement increment × 2": {"displacement_increment": 2.0},
    "load increment × 0.5": {"load_increment": 0.5},
    "load increment × 2": {"load_increment": 2.0},
    "proximal share × 0.1": {"proximal_share": 0.1},
    "proximal share × 10": {"proximal_share": 10.0},
    "gravity increments × 4": {"gravity_increments": 4.0},
}
"""by how much which settings are multiplied; the default comes first"""
COLUMNS = (
    "wall", "stones", "soft_from", "factor", "peak", "relative_to_default", "peak_mm", "first_maximum",
    "first_relative_to_default", "first_fall", "fallen", "rows",
    "seconds", "end",
)  # fmt: skip


def column(width: float, height: float, blocks: int, friction: float = 0.65) -> Wall:
    """Return a stack of equal blocks (m) on a wider support: it rocks at width / (blocks x height)."""
    levels = np.arange(blocks) * height
    corners = np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])
    support = read_only(np.array([[-width, -height], [2 * width, -height], [2 * width, 0.0], [-width, 0.0]]))
    stones = [Block(k, read_only(corners + [0.0, y]), False, 20e3) for k, y in enumerate(levels, start=1)]
    return Wall("column", (Block(0, support, True, 20e3), *stones), 0.3, friction)


def walls() -> dict[str, Wall]:
    """Return the wall of each family, of 10 to 50 stones."""
    return {
        "column of 10": column(0.4, 0.2, 10),
        "running bond 2 x 5": running_bond(2, 5),
        "irregular courses": irregular_courses(IrregularCourses(0.8, 0.6, seed=1)),
        "rubble": rubble(Rubble(1.0, 0.8, stone=0.32, flatness=1.6, seed=4)),
        "segmental arch on piers": arch_on_piers(
            Arch(9, 1.3, 0.24, angle=2.0, courses=3, pier_width=0.6, pier_height=0.9, thickness=0.3)
        ),
    }


def scaled(settings: Settings, by: dict[str, float]) -> Settings:
    """Return settings with those fields multiplied that they have; whole numbers stay whole."""
    changed = {name: getattr(settings, name) * factor for name, factor in by.items() if hasattr(settings, name)}
    return replace(settings, **{k: round(v) if k == "gravity_increments" else v for k, v in changed.items()})


def pushed(wall: Wall, by: dict[str, float], expected: float) -> dict[str, Any]:
    """Return peak (share of the horizontal load), course and end of one pushover."""
    assemblage = find_joints(wall, JointSettings())
    height = max(block.polygon[:, 1].max() for block in wall.blocks)
    stepping = scaled(SteppingSettings(final_displacement=float(height) / 30), by)
    bodies = make_bodies(assemblage, one_body_per_block(assemblage))
    slip = slip_tolerance_of(bodies, ElasticSettings(), ContactSettings())
    increments = pushover_increments(
        bodies,
        elastic=scaled(ElasticSettings(), by),
        contact=scaled(ContactSettings(slip), by),
        stepping=stepping,
        expected_multiplier=expected,
    )
    curve, _, seconds = followed(increments, stepping, LIMIT)
    share = curve.base_shear_N / curve.horizontal_load_N[0]
    moved = 1e3 * (curve.control_displacement_m - curve.control_displacement_m[0])
    best = int(np.where(curve.moving, -np.inf, share).argmax())
    fell = np.flatnonzero(np.diff(curve.fallen_bodies))
    return {
        "peak": float(share[best]),
        "peak_mm": float(moved[best]),
        "first_fall": float(curve.load_multiplier[fell[0]]) if fell.size else "",
        "fallen": int(curve.fallen_bodies[-1]),
        "rows": len(share),
        "seconds": round(seconds, 1),
        "end": curve.stopped_because,
        "curve": np.column_stack([moved, share, curve.load_multiplier, curve.moving, curve.fallen_bodies]).tolist(),
    }


def rows() -> Iterator[dict[str, Any]]:
    """Yield a row for every factor and wall: all walls with one factor before the next."""
    of = walls()
    for factor, by in FACTORS.items():
        for name, wall in of.items():
            kept = RESULTS / "rigid_limit" / name.replace(" ", "_")
            limit = stored(kept / "limit_analysis.json", partial(limits, wall))
            default = stored(kept / "default.json", partial(pushed, wall, {}, limit["associative"]))
            run = stored(kept / f"{factor}.json", partial(pushed, wall, by, limit["associative"]))
            yield {
                "wall": name,
                "stones": sum(not block.fixed for block in wall.blocks),
                "soft_from": limit["soft_from"],
                "factor": factor,
                "relative_to_default": run["peak"] / default["peak"] - 1.0,
                "first_maximum": first_maximum(run["curve"]),
                "first_relative_to_default": first_maximum(run["curve"]) / first_maximum(default["curve"]) - 1.0,
                **run,
            }


def first_maximum(curve: list[list[float]]) -> float:
    """Return the largest base shear of static rows before it first falls by what a static row may be wrong by."""
    share = np.array([row[1] for row in curve if not row[3]])
    largest = np.maximum.accumulate(share)
    fell = np.flatnonzero(share < largest - SteppingSettings().out_of_balance * largest[-1])
    return float(largest[fell[0]] if fell.size else largest[-1])


def limits(wall: Wall) -> dict[str, Any]:
    """Return what limit analysis expects, and from which multiplier on it says that the wall is soft."""
    found = analyse(find_joints(wall, JointSettings()))
    return {
        "associative": found.associative.load_multiplier,
        "headline": found.headline.load_multiplier,
        "soft_from": found.soft_from,
    }


def write(done: list[dict[str, Any]]) -> None:
    """Write rigid_limit.csv and rigid_limit.md."""
    write_csv(FOLDER / "rigid_limit.csv", COLUMNS, [[row[name] for name in COLUMNS] for row in done])
    names = list(dict.fromkeys(row["wall"] for row in done))
    cells = {(row["wall"], row["factor"]): row for row in done}
    peaks = [f"{cells[name, 'default']['peak']:.4f}" for name in names]
    lines = [["**default: peak**", *peaks]]
    for factor in list(FACTORS)[1:]:
        lines.append([factor, *(_deviation(cells.get((name, factor))) for name in names)])
    page = (FOLDER / "rigid_limit_head.md").read_text()
    table = markdown(["peak, and by how much it differs", *names], lines)
    write_text(FOLDER / "rigid_limit.md", page.replace("{{table}}", table))


def _deviation(row: dict[str, Any] | None) -> str:
    """Return a cell: the deviation, above BOUND in bold and beside that of the first maximum; "left" after LIMIT s."""
    if row is None:
        return "not yet"
    off, first = row["relative_to_default"], row["first_relative_to_default"]
    said = f"{off:+.2%}" if abs(off) <= BOUND else f"**{off:+.2%}**, first maximum {first:+.2%}"
    return f"{said} (left)" if str(row["end"]).startswith("left") else said


if __name__ == "__main__":
    written_after_each(rows(), COLUMNS, write)
