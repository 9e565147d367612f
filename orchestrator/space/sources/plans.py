"""Plans of courses (DXF) -> SpaceWall: how surveyors draw returns and headers.

Every course is drawn in plan on a layer of its own, stones as closed polylines. Layers are named "course 1",
"course 2", ... from the foot; all have the same height unless one is named "course 3 h 120" (in the drawing's unit). A
layer "supports" holds the ground in plan, below the first course. A stone of several courses stands on a layer of
its own, "courses 3-4". What is drawn on these layers and is no such polyline is refused, texts and hatches are passed
over, and other layers are told.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.basis.errors import CaseError
from orchestrator.basis.printed import as_place, counted
from orchestrator.geometry.polyhedra import prism
from orchestrator.masonry.sources.dxf_entities import DRAWN
from orchestrator.space.sources.material import SpaceMaterial
from orchestrator.space.wall import UPRIGHT, SpaceBlock, SpaceWall

COURSES = re.compile(r"courses?[ _]*(\d{1,4})(?:\s*-\s*(\d{1,4}))?(?:[ _]+h[ _]*(\d+\.?\d*|\.\d+))?", re.IGNORECASE)
SUPPORTS = "supports"
"""layer of the ground"""
UNIT_CODES = {1: 0.0254, 2: 0.3048, 4: 1e-3, 5: 1e-2, 6: 1.0}
"""m of a drawing's unit by its code in the DXF header ($INSUNITS)"""


def read_plans(
    path: Path,
    length: float | None,
    height: float | None,
    material: SpaceMaterial,
    say: Callable[[str], None] = lambda _: None,
) -> SpaceWall:
    """Return the wall whose courses are drawn in plan; length: the drawing's unit (m), None for the file's own; height
    (m) of every course whose layer does not say it. What is left out is said. Raises CaseError."""
    import ezdxf

    try:
        document = ezdxf.readfile(path)
    except OSError as error:
        problem = f"cannot be read ({error.strerror})" if error.strerror else "is not a DXF drawing"
        raise CaseError("", problem, "save it as DXF, ASCII or binary") from None
    except ezdxf.DXFError as error:
        raise CaseError("", f"is a damaged DXF drawing ({error})", "save it as DXF, ASCII or binary") from None
    if length is None:
        length = UNIT_CODES.get(int(document.header.get("$INSUNITS", 0)))
        if length is None:
            raise CaseError("--unit", "the drawing has no unit", "give it, as in --unit mm")
    drawn: dict[str, list[FloatArray]] = {}
    others: Counter[str] = Counter()
    for entity in document.modelspace():
        layer = str(entity.dxf.layer)
        if entity.dxftype() not in (*DRAWN, "INSERT"):
            continue
        if COURSES.fullmatch(layer.strip()) or layer == SUPPORTS:
            drawn.setdefault(layer, []).append(_outline(entity, layer, length))
        else:
            others[layer] += 1
    courses = {layer: match for layer in drawn if (match := COURSES.fullmatch(layer.strip()))}
    for layer, count in sorted(others.items()):
        say(f"layer {layer!r} is no course: {counted(count, 'line')} left out")
    if not courses:
        listed = ", ".join(sorted([*drawn, *others])[:5]) or "none that is drawn on"
        raise CaseError(
            "", f"no layer is a course; layers: {listed}", 'name them "course 1", "course 2", ... from the foot'
        )
    return _stacked(path.stem, drawn, courses, length, height, material)


def _outline(entity: Any, layer: str, length: float) -> FloatArray:
    """Return the outline (n, 2) in m of a stone in plan. Raises CaseError for what is no closed polyline of straight
    sides."""
    kind = entity.dxftype()
    if kind not in ("LWPOLYLINE", "POLYLINE"):
        raise CaseError(
            f"layer {layer!r}", f"holds a {kind}, which is no stone", "explode it, or draw stones as closed polylines"
        )
    light = kind == "LWPOLYLINE"
    rows = entity.get_points("xyb") if light else [(*v.dxf.location[:2], v.dxf.bulge) for v in entity.vertices]
    points = length * np.array([row[:2] for row in rows], dtype=float).reshape(-1, 2)
    at = f"at {as_place(points[0, 0], points[0, 1])} m" if len(points) else "without corners"
    if len(points) > 3 and np.allclose(points[0], points[-1], rtol=0.0, atol=1e-6 * float(np.ptp(points))):
        points, closed = points[:-1], True
    else:
        closed = bool(entity.closed if light else entity.is_closed)
    if not closed or len(points) < 3:
        raise CaseError(
            f"layer {layer!r}", f"the polyline {at} is open, and no stone", "close it, or move it elsewhere"
        )
    if any(row[2] for row in rows):
        raise CaseError(f"layer {layer!r}", f"the polyline {at} has an arc", "draw its chords")
    return points


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
    for layer, match in courses.items():
        if not 1 <= int(match[1]) <= int(match[2] or match[1]):
            raise CaseError(
                f"layer {layer!r}", "names no courses", "count from 1 at the foot upwards, as in courses 2-3"
            )
        if match[3] and match[2]:
            problem = "says one height of several courses"
            raise CaseError(f"layer {layer!r}", problem, 'name layers of one course for that, as in "course 2 h 250"')
        if match[3]:
            heights[int(match[1])] = length * float(match[3])
    for key, value in [("--height", height), *((f"layer of course {k}", value) for k, value in heights.items())]:
        if value is not None and not value > 0.0:
            raise CaseError(key, f"a height of {value:g} m is not above 0", "give the height of a course")
    last = max(int(match[2] or match[1]) for match in courses.values())
    missing = [k for k in range(1, last + 1) if k not in heights]
    if missing and height is None:
        problem = f"the height of course {missing[0]} is not known"
        raise CaseError("--height", problem, 'give it, as in --height "250 mm", or name the layer "course 1 h 250"')
    level = np.concatenate([[0.0], np.cumsum([heights.get(k, height or 0.0) for k in range(1, last + 1)])])
    blocks: list[SpaceBlock] = []
    for ring in drawn.get(SUPPORTS, []):
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
