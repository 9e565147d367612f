"""Meshes -> SpaceWall: OBJ (one block a group or object), PLY and STL (one block a file; a folder holds many).

STL and PLY come as triangles whose corners are repeated: corners nearer than MERGED of the block's size become one.
Triangles that lie in one plane become one face.
None of these formats has a unit, so it must be given. Several closed bodies in one file or group become blocks of
their own.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.basis.errors import CaseError, naming
from orchestrator.basis.graphs import connected_groups
from orchestrator.geometry.polyhedra import FLAT, Polyhedron, area_vector
from orchestrator.space.sources.material import SpaceMaterial, oriented
from orchestrator.space.wall import UPRIGHT, SpaceBlock, SpaceWall

SUFFIXES = (".obj", ".ply", ".stl")
MERGED = 1e-5
"""Part of a mesh's size below which corners are one: STL holds seven digits."""
Faces = list[tuple[int, ...]]


def read_meshes(path: Path, length: float, material: SpaceMaterial) -> SpaceWall:
    """Return the wall in a mesh file or in a folder of them; `length` (m) is their unit. Raises CaseError."""
    files = sorted(file for file in path.iterdir() if file.suffix.lower() in SUFFIXES) if path.is_dir() else [path]
    if not files:
        raise CaseError("", "holds no .obj, .ply or .stl files", "give a folder with one mesh a block")
    blocks: list[SpaceBlock] = []
    for file in files:
        with naming(file):
            for corners, faces in _meshes(file):
                for body in bodies_in(corners * length, faces):
                    blocks.append(SpaceBlock(len(blocks) + 1, body, False, material.unit_weight))
    return SpaceWall(path.stem, tuple(blocks), material.friction, read_only(UPRIGHT))


def _meshes(file: Path) -> Iterator[tuple[FloatArray, Faces]]:
    if file.suffix.lower() == ".obj":
        yield from _obj(file)
        return
    import meshio

    try:
        mesh = meshio.read(file)
    except (Exception, SystemExit) as error:  # meshio raises its own errors and ends the program on some files
        raise CaseError("", f"cannot be read ({str(error)[:80]})", "export it again, binary or ASCII") from None
    faces = [tuple(int(k) for k in row) for cells in mesh.cells for row in cells.data if len(row) >= 3]
    if not faces:
        raise CaseError("", "holds no faces", "export the surface of the block")
    yield np.asarray(mesh.points, dtype=float)[:, :3], faces


def _obj(file: Path) -> Iterator[tuple[FloatArray, Faces]]:
    """Yield corners and faces of every object or group that has faces."""
    corners: list[list[float]] = []
    groups: list[Faces] = [[]]
    try:
        for line in file.read_text(encoding="utf-8", errors="replace").splitlines():
            word, *rest = line.split() or [""]
            if word == "v":
                x, y, z = map(float, rest[:3])
                corners.append([x, y, z])
            elif word in ("o", "g") and groups[-1]:
                groups.append([])
            elif word == "f":
                places = [int(part.split("/")[0]) for part in rest]
                face = tuple(place - 1 if place > 0 else len(corners) + place for place in places)
                if len(face) < 3 or min(face) < 0 or max(face) >= len(corners):
                    raise ValueError(line)
                groups[-1].append(face)
    except (ValueError, OSError) as error:
        raise CaseError("", f"cannot be read ({str(error)[:60]})", "export it again as Wavefront OBJ") from None
    if not any(groups):
        raise CaseError("", "holds no faces", "export the surfaces of the blocks")
    for faces in groups:
        if faces:
            yield np.array(corners), faces


def bodies_in(corners: FloatArray, faces: Faces) -> Iterator[Polyhedron]:
    """Yield the closed bodies of a mesh: corners merged, faces without area dropped, split where no edge connects, what
    lies in one plane joined. Raises CaseError (without the file) for corners that are no finite numbers."""
    used = np.unique(np.concatenate([np.array(face) for face in faces]))
    if not np.isfinite(corners[used]).all():
        raise CaseError("", "a corner is not three finite numbers", "export the mesh again")
    size = float(np.linalg.norm(np.ptp(corners[used], axis=0)))
    pairs = cKDTree(corners[used]).query_pairs(MERGED * size, output_type="ndarray")
    merged = connected_groups(len(used), *pairs.T)
    _, first = np.unique(merged, return_index=True)
    number = dict(zip(used.tolist(), merged.tolist(), strict=True))
    points, kept = corners[used][first], list[tuple[int, ...]]()
    for face in faces:
        ring = [number[k] for k in face]
        ring = [k for k, before in zip(ring, [ring[-1], *ring[:-1]], strict=True) if k != before]
        if len(ring) >= 3:
            kept.append(tuple(ring))
    for group in (_plane_faces(points, _consistent(group)) for group in _connected(kept)):
        mine = sorted({k for face in group for k in face})
        place = {k: n for n, k in enumerate(mine)}
        yield oriented(Polyhedron(read_only(points[mine]), tuple(tuple(place[k] for k in face) for face in group)))


def _plane_faces(corners: FloatArray, faces: Faces) -> Faces:
    """Return the faces of one body: what shares edges and lies in one plane (FLAT) is one where one ring bounds it.

    Every corner stays: neighbours have it too.
    """
    areas = np.array([area_vector(corners[list(face)]) for face in faces])
    normals = areas / np.maximum(np.linalg.norm(areas, axis=1), np.finfo(float).tiny)[:, None]
    owner = {edge: k for k, face in enumerate(faces) for edge in _edges(face)}
    pairs = [(k, owner[end, start]) for (start, end), k in owner.items() if (end, start) in owner]
    level = [(k, other) for k, other in pairs if np.linalg.norm(normals[k] - normals[other]) < FLAT]
    group = connected_groups(len(faces), *np.array(level, dtype=int).reshape(-1, 2).T)
    joined: Faces = []
    for number in range(group.max() + 1):
        mine = [face for face, own in zip(faces, group, strict=True) if own == number]
        ring = _ring_around(mine)
        joined += [ring] if len(mine) > 1 and _is_plane(corners[list(ring)]) else mine
    return joined


def _ring_around(faces: Faces) -> tuple[int, ...]:
    """Return the ring of corners that bounds faces, empty where there are several or one touches itself."""
    edges = {edge for face in faces for edge in _edges(face)}
    bounding = [(start, end) for start, end in edges if (end, start) not in edges]
    following = dict(bounding)
    ring = [min(following)]
    while len(ring) < len(following) and (after := following[ring[-1]]) != ring[0]:
        ring.append(after)
    return tuple(ring) if len(ring) == len(bounding) else ()


def _is_plane(ring: FloatArray) -> bool:
    """Whether corners (n, 3) of a ring lie in one plane, to FLAT of its size."""
    if len(ring) < 3:
        return False
    area, size = area_vector(ring), float(np.linalg.norm(np.ptp(ring, axis=0)))
    off = (ring - ring.mean(axis=0)) @ (area / max(np.linalg.norm(area), np.finfo(float).tiny))
    return bool(np.abs(off).max() <= FLAT * size)


def _connected(faces: Faces) -> Iterator[Faces]:
    """Yield the faces of every body: those that edges connect. Raises CaseError where more than two meet at an edge."""
    at_edge: dict[tuple[int, int], list[int]] = {}
    for k, face in enumerate(faces):
        for start, end in zip(face, (*face[1:], face[0]), strict=True):
            at_edge.setdefault((min(start, end), max(start, end)), []).append(k)
    if any(len(meeting) > 2 for meeting in at_edge.values()):
        raise CaseError("", "stones that touch share edges in it", "export one file, or one OBJ group, a stone")
    pairs = np.array([meeting for meeting in at_edge.values() if len(meeting) == 2]).reshape(-1, 2)
    group = connected_groups(len(faces), *pairs.T)
    for number in range(group.max() + 1):
        yield [face for face, own in zip(faces, group, strict=True) if own == number]


def _consistent(faces: Faces) -> Faces:
    """Return the faces of one body all run the same way round: every edge once each way, where that is possible."""
    at_edge: dict[tuple[int, int], list[int]] = {}
    for k, face in enumerate(faces):
        for start, end in _edges(face):
            at_edge.setdefault((min(start, end), max(start, end)), []).append(k)
    turned: dict[int, bool] = {0: False}
    waiting = [0]
    while waiting:
        k = waiting.pop()
        for start, end in _edges(faces[k]):
            for other in at_edge[min(start, end), max(start, end)]:
                if other not in turned:
                    same_way = (start, end) in _edges(faces[other])
                    turned[other] = turned[k] != same_way
                    waiting.append(other)
    return [face[::-1] if turned.get(k, False) else face for k, face in enumerate(faces)]


def _edges(face: tuple[int, ...]) -> list[tuple[int, int]]:
    return [*zip(face, (*face[1:], face[0]), strict=True)]
