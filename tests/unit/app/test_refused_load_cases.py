"""What the input of one load case shows to be wrong is refused before any load case is analysed, by the key it has.

A stone of 3 kN, 0.5 m wide and 1 m high, on the ground; beside it a stone of the same size under a beam that reaches
beyond it: 9 kN of beam stand 0.05 m inside the stone's edge, and a dead load on the beam's end makes it fall.
"""

from __future__ import annotations

import json
import shutil

import pytest

from orchestrator.app import load_cases
from orchestrator.app.cli import main
from orchestrator.loads import loads_on
from orchestrator.settings import case as cases
from tests.support.leaning_stone import CASE, stone
from tests.support.undrawn import undrawn


def box(number, x, y, width, height, **more):
    corners = [[x, y], [x + width, y], [x + width, y + height], [x, y + height]]
    return {"id": number, "polygon": corners} | more


WALL = {
    "units": {"length": "m", "unit_weight": "kN/m3"}, "thickness": 0.3, "unit_weight": 20.0, "friction": 0.9,
    "blocks": [
        box(0, -1, -0.2, 8, 0.2, fixed=True), box(1, 0, 0, 0.5, 1), box(2, 3, 0, 0.5, 1), box(3, 3, 1, 0.9, 0.5)
    ],
}  # fmt: skip
COMMANDS = ["check", "limit", "segment", "run", "sensitivity"]
ON_THE_END = "dead = [{blocks = [3], force = '5 kN', at = [3.9, 1.5]}]"
STANDS_WITHOUT = "the wall stands under its own weight, but not under this dead load too:"
ONE, RANGE = "[[load.cases]]\nname = 'one'\n", "[sensitivity]\nfriction = [0.8, 0.9]\nsamples = 0\n"
WRONG = {
    "no block": ("dead = [{blocks = [77], force = '1 kN'}]", "load.cases.1.dead.0.blocks: there is no block 77"),
    "two kinds": (
        "dead = [{blocks = [1], force = '1 kN', line_load = '1 kN/m'}]", "load.cases.1.dead.0: needs one of force"
    ),
    "no level": ("dead = [{level = '7 m', force = '1 kN'}]", "load.cases.1.dead.0.level: no block has its top"),
    "live with mass": ("live = [{blocks = [1], force = '1 kN'}]", "load.cases.1.live: 1 given for \"mass\""),
    "no live": ("distribution = 'per_block'", "load.cases.1.live: 0 given for \"per_block\""),
    "live on none": (
        "distribution = 'per_block'\nlive = [{blocks = [77], force = '1 kN'}]",
        "load.cases.1.live.0.blocks: there is no block 77",
    ),
}  # fmt: skip


def shared(of_second, common="dead = [{blocks = [1], force = '1 kN'}]"):
    """Return a case whose second load case has lines of its own, after a dead load that both share."""
    second = f"[[load.cases]]\nname = 'one'\n[[load.cases]]\nname = 'two'\n{of_second}\n"
    return f"[wall]\nblocks = 'wall.json'\n[load]\n{common}\n{second}{RANGE}"


@pytest.fixture
def given(tmp_path, monkeypatch):
    """A function that writes a case file; commands run in its folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "wall.json").write_text(json.dumps(WALL))

    def write(text):
        (tmp_path / "case.toml").write_text(text)
        return sorted(tmp_path.rglob("*"))

    return write


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("wrong", WRONG)
def test_a_wrong_load_case_is_refused_by_its_key_before_the_first_one_is_analysed(
    given, tmp_path, capsys, command, wrong
):
    lines, complaint = WRONG[wrong]
    before = given(shared(lines))
    assert main([command, "case.toml"]) == 2
    said = capsys.readouterr()
    assert said.err.startswith(f"case.toml: {complaint}")
    assert "(load case two); " in said.err
    assert said.err.count("\n") == 1
    assert "ultiplier" not in said.out, "nothing was analysed"
    assert sorted(tmp_path.rglob("*")) == before, "no folder is made"


@pytest.mark.parametrize("command", [*COMMANDS, "study"])
def test_a_single_wrong_load_leaves_no_folder_either(given, tmp_path, capsys, command):
    before = given(f"[wall]\nblocks = 'wall.json'\n[load]\n{WRONG['two kinds'][0]}\n{RANGE}")
    assert main([command, "case.toml"]) == 2
    assert capsys.readouterr().err.startswith("case.toml: load.dead.0: needs one of force and line_load; ")
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.parametrize("command", [["check"], ["limit"], ["segment"], ["run"], ["limit", "--settle", "0"]])
@pytest.mark.parametrize("cases", ["", "[[load.cases]]\nname = 'one'\n"])
def test_a_wall_that_an_extra_dead_load_alone_brings_down_is_said_to_stand_without_it(given, capsys, command, cases):
    """By the key of the load, in the file where that is."""
    given(f"[wall]\nblocks = 'wall.json'\n[load]\n{ON_THE_END}\n{cases}")
    assert main([command[0], "case.toml", *command[1:]]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"case.toml: load.dead: {STANDS_WITHOUT} block 3 would move, unless held by a force of ")
    assert said.endswith("; lower or move the load, support these blocks, or check friction\n")


@pytest.mark.parametrize("command", ["check", "limit", "segment", "run"])
def test_a_wall_that_falls_in_the_second_load_case_is_refused_before_the_first(given, tmp_path, capsys, command):
    before = given(shared(ON_THE_END))
    assert main([command, "case.toml"]) == 2
    said = capsys.readouterr()
    assert said.err.startswith(f"case.toml: load.cases.1.dead: {STANDS_WITHOUT} block 3 would move, ")
    assert "(load case two); " in said.err
    assert "ultiplier" not in said.out
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.parametrize(
    ("command", "lines"),
    [
        ("run", ONE + "[[load.cases]]\nname = 'lift'\ninclination = '90 deg'\n"),
        ("study", "[load]\ninclination = '90 deg'\n"),
        ("sensitivity", "[load]\ninclination = '90 deg'\n"),
    ],
)
def test_what_only_limit_analysis_takes_is_refused_before_any_load_case_is_pushed(
    given, tmp_path, capsys, command, lines
):
    before = given(f"[wall]\nblocks = 'wall.json'\n{lines}{RANGE}analysis = 'macro'\n")
    assert main([command, "case.toml"]) == 2
    key = "load.cases.1.inclination" if command == "run" else "load.inclination"
    assert f"case.toml: {key}: an upright live load has no base shear" in capsys.readouterr().err
    assert sorted(tmp_path.rglob("*")) == before


def test_a_refused_load_case_leaves_the_results_of_an_earlier_analysis(given, tmp_path):
    given(shared(""))
    with undrawn():
        assert main(["limit", "case.toml"]) == 0
    before = given(shared(WRONG["no block"][0]))
    assert main(["limit", "case.toml", "--force"]) == 2
    assert sorted(tmp_path.rglob("*")) == before


def test_a_run_that_cannot_go_on_with_its_second_load_case_does_not_go_on_with_its_first(tmp_path, capsys):
    (tmp_path / "stone.json").write_text(json.dumps(stone(mirror=False)))
    case, folder = tmp_path / "case.toml", tmp_path / "out"
    case.write_text(CASE.format(blocks="stone", common=""))
    with undrawn():
        assert main(["run", str(case), "--output", str(folder), "-q"]) == 0
    (folder / "+x mass" / "summary.json").unlink()
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    other = 'direction = "-x"\ndead = [{blocks = [1], force = "0.1 kN"}]'
    case.write_text(case.read_text().replace('direction = "-x"', other))
    assert main(["run", str(case), "--output", str(folder), "--resume", "-q"]) == 2
    assert "-x mass" in capsys.readouterr().err
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before


def test_load_cases_after_those_of_the_envelope_have_the_number_they_have_in_the_file(given, capsys):
    given(shared(WRONG["no level"][0], "envelope = true"))
    assert main(["limit", "case.toml"]) == 2
    assert "case.toml: load.cases.1.dead.0.level: " in capsys.readouterr().err
    given(shared("", "envelope = true").replace("'two'", "'+x mass'"))
    assert main(["limit", "case.toml"]) == 2
    assert "case.toml: load.cases.1.name: '+x mass' is the name of another one" in capsys.readouterr().err


def test_what_is_wrong_in_the_section_itself_has_the_key_of_the_section(given, capsys):
    given(shared("", WRONG["no block"][0]))
    assert main(["limit", "case.toml"]) == 2
    assert capsys.readouterr().err.startswith("case.toml: load.dead.0.blocks: there is no block 77 (load case one); ")


def test_warnings_of_check_name_the_keys_of_the_file(given, capsys):
    lines = "dead = [{blocks = [2], force = '1 kN'}]\ninclination = '90 deg'"
    given(shared(lines) + "[seismic]\npeak_ground_acceleration = '0.1 g'\n")
    with undrawn():
        assert main(["check", "case.toml"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "give inertia = true to load.dead.0, load.cases.1.dead.0" in said
    assert "run does not: case.toml: load.cases.1.inclination: " in said


FORCES = "distribution = 'per_block'\nlive = [{blocks = [1], force = '100 N'}]"


def test_a_load_case_by_mass_drops_the_forces_of_the_section(given):
    given(shared("distribution = 'mass'", FORCES))
    first, second = load_cases.each(cases.read("case.toml")).values()
    assert [load.force for load in first.load.live] == [100.0]
    wall = load_cases.check(cases.read("case.toml")).wall
    alone = shared("", "").replace("[[load.cases]]\nname = 'one'\n[[load.cases]]\nname = 'two'\n", "")
    given(alone)
    expected = loads_on(wall, cases.read("case.toml").load)
    assert loads_on(wall, second.load).live.tolist() == expected.live.tolist()


def test_the_envelope_drops_the_forces_of_the_section(given, capsys):
    given(f"[wall]\nblocks = 'wall.json'\n[load]\nenvelope = true\n{FORCES}\n")
    assert main(["limit", "case.toml", "--json"]) == 0
    assert list(json.loads(capsys.readouterr().out)) == ["+x mass", "-x mass", "+x mass x height", "-x mass x height"]


def test_a_command_that_takes_one_load_case_says_how_to_leave_out_those_of_the_envelope(given, capsys):
    given(shared("", "envelope = true"))
    assert main(["export", "case.toml"]) == 2
    said = capsys.readouterr().err
    remedy = said.split(" or ")[-1].split()
    assert remedy == ["--set", "load.cases=[]", "--set", "load.envelope=false"]
    shutil.rmtree("results", ignore_errors=True)
    assert main(["check", "case.toml", *remedy]) == 0
