"""The path of the piecewise linear problem: where it ends is its solution."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from mpi4py import MPI

from orchestrator.pushover.solve import contact_path
from orchestrator.pushover.solve.contact_path import Kinks, followed
from orchestrator.pushover.solve.linear_system import LinearSystem
from orchestrator.pushover.solve.newton import newton_coefficients
from orchestrator.pushover.solve.newton_matrix import Matrices, product
from tests.unit.pushover.test_linear_system import MORTAR, residual, state


@pytest.mark.parametrize("joints", [None, MORTAR])
@pytest.mark.parametrize("mean_displacement", [None, 1e-4])
def test_the_end_of_the_path_solves_the_piecewise_linear_problem(mean_displacement, joints):
    model, problem, x, _, _ = state(mean_displacement, joints)
    x = np.zeros_like(x)
    x[len(model.gravity) : -1] = model.weight / len(model.contacts) / model.contact_stiffness
    x[-1] = 0.35 * model.height
    now, iterate = residual(model, problem, x)
    iterate = replace(iterate, number=1)
    kinks = Kinks.at(model, problem, iterate)
    contact = newton_coefficients(model, problem, iterate)
    with LinearSystem(model, MPI.COMM_SELF) as system:
        solution = system.solve(contact, problem.time_step, -now)
        change, ends = followed(model, system, kinks, solution)
    assert ends
    phi = kinks.phi + kinks.rates(change)
    crossed = np.flatnonzero((phi > 0.0) != kinks.beyond)
    assert len(crossed) > 5
    left = now + product(model, Matrices.of(model), contact, problem.time_step, change)
    left += kinks.load(crossed, (np.where(phi > 0.0, 1.0, -1.0) * kinks.weight * phi)[crossed])
    assert np.linalg.norm(left) < 1e-6 * np.linalg.norm(now)
    whole = now + product(model, Matrices.of(model), contact, problem.time_step, solution)
    assert np.linalg.norm(whole) < 1e-6 * np.linalg.norm(now), "and Newton's step that of the first piece only"


def test_a_path_that_comes_back_to_its_first_piece_leads_nowhere(monkeypatch):
    """F = (x + 2, |x| + |y| - 1) is (1 - s) F_0 on the sides of a square, and nowhere 0: x + 2 is 1 there at least."""
    jacobian, sides = np.array([[1.0, 0.0], [1.0, 1.0]]), []

    def load(planes, amounts):
        return np.stack([np.zeros(amounts.shape[1:]), amounts.sum(axis=0)], axis=-1)

    def rates(change):
        return np.concatenate([change, np.zeros((*change.shape[:-1], 98))], axis=-1)

    far_off = np.full(98, 1.0)
    kinks = SimpleNamespace(
        phi=np.array([0.5, 0.5, *far_off]), beyond=np.ones(100, bool), weight=np.full(100, 2.0), rates=rates, load=load
    )
    system = SimpleNamespace(solve_again=lambda rights: np.linalg.solve(jacobian, rights.T).T)
    how_far = contact_path._how_far
    monkeypatch.setattr(contact_path, "_how_far", lambda *of: sides.append(of) or how_far(*of))
    solution = np.linalg.solve(jacobian, -np.array([2.5, 0.0]))
    change, ends = followed(SimpleNamespace(contacts=range(1000)), system, kinks, solution)
    assert not ends
    assert np.array_equal(change, solution)
    assert len(sides) == 4
