"""The page of the collapse of a wall in space says what was analysed, and which number counts."""

from __future__ import annotations

import html
import json
import re

import numpy as np
import pytest
from matplotlib.image import imread

from orchestrator.app import cli
from orchestrator.geometry.polyhedra import box
from orchestrator.present.in_space.space_pictures import TIE
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


TIED = """
project.language = "{language}"
[wall]
blocks = "wall.json"
[load]
direction = "-y"
[[reinforcement.ties]]
blocks = [1, 2]
start = [1.0, 0.4, 2.8]
end = [1.0, 3.0, 2.8]
strength = "5 kN"
[[reinforcement.ties]]
blocks = [1, 3]
start = [1.0, 0.0, 2.8]
end = [1.0, -2.0, 2.8]
strength = "80 kN"
"""
TIES_TOLD = {
    "en": ["5.000 kN of 5.000 kN, yields", "0.000 kN of 80.00 kN, slack", "blocks, supports, joints, ties"],
    "it": ["5,000 kN di 5,000 kN, snervata", "0,000 kN di 80,00 kN, inattiva", "blocchi, appoggi, giunti, catene"],
    "pt": ["5,000 kN de 5,000 kN, em cedência", "0,000 kN de 80,00 kN, frouxo", "blocos, apoios, juntas, tirantes"],
}


def green_columns(picture) -> int:
    """How many columns of the upper half of a picture, its legend aside, have a pixel of the colour of ties."""
    pixels = imread(picture)[..., :3]
    return int((np.abs(pixels[: len(pixels) // 2] - TIE[0]).max(axis=2) < 0.02).any(axis=0).sum())


@pytest.mark.parametrize("language", TIES_TOLD)
def test_ties_are_drawn_told_with_their_forces_and_no_joints(tmp_path, capsys, language):
    """A block of 48 kN, 0.4 m thick and 3 m high, turns away from one support and towards another, tied to both at
    2.8 m: (48 x 0.2 + 5 x 2.8) / (48 x 1.5)."""
    stones = [box((0.0, 0.0, 0.0), (2.0, 0.4, 3.0)), *(box((0.5, y, 2.5), (1.5, y + 0.5, 3.0)) for y in (3.0, -2.5))]
    wall = block_file_of([GROUND, *stones], 0.9)
    for support in wall["blocks"][2:]:
        support["fixed"] = True
    (tmp_path / "wall.json").write_text(json.dumps(wall))
    case, out = tmp_path / "case.toml", tmp_path / "out"
    case.write_text(TIED.format(language=language))
    assert cli.main(["check", str(case), "--output", str(out)]) == 0
    assert ": 1 block in space, 1 joint, 2 ties, nothing" in capsys.readouterr().out
    assert cli.main(["limit", str(case), "--output", str(out)]) == 0
    printed = capsys.readouterr().out.splitlines()
    assert any(line.endswith(": 1 block in space, 1 joint, 2 ties") for line in printed)
    for number, said in enumerate(TIES_TOLD["en"][:2], 1):
        assert f"tie {number}: {said}" in printed
    stored = json.loads((out / "limit_analysis.json").read_text())
    assert stored["non_associative"] == pytest.approx((48 * 0.2 + 5 * 2.8) / (48 * 1.5), rel=1e-6)
    assert stored["tie_forces_N"] == pytest.approx([5e3, 0.0], abs=0.1)
    assert (stored["tie_strengths_N"], stored["tie_states"]) == ([5e3, 80e3], ["yields", "slack"])
    for name in ("blocks", "collapse"):
        page = html.unescape((out / f"{name}.html").read_text(encoding="utf-8"))
        assert (TIES_TOLD[language][2], "1, 3, 1, 2") in rows_of(page)
        scene = json.loads(re.findall('<script type="application/json" id="data">(.*?)</script>', page)[0])
        assert (len(scene["joints"]), [tie["blocks"] for tie in scene["ties"]]) == (1, [[1, 2], [1, 3]])
    assert {value for _, value in rows_of(page)} >= {*TIES_TOLD[language][:2]}
    for name in ("blocks", "mechanism"):
        assert green_columns(out / "figures" / f"{name}.png") > 200


def test_the_page_names_the_block_under_the_pointer(tmp_path):
    """Stones of 1, 2 and 3 m on each other, from the front: a metre is 0.75 of the canvas' height over the diagonal of
    the pile."""
    from tests.support.browser import headless, opened, webdriver

    stones = [box((0.0, 0.0, low), (1.0, 1.0, high)) for low, high in ((0.0, 1.0), (1.0, 3.0), (3.0, 6.0))]
    wall = block_file_of([GROUND, *stones])
    (tmp_path / "wall.json").write_text(json.dumps(wall))
    assert cli.main(["check", str(tmp_path / "wall.json"), "--output", str(tmp_path / "out")]) == 0
    with headless() as page:
        opened(page, (tmp_path / "out" / "blocks.html").as_uri())
        page.find_element("css selector", "button[data-view=front]").click()
        canvas = page.find_element("css selector", "#scene")
        metre = 0.75 * canvas.size["height"] / 38**0.5
        told = "return document.getElementById('named').textContent"
        for said, height in (("block 3", 4.5), ("block 2", 2.0), ("", 6.5), ("block 1", 0.5)):
            up = webdriver.ActionChains(page).move_to_element_with_offset(canvas, 0, round(metre * (3.0 - height)))
            up.perform()
            webdriver.support.wait.WebDriverWait(page, 60).until(lambda p, said=said: p.execute_script(told) == said)
