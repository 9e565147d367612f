"""Capacity from synthetic curves whose answers are known by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from orchestrator.assessment.capacity import find_capacity, idealise, initial_stiffness, peak_reached
from orchestrator.basis.errors import ResultError
from orchestrator.pushover.increments import PushoverCurve

WEIGHT = 1000.0


def curve(displacement, base_shear, **changed):
    """A curve whose multiplier balances its base shear exactly; static throughout."""
    rows = len(displacement)
    shear = np.array(base_shear, dtype=float)
    counts = np.zeros(rows, dtype=np.int64)
    made = PushoverCurve(
        step=np.arange(5, 5 + rows),
        time_s=np.arange(rows, dtype=float),
        load_multiplier=shear / WEIGHT,
        base_shear_N=shear,
        horizontal_load_N=np.full(rows, WEIGHT),
        control_displacement_m=np.array(displacement, dtype=float),
        internal_energy_J=np.ones(rows),
        dissipated_energy_J=np.zeros(rows),
        open_contacts=counts,
        sticking_contacts=counts,
        slipping_contacts=counts,
        newton_iterations=counts,
        out_of_balance=np.zeros(rows),
        moving=counts,
        fallen_bodies=counts,
        stopped_because="displacement reached",
    )
    return replace(made, **changed)


def test_peak_is_the_largest_base_shear_and_displacements_start_from_gravity():
    capacity = find_capacity(curve([0.001, 0.002, 0.004, 0.007, 0.011], [0, 200, 310, 290, 250]))
    assert capacity.peak_base_shear == 310.0
    assert capacity.peak_multiplier == pytest.approx(0.31)
    assert capacity.displacement_at_peak == pytest.approx(0.003)
    assert capacity.final_displacement == pytest.approx(0.010)


def test_a_curve_that_creeps_upwards_has_its_peak_at_the_final_displacement():
    capacity = find_capacity(curve([0, 0.01, 0.02], [0, 295, 297]))
    assert capacity.displacement_at_peak == capacity.final_displacement == 0.02


def test_initial_stiffness_is_the_least_squares_line_of_the_rows_below_a_tenth_of_the_peak():
    # rows below 30 N: (1 mm, 10 N), (2 mm, 18 N), (3 mm, 29 N); k = (10 + 36 + 87) / 14 N/mm
    displacement = np.array([0, 1, 2, 3, 8, 20, 21]) * 1e-3
    shear = np.array([0, 10, 18, 29, 31, 300, 12.0])  # the last row is below a tenth again, after the peak
    assert initial_stiffness(shear, displacement) == pytest.approx(133 / 14 * 1e3, rel=1e-12)


def test_initial_stiffness_takes_two_rows_when_the_first_is_already_beyond_a_tenth():
    # k = (100 * 1 + 150 * 2) / (1 + 4) N/mm
    assert initial_stiffness(np.array([0, 100, 150, 160.0]), np.array([0, 1, 2, 3]) * 1e-3) == pytest.approx(80e3)


def test_initial_stiffness_is_relative_to_the_gravity_row():
    displacement, shear = np.array([0, 1, 2, 3]) * 1e-3, np.array([0, 100, 150, 160.0])
    assert initial_stiffness(shear + 7.0, displacement - 0.5) == pytest.approx(80e3, rel=1e-9)


@pytest.mark.parametrize("moved", [[0, -1, -2, -20], [0, -1, -2, 20]])
def test_a_displacement_against_the_load_gives_no_stiffness(moved):
    """Whatever the curve does later; the base shear that the wall bears is what it is."""
    capacity = find_capacity(curve(moved, [0.0, 100.0, 200.0, 150.0]))
    assert capacity.initial_stiffness is None
    assert (capacity.peak_base_shear, capacity.displacement_at_peak, capacity.peak_reached) == (200.0, -2.0, True)


@pytest.mark.parametrize("moved", [[0, -1, -2, -20], [0, 1, 2, -20]])
def test_a_curve_that_goes_or_ends_against_the_load_has_no_idealisation(moved):
    with pytest.raises(ResultError, match="the control displacement does not go along the live load"):
        idealise(np.array([0.0, 100.0, 200.0, 150.0]), np.array(moved, float))


def test_initial_stiffness_with_a_single_lateral_row_is_its_secant():
    assert initial_stiffness(np.array([0, 100.0]), np.array([0, 2e-3])) == pytest.approx(50e3)


def test_a_row_in_which_the_wall_moves_is_neither_peak_nor_end_nor_out_of_equilibrium():
    """Without the rows in motion: peak 200 N at 2 mm, end 3 mm."""
    displacement, shear = np.array([0, 1, 2, 2.5, 3, 5]) * 1e-3, [0, 100, 200, 900, 180, 170]
    multiplier = np.array([0, 0.1, 0.2, 0.3, 0.18, 0.9])
    made = curve(displacement, shear, load_multiplier=multiplier, moving=np.array([0, 0, 0, 1, 0, 1]))
    capacity = find_capacity(made)
    assert (capacity.peak_base_shear, capacity.peak_multiplier) == (200.0, 0.2)
    assert (capacity.displacement_at_peak, capacity.final_displacement) == pytest.approx((2e-3, 3e-3))
    assert capacity.equilibrium_residual == pytest.approx(0.0, abs=1e-15)
    assert capacity.peak_reached


def test_equilibrium_residual_is_the_largest_difference_along_the_curve_over_the_peak():
    made = curve([0, 1e-3, 2e-3, 3e-3], [0, 100, 300, 200], load_multiplier=np.array([0, 0.101, 0.3, 0.194]))
    assert find_capacity(made).equilibrium_residual == pytest.approx(6 / 300)


def test_what_has_fallen_is_not_pushed():
    """A fifth of the wall has fallen before the last row: 0.25 of 800 N is 200 N."""
    load, multiplier = np.array([1000.0, 1000.0, 800.0]), np.array([0, 0.1, 0.25])
    made = curve([0, 1e-3, 2e-3], [0, 100, 200], load_multiplier=multiplier, horizontal_load_N=load)
    assert find_capacity(made).equilibrium_residual == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize(
    ("made", "said"),
    [
        (curve([0], [0]), "no lateral increment"),
        (curve([0, 1e-3, 2e-3], [0, np.nan, 2]), "not finite in step 6"),
        (curve([1e-3, 1e-3, 1e-3], [0, 1, 2]), "control displacement is zero"),
    ],
)
def test_a_curve_that_cannot_be_read_is_refused(made, said):
    with pytest.raises(ResultError, match=said):
        find_capacity(made)


def test_a_bilinear_curve_is_its_own_idealisation():
    line = idealise(np.array([0.0, 700, 1000, 1000]), np.array([0.001, 0.008, 0.011, 0.031]))
    assert line.stiffness == pytest.approx(1e5)
    assert line.yield_force == pytest.approx(1000.0)
    assert line.yield_displacement == pytest.approx(0.01)
    assert line.ultimate_displacement == pytest.approx(0.03)
    assert not line.dropped


def test_the_idealisation_ends_where_the_base_shear_has_dropped_by_a_fifth_and_encloses_the_same_area():
    shear, moved = np.array([0.0, 100, 100, 60, 20]), np.array([0.0, 1.0, 2.0, 4.0, 6.0])
    line = idealise(shear, moved)
    assert line.dropped
    assert line.ultimate_displacement == pytest.approx(3.0)  # 80 lies midway between 100 at 2 and 60 at 4
    area = 50.0 + 100.0 + 90.0
    assert line.yield_force * (3.0 - 0.5 * line.yield_displacement) == pytest.approx(area)
    assert line.yield_force == pytest.approx(100.0 * line.yield_displacement)


def test_a_curve_that_starts_at_its_peak_has_no_idealisation():
    with pytest.raises(ResultError, match="does not rise"):
        idealise(np.array([10.0, 5.0]), np.array([0.0, 1.0]))


@pytest.mark.parametrize(
    ("displacement", "base_shear", "reached"),
    [
        ([0, 1, 2, 3], [0, 100, 200, 300], False),  # still rising
        ([0, 1, 2, 2.9], [0, 100, 200, 199], False),  # fallen by 0.5 % only, and just past it
        ([0, 1, 2, 3], [0, 100, 200, 198], True),  # fallen by 1 %
        ([0, 1, 2, 3], [0, 100, 200, 200.5], True),  # within 1 % of its peak from 2 on, flat to 3
        ([0, 1, 2, 2.9], [0, 100, 200, 200.5], False),  # flat for less than half as long again
        ([0, 1, 2, 3], [0, 300, 200, 250], True),  # fallen, then rising again below the peak
        ([5, 6, 7, 8], [0, 100, 200, 200.5], True),  # displacements start from gravity
        ([0, -1, -2, -9], [0, 100, 200, 200.5], False),  # the control point runs backwards and says nothing
    ],
)
def test_a_peak_is_one_where_the_curve_falls_or_goes_on_flat(displacement, base_shear, reached):
    assert peak_reached(curve(displacement, base_shear)) is reached
    assert find_capacity(curve(displacement, base_shear)).peak_reached is reached


def test_the_elastic_branch_goes_through_60_per_cent_of_the_peak():
    """0.6 x 1000 lies at 3 mm: 200 kN/m; the areas under curve and bilinear, 22 J, are the same."""
    line = idealise(np.array([0.0, 400, 800, 1000, 1000]), np.array([0, 2e-3, 4e-3, 10e-3, 25e-3]))
    assert line.stiffness == pytest.approx(600 / 3e-3)
    area = 0.4 + 1.2 + 5.4 + 15.0
    assert line.yield_force * (25e-3 - 0.5 * line.yield_displacement) == pytest.approx(area)
