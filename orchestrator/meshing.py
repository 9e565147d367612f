"""Tetrahedral meshes of the moving bodies: outlines extruded over the thickness, joint ends imprinted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt

from orchestrator.masonry.wall import FloatArray, IntArray
from orchestrator.units import Unit


@dataclass(frozen=True, slots=True)
class MeshSettings:
    """Element size in the wall's plane and number of element layers through the thickness."""

    size: Annotated[float, Unit("m"), Gt(0)] = 0.2
    layers: Annotated[int, Ge(1)] = 1


@dataclass(frozen=True, eq=False, slots=True)
class BodyMeshes:
    """One mesh of disconnected components: no node is shared by two bodies.

    nodes (m, 3) in m, x and y in the wall's plane, z from 0 to the thickness; tetrahedra (t, 4), positively oriented;
    body_of_node (m,), body_of_tetrahedron (t,); nodes and tetrahedra of a body are contiguous, bodies in order.
    side_triangles (f, 3): boundary triangles on the extruded outline, outward orientation (right-hand rule);
    body_of_side (f,). unit_weight (bodies,) in N/m3 of the moving bodies.
    distinct_shapes: how many different meshes were generated.
    """

    nodes: FloatArray
    tetrahedra: IntArray
    body_of_node: IntArray
    body_of_tetrahedron: IntArray
    side_triangles: IntArray
    body_of_side: IntArray
    unit_weight: FloatArray
    distinct_shapes: int
    seconds: float
