"""Stones that fill a wall, cut out of one plane: dressed ones (lintels, voussoirs) as given, rough ones round them.

All outlines are noded together, so that the corners of neighbours are the same numbers, and every corner is one of all
the stones round it. Stones are rings of corner numbers from there on. Too small a stone becomes part of a neighbour;
too short an edge shrinks to a point, which stays on the outline of the wall, of openings and of dressed stones.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
import shapely

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.basis.errors import CaseError
from orchestrator.geometry.rigid import cross
from orchestrator.masonry.wall import Block, Wall

Ring = list[int]
"""numbers of corners, counter-clockwise"""

SHORTEST_EDGE = 1 / 12
"""of the size of a stone: shorter edges shrink to a point"""
SMALLEST_RADIUS = 1 / 8
"""of the size of a stone: where a circle of this radius does not fit, a rough stone becomes part of a neighbour"""
CORNER_GRID = 1e-11
"""of the size of a stone, rounded to a power of ten: corners are rounded to it"""


def wall_of_tiles(
    name: str,
    outline: tuple[float, float],
    voids: Sequence[shapely.Polygon],
    dressed: Sequence[shapely.Polygon],
    rough: Sequence[shapely.Polygon],
    size: float,
    **material: float,
) -> Wall:
    """Return the wall of length and height `outline` (m) on one support (block 0) that reaches 0.2 m beyond it.

    `rough` stones cover what `voids` and `dressed` stones leave; `size` (m): the lesser side of a usual stone;
    material: thickness, unit_weight, friction. Stones are numbered from 1, from below and from the left.
    Raises CaseError where an opening or a dressed stone leaves the wall or meets another.
    """
    length, height = outline
    box = shapely.box(0.0, 0.0, length, height)
    taken = shapely.union_all([*voids, *dressed])
    room = shapely.difference(box, taken)
    if abs(room.area + sum(p.area for p in (*voids, *dressed)) - box.area) > 1e-6 * size**2:
        problem = "an opening, its arch or its lintel leaves the wall or meets another"
        raise CaseError("openings", problem, "move them apart")
    region = shapely.difference(box, shapely.union_all(voids))
    stones = _tiles(region, room, dressed, rough, size)
    stones.sort(key=lambda corners: tuple(corners.min(axis=0)[::-1].round(9)))
    support = shapely.box(-0.2, -size, length + 0.2, 0.0)
    blocks = tuple(
        Block(number, read_only(corners), fixed=number == 0, unit_weight=material["unit_weight"])
        for number, corners in enumerate([shapely.get_coordinates(shapely.normalize(support))[:0:-1], *stones])
    )
    return Wall(name, blocks, material["thickness"], material["friction"])


def _tiles(
    region: shapely.Polygon,
    room: shapely.Polygon,
    dressed: Sequence[shapely.Polygon],
    rough: Sequence[shapely.Polygon],
    size: float,
) -> list[FloatArray]:
    """Return the corners of the stones that fill `region`; rough stones are cut to `room`."""
    frame = shapely.union_all([region.boundary, *(stone.boundary for stone in dressed)])
    joints = shapely.union_all([stone.boundary for stone in rough]).intersection(room)
    grid = 10.0 ** np.round(np.log10(CORNER_GRID * size))
    faces = shapely.get_parts(shapely.polygonize(shapely.get_parts(shapely.union_all([frame, joints], grid_size=grid))))
    inside = shapely.point_on_surface(faces)
    faces, inside = (part[shapely.intersects(region, inside)] for part in (faces, inside))
    if shapely.get_num_interior_rings(faces).any():
        raise CaseError("openings", "a stone would lie all round an opening or a lintel", "choose smaller stones")
    numbers, corner = _numbered([shapely.get_coordinates(shapely.orient_polygons(face))[:-1] for face in faces])
    loose = shapely.intersects(room, inside)
    rounding = 1e-9 * size
    rings = _without_small(numbers, loose.tolist(), corner, SMALLEST_RADIUS * size)
    rings = _without_idle_corners(rings, corner, rounding)
    rings = _without_short_edges(rings, corner, _lines_through(corner, frame, rounding), SHORTEST_EDGE * size)
    return [corner[ring] for ring in _without_idle_corners(rings, corner, rounding)]


def _numbered(polygons: Sequence[FloatArray]) -> tuple[list[Ring], FloatArray]:
    """Return polygons (n, 2) as rings of numbers, and the corners (m, 2) they number."""
    corner, number = np.unique(np.vstack(polygons) + 0.0, axis=0, return_inverse=True)
    ends = np.cumsum([len(polygon) for polygon in polygons])[:-1]
    return [ring.tolist() for ring in np.split(number.ravel(), ends)], corner


def _edges(ring: Ring) -> Iterator[tuple[int, int]]:
    return pairwise([*ring, ring[0]])


def _joined(first: Ring, second: Ring) -> Ring | None:
    """Return the outline of two stones in one; none where it would not be one simple ring."""
    both = {*_edges(first), *_edges(second)}
    following = {a: b for a, b in both if (b, a) not in both}
    if len(following) < sum((b, a) not in both for a, b in both):
        return None
    ring = [min(following)]
    while (corner := following[ring[-1]]) != ring[0]:
        ring.append(corner)
    return ring if len(ring) == len(following) else None


def _without_small(rings: list[Ring], loose: list[bool], corner: FloatArray, radius: float) -> list[Ring]:
    """Return the rings with every small loose one in that loose neighbour with which it makes the most convex stone."""
    rings, loose = list(rings), list(loose)
    shapes = [shapely.Polygon(corner[ring]) for ring in rings]
    small = [k for k, shape in enumerate(shapes) if loose[k] and shape.buffer(-radius).is_empty]
    for k in sorted(small, key=lambda k: shapes[k].area):
        if not shapes[k].buffer(-radius).is_empty:
            continue  # has taken in another since
        joined = [(j, _joined(rings[k], ring)) for j, ring in enumerate(rings) if ring and loose[j] and j != k]
        made = [(j, ring, shapely.Polygon(corner[ring])) for j, ring in joined if ring is not None]
        if made:
            j, ring, shape = max(made, key=lambda union: union[2].area / union[2].convex_hull.area)
            rings[j], shapes[j], rings[k] = ring, shape, []
    return [ring for ring in rings if ring]


def _lines_through(corner: FloatArray, frame: shapely.Geometry, tolerance: float) -> list[set[int]]:
    """Return the numbers of those straight pieces of `frame` that each corner lies on."""
    chains = [shapely.get_coordinates(line) for line in shapely.get_parts(frame)]
    ends = np.concatenate([np.stack([chain[:-1], chain[1:]], axis=1) for chain in chains])
    points = shapely.points(corner)
    of_corner, line = shapely.STRtree(shapely.linestrings(ends)).query(points, "dwithin", distance=tolerance)
    through: list[set[int]] = [set() for _ in corner]
    for k, piece in zip(of_corner.tolist(), line.tolist(), strict=True):
        through[k].add(piece)
    return through


def _without_short_edges(rings: list[Ring], corner: FloatArray, lines: list[set[int]], shortest: float) -> list[Ring]:
    """Return the rings with short edges shrunk to a point, shortest first; moves what lies in `corner`.

    The point lies on all `lines` that either end lies on: where neither end does, the edge stays.
    """
    refused: set[tuple[int, int]] = set()
    while True:
        edges = {(min(edge), max(edge)) for ring in rings for edge in _edges(ring)} - refused
        short = [(float(np.linalg.norm(corner[a] - corner[b])), a, b) for a, b in edges]
        length, a, b = min(short, default=(shortest, 0, 0))
        if length >= shortest:
            return rings
        if lines[a] < lines[b]:
            a, b = b, a
        merged = [[k for k, _ in _edges([a if k == b else k for k in ring])] for ring in rings]
        merged = [[k for k, after in _edges(ring) if k != after] for ring in merged]
        place = 0.5 * (corner[a] + corner[b]) if lines[a] == lines[b] else corner[a].copy()
        moved = corner.copy()
        moved[a] = place
        changed = [ring for ring in merged if a in ring and len(ring) > 2]
        if lines[a] >= lines[b] and all(_simple(ring, moved) for ring in changed):
            corner[a] = place
            rings = [ring for ring in merged if len(ring) > 2]
        else:
            refused.add((min(a, b), max(a, b)))


def _simple(ring: Ring, corner: FloatArray) -> bool:
    outline = shapely.Polygon(corner[ring])
    return len(set(ring)) == len(ring) and outline.is_valid and outline.exterior.is_ccw


def _without_idle_corners(rings: list[Ring], corner: FloatArray, tolerance: float) -> list[Ring]:
    """Return the rings without the corners at which no third edge ends and no outline turns."""
    neighbours: list[set[int]] = [set() for _ in corner]
    for ring in rings:
        for a, b in _edges(ring):
            neighbours[a].add(b)
            neighbours[b].add(a)

    def idle(k: int) -> bool:
        if len(neighbours[k]) != 2:
            return False
        first, second = (corner[j] - corner[k] for j in neighbours[k])
        return bool(abs(cross(first, second)) < tolerance * np.linalg.norm(first - second))

    return [[k for k in ring if not idle(k)] for ring in rings]
