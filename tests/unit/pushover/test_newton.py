"""When an increment counts as solved: the stopping rule on a made-up sequence of iterates."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from orchestrator.errors import ConvergenceError
from orchestrator.pushover import newton
from orchestrator.pushover.settings import NewtonSettings


@dataclass(frozen=True)
class FakeIterate:
    number: int
    norms: tuple[float, float, float, float]
    rounding: float = 0.0


def solved(monkeypatch, *forces, rounding=0.0, **settings):
    """Run the stopping rule on iterates with these out-of-balance forces, the last repeated for ever."""

    def iterates(*_):
        for number in range(1000):
            yield FakeIterate(number, (forces[min(number, len(forces) - 1)], 0.0, 0.0, 0.0), rounding)

    monkeypatch.setattr(newton, "iterates", iterates)
    return newton.solve_increment(
        None, None, None, FakeIterate(0, (forces[0], 0.0, 0.0, 0.0)), NewtonSettings(**settings)
    )


def test_first_iterate_below_the_tolerance_is_the_answer(monkeypatch):
    assert solved(monkeypatch, 1.0, 1e-3, 1e-9, 1.0).number == 2


def test_the_start_is_never_the_answer(monkeypatch):
    assert solved(monkeypatch, 1e-12, 1e-12).number == 1


def test_cycling_just_above_the_tolerance_is_accepted_at_its_best_and_costs_all_iterations(monkeypatch):
    found = solved(monkeypatch, 1.0, *[4e-6, 5e-8] * 10, iterations=14)
    assert found.norms[0] == pytest.approx(5e-8)
    assert found.number == 14, "an expensive increment, so that the next is no larger"


def test_far_from_equilibrium_is_a_failure_that_says_how_far(monkeypatch):
    with pytest.raises(ConvergenceError, match=r"2\.0e-06 of the weight after 14 iterations"):
        solved(monkeypatch, 1.0, 3e-6, 2e-6, 5e-6, iterations=14)


def test_nan_ends_the_search_at_once(monkeypatch):
    with pytest.raises(ConvergenceError):
        solved(monkeypatch, 1.0, float("nan"))


def test_rounding_bounds_what_can_be_asked_for(monkeypatch):
    assert solved(monkeypatch, 1.0, 3e-7, rounding=4e-7).number == 1
