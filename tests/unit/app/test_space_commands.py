"""Commands on walls in space: limit, check, import, their refusals, and the shipped example."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from orchestrator.app import cli
from orchestrator.geometry.polyhedra import box
from tests.support.paths import DATA, PROJECT
from tests.support.space_walls import CUBE, GROUND, L_SHAPE, block_file_of, record


@pytest.fixture
def block_file(tmp_path):
    path = tmp_path / "wall.json"
    path.write_text(json.dumps(record()))
    return path


def test_limit_and_check_take_blocks_in_space(block_file, tmp_path, capsys):
    output = ["--output", str(tmp_path / "out")]
    assert cli.main(["check", str(block_file), *output]) == 0
    assert "1 block in space, 1 joint, nothing to complain about" in capsys.readouterr().out
    assert cli.main(["limit", str(block_file), "--set", "load.direction=[0,-1,0]", *output]) == 0
    printed = capsys.readouterr().out
    assert "0.60000" in printed
    assert (tmp_path / "out" / "figures" / "mechanism.png").stat().st_size > 5000
    page = (tmp_path / "out" / "collapse.html").read_text()
    assert "http" not in page.replace("http-equiv", "")
    assert cli.main(["limit", str(block_file), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert {
        "associative", "non_associative", "non_associative_range", "iterations", "converged", "equilibrium_residual",
        "base_shear", "seconds",
    } < set(found)  # fmt: skip
    assert found["non_associative"] == pytest.approx(0.6, abs=1e-6)
    assert found["base_shear"] == pytest.approx(0.6 * 1e3, rel=1e-5)


def test_a_plane_wall_may_be_pushed_out_of_its_plane(capsys):
    tower = str(DATA / "tower_5_blocks.json")
    assert cli.main(["limit", tower, "--set", "load.direction=+z", "--json"]) == 0
    out_of_plane = json.loads(capsys.readouterr().out)
    rows = json.loads(Path(tower).read_text())
    height = max(y for block in rows["blocks"] for _, y in block["polygon"])
    assert out_of_plane["associative"] == pytest.approx(min(rows["thickness"] / height, rows["friction"]), rel=1e-5)


def test_directions_in_plan(block_file, tmp_path, capsys):
    settings = ["--set", "load.directions=4", "--set", "limit_analysis.states=headline"]
    assert cli.main(["limit", str(block_file), *settings, "--output", str(tmp_path)]) == 0
    assert "direction 270 degrees: associative 0.6000" in capsys.readouterr().out
    assert json.loads((tmp_path / "directions.json").read_text())["associative"] == pytest.approx([0.6] * 4, abs=1e-6)
    assert (tmp_path / "figures" / "directions.png").exists()


@pytest.mark.parametrize(
    ("setting", "vector", "said"),
    [
        ("load.angle=-90 deg", (0.0, -1.0, 0.0), "(0, -1, 0), -90 degrees in plan"),
        ("load.angle=-1.5", (np.cos(1.5), -np.sin(1.5), 0.0), "(0.0707, -0.9975, 0), -85.94 degrees in plan"),
        ("load.angle=360 deg", (1.0, 0.0, 0.0), "(1, 0, 0), 0 degrees in plan"),
        (
            "load.direction=[-1, 0, 1]",
            (-(0.5**0.5), 0.0, 0.5**0.5),
            "(-0.7071, 0, 0.7071), 180 degrees in plan, 45 degrees above the horizontal",
        ),
        ("load.direction=+z", (0.0, 0.0, 1.0), "(0, 0, 1), upwards"),
    ],
)
def test_limit_and_check_say_which_direction_the_load_has(block_file, tmp_path, capsys, setting, vector, said):
    """A number is an angle in rad, as everywhere in a case file; degrees have their unit."""
    for command in ("check", "limit"):
        assert cli.main([command, str(block_file), "--set", setting, "--output", str(tmp_path / command)]) == 0
        assert f"direction of the live load: {said}\n" in capsys.readouterr().out
    stored = json.loads((tmp_path / "limit" / "limit_analysis.json").read_text())
    assert stored["direction"] == pytest.approx(vector, abs=1e-12)


def test_a_direction_that_is_held_is_a_gap(tmp_path, capsys):
    """A block of 0.5 m slides away from a wall at its side, or along it, and no force pushes it into the wall."""
    wall = block_file_of([GROUND, box((0.0, 0.0, 0.0), (0.5, 0.5, 0.5)), box((0.5, -1.0, 0.0), (1.0, 1.0, 1.0))])
    wall["blocks"][2]["fixed"] = True
    (tmp_path / "wall.json").write_text(json.dumps(wall))
    case = tmp_path / "case.toml"
    case.write_text('[wall]\nblocks = "wall.json"\n[load]\ndirection = "-x"\ndirections = 4\n')
    assert cli.main(["limit", str(case), "--output", str(tmp_path / "out")]) == 0
    printed = capsys.readouterr().out
    assert "direction 0 degrees: held, no load in this direction, however large, moves the wall\n" in printed
    assert "direction 180 degrees: associative 0.6000, without dilation 0.6000\n" in printed
    stored = json.loads((tmp_path / "out" / "directions.json").read_text())
    assert stored["gap"] == ["held", "", "", ""]
    assert stored["associative"][0] is stored["non_associative"][0] is None
    assert stored["non_associative"][1:] == pytest.approx([0.6] * 3, abs=1e-5)
    analysed = json.loads((tmp_path / "out" / "limit_analysis.json").read_text())
    assert analysed["non_associative"] == pytest.approx(0.6, abs=1e-5)
    assert (tmp_path / "out" / "collapse.html").exists()
    assert (tmp_path / "out" / "figures" / "directions.png").exists()
    assert "least of those that have an answer: direction " in printed


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (["load.direction=[0,0]"], "load.direction: [0.0, 0.0] is no direction; write"),
        (
            ["load.direction=y"],
            'load.direction: \'y\' is no direction; write "+x", "-y", "+z" or a vector of three numb',
        ),
        (["load.direction=[nan,0,1]"], "load.direction.0: nan is not a finite number; write a finite one"),
        (["load.direction=5"], "load.direction: 5 is not accepted"),
        (["load.angle=-90"], 'load.angle: -90 rad is more than a turn; write degrees with their unit, as in "-90 deg"'),
        (["load.angle=720 deg"], "load.angle: 12.5664 rad is more than a turn; write an angle within one"),
        (
            ["load.direction=+y", "load.angle=45 deg"],
            "load.angle: is given beside load.direction, which it stands for; leave one of the two out",
        ),
        (["load.directon=+y"], "load.directon: is not a known key; did you mean direction?"),
        (["contact.gap=0"], "contact.gap"),
        (
            ["mesh.size=1mm"],
            "mesh: is not a section of a wall in space: there is limit analysis only; use name, wall, project, load",
        ),
        (["limit_analysis.torsion=none"], "limit_analysis.torsion"),
        (["wall.thickness=1"], "wall.thickness: is not a known key"),
    ],
)
def test_bad_settings_take_one_line(block_file, capsys, settings, message):
    assert cli.main(["limit", str(block_file), *(part for one in settings for part in ("--set", one))]) == 2
    said = capsys.readouterr().err.strip()
    assert message in said
    assert "\n" not in said
    assert str(block_file) in said


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"units": {"length": "mm"}}, "units.unit_weight: is missing"),
        ({"up": "w"}, "up: 'w' is no axis"),
        ({"up": ["z"]}, "up: ['z'] is no axis"),
        (
            {"blocks": [{"id": 1, "vertices": [[0, 0, 0]], "faces": []}]},
            "block 1.vertices: is not a list of at least 4",
        ),
        ({"blocks": [{"id": 1, "vertices": CUBE.vertices.tolist(), "faces": [[0, 1, 99]] * 4}]}, "block 1.faces[0]"),
        (
            {"blocks": [{"id": 1, "vertices": CUBE.vertices.tolist(), "faces": [[3, 2, 1, 17]] * 4}]},
            "block 1.faces[0]: corner 17 does not exist, corners are 0 to 7; list",
        ),
        (
            {"blocks": [{"id": 1, "vertices": CUBE.vertices.tolist(), "faces": [[3, 17]] * 4}]},
            "block 1.faces[0]: [3, 17] does not name three corners; list",
        ),
        ({"blocks": [{"id": 1, "vertices": [], "polygon": []}]}, "block 1: needs vertices and faces, or a polygon"),
        ({"blocks": [{"id": 1, "polygon": L_SHAPE, "offset": 1}]}, "block 1.thickness: is missing"),
    ],
)
def test_bad_block_files_take_one_line(tmp_path, capsys, change, message):
    path = tmp_path / "bad.json"
    path.write_text(json.dumps({**record(), "up": "z", **change}))
    assert cli.main(["check", str(path), "--output", str(tmp_path)]) == 2
    said = capsys.readouterr().err.strip()
    assert message in said
    assert "\n" not in said


def test_the_shipped_example(tmp_path, capsys):
    template = str(PROJECT / "templates" / "uwall.toml")
    assert cli.main(["limit", template, "--set", "limit_analysis.states=headline", "--output", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert "0.34229" in printed
    assert "0.31950" in printed
    assert "56 blocks (84 % of the weight) in 1 body" in printed
    page = (tmp_path / "collapse.html").read_text(encoding="utf-8")
    assert " 0.8179 " in printed, "kN, as on the page"
    assert "<td>0.8179 kN</td>" in page
    assert "@bottom-right { content: counter(page)" in page, "prints as the report does"
    assert cli.main(["check", template, "--set", "wall.fasade=3", "--output", str(tmp_path)]) == 2
    assert "wall.fasade: is not a key of the generator 'u'" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["run", "segment", "study", "sensitivity", "export", "limit --settle 0"])
def test_commands_that_do_not_take_walls_in_space_say_so(command, block_file, capsys):
    name, *options = command.split(" ", 1)
    assert cli.main([name, str(block_file), *" ".join(options).split()]) == 2
    assert f"is a wall in space, which {command.removesuffix(' 0')} does not take; " in capsys.readouterr().err


@pytest.mark.parametrize(
    ("language", "words"),
    [
        ("en", ["client: Town of A", "author: B", "all joints", "Multiplier by direction", "to be seen on site"]),
        ("it", ["committente: Town of A", "redatto da: B", "tutti i giunti", "Moltiplicatore per direzione", "0,60"]),
        ("pt", ["cliente: Town of A", "elaborado por: B", "todas as juntas", "Multiplicador por direção", "0,60"]),
    ],
)
def test_project_data_and_language_reach_the_pages(block_file, tmp_path, language, words):
    case = tmp_path / "project.toml"
    text = '[project]\nclient = "Town of A"\nauthor = "B"\nremarks = "to be seen on site"\n'
    text += f'language = "{language}"\n[wall]\nblocks = "wall.json"\n[load]\ndirection = "+x"\ndirections = 4\n'
    case.write_text(text)
    assert cli.main(["limit", str(case), "--output", str(tmp_path / "out")]) == 0
    page = (tmp_path / "out" / "collapse.html").read_text()
    assert [word for word in words if word not in page] == []
    assert cli.main(["check", str(case), "--output", str(tmp_path / "out")]) == 0
    page = (tmp_path / "out" / "blocks.html").read_text()
    assert [word for word in words[:3] if word not in page] == []


@pytest.mark.parametrize(
    ("setting", "said"),
    [
        ("wall.compressive_strength=1MPa", "joints have friction only, no strengths"),
        ("joints.classes=[{compressive_strength='1 MPa'}]", "joints have friction only, no strengths"),
    ],
)
def test_a_compressive_strength_is_refused_by_what_is_missing(block_file, capsys, setting, said):
    assert cli.main(["limit", str(block_file), "--set", setting]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert setting.partition(".")[0] in line
    assert said in line


def test_ties_of_a_case_file(tmp_path, block_file, capsys):
    case = tmp_path / "tied.toml"
    text = '[wall]\nblocks = "wall.json"\n[load]\ndirection = "+x"\n[[reinforcement.ties]]\nblocks = [0, {}]\n'
    text += 'start = [-0.4, 0.25, -0.05]\nend = [0.0, 0.25, 0.0]\nstrength = "1 kN"\n'
    case.write_text(text.format(1))
    assert cli.main(["limit", str(case), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["associative"] > 1.5
    case.write_text(text.format(7))
    assert cli.main(["limit", str(case)]) == 2
    assert "reinforcement.ties.0.blocks: [0, 7] are not two blocks; name two" in capsys.readouterr().err


TIED = """
[wall]
blocks = "wall.json"
[load]
direction = "+y"
[[reinforcement.ties]]
blocks = {blocks}
start = {start}
end = {end}
strength = "{strength}"
"""


def tied(folder, blocks=(2, 1), start=(0.3, -0.3, 0.4), end=(0.3, 0.0, 0.4), strength="0.1 kN") -> str:
    """A block of 0.6 kN on the ground, 0.1 m thick, that a tie at 0.4 m holds to a wall which stands still."""
    shapes = [GROUND, box((0.0, 0.0, 0.0), (0.6, 0.1, 0.5)), box((0.0, -0.5, 0.0), (0.6, -0.3, 2.0))]
    wall = block_file_of(shapes)
    wall["blocks"][2]["fixed"] = True
    (folder / "wall.json").write_text(json.dumps(wall))
    case = folder / "tied.toml"
    case.write_text(TIED.format(blocks=[*blocks], start=[*start], end=[*end], strength=strength))
    return str(case)


def test_a_tie_acts_where_its_ends_are_and_check_says_where_that_is(tmp_path, capsys):
    """About the edge at y = 0.1 m: 0.1 / 0.5 by its weight, and 0.1 kN at 0.4 m over 0.6 kN at 0.25 m."""
    case = tied(tmp_path)
    assert cli.main(["limit", case, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["non_associative"] == pytest.approx(0.2 + 0.04 / 0.15, abs=1e-5)
    assert cli.main(["limit", case, "--output", str(tmp_path / "limit")]) == 0
    assert "kinematic verification" not in capsys.readouterr().out, "walls with ties are not verified"
    assert cli.main(["check", case, "--output", str(tmp_path / "out")]) == 0
    said = "tie 1: block 2 at (0.3, -0.3, 0.4) m to block 1 at (0.3, 0, 0.4) m, yields at 0.100 kN"
    assert said in capsys.readouterr().out


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        (
            {"start": (300, -300, 400), "end": (300, 0, 400)},
            "ties.0.start: (300, -300, 400) m is not on block 2; give a point of the block, which reaches from "
            "(0, -0.5, 0) m to (0.6, -0.3, 2) m",
        ),
        ({"end": (0.3, -0.01, 0.4)}, "ties.0.end: (0.3, -0.01, 0.4) m is not on block 1; give a point of the block"),
        ({"blocks": (2, 0)}, "ties.0.blocks: a tie between supports holds nothing; name a block that can move"),
        (
            {"strength": "1e12 kN"},
            "ties.0.strength: comes to 1e+15 N, more than 1e+06 times the mean weight of a block",
        ),
        ({"start": (0, 0)}, "ties.0.start: [0, 0] is not accepted; write a list of at least 3"),
        ({"end": (0, 0, 0, 0)}, "ties.0.end: [0, 0, 0, 0] is not accepted; write a list of at most 3"),
    ],
)
def test_a_tie_whose_ends_are_not_on_its_blocks_is_refused(tmp_path, capsys, changed, said):
    for command in ("check", "limit"):
        case = tied(tmp_path, **changed)
        assert cli.main([command, case, "--output", str(tmp_path / "out")]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert line.startswith(f"{case}: reinforcement.{said}")
