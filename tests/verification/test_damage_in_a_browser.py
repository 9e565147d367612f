"""Damage in report.html in headless Chromium: bonded joints that crack and break, a stone that fell."""

from __future__ import annotations

import json
import re

import pytest

from orchestrator.app.cli import main
from tests.support.browser import headless, opened, picture, set_slider
from tests.support.paths import PROJECT
from tests.support.undrawn import undrawn


@pytest.fixture(scope="module")
def browser():
    with headless() as driver:
        yield driver


@pytest.fixture(scope="module")
def bonded(tmp_path_factory):
    """Wall 1 as macroblocks with bonded joints, to 1 mm: they crack and break."""
    folder = tmp_path_factory.mktemp("bonded")
    classes = '[[joints.classes]]\ncohesion = "2 kPa"\ntensile_strength = "1 kPa"\n'
    wall = PROJECT / "tests/data/ferris_tinloi_wall1.json"
    case = f'[wall]\nblocks = "{wall}"\n[stepping]\nfinal_displacement = "1 mm"\n[macroblocks]\ntol_n = 1e-3\n{classes}'
    (folder / "case.toml").write_text(case, encoding="utf-8")
    with undrawn():
        command = ["run", str(folder / "case.toml"), "--output", str(folder / "run"), "--model", "macro", "--quiet"]
        assert main(command) == 0
    return folder / "run"


def test_damage_of_bonded_joints_is_shown_from_none_to_broken(bonded, toppled, browser):
    """Bands, their legend, the line of state and the table; none of it where joints are dry."""
    opened(browser, (toppled / "report.html").as_uri())
    assert not browser.find_element("id", "damaged").is_displayed()
    opened(browser, (bonded / "report.html").as_uri())
    assert browser.find_element("id", "damaged").is_displayed()
    bands = "return [...document.querySelectorAll('#picture .damage')].filter((p) => p.getAttribute('d')).length"
    set_slider(browser, 0)
    assert browser.execute_script(bands) == 0
    assert "damaged" not in picture(browser)[2]
    set_slider(browser, 10**6)
    assert browser.execute_script(bands) >= 1
    assert "damaged (" in picture(browser)[2]
    kinds = [cell.text for cell in browser.find_elements("css selector", "#damage td:nth-child(4)")]
    assert {"slides", "cracks", "breaks"} <= set(kinds)
    assert browser.get_log("browser") == []


@pytest.fixture(scope="module")
def toppled(tmp_path_factory):
    """A stone of 0.5 m x 1.5 m on a block of 9 m x 4 m, pushed until the block slides: the stone has fallen before."""
    folder = tmp_path_factory.mktemp("toppled")
    boxes = [(-9.0, -0.5, 18.0, 0.0), (0.0, 0.0, 9.0, 4.0), (4.25, 4.0, 4.75, 5.5)]
    blocks = [
        {"id": n, "polygon": [[x0, y0], [x1, y0], [x1, y1], [x0, y1]], "fixed": n == 0}
        for n, (x0, y0, x1, y1) in enumerate(boxes)
    ]
    wall = {"units": {"length": "m", "unit_weight": "kN/m3"}, "thickness": 0.3, "friction": 0.7, "unit_weight": 25.0}
    (folder / "wall.json").write_text(json.dumps(wall | {"blocks": blocks}), encoding="utf-8")
    with undrawn():
        assert main(["run", str(folder / "wall.json"), "--output", str(folder / "run"), "--model", "micro", "-q"]) == 0
    return folder / "run"


def test_a_stone_that_fell_is_an_outline_where_it_stood(toppled, browser):
    opened(browser, (toppled / "report.html").as_uri())
    assert browser.find_element("id", "fell").is_displayed()
    set_slider(browser, 0)
    assert len(browser.find_elements("css selector", "#picture .body")) == 2
    set_slider(browser, 10**6)
    assert len(browser.find_elements("css selector", "#picture .body")) == 1
    (left,) = browser.find_elements("css selector", "#picture .fell")

    def corners(drawn):
        return {tuple(float(x) for x in point.split()) for point in re.split("[MLZ]", drawn) if point}

    assert {(4.25, -4.0), (4.75, -4.0), (4.75, -5.5), (4.25, -5.5)} <= corners(left.get_attribute("d"))
    assert browser.get_log("browser") == []
