"""Loads beyond the bodies' own mass, as forces on the nodes of their meshes (numpy and shapely only).

A load is spread evenly over its stone's volume, or over the edges of the stone that face upwards, as equal or weighted
point loads. Each goes to the corners of the tetrahedron that holds its point, by barycentric weights, so that resultant
and moment are those of limit analysis whatever the mesh; on the outline that is the traction on the surface nodes.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos

import numpy as np
import shapely

from orchestrator.basis.arrays import FloatArray, IntArray, read_only
from orchestrator.basis.errors import CaseError
from orchestrator.loads.block_loads import LoadSettings, live_loads
from orchestrator.loads.dead_loads import PlacedLoads, extra_dead_loads, over_volume
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.masonry.block_properties import block_areas, block_centroids, block_weights
from orchestrator.masonry.wall import Wall
from orchestrator.pushover.meshing import BodyMeshes

POINTS_ON_EDGE = 8
"""at which a line load acts on a stretch of an edge"""
POINTS_THROUGH_THICKNESS = 4
"""levels of z at which it acts"""
IN_TRIANGLE = np.array([[4.0, 1.0, 1.0], [1.0, 4.0, 1.0], [1.0, 1.0, 4.0]]) / 6.0
"""barycentric weights of three points of equal weight, exact for polynomials of degree 2"""
WEIGHT_ROUNDING = 1e-9
"""part of a stone's weight by which it may differ from its part of its body's before that is a load of its own"""
UPRIGHT_COSINE = 1e-6
"""a live load with a horizontal part below this one has no base shear to report"""


@dataclass(frozen=True, eq=False, slots=True)
class NodalLoads:
    """Forces in N on m nodes. dead (m,): downwards, besides the weight. live (m,): along the live load's direction at a
    load multiplier of 1, besides that of the bodies' own mass, which acts where `of_mass`. direction (2,): unit vector
    of the live load."""

    dead: FloatArray
    live: FloatArray
    of_mass: bool
    direction: FloatArray

    @property
    def sideways(self) -> float:
        """Horizontal part of a live load of 1."""
        return abs(float(self.direction[0]))


def own_weight(meshes: BodyMeshes, direction: FloatArray) -> NodalLoads:
    """Return the bodies' own weight as the only load, and the same turned into `direction` (2,) as the live load."""
    nothing = read_only(np.zeros(len(meshes.nodes)))
    return NodalLoads(nothing, nothing, True, read_only(direction))


def nodal_loads(wall: Wall, bodies: Bodies, meshes: BodyMeshes, settings: LoadSettings) -> NodalLoads:
    """Return the loads of a case on the nodes of its bodies. Raises CaseError (key only)."""
    refuse_upright(settings)
    live = live_loads(wall, settings)
    if settings.distribution == "mass":  # the free blocks' own masses come first, and the mass matrix has them
        own = sum(not block.fixed for block in wall.blocks)
        live = live.part(slice(own, None))
    uneven = _spread(departures_from_mean(wall, bodies), wall, bodies, meshes)
    with_mass = settings.distribution == "mass"
    return NodalLoads(
        dead=read_only(uneven + _spread(extra_dead_loads(wall, settings.dead), wall, bodies, meshes)),
        live=read_only(with_mass * uneven + _spread(live, wall, bodies, meshes)),
        of_mass=settings.distribution == "mass",
        direction=read_only(settings.vector),
    )


def departures_from_mean(wall: Wall, bodies: Bodies) -> PlacedLoads:
    """Return what stones weigh more (or less) than their part of a body whose mass matrix has one density: their sum is
    zero in each body, and brings its weight to the centroid of its stones."""
    even, weight, centroid = np.zeros(len(wall.blocks)), block_weights(wall), block_centroids(wall)
    for body in bodies.bodies:
        even[body.blocks] = body.unit_weight * bodies.thickness
    departure = weight - even * block_areas(wall)
    fixed = np.array([block.fixed for block in wall.blocks])
    block = np.flatnonzero(~fixed & (np.abs(departure) > WEIGHT_ROUNDING * weight))
    return over_volume(block, centroid[block], departure[block])


def refuse_upright(settings: LoadSettings) -> None:
    """Raise CaseError (key only) for a live load that pushes nowhere."""
    if cos(settings.inclination) < UPRIGHT_COSINE:
        raise CaseError("load.inclination", "an upright live load has no base shear", "use the command limit")


def _spread(loads: PlacedLoads, wall: Wall, bodies: Bodies, meshes: BodyMeshes) -> FloatArray:
    """Return the size (m,) of the loads on each node, N."""
    body_of_block = {int(block): body.number for body in bodies.bodies for block in body.blocks}
    total = np.zeros(len(meshes.nodes))
    for number, (block, size) in enumerate(zip(loads.block.tolist(), loads.size.tolist(), strict=True)):
        place, share = _points_of(loads, number, wall.blocks[block].polygon)
        points, part = through_thickness(place, share, bodies.thickness)
        element, weight = held_by(points, meshes, body_of_block[block])
        force = size * part
        np.add.at(total, element, force[:, None] * weight)
    return total


def through_thickness(place: FloatArray, share: FloatArray, thickness: float) -> tuple[FloatArray, FloatArray]:
    """Return points (4 p, 3) in m on levels through the thickness (m) for places (p, 2), and their shares (4 p,)."""
    levels = (np.arange(POINTS_THROUGH_THICKNESS) + 0.5) / POINTS_THROUGH_THICKNESS * thickness
    points = np.column_stack([np.repeat(place, len(levels), axis=0), np.tile(levels, len(place))])
    return points, np.repeat(share, len(levels)) / len(levels)


def _points_of(loads: PlacedLoads, number: int, polygon: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return points (p, 2) that stand for one load on its block, and their shares (p,) of it."""
    if loads.spread[number] == "point":
        return loads.point[number : number + 1], np.ones(1)
    return _points_on_top(loads.edges[number]) if loads.spread[number] == "top" else _points_within(polygon)


def _points_within(polygon: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return points (p, 2) in a polygon and their shares (p,) of its area, with its centroid."""
    triangles = shapely.constrained_delaunay_triangles(shapely.Polygon(polygon)).geoms
    corners = np.array([np.array(triangle.exterior.coords)[:3] for triangle in triangles])
    area = np.array([triangle.area for triangle in triangles])
    return (IN_TRIANGLE @ corners).reshape(-1, 2), np.repeat(area / area.sum(), 3) / 3


def _points_on_top(edges: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return points (p, 2) on edges (e, 2, 2) and their shares (p,) of the horizontal projection."""
    start, end = edges.transpose(1, 0, 2)
    width = start[:, 0] - end[:, 0]
    place = ((np.arange(POINTS_ON_EDGE) + 0.5) / POINTS_ON_EDGE)[None, :, None]
    points = start[:, None] + place * (end - start)[:, None]
    return points.reshape(-1, 2), np.repeat(width / width.sum(), POINTS_ON_EDGE) / POINTS_ON_EDGE


def held_by(points: FloatArray, meshes: BodyMeshes, body: int) -> tuple[IntArray, FloatArray]:
    """Return the corners (p, 4) of the tetrahedron of a body that holds each point (p, 3), and barycentric weights."""
    elements = meshes.tetrahedra[meshes.body_of_tetrahedron == body]
    corners = meshes.nodes[elements]
    edges = np.linalg.inv((corners[:, 1:] - corners[:, :1]).transpose(0, 2, 1))
    last = np.einsum("tij,ptj->pti", edges, points[:, None] - corners[:, 0])
    weights = np.concatenate([1.0 - last.sum(axis=2, keepdims=True), last], axis=2)
    best = weights.min(axis=2).argmax(axis=1)
    return elements[best], weights[np.arange(len(points)), best]
