"""Earthquakes that are unusual: limit states interchanged, values of another return period, drifts in per cent."""

from __future__ import annotations

import pytest

from orchestrator.settings import case as cases
from orchestrator.settings.unusual import unusual
from tests.support.paths import PROJECT

AT_SLV = ("spectrum='ntc2018'", "reference_period=0.3", "amplification=2.4", "peak_ground_acceleration=2.0")


def at(name, acceleration, more=", amplification=2.4, reference_period=0.3"):
    return f"limit_states=[{{name='{name}', peak_ground_acceleration={acceleration}{more}}}]"


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ((*AT_SLV, at("SLD", 5.0)), "a_g of SLD is not below that of SLV; are they interchanged?"),
        (
            (*AT_SLV, at("SLC", 3.0, ", amplification=2.4")),
            "limit_states.0 (SLC) has no own reference_period, which depend",
        ),
        (("peak_ground_acceleration=2.0", "largest_drift=0.5"), "usual are up to 0.03; is 0.5 % meant?"),
        ((*AT_SLV, at("SLD", 1.0)), None),
        ((*AT_SLV[:-1], at("SLV", 2.0, "")), None),
        (("peak_ground_acceleration=2.0", "largest_drift=0.005"), None),
    ],
)
def test_what_is_unusual_about_an_earthquake(settings, said):
    case = cases.read(PROJECT / "templates" / "benchmark1.toml", [f"seismic.{one}" for one in settings])
    found = unusual(case, cases.read_wall(case), [], [], [])
    assert [said in one for one in found] == ([True] if said else [])
