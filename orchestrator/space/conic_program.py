"""Second-order cone programs of limit analysis in space (Portioli et al. 2014). Clarabel.

    max  (1 - w) lambda - sum_k s_k N_k    s.t.   B q + lambda f_L + f_D = 0,   ||(T1_k, T2_k)|| <= mu_k N_k
    (w = 0, s = 0: the associative multiplier; s = mu ||v_T||: the dilation shift)

    max  lambda    s.t.   B q + lambda f_L + f_D = 0,   N_k >= 0,   ||(T1_k, T2_k)|| <= mu_k N^_k   (N^ given)

Duals of the equality rows are the block velocities, scaled to f_L . u = 1; B^T u are then openings and slips. Inside,
forces are divided by the mean block weight, moments by a block's length and the unknown is live load over mean weight.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import clarabel
import numpy as np
import scipy.sparse as sp

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.errors import ConvergenceError
from orchestrator.limit_analysis.paper.linear_program import is_optimum, not_solved, solver_settings
from orchestrator.space.equilibrium import SpaceEquilibrium
from orchestrator.space.work import Work

TOLERANCE = 1e-9
"""On gap and feasibility. 1,037 blocks: 5.9 s to 1e-9, 4.1 s to 1e-6."""
FRICTIONLESS = 1e-6
"""Points with less friction carry normal forces only: with mu = 1e-9 the solver ends 3e-5 off."""
REGULARISATION = (1e-8, 1e-7)
"""Of the solver's linear systems: its own default first."""


@dataclass(frozen=True, eq=False, slots=True)
class ConicSolution:
    """Optimum: forces (p, 3) in N (normal, two shears); velocities (m, 6) of the free blocks in m/s and rad/s and rates
    (p, 3) in m/s (opening, two slips), both at unit live-load power (f_L . u = 1 N m/s)."""

    load_multiplier: float
    forces: FloatArray
    velocities: FloatArray
    rates: FloatArray
    iterations: int
    seconds: float
    status: str

    @property
    def slip(self) -> FloatArray:
        """Size (p,) of the slip in m/s."""
        return np.linalg.norm(self.rates[:, 1:], axis=1)


def solve_associative(
    equilibrium: SpaceEquilibrium,
    shift: FloatArray | None = None,
    live_weight: float = 1.0,
    tolerance: float = TOLERANCE,
    work: Work | None = None,
) -> ConicSolution:
    """Maximise live_weight lambda - sum s N, with a shift s (p,) in m/s at unit live-load power (none: 0).

    work: what is left of it bounds the iterations, which are added. Raises InfeasibleError, UnboundedError, or
    ConvergenceError when the solver stops short of ACCEPTED tolerance.
    """
    objective = np.zeros(3 * len(equilibrium.friction))
    if shift is not None:
        objective[::3] = equilibrium.live_total * shift
    cones, rows, offset = _coulomb_cones(equilibrium)
    return _solve(equilibrium, objective, live_weight, rows, offset, cones, tolerance, "limit analysis", work)


def solve_given_normals(
    equilibrium: SpaceEquilibrium, normal: FloatArray, tolerance: float = TOLERANCE, work: Work | None = None
) -> ConicSolution:
    """Maximise lambda with friction mu N^ for given normal forces N^ (p,) in N: a mechanism without dilation."""
    radius = equilibrium.friction * np.maximum(normal, 0.0) / equilibrium.weight_scale
    points = np.arange(len(radius))
    held, sliding = points[radius <= 1e-9], points[radius > 1e-9]
    blocks, offsets, cones = [], [], list[object]()
    blocks.append(_rows(3 * points, -1.0, len(radius)))
    offsets.append(np.zeros(len(points)))
    cones.append(clarabel.NonnegativeConeT(len(points)))
    if len(held):
        both = np.concatenate([3 * held + 1, 3 * held + 2])
        blocks.append(_rows(both, 1.0, len(radius)))
        offsets.append(np.zeros(len(both)))
        cones.append(clarabel.ZeroConeT(len(both)))
    if len(sliding):
        column = (3 * sliding[:, None] + np.arange(3)).ravel()
        value = np.tile([0.0, -1.0, -1.0], len(sliding))
        blocks.append(_rows(column, value, len(radius)))
        offsets.append(np.column_stack([radius[sliding], np.zeros((len(sliding), 2))]).ravel())
        cones += [clarabel.SecondOrderConeT(3)] * len(sliding)
    _limit_ties(equilibrium, blocks, offsets, cones)
    rows, offset = sp.vstack(blocks, format="csc"), np.concatenate(offsets)
    rows.eliminate_zeros()
    return _solve(equilibrium, np.zeros(3 * len(radius)), 1.0, rows, offset, cones, tolerance, "mechanism", work)


def gravity_forces(equilibrium: SpaceEquilibrium, stiffness: FloatArray) -> FloatArray:
    """Return forces (p, 3) in N without live load: those of least energy, sum q^2 / k, of springs k (p,).

    Raises InfeasibleError where the wall cannot stand.
    """
    scale, weight = equilibrium.row_scale, equilibrium.weight_scale
    B = sp.diags(scale) @ equilibrium.matrix
    cones, rows, offset = _coulomb_cones(equilibrium)
    A = sp.vstack([B, rows], format="csc")
    b = np.concatenate([-scale * equilibrium.dead_load / weight, offset])
    P = sp.diags(np.repeat(stiffness.mean() / stiffness, 3), format="csc")
    every = [clarabel.ZeroConeT(B.shape[0]), *cones]
    return weight * np.array(_solved("gravity", P, np.zeros(A.shape[1]), A, b, every, 1e-8).x).reshape(-1, 3)


def missing_support(equilibrium: SpaceEquilibrium) -> tuple[float, FloatArray]:
    """Return the least sum of forces, in mean block weights, that must be added to make a wall stand without live load,
    and the motion (m, 6) it would make: the dual, in which gravity does that much work."""
    scale, weight = equilibrium.row_scale, equilibrium.weight_scale
    B = sp.diags(scale) @ equilibrium.matrix
    cones, rows, offset = _coulomb_cones(equilibrium)
    r, count = sp.identity(len(scale)), B.shape[1]
    A = sp.bmat([[B, r, -r], [rows, None, None], [None, -r, None], [None, None, -r]], format="csc")
    b = np.concatenate([-scale * equilibrium.dead_load / weight, offset, np.zeros(2 * len(scale))])
    objective = np.concatenate([np.zeros(count), np.ones(2 * len(scale))])
    every = [clarabel.ZeroConeT(len(scale)), *cones, clarabel.NonnegativeConeT(2 * len(scale))]
    solution = _solved("gravity check", sp.csc_matrix(2 * (A.shape[1],)), objective, A, b, every, 1e-8)
    return float(solution.obj_val), (-np.array(solution.z[: len(scale)]) * scale).reshape(-1, 6)


def _rows(columns: np.ndarray, values: FloatArray | float, points: int) -> sp.csc_matrix:
    """Return one row for each column number, with its value there."""
    data = np.broadcast_to(values, columns.shape)
    return sp.csc_matrix((data, (np.arange(len(columns)), columns)), shape=(len(columns), 3 * points))


def _coulomb_cones(equilibrium: SpaceEquilibrium) -> tuple[list[object], sp.csc_matrix, FloatArray]:
    """Return cones, rows and right side of ||T|| <= mu N; a frictionless point has N >= 0 and T = 0; ties N <= F_y."""
    slopes = equilibrium.friction
    rubbing, points = slopes >= FRICTIONLESS, np.arange(len(slopes))
    smooth = points[~rubbing]
    column = (3 * points[rubbing, None] + np.arange(3)).ravel()
    value = -np.column_stack([slopes[rubbing], np.ones((len(points) - len(smooth), 2))]).ravel()
    blocks = [_rows(column, value, len(slopes))]
    cones: list[object] = [clarabel.SecondOrderConeT(3)] * (len(points) - len(smooth))
    if len(smooth):
        both = np.concatenate([3 * smooth + 1, 3 * smooth + 2])
        blocks += [_rows(3 * smooth, -1.0, len(slopes)), _rows(both, 1.0, len(slopes))]
        cones += [clarabel.NonnegativeConeT(len(smooth)), clarabel.ZeroConeT(len(both))]
    offset = [np.zeros(sum(block.shape[0] for block in blocks))]
    _limit_ties(equilibrium, blocks, offset, cones)
    return cones, sp.vstack(blocks, format="csc"), np.concatenate(offset)


def _limit_ties(
    equilibrium: SpaceEquilibrium, blocks: list[sp.csc_matrix], offset: list[FloatArray], cones: list[object]
) -> None:
    """Add N <= F_y of ties to rows, right sides and cones."""
    ties = np.flatnonzero(np.isfinite(equilibrium.capacity))
    if len(ties):
        blocks.append(_rows(3 * ties, 1.0, len(equilibrium.capacity)))
        offset.append(equilibrium.capacity[ties] / equilibrium.weight_scale)
        cones.append(clarabel.NonnegativeConeT(len(ties)))


def _solve(
    equilibrium: SpaceEquilibrium,
    objective: FloatArray,
    live_weight: float,
    rows: sp.csc_matrix,
    offset: FloatArray,
    cones: Sequence[object],
    tolerance: float,
    stage: str,
    work: Work | None,
) -> ConicSolution:
    """Maximise live_weight lambda - objective . q under equilibrium and the cones."""
    scale, weight, live_total = equilibrium.row_scale, equilibrium.weight_scale, equilibrium.live_total
    B = sp.diags(scale) @ equilibrium.matrix
    f_L = sp.csc_matrix((scale * equilibrium.live_load / live_total)[:, None])
    A = sp.bmat([[B, f_L], [rows, None]], format="csc")
    b = np.concatenate([-scale * equilibrium.dead_load / weight, offset])
    q = np.append(objective, -live_weight)
    every = [clarabel.ZeroConeT(B.shape[0]), *cones]
    solution = _solved(stage, sp.csc_matrix(2 * (A.shape[1],)), q, A, b, every, tolerance, work)
    velocities = np.array(solution.z[: B.shape[0]]) * scale
    velocities = (velocities / (equilibrium.live_load @ velocities)).reshape(-1, 6)
    return ConicSolution(
        load_multiplier=solution.x[-1] * weight / live_total,
        forces=weight * np.array(solution.x[:-1]).reshape(-1, 3),
        velocities=velocities,
        rates=equilibrium.rates(velocities),
        iterations=solution.iterations,
        seconds=solution.solve_time,
        status=str(solution.status),
    )


def _solved(
    stage: str,
    P: sp.csc_matrix,
    objective: FloatArray,
    A: sp.csc_matrix,
    b: FloatArray,
    cones: Sequence[object],
    tolerance: float,
    work: Work | None = None,
) -> clarabel.DefaultSolution:
    """Minimise x P x / 2 + objective . x, A x + slack = b, slack in cones; anything but an optimum raises.

    Where the solver loses its way it starts again with REGULARISATION: contact points much nearer to each other than a
    block is large need it (a knife edge on a wall), others take a third longer with it.
    """
    for regularisation in REGULARISATION:
        settings = solver_settings(tolerance)
        if work is not None:
            settings.max_iter = int(min(max(work.left, 1.0), settings.max_iter))
        settings.static_regularization_constant = regularisation
        solution = clarabel.DefaultSolver(P, objective, A, b, list(cones), settings).solve()
        if work is not None:
            work.done += solution.iterations
        if is_optimum(solution, stage):
            return solution
        if work is not None and work.left <= 0:
            break
    raise ConvergenceError(stage, not_solved("cone", solution.iterations))
