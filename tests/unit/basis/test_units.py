from __future__ import annotations

import pytest

from orchestrator.basis.units import Unit, quantity


@pytest.mark.parametrize(
    ("unit", "text", "value"),
    [
        ("m", "450 mm", 0.45),
        ("m", "1.5e2cm", 1.5),
        ("m", 3, 3.0),
        ("N/m3", "25 kN/m3", 25e3),
        ("Pa", "3.5 GPa", 3.5e9),
        ("Pa", "2 N/mm2", 2e6),
        ("s", "50 ms", 0.05),
        ("s", "2 min", 120),
        ("1/s", "0.3 1/s", 0.3),
        ("m", "-.5km", -500),
        ("m", " 2. m ", 2),
        ("Pa", "20 kPa", 2e4),
        ("Pa", "20 kN/m2", 2e4),
        ("Pa", "3500 MPa", 3.5e9),
        ("Pa", "7 N/m2", 7),
        ("N/m3", "0.025 MN/m3", 25e3),
        ("N/m3", "7 N/m3", 7),
    ],
)
def test_quantities_become_si(unit, text, value):
    assert Unit(unit).parse(text) == pytest.approx(value)


@pytest.mark.parametrize(
    "text", ["3 kN", "3", "3 furlong", "mm", "", "three mm", True, None, [1], float("nan"), "nan m"]
)
def test_anything_else_is_refused_with_a_remedy(text):
    with pytest.raises(ValueError, match=r"; (use one of m, mm|write)"):
        Unit("m").parse(text)


def test_a_unit_of_another_kind_is_named_with_those_that_fit():
    with pytest.raises(ValueError, match=r"^unit 'kPa' does not fit; use one of N/m3, kN/m3, MN/m3, GN/m3, N/mm3$"):
        Unit("N/m3").parse("25 kPa")


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (3.5e9, "Pa", "3.5 GPa"),
        (1e-5, "m", "0.01 mm"),
        (0.45, "m", "0.45 m"),
        (0.0, "rad", "0 rad"),
        (1 / 3, "m", None),
    ],
)
def test_a_value_is_stated_so_that_it_reads_back_as_it_is(value, unit, text):
    stated = quantity(value, unit)
    assert Unit(unit).parse(stated) == value
    assert text is None or stated == text
