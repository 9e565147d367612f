"""When an increment counts as solved: the stopping rule on a made-up sequence of iterates."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest

from orchestrator.basis.errors import ConvergenceError
from orchestrator.pushover.settings import NewtonSettings
from orchestrator.pushover.solve import newton


@dataclass(frozen=True)
class FakeIterate:
    number: int
    norms: tuple[float, float, float, float]
    of_bodies: float = 0.0
    rounding: float = 0.0
    active: np.ndarray = field(default_factory=lambda: np.ones(2, bool))
    normal_force: np.ndarray = field(default_factory=lambda: np.zeros(2))
    response: SimpleNamespace = field(default_factory=lambda: SimpleNamespace(sliding=np.zeros(2, bool)))
    crushes: np.ndarray = field(default_factory=lambda: np.zeros(2, bool))
    ties: None = None


def solved(monkeypatch, *forces, rounding=0.0, states=1, leads=1000, **settings):
    """Run the stopping rule on so many iterates with these out-of-balance forces, the last one repeated."""

    def iterates(*_):
        for number in range(leads):
            active = np.array([number % states == 0, True])
            yield FakeIterate(number, (forces[min(number, len(forces) - 1)], 0.0, 0.0, 0.0), 0.0, rounding, active)

    monkeypatch.setattr(newton, "iterates", iterates)
    model = SimpleNamespace(
        contacts=SimpleNamespace(slave_body=np.zeros(2, int), master_body=np.ones(2, int)),
        body_names=("a", "b"),
        height=1.0,
    )
    return newton.solve_increment(
        model,
        None,
        None,
        FakeIterate(0, (forces[0], 0.0, 0.0, 0.0)),
        NewtonSettings(**settings),
    )


def test_first_iterate_below_the_tolerance_is_the_answer(monkeypatch):
    assert solved(monkeypatch, 1.0, 1e-3, 1e-9, 1.0).number == 2


def test_the_start_is_never_the_answer(monkeypatch):
    assert solved(monkeypatch, 1e-12, 1e-12).number == 1


def test_what_rounding_holds_just_above_the_tolerance_is_accepted_as_soon_as_it_goes_no_further(monkeypatch):
    found = solved(monkeypatch, 1.0, *[4e-6, 5e-8] * 10, states=2, iterations=14)
    assert found.norms[0] == pytest.approx(5e-8)
    assert found.number == 3


def test_a_path_that_leads_nowhere_is_a_failure_that_says_how_far_and_where(monkeypatch):
    said = r"2\.0e-06 of the weight after 3 iterations, contacts change between a \| b"
    with pytest.raises(ConvergenceError, match=said) as failed:
        solved(monkeypatch, 1.0, 3e-6, 2e-6, 5e-6, states=2, leads=4, iterations=14)
    assert failed.value.iterations == 3


def test_slow_convergence_uses_all_iterations(monkeypatch):
    with pytest.raises(ConvergenceError, match="after 14 iterations") as failed:
        solved(monkeypatch, 1.0, *[0.5**k for k in range(20)], iterations=14)
    assert failed.value.iterations == 14


def test_nan_ends_the_search_at_once(monkeypatch):
    with pytest.raises(ConvergenceError):
        solved(monkeypatch, 1.0, float("nan"))


def test_rounding_bounds_what_can_be_asked_for(monkeypatch):
    assert solved(monkeypatch, 1.0, 3e-7, rounding=4e-7).number == 1
