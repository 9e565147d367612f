"""import, new, schema, check as a person calls them: files that are read back, examples of --help that work."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import tomllib
from pathlib import Path

import ezdxf
import fastjsonschema
import pytest
from PIL import Image

from orchestrator.app import cli
from orchestrator.app.file_commands import EXAMPLE
from orchestrator.basis.program import commit
from orchestrator.loads import DeadLoad, LiveLoad
from orchestrator.masonry.joints import JointClass
from orchestrator.masonry.sources.block_files import read_blocks
from orchestrator.settings import case as cases
from orchestrator.settings import reference
from tests.support.drawings import METRES, polylines
from tests.support.intake import WALL_1, as_polylines, assert_same_wall, associative, painted, written
from tests.support.paths import DATA, PROJECT
from tests.support.undrawn import undrawn

COMMANDS = ("run", "check", "limit", "segment", "import", "new", "schema", "export")
PUBLISHED = 0.643
"""associative multiplier of wall 1, Ferris and Tin-Loi (2001), three digits"""


def call(*arguments):
    return cli.main([str(argument) for argument in arguments])


def help_of(capsys, *command):
    with pytest.raises(SystemExit) as ended:
        call(*command, "--help")
    assert ended.value.code == 0
    return capsys.readouterr().out


@pytest.mark.parametrize("name", ["wall.dxf", "wall.txt", "wall.json", "wall.png"])
def test_import_of_every_kind_gives_a_block_file_and_its_picture(tmp_path, capsys, name):
    source, output = tmp_path / name, tmp_path / "out" / "blocks.json"
    options = ["--thickness", "100 mm", "--unit-weight", "25 kN/m3", "--friction", "0.65"]
    if name == "wall.dxf":
        written(source, as_polylines(WALL_1))
    elif name == "wall.png":
        painted(source, WALL_1, 0.0025, 0.01)
        options += ["--scale", "2.5mm", "--ground", "200 mm", "--mortar", "15 mm"]
    else:
        options = []
        kind = "templates/wall1.txt" if name == "wall.txt" else "tests/data/ferris_tinloi_wall1.json"
        source.write_text((PROJECT / kind).read_text())
    assert call("import", source, "--output", output, *options) == 0
    said = capsys.readouterr().out
    assert "33 blocks, 1 support, " in said
    wall = read_blocks(output)
    if name != "wall.png":
        assert "2 x 1.05 m, 0.1 m thick: " in said
        assert_same_wall(wall, WALL_1)
    assert associative(wall) == pytest.approx(PUBLISHED, rel=0.02 if name == "wall.png" else 1e-3)
    with Image.open(output.with_name(f"{output.stem}_imported.png")) as picture:
        assert min(picture.size) > 300
    assert call("check", output, "--output", tmp_path / "run") == 0


@pytest.mark.parametrize(
    ("name", "options", "complaint"),
    [
        ("wall.dxf", [], "--thickness: is missing"),
        ("wall.dxf", ["--thickness", "3 kN"], "--thickness: unit 'kN' does not fit; use one of m, mm"),
        ("wall.dxf", ["--thickness=-3"], "--thickness: -3 m is not accepted; write more than 0 m"),
        ("wall.dxf", ["--thickness", "0.1", "--scale", "1 mm"], "--scale: does not go with a drawing"),
        ("wall.dxf", ["--thickness", "0.1", "--tolerance", "1 m"], "--tolerance:"),
        ("wall.dxf", ["--thickness", "0.1", "--unit", "ell"], "--unit: unit 'ell' does not fit"),
        ("wall.png", ["--thickness", "0.1"], "--scale: is missing"),
        ("wall.png", ["--thickness", "0.1", "--scale", "1mm", "--stones", "red"], "--stones: 'red' is not accepted"),
        ("wall.txt", ["--thickness", "0.1"], "--thickness: states everything itself"),
        ("wall.doc", [], "files ending in '.doc' are not read"),
        ("absent.dxf", [], "no such file"),
        ("absent.txt", [], "no such file"),
        ("absent.png", ["--thickness", "0.1", "--scale", "1mm"], "no such file"),
    ],
)
def test_import_that_is_refused(tmp_path, capsys, name, options, complaint):
    if name == "wall.dxf":
        written(tmp_path / name, as_polylines(WALL_1))
    elif not name.startswith("absent"):
        (tmp_path / name).write_text("unit = mm")
    assert call("import", tmp_path / name, "--output", tmp_path / "out.json", *options) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    (line,) = printed.err.splitlines()
    assert str(tmp_path / name) in line
    assert complaint in line
    assert not (tmp_path / "out.json").exists()


@pytest.mark.parametrize(
    ("option", "said"),
    [
        ("--unit-weight=20", "UNUSUAL: unit weight 0.02 kN/m3, usual are 3 to 32 kN/m3; is 20 kN/m3 meant?"),
        ("--friction=31", "UNUSUAL: friction 31, usual are 0.2 to 1.5; is an angle of 31 degrees meant?"),
        ("--unit-weight=20 kN/m3", ""),
    ],
)
@pytest.mark.parametrize("kind", ["plane", "space"])
def test_a_material_of_another_unit_is_pointed_out(tmp_path, capsys, kind, option, said):
    drawn = [polylines(tmp_path / "wall.dxf", WALL_1), "--thickness", "300 mm"]
    options = drawn if kind == "plane" else [DATA / "space" / "compas_dem_wall.obj", "--unit", "m"]
    assert call("import", *options, option, "--output", tmp_path / "wall.json") == 0
    printed = capsys.readouterr().out
    assert said in printed
    assert bool(said) == ("UNUSUAL" in printed)


@pytest.mark.parametrize("layer", ["0", "1e3", "12"])
def test_a_layer_whose_name_is_a_number_is_a_layer(tmp_path, layer):
    """What is drawn without choosing a layer is on layer 0 of a DXF file."""
    drawing = ezdxf.new()
    for x in (0, 500):
        outline = [(x, 0), (x + 500, 0), (x + 500, 300), (x, 300)]
        drawing.modelspace().add_lwpolyline(outline, close=True, dxfattribs={"layer": layer})
    drawing.saveas(tmp_path / "two.dxf")
    options = ["--thickness", "300 mm", "--ground", "200 mm", "--unit", "mm", "--blocks", layer]
    assert call("import", tmp_path / "two.dxf", "--output", tmp_path / "two.json", *options) == 0
    assert len(read_blocks(tmp_path / "two.json").blocks) == 3


def test_a_drawing_in_millimetres_that_states_metres_is_asked_about_its_unit(tmp_path, capsys):
    """Stones 3 mm apart look like stones 3 m apart: a tolerance of metres is no remedy."""
    drawn = polylines(tmp_path / "wall.dxf", WALL_1, gap=0.003)
    document = ezdxf.readfile(drawn)
    document.header["$INSUNITS"] = METRES
    document.saveas(drawn)
    assert call("import", drawn, "--output", tmp_path / "wall.json", "--thickness", "300 mm") == 2
    said = capsys.readouterr().err
    assert "m: is the unit right?" in said
    assert "--tolerance" not in said


def test_a_refused_import_lists_three_warnings(tmp_path, capsys):
    """Nine gaps of 4 mm in a row of ten blocks, and an eleventh in the air."""
    corners = [(0.504 * k, 0.0) for k in range(10)] + [(1.0, 5.0)]
    polygons = [[[x, y], [x + 0.5, y], [x + 0.5, y + 0.3], [x, y + 0.3]] for x, y in corners]
    ground = {"id": 0, "polygon": [[-1, -1], [9, -1], [9, 0], [-1, 0]], "fixed": True}
    blocks = [ground, *({"id": k, "polygon": polygon} for k, polygon in enumerate(polygons, 1))]
    (tmp_path / "row.json").write_text(json.dumps(EXAMPLE | {"blocks": blocks}))
    arguments = ("--tolerance", "1 mm", "--output", tmp_path / "out.json")
    assert call("import", tmp_path / "row.json", *arguments) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "touches no other block" in line
    assert line.count("gap of 4 mm") == 3
    assert " and 6 more; else " in line


@pytest.mark.parametrize("command", ["import", "check"])
def test_millimetres_stated_as_metres_are_pointed_out(tmp_path, capsys, command):
    text = (PROJECT / "templates" / "wall1.txt").read_text().replace("unit = mm", "unit = m")
    (tmp_path / "wall.txt").write_text(text)
    assert call("import", tmp_path / "wall.txt", "--output", tmp_path / "wall.json") == 0
    if command == "check":
        capsys.readouterr()
        assert call("check", tmp_path / "wall.json", "--output", tmp_path / "run") == 0
    assert "WARNING: the wall measures 2400 m: is the unit right?" in capsys.readouterr().out


def test_new_writes_a_case_that_check_accepts_and_draws(tmp_path, capsys):
    assert call("new", "north.toml", "--output", tmp_path) == 0
    assert call("check", tmp_path / "north.toml", "--output", tmp_path / "run") == 0
    printed = capsys.readouterr().out
    assert "2 blocks, 3 joints, nothing to complain about" in printed
    assert (tmp_path / "run" / "figures" / "blocks.png").exists()
    assert call("new", "north", "--output", tmp_path) == 2
    assert "north.toml: exists already" in capsys.readouterr().err


def test_a_table_behind_a_new_case_is_taken(tmp_path, capsys, monkeypatch):
    """`dead = []` in the file would refuse [[load.dead]] below it; one block is no "1 blocks"."""
    monkeypatch.chdir(tmp_path)
    assert cli.main(["new", "mine"]) == 0
    with (tmp_path / "mine.toml").open("a") as file:
        file.write('\n[[load.dead]]\nblocks = [1]\nforce = "1 kN"\n')
    assert cli.main(["check", str(tmp_path / "mine.toml"), "--output", str(tmp_path / "out")]) == 0
    wall = json.loads((tmp_path / "mine.json").read_text())
    wall["blocks"] = wall["blocks"][:2]
    (tmp_path / "one.json").write_text(json.dumps(wall))
    capsys.readouterr()
    assert cli.main(["check", str(tmp_path / "one.json"), "--output", str(tmp_path / "one")]) == 0
    assert "1 block, 1 joint," in capsys.readouterr().out


@pytest.mark.parametrize("output", [".", "cases", "cases/deep", "../beside"])
def test_a_new_case_finds_its_block_file_from_wherever_it_is_written(tmp_path, monkeypatch, output):
    here = tmp_path / "here"
    (here / "walls").mkdir(parents=True)
    monkeypatch.chdir(here)
    (here / "walls" / "one.json").write_bytes((PROJECT / "tests/data/ferris_tinloi_wall1.json").read_bytes())
    for blocks in ("walls/one.json", str(here / "walls" / "one.json")):
        assert call("new", "one", "--blocks", blocks, "--output", output, "--force") == 0
        assert call("check", f"{output}/one.toml", "--output", "checked") == 0
        assert cases.read(Path(output) / "one.toml").wall.blocks.startswith("/") == blocks.startswith("/")
    assert call("new", "two", "--output", output) == 0
    assert call("check", f"{output}/two.toml", "--output", "checked") == 0


def test_a_new_case_says_where_its_block_file_is_not_there_yet(tmp_path, capsys):
    assert call("new", "wall", "--blocks", "gone.json", "--output", tmp_path) == 0
    assert "gone.json is not there yet" in capsys.readouterr().out


def test_a_new_case_file_states_every_default(tmp_path):
    (tmp_path / "full.toml").write_text(reference.commented_case("full", "wall.json"))
    (tmp_path / "bare.toml").write_text("name = 'full'\n[wall]\nblocks = 'wall.json'\n")
    full, bare = cases.read(tmp_path / "full.toml"), cases.read(tmp_path / "bare.toml")
    assert full == bare
    record = tomllib.loads((tmp_path / "full.toml").read_text())
    for section, kind in cases.section_types().items():
        left_out = re.findall(r"^# (\w+) =   \(left out\)", (tmp_path / "full.toml").read_text(), re.M)
        stated = {*record[section], *left_out}
        assert set(kind.__dataclass_fields__) <= stated, section


def test_new_writes_what_most_walls_change_and_every_key_on_demand(tmp_path):
    """Both are the case with nothing but defaults; the short one is read at a glance and says where the rest stands."""
    assert call("new", "north", "--output", tmp_path) == 0
    text = (tmp_path / "north.toml").read_text()
    short = cases.read(tmp_path / "north.toml")
    assert call("new", "north", "--all-keys", "--force", "--output", tmp_path) == 0
    whole = (tmp_path / "north.toml").read_text()
    assert cases.read(tmp_path / "north.toml") == short
    assert len(text.splitlines()) < 80 < len(whole.splitlines())
    assert "--all-keys" in text
    assert 'elastic_modulus = "3.5 GPa"' in text
    assert not re.search(r'"[\d.]*e[-+]\d+ m"|\d{6}', text)


@pytest.mark.parametrize("name", ["a/b", "", "..\ud800", "a\nb"])
def test_a_name_that_is_none_is_refused(tmp_path, capsys, name):
    assert call("new", name, "--output", tmp_path) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1
    assert not list(tmp_path.iterdir())


def test_schema_accepts_what_is_accepted_and_refuses_what_is_refused(capsys):
    assert call("schema") == 0
    schema = json.loads(capsys.readouterr().out, parse_constant=lambda word: pytest.fail(word))
    assert schema["$schema"].endswith("2020-12/schema")
    as_draft_7 = json.dumps(schema | {"$schema": "http://json-schema.org/draft-07/schema#"})  # all fastjsonschema knows
    validate = fastjsonschema.compile(json.loads(as_draft_7.replace("$defs", "definitions")))
    for text in ((PROJECT / "templates" / "benchmark1.toml").read_text(), reference.commented_case("x", "x.json")):
        validate(tomllib.loads(text))
    timber = {"material": "timber", "unit_weight": "6 kN/m3", "elastic_modulus": "11 GPa", "friction": 0.4}
    floor = {"level": "2.8 m", "line_load": "6 kN/m", "inertia": True}
    good = {"wall": {"blocks": "wall.json"}}
    validate({"wall": {"blocks": "wall.json", "classes": [timber]}, "load": {"dead": [floor]}})
    validate(good | {"load": {"cases": [{"name": "+x"}, {"name": "-x", "direction": "-x", "dead": [floor]}]}})
    for bad in (
        {},
        good | {"mash": {}},
        good | {"mesh": {"size": "3 kN"}},
        good | {"mesh": {"size": -1}},
        good | {"load": {"direction": "up"}},
        good | {"load": {"cases": [{"direction": "-x"}]}},
        good | {"load": {"dead": [floor | {"level": "2.8 kN"}]}},
        {"wall": {"blocks": "wall.json", "classes": [timber | {"unit_weight": "6 kN/m2"}]}},
    ):
        with pytest.raises(fastjsonschema.JsonSchemaValueException):
            validate(bad)


def test_the_schema_knows_every_bound():
    """A unit that stands before a bound in a setting's type hides it: `Annotated[float, Gt(0), Unit("m")]`."""
    text = json.dumps(reference.schema())
    assert '"exclusiveMinimum": 0' in text
    assert not re.search(r'"(gt|ge|lt|le)": ', text)


@pytest.mark.parametrize("command", COMMANDS[1:])
def test_examples_of_help_work_when_pasted(capsys, monkeypatch, tmp_path, command):
    for name in ("templates", "meshes"):
        (tmp_path / name).symlink_to(PROJECT / name)
    monkeypatch.chdir(tmp_path)
    text = help_of(capsys, command)
    (example,) = re.findall(r"^  \.venv/bin/python -m orchestrator (.*)$", text, re.M)
    assert example.startswith(command)
    with undrawn():
        assert cli.main(shlex.split(example)) == 0


@pytest.mark.parametrize("command", [(), *((command,) for command in COMMANDS)])
def test_help_documents_the_exit_codes(capsys, command):
    text = help_of(capsys, *command)
    assert "exit codes: 0 done, 1 failed while running, 2 bad input, 3 finished but not valid, 130 interrupted" in text


def test_version(capsys):
    with pytest.raises(SystemExit) as ended:
        call("--version")
    assert ended.value.code == 0
    said = capsys.readouterr().out
    assert re.fullmatch(r"orchestrator \d+\.\d+\.\d+(, commit [0-9a-f]{12}(\+changes)?)?\n", said)
    assert commit() in said


def test_settings_reference_names_every_key_with_default_and_unit():
    page = reference.reference_page()
    for section, kind in cases.section_types().items():
        assert f"## `[{section}]`" in page
        for key in kind.__dataclass_fields__:
            assert f"| `{key}` |" in page
    assert "| `size` | left out | m | ≥ 1e-09, ≤ 1e+09 |" in page


@pytest.mark.parametrize("kind", [*cases.section_types().values(), JointClass, DeadLoad, LiveLoad])
def test_every_setting_says_what_it_is(kind):
    """Unit and range alone do not."""
    silent = [one.key for one in reference.settings_of(kind) if len(one.meaning.split()) < 2]
    assert not silent


def test_bash_completes_commands(tmp_path, capsys):
    """As bash does it: the script is sourced, its function called with what stands on the line."""
    with pytest.raises(SystemExit) as ended:
        call("--print-completion", "bash")
    assert ended.value.code == 0
    script = tmp_path / "completion.sh"
    script.write_text(capsys.readouterr().out)
    ask = (
        f"source {script}; COMP_WORDS=(orchestrator seg); COMP_CWORD=1; "
        "$(complete -p orchestrator | sed 's/.*-F \\([^ ]*\\) .*/\\1/') orchestrator seg orchestrator; "
        "echo ${COMPREPLY[@]}"
    )
    done = subprocess.run(["bash", "-c", ask], capture_output=True, text=True, timeout=20, check=True)
    assert done.stdout.split() == ["segment"]
