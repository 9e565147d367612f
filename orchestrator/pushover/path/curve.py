"""The pushover of bodies increment by increment, for use from Python: no communicator, no files, no checks.

    for increment in pushover_increments(make_bodies(assemblage, partition)): ...

Every process works for itself. `push` (pushed.py) takes all loads and checks the curve.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from orchestrator.basis.errors import CaseError
from orchestrator.basis.parallel import this_rank
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.pushover.increments import Increment
from orchestrator.pushover.meshing import BodyMeshes, MeshSettings, mesh_bodies
from orchestrator.pushover.model import build_model
from orchestrator.pushover.path.stepping import Pushover
from orchestrator.pushover.settings import ContactSettings, ElasticSettings, NewtonSettings, SteppingSettings
from orchestrator.pushover.solids.nodal_loads import UPRIGHT_COSINE, own_weight
from orchestrator.pushover.solve.linear_system import LinearSystem


def pushover_increments(
    bodies: Bodies,
    mesh: MeshSettings | BodyMeshes | None = None,
    elastic: ElasticSettings | None = None,
    contact: ContactSettings | None = None,
    newton: NewtonSettings | None = None,
    stepping: SteppingSettings | None = None,
    direction: tuple[float, float] = (1.0, 0.0),
    expected_multiplier: float | None = None,
) -> Iterator[Increment]:
    """Yield the increments: gravity, load control, displacement control, and motion between static states.

    mesh: settings, or meshes of `mesh_bodies`. direction: into which the weight is turned as live load, a vector of any
    length. A body has one density, that of its stones in the mean. expected_multiplier: what limit analysis expects,
    the measure of load increments; without it 0.3 x weight / horizontal load. Raises CaseError for an upright live
    load, ConvergenceError when no further increment converges, CollapseError when a large part of the wall has fallen;
    what was yielded stays valid.
    """
    stepping, alone, size = stepping or SteppingSettings(), this_rank(), float(np.hypot(*direction))
    if not abs(direction[0]) > UPRIGHT_COSINE * size:
        raise CaseError("direction", f"{direction} has no horizontal part", "give the live load one, as (1.0, 0.0)")
    meshes = mesh if isinstance(mesh, BodyMeshes) else mesh_bodies(bodies, mesh or MeshSettings(), None)
    elastic, contact = elastic or ElasticSettings(), contact or ContactSettings()
    loads = own_weight(meshes, np.array(direction) / size)
    model = build_model(bodies, meshes, elastic, contact, stepping.large_displacement, loads)
    with LinearSystem(model, alone) as system:
        expected = expected_multiplier or 0.3 * model.weight / model.horizontal_load
        yield from Pushover(model, system, newton or NewtonSettings(), stepping, expected).increments()
