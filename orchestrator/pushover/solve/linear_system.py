"""The linear system of a Newton iteration, solved on all ranks: factors of the condensed matrix, and refinement.

newton_matrix.py says what the matrix is, and the condensed one that is factorised in its place; factors.py, how. Its
pattern is analysed once. With the residual r of the exact system

    solve the condensed system for r, expand, add to x, r = right - (Newton matrix) x

leaves about 1 / penalty of most errors each time. Of a few it leaves nearly all: forces that circulate between four
corners in one point meet little but the stiffness with which these stick. So changes are added in that combination,
of all so far, that leaves the least residual (generalised conjugate residuals): each such force takes one refinement
more. Without, walls cut by straight lines, whose stones meet so, broke off
(tests/verification/test_corners_in_a_point.py). The residual is kept in extended precision (np.longdouble), because in
double precision the penalty's rounding is larger than what stiff stones (E x 100) leave of it. The solution is then
exact to 1e-11 of its largest entry, but for forces with next to nothing against them, whose residual is small. Smaller
entries, forces among them, differ by more from one number of ranks to another; Newton's iterations part where contacts
close and slide in turn more than about ten times.

Tried, and not used: the forces of closed contacts as unknowns, with the flexibility of each body (constant in its own
frame) and its rigid motion in the place of displacements. Factors of benchmark 1 when it is loaded and past its peak
took, in ms of one machine (those of the condensed matrix in brackets), 2.3 and 0.4 (0.7) for macroblocks, 4.8 and 2.7
(1.6) for every stone, 19 and 2 (30), 28 and 9 (38) with a quarter of the element size, 40 and 20 (25) for 512 stones.
Each solution takes two of the bodies' own besides: 5 ms with a quarter of the element size, for 3 to 5 as it is. All
nodes of contacts as unknowns take as long as all nodes, even there.

N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., SIAM 2002, chapter 12; S. C. Eisenstat,
H. C. Elman, M. H. Schultz, SIAM Journal on Numerical Analysis 20 (1983) 345-357.
"""

from __future__ import annotations

import logging
from time import perf_counter

import numpy as np
from mpi4py import MPI

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.errors import ConvergenceError
from orchestrator.basis.parallel import refuse_disagreement
from orchestrator.pushover.model import ContactModel
from orchestrator.pushover.solve.factors import Mumps, Unpivoted
from orchestrator.pushover.solve.newton_matrix import (
    Coefficients,
    Matrices,
    Pattern,
    condensed_right,
    connect_alike,
    expanded,
    make_pattern,
    product,
    values,
    values_of_bodies,
    with_values_of,
)

logger = logging.getLogger(__name__)

SOLUTION_ERROR = 1e-11
"""error of the solution, as expected from the last two refinements, at which they end (1e-12 takes 2.8 solutions an
iteration of benchmark 1 in place of 2.5, for curves equal to 1e-11)"""
ROUNDS = 8
"""refinements at most (with 40 one more of 280 walls cut by straight lines reached its peak; a throw-away script)"""
USELESS = 1e-6
"""where refinements do not end, a residual larger than this share of the right-hand side is a failure"""
SMALL = 20_000
"""unknowns up to which one rank eliminates without pivoting (factors.py says what that takes)"""


class LinearSystem:
    """The factors of a model's pattern; use as a context manager. The same solution is returned on every rank."""

    def __init__(self, model: ContactModel, comm: MPI.Comm) -> None:
        self._comm = comm.Dup()
        self.seconds = 0.0
        """time spent in `solve` so far"""
        self.together = 0.0
        """seconds in what all ranks do together, waiting included: the factors and the exchange around them"""
        self._take(model)
        self._pattern = self._own_rows()
        self._factor = self._made()
        self._last: tuple[Mumps | Unpivoted, Coefficients] | None = None
        # of the last solution: unit residuals, and the changes that take them
        self._solved: tuple[FloatArray, FloatArray]
        self._lacking: FloatArray | None = None  # what the factors alone leave of these changes

    def follow(self, model: ContactModel) -> None:
        """Take the values of another state of the model; a new pattern only where its contacts connect other nodes."""
        if model is self._model:
            return
        alike = connect_alike(model, self._model)
        self._take(model)
        if alike:
            self._pattern = with_values_of(self._pattern, model)
        else:
            self._forget()
            self._factor.close()
            self._pattern = self._own_rows()
            self._factor = self._made()

    def _take(self, model: ContactModel) -> None:
        self._model, self._exact = model, Matrices.of(model, np.longdouble)
        self._bodies: tuple[float, FloatArray] | None = None  # for a time step

    @property
    def _unknowns(self) -> int:
        return 3 * len(self._model.body) + 1

    @property
    def _small(self) -> bool:
        return self._comm.size == 1 and self._unknowns <= SMALL

    def _own_rows(self) -> Pattern:
        count, ranks = len(self._model.body), self._comm.size
        first, last = (count * rank // ranks for rank in (self._comm.rank, self._comm.rank + 1))
        return make_pattern(self._model, first, last)

    def _made(self) -> Mumps | Unpivoted:
        return Unpivoted(self._pattern) if self._small else Mumps(self._pattern, self._unknowns, self._comm)

    def __enter__(self) -> LinearSystem:
        return self

    def __exit__(self, failure: type[BaseException] | None, *_: object) -> None:
        if failure is None or self._comm.size == 1:  # a rank that fails may be alone: no collective call then
            self._forget()
            self._factor.close()
            self._comm.Free()

    def solve(self, contact: Coefficients, time_step: float, right: FloatArray) -> FloatArray:
        """Return the solution (unknowns,) for `right` (unknowns,). Raises ConvergenceError if there is none."""
        began = perf_counter()
        if self._comm.size > 1:
            refuse_disagreement(self._comm, np.append(right, time_step).tobytes(), "the increment to be solved")
            self.together += perf_counter() - began
        if self._bodies is None or self._bodies[0] != time_step:
            self._bodies = time_step, values_of_bodies(self._pattern, self._model, time_step)
        found = values(self._pattern, self._model, contact, time_step, self._bodies[1])
        self._forget()
        self._last = self._factor, contact
        try:
            self._factor.take(found)
            solution = self._refined(self._factor, contact, time_step, right)
        except ConvergenceError as error:
            if not self._small:
                raise
            logger.info("%s: solved with pivoting", error)
            with_pivots = Mumps(self._pattern, self._unknowns, self._comm)
            self._last = with_pivots, contact
            with_pivots.take(found)
            solution = self._refined(with_pivots, contact, time_step, right)
        self.seconds += perf_counter() - began
        return solution

    def solve_again(self, rights: FloatArray) -> FloatArray:
        """Return solutions for right-hand sides, (k, unknowns), with the last factors and the changes that the last
        solution was put together from: to about 1 / PENALTY."""
        began = perf_counter()
        images, changes = self._solved
        if self._lacking is None:
            self._lacking = changes - self._once(images)
        found = self._once(rights) + (rights @ images.T) @ self._lacking
        passed = perf_counter() - began
        self.together, self.seconds = self.together + passed, self.seconds + passed
        return found

    def _once(self, rights: FloatArray) -> FloatArray:
        """Return solutions (k, unknowns) with the last factors alone."""
        assert self._last is not None
        factor, contact = self._last
        condensed = factor.solve_each(condensed_right(self._model, contact, rights))
        return expanded(self._model, contact, rights, condensed)

    def _forget(self) -> None:
        """Free factors with pivoting, which are made for one solution."""
        if self._last is not None and self._last[0] is not self._factor:
            self._last[0].close()
        self._last = self._lacking = None

    def _refined(
        self, factor: Mumps | Unpivoted, contact: Coefficients, time_step: float, right: FloatArray
    ) -> FloatArray:
        model = self._model
        solution, residual, before = np.zeros_like(right), right.astype(np.longdouble), 1.0
        images, changes = np.zeros((0, len(right)), np.longdouble), np.zeros((0, len(right)))
        for _ in range(ROUNDS):
            lacks = residual.astype(float)
            forces = condensed_right(model, contact, lacks)
            began = perf_counter()
            condensed = factor.solve(forces)
            self.together += perf_counter() - began
            change = expanded(model, contact, lacks, condensed)
            share = _size(change) / max(_size(solution + change), 1e-300)
            if share**2 / before <= SOLUTION_ERROR:
                self._solved = images.astype(float), changes
                return solution + change
            image = product(model, self._exact, contact, time_step, change.astype(np.longdouble))
            known = images @ image
            image, change = image - known @ images, change - known.astype(float) @ changes
            length = _size(image)
            if not length > 0.0:
                break
            images, changes = np.vstack([images, image / length]), np.vstack([changes, change / length])
            step = images[-1] @ residual
            solution, residual, before = solution + float(step) * changes[-1], residual - step * images[-1], share
        left, size = _size(residual), _size(right)
        if not left <= USELESS * size:
            raise ConvergenceError("linear solver", f"refinement ends at {left:.0e} of {size:.0e}")
        self._solved = images.astype(float), changes
        return solution

    @property
    def share(self) -> float:
        """Part of the last factorisation's operations that this rank did."""
        return self._factor.share


def _size(vector: FloatArray) -> float:
    return float(np.linalg.norm(vector.astype(float)))
