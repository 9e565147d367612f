"""Benchmark 2 from the case file to the summary: what it must show, and its curves against stored ones."""

from __future__ import annotations

import json

import pytest

from orchestrator.app import driver
from orchestrator.settings import case
from tests.regression.stored_curves import compare
from tests.support.paths import PROJECT

pytestmark = pytest.mark.usefixtures("without_pictures")

TEMPLATE = PROJECT / "templates" / "benchmark2.toml"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("benchmark2")


@pytest.fixture(scope="module")
def summary(folder):
    outcome = driver.run(case.read(TEMPLATE), folder, False, None, lambda event: None)
    assert outcome.complaints == ()
    return outcome.summary.record


def test_few_bodies_keep_the_peak(summary, folder):
    """36 bodies of 173 bear 0.8 % more than micro-FE. They are not known to, as limit analysis has 3 % more
    still: stones give way at pressed edges. So it goes on until twice as many bear the same twice in a row."""
    macro, micro = summary["pushover"]
    assert micro["bodies"] == 173
    multiplier = micro["peak_base_shear"] / summary["wall"]["horizontal_load"]
    assert macro["peak_base_shear"] == pytest.approx(micro["peak_base_shear"], rel=0.01)
    borne = {one["bodies"]: one["multiplier"] for one in json.loads((folder / "macro" / "borne.json").read_text())}
    assert borne[36] == pytest.approx(multiplier, rel=0.01)
    assert borne[72] == pytest.approx(multiplier, rel=0.01)


def test_the_peak_is_that_of_fine_elements(summary):
    """`run templates/benchmark2.toml --model micro --set mesh.size=25mm --set mesh.toe_offset=0.5` has 6.417 kN."""
    assert summary["pushover"][1]["peak_base_shear"] == pytest.approx(6417.0, rel=5e-3)


@pytest.mark.parametrize("model", ["macro", "micro"])
def test_curve_is_the_stored_one(summary, folder, model):
    assert summary["case"]
    compare("benchmark2", folder, model)
