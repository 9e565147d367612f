"""One wall drawn as draughtsmen draw: closed outlines, lines and arcs, with the errors of drawings and surveys."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import ezdxf
import numpy as np
import shapely

from orchestrator.geometry.planar_map import planar_map
from orchestrator.masonry.patterns import ArchedOpening

INCHES, MILLIMETRES, CENTIMETRES, METRES = 1, 4, 5, 6
FACTOR = {INCHES: 1 / 0.0254, MILLIMETRES: 1e3, CENTIMETRES: 1e2, METRES: 1.0}


def with_errors(wall, error=0.0, gap=0.0, rounding=0.0, seed=0):
    """Return the outlines (n, 2) of all blocks in m: shrunk to leave a gap between any two, corners off by up to
    `error` in x and y, coordinates rounded to multiples of `rounding`."""
    random = np.random.default_rng(seed)
    outlines = []
    for block in wall.blocks:
        shape = shapely.Polygon(block.polygon).buffer(-0.5 * gap, join_style="mitre", mitre_limit=20.0)
        outline = shapely.get_coordinates(shapely.geometry.polygon.orient(shape))[:-1]
        outline = outline + random.uniform(-error, error, outline.shape)
        outlines.append(np.round(outline / rounding) * rounding if rounding else outline)
    return outlines


def polylines(path: Path, wall, unit=MILLIMETRES, **errors) -> Path:
    """Draw every block as a closed polyline, with the errors of `with_errors`."""
    document = ezdxf.new()
    document.header["$INSUNITS"] = unit
    for block, outline in zip(wall.blocks, with_errors(wall, **errors), strict=True):
        layer = {"layer": "supports" if block.fixed else "blocks"}
        document.modelspace().add_lwpolyline(FACTOR[unit] * outline, close=True, dxfattribs=layer)
    document.saveas(path)
    return path


def lines_and_arcs(path: Path, wall, arches: Iterable[ArchedOpening] = (), openings=(), error=0.0, seed=0) -> Path:
    """Draw joints and edges once, as long lines, the rings of `arches` as arcs; ends are off by up to `error` (m).

    The voids of arches and `openings` (left, right, bottom, top) are outlines on a layer of their own."""
    random = np.random.default_rng(seed)
    document = ezdxf.new()
    document.header["$INSUNITS"] = MILLIMETRES
    space = document.modelspace()
    rings = [ring for arch in arches if arch.rise != 0 for ring in arch.rings()]
    stones = [block for block in wall.blocks if not block.fixed]
    for a, b in long_lines(stones, rings):
        for ring in rings:
            a, b = _up_to_the_arc(ring, a, b), _up_to_the_arc(ring, b, a)
        a, b = (p + random.uniform(-error, error, 2) for p in (a, b))
        space.add_line(1e3 * a, 1e3 * b, dxfattribs={"layer": "blocks"})
    for ring in rings:
        centre, radius = _circle(ring[0], ring[len(ring) // 2], ring[-1])
        ends = [np.degrees(np.arctan2(*(p + random.uniform(-error, error, 2) - centre)[::-1])) for p in ring[[-1, 0]]]
        space.add_arc(
            1e3 * centre, 1e3 * (radius + random.uniform(-error, error)), *ends, dxfattribs={"layer": "blocks"}
        )
    voids = [arch.void() for arch in arches] + [shapely.box(x, y, r, t) for x, r, y, t in openings]
    for void in voids:
        space.add_lwpolyline(1e3 * shapely.get_coordinates(void), close=True, dxfattribs={"layer": "openings"})
    for block in wall.blocks:
        if block.fixed:
            space.add_lwpolyline(1e3 * block.polygon, close=True, dxfattribs={"layer": "supports"})
    document.saveas(path)
    return path


def long_lines(blocks, rings=()) -> list[np.ndarray]:
    """Return the edges of the blocks, each once but for chords of `rings`, those that continue each other as one (2,
    2)."""
    joined = planar_map([block.polygon for block in blocks], 1e-6)
    a, b = joined.vertex[joined.start], joined.vertex[joined.end]
    own = np.array([not any(_is_chord(ring, p, q) for ring in rings) for p, q in zip(a, b, strict=True)])
    a, b = a[own], b[own]
    turned = (b - a)[:, 0] < -1e-9 * np.abs((b - a)[:, 1])
    a, b = np.where(turned[:, None], b, a), np.where(turned[:, None], a, b)
    along = (b - a) / np.linalg.norm(b - a, axis=1)[:, None]
    along[np.abs(along[:, 0]) < 1e-9] = [0.0, 1.0]
    off = a[:, 0] * along[:, 1] - a[:, 1] * along[:, 0]
    place = np.sort(np.stack([np.sum(p * along, axis=1) for p in (a, b)]), axis=0)
    found: list[np.ndarray] = []
    keys = np.round(np.column_stack([along, off]), 7)
    for key in np.unique(keys, axis=0):
        members = np.flatnonzero((keys == key).all(axis=1))
        members = members[np.argsort(place[0, members])]
        direction, normal = along[members[0]], np.array([along[members[0], 1], -along[members[0], 0]])
        begin, end = place[:, members[0]]
        for member in members[1:]:
            if place[0, member] > end + 1e-6:
                found.append(np.stack([direction * t + normal * off[members[0]] for t in (begin, end)]))
                begin = place[0, member]
            end = max(end, place[1, member])
        found.append(np.stack([direction * t + normal * off[members[0]] for t in (begin, end)]))
    return found


def _is_chord(ring, a, b):
    return bool((_chord_distances(ring, 0.5 * (a + b)) < 1e-6).any())


def _chord_distances(ring, point):
    return shapely.distance(shapely.linestrings(np.stack([ring[:-1], ring[1:]], axis=1)), shapely.Point(point))


def _up_to_the_arc(ring, end, other):
    """Return the end of a line that lies on a chord of the ring moved along the line to the arc."""
    if _chord_distances(ring, end).min() > 1e-6:
        return end
    centre, radius = _circle(ring[0], ring[len(ring) // 2], ring[-1])
    along = (end - other) / np.linalg.norm(end - other)
    middle = (centre - end) @ along
    half = np.sqrt(radius**2 - ((end - centre) @ (end - centre) - middle**2))
    return end + along * min((middle - half, middle + half), key=abs)


def _circle(a, b, c):
    """Return centre and radius of the circle through three points."""
    matrix = 2 * np.array([b - a, c - a])
    centre = np.linalg.solve(matrix, [b @ b - a @ a, c @ c - a @ a])
    return centre, float(np.linalg.norm(a - centre))
