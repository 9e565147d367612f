"""The chain from a wall to its FE increments, as tests need it: one call, all settings visible."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from mpi4py import MPI

from orchestrator.loads import LoadSettings
from orchestrator.macroblocks.bodies import Bodies, make_bodies
from orchestrator.macroblocks.criteria import Partition, one_body_per_block
from orchestrator.masonry.joints import Assemblage, JointClass, JointSettings, find_joints
from orchestrator.masonry.ties import Tie
from orchestrator.masonry.wall import Block, Wall
from orchestrator.pushover.increments import Increment, PushoverCurve
from orchestrator.pushover.meshing import MeshSettings, mesh_bodies
from orchestrator.pushover.model import ContactModel, build_model
from orchestrator.pushover.path.increment_record import at_rest, in_front, increment_of, of_all_nodes
from orchestrator.pushover.path.stepping import Pushover
from orchestrator.pushover.settings import ContactSettings, ElasticSettings, NewtonSettings, SteppingSettings
from orchestrator.pushover.solids.nodal_loads import nodal_loads, own_weight
from orchestrator.pushover.solids.tie_bars import find_ties
from orchestrator.pushover.solve.iterate import Target, evaluate
from orchestrator.pushover.solve.linear_system import LinearSystem
from orchestrator.pushover.solve.newton import solve_increment
from orchestrator.storage import Effort, effort_of
from tests.support.walls import rectangle


@dataclass(frozen=True)
class Run:
    """A model and every increment it went through."""

    model: ContactModel
    increments: list[Increment]

    @property
    def curve(self) -> PushoverCurve:
        return PushoverCurve.from_increments(self.increments, "final displacement")

    @property
    def peak(self) -> float:
        """Largest base shear of the static rows / horizontal part of the live load."""
        return float(self.curve.static.base_shear_N.max()) / self.model.horizontal_load

    @property
    def effort(self) -> Effort:
        return effort_of(self.increments, self.model.body_names, self.model.body_mass)

    @property
    def under_gravity(self) -> Increment:
        return [i for i in self.increments if i.phase == "gravity"][-1]


def stack(*sizes: tuple[float, float], friction: float) -> Wall:
    """Blocks (width, height) one on the other, centred on x = 0, on a wide support."""
    blocks = [Block(0, rectangle(-2.0, -0.2, 4.0, 0.2), True, 25e3)]
    level = 0.0
    for number, (width, height) in enumerate(sizes, start=1):
        blocks.append(Block(number, rectangle(-width / 2, level, width, height), False, 25e3))
        level += height
    return Wall("stack", tuple(blocks), 0.1, friction)


def assemblage_of(wall: Wall, *classes: JointClass) -> Assemblage:
    return find_joints(wall, JointSettings(classes=classes))


def bodies_of(wall: Wall, *classes: JointClass) -> Bodies:
    """Every stone a body."""
    assemblage = assemblage_of(wall, *classes)
    return make_bodies(assemblage, one_body_per_block(assemblage))


def model_of(
    wall: Wall,
    partition: Partition | None = None,
    mesh_size: float | None = None,
    direction: int = 1,
    slip_tolerance: float | None = None,
    large_displacement: bool = False,
    loads: LoadSettings | None = None,
    joints: JointClass | None = None,
    softening: float = 2e-4,
    elastic: ElasticSettings | None = None,
    ties: tuple[Tie, ...] = (),
    halves: bool = True,
) -> ContactModel:
    assemblage = assemblage_of(wall, *([joints] if joints else []))
    bodies = make_bodies(assemblage, partition or one_body_per_block(assemblage))
    meshes = mesh_bodies(bodies, MeshSettings(size=mesh_size), None)
    given = own_weight(meshes, np.array([direction, 0.0]))
    if loads:
        given = nodal_loads(wall, bodies, meshes, replace(loads, direction="+x" if direction > 0 else "-x"))
    contact = ContactSettings(slip_tolerance, softening)
    elastic = elastic or ElasticSettings()
    bars = find_ties(wall, bodies, meshes, ties)
    return build_model(bodies, meshes, elastic, contact, large_displacement, given, bars, halves)


def run(
    model: ContactModel, final_displacement: float | None = None, comm: MPI.Comm = MPI.COMM_SELF, **stepping: float
) -> Run:
    settings = SteppingSettings(final_displacement=final_displacement, **stepping)
    with LinearSystem(model, comm) as system:
        return Run(model, list(Pushover(model, system, NewtonSettings(), settings).increments()))


def moved_to(model: ContactModel, displacements: list[float], state: Increment | None = None) -> list[Increment]:
    """Prescribe the mean displacement (m) step by step, forth or back, under the full weight (small displacements)."""
    state = in_front(model, state) if state else at_rest(model)
    path = [state]
    with LinearSystem(model, MPI.COMM_SELF) as system:
        for displacement in displacements:
            start = state.displacement.ravel()
            gap, mortar = state.gap, model.mortar and model.mortar.at(model.rows, state.closing, state.normal_force)
            gap = mortar.opened(gap, state.normal_force) if mortar else gap
            bond = model.bond and model.bond.at(model.rows, state.damage, state.slip, gap)
            problem = Target(1.0, start, state.elastic_slip, 1.0, displacement, bond=bond, mortar=mortar)
            if state.number == 0:
                problem = replace(problem, reference_force=model.weight / len(model.contacts))
            first = evaluate(model, problem, start, state.normal_force, state.load_multiplier)
            iterate = solve_increment(model, system, problem, first, NewtonSettings(iterations=50))
            state = increment_of(model, state, problem, iterate, "displacement", 1.0, SteppingSettings().out_of_balance)
            path.append(state)
    return [of_all_nodes(model, state) for state in path]
