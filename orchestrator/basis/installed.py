"""What is not needed by every command: whether it is installed, and what to install where it is not.

Finite elements (dolfinx with PETSc, and MPI) and the mesh generator are imported where they are used. `check`, `limit`,
`segment`, `import` and `report` need none of them.
"""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

from orchestrator.basis.errors import CaseError

FINITE_ELEMENTS = ("dolfinx", "petsc4py", "mpi4py", "gmsh")
REMEDY = {
    "dolfinx": "dolfinx with real numbers",
    "petsc4py": "petsc4py",
    "mpi4py": "mpi4py",
    "gmsh": "gmsh (pip install gmsh)",
}


def refuse_missing(purpose: str, modules: tuple[str, ...] = FINITE_ELEMENTS) -> None:
    """Raise CaseError naming what `purpose` needs and this Python cannot import."""
    missing = [module for module in modules if not _is_there(module)]
    if not missing:
        _refuse_second_hdf5(purpose, modules)
        return
    remedy = f"install {', '.join(REMEDY[module] for module in missing)}"
    if set(missing) - {"gmsh"}:
        remedy += ": `make setup` does so on Debian and Ubuntu 26.04, environment.yml with conda; "
        remedy += "check, limit and segment work without"
    raise CaseError("", f"{purpose} needs {', '.join(missing)}, not installed here", remedy, "orchestrator")


def _is_there(module: str) -> bool:
    try:
        return find_spec(module) is not None
    except (ImportError, ValueError):  # something on the way refuses it
        return False


def _refuse_second_hdf5(purpose: str, modules: tuple[str, ...]) -> None:
    """Raise CaseError where dolfinx would meet the HDF5 in h5py's own wheel: whichever comes second breaks."""
    h5py = find_spec("h5py")
    if "dolfinx" in modules and h5py and h5py.origin and (Path(h5py.origin).parents[1] / "h5py.libs").is_dir():
        problem = f"{purpose} needs an h5py of the HDF5 that dolfinx has, and PyPI's brings one of its own"
        remedy = "pip uninstall h5py, and install Debian's python3-h5py, or conda's"
        raise CaseError("", problem, remedy, "orchestrator")
