"""The Newton matrix against finite differences of the residual it is meant to be the derivative of."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sparse
from mpi4py import MPI

from orchestrator.basis.errors import ConvergenceError
from orchestrator.masonry.joints import JointClass
from orchestrator.masonry.patterns import running_bond
from orchestrator.pushover.solve.factors import Mumps, Unpivoted
from orchestrator.pushover.solve.iterate import Target, evaluate
from orchestrator.pushover.solve.linear_system import LinearSystem
from orchestrator.pushover.solve.newton import newton_coefficients
from orchestrator.pushover.solve.newton_matrix import (
    Coefficients,
    Matrices,
    condensed_right,
    expanded,
    make_pattern,
    product,
    values,
)
from tests.support.pushover_chain import model_of, stack
from tests.support.ranks import on_ranks


def residual(model, problem, x):
    """Return (R_u, contact rows, control row) of newton.py for x = (u, lambda / kappa, alpha x height)."""
    n, kappa = len(model.gravity), model.contact_stiffness
    iterate = evaluate(model, problem, x[:n], kappa * x[n:-1], x[-1] / model.height)
    contact = np.where(iterate.active, kappa * iterate.gap, iterate.normal_force)
    contact = np.where(iterate.crushes, iterate.normal_force - iterate.strength, contact)
    if problem.mean_displacement is None:
        return np.concatenate([iterate.force_residual, contact, [0.0]]), iterate
    control = kappa * (model.mean_row @ x[:n] - problem.mean_displacement)
    return np.concatenate([iterate.force_residual, contact, [control]]), iterate


MORTAR = JointClass(normal_stiffness=1e11, shear_stiffness=2e9, compressive_strength=1e5)


def state(mean_displacement, joints=None):
    """Return model, problem, a state x between stick, slip and opening, and the coefficients of its matrix."""
    model = model_of(stack((0.4, 0.3), (0.2, 0.3), friction=0.6), mesh_size=0.05, slip_tolerance=1e-5, joints=joints)
    n, c = len(model.gravity), len(model.contacts)
    random = np.random.default_rng(2)
    problem = Target(
        gravity_share=1.0,
        displacement=np.zeros(n),
        elastic_slip=random.normal(size=(c, 2)) * 1e-5,
        time_step=0.05,
        mean_displacement=mean_displacement,
        mortar=model.mortar,
    )
    displacement = random.normal(size=n) * 1e-5
    closed = model.normal_rows @ displacement < 0  # an open contact carries nothing, as after any Newton step
    x = np.concatenate([displacement, np.where(closed, random.uniform(1e-6, 1e-5, c), 0.0), [0.1]])
    _, iterate = residual(model, problem, x)
    assert 0 < iterate.active.sum() < c
    assert 0 < iterate.response.sliding.sum() < c
    assert bool(joints) == (0 < iterate.crushes.sum() < iterate.active.sum())
    assert bool(joints) == (0 < iterate.response.elastic.sum() < c)
    contact = newton_coefficients(model, problem, replace(iterate, number=1))
    return model, problem, x, closed, contact


@pytest.mark.parametrize("joints", [None, MORTAR])
@pytest.mark.parametrize("mean_displacement", [None, 1e-4])
def test_matrix_is_the_derivative_of_the_residual(mean_displacement, joints):
    model, problem, x, closed, contact = state(mean_displacement, joints)
    n, c, kappa = len(model.gravity), len(model.contacts), model.contact_stiffness
    direction = np.random.default_rng(5).normal(size=n + c + 1) * 1e-5
    direction[n:-1] *= closed
    direction[-1] = 0.01 if mean_displacement is not None else 0.0
    step = 1e-5
    ahead, behind = residual(model, problem, x + step * direction)[0], residual(model, problem, x - step * direction)[0]
    found = product(model, Matrices.of(model), contact, problem.time_step, direction)
    assert found == pytest.approx((ahead - behind) / (2 * step), rel=1e-4, abs=1e-3)
    assert np.abs(found).max() > kappa * 1e-6, "the direction must matter"


@pytest.mark.parametrize("joints", [None, MORTAR])
@pytest.mark.parametrize("mean_displacement", [None, 1e-4])
def test_solution_times_matrix_is_the_right_hand_side(mean_displacement, joints):
    model, problem, _, _, contact = state(mean_displacement, joints)
    right = np.random.default_rng(6).normal(size=model.unknowns)
    with LinearSystem(model, MPI.COMM_SELF) as system:
        solution = system.solve(contact, problem.time_step, right)
    found = product(model, Matrices.of(model), contact, problem.time_step, solution)
    assert np.linalg.norm(found - right) < 1e-10 * np.linalg.norm(right)


@pytest.mark.parametrize("joints", [None, MORTAR])
@pytest.mark.parametrize("mean_displacement", [None, 1e-4])
def test_condensed_matrix_is_the_newton_matrix_with_a_penalty(mean_displacement, joints):
    """Eliminating the multipliers of (Newton matrix + kappa / penalty where active) leaves the rows of both ranks."""
    model, problem, _, _, contact = state(mean_displacement, joints)
    n, count = len(model.gravity), len(model.body)
    parts = []
    for first, last in ((0, count // 3), (count // 3, count)):
        pattern = make_pattern(model, first, last)
        data = values(pattern, model, contact, problem.time_step)
        parts.append(sparse.csr_matrix((data, pattern.indices, pattern.indptr), (len(pattern.indptr) - 1, n + 1)))
    condensed = sparse.vstack(parts).tocsr()
    x = np.random.default_rng(7).normal(size=model.unknowns)
    penalty = np.zeros_like(x)
    penalty[n:-1] = model.contact_stiffness * (contact.compliance - contact.softness)
    right = product(model, Matrices.of(model), contact, problem.time_step, x) + penalty * x
    reduced = condensed_right(model, contact, right)
    cancels = 1e-12 * abs(condensed).max()
    assert condensed @ np.append(x[:n], x[-1]) == pytest.approx(reduced, rel=1e-6, abs=cancels)
    found = expanded(model, contact, right, np.append(x[:n], x[-1]))
    assert found == pytest.approx(x, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("halves", [True, False])
def test_a_large_wall_has_every_mass_in_its_place(halves):
    model = model_of(running_bond(42, 24), halves=halves)
    pattern = make_pattern(model, 0, len(model.body))
    n = len(model.gravity)
    assert n * n > 2**31 or halves, "row x width + column of a mass must not fit into 32 bits"
    mass = np.zeros((len(pattern.mass), 9))
    mass[:, [0, 4, 8]] = pattern.mass
    data = np.zeros(len(pattern.indices))
    data[pattern.place] = mass
    found = sparse.csr_matrix((data, pattern.indices, pattern.indptr), shape=(n + 1, n + 1))
    acceleration = np.random.default_rng(3).normal(size=n + 1)
    inertia = np.append(model.mass @ acceleration[:n], 0.0)
    assert found @ acceleration == pytest.approx(inertia, rel=1e-12, abs=1e-12 * np.abs(inertia).max())


TWO_BODIES = """
import numpy as np
from mpi4py import MPI
from orchestrator.pushover.solve.linear_system import LinearSystem
from tests.unit.pushover.test_linear_system import state
model, problem, _, _, contact = state(1e-4)
right, other = np.random.default_rng(6).normal(size=(2, model.unknowns))
solutions, off = [], []
for comm in (MPI.COMM_SELF, MPI.COMM_WORLD):
    with LinearSystem(model, comm) as system:
        expected = system.solve(contact, problem.time_step, other)
        solutions.append(system.solve(contact, problem.time_step, right))
        again = system.solve_again(np.array([right, other]))
        wholes = solutions[-1], expected
        off += [np.linalg.norm(one - whole) / np.linalg.norm(whole) for one, whole in zip(again, wholes)]
        share = system.share
difference = np.linalg.norm(solutions[1] - solutions[0]) / np.linalg.norm(solutions[0])
everywhere = MPI.COMM_WORLD.gather((model.bodies, difference, solutions[1].tobytes(), share))
if everywhere:
    print(everywhere[0][0], max(each[1] for each in everywhere), len({each[2] for each in everywhere}))
    print(sum(each[3] for each in everywhere), max(off))
"""


def test_two_bodies_on_three_ranks_have_the_solution_of_one():
    """Either body is larger than a rank's share; the right-hand side moves the blocks by metres: 1e-8 is rounding."""
    done = on_ranks(3, "-c", TWO_BODIES)
    assert done.returncode == 0, done.stderr
    bodies, difference, different, shares, off = done.stdout.split()
    assert int(bodies) == 2
    assert float(difference) < 1e-8
    assert int(different) == 1, "every rank must have the same bits"
    assert float(shares) == pytest.approx(1.0), "of the operations of the factorisation"
    assert float(off) < 1e-4, "solutions together, by either kind of factors, are those of each alone"


def test_a_block_that_slides_freely_is_held_by_the_prescribed_displacement():
    """Without its load multiplier the matrix is singular, and that is eliminated last."""
    model = model_of(stack((0.4, 0.3), friction=1e-9), mesh_size=0.1)
    count = len(model.contacts)
    contact = Coefficients(
        slip_stiffness=np.zeros((count, 2, 2)),
        pressure_slope=np.zeros((count, 2)),
        gap_slope=np.ones(count),
        softness=np.zeros(count),
        active=np.ones(count, bool),
        displacement_control=True,
    )
    no_mass = 1e12
    right = np.zeros(model.unknowns)
    right[-1] = model.contact_stiffness * 1e-3
    with LinearSystem(model, MPI.COMM_SELF) as system:
        solution = system.solve(contact, no_mass, right)
    moved = solution[: len(model.gravity)].reshape(-1, 3)
    assert moved == pytest.approx(np.tile([1e-3, 0.0, 0.0], (len(moved), 1)), abs=1e-9)
    assert np.abs(solution[len(model.gravity) :]).max() < 1e-9, "no force is needed"


@pytest.mark.parametrize("mean_displacement", [None, 1e-4])
def test_elimination_without_pivoting_has_the_solution_of_mumps(mean_displacement):
    model, problem, _, _, contact = state(mean_displacement)
    pattern, unknowns = make_pattern(model, 0, len(model.body)), len(model.gravity) + 1
    right = np.random.default_rng(8).normal(size=unknowns)
    found = []
    for factor in (Mumps(pattern, unknowns, MPI.COMM_SELF), Unpivoted(pattern)):
        factor.take(values(pattern, model, contact, problem.time_step))
        found.append(factor.solve(right))
        factor.close()
    assert found[1] == pytest.approx(found[0], rel=1e-3, abs=1e-3 * np.abs(found[0]).max())


class WithoutPivot:
    """An elimination that meets a pivot of zero."""

    def take(self, values):
        """Take anything."""

    def solve(self, right):
        raise ConvergenceError("linear solver", "factorisation failed")

    def close(self):
        """Hold nothing."""


def test_where_it_fails_pivots_are_looked_for(caplog):
    model, problem, _, _, contact = state(1e-4)
    right = np.random.default_rng(6).normal(size=model.unknowns)
    with LinearSystem(model, MPI.COMM_SELF) as system:
        expected = system.solve(contact, problem.time_step, right)
        system._factor.close()
        system._factor = WithoutPivot()
        with caplog.at_level("INFO"):
            found = system.solve(contact, problem.time_step, right)
    assert found == pytest.approx(expected, rel=1e-8, abs=1e-10 * np.abs(expected).max())
    assert "with pivoting" in caplog.text
