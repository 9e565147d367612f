"""COMPAS JSON -> SpaceWall: assemblies (compas_assembly, compas_cra) and block models (compas_dem).

    assembly      data.graph.data.node.{k}: {block: {data: {vertex, face}}, is_support}
    block model   data.elements.{guid}.data: {geometry: {data: {vertex, face}}, is_support, transformation}

Neither states a unit of length: it must be given. Coordinates have z upwards.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.basis.arrays import FloatArray, read_only
from orchestrator.basis.errors import CaseError
from orchestrator.geometry.polyhedra import Polyhedron
from orchestrator.masonry.sources.block_files import LARGEST_FILE, json_in
from orchestrator.space.sources.material import SpaceMaterial, oriented
from orchestrator.space.wall import UPRIGHT, SpaceBlock, SpaceWall

KINDS = ("Assembly", "CRA_Assembly", "BlockModel")


def is_compas(record: Any) -> bool:
    """Return whether a JSON file's content is one of the two layouts."""
    return isinstance(record, dict) and str(record.get("dtype", "")).rpartition("/")[2] in KINDS


def read_compas(path: Path, length: float, material: SpaceMaterial) -> SpaceWall:
    """Return the wall in a COMPAS JSON file whose unit of length is `length` (m). Raises CaseError."""
    record = json_in(path, "a COMPAS JSON file", LARGEST_FILE, "export it again from COMPAS")
    try:
        data = record["data"]
        rows = _elements(data["elements"]) if "elements" in data else _nodes(data["graph"]["data"]["node"])
        if not rows:
            raise CaseError("", "holds no blocks", "export the assembly with its blocks")
        blocks = tuple(_block(number, row, length, material) for number, row in enumerate(rows, 1))
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise CaseError("", f"is not a COMPAS assembly or block model ({error!r:.60})", "export it again") from None
    return SpaceWall(path.stem, blocks, material.friction, read_only(UPRIGHT))


def _nodes(nodes: dict[str, Any]) -> list[dict[str, Any]]:
    rows = [
        (node["block"]["data"], bool(node.get("is_support")), None) for _, node in sorted(nodes.items(), key=_order)
    ]
    return [{"mesh": mesh, "fixed": fixed, "turn": turn} for mesh, fixed, turn in rows]


def _order(item: tuple[str, Any]) -> tuple[int, str]:
    return (int(item[0]), "") if item[0].isdigit() else (10**9, item[0])


def _elements(elements: dict[str, Any]) -> list[dict[str, Any]]:
    return [
        {
            "mesh": element["data"]["geometry"]["data"],
            "fixed": bool(element["data"].get("is_support")),
            "turn": element["data"].get("transformation"),
        }
        for element in elements.values()
    ]


def _block(number: int, row: dict[str, Any], length: float, material: SpaceMaterial) -> SpaceBlock:
    """Return one block; COMPAS numbers corners as it likes, so they are numbered anew."""
    keys = list(row["mesh"]["vertex"])
    place = {str(key): k for k, key in enumerate(keys)}
    corners = np.array([[row["mesh"]["vertex"][key][axis] for axis in "xyz"] for key in keys], dtype=float)
    if row["turn"]:
        corners = _transformed(corners, row["turn"])
    faces = tuple(tuple(place[str(corner)] for corner in face) for face in row["mesh"]["face"].values())
    body = oriented(Polyhedron(read_only(length * corners), faces))
    return SpaceBlock(number, body, row["fixed"], material.unit_weight)


def _transformed(corners: FloatArray, transformation: dict[str, Any]) -> FloatArray:
    matrix = np.array(transformation["data"]["matrix"], dtype=float)
    return corners @ matrix[:3, :3].T + matrix[:3, 3]
