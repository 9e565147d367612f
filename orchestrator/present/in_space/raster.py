"""Pictures of polyhedra with hidden surfaces: an orthographic view into a depth buffer, in numpy alone.

Faces are filled triangle by triangle with their depth, shaded by their slope; where the face in front changes, a line
is drawn; lines in space (joints) show where they are not hidden. Everything is drawn twice as fine and averaged.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray
from orchestrator.geometry.polyhedra import Polyhedron, face_normals, tangents_of, triangles

FINER = 2
"""pixels drawn for one that is shown, on each side"""
BIAS = 4e-3
"""Part of the picture's size by which a line may lie behind a face and still be drawn."""
DEEP = 0.8
"""part of the largest distance from a face's outline that the place of its number has at least"""
LIGHT = np.array([0.25, 0.45, 0.86])
"""right, up, towards the eye"""


@dataclass(frozen=True, eq=False, slots=True)
class View:
    """Where the eye is: axes (3, 3), the picture's right and up and the direction towards the eye."""

    name: str
    axes: FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class Picture:
    """pixels (height, width, 3) from 0 to 1; face (height, width): the number of the face that is seen there, -1 for
    none, counted over all bodies; first (n,): the number of each body's first one."""

    pixels: FloatArray
    face: IntArray
    first: IntArray


@dataclass(frozen=True, eq=False, slots=True)
class Line:
    """Points (n, 3) that are joined by straight lines; colour (3,) from 0 to 1; width in pixels of the picture; whether
    it shows through what is in front of it."""

    points: FloatArray
    colour: tuple[float, float, float]
    width: float
    through: bool = False


def view_towards(name: str, eye: FloatArray, up: FloatArray) -> View:
    """Return the view of an eye in direction `eye` (3,) from the wall, upright where `up` (3,) allows."""
    eye = eye / np.linalg.norm(eye)
    right = np.cross(up, eye)
    right = right / np.linalg.norm(right) if np.linalg.norm(right) > 1e-6 else tangents_of(eye)[0]
    return View(name, np.array([right, np.cross(eye, right), eye]))


def drawn(
    bodies: Sequence[Polyhedron],
    colours: FloatArray,
    lines: Sequence[Line],
    view: View,
    box: tuple[FloatArray, FloatArray],
    pixels: int,
) -> Picture:
    """Return a picture of bodies with colours (n, 3) and lines; box: the corners in the view's right and up (2,) that
    it shows; pixels: its longer side."""
    low, high = box
    scale = FINER * pixels / float((high - low).max())
    width, height = (max(4, int(np.ceil(side * scale))) for side in high - low)
    colour, depth = np.ones((height, width, 3)), np.full((height, width), -np.inf)
    face = np.full((height, width), -1, dtype=np.int64)
    first = np.cumsum([0, *(len(body.faces) for body in bodies)])[:-1]
    for body, own, number in zip(bodies, colours, first.tolist(), strict=True):
        place = body.vertices @ view.axes.T
        flat = (place[:, :2] - low) * scale
        normal = face_normals(body) @ view.axes.T
        groups = _flat_groups(normal)
        shade = 0.58 + 0.42 * np.maximum(normal @ LIGHT, 0.0)
        for triangle, k in zip(triangles(body), _face_of_triangles(body), strict=True):
            if normal[k, 2] > 1e-9:
                _fill(flat[triangle], place[triangle, 2], own * shade[k], number + groups[k], colour, depth, face)
    _edges(colour, face)
    for line in lines:
        _line(line, view, low, scale, colour, depth)
    trimmed = colour[: height // FINER * FINER, : width // FINER * FINER]
    averaged = trimmed.reshape(height // FINER, FINER, width // FINER, FINER, 3).mean(axis=(1, 3))
    shown = face[: len(averaged) * FINER : FINER, : averaged.shape[1] * FINER : FINER]
    return Picture(averaged[::-1], shown[::-1], first)


def places_of_numbers(picture: Picture) -> dict[int, tuple[int, int, int, int]]:
    """Return where the number of every body that is seen goes, on the face of which most is seen: column and row of the
    pixel, and how many pixels of the face there are beside it in its row and in its column, itself among them."""
    from scipy.ndimage import distance_transform_cdt

    face = picture.face
    seen = np.bincount(face.ravel() + 1)[1:]
    by_face = np.split(np.argsort(face, axis=None, kind="stable"), np.cumsum([np.sum(face < 0), *seen[:-1]]))[1:]
    padded = np.pad(face, 1, constant_values=-1)
    alike = [np.roll(padded, step, axis) == padded for axis in (0, 1) for step in (-1, 1)]
    inside = np.asarray(distance_transform_cdt(np.logical_and.reduce(alike)))[1:-1, 1:-1]
    body = np.searchsorted(picture.first, np.arange(len(seen)), side="right") - 1
    places = {}
    for k in np.unique(body[seen > 0]).tolist():
        largest = int(np.argmax(np.where(body == k, seen, 0)))
        pixels = np.column_stack(np.unravel_index(by_face[largest], face.shape))
        depth = inside[tuple(pixels.T)]
        off = np.where(depth < DEEP * depth.max(), np.inf, np.linalg.norm(pixels - pixels.mean(axis=0), axis=1))
        row, column = pixels[np.argmin(off)].tolist()
        across, along = face[row] == largest, face[:, column] == largest
        places[k] = (column, row, _around(across, column), _around(along, row))
    return places


def _around(holds: BoolArray, place: int) -> int:
    """Return how many neighbours in a row hold, at a place that does."""
    ends = np.flatnonzero(~holds)
    after = np.searchsorted(ends, place)
    return int((ends[after] if after < len(ends) else len(holds)) - (ends[after - 1] + 1 if after else 0))


def _flat_groups(normal: FloatArray) -> IntArray:
    """Number faces so that those of one direction share a number: no lines between the triangles of a plane."""
    _, group = np.unique(np.round(normal, 4), axis=0, return_inverse=True)
    return np.asarray(group).ravel()


def _face_of_triangles(body: Polyhedron) -> IntArray:
    return np.repeat(np.arange(len(body.faces)), [len(face) - 2 for face in body.faces])


def _fill(
    flat: FloatArray,
    heights: FloatArray,
    own: FloatArray,
    number: int,
    colour: FloatArray,
    depth: FloatArray,
    face: IntArray,
) -> None:
    """Fill a triangle (3, 2), in pixels, where nothing drawn so far is in front of it."""
    low = np.maximum(np.floor(flat.min(axis=0)).astype(int), 0)
    high = np.minimum(np.ceil(flat.max(axis=0)).astype(int) + 1, depth.shape[::-1])
    if (low >= high).any():
        return
    (ax, ay), (bx, by), (cx, cy) = flat
    twice = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
    if abs(twice) < 1e-12:
        return
    x = np.arange(low[0], high[0])[None] + 0.5
    y = np.arange(low[1], high[1])[:, None] + 0.5
    second = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / twice
    third = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / twice
    inside = (second >= -1e-9) & (third >= -1e-9) & (second + third <= 1.0 + 1e-9)
    height = heights[0] + second * (heights[1] - heights[0]) + third * (heights[2] - heights[0])
    window = (slice(low[1], high[1]), slice(low[0], high[0]))
    front = inside & (height > depth[window] + 1e-9)
    depth[window][front], face[window][front] = height[front], number
    colour[window][front] = own


def _edges(colour: FloatArray, face: IntArray) -> None:
    """Darken pixels beside which another face is in front."""
    below, above = (slice(1, None),), (slice(None, -1),)
    right, left = (slice(None), slice(1, None)), (slice(None), slice(None, -1))
    for one, other in ((below, above), (right, left)):
        differs = face[one] != face[other]
        colour[one][differs] *= 0.35
        colour[other][differs] = np.minimum(colour[other][differs], 0.35 * np.ones(3))


def _line(line: Line, view: View, low: FloatArray, scale: float, colour: FloatArray, depth: FloatArray) -> None:
    """Draw straight lines, where no face is in front of them by more than BIAS or all through."""
    place = line.points @ view.axes.T
    behind = np.inf if line.through else BIAS * max(depth.shape) / scale
    reach = max(0, round(0.5 * FINER * line.width))
    steps = np.arange(-reach, reach + 1)
    brush = np.array([(x, y) for x in steps for y in steps if x * x + y * y <= reach * reach + 1])
    for start, end in pairwise(place):
        count = max(2, int(np.linalg.norm((end - start)[:2]) * scale) + 1)
        part = np.linspace(0.0, 1.0, count)[:, None]
        points = start + part * (end - start)
        at = np.floor((points[:, :2] - low) * scale).astype(int)
        inside = ((at >= 0) & (at < depth.shape[::-1])).all(axis=1)
        at, height = at[inside], points[inside, 2]
        seen = at[height > depth[at[:, 1], at[:, 0]] - behind]
        dots = (seen[:, None] + brush[None]).reshape(-1, 2)
        dots = dots[((dots >= 0) & (dots < depth.shape[::-1])).all(axis=1)]
        colour[dots[:, 1], dots[:, 0]] = line.colour
