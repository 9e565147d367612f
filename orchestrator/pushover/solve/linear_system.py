"""The linear system of a Newton iteration, solved on all ranks: MUMPS on the condensed matrix, iterative refinement.

newton_matrix.py says what the matrix is, and the condensed one that is factorised in its place; MUMPS analyses its
pattern once. With the residual r of the exact system

    solve the condensed system for r, expand, add to x, r = right - (Newton matrix) x

leaves about 1 / penalty of the error each time. The residual is formed in extended precision (np.longdouble), because
in double precision the penalty's rounding is larger than what stiff stones (E x 100) leave of it. The solution is then
exact to the rounding of its largest entry. Smaller entries, forces among them, still differ by 1e-12 from one number of
ranks to another; Newton's iterations part where contacts close and slide in turn more than about ten times.

N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., SIAM 2002, chapter 12.
"""

from __future__ import annotations

from dataclasses import replace
from time import perf_counter

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.errors import ConvergenceError
from orchestrator.basis.parallel import refuse_disagreement
from orchestrator.pushover.model import ContactModel
from orchestrator.pushover.solve.newton_matrix import (
    Coefficients,
    Pattern,
    condensed_right,
    connect_alike,
    expanded,
    make_pattern,
    product,
    values,
    with_values_of,
)

SOLUTION_ERROR = 1e-15
"""error of the solution, as expected from the last two refinements, at which they end"""
SLOW = 0.5
"""a refinement by more than this share of the one before brings nothing any more"""
ROUNDS = 8
"""refinements at most"""
USELESS = 1e-6
"""where refinements do not end, a residual larger than this share of the right-hand side is a failure"""


PREFIX = "contact_"
PETSc.Options()[f"{PREFIX}mat_mumps_icntl_7"] = 6
"""MUMPS eliminates in the order of QAMD (minimum degree that knows dense rows, as load and control are): 10 % fewer
operations than with its own choice at 1,012 stones, in half the time. It takes this from PETSc's options only."""


class LinearSystem:
    """MUMPS on the constant pattern; use as a context manager. The same solution is returned on every rank."""

    def __init__(self, model: ContactModel, comm: MPI.Comm) -> None:
        self._comm = comm.Dup()
        self.seconds = 0.0
        """time spent in `solve` so far"""
        self.together = 0.0
        """seconds in what all ranks do together, waiting included: MUMPS and the exchange around it"""
        self._model, self._exact = model, _extended(model)
        self._pattern = self._open()

    def follow(self, model: ContactModel) -> None:
        """Take the values of another state of the model; a new pattern only where its contacts connect other nodes."""
        if model is self._model:
            return
        self._exact = _extended(model)
        if connect_alike(model, self._model):
            self._pattern, self._model = with_values_of(self._pattern, model), model
        else:
            self._close()
            self._model = model
            self._pattern = self._open()

    def _open(self) -> Pattern:
        """Return the pattern of the model as it is, and make PETSc's matrix, vectors and solver for it."""
        count, ranks = len(self._model.body), self._comm.size
        first, last = (count * rank // ranks for rank in (self._comm.rank, self._comm.rank + 1))
        pattern = make_pattern(self._model, first, last)
        local = (len(pattern.indptr) - 1, 3 * count + 1)
        self._values = np.ones(len(pattern.indices))
        csr = (pattern.indptr, pattern.indices, self._values)
        create = PETSc.Mat().createAIJWithArrays if ranks == 1 else PETSc.Mat().createAIJ
        self._matrix = create((local, local), csr=csr, comm=self._comm)
        self._right, self._solution = self._matrix.createVecs()
        self._solver = PETSc.KSP().create(self._comm)
        self._solver.setOperators(self._matrix)
        self._solver.setType("preonly")
        preconditioner = self._solver.getPC()
        preconditioner.setType("lu")
        preconditioner.setFactorSolverType("mumps")
        preconditioner.setFactorSetUpSolverType()
        factor = preconditioner.getFactorMatrix()
        factor.setOptionsPrefix(PREFIX)
        factor.setMumpsIcntl(8, 0)  # kappa has scaled the system already; computing more takes a seventh of the time
        return pattern

    def _close(self) -> None:
        for item in (self._solver, self._matrix, self._right, self._solution):
            item.destroy()

    def __enter__(self) -> LinearSystem:
        return self

    def __exit__(self, failure: type[BaseException] | None, *_: object) -> None:
        if failure is None or self._comm.size == 1:  # a rank that fails may be alone: no collective call then
            self._close()
            self._comm.Free()

    def solve(self, contact: Coefficients, time_step: float, right: FloatArray) -> FloatArray:
        """Return the solution (unknowns,) for `right` (unknowns,). Raises ConvergenceError if MUMPS fails."""
        began = perf_counter()
        if self._comm.size > 1:
            before = perf_counter()
            refuse_disagreement(self._comm, np.append(right, time_step).tobytes(), "the increment to be solved")
            self.together += perf_counter() - before
        pattern, model = self._pattern, self._model
        self._values[:] = values(pattern, model, contact, time_step)
        if self._comm.size > 1:
            self._matrix.setValuesCSR(pattern.indptr, pattern.indices, self._values)
        self._matrix.assemble()
        self._matrix.stateIncrease()
        solution, size = np.zeros_like(right), float(np.linalg.norm(right))
        residual, before = right, 1.0 / SLOW**2  # of the first refinement, which is all of the solution
        for _ in range(ROUNDS):
            change = expanded(model, contact, residual, self._condensed(condensed_right(model, contact, residual)))
            refined = solution + change
            share = float(np.linalg.norm(change)) / max(float(np.linalg.norm(refined)), 1e-300)
            if not share < SLOW * before:
                break
            solution = refined
            if share**2 / before <= SOLUTION_ERROR:
                residual = np.zeros_like(right)
                break
            exact = product(self._exact, contact, time_step, refined.astype(np.longdouble))
            residual, before = (right - exact).astype(float), share
        left = float(np.linalg.norm(residual))
        self.seconds += perf_counter() - began
        if not left <= USELESS * size:
            raise ConvergenceError("linear solver", f"refinement ends at {left:.0e} of {size:.0e}")
        return solution

    @property
    def share(self) -> float:
        """Part of the last factorisation's operations that this rank did (RINFO(3) over RINFOG(3) of MUMPS)."""
        factor = self._solver.getPC().getFactorMatrix()
        return float(factor.getMumpsRinfo(3) / factor.getMumpsRinfog(3))

    def _condensed(self, right: FloatArray) -> FloatArray:
        """Return the solution (n + 1,) of the factorised matrix on every rank."""
        began = perf_counter()
        self._right.setArray(right[slice(*self._right.getOwnershipRange())])
        try:
            self._solver.solve(self._right, self._solution)
        except PETSc.Error as error:
            raise ConvergenceError("linear solver", f"MUMPS failed ({error})") from error
        reason = self._solver.getConvergedReason()
        solution = np.empty(len(right))
        self._comm.Allgatherv(self._solution.getArray(), (solution, np.diff(self._matrix.getOwnershipRanges())))
        self.together += perf_counter() - began
        if reason < 0 or not np.isfinite(solution).all():
            raise ConvergenceError("linear solver", f"MUMPS failed (PETSc reason {reason})")
        return solution


def _extended(model: ContactModel) -> ContactModel:
    """Return the model with the matrices of product() in extended precision."""
    return replace(
        model,
        stiffness=model.stiffness.astype(np.longdouble),
        mass=model.mass.astype(np.longdouble),
        normal_rows=model.normal_rows.astype(np.longdouble),
        tangential_rows=model.tangential_rows.astype(np.longdouble),
    )
