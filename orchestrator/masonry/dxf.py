"""DXF drawings -> Drawing: closed outlines, and lines and arcs that close, on the layer of the blocks (ezdxf).

Layers are chosen by name (shell patterns separated by commas, whatever the case). Where blocks are on several layers,
the layer is a block's material. Entities inside block references are read too; texts, dimensions and hatches are passed
over.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fnmatch import fnmatchcase
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from orchestrator.errors import CaseError
from orchestrator.masonry.drawing import LARGEST_COUNT, Drawing
from orchestrator.masonry.readers import refuse_what_is_no_file
from orchestrator.masonry.wall import FloatArray
from orchestrator.units import Unit

HEADER_UNITS = {1: 0.0254, 2: 0.3048, 4: 1e-3, 5: 1e-2, 6: 1.0, 7: 1e3, 10: 0.9144, 14: 0.1, 21: 1200 / 3937}
"""m by the header's $INSUNITS: inch, foot, mm, cm, m, km, yard, dm, US survey foot (DXF reference, HEADER section)"""
DRAWN = ("LINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE", "LWPOLYLINE", "POLYLINE")
LARGEST_FILE = 100_000_000
"""bytes"""
CHORD = 0.1
"""part of the tolerance by which chords lie off an arc: what they add to the errors of a drawing must not count"""
SMALLEST_ERROR = 1e-6
"""part of the drawing's size: ends of lines are first taken to meet over this distance"""
LARGEST_CORNERS = 2_000_000
LARGEST_ENTITIES = 2 * LARGEST_COUNT
DEEPEST = 50
OnLayer = tuple[str, FloatArray]
"""layer and points (n, 2) or (n, 3)"""


@dataclass(frozen=True, slots=True)
class Layers:
    """Names of layers, separated by commas; `*` and `?` stand for any letters."""

    blocks: str = "blocks"
    supports: str = "supports"
    openings: str = "openings"


def read_dxf(path: Path, layers: Layers, tolerance: float, unit: str = "") -> Drawing:
    """Return the outlines in the drawing `path` in m. Raises CaseError naming file, layer or place, and remedy.

    tolerance in m: ends of lines nearer than this meet, arcs become chords no farther off. unit: of the drawing's
    coordinates, instead of its header's.
    """
    try:
        return _drawing(path, layers, tolerance, unit)
    except CaseError as error:
        raise error.in_file(str(path)) from None


def _drawing(path: Path, layers: Layers, tolerance: float, unit: str) -> Drawing:
    document = _opened(path)
    factor, remark = _factor(document, unit)
    try:
        paths, curved = _paths(document, CHORD * tolerance / factor)
    except CaseError:
        raise
    except Exception as error:  # ezdxf checks little: a damaged entity fails with whatever Python raises
        raise CaseError("", f"an entity cannot be read ({_short(error)})", "repair the drawing (AUDIT)") from None
    on: dict[str, list[OnLayer]] = {}
    for role in ("blocks", "supports", "openings"):
        patterns = [pattern.strip() for pattern in getattr(layers, role).lower().split(",")]
        on[role] = [
            (name, factor * points)
            for name, points in paths
            if any(fnmatchcase(name.lower(), pattern) for pattern in patterns)
        ]
    if not on["blocks"]:
        found = ", ".join(sorted({name for name, _ in paths})[:20]) or "none with lines"
        problem = f"nothing is drawn on layer {layers.blocks!r}"
        raise CaseError("blocks", problem, f"choose one with --blocks NAME; the drawing's layers: {found}")
    _refuse_depth(on, tolerance)
    flat = {role: [(name, points[:, :2]) for name, points in drawn] for role, drawn in on.items()}
    closed = {role: _closed(drawn, role, tolerance) for role, drawn in flat.items()}
    remarks = [remark, *(text for _, texts, _ in closed.values() for text in texts)]
    stones, supports, openings = (
        tuple(outline for _, outline in closed[role][0]) for role in ("blocks", "supports", "openings")
    )
    several = len({name for name, _ in on["blocks"]}) > 1
    materials = tuple(name for name, _ in closed["blocks"][0]) if several else ()
    joined = max(within for _, _, within in closed.values())
    return Drawing(stones, supports, openings, tuple(remarks), materials, joined, curved)


def _opened(path: Path) -> Any:
    import ezdxf

    try:
        refuse_what_is_no_file(path, LARGEST_FILE, "keep only the layers of the wall")
        return ezdxf.readfile(path)
    except FileNotFoundError:
        raise CaseError("", "no such file", "give the path of a DXF drawing") from None
    except CaseError:
        raise
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


def _paths(document: Any, chord: float) -> tuple[list[OnLayer], bool]:
    """Return layer and points (n, 3) of everything drawn, in drawing units, the first point repeated if closed; and
    whether curves are among it."""
    from ezdxf.disassemble import recursive_decompose
    from ezdxf.path import make_path

    if _expanded(document.modelspace(), document, {}) > LARGEST_ENTITIES:
        raise CaseError("", f"more than {LARGEST_ENTITIES} entities", "keep only the layers of the wall")
    paths, corners, curved = [], 0, False
    for entity in recursive_decompose(document.modelspace()):
        if entity.dxftype() not in DRAWN:
            continue
        path = make_path(entity)
        curved |= path.has_curves
        points = np.array(list(islice(path.flattening(chord), LARGEST_CORNERS + 1)), dtype=float)
        corners += len(points)
        if corners > LARGEST_CORNERS:
            raise CaseError("", f"more than {LARGEST_CORNERS} corners", "raise --tolerance or import it in parts")
        if len(points) > 1:
            paths.append((str(entity.dxf.layer), points.reshape(-1, 3)))
    return paths, curved


def _expanded(entities: Any, document: Any, known: dict[str, int], depth: int = 0) -> int:
    """Return how many entities there are with block references written out; `known`: that number by block name.

    Raises CaseError for references nested too deep (a block that refers to itself never ends).
    """
    if depth > DEEPEST:
        raise CaseError("", f"block references are nested more than {DEEPEST} deep", "explode them")
    total = 0
    for entity in entities:
        if entity.dxftype() != "INSERT" or (block := document.blocks.get(entity.dxf.name)) is None:
            total += 1
            continue
        if entity.dxf.name not in known:
            known[entity.dxf.name] = _expanded(block, document, known, depth + 1)
        total += max(1, entity.mcount) * (1 + known[entity.dxf.name])
    return total


def _refuse_depth(on: dict[str, list[OnLayer]], tolerance: float) -> None:
    points = np.vstack([points for drawn in on.values() for _, points in drawn])
    if not (np.abs(points) < 1e9).all():
        raise CaseError("", "a coordinate is not a number below 1e9 m", "correct the drawing, or its unit with --unit")
    if np.ptp(points[:, 2]) > tolerance:
        raise CaseError("", f"depth varies by {np.ptp(points[:, 2]):.3g} m", "draw the wall in the xy plane")


def _closed(drawn: list[OnLayer], role: str, tolerance: float) -> tuple[list[OnLayer], list[str], float]:
    """Return the closed outlines (n, 2) in what is `drawn` and those its open lines form, remarks on the rest, and over
    what distance (m) ends had to be joined."""
    is_closed = [
        len(path) > 3 and np.linalg.norm(path[0] - path[-1]) <= tolerance < np.ptp(path, axis=0).max()
        for _, path in drawn
    ]
    outlines = [(name, path[:-1]) for (name, path), closed in zip(drawn, is_closed, strict=True) if closed]
    lines = [one for one, closed in zip(drawn, is_closed, strict=True) if not closed]
    faces, rest, within = _faces([path for _, path in lines], tolerance)
    along = _layers_along(faces, lines, tolerance)
    named = [(name, _without_repeats(outline)) for name, outline in outlines]
    distinct, twice = _without_duplicates([*named, *zip(along, faces, strict=True)])
    remarks = [f"{role}: {twice} outlines drawn twice, kept once"] if twice else []
    if rest:
        x, y = shapely.get_coordinates(rest[0])[0]
        remarks.append(f"{role}: WARNING: {len(rest)} lines close no outline, the first at ({x:.4g}, {y:.4g}) m")
    return distinct, remarks, within


def _layers_along(faces: list[FloatArray], lines: list[OnLayer], tolerance: float) -> list[str]:
    """Return for each face (n, 2) the layer that most of its boundary is drawn on, "" where two have as much."""
    names = sorted({name for name, _ in lines})
    if len(names) < 2:
        return names * len(faces)
    bands = [
        shapely.union_all([shapely.LineString(path) for on, path in lines if on == name]).buffer(tolerance)
        for name in names
    ]
    found = []
    for ring in map(shapely.LinearRing, faces):
        length = np.array([ring.intersection(band).length for band in bands])
        most = np.flatnonzero(length > 0.99 * length.max())
        found.append(names[most[0]] if len(most) == 1 else "")
    return found


def _faces(lines: list[FloatArray], tolerance: float) -> tuple[list[FloatArray], list[shapely.Geometry], float]:
    """Return the outlines that lines form, the lines that bound none, and the distance (m) over which ends were joined.

    Ends are taken to meet over the smallest distance, doubled from a millionth of the drawing up to the tolerance, that
    leaves no line over; so a larger tolerance does not change what a smaller one closes.
    """
    if not lines:
        return [], [], 0.0
    within = min(tolerance, SMALLEST_ERROR * float(np.ptp(np.vstack(lines), axis=0).max()))
    while True:
        faces, rest = _faces_within(lines, within)
        if not rest or within == tolerance:
            return faces, rest, within
        within = min(tolerance, 2 * within)


def _faces_within(lines: list[FloatArray], within: float) -> tuple[list[FloatArray], list[shapely.Geometry]]:
    """Return the outlines of lines whose ends meet each other, or another line, within `within` (m); and the rest."""
    ends = _meeting(np.vstack([line[[0, -1]] for line in lines]), within).reshape(-1, 2, 2)
    joined = [np.vstack([a, line[1:-1], b]) for line, (a, b) in zip(lines, ends, strict=True)]
    network = shapely.union_all([shapely.LineString(line) for line in joined if np.ptp(line, axis=0).max() > 0])
    corners = shapely.MultiPoint(np.unique(ends.reshape(-1, 2), axis=0))
    network = shapely.union_all(shapely.snap(network, corners, within))  # an end beside a line meets it there
    polygons, cuts, dangles, _ = shapely.polygonize_full([network])
    rest = [line for part in (cuts, dangles) for line in part.geoms if line.length > within]
    return [shapely.get_coordinates(face.exterior)[:-1] for face in polygons.geoms if not face.interiors], rest


def _meeting(points: FloatArray, within: float) -> FloatArray:
    """Return points (p, 2), those that chains of steps up to `within` (m) connect at their mean."""
    places = shapely.points(points)
    pairs = shapely.STRtree(places).query(places, predicate="dwithin", distance=within)
    matrix = coo_matrix((np.ones(pairs.shape[1]), pairs), shape=(len(points), len(points)))
    group = connected_components(matrix, directed=False)[1]
    size = np.bincount(group)
    return np.column_stack([np.bincount(group, points[:, k]) / size for k in (0, 1)])[group]


def _without_duplicates(outlines: Iterable[OnLayer]) -> tuple[list[OnLayer], int]:
    found: dict[bytes, OnLayer] = {}
    count = 0
    for name, outline in outlines:
        count += 1
        found.setdefault(np.unique(np.round(outline, 6) + 0.0, axis=0).tobytes(), (name, outline))
    return list(found.values()), count - len(found)


def _without_repeats(outline: FloatArray) -> FloatArray:
    return outline[np.any(outline != np.roll(outline, 1, axis=0), axis=1)]


def _short(error: Exception) -> str:
    return f"{type(error).__name__}: {str(error)[:100]}"
