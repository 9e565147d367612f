"""A pushover that no increment continues says what happened, where, and what may help, in every language."""

from __future__ import annotations

import json
import re

import pytest

from orchestrator.app import cli
from orchestrator.present.phrases import phrases
from tests.support.paths import DATA

TOWER = str(DATA / "tower_5_blocks.json")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A run whose gaps are to come below what rounding leaves of displacements: once the tower rocks they cannot."""
    folder = tmp_path_factory.mktemp("broken") / "run"
    settings = ["gap=1e-22", "residual=1e-16", "acceptable=1"]
    newton = [word for one in settings for word in ("--set", f"newton.{one}")]
    stiff = ["--set", "elastic.elastic_modulus=1e14"]
    assert cli.main(["run", TOWER, "--model", "micro", "--output", str(folder), "-q", *newton, *stiff]) == 1
    return folder


def test_what_happened_where_and_what_may_help(folder):
    (pushed,) = json.loads((folder / "summary.json").read_text())["pushover"]
    place = r"after increment \d+ \(\w+, [\d.e-]+ mm, multiplier [\d.]+\)"
    said = (
        rf"micro FE: stopped {place}: no equilibrium is found for a next increment, however small, nor a motion that "
    )
    said += r"leads to one; block \d at \([\d.]+, [\d.]+\) m moves most; the curve is not valid; try "
    said += r"a smaller elastic.elastic_modulus \(default 3.5 GPa\), a larger newton.residual \(default 1e-08\), "
    said += r"stepping.large_displacement=false \(small displacements\), --model macro \(.+\)"
    assert re.fullmatch(said, pushed["complaint"]), pushed["complaint"]
    by_rounding = r"energy balance: .+"  # of the last increments, on some processors
    assert re.fullmatch(rf"end of the curve: it broke off {place}|{by_rounding}", pushed["not_valid_because"])


@pytest.mark.parametrize(
    ("language", "word"), [("it", "non si trova equilibrio"), ("pt", "não se encontra equilíbrio")]
)
def test_the_page_says_it_in_its_language(folder, language, word):
    (pushed,) = json.loads((folder / "summary.json").read_text())["pushover"]
    assert word in phrases(language)(pushed["complaint"])


def pretension_of(force):
    return f", pretension='{force}'"


def test_ties_that_pull_a_wall_over_as_they_are_tightened_are_named(tmp_path, capsys):
    """3 kN at 1.2 m against 4.5 kN at 0.25 m; without a pretension the block stands. Another tie, which might hold it,
    pulls with its own pretension as long as it is tightened."""
    outlines = [[[-1, -0.2], [2, -0.2], [2, 0], [-1, 0]], [[0, 0], [0.5, 0], [0.5, 1.5], [0, 1.5]]]
    blocks = [{"id": number, "polygon": outline, "fixed": not number} for number, outline in enumerate(outlines)]
    values = {"name": "block", "units": {"length": "m", "unit_weight": "kN/m3"}, "thickness": 0.3, "unit_weight": 20}
    wall = tmp_path / "block.json"
    wall.write_text(json.dumps(values | {"friction": 0.7, "blocks": blocks}))
    tie = "{blocks=[1], start=['0 m', '1.2 m'], end=['-1 m', '1.2 m'], strength='9 kN', stiffness='1 kN/mm'%s}"
    other = "{blocks=[1], start=['0.5 m', '1.2 m'], end=['2 m', '1.2 m'], strength='9 kN', stiffness='1 kN/mm'"
    held = f"{tie % pretension_of('3 kN')}, {other}{pretension_of('0.1 kN')}}}"
    alone = tie % pretension_of("3 kN")
    named = "its ties are tightened meanwhile (reinforcement.ties.pretension)"
    refused = "reinforcement.ties: their pretension moves block 1"
    for drawn, code, said in ((alone, 2, refused), (held, 1, named), (tie % "", 0, "")):
        ties = f"reinforcement.ties=[{drawn}]"
        command = ["run", str(wall), "--model", "micro", "--set", ties, "--set", "stepping.final_displacement=2mm"]
        assert cli.main([*command, "--output", str(tmp_path / f"run{code}"), "-q"]) == code
        printed = " ".join(capsys.readouterr().err.split())
        assert said in printed
        assert bool(printed) == bool(said)
