"""Ties in the report: their forces under gravity, at the peak and at the end, where they yield; and in pictures."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from matplotlib.colors import to_hex

from orchestrator.app import driver
from orchestrator.present import plots
from orchestrator.present.page import write
from orchestrator.present.page.tie_forces import tie_rows
from orchestrator.present.plots.pushover_pictures import TIES
from orchestrator.present.tie_states import shown_ties, state_of
from orchestrator.settings import case as cases
from orchestrator.storage.stored_run import read_run
from tests.support.figures import segments
from tests.support.pushover_chain import rectangle
from tests.support.undrawn import undrawn

STRENGTH, PRETENSION = 400.0, 100.0
TIES_GIVEN = f"""reinforcement.ties=[
{{blocks=[1], start=[0.4, 0.9], end=[2.0, 0.9], strength={STRENGTH}, stiffness=2e6, pretension={PRETENSION}}},
{{blocks=[1], start=[0.0, 0.9], end=[-1.0, 0.9], strength={STRENGTH}, stiffness=2e6}}]"""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A block of 2.4 kN, that rocks to the left, from its pretensioned anchor and towards the other."""
    folder = tmp_path_factory.mktemp("tied")
    blocks = [{"id": 0, "polygon": rectangle(-3.0, -0.2, 6.0, 0.2).tolist(), "fixed": True}]
    blocks.append({"id": 1, "polygon": rectangle(0.0, 0.0, 0.4, 1.0).tolist()})
    wall = {"units": {"length": "m", "unit_weight": "N/m3"}, "thickness": 0.3, "unit_weight": 20e3}
    (folder / "wall.json").write_text(json.dumps(wall | {"friction": 5.0, "blocks": blocks}))
    given = [
        " ".join(TIES_GIVEN.split()),
        "load.direction=-x",
        "stepping.final_displacement=2mm",
        "run.models=['micro']",
    ]
    with undrawn():
        driver.run(cases.read(folder / "wall.json", given), folder / "run", False, None, lambda _: None)
    return read_run(folder / "run")


def test_the_table_has_the_forces_of_every_tie_and_where_it_yields(run):
    pulls, loose = tie_rows(run.models[0], run.case.reinforcement.ties)
    assert pulls["gravity"] == pytest.approx(PRETENSION, rel=1e-6)
    assert pulls["end"] == pulls["strength"] == STRENGTH
    assert (pulls["state"], loose["state"]) == ("yields", "slack")
    assert (loose["end"], loose["yields"]) == (0.0, None)
    multiplier, moved = pulls["yields"]
    stored = np.genfromtxt(run.folder / "micro" / "ties.csv", delimiter=",", names=True)
    assert multiplier == stored["load_multiplier"][stored["tie_1_N"] == STRENGTH][0]
    assert 0.0 < moved < 2e-3


def test_the_page_has_a_row_of_every_tie_and_draws_them_under_the_slider(run):
    text = write(run.folder).read_text(encoding="utf-8")
    rows = re.findall(r"<tr><td class=\"t\">Micro-FE</td><td class=\"t\">\d</td>.*", text)
    assert len(rows) == 2
    assert "<td>0.1000</td>" in rows[0]
    assert "never" in rows[1]
    data = json.loads(re.search(r'id="data">(.*?)</script>', text)[1])
    model = data["models"][0]
    assert model["ties"] == [[[0.4, 0.9], [2.0, 0.9]], [[0.0, 0.9], [-1.0, 0.9]]]
    end = model["frames"][-1]["ties"]
    assert [tie["state"] for tie in end] == ["yields", "slack"]
    assert end[0]["moved"][0][0] < -1e-3
    assert end[0]["moved"][1] == [0.0, 0.0], "the anchor stays"


def test_the_slider_shows_the_bound_and_the_headline_of_limit_analysis(run):
    text = write(run.folder).read_text(encoding="utf-8")
    lines = json.loads(re.search(r'id="data">(.*?)</script>', text)[1])["limit"]
    limit, load = run.summary.limit_analysis, run.analysis.horizontal_load
    assert lines == {"associative": limit.associative * load, "headline": limit.base_shear}
    words = json.loads(re.search(r'id="words">(.*?)</script>', text)[1])
    assert words["associative"] == "micro-LA, associative"
    assert words["headline"] == "micro-LA, collapse state met by loading"


def test_the_page_has_materials_with_all_values_and_joints_with_their_strengths(run):
    text = write(run.folder).read_text(encoding="utf-8")
    (material,) = re.findall(r'<tr><td class="t">masonry</td>(.*?)</tr>', text)
    assert re.findall(r"<td>([^<]*)</td>", material) == [
        "1", "2.400", "20.00", "0.300", "5.00", "3.50", "0.20",
    ]  # fmt: skip
    (joints,) = re.findall(r'<span>support</span></td><td class="t">bed joints</td>(.*?)</tr>', text)
    assert re.findall(r"<td>([^<]*)</td>", joints) == ["1", "0.4000", "5.00", "–", "–", "–"]


def test_deformed_pictures_have_the_ties_where_they_have_gone(run):
    (model,) = run.models
    last = model.store.read(int(model.curve.step[-1]))
    ties = shown_ties(run.assemblage.wall, model.bodies, model.meshes, run.case.reinforcement.ties)
    figure = plots.deformed(model.bodies, model.meshes, last, model.contacts, "", 10.0, ties=ties)
    (pulling,) = segments(figure, to_hex(TIES["yields"][0]))
    start, anchor = pulling
    corner = model.bodies.bodies[0].exterior
    assert start[0] == pytest.approx(0.4 + 10.0 * ties.moved(last)[0, 0, 0])
    assert start[0] < corner[:, 0].max() - 0.01
    assert anchor.tolist() == [2.0, 0.9]
    assert "0.4000 kN" in [text.get_text() for text in figure.axes[0].texts]
    assert {"tie, yields", "tie, slack"} <= {text.get_text() for text in figure.legends[0].get_texts()}


def test_a_tie_that_pushes_yields_both_ways():
    assert [state_of(force, 5.0) for force in (-5.0, -1.0, 0.0, 2.0, 5.0)] == [
        "yields", "taut", "slack", "taut", "yields",
    ]  # fmt: skip
