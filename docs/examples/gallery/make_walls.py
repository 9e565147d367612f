"""Block files of the gallery: python docs/examples/gallery/make_walls.py writes them beside this file.

Coordinates are rounded to a micrometre, alike for both stones of a joint. Walls in row notation and in space, and those
of templates/, need no file here.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from orchestrator.masonry.patterns import Arch, IrregularCourses, Rubble, arch_on_piers, irregular_courses, rubble
from orchestrator.masonry.wall import Wall

WINDOWS = tuple((x - 0.55, x + 0.55, sill, head) for x in (2.0, 6.0, 10.0) for sill, head in ((4.4, 6.2), (7.9, 9.5)))
DOORS = tuple((x - 0.65, x + 0.65, 0.0, 2.4) for x in (2.0, 6.0, 10.0))

WALLS = {
    "rubble": rubble(Rubble(4.5, 3.6, 0.32, openings=((0.9, 1.8, 0.0, 2.1), (2.8, 3.6, 1.2, 2.2)), seed=3)),
    "three_storeys": irregular_courses(
        IrregularCourses(
            length=12.0,
            height=10.8,
            thickness=0.6,
            widths=(0.28, 0.52),
            heights=(0.2, 0.28),
            overlap=0.06,
            openings=WINDOWS + DOORS,
            bearing=0.25,
            unit_weight=20e3,
            friction=0.65,
            seed=1,
        )
    ),
    "tied": irregular_courses(
        IrregularCourses(
            length=6.0,
            height=6.4,
            thickness=0.5,
            widths=(0.3, 0.6),
            heights=(0.24, 0.34),
            overlap=0.08,
            openings=tuple((x, x + 1.0, y, y + 1.7) for x in (1.1, 3.9) for y in (0.9, 4.0)),
            bearing=0.25,
            unit_weight=20e3,
            friction=0.65,
            seed=2,
        )
    ),
    "arch": arch_on_piers(Arch(21, 1.5, 0.35, np.pi, 6, 0.8, 2.1, 0.6)),
}


def block_file(name: str, wall: Wall) -> str:
    """Return the text of the block file, one block a line."""
    head = {
        "name": name.replace("_", " "),
        "source": "this project: docs/examples/gallery/make_walls.py",
        "units": {"length": "m", "unit_weight": "N/m3"},
        "thickness": wall.thickness,
        "unit_weight": wall.blocks[-1].unit_weight,
        "friction": wall.friction,
    }
    rows = [json.dumps({"id": b.id, "polygon": b.polygon.round(6).tolist(), "fixed": b.fixed}) for b in wall.blocks]
    return json.dumps(head, indent=1).removesuffix("\n}") + ',\n "blocks": [\n  ' + ",\n  ".join(rows) + "\n ]\n}\n"


if __name__ == "__main__":
    for name, wall in WALLS.items():
        Path(__file__).with_name(f"{name}.json").write_text(block_file(name, wall), encoding="utf-8")
