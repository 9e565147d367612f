"""Block files (JSON) in space -> SpaceWall.

    {"units": {"length": "m", "unit_weight": "kN/m3"}, "up": "z", "unit_weight": 20.0, "friction": 0.6,
     "blocks": [{"id": 1, "vertices": [[x, y, z], ...], "faces": [[0, 1, 2, 3], ...], "fixed": false}, ...]}

Faces run counter-clockwise seen from outside. A block may be given as `polygon` with `thickness` and `offset` instead:
a prism across the plane of the polygon, whose y points up. A plane wall's file is read as prisms of its thickness.
`up` names the vertical axis; left out it is z where a block has vertices and y for plane walls.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.errors import CaseError
from orchestrator.masonry.readers import (
    INFORMATION,
    LARGEST_COORDINATE,
    LARGEST_FILE,
    json_in,
    refuse_what_is_not_utf8,
)
from orchestrator.masonry.wall import FloatArray, read_only
from orchestrator.space.polyhedra import Polyhedron, prism
from orchestrator.space.wall import SpaceBlock, SpaceWall
from orchestrator.units import Unit

TOP_KEYS = ("units", "up", "thickness", "unit_weight", "friction", "blocks", "mortar")
BLOCK_KEYS = (
    "id", "vertices", "faces", "polygon", "thickness", "depth", "offset", "fixed", "unit_weight", "material",
"friction", )  # fmt: skip
UNITS = {"length": Unit("m"), "unit_weight": Unit("N/m3")}
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
    _refuse_unknown(record, (*TOP_KEYS, *INFORMATION), "")
    for key in ("units", "unit_weight", "friction"):
        if key not in record:
            raise CaseError(key, "is missing", "see docs/space.md for blocks in space")
    length, weight = (_factor(record["units"], kind) for kind in UNITS)
    vertices_given = any(isinstance(row, dict) and "vertices" in row for row in record["blocks"])
    up = record.get("up", "z" if vertices_given else "y")
    if up not in UP:
        raise CaseError("up", f"{up!r} is no axis", 'write "x", "y" or "z", the axis that points upwards')
    name = str(record.get("name", name))
    refuse_what_is_not_utf8(name, "name")
    defaults = {
        "thickness": _number(record, "thickness", "") * length if "thickness" in record else None,
        "unit_weight": _number(record, "unit_weight", "") * weight,
    }
    blocks = tuple(_block(row, k, defaults, up, length, weight) for k, row in enumerate(record["blocks"]))
    return SpaceWall(name, blocks, _number(record, "friction", ""), read_only(UP[up]))


def _block(
    row: Any, number: int, defaults: dict[str, float | None], up: str, length: float, weight: float
) -> SpaceBlock:
    if not isinstance(row, dict) or type(row.get("id")) is not int:
        raise CaseError(f"blocks[{number}].id", "is missing or not a whole number", "give every block its own id")
    key = f"block {row['id']}"
    _refuse_unknown(row, BLOCK_KEYS, f"{key}.")
    fixed, material = row.get("fixed", False), row.get("material", "")
    if not isinstance(fixed, bool):
        raise CaseError(f"{key}.fixed", f"{fixed!r} is neither true nor false", "write true for supports")
    if not isinstance(material, str):
        raise CaseError(f"{key}.material", f"{material!r} is not a name", 'write a text, in "quotes"')
    own = _number(row, "unit_weight", f"{key}.") * weight if "unit_weight" in row else defaults["unit_weight"]
    assert own is not None
    return SpaceBlock(
        row["id"],
        _shape(row, key, defaults["thickness"], up, length),
        fixed,
        own,
        material,
        _number(row, "friction", f"{key}.") if "friction" in row else None,
    )


def _shape(row: dict[str, Any], key: str, thickness: float | None, up: str, length: float) -> Polyhedron:
    if ("polygon" in row) == ("vertices" in row):
        raise CaseError(key, "needs vertices and faces, or a polygon", "give one of the two")
    if "vertices" in row:
        return _polyhedron(row, key, length)
    own = "depth" if "depth" in row else "thickness"
    depth = _number(row, own, f"{key}.") * length if own in row else thickness
    if depth is None:
        raise CaseError(f"{key}.thickness", "is missing", "give the block or the whole file a thickness")
    if not depth > 0:
        raise CaseError(f"{key}.thickness", f"{depth:g} is not above 0", "give the depth of the prism")
    polygon = length * _points(row["polygon"], 2, f"{key}.polygon")
    offset = _number(row, "offset", f"{key}.") * length if "offset" in row else 0.0
    axes = PLANES[up]
    return prism(_counter_clockwise(polygon), offset * axes[2], axes * [[1.0], [1.0], [depth]])


def _counter_clockwise(polygon: FloatArray) -> FloatArray:
    """Return a polygon (n, 2) counter-clockwise, without corners that the next one repeats."""
    side = np.abs(polygon - np.roll(polygon, -1, axis=0)).max(axis=1)
    polygon = polygon[side > 1e-12 * side.max()]
    x, y = polygon.T
    return polygon if np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) > 0 else polygon[::-1]


def _polyhedron(row: dict[str, Any], key: str, length: float) -> Polyhedron:
    vertices = length * _points(row["vertices"], 3, f"{key}.vertices")
    faces = row.get("faces")
    remedy = "list the corner numbers of every face, from 0, counter-clockwise seen from outside"
    if not isinstance(faces, list) or len(faces) < 4:
        raise CaseError(f"{key}.faces", "is not a list of at least four faces", remedy)
    for number, face in enumerate(faces):
        good = (
            isinstance(face, list) and len(face) >= 3 and all(type(k) is int and 0 <= k < len(vertices) for k in face)
        )
        if not good:
            raise CaseError(f"{key}.faces[{number}]", f"{str(face)[:60]} does not name three corners", remedy)
    return Polyhedron(read_only(vertices), tuple(tuple(face) for face in faces))


def _points(rows: Any, width: int, key: str) -> FloatArray:
    """Return points (n, 2) or (n, 3) in the file's unit."""
    try:
        points = np.array(rows)
    except ValueError:
        points = np.zeros(0)
    least = width + 1
    if points.dtype.kind not in "if" or points.ndim != 2 or points.shape[1] != width or len(points) < least:
        example = "[[x, y], [x, y], [x, y]]" if width == 2 else "[[x, y, z], ...]"
        raise CaseError(key, f"is not a list of at least {least} points", f"write {example}")
    if not (np.abs(points) < LARGEST_COORDINATE).all():
        raise CaseError(key, "a coordinate is not a finite number", "give finite coordinates")
    return points.astype(float)


def _factor(units: Any, kind: str) -> float:
    if not isinstance(units, dict) or kind not in units:
        raise CaseError(f"units.{kind}", "is missing", f'state the unit, as in "{kind}": "{UNITS[kind].symbol}"')
    _refuse_unknown(units, tuple(UNITS), "units.")
    try:
        return UNITS[kind].factor(str(units[kind]))
    except ValueError as error:
        problem, _, remedy = str(error).partition("; ")
        raise CaseError(f"units.{kind}", problem, remedy) from None


def _number(record: dict[str, Any], key: str, place: str) -> float:
    value = record[key]
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 1e300:
        raise CaseError(place + key, f"{value!r} is not a number", "write a number in the file's units")
    return float(value)


def _refuse_unknown(record: dict[str, Any], known: tuple[str, ...], place: str) -> None:
    for key in record:
        if key not in known:
            raise CaseError(place + str(key)[:40], "is not a known key", f"use {', '.join(known)}")
