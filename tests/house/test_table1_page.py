"""docs/studies/table1.py makes the page from what a study leaves; the page in the repository has its form."""

from __future__ import annotations

import json
import re
import runpy
import sys

import pytest

from tests.support.paths import PROJECT

STUDIES = PROJECT / "docs" / "studies"


@pytest.fixture
def table1():
    return runpy.run_path(str(STUDIES / "table1.py"))


def test_a_row_is_rounded_for_the_page(table1, tmp_path):
    """From figures with all their digits, under the heading that the page has."""
    (tmp_path / "table.csv").write_text(
        "tol_n,tol_D_m,bodies,joints,peak_multiplier,peak_base_shear_N,displacement_at_peak_m,"
        "initial_stiffness_N_per_m,seconds,bodies_over_micro,peak_over_micro,stiffness_over_micro,"
        "seconds_over_micro,run,stopped_because,complaints\n"
        "3.75e-06,0.001,32,133,0.29242,6498,0.012,38410000.0,11.91,0.21918,1.0013,1.1172,0.1879,32_bodies-a,,\n"
        "none,none,1,8,,,,,,,,,,1_bodies-b,,fell\n"
    )
    heading, _, row, failed = table1["table"](tmp_path, lambda run: "0.2965").splitlines()
    assert heading in (STUDIES / "table1.md").read_text().splitlines()
    assert row == "| 3.75e-06 | 1 | 32 | 0.219 | 133 | 0.2924 | 1.001 | 0.2965 | 38.41 | 1.12 | 11.9 | 0.19 |"
    assert failed == "| none | none | 1 |  | 8 |  |  | 0.2965 |  |  |  |  |"


def test_the_page_is_its_head_and_its_tables():
    page, head = ((STUDIES / name).read_text() for name in ("table1.md", "table1_head.md"))
    without = re.sub(r"\| (?:tol_n|wall \| margin|curve) \|.*?\n\n", "{{}}\n\n", page, flags=re.DOTALL)
    assert without == re.sub(r"\{\{\w+\}\}", "{{}}", head)


def test_the_table_of_the_automatic_choice_is_that_of_all_walls(table1):
    """The page cannot show other figures than docs/studies/tolerances.csv."""
    made = table1["automatic"](STUDIES / "tolerances.csv")
    assert made in (STUDIES / "table1.md").read_text()
    assert [line.split(" | ")[2] for line in made.splitlines() if "every stone" in line] == ["146", "173"]


def test_a_study_that_is_missing_is_named(table1, monkeypatch, tmp_path):
    monkeypatch.setattr(sys, "argv", ["table1.py", str(tmp_path)])
    with pytest.raises(SystemExit, match="no finished study; run make table1 first"):
        table1["main"]()


def test_rigid_multiplier_of_one_body_is_the_coefficient_of_friction(table1, tmp_path):
    """The whole wall slides on its support at 0.65 (Table 1: 0.6500)."""
    blocks = json.loads((STUDIES.parents[1] / "meshes" / "ferris_tinloi_wall6.json").read_text())["blocks"]
    folder = tmp_path / "runs" / "one"
    folder.mkdir(parents=True)
    bodies = [{"block": block["id"], "body": int(block.get("fixed", False))} for block in blocks]
    (folder / "macroblocks.json").write_text(json.dumps({"body_of_block": bodies}))
    assert table1["rigid_multipliers"](tmp_path, "benchmark1")("one") == "0.6500"
