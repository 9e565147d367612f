"""Stiffness and consistent mass of the bodies, assembled by dolfinx.

    a(u, v) = int 2 mu eps(u) : eps(v) + lambda tr eps(u) tr eps(v) dx        stiffness K, N/m
    m(u, v) = int rho u . v dx                                                mass M, kg

on 4-node tetrahedra; all bodies are one mesh of disconnected components, each body owned by one rank.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager

import dolfinx
import numpy as np
import scipy.sparse as sparse
import ufl
from dolfinx import cpp, fem
from mpi4py import MPI
from petsc4py import PETSc

from orchestrator.masonry.wall import GRAVITY, FloatArray, IntArray
from orchestrator.meshing import BodyMeshes
from orchestrator.pushover.settings import ElasticSettings

assert PETSc.ScalarType is np.float64, "this program needs PETSc built for real numbers (python3-dolfinx-real)"


@contextmanager
def _quiet_compiler() -> Iterator[None]:
    """Keep the form compiler's command lines off the terminal (the first run on a machine compiles)."""
    before = logging.root.manager.disable
    logging.disable(logging.INFO)
    try:
        yield
    finally:
        logging.disable(before)


@_quiet_compiler()
def assemble(
    meshes: BodyMeshes, elastic: ElasticSettings, comm: MPI.Comm
) -> tuple[sparse.csr_matrix, sparse.csr_matrix]:
    """Return K (N/m) and M (kg), both (3 nodes, 3 nodes) in the node order of `meshes`, the same on every rank."""
    mesh = _distributed_mesh(meshes, comm)
    space = fem.VectorFunctionSpace(mesh, ("Lagrange", 1))
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    first, second = _lame(elastic)
    strain_u, strain_v = ufl.sym(ufl.grad(u)), ufl.sym(ufl.grad(v))
    stiffness = 2 * second * ufl.inner(strain_u, strain_v) + first * ufl.tr(strain_u) * ufl.tr(strain_v)
    inertia = _density(mesh, meshes) * ufl.inner(u, v)
    numbering = _input_numbering(space)
    return _gathered(fem.form(stiffness * ufl.dx), numbering, comm), _gathered(
        fem.form(inertia * ufl.dx), numbering, comm
    )


def _lame(elastic: ElasticSettings) -> tuple[float, float]:
    modulus, ratio = elastic.elastic_modulus, elastic.poisson_ratio
    return modulus * ratio / ((1 + ratio) * (1 - 2 * ratio)), modulus / (2 * (1 + ratio))


def _distributed_mesh(meshes: BodyMeshes, comm: MPI.Comm) -> dolfinx.mesh.Mesh:
    """Hand the mesh over from rank 0; no body is cut: bodies go to ranks in contiguous groups of equal size."""
    cells, nodes = meshes.tetrahedra, meshes.nodes
    rank_of_cell = _rank_of_body(meshes.body_of_tetrahedron, comm.size)[meshes.body_of_tetrahedron]
    if comm.rank > 0:
        cells, nodes, rank_of_cell = cells[:0], nodes[:0], rank_of_cell[:0]

    def by_body(*_: object) -> cpp.graph.AdjacencyList_int32:
        return cpp.graph.AdjacencyList_int32(rank_of_cell.astype(np.int32).reshape(-1, 1))

    domain = ufl.Mesh(ufl.VectorElement("Lagrange", ufl.tetrahedron, 1))
    return dolfinx.mesh.create_mesh(comm, cells, nodes, domain, partitioner=by_body)


def _rank_of_body(body_of_tetrahedron: IntArray, ranks: int) -> IntArray:
    elements = np.bincount(body_of_tetrahedron)
    before = np.cumsum(elements) - elements
    return before * ranks // len(body_of_tetrahedron)


def _density(mesh: dolfinx.mesh.Mesh, meshes: BodyMeshes) -> fem.Function:
    """Return the density (kg/m3) of each cell. Rank 0 handed over all cells, so original numbers are the input's."""
    density = fem.Function(fem.FunctionSpace(mesh, ("DG", 0)))
    body = meshes.body_of_tetrahedron[np.array(mesh.topology.original_cell_index)]
    density.x.array[:] = meshes.unit_weight[body] / GRAVITY
    return density


def _input_numbering(space: fem.FunctionSpace) -> IntArray:
    """Return the input node of each node owned or ghosted here (P1 dofs are not numbered like geometry nodes)."""
    mesh = space.mesh
    dof_of_cell = space.dofmap.list.array.reshape(-1, 4)
    geometry_of_cell = mesh.geometry.dofmap.array.reshape(-1, 4)
    node_of_dof = np.zeros(space.dofmap.index_map.size_local + space.dofmap.index_map.num_ghosts, np.int64)
    node_of_dof[dof_of_cell] = np.array(mesh.geometry.input_global_indices)[geometry_of_cell]
    return node_of_dof[: space.dofmap.index_map.size_local]


def _gathered(form: fem.FormMetaClass, numbering: IntArray, comm: MPI.Comm) -> sparse.csr_matrix:
    """Return the assembled matrix on every rank, rows and columns in input order."""
    matrix = fem.petsc.assemble_matrix(form)
    matrix.assemble()
    indptr, columns, values = matrix.getValuesCSR()
    matrix.destroy()
    node = np.concatenate(comm.allgather(numbering))
    dof = (3 * node[:, None] + np.arange(3)).ravel()
    rows = np.repeat(np.arange(len(indptr) - 1), np.diff(indptr))
    local_dof = (3 * numbering[:, None] + np.arange(3)).ravel()
    parts = comm.allgather((local_dof[rows], dof[columns], values))
    row, column, value = (np.concatenate([part[k] for part in parts]) for k in range(3))
    assembled = sparse.csr_matrix((value, (row, column)), shape=(len(dof), len(dof)))
    assembled.sort_indices()
    return assembled


def gravity_and_lateral_loads(mass: sparse.csr_matrix, direction: int) -> tuple[FloatArray, FloatArray]:
    """Return nodal forces (3 nodes,) in N: own weight, and the weight turned to +x or -x (load multiplier 1)."""
    unit = np.ones(mass.shape[0] // 3)
    vertical = np.kron(unit, [0.0, -GRAVITY, 0.0])
    horizontal = np.kron(unit, [direction * GRAVITY, 0.0, 0.0])
    return mass @ vertical, mass @ horizontal
