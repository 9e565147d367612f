"""Spectra at their corners, tables of constants, floor spectra by hand, and what settings are refused."""

from __future__ import annotations

from dataclasses import replace
from math import sqrt

import pytest

from orchestrator.assessment.seismic.settings import (
    LimitStateSettings,
    SeismicSettings,
    largest_force_ratio,
    limit_states,
    refuse_building,
)
from orchestrator.assessment.seismic.spectrum import EC8_GROUND, NTC_PERIOD, NTC_SOIL, spectrum_at_height, spectrum_of
from orchestrator.basis.errors import CaseError

AG = 0.15 * 9.81
TYPE_1_B = SeismicSettings(AG, spectrum="ec8_type1", ground="B")


def of(settings, ground=None, damping=0.05):
    (state,) = limit_states(settings)
    return spectrum_of(settings, state, ground or state.peak_ground_acceleration, damping)


@pytest.mark.parametrize(
    ("period", "shape"), [(0.0, 1.0), (0.15, 2.5), (0.3, 2.5), (0.5, 2.5), (1.0, 1.25), (2.0, 0.625), (4.0, 0.15625)]
)
def test_spectrum_of_en_1998_1_at_its_corners(period, shape):
    assert of(TYPE_1_B).acceleration(period) == pytest.approx(AG * 1.2 * shape)


def test_the_topographic_factor_multiplies_s_of_en_1998_1_too():
    """EN 1998-5 Annex A: 1.4 on a ridge; S = 1.2 x 1.4 on ground B."""
    assert of(replace(TYPE_1_B, topography=1.4)).peak_acceleration == pytest.approx(AG * 1.2 * 1.4)


def test_constants_of_en_1998_1_tables_3_2_and_3_3():
    """As printed: ground, S, T_B, T_C, T_D."""
    type_1 = "A 1.0 0.15 0.4 2.0 B 1.2 0.15 0.5 2.0 C 1.15 0.20 0.6 2.0 D 1.35 0.20 0.8 2.0 E 1.4 0.15 0.5 2.0"
    type_2 = "A 1.0 0.05 0.25 1.2 B 1.35 0.05 0.25 1.2 C 1.5 0.10 0.25 1.2 D 1.8 0.10 0.30 1.2 E 1.6 0.05 0.25 1.2"
    for name, printed in (("ec8_type1", type_1), ("ec8_type2", type_2)):
        cells = printed.split()
        rows = {cells[k]: tuple(map(float, cells[k + 1 : k + 5])) for k in range(0, 25, 5)}
        assert EC8_GROUND[name] == rows


def test_constants_of_ntc_2018_table_3_2_iv():
    """As printed: S_S between its bounds, and C_C."""
    assert NTC_SOIL == {
        "A": (1.00, 0.00, 1.00, 1.00), "B": (1.40, 0.40, 1.00, 1.20), "C": (1.70, 0.60, 1.00, 1.50),
        "D": (2.40, 1.50, 0.90, 1.80), "E": (2.00, 1.10, 1.00, 1.60),
    }  # fmt: skip
    assert NTC_PERIOD == {
        "A": (1.00, 0.0), "B": (1.10, 0.20), "C": (1.05, 0.33), "D": (1.25, 0.50), "E": (1.15, 0.40),
    }  # fmt: skip


def test_damping():
    assert of(TYPE_1_B, damping=0.1).damping_factor == pytest.approx(sqrt(10 / 15))
    assert of(TYPE_1_B, damping=0.5).damping_factor == 0.55


def test_spectrum_of_ntc_2018_by_hand():
    """Subsoil C, a_g = 0.2 g, F_0 = 2.4, T_C* = 0.3 s: S_S = 1.7 - 0.6 x 2.4 x 0.2, C_C = 1.05 x 0.3^-0.33."""
    found = of(SeismicSettings(1.962, spectrum="ntc2018", ground="C", amplification=2.4, reference_period=0.3))
    assert found.soil_factor == pytest.approx(1.412)
    assert found.period_c == pytest.approx(0.46866, abs=2e-5)
    assert found.period_b == pytest.approx(0.46866 / 3, abs=1e-5)
    assert found.period_d == pytest.approx(2.4)
    assert found.acceleration(0.0) == pytest.approx(1.962 * 1.412)
    assert found.acceleration(0.3) == pytest.approx(1.962 * 1.412 * 2.4)
    assert found.acceleration(1.2) == pytest.approx(1.962 * 1.412 * 2.4 * 0.46866 / 1.2, rel=5e-5)


@pytest.mark.parametrize(("share", "soil"), [(0.05, 1.5), (0.2, 1.412), (0.6, 1.0)])
def test_soil_factor_of_ntc_2018_stays_within_its_bounds(share, soil):
    settings = SeismicSettings(1.0, spectrum="ntc2018", ground="C", amplification=2.4, reference_period=0.3)
    assert of(settings, 9.81 * share).soil_factor == pytest.approx(soil)


def test_floor_spectrum_by_hand():
    """docs/seismic.md: z = 6 m of 9 m, 3 storeys, T_1 = 0.3 s, 5 %; ground B, 0.15 g.

    gamma_1 = 9/7, psi_1 = 2/3; S_e(0.3) = 4.4145; a_Z = 4.4145 x 6/7 x sqrt(1.01) = 3.8028 m/s2.
    A = 1.1/sqrt(0.05) = 4.9193: S_eZ = 18.707 between 0.24 and 0.33 s.
    """
    settings = SeismicSettings(
        AG, spectrum="ec8_type1", ground="B", mechanism_height=6.0, building_height=9.0, building_period=0.3, storeys=3
    )
    (state,) = limit_states(settings)
    found = spectrum_at_height(settings, state, AG, 0.05)
    assert found.peak_acceleration == pytest.approx(3.8028, abs=1e-4)
    assert found.acceleration(0.0) == pytest.approx(3.8028, abs=1e-4)
    assert found.acceleration(0.24) == found.acceleration(0.3) == pytest.approx(18.707, abs=2e-3)
    # 1.1 s: (1.1/0.33 - 1)^1.2 = 2.7642; 18.707/(1 + 3.9193 x 2.7642) = 1.5808, but the ground has 4.4145/2.2
    assert found.acceleration(1.1) == pytest.approx(4.4145 * 0.5 / 1.1, rel=1e-6)
    assert found.acceleration(0.5) == pytest.approx(18.707 / (1 + 3.9193 * (0.5 / 0.33 - 1) ** 1.2), rel=1e-4)
    # displacements do not fall beyond 1.1 T_1: 18.707 (0.33 / 2 pi)^2 = 51.60 mm
    assert found.displacement(0.35) == pytest.approx(51.60e-3, abs=2e-5)


def test_near_the_ground_the_floor_spectrum_is_not_below_the_ground():
    settings = SeismicSettings(AG, mechanism_height=0.1, building_height=9.0, building_period=0.3, storeys=3)
    (state,) = limit_states(settings)
    assert spectrum_at_height(settings, state, AG, 0.05).peak_acceleration == pytest.approx(AG)


def test_limit_states_with_their_own_demand():
    more = (LimitStateSettings("SLC", 2.5, 2.45, 0.32), LimitStateSettings("SLD", 0.6))
    settings = SeismicSettings(1.9, spectrum="ntc2018", reference_period=0.3, limit_states=more)
    found = limit_states(settings)
    assert [state.name for state in found] == ["SLD", "SLV", "SLC"]
    assert [state.peak_ground_acceleration for state in found] == [0.6, 1.9, 2.5]
    assert [state.reference_period for state in found] == [0.3, 0.3, 0.32]
    assert [largest_force_ratio(settings, state.name) for state in found] == [float("inf"), 3.0, 4.0]


def test_without_acceleration_nothing_is_verified():
    assert limit_states(SeismicSettings()) == ()


def test_the_default_limit_state_is_significant_damage():
    assert limit_states(TYPE_1_B)[0].name == "SD"
    assert limit_states(SeismicSettings(1.0, spectrum="ntc2018", reference_period=0.3))[0].name == "SLV"


STOOD = {"building_height": 9.0, "building_period": 0.3, "storeys": 3}


@pytest.mark.parametrize(
    ("settings", "key", "said"),
    [
        (SeismicSettings(1.0, spectrum="ntc2018"), "seismic.reference_period", "0.4 s"),
        (SeismicSettings(1.0, spectrum="parameters", soil_factor=1.2), "seismic.period_b", "0.4 s"),
        (SeismicSettings(1.0, spectrum="parameters"), "seismic.soil_factor", "1.2"),
        (
            SeismicSettings(1.0, None, (), "parameters", soil_factor=1.2, period_b=0.5, period_c=0.2, period_d=2.0),
            "seismic.period_c",
            "period_b <= period_c",
        ),
        (SeismicSettings(1.0, "SLV"), "seismic.limit_state", "use one of DL, SD, NC"),
        (SeismicSettings(1.0, "NC", spectrum="ntc2018"), "seismic.limit_state", "use one of SLD, SLV, SLC"),
        (SeismicSettings(limit_state="NC"), "seismic.limit_state", "has no ground acceleration"),
        (
            SeismicSettings(1.0, limit_states=(LimitStateSettings("SD", 2.0),)),
            "seismic.limit_states.0.name",
            "given twice",
        ),
        (SeismicSettings(1.0, mechanism_height=3.0), "seismic.building_height", "9 m"),
        (SeismicSettings(1.0, storeys=3), "seismic.storeys", "give seismic.mechanism_height with it"),
        (SeismicSettings(1.0, building_damping=0.1), "seismic.building_damping", "give seismic.mechanism_height"),
        (SeismicSettings(1.0, mechanism_height=12.0, **STOOD), "seismic.mechanism_height", "at most building_height"),
    ],
)
def test_what_cannot_be_verified_names_its_key(settings, key, said):
    with pytest.raises(CaseError, match=said) as caught:
        [(spectrum_at_height(settings, one, 1.0, 0.05), refuse_building(settings)) for one in limit_states(settings)]
    assert caught.value.key == key
