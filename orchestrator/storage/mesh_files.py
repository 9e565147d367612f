"""Meshes of a pushover as files of other programs (meshio)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from orchestrator.basis.atomic_files import replacing
from orchestrator.pushover.meshing import BodyMeshes


def write_mesh(meshes: BodyMeshes, path: Path, suffix: str = "") -> None:
    """Write the mesh in the format of the suffix (.msh is gmsh 4.1, .vtu, .xdmf), body number as cell data; suffix: of
    another one than the path's."""
    import meshio

    mesh = meshio.Mesh(
        meshes.nodes, [("tetra", meshes.tetrahedra)], cell_data={"body": [meshes.body_of_tetrahedron.astype(np.int32)]}
    )
    suffix = suffix or path.suffix
    if suffix == ".xdmf":  # writes a second file, named after the first
        mesh.write(path)
        return
    options = {".msh": {"file_format": "gmsh", "binary": True}}.get(suffix, {"file_format": suffix[1:]})
    with replacing(path) as temporary:
        mesh.write(temporary, **options)
