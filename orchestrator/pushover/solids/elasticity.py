"""Stiffness and consistent mass of the bodies, assembled by dolfinx.

    a(u, v) = int 2 mu eps(u) : eps(v) + lambda tr eps(u) tr eps(v) dx        stiffness K, N/m
    m(u, v) = int rho u . v dx                                                mass M, kg

on 4-node tetrahedra; all bodies are one mesh of disconnected components. Every rank assembles all of it, in the same
order, so that the matrices do not depend on the ranks (a hundredth of the time of benchmark 1's pushover).

With 10-node tetrahedra the displacement of a middle node is the mean of its edge's ends plus a departure of its own,
and the departures are the additional unknowns (hierarchical basis). Edges on the outline stay straight (no unknown), so
that contact sees plane triangles between corner nodes, whatever the order. Node rows come first, edge rows after them.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import dolfinx
import numpy as np
import scipy.sparse as sparse
import ufl
from dolfinx import fem
from mpi4py import MPI
from petsc4py import PETSc

from orchestrator.basis.arrays import BoolArray, FloatArray, IntArray
from orchestrator.masonry.wall import GRAVITY
from orchestrator.pushover.meshing import BodyMeshes
from orchestrator.pushover.solids.dolfinx_versions import cell_space, matrix_of, mesh_of, rows, vector_space
from orchestrator.pushover.solids.edges import TETRAHEDRON_EDGES, edges_of, on_outline
from orchestrator.pushover.solids.elastic_constants import ElasticConstants

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


@dataclass(frozen=True, eq=False, slots=True)
class Elasticity:
    """K (N/m) and M (kg), both (n, n), n = 3 x (nodes + curved edges); body (n / 3,): of each node and edge."""

    stiffness: sparse.csr_matrix
    mass: sparse.csr_matrix
    body: IntArray


@_quiet_compiler()
def assemble(meshes: BodyMeshes, constants: ElasticConstants, element_order: int) -> Elasticity:
    """Return stiffness and mass in the node order of `meshes`, the same on every rank to the last bit."""
    mesh = mesh_of(MPI.COMM_SELF, meshes.tetrahedra, meshes.nodes)
    space = vector_space(mesh, element_order)
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    first, second = _lame(mesh, meshes, constants)
    strain_u, strain_v = ufl.sym(ufl.grad(u)), ufl.sym(ufl.grad(v))
    stiffness = 2 * second * ufl.inner(strain_u, strain_v) + first * ufl.tr(strain_u) * ufl.tr(strain_v)
    inertia = _of_cells(mesh, meshes, meshes.unit_weight / GRAVITY) * ufl.inner(u, v)
    edges = edges_of(meshes.tetrahedra) if element_order == 2 else np.zeros((0, 2), np.int64)
    numbering = _input_numbering(space, edges, len(meshes.nodes))
    curved = ~on_outline(edges, meshes)
    basis = _hierarchical_basis(edges, curved, len(meshes.nodes))

    def matrix(form: ufl.Form) -> sparse.csr_matrix:
        nodal = _renumbered(form * ufl.dx, numbering)
        return (basis.T @ nodal @ basis).tocsr() if len(edges) else nodal

    body = np.concatenate([meshes.body_of_node, meshes.body_of_node[edges[curved, 0]]])
    return Elasticity(matrix(stiffness), matrix(inertia), body)


def _hierarchical_basis(edges: IntArray, curved: BoolArray, nodes: int) -> sparse.csr_matrix:
    """Return T: displacements of nodes and middle nodes = T (displacements of nodes, departures of curved edges)."""
    middle = nodes + np.arange(len(edges))
    departs = np.flatnonzero(curved)
    row = np.concatenate([np.arange(nodes), np.repeat(middle, 2), middle[departs]])
    column = np.concatenate([np.arange(nodes), edges.ravel(), nodes + np.arange(len(departs))])
    value = np.concatenate([np.ones(nodes), np.full(2 * len(edges), 0.5), np.ones(len(departs))])
    shape = (nodes + len(edges), nodes + len(departs))
    return sparse.kron(sparse.csr_matrix((value, (row, column)), shape), sparse.identity(3), format="csr")


def _lame(mesh: dolfinx.mesh.Mesh, meshes: BodyMeshes, constants: ElasticConstants) -> tuple[Any, Any]:
    """Return lambda and mu: constants where all bodies have the same, else functions that are constant on each cell.

    Plain numbers would be written into the generated code with too few digits, and compiled anew for every modulus.
    """
    moving = len(meshes.unit_weight)
    modulus, ratio = constants.elastic_modulus[:moving], constants.poisson_ratio[:moving]
    first, second = modulus * ratio / ((1 + ratio) * (1 - 2 * ratio)), modulus / (2 * (1 + ratio))
    if np.ptp(modulus) == 0.0 and np.ptp(ratio) == 0.0:
        return fem.Constant(mesh, float(first[0])), fem.Constant(mesh, float(second[0]))
    return _of_cells(mesh, meshes, first), _of_cells(mesh, meshes, second)


def _of_cells(mesh: dolfinx.mesh.Mesh, meshes: BodyMeshes, of_body: FloatArray) -> fem.Function:
    """Return values (bodies,) on each cell."""
    values = fem.Function(cell_space(mesh))
    body = meshes.body_of_tetrahedron[np.array(mesh.topology.original_cell_index)]
    values.x.array[:] = of_body[body]
    return values


def _input_numbering(space: Any, edges: IntArray, nodes: int) -> IntArray:
    """Return the input node, or `nodes` + the edge, of each dof (dofs are not numbered like the input)."""
    mesh = space.mesh
    corners = np.array(mesh.geometry.input_global_indices)[rows(mesh.geometry.dofmap, 4)]
    numbers = corners
    if len(edges):
        pairs = np.sort(corners[:, TETRAHEDRON_EDGES], axis=2)
        place = np.searchsorted(edges @ [nodes, 1], pairs @ [nodes, 1])
        numbers = np.column_stack([corners, nodes + place])
    dof_of_cell = rows(space.dofmap.list, numbers.shape[1])
    number_of_dof = np.zeros(space.dofmap.index_map.size_local, np.int64)
    number_of_dof[dof_of_cell] = numbers
    return number_of_dof


def _renumbered(form: ufl.Form, numbering: IntArray) -> sparse.csr_matrix:
    """Return the assembled matrix, rows and columns in input order."""
    matrix = matrix_of(form)
    indptr, columns, values = matrix.getValuesCSR()
    matrix.destroy()
    dof = (3 * numbering[:, None] + np.arange(3)).ravel()
    row = np.repeat(dof, np.diff(indptr))
    assembled = sparse.csr_matrix((values, (row, dof[columns])), shape=(len(dof), len(dof)))
    assembled.sort_indices()
    return assembled


def gravity_and_lateral_loads(mass: sparse.csr_matrix, nodes: int) -> tuple[FloatArray, FloatArray]:
    """Return forces (n,) in N: own weight, and the weight turned to +x."""
    unit = (np.arange(mass.shape[0] // 3) < nodes).astype(float)  # edges do not depart in a translation
    vertical = np.kron(unit, [0.0, -GRAVITY, 0.0])
    horizontal = np.kron(unit, [GRAVITY, 0.0, 0.0])
    return mass @ vertical, mass @ horizontal
