"""Macroblocks that carry more than their stones can say so, and others do not, whatever tension their elements show."""

from __future__ import annotations

import json

import pytest

from orchestrator import storage
from orchestrator.app import driver
from orchestrator.settings import case as cases
from tests.support.pushover_chain import rectangle

pytestmark = pytest.mark.usefixtures("without_pictures")

LOWER, UPPER = (1.0, 0.4), (0.3, 1.0)
"""width and height of two stones, one on the other, m"""


def overturning(*stones):
    """lambda about the toe of the lowest stone: sum W b / 2 = lambda sum W y, all centred on each other."""
    level, moment, weight = 0.0, 0.0, 0.0
    for width, height in stones:
        weight += width * height
        moment += width * height * (level + 0.5 * height)
        level += height
    return weight * 0.5 * stones[0][0] / moment


def pushed(folder, stones):
    """The stones merged into one body and pushed."""
    blocks, level = [{"id": 0, "polygon": rectangle(-2.0, -0.2, 4.0, 0.2).tolist(), "fixed": True}], 0.0
    for number, (width, height) in enumerate(stones, 1):
        blocks.append({"id": number, "polygon": rectangle(-width / 2, level, width, height).tolist()})
        level += height
    wall = {"units": {"length": "m", "unit_weight": "kN/m3"}, "thickness": 0.3, "unit_weight": 20.0, "friction": 5.0}
    (folder / "wall.json").write_text(json.dumps(wall | {"blocks": blocks}))
    merged = ["run.models=['macro']", "macroblocks.tol_n=none", "macroblocks.tol_d=none"]
    case = cases.read(folder / "wall.json", [*merged, "stepping.final_displacement=20mm"])
    summary = driver.run(case, folder / "run", False, None, lambda _: None).summary
    return summary, [said for said in storage.remarks(summary) if "tension inside" in said]


def test_a_foot_that_hangs_on_its_pier_is_told(tmp_path):
    """The pier alone turns at b/h = 0.3; with the foot glued to it it would have to lift both."""
    summary, said = pushed(tmp_path, (LOWER, UPPER))
    assert summary.pushover[0].peak_multiplier == pytest.approx(overturning(LOWER, UPPER), rel=0.01)
    assert summary.limit_analysis.associative == pytest.approx(overturning(UPPER), rel=1e-6)
    assert len(said) == 1
    assert "0.3000" in said[0]


def test_a_pier_whose_stones_can_do_as_it_does_is_not(tmp_path):
    """Two stones of one width turn as one: what the elements show of tension stands for nothing."""
    summary, said = pushed(tmp_path, (UPPER, UPPER))
    assert summary.pushover[0].peak_multiplier == pytest.approx(overturning(UPPER, UPPER), rel=0.01)
    assert said == []
