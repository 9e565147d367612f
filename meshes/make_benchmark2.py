"""The wall of benchmark 2, drawn once: python meshes/make_benchmark2.py writes benchmark2.json beside this file.

Szabo, Funari and Lourenco (2023) give the stones' sizes, thickness, weight and friction of their benchmark 2, but no
outline: 1.4 m x 2.8 m with an opening of 0.45 m x 0.7 m in the middle is this project's. Coordinates are rounded to
0.1 mm, as they stand in the file.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from orchestrator.masonry.patterns import IrregularCourses, irregular_courses
from orchestrator.masonry.wall import Wall

# seed 4 of 1 to 5; the others:
# docs/studies/benchmark2_seeds.md
PATTERN = IrregularCourses(
    length=1.4,
    height=2.8,
    thickness=0.3,
    widths=(0.12, 0.26),
    heights=(0.09, 0.13),
    openings=((0.475, 0.925, 1.05, 1.75),),
    unit_weight=19.4e3,
    friction=0.75,
    seed=4,
)


def block_file(wall: Wall) -> str:
    """Return the text of the block file, one block a line."""
    head = {
        "name": "benchmark 2: slender wall with one opening, irregular courses",
        "source": "stone sizes and material: Szabo, Funari and Lourenco 2023; outline and stones: this project",
        "remark": f"made by meshes/make_benchmark2.py, seed {PATTERN.seed}; the paper gives no outline",
        "units": {"length": "m", "unit_weight": "kN/m3"},
        "thickness": wall.thickness,
        "unit_weight": PATTERN.unit_weight / 1e3,
        "friction": wall.friction,
    }
    rows = [json.dumps({"id": b.id, "polygon": np.round(b.polygon, 4).tolist(), "fixed": b.fixed}) for b in wall.blocks]
    opening = json.dumps(head, indent=1).removesuffix("\n}")
    return opening + ',\n "blocks": [\n  ' + ",\n  ".join(rows) + "\n ]\n}\n"


if __name__ == "__main__":
    path = Path(__file__).with_name("benchmark2.json")
    path.write_text(block_file(irregular_courses(PATTERN)), encoding="utf-8")
