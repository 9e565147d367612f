"""The comparison with stored curves refuses what it is there to refuse."""

from __future__ import annotations

import numpy as np
import pytest

from tests.regression.stored_curves import (
    COMPARED,
    REPRODUCED,
    libraries,
    refuse_another_curve,
    refuse_another_row,
)

RISE = np.linspace(0.0, 1.0, 41)
PEAK, STIFFNESS, LARGEST = 6e3, 2e7, 0.02
"""N, N/m, m"""


def curve(factor=1.0):
    """A wall that is elastic, then yields, up to 20 mm."""
    rows = np.zeros(len(RISE), [(name, float) for name in COMPARED])
    rows["control_displacement_m"] = LARGEST * RISE**2
    rows["base_shear_N"] = factor * np.minimum(STIFFNESS * LARGEST * RISE**2, PEAK)
    rows["load_multiplier"] = rows["base_shear_N"] / 22e3
    rows["internal_energy_J"] = rows["dissipated_energy_J"] = RISE
    return rows


def test_the_same_curve_passes():
    refuse_another_curve(curve(), curve(), "macro")
    refuse_another_row(curve(), curve(1.0 + REPRODUCED / 2), "macro")


@pytest.mark.parametrize("name", COMPARED)
def test_one_value_that_is_off_by_two_millionths_of_the_largest_is_refused(name):
    found = curve()
    found[name][7] += 2 * REPRODUCED * found[name].max()
    refuse_another_curve(curve(), found, "macro")
    with pytest.raises(AssertionError, match=f"row 7: {name}"):
        refuse_another_row(curve(), found, "macro")


def test_another_number_of_rows_is_refused():
    with pytest.raises(AssertionError, match="40 rows, stored 41"):
        refuse_another_row(curve(), curve()[:-1], "macro")


@pytest.mark.parametrize("factor", [0.98, 1.02])
def test_another_peak_is_refused_on_every_processor(factor):
    with pytest.raises(AssertionError, match="peak in N"):
        refuse_another_curve(curve(), curve(factor), "macro")


def test_all_libraries_that_compute_are_named():
    assert all(libraries()[name] for name in ("numpy", "scipy", "clarabel", "dolfinx", "gmsh", "petsc"))
