"""geometry.h5: what pictures need of a pushover model (mesh, contact places), so that they can be drawn again later.

The file is followed by its sha256, as states.h5 is, and read only if it matches.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from orchestrator.basis.arrays import IntArray, read_only
from orchestrator.basis.atomic_files import replacing, require_seal, seal
from orchestrator.basis.errors import CaseError
from orchestrator.pushover.meshing import BodyMeshes
from orchestrator.storage.files import missing
from orchestrator.storage.hdf5 import hdf5_file
from orchestrator.storage.stored_increments import IN_MEMORY, StateStore

GEOMETRY_FILE = "geometry.h5"


@dataclass(frozen=True, eq=False, slots=True)
class ContactPlaces:
    """The c contacts that touch in the undeformed wall; they are the first c of every array of an Increment.

    slave_node (c,): the node of the mesh that each is; interface (c,): number as in Bodies.
    """

    slave_node: IntArray
    interface: IntArray


def write_geometry(store: StateStore, meshes: BodyMeshes, contacts: ContactPlaces) -> None:
    """Write geometry.h5 into the model's folder."""
    with replacing(store.folder / GEOMETRY_FILE) as temporary:
        with hdf5_file(temporary, "w") as file:
            file.attrs["fingerprint"] = store.fingerprint
            for group, value in (("meshes", meshes), ("contacts", contacts)):
                for field in fields(value):
                    file[f"{group}/{field.name}"] = getattr(value, field.name)
        seal(temporary)


def read_geometry(folder: Path) -> tuple[StateStore, BodyMeshes, ContactPlaces]:
    """Return the stored increments of a model's folder, its meshes and its contacts. Raises CaseError."""
    path = folder / GEOMETRY_FILE
    if not path.exists():
        raise missing(path)
    try:
        require_seal(path)
        with hdf5_file(path, "r") as file:
            store = StateStore(folder, str(file.attrs["fingerprint"]), IN_MEMORY)
            meshes = {field.name: file[f"meshes/{field.name}"][()] for field in fields(BodyMeshes)}
            contacts = {field.name: file[f"contacts/{field.name}"][()] for field in fields(ContactPlaces)}
    except (OSError, KeyError, ValueError) as error:
        problem = "cannot be read (damaged, or written by another version)"
        raise CaseError(
            "", problem, "delete it and `run` the case with --resume, or run the case anew", str(path)
        ) from error
    return store, _mesh_of(meshes), ContactPlaces(**{n: read_only(v, v.dtype) for n, v in contacts.items()})


def _mesh_of(values: dict[str, Any]) -> BodyMeshes:
    arrays: dict[str, Any] = {name: read_only(value, value.dtype) for name, value in values.items() if value.ndim}
    return BodyMeshes(**arrays, distinct_shapes=int(values["distinct_shapes"]), seconds=float(values["seconds"]))
