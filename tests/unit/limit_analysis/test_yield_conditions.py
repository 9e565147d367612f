"""Friction lines: Coulomb, Eq. (2), and the rows handed to the linear program."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orchestrator.limit_analysis.paper.yield_conditions import (
    CHORDS,
    YieldConditions,
    falling_line,
    relaxed_normal,
    yield_matrix,
    yield_offset,
)

LAW = YieldConditions(np.array([0.65, 0.3]), np.array([0.0, 10.0]))


def test_excess_names_the_worst_violation():
    assert LAW.excess(np.array([[50.0, 50.0, 65.0], [0.0, 100.0, -40.0]])) == pytest.approx(0.0, abs=1e-12)
    assert LAW.excess(np.array([[50.0, 50.0, -66.0], [0.0, 100.0, 0.0]])) == pytest.approx(1.0)
    assert LAW.excess(np.array([[50.0, 50.0, 0.0], [-3.0, 100.0, 0.0]])) == pytest.approx(3.0)


@given(
    normal=st.floats(0, 1e4),
    expected=st.floats(0, 1e4),
    alpha=st.floats(1e-3, 0.5),
    mu=st.floats(0.1, 1.0),
    cohesion=st.floats(0, 100),
)
def test_falling_line_meets_coulomb_at_the_expected_normal_force(normal, expected, alpha, mu, cohesion):
    """Eq. (2): equal resistance at N_expected, less than Coulomb beyond it, more below, and falling everywhere."""
    law = YieldConditions(np.array([mu]), np.array([cohesion]))
    line = falling_line(law, np.array([expected]), alpha, 0.0)

    def resistance(conditions, n):
        return (conditions.slope * n + conditions.cohesion)[0]

    assert resistance(line, expected) == pytest.approx(resistance(law, expected), rel=1e-12, abs=1e-9)
    assert line.slope[0] < 0
    difference = resistance(law, normal) - resistance(line, normal)
    assert difference * (normal - expected) >= -1e-6


def test_seed_adds_to_the_falling_line():
    bare, seeded = (falling_line(LAW, np.array([5.0, 7.0]), 0.01, seed) for seed in (0.0, 2.5))
    assert seeded.cohesion - bare.cohesion == pytest.approx([2.5, 2.5])


def test_relaxation_weighs_the_last_iterate_by_beta():
    assert relaxed_normal(np.array([10.0]), np.array([20.0]), 0.6) == pytest.approx([14.0])


@given(forces=st.lists(st.floats(-10, 10), min_size=6, max_size=6))
def test_rows_are_non_negative_exactly_inside_the_cone(forces):
    forces = np.array(forces)
    rows = yield_matrix(LAW) @ forces + yield_offset(LAW)
    assert max(0.0, -rows.min()) == pytest.approx(LAW.excess(forces.reshape(2, 3)), abs=1e-9)


def test_rows_at_slope_zero_keep_the_shear():
    law = YieldConditions(np.array([0.0]), np.array([5.0]))
    rows = yield_matrix(law) @ np.array([1.0, 2.0, 4.0]) + yield_offset(law)
    assert rows.tolist() == [1.0, 2.0, 1.0, 9.0]


CRUSHING = YieldConditions(
    np.array([100.0]), np.array([1e9]), np.array([30.0]), np.array([970.0]), chords=np.ones(CHORDS, bool)
)
BEGUN = YieldConditions(CRUSHING.slope, CRUSHING.cohesion, CRUSHING.tension, CRUSHING.crushing)


def least_row(conditions, forces):
    return (yield_matrix(conditions) @ forces + yield_offset(conditions)).min()


@given(part=st.floats(1e-6, 1.0), eccentricity=st.floats(-0.4995, 0.4995))
def test_chords_of_crushing_lose_less_than_a_thousandth_of_the_moment(part, eccentricity):
    """At N + T = part x 1000 N, |M|/L = (N + T)/2 (1 - part) is the limit; 99.9 % of it and less must pass."""
    shifted = part * 1000.0
    moment = shifted * (1.0 - part) * eccentricity
    forces = np.array([0.5 * (shifted - 30.0) - moment, 0.5 * (shifted - 30.0) + moment, 0.0])
    assert least_row(CRUSHING, forces) > -1e-9
    assert CRUSHING.with_chords_at(forces[None]) is CRUSHING


@given(part=st.floats(1e-8, 1e-3))
def test_chords_of_crushing_lose_little_where_crushing_takes_little(part):
    """Crushing takes `part` of the moment, chords at most five times as much more."""
    shifted = part * 1000.0
    moment = shifted * (1.0 - part) * 0.5 * (1.0 - 5.0 * part)
    forces = np.array([0.5 * (shifted - 30.0) - moment, 0.5 * (shifted - 30.0) + moment, 0.0])
    assert least_row(CRUSHING, forces) > -1e-12


@given(forces=st.lists(st.floats(-100, 1100), min_size=2, max_size=2))
def test_chords_of_crushing_are_on_the_safe_side(forces):
    forces = np.array([*forces, 0.0])
    if least_row(CRUSHING, forces) >= 0.0:
        assert CRUSHING.excess(forces[None]) < 1e-9


@given(forces=st.lists(st.floats(0, 1100), min_size=2, max_size=2))
def test_forces_that_ask_for_no_chord_respect_them_all(forces):
    """Rows begun with, and those asked for, say of forces what all rows say."""
    forces = np.array([*forces, 0.0])
    asked = BEGUN.with_chords_at(forces[None])
    assert (least_row(asked, forces) < 0.0) == (least_row(CRUSHING, forces) < 0.0)
    assert asked.with_chords_at(forces[None]) is asked
