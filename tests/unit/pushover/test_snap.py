"""Overdamped motion to the next state of rest, of one point drawn by a spring: every step has a closed form."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest

from orchestrator.errors import ConvergenceError
from orchestrator.pushover.settings import SteppingSettings
from orchestrator.pushover.snap import rest_after_snap
from orchestrator.pushover.state import Attempt
from orchestrator.pushover.stepping import refuse_jump

SPRING, MASS, REST = 1e6, 100.0, 5e-3
MODEL = SimpleNamespace(tracking=None, contact_stiffness=1e9, weight=1e4)
FAILURE = ConvergenceError("Newton", "no state near", 14)


@dataclass(frozen=True)
class Point:
    displacement: np.ndarray
    mean_displacement: float = 0.0
    iterations: int = 3
    number: int = 7
    base_shear: float = 1.0
    largest_base_shear: float = 2.0
    attempts: tuple[Attempt, ...] = ()


@dataclass(frozen=True)
class Asked:
    viscosity: float
    time_step: float = 0.02
    mean_displacement: float = 1e-6


def at(x: float) -> Point:
    return Point(np.array([[x, 0.0, 0.0]]))


def followed(static_reach: float, longest_step: float = np.inf, proximal_time: float = 1.0):
    """Return where the point rests, and the (viscosity, time step) of every solution that was asked for."""
    asked = []

    def solve(state, problem, predicted):
        asked.append((problem.viscosity, problem.time_step))
        x = state.displacement[0, 0]
        resistance = problem.viscosity + (MASS / problem.time_step**2 if problem.viscosity else 0.0)
        step = SPRING * (REST - x) / (SPRING + resistance)
        if step > (longest_step if problem.viscosity else static_reach):
            raise ConvergenceError("Newton", "too far", 14)
        return replace(state, displacement=state.displacement + [[step, 0.0, 0.0]])

    settings = SteppingSettings(proximal_time=proximal_time)
    end = rest_after_snap(MODEL, settings, at(0.0), lambda _, viscosity=0.0: Asked(viscosity), solve, FAILURE)
    return end, asked


@pytest.mark.parametrize("longest_step", [np.inf, 5e-4])
def test_the_point_comes_to_rest_where_the_spring_is_slack(longest_step):
    end, asked = followed(1e-4, longest_step)
    assert end.displacement[0, 0] == pytest.approx(REST, abs=1e-9)
    assert (end.number, end.largest_base_shear) == (8, 2.0)
    assert end.attempts[0].action == "followed a snap"
    assert end.attempts[0].iterations >= 14 + 3 * (len(asked) - 1) - 3
    assert len(asked) < 40


def test_mass_holds_back_less_as_viscosity_does():
    """The time step grows with the root of 1 / viscosity, up to the proximal time."""
    _, asked = followed(1e-4, proximal_time=0.1)
    viscosity, time_step = np.array([pair for pair in asked if pair[0] > 0.0]).T
    expected = np.minimum(0.02 * np.sqrt(viscosity[0] / viscosity), 0.1)
    assert len(viscosity) > 5
    assert time_step == pytest.approx(expected)
    assert time_step[0] == 0.02
    assert time_step[-1] == 0.1


def test_no_state_of_rest_is_a_failure_that_counts_its_iterations():
    with pytest.raises(ConvergenceError, match="no state of rest after a snap") as failed:
        followed(-1.0)
    assert failed.value.iterations > 14


def test_an_increment_that_ends_far_from_where_it_was_expected_is_refused():
    """0.01 mm expected, 1 mm found."""
    start, near, far = at(0.0), replace(at(2e-5), mean_displacement=1e-6), replace(at(1e-3), mean_displacement=1e-6)
    predicted = np.array([1e-5, 0.0, 0.0])
    refuse_jump(start, near, predicted)
    with pytest.raises(ConvergenceError, match=r"0\.99 mm away"):
        refuse_jump(start, far, predicted)
