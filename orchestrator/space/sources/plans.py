"""Plans of courses (DXF) -> SpaceWall: how surveyors draw returns and headers.

Every course is drawn in plan on a layer of its own, stones as closed polylines. Layers are named "course 1",
"course 2", ... from the foot; all have the same height unless one is named "course 3 h 120" (in the drawing's unit). A
layer "supports" holds the ground in plan, below the first course. A stone of several courses stands on a layer of
its own, "courses 3-4".
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.basis.errors import CaseError
from orchestrator.geometry.polyhedra import prism
from orchestrator.space.sources.material import SpaceMaterial
from orchestrator.space.wall import UPRIGHT, SpaceBlock, SpaceWall

COURSES = re.compile(r"courses?[ _]*(\d+)(?:\s*-\s*(\d+))?(?:[ _]+h[ _]*([\d.]+))?", re.IGNORECASE)
UNIT_CODES = {1: 0.0254, 2: 0.3048, 4: 1e-3, 5: 1e-2, 6: 1.0}
"""m of a drawing's unit by its code in the DXF header ($INSUNITS)"""


def read_plans(path: Path, length: float | None, height: float | None, material: SpaceMaterial) -> SpaceWall:
    """Return the wall whose courses are drawn in plan; length: the drawing's unit (m), None for the file's own; height
    (m) of every course whose layer does not say it. Raises CaseError."""
    import ezdxf

    try:
        document = ezdxf.readfile(path)
    except (OSError, ezdxf.DXFError) as error:
        raise CaseError("", f"is not a DXF drawing ({str(error)[:60]})", "save it as DXF, ASCII or binary") from None
    if length is None:
        length = UNIT_CODES.get(int(document.header.get("$INSUNITS", 0)))
        if length is None:
            raise CaseError("--unit", "the drawing has no unit", "give it, as in --unit mm")
    drawn: dict[str, list[FloatArray]] = {}
    for line in document.modelspace().query("LWPOLYLINE POLYLINE"):
        closed = getattr(line, "closed", None)
        closed = line.is_closed if closed is None else closed
        points = (
            line.get_points("xy") if line.dxftype() == "LWPOLYLINE" else [v.dxf.location[:2] for v in line.vertices]
        )
        if closed and len(points) >= 3:
            drawn.setdefault(line.dxf.layer, []).append(length * np.array(points, dtype=float))
    courses = {layer: match for layer in drawn if (match := COURSES.fullmatch(layer.strip()))}
    if not courses:
        listed = ", ".join(sorted(drawn)[:5]) or "none with closed polylines"
        raise CaseError(
            "", f"no layer is a course; layers: {listed}", 'name them "course 1", "course 2", ... from the foot'
        )
    return _stacked(path.stem, drawn, courses, length, height, material)


def _stacked(
    name: str,
    drawn: dict[str, list[FloatArray]],
    courses: dict[str, re.Match[str]],
    length: float,
    height: float | None,
    material: SpaceMaterial,
) -> SpaceWall:
    """Return the stones of all courses, each as high as its courses."""
    heights: dict[int, float] = {}
    for match in courses.values():
        if match[3] and not match[2]:
            heights[int(match[1])] = length * float(match[3])
    last = max(int(match[2] or match[1]) for match in courses.values())
    missing = [k for k in range(1, last + 1) if k not in heights]
    if missing and height is None:
        problem = f"the height of course {missing[0]} is not known"
        raise CaseError("--height", problem, 'give it, as in --height "250 mm", or name the layer "course 1 h 250"')
    level = np.concatenate([[0.0], np.cumsum([heights.get(k, height or 0.0) for k in range(1, last + 1)])])
    blocks: list[SpaceBlock] = []
    for ring in drawn.get("supports", []):
        blocks.append(_block(len(blocks), ring, -float(level[1]), 0.0, True, material))
    for layer in sorted(courses, key=lambda one: int(courses[one][1])):
        match = courses[layer]
        low, high = float(level[int(match[1]) - 1]), float(level[int(match[2] or match[1])])
        for ring in drawn[layer]:
            blocks.append(_block(len(blocks), ring, low, high, False, material))
    return SpaceWall(name, tuple(blocks), material.friction, read_only(UPRIGHT))


def _block(number: int, ring: FloatArray, low: float, high: float, fixed: bool, material: SpaceMaterial) -> SpaceBlock:
    axes = np.diag([1.0, 1.0, high - low])
    return SpaceBlock(number, prism(ring, np.array([0.0, 0.0, low]), axes), fixed, material.unit_weight)
