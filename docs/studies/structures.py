"""Ordinary structures, each drawn by a few lines: limit analysis, micro-FE and macroblocks.

    python docs/studies/structures.py

writes structures.csv, structures.md (after structures_head.md) and ../figures/structures.png beside this file, every
structure along +x, and those of OF_TWO_SIDES along -x. A row is made as those of macroblock_peaks.py are.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise, zip_longest
from pathlib import Path

import macroblock_peaks
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from stored import table as in_markdown

from orchestrator import JointSettings, LoadSettings, analyse, find_joints, loads_on
from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.masonry.block_properties import block_centroids
from orchestrator.masonry.patterns import ArchedOpening, ArchedWall, IrregularCourses, arched_wall
from orchestrator.masonry.wall import Block, Wall

FOLDER = Path(__file__).parent
COLUMNS = ("structure", "direction", "stones", "headline", "moved", "pressed", "micro-FE", "micro_s", "bodies")
COLUMNS += ("macroblocks", "off", "finite_elements_s", "local", "ended")
DRAWN = 0.15
"""part of the structure's height that the fastest block of a picture moves by"""

Stone = Sequence[tuple[float, float]]


def box(x: float, y: float, width: float, height: float) -> Stone:
    """Return a rectangle from its lower left corner."""
    return [(x, y), (x + width, y), (x + width, y + height), (x, y + height)]


def structure(name: str, stones: Iterable[Stone], supports: Sequence[Stone], friction: float = 0.6) -> Wall:
    """Return stones of 20 kN/m3, 0.5 m thick, on supports."""
    outlines = [*supports, *stones]
    blocks = (
        Block(number, read_only(np.round(np.array(outline, dtype=float), 9)), number < len(supports), 20e3)
        for number, outline in enumerate(outlines)
    )
    return Wall(name, tuple(blocks), 0.5, friction)


def courses(
    left: float, right: float, base: float, count: int, height: float, length: float, lean: float = 0.0
) -> Iterator[Stone]:
    """Yield running bond of which every course is `lean` shorter at each end than the one below."""
    for number in range(count):
        start, end = left + lean * number, right - lean * number
        joints = np.arange(start + length * (0.5 if number % 2 else 1.0), end - 0.25 * length, length)
        for a, b in pairwise([start, *joints, end]):
            yield box(a, base + number * height, b - a, height)


def ring(
    x: float, y: float, radius: float, depth: float, count: int, first: float = 180.0, last: float = 0.0
) -> Iterator[Stone]:
    """Yield voussoirs about a centre, from one angle to another, degrees."""
    angle = np.radians(np.linspace(first, last, count + 1))
    rays = np.column_stack([np.cos(angle), np.sin(angle)])
    for a, b in pairwise(rays):
        inner, outer = radius, radius + depth
        yield [(x + r * ray[0], y + r * ray[1]) for r, ray in ((inner, b), (outer, b), (outer, a), (inner, a))]


def colonnade(columns: int, drums: int, width: float, height: float) -> Wall:
    """Columns of drums with capitals under architraves that meet above them."""
    pitch, stones = 1.8, list[Stone]()
    for column in range(columns):
        x = column * pitch
        stones += [box(x - width / 2, k * height / drums, width, height / drums) for k in range(drums)]
        stones.append(box(x - 0.7 * width, height, 1.4 * width, 0.2))
    ends = [-0.7 * width, *(pitch * k for k in range(1, columns - 1)), pitch * (columns - 1) + 0.7 * width]
    stones += [box(a, height + 0.2, b - a, 0.4) for a, b in pairwise(ends)]
    return structure(f"{columns} columns of {drums} drums", stones, [box(-1.0, -0.4, pitch * columns, 0.4)])


def gable(degrees: float, friction: float) -> Wall:
    """A gable of 4 m above an eave of 1.5 m; courses are cut along its slopes."""
    width, height, length, eave, slope = 4.0, 0.25, 0.6, 1.5, np.tan(np.radians(degrees))
    stones, top = list[Stone](), eave + 0.5 * width * slope
    levels = np.arange(0.0, top - 0.5 * height, height)
    for number, (low, high) in enumerate(pairwise([*levels, top])):
        below, above = (max(0.0, (level - eave) / slope) for level in (low, high))
        shift = 0.5 * length if number % 2 else length
        cuts = [x for x in np.arange(shift, width, length) if above + 0.15 < x < width - above - 0.15]
        under, over = (pairwise([end, *cuts, width - end]) for end in (below, above))
        for (a, b), (c, d) in zip(under, over, strict=True):
            stones.append([(a, low), (b, low), (d, high), *([(c, high)] if d - c > 1e-9 else [])])
    return structure(f"gable of {degrees:g} degrees", stones, [box(-0.5, -0.4, 5.0, 0.4)], friction)


def arch_on_piers(pier: float, height: float, voussoirs: int) -> Wall:
    """A semicircle of 1 m span on two piers in running bond."""
    stones = [*courses(-0.5 - pier, -0.5, 0.0, round(height / 0.25), 0.25, 0.4)]
    stones += [*courses(0.5, 0.5 + pier, 0.0, round(height / 0.25), 0.25, 0.4)]
    stones += [*ring(0.0, height, 0.5, min(pier, 0.4), voussoirs)]
    return structure(f"arch of {voussoirs} voussoirs on piers of {pier:g} m", stones, [box(-2.0, -0.4, 4.0, 0.4)])


def buttressed() -> Wall:
    """The section of a wall of two leaves that are bonded, with a stepped buttress on its right."""
    stones, height = list[Stone](), 0.3
    for number in range(12):
        out = 0.75 - 0.15 * (number // 3) if number < 9 else 0.0
        joint = 0.6 if number % 2 and out else 0.3
        stones += [box(0.0, number * height, joint, height), box(joint, number * height, 0.6 + out - joint, height)]
    return structure("wall with a buttress, section", stones, [box(-1.0, -0.4, 4.0, 0.4)])


def flying_buttress() -> Wall:
    """A pier, and a quarter of an arch from its top to a wall."""
    stones = [*courses(-2.7, -1.8, 0.0, 7, 0.25, 0.5), *courses(0.0, 0.7, 0.0, 16, 0.25, 0.4)]
    stones += [*ring(0.0, 1.75, 1.8, 0.25, 7, 180.0, 90.0)]
    return structure("flying buttress", stones, [box(-3.5, -0.4, 5.0, 0.4)])


def corbelled() -> Wall:
    """An opening of 1 m that stones close, each 0.12 m beyond the one below."""
    stones, height = list[Stone](), 0.25
    for number in range(6):
        out, end = max(0.0, 0.12 * (number - 1)), 0.5 if number % 2 else 0.8
        stones += [box(-1.5, number * height, end, height), box(-1.5 + end, number * height, 1.0 - end + out, height)]
        stones += [
            box(0.5 - out, number * height, 1.0 - end + out, height),
            box(1.5 - end, number * height, end, height),
        ]
    for number in range(6, 9):
        joints = (-1.5, -0.5, 0.5, 1.5) if number % 2 == 0 else (-1.5, -1.0, 0.0, 1.0, 1.5)
        stones += [box(a, number * height, b - a, height) for a, b in pairwise(joints)]
    return structure("corbelled opening", stones, [box(-2.0, -0.4, 4.0, 0.4)])


def stepped_foundation() -> Wall:
    """Running bond on ground that steps down by a course."""
    stones = [*courses(1.2, 3.0, -0.3, 1, 0.3, 0.6), *courses(0.0, 3.0, 0.0, 7, 0.3, 0.6)]
    return structure("wall on a step", stones, [box(-0.5, -0.6, 1.7, 0.6), box(1.2, -0.6, 2.3, 0.3)])


def sloping_beds() -> Wall:
    """Running bond whose beds rise by 8 degrees to the right."""
    angle = np.radians(8.0)
    turn: FloatArray = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    stones = [[*map(tuple, np.array(stone) @ turn)] for stone in courses(0.0, 2.4, 0.0, 6, 0.3, 0.6)]
    ground = [*map(tuple, np.array(box(-1.0, -0.4, 4.4, 0.4)) @ turn)]
    return structure("wall with sloping beds", stones, [ground])


def two_leaves() -> Wall:
    """A pier of two leaves and a core, a header in every third course."""
    stones = list[Stone]()
    for number in range(10):
        joints = (0.0, 0.8) if number % 3 == 2 else (0.0, 0.3, 0.5, 0.8)
        stones += [box(a, 0.2 * number, b - a, 0.2) for a, b in pairwise(joints)]
    return structure("pier of two leaves, section", stones, [box(-1.0, -0.4, 3.0, 0.4)])


def relieving_arch() -> Wall:
    """Two piers, an arch on them, and one stone that fills it."""
    stones = [*courses(-1.4, -0.6, 0.0, 8, 0.25, 0.4), *courses(0.6, 1.4, 0.0, 8, 0.25, 0.4)]
    arch = [*ring(0.0, 2.0, 0.8, 0.35, 9)]
    stones += [*arch, [(-0.8, 2.0), (0.8, 2.0), *(stone[0] for stone in arch[-2::-1])]]
    return structure("relieving arch", stones, [box(-2.0, -0.4, 4.0, 0.4)])


def bell_gable() -> Wall:
    """A wall of 3 m with two arched openings and a few courses above."""
    openings = tuple(ArchedOpening(x, x + 0.65, 1.0, 2.0, depth=0.25, voussoirs=7) for x in (0.5, 1.85))
    wall = IrregularCourses(3.0, 3.4, widths=(0.3, 0.5), heights=(0.2, 0.25), seed=3)
    return arched_wall(ArchedWall(wall, openings))


def arcade() -> Wall:
    """Three arches of 1.2 m on piers of 0.7 m."""
    openings = tuple(ArchedOpening(0.7 + 1.9 * k, 1.9 + 1.9 * k, 0.0, 1.5, depth=0.3, voussoirs=9) for k in range(3))
    wall = IrregularCourses(6.4, 3.0, widths=(0.3, 0.5), heights=(0.2, 0.3), seed=4)
    return arched_wall(ArchedWall(wall, openings))


STRUCTURES = {
    "2 columns of 4 drums": colonnade(2, 4, 0.5, 3.0),
    "3 columns of 6 drums": colonnade(3, 6, 0.6, 3.6),
    "4 columns of 3 drums": colonnade(4, 3, 0.4, 2.4),
    "gable of 45 degrees": gable(45.0, 0.6),
    "gable of 30 degrees, friction 0.9": gable(30.0, 0.9),
    "arch of 7 voussoirs on piers": arch_on_piers(0.5, 1.5, 7),
    "arch of 9 voussoirs on piers": arch_on_piers(0.7, 2.0, 9),
    "bell gable": bell_gable(),
    "arcade": arcade(),
    "relieving arch": relieving_arch(),
    "corbelled opening": corbelled(),
    "battered wall": structure(
        "battered wall", courses(0.0, 2.4, 0.0, 8, 0.25, 0.5, 0.06), [box(-1.0, -0.4, 4.4, 0.4)], 0.5
    ),
    "pier of two leaves": two_leaves(),
    "wall with a buttress": buttressed(),
    "flying buttress": flying_buttress(),
    "wall on a step": stepped_foundation(),
    "wall with sloping beds": sloping_beds(),
}
OF_TWO_SIDES = (
    "wall with a buttress",
    "flying buttress",
    "wall on a step",
    "wall with sloping beds",
    "bell gable",
    "arcade",
)


def of(number: int) -> tuple[str, Wall]:
    """Return the name and the wall of a structure."""
    return [*STRUCTURES.items()][number]


def runs() -> list[int]:
    """Return the runs: twice the number of a structure, and one more along -x."""
    return [2 * n + k for n, name in enumerate(STRUCTURES) for k in range(2 if name in OF_TWO_SIDES else 1)]


def picture(run: int, axes: Axes) -> None:
    """Draw the structure and its mechanism of limit analysis."""
    name, wall = of(run // 2)
    assemblage, direction = find_joints(wall, JointSettings()), "-x" if run % 2 else "+x"
    state = analyse(assemblage, loads=loads_on(wall, LoadSettings(direction))).headline
    corners = np.vstack([block.polygon for block in wall.blocks if not block.fixed])
    scale = DRAWN * np.ptp(corners[:, 1]) / state.mechanism.largest_displacement
    moving = zip(wall.blocks, block_centroids(wall), state.mechanism.velocities, strict=True)
    for block, centroid, (along, up, turn) in moving:
        arm = block.polygon - centroid
        moved = block.polygon + scale * (np.array([along, up]) + turn * np.column_stack([-arm[:, 1], arm[:, 0]]))
        axes.fill(*moved.T, facecolor="0.6" if block.fixed else "0.93", edgecolor="0.15", linewidth=0.5)
    axes.set_title(f"{name}, {direction}: {state.load_multiplier:.3f}", fontsize=6)
    axes.set_aspect("equal")


def main() -> None:
    """Run all, two at a time, and write table and picture."""
    rows = list[dict[str, object]]()
    for done in macroblock_peaks.each(runs(), of):
        rows = [{"structure": row["family"], "stones": row["blocks"]} | row for row in done]
    table = [{name: row.get(name, "") for name in COLUMNS} for row in rows]
    head = (FOLDER / "structures_head.md").read_text()
    (FOLDER / "structures.md").write_text(f"{head}\n{macroblock_peaks.said(rows)}\n\n{in_markdown(table)}\n")
    macroblock_peaks.write_csv(rows, "structures.csv")
    figure = Figure(figsize=(9.0, 10.0), layout="constrained")
    for run, axes in zip_longest(runs(), figure.subplots(6, 4).ravel()):
        axes.axis("off")
        if run is not None:
            picture(run, axes)
    figure.savefig(FOLDER.parent / "figures" / "structures.png", dpi=150)


if __name__ == "__main__":
    main()
