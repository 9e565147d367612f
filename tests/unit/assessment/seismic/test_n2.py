"""N2: the examples worked by hand in docs/seismic.md, and the limits of codes by hand."""

from __future__ import annotations

from math import inf, pi, sqrt

import numpy as np
import pytest

from orchestrator.assessment.capacity import Bilinear
from orchestrator.assessment.seismic.n2 import (
    demand,
    displacement_at_force_ratio,
    displacement_of_curve,
    equivalent_system,
    largest_ground_acceleration,
)
from orchestrator.assessment.seismic.spectrum import Spectrum

AG = 0.15 * 9.81
LINE = Bilinear(2e7, 80e3, 4e-3, 20e-3, dropped=True)


def type_1_b(ground=AG):
    return Spectrum(ground, 1.2, 0.15, 0.5, 2.0, 2.5, 1.0)


def three_masses(load):
    return equivalent_system(20e3 * np.eye(3), np.array([1, 2, 3]) / 3, np.array(load), np.ones(3))


CLAUSE, UNIFORM = three_masses([1.0, 2.0, 3.0]), three_masses([1.0, 1.0, 1.0])
"""loads m phi, as Annex B has them, and loads proportional to mass, as the pushover has them"""


def test_equivalent_system_of_three_masses():
    for system in (CLAUSE, UNIFORM):
        assert system.mass == pytest.approx(40e3)
        assert system.gamma == pytest.approx(9 / 7)
        assert system.effective_mass == pytest.approx(6 / 7)
    assert CLAUSE.force_share == pytest.approx(7 / 9), "F* = V / Gamma of EN 1998-1 B.4"
    assert UNIFORM.force_share == pytest.approx(2 / 3)


def test_demand_by_hand():
    found = demand(type_1_b(), LINE, CLAUSE)
    assert found.period == pytest.approx(0.2810, abs=5e-5)
    assert found.force_ratio == pytest.approx(2.838, abs=5e-4)
    assert found.displacement == pytest.approx(13.29e-3, abs=5e-6)


def test_demand_by_hand_under_a_load_proportional_to_mass():
    found = demand(type_1_b(), LINE, UNIFORM)
    assert found.period == pytest.approx(0.3035, abs=5e-5)
    assert found.force_ratio == pytest.approx(3.311, abs=5e-4)
    assert found.displacement == pytest.approx(14.955e-3, abs=5e-6)


@pytest.mark.parametrize(
    ("system", "state", "largest", "governs", "ground", "ratio"),
    [
        (CLAUSE, "NC", inf, 15.556e-3, 1.684, 1.1445),
        (CLAUSE, "SD", inf, 11.667e-3, 1.32035, 0.8973),
        (CLAUSE, "SLV", 3.0, 11.667e-3, 1.32035, 0.8973),
        (CLAUSE, "SLC", 3.0, 14.182e-3, 1.5556, 1.0571),
        (UNIFORM, "NC", inf, 15.556e-3, 1.5235, 1.035),
    ],
)
def test_capacity_by_hand(system, state, largest, governs, ground, ratio):
    """NC: 20 mm / 1.2857 = 5 d_y*, q* = 1 + 4 x 0.2810/0.5 = 3.248; SD: 3.75 d_y*, q* = 1 + 2.75 x 0.2810/0.5 = 2.5455.

    q* = 3: d = d_y* (1 + 2 x 0.5/0.2810) = 4.5587 d_y* = 14.18 mm, and a_g = 1.4715 x 3/2.838.
    """
    of_curve = displacement_of_curve(state, LINE, at_peak=3e-3) / system.gamma
    capacity = min(of_curve, displacement_at_force_ratio(largest, type_1_b(), LINE, system))
    assert capacity == pytest.approx(governs, rel=2e-4)
    found = largest_ground_acceleration(lambda a: demand(type_1_b(a), LINE, system).displacement <= capacity)
    assert found == pytest.approx(ground, rel=4e-4)
    assert found / AG == pytest.approx(ratio, rel=4e-4)


def test_displacements_of_a_curve_at_every_limit_state():
    """C7.8.1.5.4: SLC at the drop, SLV 3/4 of it, SLD at yield or at the peak; EN 1998-3: DL at yield, SD 3/4 of NC."""
    assert displacement_of_curve("SLD", LINE, at_peak=3e-3) == pytest.approx(3e-3)
    found = {state: displacement_of_curve(state, LINE, 6e-3) for state in ("SLD", "SLV", "SLC", "DL", "SD", "NC")}
    assert found == pytest.approx({"SLD": 4e-3, "SLV": 15e-3, "SLC": 20e-3, "DL": 4e-3, "SD": 15e-3, "NC": 20e-3})


def test_force_ratio_of_a_long_period_is_ductility():
    soft = Bilinear(4e4, 800.0, 0.02, 0.2, dropped=True)
    one = equivalent_system(np.diag([1e4]), np.ones(1), np.ones(1), np.ones(1))  # T* = pi s
    assert displacement_at_force_ratio(3.0, type_1_b(), soft, one) == pytest.approx(0.06)


def test_period_of_a_shear_wall_is_rayleigh_s():
    """A cantilever that shears (wave speed c), under its own mass: phi = 2 y/H - (y/H)^2, omega^2 = 2.5 (c/H)^2.

    Exact: omega = pi c / 2 H. m* = 2/3 M, sum(m phi^2) = 8/15 M, so Gamma = 5/4. With phi = 1 the period would be 11 %
    too long, with F* = V/Gamma under this load 9 % too short.
    """
    height, speed, mass, count = 3.0, 200.0, 9e3, 400
    level = height * (np.arange(count) + 0.5) / count
    shape = 2.0 * (level / height) * (1.0 - 0.5 * level / height)
    matrix = np.diag(np.full(count, mass / count))
    stiffness = 2.0 * mass * speed**2 / height**2  # V / u(H) = M a / (a H^2 / 2 c^2)
    line = Bilinear(stiffness, 1e-2 * stiffness, 1e-2, 1.0, dropped=True)
    one, exact = np.ones(count), 4.0 * height / speed

    def period_of(system):
        return demand(type_1_b(), line, system).period

    system = equivalent_system(matrix, shape, one, one)
    assert (system.gamma, system.mass / mass) == (pytest.approx(1.25, rel=1e-4), pytest.approx(2 / 3, rel=1e-4))
    assert system.effective_mass == pytest.approx(5 / 6, rel=1e-4)
    assert period_of(system) == pytest.approx(2 * pi * height / (sqrt(2.5) * speed), rel=1e-4)
    assert period_of(system) == pytest.approx(exact, rel=0.01)
    assert period_of(equivalent_system(matrix, one, one, one)) == pytest.approx(1.111 * exact, rel=2e-3)
    assert period_of(equivalent_system(matrix, shape, shape, one)) == pytest.approx(0.907 * exact, rel=2e-3)


def test_equal_displacements_beyond_the_plateau_and_in_the_elastic_range():
    spectrum, one = Spectrum(1.0, 1.0, 0.1, 0.2, 2.0, 2.5, 1.0), np.ones(1)
    rigid = equivalent_system(np.diag([1e4]), one, one, one)
    soft = demand(spectrum, Bilinear(4e4 * pi**2, 1e2 * pi**2, 2.5e-3, 1.0, dropped=True), rigid)  # T* = 1 s
    assert soft.period == pytest.approx(1.0)
    assert soft.force_ratio > 1.0
    assert soft.displacement == pytest.approx(2.5 * 0.2 / 1.0 / (4 * pi**2))
    strong = demand(spectrum, Bilinear(1e8, 1e6, 1e-2, 1.0, dropped=True), rigid)  # T* = 0.0628 s
    assert strong.displacement == pytest.approx((1 + 0.62832 * 1.5) * 1e-4, rel=1e-4)
