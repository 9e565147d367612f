"""What finer elements do to the peak: walls of all families, every stone a body, elements of a half and a quarter.

    python docs/studies/mesh_size.py

writes mesh_size.csv and mesh_size.md (mesh_size_head.md with the table put in) beside this file. The five walls of
rigid_limit.py and ten of path.py are pushed along +x in large displacements, by `push` with its defaults but for
the mesh. A run is kept in results/mesh_size as soon as it is done and not run again: delete that folder when the
mechanics change.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import path
import rigid_limit
from stored import RESULTS, markdown, stored, written_after_each

from orchestrator import JointSettings, MeshSettings, analyse, find_joints, make_bodies, one_body_per_block, push
from orchestrator.masonry.wall import Wall
from orchestrator.storage import write_csv, write_text

FOLDER = Path(__file__).parent
PAIRS = (4, 12, 13, 14, 15, 16, 25, 26, 31, 46)
"""pairs of pushovers of path.py: one of irregular courses, eight that were drawn, one of larger rubble"""
SHARES = (1.0, 0.5, 0.25)
"""element sizes, over the default"""
COLUMNS = (
    "wall", "stones", "size_over_default", "nodes", "peak", "relative_to_default", "peak_mm", "valid", "rigid",
    "rigid_moved", "seconds",
)  # fmt: skip


def walls() -> dict[str, Wall]:
    """Return the walls by their names."""
    drawn = {f"{family}, run {2 * pair}": wall for pair in PAIRS for family, wall in [path.wall_of(pair)]}
    return rigid_limit.walls() | drawn


def pushed(wall: Wall, share: float) -> dict[str, Any]:
    """Return peak and cost of one pushover with elements of a share of the default's size, and limit analysis."""
    assemblage = find_joints(wall, JointSettings())
    partition, analysis = one_body_per_block(assemblage), analyse(assemblage)
    size = share * MeshSettings().size_of(make_bodies(assemblage, partition))
    done = push(assemblage, analysis, partition, mesh=MeshSettings(size=size)).summary
    return {
        "stones": done.bodies,
        "nodes": done.nodes,
        "peak": done.peak_multiplier,
        "peak_mm": 1e3 * done.displacement_at_peak,
        "valid": done.valid,
        "rigid": analysis.headline.load_multiplier,
        "rigid_moved": analysis.rigid_peak,
        "seconds": round(done.seconds["total"], 1),
    }


def rows() -> Iterator[dict[str, Any]]:
    """Yield a row for every size and wall: all walls with one size before the next."""
    of = walls()
    for share in SHARES:
        for name, wall in of.items():
            kept = RESULTS / "mesh_size" / name.replace(" ", "_")
            default, run = (stored(kept / f"{size:g}.json", partial(pushed, wall, size)) for size in (1.0, share))
            off = run["peak"] / default["peak"] - 1.0
            yield {"wall": name, "size_over_default": share, "relative_to_default": off, **run}


def write(done: list[dict[str, Any]]) -> None:
    """Write mesh_size.csv and mesh_size.md."""
    write_csv(FOLDER / "mesh_size.csv", COLUMNS, [[row[name] for name in COLUMNS] for row in done])
    cells = {(row["wall"], row["size_over_default"]): row for row in done}
    lines = []
    for name in dict.fromkeys(row["wall"] for row in done):
        default = cells[name, 1.0]
        finer = [cells.get((name, share)) for share in SHARES[1:]]
        moved = "–" if default["rigid_moved"] is None else f"{default['rigid_moved']:.4f}"
        rigid = [f"{default['rigid']:.4f}", moved, f"{default['peak']:.4f}"]
        off = ["not yet" if row is None else f"{row['relative_to_default']:+.2%}" for row in finer]
        lines.append([name, str(default["stones"]), *rigid, *off])
    heads = ["wall", "stones", "rigid, small", "rigid, moved", "default", *(f"× {share:g}" for share in SHARES[1:])]
    page = (FOLDER / "mesh_size_head.md").read_text()
    write_text(FOLDER / "mesh_size.md", page.replace("{{table}}", markdown(heads, lines)))


if __name__ == "__main__":
    written_after_each(rows(), COLUMNS, write)
