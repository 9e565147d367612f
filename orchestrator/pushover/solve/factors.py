"""Factors of the condensed matrix: MUMPS on any number of ranks, or without pivoting on one rank, for small systems.

MUMPS looks for pivots and sorts the matrix into its fronts anew each time, which for some thousand unknowns takes
longer than to eliminate them. PETSc's own elimination goes through the nodes in one order (minimum degree, found with
the pattern), three unknowns at a time: a pushover of benchmark 1 with 7,500, 8,300 and 16,700 unknowns takes 0.64, 0.74
and 0.70 of the time with it, one of 512 stones with 31,500 as long, of 1,012 with 63,000 1.08. (One unknown at a time
takes 1.5 times as long as three. With three, rounding reaches a hundred times farther: the penalty is no larger than
that allows.)
Whether a solution is good without pivoting is seen from the exact system (linear_system.py).
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sparse
from mpi4py import MPI
from petsc4py import PETSc

from orchestrator.basis.arrays import FloatArray, IntArray
from orchestrator.basis.errors import ConvergenceError
from orchestrator.pushover.solve.newton_matrix import Pattern

PREFIX = "contact_"
PETSc.Options()[f"{PREFIX}mat_mumps_icntl_7"] = 6
"""MUMPS eliminates in the order of QAMD (minimum degree that knows dense rows, as load and control are): 10 % fewer
operations than with its own choice at 1,012 stones, in half the time. It takes this from PETSc's options only."""


class _OfPetsc:
    """PETSc's matrix, vectors and solver."""

    _matrix: PETSc.Mat
    _right: PETSc.Vec
    _solution: PETSc.Vec
    _solver: PETSc.KSP

    def _solve(self, right: FloatArray) -> FloatArray:
        """Return this rank's part of the solution for its part of the right-hand side. Raises ConvergenceError."""
        self._right.setArray(right)
        try:
            self._solver.solve(self._right, self._solution)
        except PETSc.Error as error:
            raise ConvergenceError("linear solver", f"factorisation failed ({error})") from error
        reason, solution = self._solver.getConvergedReason(), self._solution.getArray()
        if reason < 0:
            raise ConvergenceError("linear solver", f"factorisation failed (PETSc reason {reason})")
        return solution

    def close(self) -> None:
        """Free what PETSc holds."""
        for item in (self._solver, self._matrix, self._right, self._solution):
            item.destroy()


class Mumps(_OfPetsc):
    """LU with threshold pivoting of the rows of a pattern on each rank."""

    def __init__(self, pattern: Pattern, unknowns: int, comm: MPI.Comm) -> None:
        self._comm, self._pattern = comm, pattern
        local = (len(pattern.indptr) - 1, unknowns)
        self._values = np.ones(len(pattern.indices))
        csr = (pattern.indptr, pattern.indices, self._values)
        create = PETSc.Mat().createAIJWithArrays if comm.size == 1 else PETSc.Mat().createAIJ
        self._matrix = create((local, local), csr=csr, comm=comm)
        self._right, self._solution = self._matrix.createVecs()
        self._solver = _direct(self._matrix, "mumps", comm)
        self._solver.getPC().setFactorSetUpSolverType()
        factor = self._solver.getPC().getFactorMatrix()
        factor.setOptionsPrefix(PREFIX)
        factor.setMumpsIcntl(8, 0)  # kappa has scaled the system already; computing more takes a seventh of the time

    def take(self, values: FloatArray) -> None:
        """Take the values of the pattern's entries; they are factorised at the next solution."""
        self._values[:] = values
        if self._comm.size > 1:
            self._matrix.setValuesCSR(self._pattern.indptr, self._pattern.indices, self._values)
        self._matrix.assemble()
        self._matrix.stateIncrease()

    def solve(self, right: FloatArray) -> FloatArray:
        """Return the solution for `right`, both (unknowns,) on every rank. Raises ConvergenceError."""
        own = self._solve(right[slice(*self._right.getOwnershipRange())])
        solution = np.empty(len(right))
        self._comm.Allgatherv(own, (solution, np.diff(self._matrix.getOwnershipRanges())))
        return _finite(solution)

    def solve_each(self, rights: FloatArray) -> FloatArray:
        """Return the solutions for right-hand sides, both (k, unknowns) on every rank: those of few entries take half
        as long as others. Raises ConvergenceError."""
        count, unknowns = len(rights), rights.shape[1]
        centre = self._comm.rank == 0  # where PETSc wants such right-hand sides, all of them
        rows = _sparse(rights if centre else rights[:0])
        size = ((len(rows[0]) - 1, count), (unknowns if centre else 0, unknowns))
        sparsely = PETSc.Mat().createAIJ(size, csr=rows, comm=self._comm)
        right = PETSc.Mat().createTranspose(sparsely)
        own = np.empty((self._right.getLocalSize(), count), order="F")
        found = PETSc.Mat().createDense(((len(own), unknowns), (PETSc.DECIDE, count)), array=own, comm=self._comm)
        try:
            self._solver.getPC().getFactorMatrix().matSolve(right, found)
        except PETSc.Error as error:
            raise ConvergenceError("linear solver", f"no solution by the factors ({error})") from error
        solutions = np.empty((unknowns, count))
        counts = count * np.diff(self._matrix.getOwnershipRanges())
        self._comm.Allgatherv(np.ascontiguousarray(found.getDenseArray()), (solutions, counts))
        for item in (right, sparsely, found):
            item.destroy()
        return _finite(np.ascontiguousarray(solutions.T))

    @property
    def share(self) -> float:
        """Part of the last factorisation's operations that this rank did (RINFO(3) over RINFOG(3) of MUMPS)."""
        factor = self._solver.getPC().getFactorMatrix()
        return float(factor.getMumpsRinfo(3) / factor.getMumpsRinfog(3))


class Unpivoted(_OfPetsc):
    """LU of all rows of a pattern without pivoting but within blocks of three, on one rank."""

    share = 1.0

    def __init__(self, pattern: Pattern) -> None:
        unknowns = len(pattern.indptr) - 1
        order = minimum_degree(pattern)
        number = sparse.csr_matrix((np.arange(1, len(pattern.indices) + 1), pattern.indices, pattern.indptr))
        in_order = sparse.block_diag([number[order][:, order], sparse.diags([-1, -1], dtype=int)]).tobsr((3, 3))
        in_order.sort_indices()
        self._order, self._rows = order, (in_order.indptr, in_order.indices)
        self._entries = in_order.data - 1  # -1: nothing, -2: 1; the last block has two unknowns of no use
        self._blocks = np.ones(in_order.data.shape)
        self._matrix = PETSc.Mat().createBAIJ(in_order.shape, 3, csr=(*self._rows, self._blocks), comm=MPI.COMM_SELF)
        self._right, self._solution = self._matrix.createVecs()
        self._padded = np.zeros(unknowns + 2)
        self._solver = _direct(self._matrix, "petsc", MPI.COMM_SELF)
        self._solver.getPC().setFactorOrdering("natural")

    def take(self, values: FloatArray) -> None:
        """Take the values of the pattern's entries; they are factorised at the next solution."""
        np.take(np.append(values, [1.0, 0.0]), self._entries, out=self._blocks, mode="wrap")
        self._matrix.setValuesBlockedCSR(*self._rows, self._blocks)
        self._matrix.assemble()

    def solve(self, right: FloatArray) -> FloatArray:
        """Return the solution (unknowns,) for `right` (unknowns,). Raises ConvergenceError for a pivot of zero."""
        self._padded[:-2] = right[self._order]
        solution = np.empty(len(right))
        solution[self._order] = self._solve(self._padded)[:-2]
        return _finite(solution)

    def solve_each(self, rights: FloatArray) -> FloatArray:
        """Return the solutions for right-hand sides, both (k, unknowns). Raises ConvergenceError."""
        return np.array([self.solve(right) for right in rights])


def minimum_degree(pattern: Pattern) -> IntArray:
    """Return the order (unknowns,) in which few entries of a pattern's factor fill up: node by node, the load
    multiplier last."""
    count = (len(pattern.indptr) - 1) // 3
    rows = sparse.csr_matrix((np.ones(len(pattern.indices)), pattern.indices, pattern.indptr))
    nodes = rows[: 3 * count : 3, : 3 * count : 3]
    matrix = PETSc.Mat().createAIJ(nodes.shape, csr=(nodes.indptr, nodes.indices, nodes.data), comm=MPI.COMM_SELF)
    order, columns = matrix.getOrdering("qmd")
    found = 3 * order.getIndices().astype(np.int64)[:, None] + np.arange(3)
    for item in (order, columns, matrix):
        item.destroy()
    return np.append(found.ravel(), 3 * count)


def _direct(matrix: PETSc.Mat, package: str, comm: MPI.Comm) -> PETSc.KSP:
    solver = PETSc.KSP().create(comm)
    solver.setOperators(matrix)
    solver.setType("preonly")
    solver.getPC().setType("lu")
    solver.getPC().setFactorSolverType(package)
    return solver


def _sparse(rows: FloatArray) -> tuple[IntArray, IntArray, FloatArray]:
    """Return where rows begin among the entries that are not 0, their columns, and their values."""
    there = np.flatnonzero((rows != 0.0).ravel())
    begins = np.searchsorted(there, rows.shape[1] * np.arange(len(rows) + 1))
    return begins.astype(np.int32), (there % rows.shape[1]).astype(np.int32), rows.ravel()[there]


def _finite(solution: FloatArray) -> FloatArray:
    if not np.isfinite(solution).all():
        raise ConvergenceError("linear solver", "the factors overflow")
    return solution
