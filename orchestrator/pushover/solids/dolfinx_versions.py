"""What dolfinx calls differently from version to version (0.5 to 0.10), for elasticity.py alone.

0.7 replaced the classes of function spaces by `functionspace`, UFL's elements by basix's, and adjacency lists by plain
arrays; 0.8 renamed the element of `create_mesh`, and 0.10 moves its place, which keywords do not mind.
"""

from __future__ import annotations

import inspect
from typing import Any

import dolfinx
import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI
from petsc4py import PETSc

from orchestrator.basis.arrays import FloatArray, IntArray

PETSc.Options()["options_left"] = "no"  # since 3.19 PETSc ends by listing options of solvers that a run had no use for
SINCE_0_7 = hasattr(fem, "functionspace")
if SINCE_0_7:
    import basix.ufl
    import dolfinx.fem.petsc


def vector_space(mesh: dolfinx.mesh.Mesh, order: int) -> Any:
    """Return the space of displacements in space, continuous and of `order` on each tetrahedron."""
    if SINCE_0_7:
        return fem.functionspace(mesh, ("Lagrange", order, (3,)))
    return fem.VectorFunctionSpace(mesh, ("Lagrange", order))


def cell_space(mesh: dolfinx.mesh.Mesh) -> Any:
    """Return the space of functions that are constant on each cell."""
    return (fem.functionspace if SINCE_0_7 else fem.FunctionSpace)(mesh, ("DG", 0))


def mesh_of(comm: MPI.Comm, cells: IntArray, nodes: FloatArray) -> dolfinx.mesh.Mesh:
    """Return the mesh of straight tetrahedra: cells (t, 4), nodes (m, 3) in m."""
    element = (
        basix.ufl.element("Lagrange", "tetrahedron", 1, shape=(3,))
        if SINCE_0_7
        else ufl.VectorElement("Lagrange", ufl.tetrahedron, 1)
    )
    name = "e" if "e" in inspect.signature(dolfinx.mesh.create_mesh).parameters else "domain"
    return dolfinx.mesh.create_mesh(comm, cells=cells, x=nodes, **{name: ufl.Mesh(element)})


def rows(adjacency: Any, columns: int) -> IntArray:
    """Return (cells, columns): the numbers that a dof map holds of each cell."""
    return np.asarray(getattr(adjacency, "array", adjacency)).reshape(-1, columns)


def matrix_of(form: ufl.Form) -> PETSc.Mat:
    """Return the assembled matrix of a bilinear form; the caller destroys it."""
    matrix = fem.petsc.assemble_matrix(fem.form(form))
    matrix.assemble()
    return matrix
