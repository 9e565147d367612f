"""How figures and places are printed."""

from __future__ import annotations

import pytest

from orchestrator.basis.printed import as_place


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
