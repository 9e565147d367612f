"""How figures and places are printed."""

from __future__ import annotations

import pytest

from orchestrator.basis.printed import as_place, printed


@pytest.mark.parametrize(
    ("place", "said"),
    [
        ((1.70619, 1.81904), "(1.706, 1.819)"),
        ((0.0404, -0.01), "(0.0404, -0.01)"),
        ((5432.1234, 10.0), "(5432.123, 10)"),
        ((1e6 + 0.5, -999.9996), "(1000000.5, -1000)"),
    ],
)
def test_places_have_four_digits_and_millimetres_far_from_the_origin(place, said):
    assert as_place(*place) == said


@pytest.mark.parametrize(
    ("newtons", "said"), [(0.0045, "4.500e-06"), (12.0, "0.012"), (-0.5, "-0.0005000"), (0.0, "0.000")]
)
def test_a_small_weight_has_digits_of_its_own(newtons, said):
    assert printed("weight", newtons) == said
