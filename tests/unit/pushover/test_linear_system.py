"""The Newton matrix against finite differences of the residual it is meant to be the derivative of."""

import numpy as np
import pytest
import scipy.sparse as sparse

from orchestrator.masonry.patterns import running_bond
from orchestrator.pushover.linear_system import coefficients, make_pattern
from orchestrator.pushover.newton import Problem, evaluate
from tests.verification.pushover_chain import model_of, stack


def residual(model, problem, x):
    """Return (R_u, contact rows, control row) of newton.py for x = (u, lambda / kappa, alpha)."""
    n, kappa = len(model.gravity), model.contact_stiffness
    iterate = evaluate(model, problem, x[:n], kappa * x[n:-1], x[-1])
    contact = np.where(iterate.active, kappa * iterate.gap, iterate.normal_force)
    if problem.mean_displacement is None:
        return np.concatenate([iterate.force_residual, contact, [0.0]]), iterate
    control = kappa * (model.mean_row @ x[:n] - problem.mean_displacement)
    return np.concatenate([iterate.force_residual, contact, [control]]), iterate


@pytest.mark.parametrize("mean_displacement", [None, 1e-4])
def test_matrix_is_the_derivative_of_the_residual(mean_displacement):
    model = model_of(stack((0.4, 0.3), (0.2, 0.3), friction=0.6), slip_tolerance=1e-5)
    n, c = len(model.gravity), len(model.contacts)
    random = np.random.default_rng(2)
    problem = Problem(
        gravity_share=1.0,
        displacement=np.zeros(n),
        elastic_slip=random.normal(size=(c, 2)) * 1e-5,
        inertia_reference=np.zeros(n),
        time_step=0.05,
        mean_displacement=mean_displacement,
    )
    kappa = model.contact_stiffness
    displacement = random.normal(size=n) * 1e-5
    closed = model.normal_rows @ displacement < 0  # an open contact carries nothing, as after any Newton step
    x = np.concatenate([displacement, np.where(closed, random.uniform(1e-6, 1e-5, c), 0.0), [0.1]])
    _, iterate = residual(model, problem, x)
    assert 0 < iterate.active.sum() < c
    assert 0 < iterate.response.sliding.sum() < c
    pattern = make_pattern(model)
    control = mean_displacement is not None
    data = pattern.stiffness + pattern.mass / problem.time_step**2
    data = data + pattern.scatter @ coefficients(
        iterate.response, iterate.active, iterate.carrying, iterate.pull_slope, control
    )
    matrix = sparse.csr_matrix((data, pattern.indices, pattern.indptr))
    direction = random.normal(size=n + c + 1) * 1e-5
    direction[n:-1] *= closed
    direction[-1] = 0.01 if control else 0.0
    step = 1e-5
    ahead, behind = residual(model, problem, x + step * direction)[0], residual(model, problem, x - step * direction)[0]
    assert matrix @ direction == pytest.approx((ahead - behind) / (2 * step), rel=1e-4, abs=1e-3)
    assert np.abs(matrix @ direction).max() > kappa * 1e-6, "the direction must matter"


def test_a_large_wall_has_every_mass_in_its_place():
    model = model_of(running_bond(40, 24))
    n, width = len(model.gravity), model.unknowns
    assert n * width > 2**31, "row x width + column of a mass must not fit into 32 bits"
    pattern = make_pattern(model)
    mass = sparse.csr_matrix((pattern.mass, pattern.indices, pattern.indptr), shape=(width, width))
    acceleration = np.random.default_rng(3).normal(size=width)
    inertia = np.concatenate([model.mass @ acceleration[:n], np.zeros(width - n)])
    assert mass @ acceleration == pytest.approx(inertia, rel=1e-12, abs=1e-12 * np.abs(inertia).max())
