"""How the sequences stop, step back and give up: on toy programs, without linear programs."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from itertools import count
from typing import get_type_hints

import annotated_types
import numpy as np
import pytest

from orchestrator.basis.errors import ConvergenceError
from orchestrator.limit_analysis.paper.linear_program import InfeasibleError, LimitSolution
from orchestrator.limit_analysis.paper.sequence import (
    HALVINGS,
    LimitAnalysisSettings,
    SequenceIterate,
    feasible_iterate,
    sequence_has_settled,
    taken_until,
)
from orchestrator.limit_analysis.paper.yield_conditions import YieldConditions

SETTINGS = LimitAnalysisSettings()
LAW = YieldConditions(np.array([0.5]), np.array([0.0]))


@dataclass
class OneNewton:
    """Stands for an Equilibrium with a mean block weight of 1 N."""

    unit_force: float = 1.0


def solution(load_multiplier, normal=1.0, slip=0.0):
    forces = np.array([[normal, 0.0, 0.0]])
    rates = np.array([[0.0, 0.0, slip]])
    return LimitSolution(load_multiplier, forces, np.zeros(3), rates, 1, 0.0, "Solved")


def iterate(load_multiplier, halvings=0, expected=1.0):
    return SequenceIterate(solution(load_multiplier), 0.1, np.array([expected]), np.array([1.0]), halvings)


@dataclass
class ProgramWithLeastCohesion:
    """Has a solution only for cohesions of at least `least`; remembers what it was asked."""

    least: float
    asked: list = field(default_factory=list)

    def solve(self, cohesion, shift=None):
        self.asked.append(float(cohesion[0]))
        if cohesion[0] < self.least:
            raise InfeasibleError("test", "no")
        return solution(0.3)


def test_taking_stops_when_settled_but_not_before_the_minimum():
    assert taken_until(lambda taken: True, count(), 3, 10) == ([0, 1, 2], True)
    assert taken_until(lambda taken: taken[-1] >= 5, count(), 3, 10) == ([0, 1, 2, 3, 4, 5], True)
    assert taken_until(lambda taken: False, count(), 3, 5) == ([0, 1, 2, 3, 4], False)


def test_settled_means_relative_change():
    assert sequence_has_settled([iterate(0.3), iterate(0.3 * (1 + 0.9e-6))], 1e-6)
    assert not sequence_has_settled([iterate(0.3), iterate(0.3 * (1 + 1.2e-6))], 1e-6)


@pytest.mark.parametrize("halvings", [(1, 0), (0, 1)])
def test_standing_still_by_stepping_back_is_not_settled(halvings):
    before, last = halvings
    assert not sequence_has_settled([iterate(0.3, before), iterate(0.3, last)], 1e-6)


def test_infeasible_program_is_retried_halfway_back():
    """Expected 0 N against 8 N that had a solution: c = 1.01 mu N = 0, 2.02, 3.03 N ...; 3 N is enough."""
    program = ProgramWithLeastCohesion(3.0)
    found = feasible_iterate(program, OneNewton(), LAW, iterate(0.2, expected=8.0), np.array([0.0]), 0.0, SETTINGS)
    assert program.asked == pytest.approx([0.0, 2.02, 3.03])
    assert found.halvings == 2
    assert found.expected_normal == pytest.approx([6.0])


def test_hopeless_program_raises_after_all_halvings():
    program = ProgramWithLeastCohesion(1e9)
    with pytest.raises(ConvergenceError):
        feasible_iterate(program, OneNewton(), LAW, iterate(0.2), np.array([0.0]), 0.0, SETTINGS)
    assert len(program.asked) == HALVINGS + 1


def test_seed_reaches_the_program():
    program = ProgramWithLeastCohesion(0.0)
    feasible_iterate(program, OneNewton(), LAW, iterate(0.2), np.array([2.0]), 0.25, SETTINGS)
    assert program.asked == pytest.approx([1.01 * 0.5 * 2.0 + 0.25])


def test_every_number_that_can_be_set_has_a_bound():
    hints = get_type_hints(LimitAnalysisSettings, include_extras=True)
    bounds = (annotated_types.Gt, annotated_types.Ge, annotated_types.MinLen)
    for setting in fields(LimitAnalysisSettings):
        if hints[setting.name] is bool:
            continue
        assert any(isinstance(mark, bounds) for mark in hints[setting.name].__metadata__), setting.name
