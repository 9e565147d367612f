"""Joints between polyhedra: where faces of two blocks look at each other in one plane.

Pairs of blocks whose boxes touch; pairs of faces that look at each other; the polygon both cover, in their mean plane;
pieces of one pair of blocks in one plane become one region (triangulated faces leave no seams). Every connected part of
a region is a joint, with the corners of its convex hull as contact points: with plane contact, friction and unlimited
strength, forces at these corners make up exactly the forces that any distribution of pressure can make
(Livesley 1992; docs/space.md). Several joints a pair of blocks are allowed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import shapely
from annotated_types import Gt, Le

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.basis.checked import Checked
from orchestrator.basis.errors import CaseError
from orchestrator.geometry.polyhedra import face_normals, tangents_of
from orchestrator.geometry.rigid import cross
from orchestrator.masonry.interfaces import Interfaces
from orchestrator.space.alignment import aligned
from orchestrator.space.wall import SpaceWall, pairs_of_boxes

TOUCHING = -0.998
"""Cosine between outward normals from which two faces may touch: 3.6 degrees, what a gap of a stone's tolerance allows;
the gap itself decides."""
COLLINEAR = 1e-3
"""Part of a joint's size by which a hull corner must stand out to be a contact point: as much as faces may gape. Of
corners that a drawing has a micrometre apart each would be a point with a spring of its own."""
OUTLINE_GRID = 1e-9
"""Part of a face's size to which outlines are rounded before they are intersected: without, two faces that share an
edge to rounding may come out as lying on each other (GEOS 3.13; a dome of 112 blocks had 6 joints too many)."""
LARGEST_GAP = 0.1
"""of what faces may gape by"""
GAPING = 10.0
"""times contact.gap up to which faces that have no joint look as if they should"""
NOTHING = 1e-9
"""Part of a stone's face below which a common area is rounding and is not even listed."""


@dataclass(frozen=True, slots=True)
class FaceContactSettings(Checked):
    """How near faces must be to touch, and what is too small to be a joint; both relative to the stones."""

    gap: Annotated[float, Gt(0), Le(LARGEST_GAP)] = 1e-3
    """largest distance between two faces, as a part of the smaller block's size (cube root of its volume)"""
    smallest: Annotated[float, Gt(0), Le(0.5)] = 1e-3
    """smaller common areas, as a part of (volume of the smaller block)^(2/3), are no joint; they are listed"""


@dataclass(frozen=True, slots=True)
class Ignored:
    """A common area (m2) of two blocks (ids) too small to be a joint."""

    i: int
    j: int
    area: float


@dataclass(frozen=True, eq=False, slots=True)
class SpaceAssemblage:
    """A wall in space, its joints, and the common areas too small to be one."""

    wall: SpaceWall
    joints: Interfaces
    ignored: tuple[Ignored, ...]


@dataclass(frozen=True, eq=False, slots=True)
class _Faces:
    """The faces of one block: outlines (n, 3) each, outward unit normals (f, 3), one corner of each (f, 3)."""

    outlines: list[FloatArray]
    normal: FloatArray
    corner: FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class _Region:
    """A plane region that two blocks share: outline in the frame (3, 3: t1, t2, n) about an origin (3,)."""

    polygon: shapely.Geometry
    frame: FloatArray
    origin: FloatArray


def find_joints(wall: SpaceWall, settings: FaceContactSettings | None = None) -> SpaceAssemblage:
    """Return the assemblage of a wall with its corners at common levels (alignment.py): joints sorted by block i, block
    j; two supports have none. Raises CaseError for a block that no chain of joints connects to a support."""
    settings = settings or FaceContactSettings()
    wall = aligned(wall, settings.gap)
    regions: list[tuple[int, int, _Region]] = []
    ignored = []
    for i, j, part, share in _shared(wall, settings.gap):
        if share >= settings.smallest:
            regions.append((i, j, part))
        elif share > NOTHING:
            ignored.append(Ignored(wall.blocks[i].id, wall.blocks[j].id, float(part.polygon.area)))
    assemblage = SpaceAssemblage(wall, _interfaces(wall, regions), tuple(ignored))
    _refuse_unsupported(assemblage)
    return assemblage


def gaping(assemblage: SpaceAssemblage, settings: FaceContactSettings) -> list[tuple[int, int]]:
    """Return the pairs of blocks (ids) that have no joint and would have one with up to GAPING times the gap."""
    blocks, joints = assemblage.wall.blocks, assemblage.joints
    known = {*zip(joints.i.tolist(), joints.j.tolist(), strict=True)}
    found = {(i, j) for i, j, _, share in _shared(assemblage.wall, GAPING * settings.gap) if share >= settings.smallest}
    small = {(one.i, one.j) for one in assemblage.ignored}
    named = [(blocks[i].id, blocks[j].id) for i, j in sorted(found - known)]
    return [pair for pair in named if pair not in small]


def _shared(wall: SpaceWall, gap: float) -> Iterator[tuple[int, int, _Region, float]]:
    """Yield what pairs of blocks share within a gap (parts of the smaller one's size), with its area as such a part."""
    faces = [_faces(wall, number) for number in range(len(wall.blocks))]
    length = np.cbrt(wall.weights / np.array([block.unit_weight for block in wall.blocks]))
    low = np.array([block.shape.vertices.min(axis=0) for block in wall.blocks]) - gap * length[:, None]
    high = np.array([block.shape.vertices.max(axis=0) for block in wall.blocks]) + gap * length[:, None]
    for i, j in zip(*pairs_of_boxes(low, high), strict=True):
        if wall.blocks[i].fixed and wall.blocks[j].fixed:
            continue
        smaller = min(length[i], length[j])
        for part in _parts(faces[i], faces[j], gap * smaller):
            yield int(i), int(j), part, float(part.polygon.area / smaller**2)


def _faces(wall: SpaceWall, number: int) -> _Faces:
    shape = wall.blocks[number].shape
    outlines = [shape.vertices[list(face)] for face in shape.faces]
    return _Faces(outlines, face_normals(shape), np.array([outline[0] for outline in outlines]))


def _parts(one: _Faces, other: _Faces, gap: float) -> Iterator[_Region]:
    """Yield the connected parts of all plane regions that two blocks share."""
    for region in _merged(list(_pieces(one, other, gap)), gap):
        for part in getattr(region.polygon, "geoms", [region.polygon]):
            if part.geom_type == "Polygon" and part.area > 0:
                yield _Region(part, region.frame, region.origin)


def _pieces(one: _Faces, other: _Faces, gap: float) -> Iterator[_Region]:
    """Yield what pairs of faces share, each in the mean plane of the two."""
    for f, g in np.argwhere(one.normal @ other.normal.T < TOUCHING):
        heights = (other.outlines[g] - one.corner[f]) @ one.normal[f]
        if heights.min() > gap or heights.max() < -gap:
            continue
        normal = one.normal[f] - other.normal[g]
        normal /= np.linalg.norm(normal)
        frame, origin = np.vstack([tangents_of(normal), normal]), one.corner[f]
        first, second = ((outline - origin) @ frame[:2].T for outline in (one.outlines[f], other.outlines[g]))
        if (first.max(axis=0) <= second.min(axis=0)).any() or (second.max(axis=0) <= first.min(axis=0)).any():
            continue
        grid = OUTLINE_GRID * max(float(np.ptp(first)), float(np.ptp(second)))
        common = shapely.intersection(shapely.Polygon(first), shapely.Polygon(second), grid_size=grid)
        if common.area > 0 and (level := _level(one, other, int(f), int(g), frame, common, gap)) is not None:
            yield _Region(common, frame, origin + level * normal)


def _level(
    one: _Faces, other: _Faces, f: int, g: int, frame: FloatArray, common: shapely.Geometry, gap: float
) -> float | None:
    """Return the height of the mean plane over the first corner of face f, or None where the faces gape too far."""
    flat = shapely.get_coordinates(common)
    points = one.corner[f] + flat @ frame[:2]

    def height(normal: FloatArray, corner: FloatArray) -> FloatArray:
        return ((corner - points) @ normal) / (frame[2] @ normal)

    first, second = height(one.normal[f], one.corner[f]), height(other.normal[g], other.corner[g])
    return float(0.5 * (first + second).mean()) if np.abs(second - first).max() <= gap else None


def _merged(pieces: list[_Region], gap: float) -> Iterator[_Region]:
    """Yield regions: pieces that lie in one plane, as one."""
    while pieces:
        first, *others = pieces
        plane = [
            piece.frame[2] @ first.frame[2] > -TOUCHING and abs((piece.origin - first.origin) @ first.frame[2]) <= gap
            for piece in others
        ]
        if any(plane):
            turned = [_in_frame(piece, first) for piece, same in zip(others, plane, strict=True) if same]
            yield _Region(_joined([first.polygon, *turned], gap), first.frame, first.origin)
        else:
            yield first
        pieces = [piece for piece, same in zip(others, plane, strict=True) if not same]


def _in_frame(piece: _Region, first: _Region) -> shapely.Geometry:
    turn, shift = piece.frame[:2] @ first.frame[:2].T, (piece.origin - first.origin) @ first.frame[:2].T
    return shapely.transform(piece.polygon, lambda flat: flat @ turn + shift)


def _joined(polygons: list[shapely.Geometry], gap: float) -> shapely.Geometry:
    """Return the union of polygons, without the slits that rounding leaves between them."""
    hair = 1e-6 * gap
    return shapely.union_all([polygon.buffer(hair, join_style="mitre") for polygon in polygons]).buffer(
        -hair, join_style="mitre"
    )


def _interfaces(wall: SpaceWall, regions: list[tuple[int, int, _Region]]) -> Interfaces:
    hulls = [_hull(region) for _, _, region in regions]
    friction = np.array([wall.friction if block.friction is None else block.friction for block in wall.blocks])
    i, j = (np.array([pair[k] for pair in regions], dtype=np.int64) for k in (0, 1))
    frames = np.array([region.frame for _, _, region in regions]).reshape(-1, 3, 3)
    centres = [np.array(region.polygon.centroid.coords[0]) for _, _, region in regions]
    return Interfaces(
        i=read_only(i, np.int64),
        j=read_only(j, np.int64),
        normal=read_only(frames[:, 2]),
        tangents=read_only(frames[:, :2]),
        area=read_only([region.polygon.area for _, _, region in regions]),
        centroid=read_only(
            np.array([r.origin + c @ r.frame[:2] for (_, _, r), c in zip(regions, centres, strict=True)]).reshape(-1, 3)
        ),
        friction=read_only(np.minimum(friction[i], friction[j])),
        point=read_only(np.concatenate(hulls) if hulls else np.zeros((0, 3))),
        joint=read_only(np.repeat(np.arange(len(hulls)), [len(hull) for hull in hulls]), np.int64),
        outlines=tuple(_ring(region, region.polygon.exterior) for _, _, region in regions),
        holes=tuple(tuple(_ring(region, hole) for hole in region.polygon.interiors) for _, _, region in regions),
    )


def _ring(region: _Region, ring: shapely.LinearRing) -> FloatArray:
    """Return the corners (v, 3) of a ring of a region."""
    return read_only(region.origin + shapely.get_coordinates(ring)[:-1] @ region.frame[:2])


def _hull(region: _Region) -> FloatArray:
    """Return the corners (v, 3) of a region's convex hull that stand out from the line between their neighbours."""
    flat = shapely.get_coordinates(region.polygon.convex_hull)[:-1]
    size = np.ptp(flat, axis=0).max()
    k = 0
    while k < len(flat) and len(flat) > 3:
        before, after = flat[k - 1], flat[(k + 1) % len(flat)]
        run, arm = after - before, flat[k] - before
        if abs(cross(run, arm)) <= COLLINEAR * size * np.linalg.norm(run):
            flat = np.delete(flat, k, axis=0)
        else:
            k += 1
    return region.origin + flat @ region.frame[:2]


def _refuse_unsupported(assemblage: SpaceAssemblage) -> None:
    """Raise CaseError for a block that touches nothing, or that no chain of joints connects to a support."""
    wall, joints = assemblage.wall, assemblage.joints
    group = joints.groups(len(wall.blocks))
    apart = np.flatnonzero(~np.isin(group, group[wall.fixed]))
    if not len(apart):
        return
    first = int(apart[0])
    touches = first in {*joints.i.tolist(), *joints.j.tolist()}
    problem = "is not connected to any support" if touches else "touches no other block"
    x, y, z = wall.centroids[first]
    problem += f", at ({x:.4g}, {y:.4g}, {z:.4g}) m"
    free = int((~wall.fixed).sum())
    problem += f"; {len(apart)} of {free} blocks alike" if len(apart) > 1 else ""
    small = [other for other in assemblage.ignored if wall.blocks[first].id in (other.i, other.j)]
    remedy = "move it until a face of it lies on another block's, or raise contact.gap"
    if small:
        remedy = f"its common area with block {small[0].i + small[0].j - wall.blocks[first].id} is too small: "
        remedy += "lower contact.smallest, or correct the block"
    raise CaseError(f"block {wall.blocks[first].id}", problem, remedy)
