"""The linear program of limit analysis, Eq. (1), and the one that asks whether a wall stands at all. Clarabel.

    max  lambda - sum_k d_k N_k    s.t.   B q - lambda f_L = f_D,   C^T q + c >= 0            (d = 0 in Eq. (1))

Duals of the equality rows are the block velocities u (f_L . u = 1); -B^T u are then the openings and slips of joints.

Inside, forces are divided by the mean block weight, moments by a block length, and the unknown is live load over mean
block weight instead of lambda: unscaled, lambda is off by 2e-4 at 1,100 blocks although the status says solved
(docs/theory.md). Only c and d change between the programs of a sequence, so the solver is set up once (presolve off).
A shear that must be 0, as that of a tie, is no unknown: held between 0 and 0 it left the program no interior, and walls
with a tie of 100 block weights or more had no optimum now and then.
"""

from __future__ import annotations

from dataclasses import dataclass

import clarabel
import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.errors import ConvergenceError
from orchestrator.limit_analysis.paper.equilibrium import SMALL, Equilibrium
from orchestrator.limit_analysis.paper.yield_conditions import (
    YieldConditions,
    cohesion_rows,
    yield_matrix,
    yield_offset,
)

SMALLEST = 1e-6
"""Part to which rows and joints of small blocks are made smaller at most."""
FINAL_TOLERANCE = 1e-12
"""On gap and feasibility, where forces or mechanism are kept: the noise of the mechanism falls with it, for one or two
interior-point iterations more than 1e-9 (wall 6: 21 for 19)."""
ITERATE_TOLERANCE = 1e-9
"""For programs that only lead to the next one. At 1e-12 they take many more iterations where joints are
nearly indifferent."""
REFINED = 1e-10
"""Solutions of the linear systems are refined for tighter tolerances only: otherwise the same number of iterations in
40 % less time (wall 6). Large walls, which are solved to LARGE_TOLERANCE at best, need it wherever forces or mechanism
are kept: without, joints of a wall of 336 blocks exceed their strength by 1.3e-8 block weights."""
LARGE = 300
"""Free blocks; walls of more are solved to LARGE_TOLERANCE at best."""
LARGE_TOLERANCE = 1e-10
"""Of the linear programs of large walls. At 997 blocks 1e-12 is out of reach: programs end as AlmostSolved after 60 to
200 iterations and up to 18 s."""
DOUBTFUL = 1e-2
"""Mean block weights; if less is missing in the gravity check, it may be the solver's tolerance."""
VERY_LARGE = 2000
"""Walls of more free blocks are solved without refinement, which is two thirds of the time there: running bond, 2,979
blocks, forces without dilation 5.1 s for 8.3 s, equilibrium to 4e-13 of the weight and no joint beyond its strength. At
1e-9, four fifths of the time, power stays out of balance by 2.7e-7 and ends open by 1.7e-4 of the largest velocity
(10,050 blocks; 8e-8 and 1e-5 at 1e-10)."""
ACCEPTED = 1e3
"""Times the tolerance passes when the solver cannot do better (status AlmostSolved)."""


class InfeasibleError(ConvergenceError):
    """No joint forces satisfy equilibrium and yield together."""


class UnboundedError(ConvergenceError):
    """The load multiplier has no upper bound."""


@dataclass(frozen=True, eq=False, slots=True)
class LimitSolution:
    """Optimum of Eq. (1): joint_forces (k, 3) in N; velocities (3m,) of the free blocks in m/s and rad/s and joint
    rates (k, 3) in m/s (opening at start, at end, slip), both at unit live-load power (f_L . u = 1 N m/s)."""

    load_multiplier: float
    joint_forces: FloatArray
    velocities: FloatArray
    rates: FloatArray
    iterations: int
    seconds: float
    status: str

    @property
    def normal(self) -> FloatArray:
        """Normal force N (k,) of every joint in N."""
        return self.joint_forces[:, :2].sum(axis=1)


class LimitProgram:
    """Eq. (1) of one wall and one slope of the friction lines, set up once and solved for many c and d."""

    def __init__(
        self,
        equilibrium: Equilibrium,
        conditions: YieldConditions,
        tolerance: float = FINAL_TOLERANCE,
        flexibility: FloatArray | None = None,
    ) -> None:
        """Set up for yield conditions whose cohesion may change, to be solved to `tolerance`.

        flexibility (k, 3): of the joints, any unit; for programs `around` forces.
        """
        self._equilibrium, self._live_total = equilibrium, equilibrium.live_total
        self._tolerance, refined = _attainable(tolerance, len(equilibrium.free_blocks))
        self._refined = refined or flexibility is not None
        self._row_scale, self._force = scales(equilibrium)
        self._part = np.repeat(self._force / equilibrium.unit_force, 3)
        self._no_shear = conditions.without_shear
        self._part[2::3][self._no_shear] = 0.0
        squares = None if flexibility is None else np.append(flexibility.ravel() * self._part**2, 0.0)
        self._squares = None if squares is None else sp.diags(squares).tocsc()
        self._objective = np.zeros(equilibrium.matrix.shape[1] + 1)
        self._set_up(conditions)

    def _set_up(self, conditions: YieldConditions) -> None:
        """Hand the program to the solver with the chords of crushing that the conditions have so far."""
        self._conditions, equilibrium, scale = conditions, self._equilibrium, self._row_scale
        B = sp.diags(scale) @ equilibrium.matrix @ sp.diags(self._part)
        f_L = sp.csc_matrix((scale * equilibrium.live_load / self._live_total)[:, None])
        C_T, offset = scaled_rows(conditions, self._force)
        A = sp.bmat([[B, -f_L], [-C_T, None]], format="csc")
        self._right_side = np.append(scale * equilibrium.dead_load / equilibrium.unit_force, offset)
        cones = [clarabel.ZeroConeT(B.shape[0]), clarabel.NonnegativeConeT(C_T.shape[0])]
        self._solver = _solver(
            self._objective,
            A,
            self._right_side,
            cones,
            self._tolerance,
            self._refined,
            self._squares,
            equilibrate=bool(conditions.crushes.any()),
        )

    def solve(
        self,
        cohesion: FloatArray,
        shift: FloatArray | None = None,
        live_weight: float = 1.0,
        around: tuple[FloatArray, float] | None = None,
    ) -> LimitSolution:
        """Maximise live_weight lambda - sum d N for cohesions c (k,) in N and a shift d (k,) in m/s (none: 0).

        around: forces q_0 (k, 3) in N and a weight w: minimises w (q - q_0) F (q - q_0) / 2 too, forces over the mean
        block weight. Raises InfeasibleError, UnboundedError, or ConvergenceError when the solver stops short of
        ACCEPTED tolerance.
        """
        equilibrium, w, live_total = self._equilibrium, self._equilibrium.unit_force, self._live_total
        self._objective[:] = 0.0
        squares = None
        if around is not None and self._squares is not None:
            squares = around[1] * self._squares
            self._objective[:-1] = -squares.diagonal()[:-1] * around[0].ravel() / np.repeat(self._force, 3)
        if shift is not None:
            self._objective[:-1].reshape(-1, 3)[:, :2] += (live_total * self._part[::3] * shift)[:, None]
        self._objective[-1] = -live_weight
        solution, iterations, seconds = self._solved_with_all_chords(cohesion, squares)
        rows = len(self._row_scale)
        q, velocities = np.array(solution.x[:-1]).reshape(-1, 3), -np.array(solution.z[:rows]) * self._row_scale
        q[self._no_shear, 2] = 0.0
        velocities /= equilibrium.live_load @ velocities
        return LimitSolution(
            load_multiplier=solution.x[-1] * w / live_total,
            joint_forces=self._force[:, None] * q,
            velocities=velocities,
            rates=equilibrium.joint_rates(velocities),
            iterations=iterations,
            seconds=seconds,
            status=str(solution.status),
        )

    def _solved_with_all_chords(
        self, cohesion: FloatArray, squares: sp.csc_matrix | None
    ) -> tuple[clarabel.DefaultSolution, int, float]:
        """Solve for the objective, again while forces exceed chords; return iterations and seconds of all."""
        rows = len(self._row_scale)
        iterations, seconds = 0, 0.0
        while True:
            strength = np.where(self._no_shear, 1.0, cohesion / self._force)
            self._right_side[rows:][cohesion_rows(len(cohesion))] = np.tile(strength, 2)
            if squares is not None:
                self._solver.update(P=squares)
            self._solver.update(q=self._objective, b=self._right_side)
            solution = _solved(self._solver, "limit analysis")
            iterations, seconds = iterations + solution.iterations, seconds + solution.solve_time
            forces = self._force[:, None] * np.array(solution.x[:-1]).reshape(-1, 3)
            needed = self._conditions.with_chords_at(forces)
            if needed is self._conditions:
                return solution, iterations, seconds
            self._set_up(needed)


def scales(equilibrium: Equilibrium) -> tuple[FloatArray, FloatArray]:
    """Return factors (3m,) for the rows of equilibrium, and the forces (k,) that those of joints are measured by, in N.

    They are those of blocks of the mean weight, but smaller at blocks of less than SMALL times that: what a linear
    program says of a stone of 3e-4 of the others was else less than what rounding leaves (0.7 for 0.5).
    """
    weight = np.hypot(*equilibrium.dead_load.reshape(-1, 3)[:, :2].T) / (SMALL * equilibrium.unit_force)
    part = np.where(weight > 0.0, np.clip(weight, SMALLEST, 1.0), 1.0)  # a support that settles weighs nothing
    rows = equilibrium.row_scale / np.column_stack([part, part, part**1.5]).ravel()  # a moment goes with area x length
    touched = abs(equilibrium.matrix[:, ::3]).tocsc()
    block = np.repeat(part, 3)[touched.indices]
    return rows, equilibrium.unit_force * np.minimum.reduceat(block, touched.indptr[:-1])


def scaled_rows(conditions: YieldConditions, force: FloatArray) -> tuple[sp.csc_matrix, FloatArray]:
    """Return C^T and c for forces over `force` (k,) in N; rows of chords at far larger forces are brought back to 1."""
    C_T = yield_matrix(conditions).tocsr()
    of_row = np.repeat(force, 3)[C_T.indices[C_T.indptr[:-1]]]  # a row is of one joint
    offset = yield_offset(conditions) / of_row
    chords = offset[cohesion_rows(len(conditions.slope)).stop :]
    size = np.append(np.ones(len(offset) - len(chords)), np.maximum(chords, 1.0))
    return (sp.diags(1.0 / size) @ C_T).tocsc(), offset / size


def _attainable(tolerance: float, blocks: int) -> tuple[float, bool]:
    """Return the tolerance that a wall of so many free blocks is solved to where `tolerance` is wanted, and whether
    the linear systems are refined."""
    if blocks > LARGE:
        return max(tolerance, LARGE_TOLERANCE), tolerance < ITERATE_TOLERANCE and blocks <= VERY_LARGE
    return tolerance, tolerance < REFINED


def solve_limit_lp(equilibrium: Equilibrium, conditions: YieldConditions) -> LimitSolution:
    """Solve Eq. (1) once; raises as `LimitProgram.solve`."""
    return LimitProgram(equilibrium, conditions).solve(conditions.cohesion)


def solve_gravity_lp(equilibrium: Equilibrium, conditions: YieldConditions) -> tuple[float, FloatArray]:
    """Least sum of forces that must be added to make a wall stand without live load, and the motion it would make.

        min  sum (r+ + r-)   s.t.   B q + r+ - r- = f_D,   C^T q + c >= 0,   r+, r- >= 0

    Returns the sum over the mean block weight (0: it stands) and velocities (3m,) of the free blocks, none above 1
    (rotations times a block length): the dual, the mechanism in which gravity does that much work.

    The sum is that of the forces q found, sum |f_D - B q| + what they lack in C^T q + c >= 0: an upper bound of the
    least sum whatever the solver's tolerance. Its own objective is what the tolerance leaves of thousands of terms
    (running bond walls that stand: 4e-9 at 123 blocks, 1.3e-7 at 1,005, 3.3e-5 at 9,945). If less than DOUBTFUL is
    missing, q takes the least change that balances, B^T (B B^T)^-1 (f_D - B q): the LP's q lie in the middle of the
    cone, so that a change of 1e-8 costs no strength (the sum is then 1e-13, 3e-12, 8e-11).
    """
    scale = equilibrium.row_scale
    acts = np.ones((len(conditions.slope), 3))
    acts[conditions.without_shear, 2] = 0.0
    B = sp.diags(scale) @ equilibrium.matrix @ sp.diags(acts.ravel())
    C_T, offset = scaled_rows(conditions, np.full(len(conditions.slope), equilibrium.unit_force))
    offset[cohesion_rows(len(acts))] += np.tile(conditions.without_shear, 2)
    r = sp.identity(len(scale))
    A = sp.bmat([[B, r, -r], [-C_T, None, None], [None, -r, None], [None, None, -r]], format="csc")
    objective = np.concatenate([np.zeros(B.shape[1]), np.ones(2 * len(scale))])
    dead = scale * equilibrium.dead_load / equilibrium.unit_force
    right_side = np.concatenate([dead, offset, np.zeros(2 * len(scale))])
    cones = [clarabel.ZeroConeT(len(scale)), clarabel.NonnegativeConeT(A.shape[0] - len(scale))]
    solution = _solved(_solver(objective, A, right_side, cones, ITERATE_TOLERANCE), "gravity check")
    q = np.array(solution.x[: B.shape[1]])
    known = conditions.with_chords_at(equilibrium.unit_force * q.reshape(-1, 3))
    if known is not conditions:
        return solve_gravity_lp(equilibrium, known)

    def missing(q: FloatArray) -> float:
        lacking = np.maximum(-(C_T @ q + offset), 0.0)
        return float(np.abs(right_side[: len(scale)] - B @ q).sum() + lacking.sum())

    least = missing(q)
    if least < DOUBTFUL:
        balanced = q + B.T @ spsolve((B @ B.T).tocsc(), right_side[: len(scale)] - B @ q)
        least = min(least, missing(balanced))
    return least, -np.array(solution.z[: len(scale)]) * scale


def _solver(
    objective: FloatArray,
    A: sp.csc_matrix,
    b: FloatArray,
    cones: list[object],
    tolerance: float,
    refined: bool = False,
    squares: sp.csc_matrix | None = None,
    equilibrate: bool = True,
) -> clarabel.DefaultSolver:
    """Set up min x P x / 2 + objective . x, A x + slack = b, slack in cones; P = squares.

    `refined`: solutions of the linear systems. equilibrate: whether the solver scales rows and columns; it knows
    nothing of forces and lengths, and of 233 walls with small stones it failed on 26 that `scales` alone is enough for.
    Rows of crushing, strengths over decades, need it.
    """
    settings = solver_settings(tolerance)
    settings.iterative_refinement_enable, settings.equilibrate_enable = refined, equilibrate
    P = sp.csc_matrix((A.shape[1],) * 2) if squares is None else squares
    return clarabel.DefaultSolver(P, objective, A, b, cones, settings)


def solver_settings(tolerance: float) -> clarabel.DefaultSettings:
    """Return settings with which equal programs have equal solutions, to a tolerance on gap and feasibility."""
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.presolve_enable = False
    settings.max_threads = 1
    settings.direct_solve_method = "qdldl"  # its own choice for large walls takes twice the time at 2,979 blocks
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = tolerance
    accepted = ACCEPTED * tolerance
    settings.reduced_tol_gap_abs = settings.reduced_tol_gap_rel = settings.reduced_tol_feas = accepted
    return settings


def is_optimum(solution: clarabel.DefaultSolution, stage: str) -> bool:
    """Return whether a solver has found an optimum. Raises InfeasibleError or UnboundedError where there is none."""
    status = clarabel.SolverStatus
    if solution.status in (status.PrimalInfeasible, status.AlmostPrimalInfeasible):
        raise InfeasibleError(stage, "no joint forces satisfy equilibrium and friction")
    if solution.status in (status.DualInfeasible, status.AlmostDualInfeasible):
        raise UnboundedError(stage, "the load multiplier has no upper bound")
    return solution.status in (status.Solved, status.AlmostSolved)


def _solved(solver: clarabel.DefaultSolver, stage: str) -> clarabel.DefaultSolution:
    """Run the solver; anything but an optimum raises.

    Where rounding stops it short of its tolerance it is run again to the one that passes: its last iterates may be
    worse than those before (a wall that slides, confirmed to 1e-12: 2e-11 after ten iterations, 2e-9 in the end).
    """
    solution = solver.solve()
    if not is_optimum(solution, stage):
        wanted, passes = solver.get_settings(), solver.get_settings()
        passes.tol_gap_abs = passes.tol_gap_rel = passes.tol_feas = passes.reduced_tol_feas
        solver.update(settings=passes)
        again = solver.solve()
        solver.update(settings=wanted)
        if not is_optimum(again, stage):
            raise ConvergenceError(stage, not_solved("linear", again.iterations))
        return again
    return solution


def not_solved(kind: str, iterations: int) -> str:
    """Say that a program of a kind was not solved, and in how many iterations."""
    return f"{kind} program not solved in {iterations} iterations"
