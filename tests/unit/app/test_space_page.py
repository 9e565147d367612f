"""The page of the collapse of a wall in space says what was analysed, and which number counts."""

from __future__ import annotations

import html
import json
import re

import pytest

from orchestrator.app import cli
from orchestrator.geometry.polyhedra import box
from tests.support.space_walls import GROUND, block_file_of

CASE = """
project.language = "{language}"
[wall]
blocks = "wall.json"
[load]
direction = [0, 1, 1]
[[load.dead]]
blocks = [1]
force = "2 kN"
inertia = true
[[load.dead]]
blocks = [1]
force = "0.25 kN"
direction = [0, 1, 0]
[[load.dead]]
level = "2 m"
line_load = "0.5 kN/m"
"""
ROWS = {
    "en": [
        ("direction of the live load", "(0, 0.7071, 0.7071), 90 degrees in plan, 45 degrees above the horizontal"),
        ("distribution of the live load", "proportional to mass"),
        ("friction coefficient", "0.6"),
        ("unit weight", "20 kN/m³"),
        ("dead load", "2 kN on block 1; in all 2.000 kN, with mass"),
        ("dead load", "0.25 kN on block 1, along (0, 1, 0); in all 0.250 kN, without mass"),
        ("dead load", "0.5 kN/m on level 2 m; in all 0.500 kN, without mass"),
        ("joints twist as under", "forces at corners"),
    ],
    "it": [
        ("direzione del carico sismico", "(0, 0,7071, 0,7071), 90 gradi in pianta, 45 gradi sopra l'orizzontale"),
        ("distribuzione del carico sismico", "proporzionale alla massa"),
        ("coefficiente di attrito", "0,6"),
        ("peso specifico", "20 kN/m³"),
        ("carico permanente", "2 kN sul blocco 1; in tutto 2,000 kN, con massa"),
        ("carico permanente", "0,25 kN sul blocco 1, lungo (0, 1, 0); in tutto 0,250 kN, senza massa"),
        ("carico permanente", "0,5 kN/m alla quota 2 m; in tutto 0,500 kN, senza massa"),
        ("i giunti si torcono come sotto", "forze agli spigoli"),
    ],
}


def page_of(tmp_path, language: str, command: str = "limit") -> str:
    """The text of the page of a pier of 16 kN."""
    shapes = [GROUND, box((0.0, 0.0, 0.0), (1.0, 0.4, 2.0))]
    (tmp_path / "wall.json").write_text(json.dumps(block_file_of(shapes)))
    case = tmp_path / "case.toml"
    case.write_text(CASE.format(language=language))
    assert cli.main([command, str(case), "--output", str(tmp_path / "out")]) == 0
    name = {"limit": "collapse", "check": "blocks"}[command]
    return html.unescape((tmp_path / "out" / f"{name}.html").read_text(encoding="utf-8"))


def rows_of(page: str) -> list[tuple[str, str]]:
    return re.findall("<tr><th>(.*?)</th><td>(.*?)</td></tr>", page)


@pytest.mark.parametrize("command", ["check", "limit"])
@pytest.mark.parametrize("language", ROWS)
def test_the_page_says_what_was_analysed(tmp_path, language, command):
    rows = rows_of(page_of(tmp_path, language, command))
    assert [row for row in ROWS[language] if row not in rows] == []


@pytest.mark.parametrize("language", ["en", "it", "pt"])
def test_the_page_says_which_number_counts_as_the_terminal_does(tmp_path, capsys, language):
    page = page_of(tmp_path, language)
    told = re.findall('<p class="answer">(.*?)</p>', page)
    printed = re.findall("(?m)^λ = .* counts .*$", capsys.readouterr().out)
    if language == "en":
        assert [" ".join(told)] == printed
    else:
        assert len(told) == 1
        assert not re.search(r"\b(counts|the|an|bound|joints|shear|found)\b", told[0])
        assert re.findall(r"\d+", told[0]) == re.findall(r"\d+", printed[0])


def test_the_page_warns_that_the_twist_of_joints_decides(tmp_path, capsys):
    """A beam on a pier of 1 m is twisted on it by a force on one of two stones at its ends, 2 m off the middle: about
    the pier's middle 0.7071 mu N m with forces at the corners, 0.3826 mu N m under uniform pressure."""
    ends = [box((x - 0.2, -0.2, 0.05), (x + 0.2, 0.2, 1.05)) for x in (-2.0, 2.0)]
    beam, pier = box((-2.5, -0.5, 0.0), (2.5, 0.5, 0.05)), box((-0.5, -0.5, -1.0), (0.5, 0.5, 0.0))
    wall = block_file_of([pier, beam, *ends], friction=0.3)
    for block in wall["blocks"][2:]:
        block["unit_weight"] = 200
    (tmp_path / "wall.json").write_text(json.dumps(wall))
    case = tmp_path / "case.toml"
    text = '[wall]\nblocks = "wall.json"\n[load]\ndirection = "+y"\ndistribution = "per_block"\n'
    case.write_text(f'{text}[[load.live]]\nblocks = [3]\nforce = "1 kN"\n')
    assert cli.main(["limit", str(case), "--output", str(tmp_path / "out")]) == 0
    told = re.findall('<p class="answer">(.*?)</p>', (tmp_path / "out" / "collapse.html").read_text(encoding="utf-8"))
    assert len(told) == 2
    assert told[1].startswith("Joints that twist as under uniform pressure reach no more than λ = ")
    assert " ".join(told) in capsys.readouterr().out
