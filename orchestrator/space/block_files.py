"""Block files (JSON) in space -> SpaceWall.

    {"units": {"length": "m", "unit_weight": "kN/m3"}, "up": "z", "unit_weight": 20.0, "friction": 0.6,
     "blocks": [{"id": 1, "vertices": [[x, y, z], ...], "faces": [[0, 1, 2, 3], ...], "fixed": false}, ...]}

Faces run counter-clockwise seen from outside. A block may be given as `polygon` with `thickness` and `offset` instead:
a prism across the plane of the polygon, whose y points up. A plane wall's file is read as prisms of its thickness.
`up` names the vertical axis; left out it is z where a block has vertices and y for plane walls.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.basis.errors import CaseError
from orchestrator.geometry.polyhedra import Polyhedron, prism
from orchestrator.masonry.sources.block_files import (
    INFORMATION,
    LARGEST_COORDINATE,
    LARGEST_FILE,
    UNIT_OF,
    json_in,
    number_in,
    polygon_of,
    refuse_unknown,
    refuse_what_is_no_name,
    unit_factor,
    what_every_block_has,
)
from orchestrator.space.wall import SpaceBlock, SpaceWall

TOP_KEYS = ("units", "up", "thickness", "unit_weight", "friction", "blocks", "mortar")
BLOCK_KEYS = (
    "id", "vertices", "faces", "polygon", "thickness", "depth", "offset", "fixed", "unit_weight", "material",
"friction", )  # fmt: skip
UP = {
    "x": np.array([1.0, 0.0, 0.0]), "y": np.array([0.0, 1.0, 0.0]), "z": np.array([0.0, 0.0, 1.0]),
}  # fmt: skip
PLANES = {
    "y": np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
    "z": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]),
    "x": np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
}
"""directions of a polygon's x and y, and across its plane, by the vertical axis"""


def is_in_space(record: Any) -> bool:
    """Return whether a block file's content needs three dimensions: vertices, `up`, or prisms of their own depth."""
    if not isinstance(record, dict):
        return False
    blocks = record.get("blocks")
    rows = [row for row in blocks if isinstance(row, dict)] if isinstance(blocks, list) else []
    return "up" in record or any({"vertices", "faces", "offset", "thickness", "depth"} & row.keys() for row in rows)


def read_wall(path: Path) -> SpaceWall:
    """Return the wall in the block file `path`, in SI units; its bodies are not checked here (wall.check_wall). Raises
    CaseError naming file, key and remedy."""
    try:
        record = json_in(path, "a JSON block file", LARGEST_FILE, "see docs/space.md for blocks in space")
        return wall_from(record, path.stem)
    except CaseError as error:
        raise error.in_file(str(path)) from None


def wall_from(record: Any, name: str) -> SpaceWall:
    """Return the wall that a block file's content describes. Raises CaseError."""
    if not isinstance(record, dict) or not isinstance(record.get("blocks"), list):
        raise CaseError("blocks", "is missing or not a list", "list the blocks, each with id, vertices and faces")
    refuse_unknown(record, (*TOP_KEYS, *INFORMATION), "")
    for key in ("units", "friction"):
        if key not in record:
            raise CaseError(key, "is missing", "see docs/space.md for blocks in space")
    length, weight = (unit_factor(record["units"], kind) for kind in UNIT_OF)
    vertices_given = any(isinstance(row, dict) and "vertices" in row for row in record["blocks"])
    up = record.get("up", "z" if vertices_given else "y")
    if not isinstance(up, str) or up not in UP:
        raise CaseError("up", f"{up!r} is no axis", 'write "x", "y" or "z", the axis that points upwards')
    name = record.get("name", name)
    refuse_what_is_no_name(name, "name")
    thickness = number_in(record, "thickness", "") * length if "thickness" in record else None
    unit_weight = number_in(record, "unit_weight", "") * weight if "unit_weight" in record else None
    blocks = tuple(
        _block(
            row,
            k,
            unit_weight,
            weight,
            PLANES[up][0],
            lambda row, number: _shape(row, f"block {number}", thickness, up, length),
        )
        for k, row in enumerate(record["blocks"])
    )
    return SpaceWall(name, blocks, number_in(record, "friction", ""), read_only(UP[up]))


def _block(
    row: Any,
    number: int,
    unit_weight: float | None,
    weight: float,
    along: FloatArray,
    shape: Callable[[dict[str, Any], int], Polyhedron],
) -> SpaceBlock:
    own_id, fixed, own, material = what_every_block_has(row, number, BLOCK_KEYS, unit_weight, weight)
    friction = number_in(row, "friction", f"block {own_id}.") if "friction" in row else None
    return SpaceBlock(own_id, shape(row, own_id), fixed, own, material, friction, along if "polygon" in row else None)


def _shape(row: dict[str, Any], key: str, thickness: float | None, up: str, length: float) -> Polyhedron:
    if ("polygon" in row) == ("vertices" in row):
        raise CaseError(key, "needs vertices and faces, or a polygon", "give one of the two")
    if "vertices" in row:
        return _polyhedron(row, key, length)
    own = "depth" if "depth" in row else "thickness"
    depth = number_in(row, own, f"{key}.") * length if own in row else thickness
    if depth is None:
        raise CaseError(f"{key}.thickness", "is missing", "give the block or the whole file a thickness")
    if not depth > 0:
        raise CaseError(f"{key}.thickness", f"{depth:g} is not above 0", "give the depth of the prism")
    polygon = length * polygon_of(row, row["id"])
    offset = number_in(row, "offset", f"{key}.") * length if "offset" in row else 0.0
    axes = PLANES[up]
    return prism(polygon, offset * axes[2], axes * [[1.0], [1.0], [depth]])


def _polyhedron(row: dict[str, Any], key: str, length: float) -> Polyhedron:
    vertices = length * _points(row["vertices"], f"{key}.vertices")
    faces = row.get("faces")
    remedy = "list the corner numbers of every face, from 0, counter-clockwise seen from outside"
    if not isinstance(faces, list) or len(faces) < 4:
        raise CaseError(f"{key}.faces", "is not a list of at least four faces", remedy)
    for number, face in enumerate(faces):
        where = f"{key}.faces[{number}]"
        if not isinstance(face, list) or len(face) < 3 or not all(type(corner) is int for corner in face):
            raise CaseError(where, f"{str(face)[:60]} does not name three corners", remedy)
        for corner in face:
            if not 0 <= corner < len(vertices):
                problem = f"corner {str(corner)[:20]} does not exist, corners are 0 to {len(vertices) - 1}"
                raise CaseError(where, problem, remedy)
    return Polyhedron(read_only(vertices), tuple(tuple(face) for face in faces))


def _points(rows: Any, key: str) -> FloatArray:
    """Return points (n, 3) in the file's unit."""
    try:
        points = np.array(rows)
    except ValueError:
        points = np.zeros(0)
    if points.dtype.kind not in "if" or points.ndim != 2 or points.shape[1] != 3 or len(points) < 4:
        raise CaseError(key, "is not a list of at least 4 points", "write [[x, y, z], ...]")
    if not (np.abs(points) < LARGEST_COORDINATE).all():
        raise CaseError(key, "a coordinate is not a finite number", "give finite coordinates")
    return points.astype(float)
