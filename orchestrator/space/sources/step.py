"""STEP, BREP and IGES -> SpaceWall, through gmsh's OpenCASCADE: one volume is one block.

STEP and IGES state their unit of length, BREP has none. Plane faces keep their corners; curved ones become strips and
triangles.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from orchestrator.basis.arrays import read_only
from orchestrator.basis.errors import CaseError
from orchestrator.basis.installed import refuse_missing
from orchestrator.space.sources.material import SpaceMaterial, oriented
from orchestrator.space.sources.meshes import bodies_in
from orchestrator.space.wall import UPRIGHT, SpaceBlock, SpaceWall

WITH_UNIT = (".step", ".stp", ".iges", ".igs")
"""files that state their unit of length"""
SUFFIXES = (*WITH_UNIT, ".brep")
CURVED = 24
"""elements on a full turn of a curved face"""


def read_step(path: Path, length: float | None, material: SpaceMaterial) -> SpaceWall:
    """Return the wall in a STEP, BREP or IGES file; `length` (m) is the unit of BREP, None for the others.

    Raises CaseError."""
    if length is not None and path.suffix.lower() in WITH_UNIT:
        raise CaseError("--unit", f"{path.suffix} files state their unit of length", "leave it out")
    if length is None and path.suffix.lower() not in WITH_UNIT:
        raise CaseError("--unit", "the file has no unit of length", "give it, as in --unit mm")
    refuse_missing(f"import of {path.suffix} files", ("gmsh",))
    import gmsh

    blocks: list[SpaceBlock] = []
    with _session():
        gmsh.option.setString("Geometry.OCCTargetUnit", "M")
        try:
            gmsh.model.occ.importShapes(str(path))
            gmsh.model.occ.synchronize()
            size = _largest_size()
            gmsh.option.setNumber("Mesh.MeshSizeMax", size)
            gmsh.option.setNumber("Mesh.MeshSizeMin", 0.0)
            gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
            gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", CURVED)
            gmsh.model.mesh.generate(2)
        except Exception as error:  # gmsh raises nothing more special
            raise CaseError("", f"cannot be read ({str(error)[:80]})", "export it again as STEP") from None
        for _, volume in gmsh.model.getEntities(3):
            faces = []
            for _, surface in gmsh.model.getBoundary([(3, volume)], oriented=True):
                _, _, nodes = gmsh.model.mesh.getElements(2, abs(surface))
                triangles = np.concatenate([np.asarray(n) for n in nodes]).reshape(-1, 3).astype(int)
                faces += [tuple(row) if surface > 0 else tuple(row[::-1]) for row in triangles.tolist()]
            tags, points, _ = gmsh.model.mesh.getNodes()
            place = {int(tag): k for k, tag in enumerate(tags)}
            corners = points.reshape(-1, 3) * (length or 1.0)
            numbered = [tuple(place[k] for k in face) for face in faces]
            for body in bodies_in(corners, numbered):
                blocks.append(SpaceBlock(len(blocks) + 1, oriented(body), False, material.unit_weight))
    if not blocks:
        raise CaseError("", "holds no volumes", "export solids, one a block")
    return SpaceWall(path.stem, tuple(blocks), material.friction, read_only(UPRIGHT))


def _largest_size() -> float:
    """Return a size above every edge, so that a plane face gets no corners but its own."""
    import gmsh

    low_high = np.array(gmsh.model.getBoundingBox(-1, -1))
    return 10.0 * float(np.linalg.norm(low_high[3:] - low_high[:3]))


@contextmanager
def _session() -> Iterator[None]:
    import gmsh

    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    try:
        yield
    finally:
        gmsh.finalize()
