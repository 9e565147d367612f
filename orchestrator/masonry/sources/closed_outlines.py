"""Lines and outlines as drawn -> Drawing: what closes is an outline, what does not is said, with what would close it.

Drawings of every format with lines end here. Layers (groups of an SVG drawing) are chosen by name; where blocks are on
several layers, the layer is a block's material.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fnmatch import fnmatchcase

import numpy as np
import shapely

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.graphs import connected_groups
from orchestrator.basis.printed import as_place, millimetres
from orchestrator.masonry.block_properties import rounded_up
from orchestrator.masonry.sources.doubtful_stones import IMPLAUSIBLE_SLENDERNESS, slenderness
from orchestrator.masonry.sources.drawing import Drawing
from orchestrator.masonry.sources.filled_areas import Filled, only_drawings
from orchestrator.masonry.wall import LARGEST_TOLERANCE

CHORD = 0.1
"""part of the tolerance by which chords lie off an arc: what they add to the errors of a drawing must not count"""
SMALLEST_ERROR = 1e-6
"""part of the drawing's size: ends of lines are first taken to meet over this distance"""
ROLES = ("blocks", "supports", "openings")
LARGEST_CORNERS = 2_000_000
"""of all outlines of a file"""
LISTED_ENDS = 5
"""open ends of lines that a remark names"""
NEARLY = 0.1
"""part of its size up to which a polyline that ends so close to where it begins was meant to be closed"""
BENT = 0.7
"""distance between the ends of a polyline over its length up to which it may be an outline that was left open; steps,
and two sides of a rectangle, have 0.71"""
CORNER = 0.5
"""angle (rad) by which an outline turns somewhere: the chords of an arc turn by less"""
TRIED = 4
"""larger tolerances that are tried on lines that stay open"""
OnLayer = tuple[str, FloatArray]
"""layer and points (n, 2) in m"""


@dataclass(frozen=True, slots=True)
class Layers:
    """Names of layers, separated by commas; `*` and `?` stand for any letters."""

    blocks: str = "blocks"
    supports: str = "supports"
    openings: str = "openings"


@dataclass(frozen=True, eq=False, slots=True)
class Network:
    """What lines form whose ends meet over `within` (m): outlines (n, 2), outlines that enclose others, the lines that
    bound none, and all lines cut where they meet (p,)."""

    within: float
    outlines: list[FloatArray]
    enclosing: list[shapely.Geometry]
    rest: list[shapely.Geometry]
    pieces: np.ndarray


def is_chosen(name: str, patterns: str) -> bool:
    """Return whether the name of a layer, group or category fits one of the patterns, whatever the case; brackets stand
    for themselves."""
    wanted = (pattern.strip().replace("[", "[[]") for pattern in patterns.lower().split(","))
    return any(fnmatchcase(name.lower(), pattern) for pattern in wanted)


def drawing_of(
    on: dict[str, list[OnLayer]],
    tolerance: float,
    remarks: list[str],
    curved: bool,
    areas: dict[str, list[Filled]] | None = None,
) -> Drawing:
    """Return the drawing of what is `on` the layers of each role, the first point repeated where it is closed.

    tolerance in m: ends nearer than this meet. remarks: on the reading so far; curved: as of a Drawing, for what is
    drawn with lines; areas: filled ones, by role.
    """
    closed = {role: _closed(on[role], role, tolerance) for role in ROLES}
    filled = {
        role: only_drawings((areas or {}).get(role, []), [outline for _, outline in closed[role][0]], role)
        for role in ROLES
    }
    named = {
        role: [*closed[role][0], *((area.layer, _without_repeats(area.points[:-1])) for area in filled[role][0])]
        for role in ROLES
    }
    stones, supports, openings = (tuple(outline for _, outline in named[role]) for role in ROLES)
    several = len({*(name for name, _ in on["blocks"]), *(area.layer for area in filled["blocks"][0])}) > 1
    materials = tuple(name for name, _ in named["blocks"]) if several else ()
    said = (*remarks, *(text for role in ROLES for text in (*closed[role][1], *filled[role][1])))
    joined = max(within for _, _, within in closed.values())
    curved |= any(area.curved for area in filled["blocks"][0])
    return Drawing(stones, supports, openings, said, materials, joined, curved)


def _closed(drawn: list[OnLayer], role: str, tolerance: float) -> tuple[list[OnLayer], list[str], float]:
    """Return the closed outlines (n, 2) in what is `drawn` and those its open lines form, remarks on the rest, and over
    what distance (m) ends had to be joined."""
    apart = [float(np.linalg.norm(path[0] - path[-1])) for _, path in drawn]
    size = [float(np.ptp(path, axis=0).max()) for _, path in drawn]
    is_closed = [
        len(path) > 3 and gap <= tolerance < extent for (_, path), gap, extent in zip(drawn, apart, size, strict=True)
    ]
    nearly = [
        k
        for k, (_, path) in enumerate(drawn)
        if len(path) > 3 and tolerance < apart[k] <= min(NEARLY * size[k], LARGEST_TOLERANCE)
    ]
    said = [*_said_open(role, [(apart[k], drawn[k][1]) for k in nearly])]
    named = [
        (name, _without_repeats(path[:-1])) for (name, path), closed in zip(drawn, is_closed, strict=True) if closed
    ]
    lines = [one for one, closed in zip(drawn, is_closed, strict=True) if not closed]
    if not lines:
        return named, said, 0.0
    paths = [path for _, path in lines]
    network = _network(paths, tolerance)
    along = _layers_along(network.outlines, lines, tolerance)
    alone = [drawn[k][1] for k in range(len(drawn)) if not is_closed[k] and k not in nearly and apart[k] > tolerance]
    said += _said_left_open(role, alone) if network.rest else []
    said += _said(network, paths, [outline for _, outline in named], role)
    return [*named, *zip(along, network.outlines, strict=True)], said, network.within


def _said_open(role: str, nearly: list[tuple[float, FloatArray]]) -> Iterator[str]:
    """Yield a warning about polylines that end close to where they begin, by how much (m): they bound nothing alone."""
    if nearly:
        widest, (x, y) = max(gap for gap, _ in nearly), nearly[0][1][0]
        many = f"{len(nearly)} polylines end" if len(nearly) > 1 else "1 polyline ends"
        yield (
            f"{role}: WARNING: {many} up to {millimetres(widest)} from the beginning, the first at {as_place(x, y)} "
            f'm: close what is open, or import the file with --tolerance "{rounded_up(1e3 * widest):g} mm"'
        )


def _said_left_open(role: str, paths: list[FloatArray]) -> Iterator[str]:
    """Yield a warning about polylines (n, 2) that bend like outlines of which the last side is missing."""
    bent = [path for path in paths if len(path) > 2 and _is_bent(path)]
    if bent:
        x, y = bent[0][0]
        several = len(bent) > 1
        many = f"{len(bent)} polylines are open, the first" if several else "1 polyline is open, which begins"
        close = "if they are outlines, close them" if several else "if it is an outline, close it"
        yield f"{role}: WARNING: {many} at {as_place(x, y)} m: {close} (Close in CAD, Z in an SVG path)"


def _is_bent(path: FloatArray) -> bool:
    """Return whether the ends of a polyline (n, 2) are near each other for its length, with corners between them, and
    a line between them closes an outline."""
    sides = np.diff(path, axis=0)
    length = np.linalg.norm(sides, axis=1)
    if not length.all() or np.linalg.norm(path[0] - path[-1]) >= BENT * length.sum():
        return False
    cosine = (sides[1:] * sides[:-1]).sum(axis=1) / (length[1:] * length[:-1])
    return bool(cosine.min() < np.cos(CORNER)) and bool(shapely.Polygon(path).is_valid)


def _layers_along(faces: list[FloatArray], lines: list[OnLayer], tolerance: float) -> list[str]:
    """Return for each face (n, 2) the layer that most of its boundary is drawn on, "" where two have as much."""
    names = sorted({name for name, _ in lines})
    if len(names) < 2:
        return names * len(faces)
    bands = [
        shapely.union_all([shapely.LineString(path) for on, path in lines if on == name]).buffer(tolerance)
        for name in names
    ]
    layers = []
    for ring in map(shapely.LinearRing, faces):
        length = np.array([ring.intersection(band).length for band in bands])
        most = np.flatnonzero(length > 0.99 * length.max())
        layers.append(names[most[0]] if len(most) == 1 else "")
    return layers


def _network(lines: list[FloatArray], tolerance: float) -> Network:
    """Return what lines form.

    Ends are taken to meet over the smallest distance, doubled from a millionth of the drawing up to the tolerance, that
    leaves no line over; so a larger tolerance does not change what a smaller one closes. Lines that were drawn twice
    leave slivers between them: then over the smallest distance that leaves none, if there is one.
    """
    within = min(tolerance, _smallest_error(lines))
    closed: Network | None = None
    while True:
        network = _network_within(lines, within)
        if not network.rest:
            closed = closed or network
            if not any(_is_sliver(outline, tolerance) for outline in network.outlines):
                return network
        if within == tolerance:
            return closed or network
        within = min(tolerance, 2 * within)


def _smallest_error(lines: list[FloatArray]) -> float:
    return SMALLEST_ERROR * float(np.ptp(np.vstack(lines), axis=0).max())


def _is_sliver(outline: FloatArray, tolerance: float) -> bool:
    polygon = shapely.Polygon(outline)
    return bool(2 * polygon.area < tolerance * polygon.length) and slenderness(polygon) > IMPLAUSIBLE_SLENDERNESS


def _network_within(lines: list[FloatArray], within: float) -> Network:
    """Return what lines form whose ends meet each other, or another line, within `within` (m)."""
    ends = _meeting(np.vstack([line[[0, -1]] for line in lines]), within).reshape(-1, 2, 2)
    joined = [np.vstack([a, line[1:-1], b]) for line, (a, b) in zip(lines, ends, strict=True)]
    network = shapely.union_all([shapely.LineString(line) for line in joined if np.ptp(line, axis=0).max() > 0])
    corners = shapely.MultiPoint(np.unique(ends.reshape(-1, 2), axis=0))
    network = shapely.union_all(shapely.snap(network, corners, within))  # an end beside a line meets it there
    polygons, cuts, dangles, _ = shapely.polygonize_full([network])
    rest = [line for part in (cuts, dangles) for line in part.geoms if line.length > within]
    outlines = [shapely.get_coordinates(face.exterior)[:-1] for face in polygons.geoms if not face.interiors]
    enclosing = [face for face in polygons.geoms if face.interiors]
    return Network(within, outlines, enclosing, rest, shapely.get_parts(network))


def _meeting(points: FloatArray, within: float) -> FloatArray:
    """Return points (p, 2), those that chains of steps up to `within` (m) connect at their mean."""
    places = shapely.points(points)
    pairs = shapely.STRtree(places).query(places, predicate="dwithin", distance=within)
    group = connected_groups(len(points), *pairs)
    size = np.bincount(group)
    return np.column_stack([np.bincount(group, points[:, k]) / size for k in (0, 1)])[group]


def _said(network: Network, lines: list[FloatArray], closed: list[FloatArray], role: str) -> list[str]:
    """Return warnings of lines that bound no outline, where they end and what tolerance would close them, and of
    outlines that are left out because they enclose others; closed: outlines (n, 2) beside the lines."""
    said = []
    if network.within > _smallest_error(lines):
        said.append(f"{role}: ends of lines up to {1e3 * network.within:.2g} mm apart taken to meet")
    if network.rest:
        many = f"{len(network.rest)} lines close" if len(network.rest) > 1 else "1 line closes"
        said.append(f"{role}: WARNING: {many} no outline{_said_ends(network, lines, closed)}")
    if network.enclosing:
        x, y = shapely.get_coordinates(network.enclosing[0])[0]
        many = f"{len(network.enclosing)} outlines of lines enclose others and are"
        many = many if len(network.enclosing) > 1 else "1 outline of lines encloses others and is"
        said.append(f"{role}: WARNING: {many} left out, the first at {as_place(x, y)} m")
    return said


def _said_ends(network: Network, lines: list[FloatArray], closed_beside: list[FloatArray]) -> str:
    """Return where lines end in nothing, and the smallest tolerance that closes most outlines, if any closes more.

    closed_beside: outlines (n, 2) that are closed without the lines; they close none of them.
    """
    ends, gap = _open_ends(network)
    if not len(ends):
        x, y = shapely.get_coordinates(network.rest[0])[0]
        return f", the first at {as_place(x, y)} m"
    listed = ", ".join(f"{as_place(x, y)}" for x, y in ends[:LISTED_ENDS])
    said = f"; {len(ends)} open end{'s' * (len(ends) > 1)} at {listed}{', ...' * (len(ends) > LISTED_ENDS)} m"
    near = np.sort(gap[np.isfinite(gap)])
    apart = _from_outlines(ends, closed_beside)
    shown = np.minimum(gap, apart)[np.isfinite(gap) | (apart <= LARGEST_TOLERANCE)]
    if len(shown):
        extremes = [0.0 if end <= network.within else float(end) for end in (shown.min(), shown.max())]
        said += ", " + " to ".join(dict.fromkeys(map(millimetres, extremes))) + " from the nearest line"
    wider = np.unique([1e-3 * rounded_up(1e3 * width) for width in near])
    wider = wider[(wider > network.within) & (wider <= LARGEST_TOLERANCE)]
    tried = wider[np.unique(np.linspace(0, len(wider) - 1, TRIED).astype(int))] if len(wider) else wider
    closed = {width: _network_within(lines, width) for width in tried.tolist()}
    best = max(closed, key=lambda width: (len(closed[width].outlines), -width), default=0.0)
    more = len(closed[best].outlines) - len(network.outlines) if closed else 0
    if more < 1:
        most = millimetres(tried[-1] if closed else LARGEST_TOLERANCE)
        why = f"no --tolerance up to {most} closes an outline more"
        if (apart <= network.within).any():
            return f"{said}; there is a closed outline, whose sides bound no other: draw on along it until closed"
        return f"{said}; {why}: draw on to where they meet others, or delete what is no outline"
    left = len(closed[best].rest)
    stay = "1 line stays" if left == 1 else f"{left} lines stay"
    said += f'; --tolerance "{1e3 * best:g} mm" closes {more} outline{"s" * (more > 1)} more'
    return said + (f", {stay} open then" if left else "")


def _from_outlines(points: FloatArray, outlines: list[FloatArray]) -> FloatArray:
    """Return how far points (p, 2) are from the nearest of closed outlines (p,), in m; inf where there are none."""
    if not outlines:
        return np.full(len(points), np.inf)
    return shapely.distance(shapely.points(points), shapely.union_all([shapely.LinearRing(one) for one in outlines]))


def _open_ends(network: Network) -> tuple[FloatArray, FloatArray]:
    """Return the ends (n, 2) of lines at which no other begins, and how far the nearest other line is (n,), in m; inf
    where there is none within the largest tolerance."""
    pieces = network.pieces[shapely.length(network.pieces) > network.within]
    ends = np.vstack([shapely.get_coordinates(shapely.get_point(network.pieces, k)) for k in (0, -1)])
    places, count = np.unique(ends, axis=0, return_counts=True)
    free = shapely.points(places[count == 1])
    k, piece = shapely.STRtree(pieces).query(free, predicate="dwithin", distance=LARGEST_TOLERANCE)
    distance = shapely.distance(free[k], pieces[piece])
    gap = np.full(len(free), np.inf)
    own = distance == 0.0
    np.minimum.at(gap, k[~own], distance[~own])
    first, last = (shapely.get_point(pieces[piece[own]], n) for n in (0, -1))
    bends = shapely.get_num_points(pieces[piece[own]]) > 2
    gap[k[own]] = np.minimum(gap[k[own]], np.where(bends, shapely.distance(first, last), np.inf))
    known = np.isin(np.arange(len(free)), k[own])
    return shapely.get_coordinates(free[known]), gap[known]


def _without_repeats(outline: FloatArray) -> FloatArray:
    return outline[np.any(outline != np.roll(outline, 1, axis=0), axis=1)]
