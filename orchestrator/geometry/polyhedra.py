"""Polyhedra: volume, centroid, inertia, planes of faces, and whether a body is closed, oriented and without crossings.

All integrals are sums over signed tetrahedra from one point to the triangles of the surface: exact for any closed body
whose faces are plane and run counter-clockwise seen from outside, convex or not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from orchestrator.basis.arrays import FloatArray, IntArray, read_only
from orchestrator.geometry.rigid import cross

FLAT = 1e-4
"""Part of a block's size by which the corners of a face may lie off their common plane."""
CROSSING = 1e-9
"""Part of an edge or a triangle by which a crossing must lie inside both to be one."""


@dataclass(frozen=True, eq=False, slots=True)
class Polyhedron:
    """Corners (v, 3) in m; faces: corner numbers of every face, counter-clockwise seen from outside, not closed."""

    vertices: FloatArray
    faces: tuple[tuple[int, ...], ...]

    def moved(self, turn: FloatArray, shift: FloatArray) -> Polyhedron:
        """Return the body after x -> turn x + shift; a `turn` (3, 3) that mirrors reverses the faces."""
        faces = self.faces if np.linalg.det(turn) > 0 else tuple(face[::-1] for face in self.faces)
        return Polyhedron(read_only(self.vertices @ turn.T + shift), faces)

    @property
    def size(self) -> float:
        """Diagonal of the box round the body, m."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0)))


def prism(polygon: FloatArray, start: FloatArray, axes: FloatArray) -> Polyhedron:
    """Return the prism over a plane polygon (n, 2): corners start + x axes[0] + y axes[1] (+ axes[2]).

    axes (3, 3): the directions of the polygon's x and y, and the vector from one end of the prism to the other, m.
    """
    base = start + polygon @ axes[:2]
    count = len(polygon)
    bottom, top = tuple(range(count)), tuple(range(count, 2 * count))
    sides = tuple((k, (k + 1) % count, count + (k + 1) % count, count + k) for k in range(count))
    body = Polyhedron(read_only(np.vstack([base, base + axes[2]])), (bottom[::-1], top, *sides))
    return body if volume_of(body) > 0 else reversed_faces(body)


def box(low: tuple[float, float, float], high: tuple[float, float, float]) -> Polyhedron:
    """Return the box between two corners (m)."""
    x, y, z = np.subtract(high, low)
    outline = np.array([[0.0, 0.0], [x, 0.0], [x, y], [0.0, y]])
    return prism(outline, np.array(low, dtype=float), np.diag([1.0, 1.0, z]))


def reversed_faces(body: Polyhedron) -> Polyhedron:
    """Return the body with all faces run the other way round."""
    return Polyhedron(body.vertices, tuple(face[::-1] for face in body.faces))


def fans(body: Polyhedron) -> IntArray:
    """Return triangles (t, 3) from each face's first corner: right for integrals, not for pictures of dented faces."""
    return np.array([(face[0], face[k], face[k + 1]) for face in body.faces for k in range(1, len(face) - 1)])


def volume_of(body: Polyhedron) -> float:
    """Return the volume in m3, negative where the faces run clockwise seen from outside."""
    a, b, c = np.moveaxis((body.vertices - body.vertices[0])[fans(body)], 1, 0)
    return float(np.einsum("ti,ti->", a, np.cross(b, c)) / 6.0)


def centroid_of(body: Polyhedron) -> FloatArray:
    """Return the centroid (3,) in m."""
    origin = body.vertices.mean(axis=0)
    a, b, c = np.moveaxis((body.vertices - origin)[fans(body)], 1, 0)
    sixfold = np.einsum("ti,ti->t", a, np.cross(b, c))
    return origin + (sixfold @ (a + b + c)) / (4.0 * sixfold.sum())


def face_normals(body: Polyhedron) -> FloatArray:
    """Return the outward unit normals (f, 3) of the faces; zero for a face without area."""
    normal = np.array([area_vector(body.vertices[list(face)]) for face in body.faces])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    return np.divide(normal, length, out=np.zeros_like(normal), where=length > 0)


def area_vector(polygon: FloatArray) -> FloatArray:
    """Return the area of a polygon (n, 3) in space times its unit normal, (3,) in m2."""
    arm = polygon - polygon[0]
    return 0.5 * np.cross(arm[1:-1], arm[2:]).sum(axis=0)


def tangents_of(normal: FloatArray) -> FloatArray:
    """Return two unit vectors (2, 3) with which `normal` forms a right-handed orthonormal frame."""
    least = np.eye(3)[np.argmin(np.abs(normal))]
    first = np.cross(least, normal)
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(normal, first)])


def flaw_of(body: Polyhedron, off: float = 0.0, looser: str = "") -> tuple[str, str] | None:
    """Return what is wrong with a body and what helps, or None for a closed one, oriented outwards, not crossing.

    off: m by which corners of a face may lie off their plane, where that is more than FLAT of its size; looser: what
    helps, too, where they lie farther off.
    """
    flaw = _flaw_of_faces(body, max(off, FLAT * body.size), looser) or _flaw_of_edges(body)
    if flaw:
        return flaw
    volume = volume_of(body)
    if abs(volume) < 1e-9 * body.size**3:
        return "has no volume", "give the corners of a solid body"
    if volume < 0:
        return "its faces run clockwise seen from outside", "reverse every face"
    if not is_convex(body) and (crossing := _crossing(body)):
        return crossing, "correct its corners, or split it into several blocks"
    return None


def _flaw_of_faces(body: Polyhedron, most: float, looser: str) -> tuple[str, str] | None:
    """Return the flaw of the first face that is no polygon without crossings in a plane, to `most` m."""
    size = body.size
    for number, face in enumerate(body.faces):
        corners = body.vertices[list(face)]
        if len(set(face)) < len(face):
            return f"face {number} names a corner twice", "list every corner of a face once"
        normal = area_vector(corners)
        area = np.linalg.norm(normal)
        if area <= 1e-9 * size**2:
            return f"face {number} has no area", "leave it out, or give corners that are not on one line"
        off = np.ptp(corners @ (normal / area))
        if off > most:
            by = f"{1e3 * off:.3g} mm off (at most {1e3 * most:.3g} mm)"
            return f"face {number} is not plane, its corners lie {by}", f"split it into triangles{looser}"
        if len(face) > 3 and not shapely.Polygon(corners @ tangents_of(normal / area).T).is_valid:
            return f"face {number} crosses or touches itself", "list its corners once, in order round the face"
    return None


def _flaw_of_edges(body: Polyhedron) -> tuple[str, str] | None:
    """Return what keeps the surface from being closed: every edge must be run once each way."""
    edges = [edge for face in body.faces for edge in zip(face, (*face[1:], face[0]), strict=True)]
    once = set(edges)
    if len(once) < len(edges):
        twice = next(edge for edge in edges if edges.count(edge) > 1)
        problem = f"two faces run along the edge from corner {twice[0]} to {twice[1]} the same way"
        return problem, "let every face run counter-clockwise seen from outside"
    open_edges = [edge for edge in edges if edge[::-1] not in once]
    if open_edges:
        problem = f"is open: {len(open_edges)} edges belong to one face only, the first from corner "
        return f"{problem}{open_edges[0][0]} to {open_edges[0][1]}", "add the missing faces"
    return None


def is_convex(body: Polyhedron, off: float = 0.0) -> bool:
    """Return whether no corner lies in front of any face, by more than `off` m and FLAT."""
    normal = face_normals(body)
    offset = np.array([body.vertices[face[0]] for face in body.faces])
    height = normal @ body.vertices.T - np.einsum("fi,fi->f", normal, offset)[:, None]
    return bool((height <= max(off, FLAT * body.size)).all())


def distance_to(body: Polyhedron, point: FloatArray) -> float:
    """Return how far a point (3,) lies from a body, convex or not, m: 0 in it."""
    if _winding(body, point) > 0.5:
        return 0.0
    return min(_to_face(body.vertices[list(face)], point) for face in body.faces)


def _winding(body: Polyhedron, point: FloatArray) -> float:
    """Return how often the surface goes round a point (3,): 1 in a body, 0 out of it. Solid angles of its triangles by
    Van Oosterom and Strackee (1983)."""
    arms = body.vertices - point
    length = np.linalg.norm(arms, axis=1)
    if length.min() <= 1e-12 * body.size:
        return 0.0
    a, b, c = np.moveaxis((arms / length[:, None])[fans(body)], 1, 0)
    volume = np.einsum("ti,ti->t", a, np.cross(b, c))
    cosines = 1.0 + np.einsum("ti,ti->t", a, b) + np.einsum("ti,ti->t", b, c) + np.einsum("ti,ti->t", c, a)
    return float(np.arctan2(volume, cosines).sum() / (2.0 * np.pi))


def _to_face(ring: FloatArray, point: FloatArray) -> float:
    """Return the distance of a point (3,) from a plane polygon (n, 3), m."""
    normal = area_vector(ring)
    normal /= np.linalg.norm(normal)
    across = tangents_of(normal)
    beside = shapely.Polygon((ring - ring[0]) @ across.T).distance(shapely.Point((point - ring[0]) @ across.T))
    return float(np.hypot(beside, (point - ring[0]) @ normal))


def _crossing(body: Polyhedron) -> str:
    """Return which edge goes through which face, or ""."""
    pairs = {(min(e), max(e)) for face in body.faces for e in zip(face, (*face[1:], face[0]), strict=True)}
    edges = np.array(sorted(pairs))
    start, end = body.vertices[edges[:, 0]], body.vertices[edges[:, 1]]
    for number, face in enumerate(body.faces):
        ring = body.vertices[list(face)]
        normal = area_vector(ring)
        normal /= np.linalg.norm(normal)
        low, high = (start - ring[0]) @ normal, (end - ring[0]) @ normal
        through = np.flatnonzero((low * high < -CROSSING * body.size**2) & ~np.isin(edges, face).any(axis=1))
        if not len(through):
            continue
        across = tangents_of(normal)
        part = low[through] / (low[through] - high[through])
        points = (start[through] + part[:, None] * (end[through] - start[through]) - ring[0]) @ across.T
        outline = shapely.Polygon((ring - ring[0]) @ across.T).buffer(-1e-6 * body.size)
        hit = through[shapely.contains_xy(outline, points[:, 0], points[:, 1])]
        if len(hit):
            one, other = edges[hit[0]]
            return f"crosses itself: the edge from corner {one} to {other} goes through face {number}"
    return ""


def triangles(body: Polyhedron) -> IntArray:
    """Return triangles (t, 3) that cover the faces, dented ones too: for pictures."""
    covering: list[tuple[int, int, int]] = []
    for face in body.faces:
        corners = body.vertices[list(face)]
        normal = area_vector(corners)
        flat = (corners - corners[0]) @ tangents_of(normal / np.linalg.norm(normal)).T
        covering += [(face[a], face[b], face[c]) for a, b, c in _cut_ears(flat)]
    return np.array(covering)


def _cut_ears(polygon: FloatArray) -> list[tuple[int, int, int]]:
    """Return triangles of a simple counter-clockwise polygon (n, 2)."""
    left, ears = list(range(len(polygon))), []
    while len(left) > 3:
        for k in range(len(left)):
            a, b, c = left[k - 1], left[k], left[(k + 1) % len(left)]
            others = polygon[[other for other in left if other not in (a, b, c)]]
            if cross(polygon[b] - polygon[a], polygon[c] - polygon[b]) > 0 and not _inside(polygon[[a, b, c]], others):
                ears.append((a, b, c))
                del left[k]
                break
        else:
            break
    return [*ears, *((left[0], left[k], left[k + 1]) for k in range(1, len(left) - 1))]


def _inside(triangle: FloatArray, points: FloatArray) -> bool:
    """Return whether one of the points (n, 2) lies inside a counter-clockwise triangle (3, 2) or on its sides."""
    inside = np.ones(len(points), dtype=bool)
    for start, end in zip(triangle, np.roll(triangle, -1, axis=0), strict=True):
        edge, arm = end - start, points - start
        inside &= cross(edge, arm) >= 0
    return bool(inside.any())


def rotation(axis: tuple[float, float, float], angle: float) -> FloatArray:
    """Return the turn (3, 3) by `angle` (rad) about `axis`: Rodrigues' formula."""
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
