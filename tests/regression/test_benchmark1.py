"""Benchmark 1 from the case file to the summary: the figures it must show, and its curves against stored ones."""

from __future__ import annotations

import pytest

from orchestrator.app import driver
from orchestrator.settings import case
from tests.regression.stored_curves import compare
from tests.support.paths import PROJECT

pytestmark = pytest.mark.usefixtures("without_pictures")

WEIGHT = 22225.0
"""N: 22.225 kN, Ferris and Tin-Loi 2001"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("benchmark1")


@pytest.fixture(scope="module")
def summary(folder):
    outcome = driver.run(case.read(PROJECT / "templates" / "benchmark1.toml"), folder, False, None, lambda event: None)
    assert outcome.complaints == ()
    return outcome.summary.record


def of_model(summary, model):
    (found,) = [entry for entry in summary["pushover"] if entry["model"] == model]
    return found


def test_limit_analysis_gives_the_published_multipliers(summary):
    wall = summary["wall"]
    assert (wall["blocks"], wall["joints"]) == (146, 345)
    assert all(wall[load] == pytest.approx(WEIGHT, rel=1e-9) for load in ("weight", "vertical_load", "horizontal_load"))
    limit = summary["limit_analysis"]
    assert limit["associative"] == pytest.approx(0.34782, abs=1e-4)
    assert limit["non_associative"] == pytest.approx(0.2963, abs=1e-3)
    assert limit["converged"]
    low, high = limit["non_associative_range"]
    assert low == pytest.approx(0.2963, abs=1e-3)
    assert 0.2953 < high < 0.302  # the highest state that was found: others have found 0.3011 and 0.3013
    assert limit["base_shear"] == pytest.approx(limit["non_associative"] * WEIGHT)


def test_macroblocks_are_about_18_and_not_trivial(summary):
    assert 16 <= summary["macroblocks"]["count"] <= 20
    assert not summary["macroblocks"]["trivial"]
    assert of_model(summary, "macro")["bodies"] == summary["macroblocks"]["count"]
    assert of_model(summary, "micro")["bodies"] == 146


@pytest.mark.parametrize("model", ["macro", "micro"])
def test_pushover_is_static_and_goes_to_20_mm(summary, model):
    entry = of_model(summary, model)
    assert entry["final_displacement"] == pytest.approx(0.02, rel=0.01), "the last increment ends near it"
    assert entry["displacements"] == "large"
    assert entry["energy_error"] < 0.01
    assert "final displacement" in entry["stopped_because"]
    assert entry["equilibrium_residual"] < 1e-3
    assert entry["peak_reached"]
    assert not entry["events"]
    assert 0.0 < entry["max_penetration_over_size"] < 5e-3
    assert entry["max_pressed_gap_over_size"] < 1e-4
    assert entry["peak_memory"] < 2e9


def test_peaks_agree_with_each_other_and_with_limit_analysis(summary):
    """Micro-FE: 0.2969 at 20 mm of small displacements in an independent prototype of coarse elements; P-delta takes
    2 % off, and edges that stones turn about as much. `run templates/benchmark1.toml --model micro --set mesh.size=25mm
    --set mesh.toe_offset=0.5` has 6.374 kN."""
    macro, micro = (of_model(summary, model)["peak_base_shear"] / WEIGHT for model in ("macro", "micro"))
    assert micro == pytest.approx(6374.0 / WEIGHT, rel=5e-3)
    assert micro < summary["limit_analysis"]["rigid_peak"] < summary["limit_analysis"]["non_associative"] < 0.2969
    assert micro == pytest.approx(summary["limit_analysis"]["pressed_peak"], rel=0.01)
    assert macro == pytest.approx(micro, rel=0.02)
    assert of_model(summary, "macro")["initial_stiffness"] > of_model(summary, "micro")["initial_stiffness"]


@pytest.mark.parametrize("model", ["macro", "micro"])
def test_curve_is_the_stored_one(summary, folder, model):
    assert summary["case"]
    compare("benchmark1", folder, model)
