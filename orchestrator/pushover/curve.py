"""The pushover of bodies as one call, for use from Python: no communicator, no files.

    bodies = make_bodies(assemblage, partition)
    curve = pushover_curve(bodies)                    every setting has the default of the case file
    for increment in pushover_increments(bodies):     the same, increment by increment

Every process works for itself. pushover_run.py does the same for the command line, where all ranks may share one model,
and stores, resumes and checks.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from orchestrator.bodies import Bodies
from orchestrator.errors import CollapseError
from orchestrator.meshing import BodyMeshes, MeshSettings, mesh_bodies
from orchestrator.parallel import this_rank
from orchestrator.pushover.linear_system import LinearSystem
from orchestrator.pushover.model import build_model
from orchestrator.pushover.settings import ContactSettings, ElasticSettings, NewtonSettings, SteppingSettings
from orchestrator.pushover.state import Increment, PushoverCurve
from orchestrator.pushover.stepping import Pushover, end_of_curve


def pushover_increments(
    bodies: Bodies,
    mesh: MeshSettings | BodyMeshes | None = None,
    elastic: ElasticSettings | None = None,
    contact: ContactSettings | None = None,
    newton: NewtonSettings | None = None,
    stepping: SteppingSettings | None = None,
    direction: int = 1,
    expected_multiplier: float | None = None,
) -> Iterator[Increment]:
    """Yield the increments: gravity, load control, displacement control, and motion between static states.

    mesh: settings, or meshes of `mesh_bodies`. direction: load along +x (1) or -x (-1). A body has one density, that of
    its stones in the mean. expected_multiplier: what limit analysis expects, the measure of load increments; without it
    0.3 x weight / horizontal load. Raises ConvergenceError when no further increment converges, CollapseError when a
    large part of the wall has fallen; what was yielded stays valid.
    """
    stepping, alone = stepping or SteppingSettings(), this_rank()
    meshes = mesh if isinstance(mesh, BodyMeshes) else mesh_bodies(bodies, mesh or MeshSettings(), None)
    elastic, contact = elastic or ElasticSettings(), contact or ContactSettings()
    model = build_model(bodies, meshes, elastic, contact, direction, alone, stepping.large_displacement)
    with LinearSystem(model, alone) as system:
        expected = expected_multiplier or 0.3 * model.weight / model.horizontal_load
        yield from Pushover(model, system, newton or NewtonSettings(), stepping, expected).increments()


def pushover_curve(
    bodies: Bodies,
    mesh: MeshSettings | BodyMeshes | None = None,
    elastic: ElasticSettings | None = None,
    contact: ContactSettings | None = None,
    newton: NewtonSettings | None = None,
    stepping: SteppingSettings | None = None,
    direction: int = 1,
    expected_multiplier: float | None = None,
) -> PushoverCurve:
    """Return the pushover curve of the bodies up to stepping.final_displacement, or to the fall of a body.

    Arguments as in `pushover_increments`. Raises ConvergenceError when the solver gives up before the curve ends:
    `pushover_increments` has yielded what came until then.
    """
    stepping = stepping or SteppingSettings()
    ends: list[str | None] = []

    def until_it_ends() -> Iterator[Increment]:
        try:
            for increment in pushover_increments(
                bodies, mesh, elastic, contact, newton, stepping, direction, expected_multiplier
            ):
                ends.append(end_of_curve(increment, stepping))
                yield increment
        except CollapseError as error:
            ends.append(str(error))

    curve = PushoverCurve.from_increments(until_it_ends(), "")
    return replace(curve, stopped_because=str(ends[-1]))
