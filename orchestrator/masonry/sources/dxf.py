"""DXF drawings -> Drawing: closed outlines, and lines and arcs that close, on the layer of the blocks (ezdxf).

Entities inside block references are read too. The outline of a filled area (a hatch, a solid, a face) is that of a
stone where nothing else draws one; what is not read is counted.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.errors import CaseError, naming
from orchestrator.basis.units import Unit
from orchestrator.masonry.sources.block_files import refuse_what_is_no_file
from orchestrator.masonry.sources.closed_outlines import (
    CHORD,
    LARGEST_CORNERS,
    ROLES,
    Layers,
    OnLayer,
    drawing_of,
    is_chosen,
)
from orchestrator.masonry.sources.drawing import Drawing
from orchestrator.masonry.sources.dxf_entities import DRAWN, FILLED, Seen, entities_of, said_passed_over
from orchestrator.masonry.sources.filled_areas import Filled
from orchestrator.masonry.sources.other_layers import said_of_other_layers
from orchestrator.masonry.wall import LARGEST_COUNT

HEADER_UNITS = {1: 0.0254, 2: 0.3048, 4: 1e-3, 5: 1e-2, 6: 1.0, 7: 1e3, 10: 0.9144, 14: 0.1, 21: 1200 / 3937}
"""m by the header's $INSUNITS: inch, foot, mm, cm, m, km, yard, dm, US survey foot (DXF reference, HEADER section)"""
LARGEST_FILE = 100_000_000
"""bytes"""
MOST_STRETCHED = 1e4
"""axis of an ellipse over the other one, beyond which flattening it takes all memory"""
LARGEST_ENTITIES = 2 * LARGEST_COUNT
"""in the drawing with its block references expanded, at most"""
DEEPEST_NESTING = 50
"""block references within block references, at most"""


def read_dxf(path: Path, layers: Layers, tolerance: float, unit: str = "") -> Drawing:
    """Return the outlines in the drawing `path` in m. Raises CaseError naming file, layer or place, and remedy.

    tolerance in m: ends of lines nearer than this meet, arcs become chords no farther off. unit: of the drawing's
    coordinates, instead of its header's.
    """
    with naming(path):
        return _drawing(path, layers, tolerance, unit)


@dataclass(frozen=True, eq=False, slots=True)
class Read:
    """What a drawing has: `lines` as layer and points, outlines of `areas`, all points (n, 3) in drawing units and the
    first repeated if closed; whether curves are among the lines; what was `left`."""

    lines: list[OnLayer]
    areas: list[Filled]
    curved: bool
    left: list[Seen]


def _drawing(path: Path, layers: Layers, tolerance: float, unit: str) -> Drawing:
    document = _opened(path)
    factor, remark = _factor(document, unit)
    try:
        read = _read(document, CHORD * tolerance / factor)
    except CaseError:
        raise
    except Exception as error:  # ezdxf checks little: a damaged entity fails with whatever Python raises
        raise CaseError("", f"an entity cannot be read ({_short(error)})", "repair the drawing (AUDIT)") from None
    chosen = {role: partial(is_chosen, patterns=getattr(layers, role)) for role in ROLES}
    lines = {role: [(name, factor * points) for name, points in read.lines if on(name)] for role, on in chosen.items()}
    areas = {
        role: [replace(area, points=factor * area.points) for area in read.areas if on(area.layer)]
        for role, on in chosen.items()
    }
    passed = said_passed_over(read.left, layers)
    if not lines["blocks"] and not areas["blocks"]:
        names = {*(name for name, _ in read.lines), *(area.layer for area in read.areas)}
        problem = "; ".join([f"nothing is drawn on layer {layers.blocks!r}", *passed])
        listed = ", ".join(sorted(names)[:20]) or "none with lines"
        raise CaseError("blocks", problem, f"choose one with --blocks NAME; the drawing's layers: {listed}")
    drawn = [points for paths in lines.values() for _, points in paths]
    _refuse_depth([*drawn, *(area.points for of in areas.values() for area in of)], tolerance)
    flat = {role: [(name, points[:, :2]) for name, points in paths] for role, paths in lines.items()}
    filled = {role: [replace(area, points=area.points[:, :2]) for area in of] for role, of in areas.items()}
    drawing = drawing_of(flat, tolerance, [remark, *passed], read.curved, filled)
    everything = [*read.lines, *((area.layer, area.points) for area in read.areas)]
    left = [(name, points) for name, points in everything if not any(on(name) for on in chosen.values())]
    others = [(name, factor * points[:, :2]) for name, points in left]
    return replace(drawing, remarks=(*drawing.remarks, *said_of_other_layers(others, drawing, layers, tolerance)))


def _opened(path: Path) -> Any:
    import ezdxf

    try:
        refuse_what_is_no_file(path, LARGEST_FILE, "keep only the layers of the wall")
        return ezdxf.readfile(path)
    except FileNotFoundError:
        raise CaseError("", "no such file", "give the path of a DXF drawing") from None
    except CaseError:
        raise
    except OSError as error:
        problem = f"cannot be read ({error.strerror})" if error.strerror else "is not a DXF drawing"
        raise CaseError("", problem, "save it as DXF R2000 or later") from None
    except Exception as error:  # ezdxf checks little: a damaged file fails with whatever Python raises
        raise CaseError("", f"is not a DXF drawing ({_short(error)})", "save it as DXF R2000 or later") from None


def _factor(document: Any, unit: str) -> tuple[float, str]:
    """Return m per unit of the drawing, and where that comes from."""
    if unit:
        try:
            return Unit("m").factor(unit), f"drawing in {unit}, as given"
        except ValueError as error:
            problem, _, remedy = str(error).partition("; ")
            raise CaseError("--unit", problem, remedy) from None
    code = document.header.get("$INSUNITS", 0)
    if code not in HEADER_UNITS:
        raise CaseError("$INSUNITS", "the header states no unit of length", "give it, as in --unit mm")
    return HEADER_UNITS[code], f"drawing unit {HEADER_UNITS[code]:g} m, from its header"


def _read(document: Any, chord: float) -> Read:
    """Return everything drawn that is shown, curves as chords no farther off than `chord` (drawing units)."""
    if _expanded(document.modelspace(), document, {}) > LARGEST_ENTITIES:
        raise CaseError("", f"more than {LARGEST_ENTITIES} entities", "keep only the layers of the wall")
    lines, areas, left = list[OnLayer](), list[Filled](), list[Seen]()
    corners, curved = 0, False
    for number, seen in enumerate(entities_of(document)):
        if seen.hidden or seen.kind not in (*DRAWN, *FILLED):
            left.append(seen)
            continue
        for path, is_curved in _paths(seen):
            points = np.array(list(islice(path.flattening(chord), LARGEST_CORNERS + 1)), dtype=float).reshape(-1, 3)
            corners += len(points)
            if corners > LARGEST_CORNERS:
                raise CaseError("", f"more than {LARGEST_CORNERS} corners", "raise --tolerance or import it in parts")
            if seen.kind in FILLED and len(points) > 2:
                closed = np.vstack([points, points[:1]])
                areas.append(Filled(seen.layer, closed, number, is_curved))
            elif len(points) > 1 and seen.kind in DRAWN:
                lines.append((seen.layer, points))
                curved |= is_curved
    return Read(lines, areas, curved, left)


def _paths(seen: Seen) -> Iterator[tuple[Any, bool]]:
    """Yield what bounds an entity and flattens, one for each part of a hatch, and whether it has curves.

    A spline flattens itself: as a path it is made of cubic curves, which are near it, not on it, for other degrees.
    """
    from ezdxf.path import from_hatch, make_path

    if seen.kind == "SPLINE":
        yield seen.entity, True
        return
    if seen.kind == "ELLIPSE" and not 1.0 / MOST_STRETCHED <= abs(seen.entity.dxf.ratio) <= MOST_STRETCHED:
        raise CaseError(
            f"layer {seen.layer!r}", f"an ellipse has a ratio of {seen.entity.dxf.ratio:g}", "draw it again"
        )
    paths = from_hatch(seen.entity) if seen.kind in ("HATCH", "MPOLYGON") else [make_path(seen.entity)]
    yield from ((path, path.has_curves) for path in paths)


def _expanded(entities: Any, document: Any, known: dict[str, int], depth: int = 0) -> int:
    """Return how many entities there are with block references written out; `known`: that number by block name.

    Raises CaseError for references nested too deep (a block that refers to itself never ends).
    """
    if depth > DEEPEST_NESTING:
        raise CaseError("", f"block references are nested more than {DEEPEST_NESTING} deep", "explode them")
    total = 0
    for entity in entities:
        if entity.dxftype() != "INSERT" or (block := document.blocks.get(entity.dxf.name)) is None:
            total += 1
            continue
        if entity.dxf.name not in known:
            known[entity.dxf.name] = _expanded(block, document, known, depth + 1)
        total += max(1, entity.mcount) * (1 + known[entity.dxf.name])
    return total


def _refuse_depth(drawn: list[FloatArray], tolerance: float) -> None:
    points = np.vstack(drawn)
    if not (np.abs(points) < 1e9).all():
        raise CaseError("", "a coordinate is not a number below 1e9 m", "correct the drawing, or its unit with --unit")
    if np.ptp(points[:, 2]) > tolerance:
        raise CaseError("", f"depth varies by {np.ptp(points[:, 2]):.3g} m", "draw the wall in the xy plane")


def _short(error: Exception) -> str:
    text, name = str(error)[:100].rstrip("."), type(error).__name__
    return text if text.startswith(name) else f"{name}: {text}"
