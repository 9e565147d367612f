"""Ranges of a sensitivity study that are of all joints, or blocks, though these differ in the case."""

from __future__ import annotations

import pytest

from orchestrator.app.study_commands import made_alike
from orchestrator.settings.case import read
from tests.support.paths import DATA

TIMBER = '[[joints.classes]]\norientation = "head"\nfriction = 0.3\n'


@pytest.mark.parametrize(
    ("classes", "said"),
    [("", []), (TIMBER, ["WARNING: sensitivity.friction is of every joint alike: as given they have 0.3 to 0.65"])],
)
def test_a_range_says_what_it_makes_alike(tmp_path, classes, said):
    case = tmp_path / "case.toml"
    wall = f'name = "w"\n[wall]\nblocks = "{DATA / "ferris_tinloi_wall3.json"}"\n'
    case.write_text(f"{wall}{classes}[sensitivity]\nfriction = [0.5, 0.7]\nthickness = [0.9, 1.1]\n")
    assert made_alike(read(case)) == said
