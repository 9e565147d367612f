"""What N2 needs of a pushover: its control displacement, the shape it has, and the masses that move. SI units.

All from stored states, so that a verification needs no finite elements; of static ones, as the curve that is
idealised. What has fallen is no part of the wall: not of its shape, masses and load, nor the fastest of it. Masses are
those of linear tetrahedra (the departures of curved edges of quadratic elements are left out: a wall's mass is the
same, its shape to the square of their strain), and every mass that the live load acts on: floors with `inertia` as
well as stones.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from scipy import sparse

from orchestrator.assessment.capacity import SECANT
from orchestrator.assessment.seismic.control import ControlPoint
from orchestrator.assessment.seismic.drift import DriftingPier, Drifts, drift_weights
from orchestrator.assessment.seismic.n2 import EquivalentSystem, equivalent_system
from orchestrator.basis.arrays import FloatArray, IntArray
from orchestrator.basis.errors import ResultError
from orchestrator.loads import DeadLoad, LoadSettings
from orchestrator.loads.block_loads import horizontal
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.masonry.wall import GRAVITY, Wall
from orchestrator.pushover.increments import Increment, PushoverCurve
from orchestrator.pushover.meshing import BodyMeshes
from orchestrator.pushover.solids.elastic_constants import ElasticConstants
from orchestrator.pushover.solids.nodal_loads import nodal_loads
from orchestrator.pushover.stress import element_stress
from orchestrator.pushover.stress_jumps import excess_stiffness


@dataclass(frozen=True, eq=False, slots=True)
class StoredPushover:
    """One stored pushover. curve: its static rows; `read` returns an increment by its number; interface (c,): those of
    the contacts that touch at the start. elastic: constants of its bodies, None with 10-node tetrahedra. refused: why
    it may not be verified, or ""."""

    name: str
    bodies: Bodies
    meshes: BodyMeshes
    interface: IntArray
    slip_tolerance: float
    elastic: ElasticConstants | None
    curve: PushoverCurve
    read: Callable[[int], Increment]
    refused: str

    @property
    def fallen(self) -> frozenset[int]:
        """Positions of the blocks that have fallen by the end of the curve."""
        bodies = np.flatnonzero(self.read(int(self.curve.step[-1])).fallen)
        return frozenset(int(block) for body in bodies for block in self.bodies.bodies[body].blocks)


@dataclass(frozen=True, eq=False, slots=True)
class Observed:
    """displacement (s,) in m of the control point along the load since gravity, row by row of the curve; the system
    with the shape at SECANT of the peak; slip_share: part of the displacement there that the slip tolerance makes;
    too_stiff: about the part of the bodies' stiffness there that is their elements' (stress_jumps.py);
    share_of_fastest: motion of the control point over that of the fastest node that stands, at the end; drifts of its
    piers."""

    displacement: FloatArray
    system: EquivalentSystem
    slip_share: float
    too_stiff: float
    share_of_fastest: float
    drifts: Drifts = field(default_factory=lambda: Drifts((), np.zeros((0, 0))))


def observe(
    pushover: StoredPushover, wall: Wall, load: LoadSettings, point: ControlPoint, piers: tuple[DriftingPier, ...]
) -> Observed:
    """Return what a pushover says of one control point and of piers. Raises ResultError for a point that does not go
    with the load."""
    meshes, bodies, curve = pushover.meshes, pushover.bodies, pushover.curve
    forward, weights = horizontal(load.vector), point_weights(wall, bodies, meshes, point)
    gravity = pushover.read(int(curve.step[0]))
    of_piers = drift_weights(wall, bodies, meshes, piers)
    displacement, drift = np.zeros(len(curve.step)), np.zeros((len(curve.step), len(piers)))
    for row, number in enumerate(curve.step):
        moved = _moved(pushover.read(int(number)), gravity, len(meshes.nodes))[:, :2] @ forward
        displacement[row], drift[row] = weights @ moved, np.abs(of_piers @ moved)
    if displacement[elastic_row(curve)] <= 0.0:
        raise ResultError("control point", f"{point.name} does not move along the load: name another control point")
    elastic = pushover.read(int(curve.step[elastic_row(curve)]))
    stands = standing_nodes(elastic, bodies, meshes)
    mass, force = masses_and_load(wall, bodies, meshes, load)
    mass, force = sparse.diags(stands) @ mass, stands * force
    along = _moved(elastic, gravity, len(meshes.nodes))[:, :2] @ forward
    shape = along / float(displacement[elastic_row(curve)])
    end = pushover.read(int(curve.step[-1]))
    last = _moved(end, gravity, len(meshes.nodes)) * standing_nodes(end, bodies, meshes)[:, None]
    return Observed(
        displacement=displacement,
        system=equivalent_system(mass, shape, force, np.ones(len(shape))),
        slip_share=slip_share(pushover, gravity, elastic, float(elastic.load_multiplier * (force @ along))),
        too_stiff=too_stiff(pushover, gravity, elastic),
        share_of_fastest=float(abs(displacement[-1]) / np.linalg.norm(last[:, :2], axis=1).max()),
        drifts=Drifts(piers, drift),
    )


def standing_nodes(state: Increment, bodies: Bodies, meshes: BodyMeshes) -> FloatArray:
    """Return (m,): 1 for nodes of bodies that have not fallen in a state, 0 for the others."""
    supports = np.zeros(len(bodies.bodies) - bodies.moving, bool)
    return np.where(np.append(state.fallen, supports)[meshes.body_of_node], 0.0, 1.0)


def elastic_row(curve: PushoverCurve) -> int:
    """Return the row whose shape the equivalent system has: the first at SECANT of the peak, as the bilinear."""
    above = int(np.argmax(curve.base_shear_N >= SECANT * curve.base_shear_N.max()))
    return max(above, 1)  # row 0 has not moved


def point_weights(wall: Wall, bodies: Bodies, meshes: BodyMeshes, point: ControlPoint) -> FloatArray:
    """Return weights (m,) of the nodes whose sum is 1: the mean over the blocks' tops is where a load of 1 N/m acts."""
    ids = tuple(wall.blocks[position].id for position in point.blocks)
    with_load = LoadSettings(dead=(DeadLoad(blocks=ids, line_load=1.0),))
    weights = nodal_loads(wall, bodies, meshes, with_load).dead - nodal_loads(wall, bodies, meshes, LoadSettings()).dead
    return weights / weights.sum()


def masses_and_load(
    wall: Wall, bodies: Bodies, meshes: BodyMeshes, load: LoadSettings
) -> tuple[sparse.csr_matrix, FloatArray]:
    """Return the mass matrix (m, m) in kg of everything the live load acts on, and its horizontal load (m,) in N."""
    stones = nodal_mass(meshes)
    of_mass = replace(load, distribution="mass", inclination=0.0, live=())
    extra = nodal_loads(wall, bodies, meshes, of_mass).live / GRAVITY
    nodal = nodal_loads(wall, bodies, meshes, load)
    own = GRAVITY * np.asarray(stones.sum(axis=1)).ravel() if nodal.of_mass else 0.0
    return (stones + sparse.diags(extra)).tocsr(), nodal.sideways * (nodal.live + own)


def nodal_mass(meshes: BodyMeshes) -> sparse.csr_matrix:
    """Return the consistent mass matrix (m, m) in kg of linear tetrahedra: rho V / 20, twice that on the diagonal."""
    corners = meshes.nodes[meshes.tetrahedra]
    volume = np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6.0
    mass = volume * meshes.unit_weight[meshes.body_of_tetrahedron] / GRAVITY
    values = mass[:, None, None] / 20.0 * (np.ones((4, 4)) + np.eye(4))
    rows = np.broadcast_to(meshes.tetrahedra[:, :, None], values.shape)
    columns = np.broadcast_to(meshes.tetrahedra[:, None, :], values.shape)
    size = len(meshes.nodes)
    return sparse.coo_matrix((values.ravel(), (rows.ravel(), columns.ravel())), (size, size)).tocsr()


def slip_share(pushover: StoredPushover, gravity: Increment, elastic: Increment, work: float) -> float:
    """Return the part of the displacement at SECANT of the peak that is elastic slip of the contact law's tolerance.

    By virtual work of the state on itself: friction times elastic slip since gravity over `work`, load times
    displacement in J.
    """
    count = len(pushover.interface)
    rigid = np.isinf(pushover.bodies.interfaces.shear_stiffness)  # what mortar slips by is no numerical artefact
    friction = np.where(rigid, pushover.bodies.interfaces.friction, 0.0)[pushover.interface][:, None]

    def force(state: Increment) -> FloatArray:
        normal = np.maximum(state.normal_force[:count], 0.0)[:, None]
        return np.asarray(friction * normal * state.elastic_slip[:count] / pushover.slip_tolerance)

    slipped = np.nan_to_num(elastic.elastic_slip[:count] - gravity.elastic_slip[:count])
    done = float(np.sum((force(elastic) - force(gravity)) * slipped))
    return min(max(done / work, 0.0), 1.0) if work > 0.0 else 0.0


def too_stiff(pushover: StoredPushover, gravity: Increment, elastic: Increment) -> float:
    """Return about how much too stiff 4-node tetrahedra make bodies, as a part of their stiffness, by their stresses
    since gravity; 0 where that is not asked."""
    if pushover.elastic is None:
        return 0.0
    meshes, constants = pushover.meshes, pushover.elastic
    then, now = (element_stress(meshes, constants, state.displacement, True) for state in (gravity, elastic))
    return excess_stiffness(meshes, constants, now - then)


def _moved(state: Increment, gravity: Increment, nodes: int) -> FloatArray:
    """Return the displacement (m, 3) in m of the nodes since gravity, without those of curved edges."""
    return np.asarray(state.displacement[:nodes] - gravity.displacement[:nodes])
