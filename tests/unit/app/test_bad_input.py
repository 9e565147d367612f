"""Bad input: one line that names file and place and says what would be right, exit code 2, nothing touched."""

from __future__ import annotations

import json

import pytest

from orchestrator.app.cli import main
from tests.support.paths import DATA
from tests.support.two_blocks import GROUND, LEFT, WALL, changed

BLOCK_FILES = {
    "unknown key": (changed(["fricton"], 0.5), "fricton", "did you mean friction"),
    "unknown key of a block": (changed(["blocks", 1, "polygn"], []), "block 1.polygn", "did you mean polygon"),
    "wrong unit": (changed(["units", "unit_weight"], "kN/m2"), "units.unit_weight", "use one of N/m3, kN/m3"),
    "no unit": (changed(["units", "length"], None), "units.length", "state the unit"),
    "negative thickness": (changed(["thickness"], -0.5), "thickness", "above 0"),
    "no friction": (changed(["friction"], 0.0), "friction", "above 0"),
    "text for a number": (changed(["friction"], "rough"), "friction", "write a number"),
    "number for a material": (changed(["blocks", 1, "material"], 3), "block 1.material", "write a text"),
    "overlap": (changed(["blocks", 2, "polygon"], [[0.9, 0], [2, 0], [2, 1], [0.9, 1]]), "block 1", "overlaps block 2"),
    "self-crossing": (changed(["blocks", 1, "polygon"], [[0, 0], [1, 1], [1, 0], [0, 1]]), "block 1", "in order"),
    "corners on a line": (
        changed(["blocks", 1, "polygon"], [[0, 0], [0.4, 0.4], [1, 1], [0.7, 0.7]]),
        "block 1: its polygon has no area",
        "not on one line",
    ),
    "mortar in a block": (changed(["mortar"], [[1, 1, 0.01]]), "mortar[0]", "[[1, 2, 0.01]]"),
    "mortar twice": (changed(["mortar"], [[1, 2, 0.01], [2, 1, 0.02]]), "mortar[1]", "give every pair once"),
    "list for a name": (changed(["name"], ["a"]), "name", "write a text"),
    "control character in a name": (changed(["name"], "a\x1b[31m"), "name", "leave it out"),
    "two corners": (changed(["blocks", 1, "polygon"], [[0, 0], [1, 1]]), "block 1.polygon", "three corners"),
    "touches nothing": (
        changed(["blocks", 2, "polygon"], [[1, 5], [2, 5], [2, 6], [1, 6]]),
        "block 2",
        "touches no other block",
    ),
    "no support": (changed(["blocks", 0, "fixed"], False), "blocks", '"fixed": true'),
    "same id twice": (changed(["blocks", 2, "id"], 1), "block 1", "its own id"),
    "weightless": (changed(["blocks", 1, "unit_weight"], 0), "block 1", "above 0"),
    "corners repeated": (
        changed(["blocks", 1, "polygon"], [[0, 0], [1, 0], [1, 0], [0, 0]]),
        "block 1.polygon",
        "list every corner once",
    ),
    "a number no float holds": (changed(["thickness"], 10**400), "thickness", "write a number"),
    "no blocks": (changed(["blocks"], None), "blocks", "is missing"),
    "empty": (changed(["blocks"], []), "blocks", "support"),
    "cannot stand": (
        changed(["blocks", 2, "polygon"], [[0.9, 1], [2, 1], [2, 2], [0.9, 2]]),
        "cannot stand under its own weight",
        "2",
    ),
}
VALUES = {
    "unknown section": ("[mash]\nsize = 1", "mash", "mesh"),
    "unknown key": ("[mesh]\nsiz = 1", "mesh.siz", "did you mean size"),
    "wrong unit": ('[mesh]\nsize = "3 kN"', "mesh.size", "use one of m, mm"),
    "no unit": ('[mesh]\nsize = "3"', "mesh.size", "use one of m, mm"),
    "negative": ('[mesh]\nsize = "-3 mm"', "mesh.size", "write at least 1e-09"),
    "elements larger than any number's square": (
        "[mesh]\nsize = 1e300",
        "mesh.size",
        "write at most 1e+09 m",
    ),
    "elements smaller than any number's square": (
        "[mesh]\nsize = 1e-300",
        "mesh.size",
        "write at least 1e-09",
    ),
    "friction of zero": (
        "[wall]\nblocks = 'wall.json'\nfriction = 0",
        "wall.friction",
        "write at least 1e-09",
    ),
    "not a number": ("[macroblocks]\ntol_n = nan", "macroblocks.tol_n", "write a finite one"),
    "below the noise": ("[macroblocks]\ntol_n = 1e-15", "macroblocks.tol_n", "use at least"),
    "a number no float holds": (f"[mesh]\nsize = {10**400}", "mesh.size", "write a finite one"),
    "a number too long to read": (f"[mesh]\nsize = 1{5000 * '0'}", "is not TOML", "example"),
    "part of a layer": ("[mesh]\nlayers = 1.5", "mesh.layers", "whole number"),
    "number for a section": ("mesh = 3", "mesh", "write [mesh]"),
    "text for a list": ("[run]\nmodels = 'both'", "run.models", "write a list"),
    "blocks nowhere": ("[wall]\nblocks = ''", "wall.blocks", "not empty"),
    "a section of no keys": ("[seismic]", "seismic", "peak_ground_acceleration"),
    "not TOML": ("[mesh\nsize = 1", "is not TOML", "example"),
}
LOADS = {
    "no such direction": ('[load]\ndirection = "up"', "load.direction", "'+x' or '-x'"),
    "a direction of two numbers": ("[load]\ndirection = [1, 0]", "load.direction", "'+x' or '-x'"),
    "dead load without a unit": ('[[load.dead]]\nblocks = [1]\nforce = "5"', "load.dead.0.force", "use one of N, kN"),
    "dead load on nothing": ("[[load.dead]]\nblocks = []\nforce = 5", "load.dead.0", "give one of the two"),
    "unknown key of a load": ("[[load.dead]]\nblocks = [1]\nforc = 5", "load.dead.0.forc", "did you mean force"),
    "turned too far": ('[load]\ninclination = "91 deg"', "load.inclination", "write at most 90 deg"),
}
MORTAR = {
    "joints of a metre": ("[joints]\ntolerance = 1", "joints.tolerance", "write at most 10 mm"),
    "stiffness in another unit": ('[[joints.classes]]\nnormal_stiffness = "5 GPa"', "normal_stiffness", "GN/m3, N/mm3"),
    "stiffness of zero": ("[[joints.classes]]\nshear_stiffness = 0", "shear_stiffness", "write more than 0"),
    "stiffness twice": (
        "[[joints.classes]]\nnormal_stiffness = 1e9\nmortar_modulus = 1e9\nmortar_thickness = 0.01",
        "joints.classes.0.normal_stiffness",
        "give one of the two",
    ),
    "mortar of no thickness": (
        "[[joints.classes]]\nmortar_modulus = 1e9",
        "joints.classes.0.mortar_thickness",
        'give it, as in "10 mm"',
    ),
    "bonded and elastic in shear": (
        "[[joints.classes]]\nshear_stiffness = 1e9\ncohesion = 1e4",
        "joints.classes",
        "not yet in the FE pushover",
    ),
    "mortar that snaps": (
        "[[joints.classes]]\nnormal_stiffness = 1e8\ncohesion = 1e5\ntensile_strength = 1e5",
        "contact.softening_displacement",
        "it would snap",
    ),
}
CASES = VALUES | LOADS | MORTAR

LIMIT_CASES = {
    "class of unknown stone": (
        "[[joints.classes]]\nbetween = ['a', 'b']",
        "joints.classes.0.between",
        "material",
    ),
    "dead load of two kinds": ("[[load.dead]]\nblocks = [1]", "load.dead.0", "give one of the two"),
    "dead load on air": ("[[load.dead]]\nblocks = [99]\nforce = 5", "load.dead.0.blocks", "blocks of the wall"),
    "no live load": ('[load]\ndistribution = "per_block"', "load.live", "distribution"),
    "friction of a joint class": ("[[joints.classes]]\nfriction = 1e12", "joints.classes.0.friction", "1000000000"),
    "too little friction": (
        "[[joints.classes]]\nfriction = 1e-12",
        "joints.classes.0.friction",
        "write at least 1e-09",
    ),
    "cohesion": ("[[joints.classes]]\ncohesion = 1e20", "joints.classes.0.cohesion", "1e+06 times the mean weight"),
    "tension": (
        "[[joints.classes]]\ntensile_strength = 1e20",
        "joints.classes.0.tensile_strength",
        "is the unit right?",
    ),
    "force beyond numbers": ("[[load.dead]]\nblocks = [1]\nforce = 1e300", "load.dead.0.force", "1e+06 times the mean"),
    "force of another unit": ("[[load.dead]]\nblocks = [1]\nforce = 1e12", "load.dead.0.force", "is the unit right?"),
    "line load": ("[[load.dead]]\nblocks = [1]\nline_load = 1e12", "load.dead.0.line_load", "is the unit right?"),
    "live force": (
        '[load]\ndistribution = "per_block"\nlive = [{blocks = [1], force = 1e12}]',
        "load.live.0.force",
        "is the unit right?",
    ),
    "strength of a tie": (
        "[[reinforcement.ties]]\nblocks = [1]\nstart = [0.5, 0.5]\nend = [-2, 0.5]\nstrength = 1e20",
        "reinforcement.ties.0.strength",
        "is the unit right?",
    ),
    "mortar of no modulus": (
        '[[joints.classes]]\nmortar_thickness = "10 mm"',
        "joints.classes.0.mortar_thickness",
        "mortar_modulus",
    ),
}
"""refused by limit analysis, which comes first in a run too"""


def refused(capsys, *arguments):
    """Run a command that must be refused and return the one line of its complaint; what it does may be said before."""
    assert main([str(argument) for argument in arguments]) == 2
    printed = capsys.readouterr()
    assert all(line.startswith("micro-LA: ") for line in printed.out.splitlines())
    lines = printed.err.splitlines()
    assert len(lines) == 1, printed.err
    return lines[0]


@pytest.fixture
def output(tmp_path):
    """An earlier run's folder that must stay as it is."""
    folder = tmp_path / "results"
    folder.mkdir()
    (folder / "summary.json").write_text("earlier")
    yield folder
    assert [path.name for path in folder.iterdir()] == ["summary.json"]
    assert (folder / "summary.json").read_text() == "earlier"


@pytest.mark.parametrize("kind", BLOCK_FILES)
def test_block_file(kind, tmp_path, output, capsys):
    record, place, remedy = BLOCK_FILES[kind]
    file = tmp_path / "wall.json"
    file.write_text(json.dumps(record))
    line = refused(capsys, "run", file, "--output", output, "--force")
    assert str(file) in line
    assert place in line
    assert remedy in line


@pytest.mark.parametrize("command", ["check", "limit", "run", "study", "export"])
@pytest.mark.parametrize(
    ("name", "kind", "needed"),
    [
        ("wall.dxf", "a drawing", "--thickness '300 mm' "),
        ("wall.SVG", "a drawing", "--thickness '300 mm' "),
        ("wall.txt", "row notation", ""),
        ("wall.png", "a picture", "--thickness '300 mm' --scale '2 mm' "),
    ],
)
def test_a_drawing_is_no_case(command, name, kind, needed, tmp_path, capsys):
    file = tmp_path / name
    file.write_bytes(b"\x89PNG" if name == "wall.png" else b"0\nSECTION\n")
    line = refused(capsys, command, file)
    assert line.startswith(f"{file}: is {kind}")
    assert f"; `python -m orchestrator import {file} {needed}--output wall.json` makes a wall of it" in line


@pytest.mark.parametrize("kind", LIMIT_CASES)
def test_case_file_for_limit_analysis(kind, tmp_path, capsys):
    text, place, remedy = LIMIT_CASES[kind]
    (tmp_path / "wall.json").write_text(json.dumps(WALL))
    file = tmp_path / "case.toml"
    file.write_text(f"{text}\n[wall]\nblocks = 'wall.json'\n")
    line = refused(capsys, "limit", file)
    assert str(file) in line
    assert place in line
    assert remedy in line


@pytest.mark.parametrize("kind", CASES)
def test_case_file(kind, tmp_path, output, capsys):
    text, place, remedy = CASES[kind]
    (tmp_path / "wall.json").write_text(json.dumps(WALL))
    file = tmp_path / "case.toml"
    file.write_text(text if "[wall]" in text else f"{text}\n[wall]\nblocks = 'wall.json'\n")
    line = refused(capsys, "run", file, "--output", output, "--force")
    assert str(file) in line
    assert place in line
    assert remedy in line


@pytest.mark.parametrize("name", ["absent.toml", "absent.json"])
def test_missing_file(name, tmp_path, output, capsys):
    line = refused(capsys, "run", tmp_path / name, "--output", output, "--force")
    assert str(tmp_path / name) in line
    assert "no such file" in line


def test_case_that_points_to_a_missing_block_file(tmp_path, output, capsys):
    (tmp_path / "case.toml").write_text("[wall]\nblocks = 'absent.json'")
    assert "absent.json: no such file" in refused(capsys, "run", tmp_path / "case.toml", "--output", output, "--force")


def test_not_json(tmp_path, output, capsys):
    (tmp_path / "wall.json").write_text("{blocks")
    assert "is not JSON" in refused(capsys, "run", tmp_path / "wall.json", "--output", output, "--force")


def test_arch_too_thin_to_stand_is_refused_before_any_finite_element(output, capsys):
    thin = DATA / "arch27_t0106.json"
    line = refused(capsys, "run", thin, "--output", output, "--force")
    assert "cannot stand under its own weight" in line


def test_a_settlement_of_a_wall_that_cannot_stand_is_refused_as_check_refuses_it(tmp_path, capsys):
    """Three quarters of the stone stand out beyond its support."""
    record = WALL | {"blocks": [GROUND, {"id": 1, "polygon": [[2.5, 0], [4.5, 0], [4.5, 1], [2.5, 1]]}]}
    file = tmp_path / "wall.json"
    file.write_text(json.dumps(record))
    checked = refused(capsys, "check", file, "--output", tmp_path / "checked")
    assert "cannot stand under its own weight: block 1 would move" in checked
    settled = refused(capsys, "limit", file, "--settle", "0", "--output", tmp_path / "settled")
    assert settled == checked


@pytest.mark.parametrize(
    ("ends", "key"),
    [("cohesion = [0.1, 1e20]", "sensitivity.cohesion"), ("friction = [0.1, 1e12]", "sensitivity.friction.1")],
)
def test_a_range_with_an_end_that_is_refused_is_refused_before_anything_runs(ends, key, tmp_path, capsys):
    (tmp_path / "wall.json").write_text(json.dumps(WALL))
    file, output = tmp_path / "case.toml", tmp_path / "study"
    file.write_text(f'[wall]\nblocks = "wall.json"\n[sensitivity]\nanalysis = "limit"\n{ends}\n')
    assert f"{file}: {key}: " in refused(capsys, "sensitivity", file, "--output", output)
    assert not output.exists()


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_the_largest_forces_that_are_taken_are_analysed_without_a_warning(tmp_path, capsys):
    """2 GN on a stone of 10 kN: 2e5 times its weight; it slides at the coefficient of friction times both."""
    (tmp_path / "wall.json").write_text(json.dumps(WALL | {"blocks": [GROUND, LEFT]}))
    file = tmp_path / "case.toml"
    file.write_text('[wall]\nblocks = "wall.json"\n[[load.dead]]\nblocks = [1]\nforce = "2000 MN"\n')
    assert main(["limit", str(file), "--json", "--output", str(tmp_path / "out")]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["non_associative"] == pytest.approx(0.6 * (2e9 + 10e3) / 10e3, rel=1e-6)


def test_the_wall_itself_is_accepted(tmp_path, capsys):
    """Otherwise every refusal above would prove nothing."""
    (tmp_path / "wall.json").write_text(json.dumps(WALL))
    assert main(["check", str(tmp_path / "wall.json")]) == 0
    assert "2 blocks, 3 joints" in capsys.readouterr().out
