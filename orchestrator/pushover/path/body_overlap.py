"""Displaced outlines alone: how deep bodies overlap, and how far those that press each other are apart.

Checks on contacts that know nothing of where these are: of forces only that they act between two bodies.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import shapely

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray
from orchestrator.geometry.penetration import penetrations
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.pushover.meshing import BodyMeshes

PRESSES = 0.01
"""share of the lighter body's weight from which the force between two bodies counts: ten times what a static body may
be out of balance"""


@dataclass(frozen=True, slots=True)
class Misfit:
    """The worst that two bodies do: distance in m, over the size of the smaller one (the root of its area), the names
    of the two, and where (m). Where other bodies are farther apart or deeper in m, that is the distance."""

    distance: float = 0.0
    share: float = 0.0
    names: tuple[str, str] = ("", "")
    place: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, eq=False)
class DisplacedOutlines:
    """Bodies and their meshes, whose outlines are compared once they are displaced."""

    bodies: Bodies
    meshes: BodyMeshes

    def largest_overlap(self, displacement: FloatArray, fallen: BoolArray, closed: float = 0.0) -> Misfit:
        """Return the deepest overlap of two bodies displaced by `displacement` (>= m, 3) in m (`penetrations`).

        Bodies that are `fallen` (b,) do not count, nor does the depth (m) by which mortar has `closed`.
        """
        standing = np.flatnonzero(np.append(~fallen, np.ones(len(self.bodies.bodies) - self.bodies.moving, bool)))
        shapes = self._displaced(displacement)[standing]
        farthest = float(np.abs(self.meshes.nodes).max())
        found = penetrations(shapes, standing < self.bodies.moving, farthest)
        depth = np.maximum(found.depth - closed, 0.0)
        return self._worst(depth, standing[found.pair], shapely.area(shapes)[found.pair], found.place)

    def largest_pressed_gap(
        self,
        displacement: FloatArray,
        fallen: BoolArray,
        pairs: tuple[IntArray, IntArray],
        normal_force: FloatArray,
        weight: FloatArray,
    ) -> Misfit:
        """Return the largest distance of two bodies that press each other, displaced by `displacement` (>= m, 3) in m.

        pairs (c,), (c,): the bodies of contacts with normal_force (c,) in N; what they press by together counts from
        `PRESSES` of the lighter body's weight (b,) in N, and what pulls (a bond) does not. Bodies that are `fallen`
        (b,) do not count.
        """
        supports = len(self.bodies.bodies) - self.bodies.moving
        weights = np.append(weight, np.full(supports, np.inf))
        gone = np.append(fallen, np.zeros(supports, bool))
        both, contact = np.unique(np.sort(np.column_stack(pairs), axis=1), axis=0, return_inverse=True)
        force = np.bincount(contact.ravel(), np.maximum(normal_force, 0.0), len(both))
        both = both[(force > PRESSES * weights[both].min(axis=1)) & ~gone[both].any(axis=1)]
        shapes = self._displaced(displacement)
        ways = shapely.shortest_line(*shapes[both].T)
        middles = shapely.get_coordinates(shapely.line_interpolate_point(ways, 0.5, normalized=True))
        return self._worst(shapely.length(ways), both, shapely.area(shapes)[both], middles)

    def _worst(self, distance: FloatArray, pair: IntArray, areas: FloatArray, place: FloatArray) -> Misfit:
        """Return the worst of distances (p,) in m between bodies (p, 2) with areas (p, 2) in m2; place (p, 2) in m."""
        if not len(distance):
            return Misfit()
        share = distance / np.sqrt(areas.min(axis=1))
        worst = int(share.argmax())
        one, other = (self.bodies.bodies[body].name for body in pair[worst])
        x, y = (place[worst] + self._origin).tolist()
        return Misfit(float(distance.max()), float(share[worst]), (one, other), (x, y))

    @property
    def _origin(self) -> FloatArray:
        """A node of the wall (2,) in m, about which outlines are compared."""
        return self.meshes.nodes[0, :2]

    @cached_property
    def _rings(self) -> tuple[IntArray, IntArray, IntArray]:
        """The rings of moving bodies at z = 0, each outline before its holes: nodes (k,), which ring (k,) each is of,
        and which body (r,) each ring is of."""
        nodes, sides = self.meshes.nodes, self.meshes.side_triangles
        front = nodes[:, 2] <= 1e-9 * float(np.ptp(nodes[:, 2]))
        edges = np.vstack([sides[:, list(pair)] for pair in pairwise((0, 1, 2, 0))])
        body, drawn = np.tile(self.meshes.body_of_side, 3), front[edges].all(axis=1)
        numbered = np.column_stack([nodes[:, :2], np.arange(len(nodes))])
        faces = [_face(numbered[edges[drawn & (body == number)]]) for number in range(self.bodies.moving)]
        rings, of_body = shapely.get_rings(faces, return_index=True)
        corners, ring = shapely.get_coordinates(rings, include_z=True, return_index=True)
        return corners[:, 2].astype(np.int64), ring, of_body

    def _displaced(self, displacement: FloatArray) -> npt.NDArray[np.object_]:
        """Return the outlines of all bodies displaced by `displacement` (>= m, 3) in m, about the origin."""
        node, ring, body = self._rings
        place = self.meshes.nodes[node, :2] - self._origin + displacement[node, :2]
        moving = shapely.make_valid(shapely.polygons(shapely.linearrings(place, indices=ring), indices=body))
        supports = [shapely.Polygon(body.exterior - self._origin) for body in self.bodies.bodies[self.bodies.moving :]]
        return np.array([*moving, *supports], dtype=object)


def _face(edges: FloatArray) -> shapely.Geometry:
    """Return a body's face, holes included, from its edges (e, 2, 3): x and y in m and the number of the node. Around a
    hole the ring of the hole encloses a face, too: that of the body is the one that reaches farther."""
    parts = shapely.get_parts(shapely.polygonize([*shapely.linestrings(edges)]))
    return max(parts, key=lambda part: shapely.area(shapely.envelope(part)))
