"""The arched facade, drawn once: python meshes/make_arched_facade.py writes arched_facade.json beside this file.

A front of two storeys that this project drew, like many and none in particular: a door under a semicircular arch, three
windows under segmental arches, one with a stone lintel, quoins. Coordinates are written in full: neighbours share their
corners to the last digit.
"""

from __future__ import annotations

import json
from pathlib import Path

from orchestrator.masonry.patterns import ARCHED_FACADE, arched_wall
from orchestrator.masonry.wall import Wall


def block_file(wall: Wall) -> str:
    """Return the text of the block file, one block a line."""
    head = {
        "name": "arched facade",
        "source": "this project: ARCHED_FACADE of orchestrator/masonry/patterns",
        "remark": "made by meshes/make_arched_facade.py",
        "units": {"length": "m", "unit_weight": "kN/m3"},
        "thickness": wall.thickness,
        "unit_weight": ARCHED_FACADE.courses.unit_weight / 1e3,
        "friction": wall.friction,
    }
    rows = [json.dumps({"id": b.id, "polygon": b.polygon.tolist(), "fixed": b.fixed}) for b in wall.blocks]
    opening = json.dumps(head, indent=1).removesuffix("\n}")
    return opening + ',\n "blocks": [\n  ' + ",\n  ".join(rows) + "\n ]\n}\n"


if __name__ == "__main__":
    path = Path(__file__).with_name("arched_facade.json")
    path.write_text(block_file(arched_wall(ARCHED_FACADE)), encoding="utf-8")
