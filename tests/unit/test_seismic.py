"""Spectra at their corners, and the examples worked by hand in docs/seismic.md."""

from __future__ import annotations

from math import atan, pi, sqrt

import numpy as np
import pytest

from orchestrator.capacity import Bilinear
from orchestrator.errors import CaseError
from orchestrator.seismic import (
    SeismicSettings,
    Spectrum,
    demand,
    equivalent_system,
    kinematics,
    largest_ground_acceleration,
    secant_period,
    spectrum_of,
)

AG = 0.15 * 9.81
TYPE_1_B = SeismicSettings(AG, "ec8_type1", "B")
BLOCK = np.array([[0.5, 0.25, -1.0]])
"""a block of 0.5 m x 1 m turning clockwise about its lower right corner"""


@pytest.mark.parametrize(
    ("period", "shape"), [(0.0, 1.0), (0.15, 2.5), (0.3, 2.5), (0.5, 2.5), (1.0, 1.25), (2.0, 0.625), (4.0, 0.15625)]
)
def test_spectrum_of_en_1998_1_at_its_corners(period, shape):
    assert spectrum_of(TYPE_1_B, AG).acceleration(period) == pytest.approx(AG * 1.2 * shape)


def test_type_2_ground_d_and_damping():
    found = spectrum_of(SeismicSettings(1.0, "ec8_type2", "D", damping=0.1), 1.0)
    assert (found.soil_factor, found.period_b, found.period_c, found.period_d) == (1.8, 0.1, 0.3, 1.2)
    assert found.damping_factor == pytest.approx(sqrt(10 / 15))
    assert spectrum_of(SeismicSettings(1.0, damping=0.5), 1.0).damping_factor == 0.55


def test_spectrum_of_ntc_2018_by_hand():
    """Subsoil C, a_g = 0.2 g, F_0 = 2.4, T_C* = 0.3 s: S_S = 1.7 - 0.6 x 2.4 x 0.2, C_C = 1.05 x 0.3^-0.33."""
    settings = SeismicSettings(1.962, "ntc2018", "C", amplification=2.4, reference_period=0.3)
    found = spectrum_of(settings, 1.962)
    assert found.soil_factor == pytest.approx(1.412)
    assert found.period_c == pytest.approx(0.46866, abs=2e-5)
    assert found.period_b == pytest.approx(found.period_c / 3)
    assert found.period_d == pytest.approx(2.4)
    assert found.acceleration(0.0) == pytest.approx(1.962 * 1.412)
    assert found.acceleration(0.3) == pytest.approx(1.962 * 1.412 * 2.4)
    assert found.acceleration(1.2) == pytest.approx(1.962 * 1.412 * 2.4 * found.period_c / 1.2)


@pytest.mark.parametrize(("share", "soil"), [(0.05, 1.5), (0.2, 1.412), (0.6, 1.0)])
def test_soil_factor_of_ntc_2018_stays_within_its_bounds(share, soil):
    settings = SeismicSettings(1.0, "ntc2018", "C", amplification=2.4, reference_period=0.3)
    assert spectrum_of(settings, 9.81 * share).soil_factor == pytest.approx(soil)


@pytest.mark.parametrize(
    ("settings", "key"),
    [
        (SeismicSettings(1.0, "ntc2018"), "seismic.reference_period"),
        (SeismicSettings(1.0, "parameters", soil_factor=1.2), "seismic.period_b"),
        (
            SeismicSettings(1.0, "parameters", soil_factor=1.2, period_b=0.5, period_c=0.2, period_d=2.0),
            "seismic.period_c",
        ),
    ],
)
def test_a_spectrum_that_lacks_a_setting_names_it(settings, key):
    with pytest.raises(CaseError) as caught:
        spectrum_of(settings, 1.0)
    assert caught.value.key == key


# docs/seismic.md, the N2 demand

LINE = Bilinear(2e7, 80e3, 4e-3, 20e-3, dropped=True)


def three_masses(load):
    return equivalent_system(20e3 * np.eye(3), np.array([1, 2, 3]) / 3, np.array(load), np.ones(3))


CLAUSE, UNIFORM = three_masses([1.0, 2.0, 3.0]), three_masses([1.0, 1.0, 1.0])
"""loads m phi, as Annex B has them, and loads proportional to mass, as the pushover has them"""


def test_equivalent_system_of_three_masses():
    for system in (CLAUSE, UNIFORM):
        assert system.mass == pytest.approx(40e3)
        assert system.gamma == pytest.approx(9 / 7)
        assert system.effective_mass == pytest.approx(6 / 7)
    assert CLAUSE.force_share == pytest.approx(1 / CLAUSE.gamma), "F* = V / Gamma of EN 1998-1 B.4"
    assert UNIFORM.force_share == pytest.approx(2 / 3)


def test_demand_by_hand():
    found = demand(spectrum_of(TYPE_1_B, AG), LINE, CLAUSE)
    assert found.period == pytest.approx(0.2810, abs=5e-5)
    assert found.force_ratio == pytest.approx(2.838, abs=5e-4)
    assert found.displacement == pytest.approx(13.29e-3, abs=5e-6)


def test_demand_by_hand_under_a_load_proportional_to_mass():
    found = demand(spectrum_of(TYPE_1_B, AG), LINE, UNIFORM)
    assert found.period == pytest.approx(0.3035, abs=5e-5)
    assert found.force_ratio == pytest.approx(3.311, abs=5e-4)
    assert found.displacement == pytest.approx(14.955e-3, abs=5e-6)


def test_capacity_in_terms_of_ground_acceleration_by_hand():
    def capacity(system):
        limit = 20e-3 / system.gamma
        return largest_ground_acceleration(
            lambda ground: demand(spectrum_of(TYPE_1_B, ground), LINE, system).displacement <= limit
        )

    assert capacity(CLAUSE) == pytest.approx(1.684, abs=5e-4)
    assert capacity(CLAUSE) / AG == pytest.approx(1.1445, abs=5e-4)
    assert capacity(UNIFORM) == pytest.approx(1.5235, abs=5e-4)


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
        return demand(spectrum_of(TYPE_1_B, AG), line, system).period

    system = equivalent_system(matrix, shape, one, one)
    period = period_of(system)
    assert (system.gamma, system.mass / mass) == (pytest.approx(1.25, rel=1e-4), pytest.approx(2 / 3, rel=1e-4))
    assert system.effective_mass == pytest.approx(5 / 6, rel=1e-4)
    assert period == pytest.approx(2 * pi * height / (sqrt(2.5) * speed), rel=1e-4)
    assert period == pytest.approx(exact, rel=0.01)
    assert period_of(equivalent_system(matrix, one, one, one)) == pytest.approx(1.111 * exact, rel=2e-3)
    assert period_of(equivalent_system(matrix, shape, shape, one)) == pytest.approx(0.907 * exact, rel=2e-3)


def test_equal_displacements_beyond_the_plateau_and_in_the_elastic_range():
    spectrum, one = Spectrum(1.0, 1.0, 0.1, 0.2, 2.0, 2.5, 1.0), np.ones(1)
    rigid = equivalent_system(np.diag([1e4]), one, one, one)
    soft = demand(spectrum, Bilinear(4e4 * pi**2, 1e2 * pi**2, 2.5e-3, 1.0, dropped=True), rigid)  # T* = 1 s
    assert soft.period == pytest.approx(1.0)
    assert soft.force_ratio > 1.0
    assert soft.displacement == pytest.approx(spectrum.displacement(1.0))
    strong = demand(spectrum, Bilinear(1e8, 1e6, 1e-2, 1.0, dropped=True), rigid)
    assert strong.displacement == pytest.approx(spectrum.displacement(strong.period))


# docs/seismic.md, a block that rocks


def test_rocking_block_by_hand():
    found = kinematics(0.5, np.array([10e3]), BLOCK, 1, 1.35)
    assert found.participation == pytest.approx(1.0)
    assert found.acceleration == pytest.approx(3.633, abs=5e-4)
    assert found.displacement == pytest.approx(0.25)
    ultimate, secant, period = secant_period(found)
    assert (ultimate, secant) == (pytest.approx(0.1), pytest.approx(0.04))
    assert period == pytest.approx(0.7193, abs=5e-5)
    assert spectrum_of(TYPE_1_B, AG).displacement(period) == pytest.approx(0.04022, abs=5e-6)
    capacity = largest_ground_acceleration(lambda a: spectrum_of(TYPE_1_B, a).displacement(period) <= ultimate)
    assert capacity / AG == pytest.approx(2.4865, abs=5e-4)


def test_mirrored_and_faster_mechanisms_have_the_same_capacity():
    mirrored = kinematics(0.5, np.array([10e3]), 7.0 * BLOCK * [-1, 1, -1], -1, 1.35)
    assert mirrored.acceleration == pytest.approx(0.5 * 9.81 / 1.35)
    assert mirrored.displacement == pytest.approx(0.25)


def test_participation_of_two_blocks_that_turn_as_one():
    """Two blocks of equal weight, one on the other, about one corner: delta = 1, 3; M* g = (1 + 3)^2 / (1 + 9) P."""
    velocities = np.array([[1.0, 0.5, -1.0], [3.0, 0.5, -1.0]])
    found = kinematics(0.25, np.full(2, 5e3), velocities, 1, 1.0)
    assert found.participation == pytest.approx(1.6 / 2)
    assert found.acceleration == pytest.approx(0.25 * 9.81 / 0.8)
    angle = atan(1.0 / 4.0)  # sum(v cos - u sin) = 0
    moved = np.array([1.0, 3.0]) * np.sin(angle) + 0.5 * (1 - np.cos(angle))
    assert found.displacement == pytest.approx((moved @ [1.0, 3.0]) / 4.0)


def test_blocks_at_rest_do_not_count_and_a_sliding_block_has_no_ultimate_displacement():
    found = kinematics(0.65, np.array([10e3, 99e3]), np.array([[1.0, 0.0, 0.0], [1e-9, 0, 0]]), 1, 1.0)
    assert found.participation == pytest.approx(1.0)
    assert found.displacement is None
