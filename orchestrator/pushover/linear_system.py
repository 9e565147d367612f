"""The Newton system of one increment: constant sparsity pattern, values linear in the contacts' coefficients.

Unknowns (du, dlambda / kappa, dalpha), kappa = contact stiffness, which brings all entries to one magnitude:

    [ K + M/dt^2 + B_t^T T B_t   kappa (-B_n^T + B_t^T S)   -f_h ]
    [ kappa B_n (active)         kappa I (inactive)           0  ]    inactive and bonded: T'(gap) B_n and kappa I
    [ mean row (displacement) | 0    0       0 | 1 (prescribed)  ]

T (2, 2) = d tau / d slip and S (2,) = d tau / d lambda of each contact. Every value is therefore

    data = K + M/dt^2 + scatter @ coefficients

with one sparse matrix `scatter`; MUMPS analyses the pattern once (explicit zeros are kept). A wall that moves keeps
its pattern, with new values of K and `scatter`, until a contact comes, goes, or meets another triangle.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np
import numpy.typing as npt
import scipy.sparse as sparse
from mpi4py import MPI
from petsc4py import PETSc

from orchestrator.errors import ConvergenceError
from orchestrator.masonry.wall import FloatArray, IntArray
from orchestrator.parallel import refuse_disagreement
from orchestrator.pushover.contact_law import FrictionResponse
from orchestrator.pushover.model import ContactModel


@dataclass(frozen=True, eq=False, slots=True)
class Pattern:
    """CSR pattern (indptr, indices) with the constant values of K and M in it, and `scatter` (nonzeros, coefficients).

    Coefficients in order: T (4 c), S (2 c), gap (c), active (c), displacement control (1), one (1). slot: place in
    the pattern of each entry that `_entries` lists, then of each entry of K.
    """

    indptr: IntArray
    indices: IntArray
    stiffness: FloatArray
    mass: FloatArray
    scatter: sparse.csr_matrix
    slot: IntArray


def coefficients(
    response: FrictionResponse,
    active: npt.NDArray[np.bool_],
    carrying: npt.NDArray[np.bool_],
    pull_slope: FloatArray,
    displacement_control: bool,
) -> FloatArray:
    """Return the coefficients (8 c + 2,) that multiply `Pattern.scatter`.

    carrying (c,): contacts that take shear; pull_slope (c,): d (tension of an open contact) / d gap over kappa.
    """
    return np.concatenate(
        [
            (response.slip_stiffness * carrying[:, None, None]).ravel(),
            response.pressure_slope.ravel(),
            np.where(active, 1.0, pull_slope),
            active.astype(float),
            [float(displacement_control), 1.0],
        ]
    )


def make_pattern(model: ContactModel) -> Pattern:
    """Build the pattern of the model's Newton system."""
    width = model.unknowns
    row, column, value, coefficient = _entries(model)
    elastic = model.stiffness.tocoo()
    key = _keys(np.concatenate([row, elastic.row]), np.concatenate([column, elastic.col]), width)
    slots, slot = np.unique(key, return_inverse=True)
    return Pattern(
        indptr=np.searchsorted(slots // width, np.arange(width + 1)).astype(np.int32),
        indices=(slots % width).astype(np.int32),
        stiffness=np.bincount(slot[len(row) :], elastic.data, len(slots)).astype(float),
        mass=_in_slots(model.mass, slots, width),
        scatter=_scatter(value, slot, coefficient, len(slots), len(model.contacts)),
        slot=slot,
    )


def with_values_of(pattern: Pattern, model: ContactModel) -> Pattern:
    """Return the pattern with the values of a model whose contacts connect the same nodes."""
    _, _, value, coefficient = _entries(model)
    return replace(
        pattern,
        stiffness=np.bincount(pattern.slot[len(value) :], model.stiffness.data, len(pattern.indices)).astype(float),
        scatter=_scatter(value, pattern.slot, coefficient, len(pattern.indices), len(model.contacts)),
    )


def _scatter(value: FloatArray, slot: IntArray, coefficient: IntArray, slots: int, contacts: int) -> sparse.csr_matrix:
    return sparse.csr_matrix((value, (slot[: len(value)], coefficient)), shape=(slots, 8 * contacts + 2))


def _entries(model: ContactModel) -> tuple[npt.NDArray, ...]:
    """Return rows, columns, values and coefficient numbers of everything but K and M."""
    n, c = len(model.gravity), len(model.contacts)
    kappa, alpha = model.contact_stiffness, n + c
    control, one = 8 * c, 8 * c + 1
    contact = np.arange(c)
    normal, tangential = model.normal_rows.tocoo(), model.tangential_rows.tocoo()
    entries = [
        _slip_stiffness_entries(model),
        # u-lambda: -kappa B_n^T, kappa B_t^T S;  lambda-lambda: 1 - active
        # lambda-u: kappa B_n while active, else the slope of its tension
        (normal.col, n + normal.row, -kappa * normal.data, np.full(normal.nnz, one)),
        (tangential.col, n + tangential.row // 2, kappa * tangential.data, 4 * c + tangential.row),
        (n + normal.row, normal.col, kappa * normal.data, 6 * c + normal.row),
        (n + contact, n + contact, np.full(c, kappa), np.full(c, one)),
        (n + contact, n + contact, np.full(c, -kappa), 7 * c + contact),
        *_border_entries(model, alpha, control, one),
    ]
    return tuple(np.concatenate([entry[k] for entry in entries]) for k in range(4))


def _slip_stiffness_entries(model: ContactModel) -> tuple[npt.NDArray, ...]:
    """Return rows, columns, values and coefficient numbers of B_t^T T B_t, T being 4 coefficients a contact."""
    b_t = model.tangential_rows
    parts = []
    for a in range(2):
        for b in range(2):
            first, second = b_t[a::2].tocsr(), b_t[b::2].tocsr()
            count_a, count_b = np.diff(first.indptr), np.diff(second.indptr)
            contact = np.repeat(np.arange(first.shape[0]), count_a * count_b)
            within = np.arange(len(contact)) - np.repeat(
                np.cumsum(count_a * count_b) - count_a * count_b, count_a * count_b
            )
            i = first.indptr[contact] + within // count_b[contact]
            j = second.indptr[contact] + within % count_b[contact]
            parts.append((first.indices[i], second.indices[j], first.data[i] * second.data[j], 4 * contact + 2 * a + b))
    return tuple(np.concatenate([part[k] for part in parts]) for k in range(4))


def _border_entries(model: ContactModel, alpha: int, control: int, one: int) -> list[tuple[npt.NDArray, ...]]:
    """Return the entries of the column -f_h, of the mean row, and of the corner 1 - displacement control."""
    loaded = np.flatnonzero(model.lateral)
    scale = model.contact_stiffness
    corner = np.array([alpha])
    return [
        (loaded, np.full(len(loaded), alpha), -model.lateral[loaded], np.full(len(loaded), control)),
        (np.full(len(loaded), alpha), loaded, scale * model.mean_row[loaded], np.full(len(loaded), control)),
        (corner, corner, np.array([scale]), np.array([one])),
        (corner, corner, np.array([-scale]), np.array([control])),
    ]


def _connect_alike(first: ContactModel, second: ContactModel) -> bool:
    same_nodes = np.array_equal(first.contacts.master_nodes, second.contacts.master_nodes)
    return np.array_equal(first.rows, second.rows) and same_nodes


def _keys(row: IntArray, column: IntArray, width: int) -> IntArray:
    """Return one number for each place of a matrix; the product of 46,341 rows and columns exceeds 32 bits."""
    return row.astype(np.int64) * width + column


def _in_slots(matrix: sparse.csr_matrix, slots: IntArray, width: int) -> FloatArray:
    entries = matrix.tocoo()
    slot = np.searchsorted(slots, _keys(entries.row, entries.col, width))
    return np.bincount(slot, entries.data, len(slots)).astype(float)


class LinearSystem:
    """MUMPS on the constant pattern; use as a context manager. The same solution is returned on every rank."""

    def __init__(self, model: ContactModel, comm: MPI.Comm) -> None:
        self._comm = comm.Dup()
        self.seconds = 0.0
        """time spent in `solve` so far"""
        self._model = model
        self._pattern = make_pattern(model)
        self._open()

    def follow(self, model: ContactModel) -> None:
        """Take the values of another state of the model; a new pattern only where its contacts connect other nodes."""
        if model is self._model:
            return
        if _connect_alike(model, self._model):
            self._pattern = with_values_of(self._pattern, model)
        else:
            self._close()
            self._pattern = make_pattern(model)
            self._open()
        self._model = model

    def _open(self) -> None:
        size = len(self._pattern.indptr) - 1
        rows = PETSc.Mat().createAIJ(((None, size), (None, size)), comm=self._comm)
        rows.setUp()
        first, last = rows.getOwnershipRange()
        rows.destroy()
        self._rows = slice(first, last)
        self._slots = slice(int(self._pattern.indptr[first]), int(self._pattern.indptr[last]))
        self._indptr = self._pattern.indptr[first : last + 1] - self._pattern.indptr[first]
        self._indices = self._pattern.indices[self._slots]
        local = (last - first, size)
        self._matrix = PETSc.Mat().createAIJ(
            (local, local), csr=(self._indptr, self._indices, np.ones(len(self._indices))), comm=self._comm
        )
        self._right, self._solution = self._matrix.createVecs()
        self._solver = PETSc.KSP().create(self._comm)
        self._solver.setOperators(self._matrix)
        self._solver.setType("preonly")
        preconditioner = self._solver.getPC()
        preconditioner.setType("lu")
        preconditioner.setFactorSolverType("mumps")
        preconditioner.setFactorSetUpSolverType()
        factor = preconditioner.getFactorMatrix()
        factor.setMumpsIcntl(14, 100)  # room for delayed pivots, per cent
        factor.setMumpsIcntl(8, 0)  # kappa has scaled the system already; computing more takes a seventh of the time

    def _close(self) -> None:
        for item in (self._solver, self._matrix, self._right, self._solution):
            item.destroy()

    def __enter__(self) -> LinearSystem:
        return self

    def __exit__(self, failure: type[BaseException] | None, *_: object) -> None:
        if failure is None or self._comm.size == 1:  # a rank that fails may be alone: no collective call then
            self._close()
            self._comm.Free()

    def solve(self, contact_coefficients: FloatArray, time_step: float, right: FloatArray) -> FloatArray:
        """Return the solution (unknowns,) for `right` (unknowns,). Raises ConvergenceError if MUMPS fails."""
        began = perf_counter()
        pattern = self._pattern
        if self._comm.size > 1:
            refuse_disagreement(self._comm, np.append(right, time_step).tobytes(), "the increment to be solved")
        values = pattern.stiffness + pattern.mass / time_step**2 + pattern.scatter @ contact_coefficients
        self._matrix.setValuesCSR(self._indptr, self._indices, values[self._slots])
        self._matrix.assemble()
        self._right.setArray(right[self._rows])
        try:
            self._solver.solve(self._right, self._solution)
        except PETSc.Error as error:
            raise ConvergenceError("linear solver", f"MUMPS failed ({error})") from error
        reason = self._solver.getConvergedReason()
        solution = np.concatenate(self._comm.allgather(self._solution.getArray()))
        self.seconds += perf_counter() - began
        if reason < 0 or not np.isfinite(solution).all():
            raise ConvergenceError("linear solver", f"MUMPS failed (PETSc reason {reason})")
        return solution
