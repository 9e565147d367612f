"""Tetrahedral meshes of the moving bodies: outlines extruded over the thickness, joint ends imprinted (gmsh)."""

from __future__ import annotations

import hashlib
import io
import json
import logging
import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Annotated, Any

import numpy as np
from annotated_types import Ge, Gt, Le

from orchestrator.basis.arrays import FloatArray, IntArray, read_only
from orchestrator.basis.atomic_files import sealed, unsealed, write_bytes
from orchestrator.basis.checked import Checked
from orchestrator.basis.threads import in_turn
from orchestrator.basis.units import Unit
from orchestrator.macroblocks.bodies import Bodies, Body
from orchestrator.masonry.wall import EXTREMES
from orchestrator.pushover.prisms import extruded, extruded_lines
from orchestrator.pushover.toes import GROWTH, OFFSET, bent_by_columns, element_ends

logger = logging.getLogger(__name__)

FAR = 1e3
"""sizes of elements from the outline up to which they grow"""
SAMPLES = 100
"""points of each line of an outline from which distances are measured"""


@dataclass(frozen=True, slots=True)
class MeshSettings(Checked):
    """Element size in the wall's plane and number of element layers through the thickness."""

    size: Annotated[float, Ge(EXTREMES[0]), Le(EXTREMES[1]), Unit("m")] | None = None
    """largest edge of an element on the outline of a body; joint ends are nodes. Left out: half a mean stone's size"""
    layers: Annotated[int, Ge(1)] = 1
    """elements through the thickness"""
    matching_faces: bool = False
    """both sides of a joint get the same triangles: with 10-node tetrahedra the contact patch test is then exact, not
    2 % off, but all diagonals lean one way, and walls whose courses slide take many more increments; with 4 nodes it is
    exact anyway"""
    toe_offset: Annotated[float, Gt(0), Le(0.5)] = OFFSET
    """share of a joint's length by which the resultant of a toe may lie off that crushes, presses mortar with a normal
    stiffness (joints.classes), is left of a cracked bond, bears a column that leans, or that stones turn about in the
    mechanism of limit analysis: elements are so short there; 0.5 leaves them at `size`"""
    growth: Annotated[float, Ge(0), Le(2)] = GROWTH
    """by which elements grow over the distance from the outline beyond `size`: what is inside of large bodies only
    bends; 0: none is longer than `size`"""

    def size_of(self, bodies: Bodies) -> float:
        """Return the largest edge of an element on an outline in m."""
        return 0.5 * bodies.mean_stone if self.size is None else self.size


@dataclass(frozen=True, eq=False, slots=True)
class BodyMeshes:
    """One mesh of disconnected components: no node is shared by two bodies.

    nodes (m, 3) in m, x and y in the wall's plane, z from 0 to the thickness; tetrahedra (t, 4), positively oriented;
    body_of_node (m,), body_of_tetrahedron (t,); nodes and tetrahedra of a body are contiguous, bodies in order.
    side_triangles (f, 3): boundary triangles on the extruded outline, outward orientation (right-hand rule);
    body_of_side (f,); side_edge (f,): the edge of its body's rings that each lies on (numbered as in bodies.py).
    unit_weight (bodies,) in N/m3 of the moving bodies. distinct_shapes: how many different meshes were generated.
    """

    nodes: FloatArray
    tetrahedra: IntArray
    body_of_node: IntArray
    body_of_tetrahedron: IntArray
    side_triangles: IntArray
    body_of_side: IntArray
    side_edge: IntArray
    unit_weight: FloatArray
    distinct_shapes: int
    seconds: float


@dataclass(frozen=True, eq=False, slots=True)
class ShapeMesh:
    """Mesh of one shape, first vertex of its outline at (0, 0): nodes (m, 3) in m, tetrahedra (t, 4), sides (f, 3).

    side_edge (f,): the edge of the shape's rings that each side lies on.
    """

    nodes: FloatArray
    tetrahedra: IntArray
    sides: IntArray
    side_edge: IntArray


@dataclass(frozen=True, slots=True)
class CutOutline:
    """rings: their vertices relative to the first vertex of the outline, rounded to 1e-9 m. cuts: where elements end
    within an edge, as shares of it; for edges of no cuts, and where there are none, the size of elements decides.
    bends: circles (x, y, radius) in m, about toes that columns lean on, in which elements inside are as long as the
    nearest of the outline.
    """

    rings: tuple[tuple[tuple[float, float], ...], ...]
    cuts: tuple[tuple[float, ...], ...] = ()
    bends: tuple[tuple[float, ...], ...] = ()


@in_turn
def mesh_bodies(bodies: Bodies, settings: MeshSettings, cache: Path | None = None) -> BodyMeshes:
    """Return the meshes of the moving bodies; equal shapes are meshed once, and kept in the folder `cache`."""
    began = perf_counter()
    moving = bodies.bodies[: bodies.moving]
    size = settings.size_of(bodies)
    ends = element_ends(bodies, size, settings.toe_offset)
    bends = bent_by_columns(bodies, size, settings.toe_offset)
    shapes = [_shape(body, ends, bends.get(body.number, ())) for body in moving]
    known = _meshes(dict.fromkeys(shapes), bodies.thickness, size, settings, cache)
    meshes = [known[shape] for shape in shapes]
    first_node = np.cumsum([0, *(len(mesh.nodes) for mesh in meshes)])
    origins = [np.append(body.exterior[0], 0.0) for body in moving]
    number = np.arange(len(moving))
    return BodyMeshes(
        nodes=read_only(np.concatenate([m.nodes + origin for m, origin in zip(meshes, origins, strict=True)])),
        tetrahedra=read_only(
            np.concatenate([m.tetrahedra + n for m, n in zip(meshes, first_node, strict=False)]), np.int64
        ),
        body_of_node=read_only(np.repeat(number, [len(m.nodes) for m in meshes]), np.int64),
        body_of_tetrahedron=read_only(np.repeat(number, [len(m.tetrahedra) for m in meshes]), np.int64),
        side_triangles=read_only(
            np.concatenate([m.sides + n for m, n in zip(meshes, first_node, strict=False)]), np.int64
        ),
        body_of_side=read_only(np.repeat(number, [len(m.sides) for m in meshes]), np.int64),
        side_edge=read_only(np.concatenate([m.side_edge for m in meshes]), np.int64),
        unit_weight=read_only([body.unit_weight for body in moving]),
        distinct_shapes=len(known),
        seconds=perf_counter() - began,
    )


def _shape(body: Body, ends: dict[tuple[int, int], FloatArray], bends: Sequence[FloatArray]) -> CutOutline:
    rings = [np.round(ring - body.exterior[0], 9) + 0.0 for ring in (body.exterior, *body.holes)]
    cuts = [np.round(ends.get((body.number, k), ()), 9) for k in range(sum(map(len, rings)))]
    return CutOutline(
        rings=tuple(tuple((float(x), float(y)) for x, y in ring) for ring in rings),
        cuts=tuple(tuple(map(float, of_edge)) for of_edge in cuts) if any(map(len, cuts)) else (),
        bends=tuple(tuple(map(float, np.round(circle - [*body.exterior[0], 0.0], 9))) for circle in bends),
    )


def _meshes(
    shapes: dict[CutOutline, None], thickness: float, size: float, settings: MeshSettings, cache: Path | None
) -> dict[CutOutline, ShapeMesh]:
    """Return a mesh for each shape, from the cache where it is there."""
    files = {shape: cache and cache / f"{_content_hash(shape, thickness, size, settings)}.npz" for shape in shapes}
    meshes = {shape: mesh for shape, file in files.items() if (mesh := _cached(file)) is not None}
    missing = [shape for shape in shapes if shape not in meshes]
    if missing:
        with gmsh_session() as gmsh:
            for shape in missing:
                meshes[shape] = _mesh_shape(gmsh, shape, thickness, size, settings)
                _keep(meshes[shape], files[shape])
    return meshes


@contextmanager
def gmsh_session() -> Iterator[Any]:
    """Hold gmsh's global state: silent, one thread, the sizes of elements inside are those of `_grow` alone."""
    import gmsh  # 130 MB that check, limit and segment do not need

    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.NumThreads", 1)
        gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
        gmsh.option.setNumber("Mesh.MeshSizeFromPoints", 0)
        yield gmsh
    finally:
        gmsh.finalize()


def _mesh_shape(gmsh: Any, shape: CutOutline, thickness: float, size: float, settings: MeshSettings) -> ShapeMesh:
    """Triangulate the outline, extrude it, and return its tetrahedra."""
    gmsh.model.add("body")
    geometry = gmsh.model.geo
    rings = _add_rings(geometry, shape, size)
    surface = geometry.addPlaneSurface(
        [geometry.addCurveLoop([line for edge in ring for line in edge]) for ring in rings]
    )
    if not settings.matching_faces:
        geometry.extrude([(2, surface)], 0.0, 0.0, thickness, [settings.layers])
    geometry.synchronize()
    lines = [line for ring in rings for edge in ring for line in edge]
    _grow(gmsh.model.mesh.field, lines, size, settings.growth, shape)
    gmsh.model.mesh.generate(2 if settings.matching_faces else 3)
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    _, _, elements = gmsh.model.mesh.getElements(2 if settings.matching_faces else 3)
    edges = _elements_of_edges(gmsh, [edge for ring in rings for edge in ring], surface, settings.matching_faces)
    gmsh.model.remove()
    tags, order = np.unique(np.asarray(tags, np.int64), return_index=True)
    nodes = np.asarray(coordinates).reshape(-1, 3)[order]
    assert len(elements) == 1, "the outline must be triangles only, the body tetrahedra only"
    tetrahedra = np.searchsorted(tags, np.asarray(elements[0], np.int64)).reshape(
        -1, 3 if settings.matching_faces else 4
    )
    on_edge = [np.searchsorted(tags, of_edge) for of_edge in edges]
    if settings.matching_faces:
        levels = np.linspace(0.0, thickness, settings.layers + 1)
        tetrahedra = extruded(nodes[:, :2], tetrahedra, settings.layers)
        on_edge = [extruded_lines(lines, len(nodes), settings.layers) for lines in on_edge]
        nodes = np.column_stack([np.tile(nodes[:, :2], (len(levels), 1)), np.repeat(levels, len(nodes))])
    tetrahedra = _positive(nodes, tetrahedra)
    return ShapeMesh(nodes, tetrahedra, *_sides(tetrahedra, on_edge))


def _grow(field: Any, outline: list[int], size: float, growth: float, shape: CutOutline) -> None:
    """Let elements inside be `size` long, from that distance of the outline on longer, by `growth` x what is beyond it.

    Those at toes are shorter, and grow over the distance from there, but where the shape bends.
    """
    away, length = field.add("Distance"), field.add("MathEval")
    field.setNumbers(away, "CurvesList", outline)
    field.setNumber(away, "Sampling", SAMPLES)
    beyond = f"(F{away} - {size:.17g} + Fabs(F{away} - {size:.17g})) / 2"  # 0 up to `size`
    field.setString(length, "F", f"{size:.17g} + {growth:.17g} * {beyond}")
    if shape.cuts:
        lengths = [length, _from_outline(field, outline, size, GROWTH)]
        lengths += [_within(field, _from_outline(field, outline, size, 0.0), *circle) for circle in shape.bends]
        length = field.add("Min")
        field.setNumbers(length, "FieldsList", lengths)
    field.setAsBackgroundMesh(length)


def _from_outline(field: Any, outline: list[int], size: float, growth: float) -> int:
    """Add elements as long as the nearest of the outline, up to `size` and, over the distance, by `growth` longer."""
    near = field.add("Extend")
    field.setNumbers(near, "CurvesList", outline)
    for name, value in (("DistMax", FAR * size), ("SizeMax", size + growth * FAR * size), ("Power", 1.0)):
        field.setNumber(near, name, value)
    return int(near)


def _within(field: Any, even: int, x: float, y: float, radius: float) -> int:
    """Add the lengths of a field within a circle, and from there on longer ones."""
    within, beyond = field.add("MathEval"), f"Sqrt((x - ({x:.17g}))^2 + (y - ({y:.17g}))^2) - {radius:.17g}"
    field.setString(within, "F", f"F{even} + {GROWTH:.17g} * ({beyond} + Fabs({beyond})) / 2")
    return int(within)


def _elements_of_edges(gmsh: Any, edges: list[list[int]], surface: int, matching_faces: bool) -> list[IntArray]:
    """Return the node tags of the triangles (f, 3) over each edge's lines, or of the lines' own elements (f, 2)."""
    lines = [line for edge in edges for line in edge]
    if matching_faces:
        tags = [gmsh.model.mesh.getElements(1, line)[2] for line in lines]
    else:
        above = [[face for face in gmsh.model.getAdjacencies(1, line)[0] if face != surface] for line in lines]
        assert all(len(faces) == 1 for faces in above), "extrusion makes one surface over each line"
        tags = [gmsh.model.mesh.getElements(2, faces[0])[2] for faces in above]
    assert all(len(elements) == 1 for elements in tags), "the sides must be triangles only"
    corners = 2 if matching_faces else 3
    of_line = iter(np.asarray(elements[0], np.int64).reshape(-1, corners) for elements in tags)
    return [np.concatenate([next(of_line) for _ in edge]) for edge in edges]


def _add_rings(geometry: Any, shape: CutOutline, size: float) -> list[list[list[int]]]:
    """Add the closed rings of a shape; return the lines of each edge of each, as its cuts divide it."""
    cuts = iter(shape.cuts or [()] * sum(map(len, shape.rings)))
    return [_add_ring(geometry, np.array(ring), [next(cuts) for _ in ring], size) for ring in shape.rings]


def _add_ring(geometry: Any, ring: FloatArray, cuts: list[tuple[float, ...]], size: float) -> list[list[int]]:
    """Add a closed ring of straight edges; a line that is cut, or no longer than `size`, stays one element edge."""
    following = np.roll(ring, -1, axis=0)
    share = [np.array([0.0, *within]) for within in cuts]
    corners = [a + part[:, None] * (b - a) for a, b, part in zip(ring, following, share, strict=True)]
    points = np.concatenate(corners)
    lengths = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    tags = [geometry.addPoint(x, y, 0.0) for x, y in points]
    lines = [geometry.addLine(a, b) for a, b in zip(tags, tags[1:] + tags[:1], strict=True)]
    for line, length in zip(lines, lengths, strict=True):
        geometry.mesh.setTransfiniteCurve(line, max(1, math.ceil(length / size - 1e-6)) + 1)
    of_line = iter(lines)
    return [[next(of_line) for _ in part] for part in share]


def _positive(nodes: FloatArray, tetrahedra: IntArray) -> IntArray:
    """Return the tetrahedra with positive volume (extruded ones may come out negative)."""
    return np.where((volumes(nodes, tetrahedra) > 0)[:, None], tetrahedra, tetrahedra[:, [0, 2, 1, 3]])


def volumes(nodes: FloatArray, tetrahedra: IntArray) -> FloatArray:
    """Return signed volumes (t,) in m3."""
    a, b, c, d = (nodes[tetrahedra[:, k]] for k in range(4))
    return np.einsum("ti,ti->t", b - a, np.cross(c - a, d - a)) / 6.0


def triangle_areas(nodes: FloatArray, triangles: IntArray) -> FloatArray:
    """Return areas (t,) in m2."""
    edges = nodes[triangles[:, 1:]] - nodes[triangles[:, :1]]
    return 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)


def _sides(tetrahedra: IntArray, on_edge: list[IntArray]) -> tuple[IntArray, IntArray]:
    """Return the boundary triangles (f, 3), outward, that are among those of an edge (f, 3), and these edges (f,)."""
    faces = np.concatenate([tetrahedra[:, k] for k in ([1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1])])
    known = np.concatenate(on_edge)
    edge = np.repeat(np.arange(len(on_edge)), [len(triangles) for triangles in on_edge])
    _, position, count = np.unique(np.sort(faces, axis=1), axis=0, return_inverse=True, return_counts=True)
    boundary = faces[count[position] == 1]
    _, position = np.unique(np.sort(np.concatenate([known, boundary]), axis=1), axis=0, return_inverse=True)
    edge_of = np.full(position.max() + 1, -1)
    edge_of[position[: len(known)]] = edge
    side_edge = edge_of[position[len(known) :]]
    return boundary[side_edge >= 0], side_edge[side_edge >= 0]


def _content_hash(shape: CutOutline, thickness: float, size: float, settings: MeshSettings) -> str:
    from importlib.metadata import version

    sizes = [thickness, size, settings.growth, settings.layers, settings.matching_faces]
    content = [shape.rings, shape.cuts, shape.bends, *sizes, version("gmsh"), "grows beyond its columns"]
    return hashlib.sha256(json.dumps(content).encode()).hexdigest()[:32]


def _cached(file: Path | None) -> ShapeMesh | None:
    """Return the mesh kept in `file`; None where there is none or it was damaged (it is then made again)."""
    if file is None or not file.exists():
        return None
    try:
        with np.load(io.BytesIO(unsealed(file.read_bytes())), allow_pickle=False) as stored:
            return ShapeMesh(stored["nodes"], stored["tetrahedra"], stored["sides"], stored["side_edge"])
    except (OSError, ValueError, KeyError) as error:
        logger.warning("%s: cannot be read (%s); the mesh is made again", file, error)
        return None


def _keep(mesh: ShapeMesh, file: Path | None) -> None:
    if file is None:
        return
    content = io.BytesIO()
    np.savez_compressed(
        content, nodes=mesh.nodes, tetrahedra=mesh.tetrahedra, sides=mesh.sides, side_edge=mesh.side_edge
    )
    try:
        write_bytes(file, sealed(content.getvalue()))
    except OSError as error:
        logger.warning("%s: %s; the mesh is not kept for the next run", file, error.strerror)
