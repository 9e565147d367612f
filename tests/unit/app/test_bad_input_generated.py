"""Generated bad input: whatever a file holds, it is read, or refused in one line that names it, with exit code 2.

`make verify` runs ten times as many cases (HYPOTHESIS_CASES=2000, shared by the tests below). Sizes that are refused
are stated beside each reader (LARGEST_FILE, LARGEST_COUNT, LARGEST_CORNERS, LARGEST_PICTURE).
"""

from __future__ import annotations

import json
import os
import string
from copy import deepcopy

import ezdxf
import pytest
import tomli_w
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from orchestrator.app.cli import main
from orchestrator.masonry.sources import block_files, dxf, rows
from orchestrator.settings import case as cases
from tests.support.intake import ROWS
from tests.support.two_blocks import WALL

CASES = int(os.environ.get("HYPOTHESIS_CASES", "200"))
TESTS = 8
SLOWEST = 20_000
"""ms one case may take on a busy machine; a hang is longer"""
HOLD = (HealthCheck.function_scoped_fixture, HealthCheck.too_slow)  # the fixture only gives a folder
generated = settings(max_examples=CASES // TESTS, deadline=SLOWEST, suppress_health_check=HOLD, derandomize=True)

NUMBERS = st.one_of(
    st.floats(), st.integers(), st.sampled_from([0, -1, 1e308, 5e-324, 10**400, 1e-9, 0.1, float("nan"), float("inf")])
)
WORDS = st.one_of(
    st.text(max_size=12), st.sampled_from(["", "450 mm", "3 kN", "none", "inf", "1e999 m", "../..", "\0"])
)
LEAVES = st.one_of(st.none(), st.booleans(), NUMBERS, WORDS)
VALUES = st.recursive(
    LEAVES, lambda v: st.one_of(st.lists(v, max_size=4), st.dictionaries(WORDS, v, max_size=3)), max_leaves=8
)


def accepted_or_refused(capsys, path, *command):
    """Run a command; it ends with 0, or with 2 and one line on standard error that names the file and no traceback."""
    code = main([command[0], str(path), *map(str, command[1:])])
    printed = capsys.readouterr()
    assert code in (0, 2), printed.err
    if code == 2:
        assert printed.out == ""
        (line,) = printed.err.splitlines()
        assert str(path.parent) in line
        assert "Traceback" not in line
        assert "; " in line, "a remedy"
    return code


def places(record, above=()):
    """Return the path of every value in a record."""
    found = []
    items = record.items() if isinstance(record, dict) else enumerate(record) if isinstance(record, list) else ()
    for key, value in items:
        found += [(*above, key), *places(value, (*above, key))]
    return found


@st.composite
def damaged(draw, record):
    """Draw a copy of a record with one to three values replaced, removed, or joined by one of another name."""
    record = deepcopy(record)
    for _ in range(draw(st.integers(1, 3))):
        *above, key = draw(st.sampled_from(places(record)))
        target = record
        for part in above:
            target = target[part]
        how = draw(st.sampled_from(["replace", "remove", "add"]))
        if how == "replace":
            target[key] = draw(VALUES)
        elif how == "remove":
            del target[key]
        elif isinstance(target, dict):
            target[draw(WORDS)] = draw(VALUES)
        if not places(record):
            break
    return record


@st.composite
def garbled(draw, content: bytes):
    """Draw a copy of a file with a few bytes changed, a piece repeated, removed, or the end cut off."""
    for _ in range(draw(st.integers(1, 4))):
        first = draw(st.integers(0, max(0, len(content) - 1)))
        last = min(len(content), first + draw(st.integers(1, 40)))
        how = draw(st.sampled_from(["bytes", "repeat", "remove", "cut"]))
        middle = {"bytes": draw(st.binary(max_size=6)), "repeat": 3 * content[first:last]}.get(how, b"")
        content = content[:first] + middle + (b"" if how == "cut" else content[last:])
    return content


def case_file():
    sections = {name: {} for name in cases.section_types()}
    return sections | {
        "name": "a wall",
        "wall": {"blocks": "wall.json", "thickness": "300 mm", "friction": 0.5},
        "mesh": {"size": "100 mm", "layers": 2},
        "load": {"direction": "-x"},
        "macroblocks": {"tol_n": 1e-3, "tol_d": "none"},
        "run": {"models": ["macro"]},
        "seismic": {"ground": "B"},
    }


def toml(record):
    """Return a record as TOML; what TOML does not know (null, whole numbers of 400 digits) as text."""
    try:
        return tomli_w.dumps(record).encode()
    except (TypeError, ValueError):
        return repr(record).encode(errors="replace")


@generated
@given(data=st.data())
def test_case_file_with_other_values(tmp_path, capsys, data):
    (tmp_path / "wall.json").write_text(json.dumps(WALL))
    (tmp_path / "case.toml").write_bytes(toml(data.draw(damaged(case_file()))))
    accepted_or_refused(capsys, tmp_path / "case.toml", "check", "--output", tmp_path / "run")


@generated
@given(content=st.one_of(st.binary(max_size=200), garbled(toml(case_file()))))
def test_case_file_of_other_bytes(tmp_path, capsys, content):
    (tmp_path / "wall.json").write_text(json.dumps(WALL))
    (tmp_path / "case.toml").write_bytes(content)
    accepted_or_refused(capsys, tmp_path / "case.toml", "check", "--output", tmp_path / "run")


@generated
@given(record=damaged(WALL))
def test_block_file_with_other_values(tmp_path, capsys, record):
    (tmp_path / "wall.json").write_text(json.dumps(record))
    accepted_or_refused(capsys, tmp_path / "wall.json", "check", "--output", tmp_path / "run")


@generated
@given(content=st.one_of(st.binary(max_size=200), garbled(json.dumps(WALL).encode())))
def test_block_file_of_other_bytes(tmp_path, capsys, content):
    (tmp_path / "wall.json").write_bytes(content)
    accepted_or_refused(capsys, tmp_path / "wall.json", "check", "--output", tmp_path / "run")


def drawing(path):
    document = ezdxf.new("R2000")
    document.header["$INSUNITS"] = 4
    space = document.modelspace()
    space.add_lwpolyline([(0, 0), (500, 0), (500, 300), (0, 300)], close=True, dxfattribs={"layer": "blocks"})
    space.add_line((500, 0), (900, 0), dxfattribs={"layer": "blocks"})
    space.add_line((900, 0), (500, 300), dxfattribs={"layer": "blocks"})
    space.add_line((500, 300), (500, 0), dxfattribs={"layer": "blocks"})
    space.add_arc((250, 300), 250, 0, 180, dxfattribs={"layer": "blocks"})
    document.saveas(path)
    return path.read_bytes()


@pytest.fixture(scope="module")
def dxf_bytes(tmp_path_factory):
    return drawing(tmp_path_factory.mktemp("drawing") / "wall.dxf")


def read_drawing(tmp_path, capsys, content):
    (tmp_path / "wall.dxf").write_bytes(content)
    options = ["--thickness", "0.3", "--ground", "0.2", "--output", tmp_path / "out.json", "--force"]
    return accepted_or_refused(capsys, tmp_path / "wall.dxf", "import", *options)


@generated
@given(data=st.data())
def test_drawing_of_other_bytes(tmp_path, capsys, dxf_bytes, data):
    """Damage in the entities, which a file of mostly tables would hide, or anywhere."""
    start = dxf_bytes.index(b"LWPOLYLINE") if data.draw(st.booleans()) else 0
    end = dxf_bytes.index(b"ENDSEC", start) if start else len(dxf_bytes)
    damaged_part = data.draw(st.one_of(garbled(dxf_bytes[start:end]), st.binary(max_size=60)))
    read_drawing(tmp_path, capsys, dxf_bytes[:start] + damaged_part + dxf_bytes[end:])


@generated
@given(
    lines=st.lists(st.lists(st.tuples(NUMBERS, NUMBERS), min_size=1, max_size=6), min_size=1, max_size=5),
    close=st.booleans(),
)
def test_drawing_with_other_coordinates(tmp_path, capsys, lines, close):
    document = ezdxf.new("R2000")
    document.header["$INSUNITS"] = 6
    for points in lines:
        finite = [(float(max(min(x, 1e300), -1e300)), float(max(min(y, 1e300), -1e300))) for x, y in points]
        document.modelspace().add_lwpolyline(finite, close=close, dxfattribs={"layer": "blocks"})
    document.saveas(tmp_path / "source.dxf")
    read_drawing(tmp_path, capsys, (tmp_path / "source.dxf").read_bytes())


LINES = st.one_of(
    st.text(st.sampled_from(string.digits + ".-+e:= #\t"), max_size=20),
    st.tuples(st.sampled_from(["unit", "thickness", "friction", "support", "unit_weight", "x"]), WORDS).map(" = ".join),
    st.text(max_size=20),
)


@generated
@given(data=st.data())
def test_row_notation_with_other_lines(tmp_path, capsys, data):
    lines = ROWS.splitlines()
    for _ in range(data.draw(st.integers(1, 3))):
        lines[data.draw(st.integers(0, len(lines) - 1))] = data.draw(LINES)
    (tmp_path / "wall.txt").write_bytes("\n".join(lines).encode(errors="replace"))
    accepted_or_refused(capsys, tmp_path / "wall.txt", "import", "--output", tmp_path / "out.json", "--force")


@generated
@given(content=st.one_of(st.binary(max_size=200), garbled(ROWS.encode())))
def test_row_notation_of_other_bytes(tmp_path, capsys, content):
    (tmp_path / "wall.txt").write_bytes(content)
    accepted_or_refused(capsys, tmp_path / "wall.txt", "import", "--output", tmp_path / "out.json", "--force")


def test_the_undamaged_files_are_accepted(tmp_path, capsys, dxf_bytes):
    """Otherwise every case above might fail for the same reason."""
    (tmp_path / "wall.json").write_text(json.dumps(WALL))
    (tmp_path / "case.toml").write_bytes(toml(case_file()))
    (tmp_path / "wall.txt").write_text(ROWS)
    assert accepted_or_refused(capsys, tmp_path / "case.toml", "check", "--output", tmp_path / "run") == 0
    output = ["--output", tmp_path / "out.json", "--force"]
    assert accepted_or_refused(capsys, tmp_path / "wall.txt", "import", *output) == 0
    assert read_drawing(tmp_path, capsys, dxf_bytes) == 0


@pytest.mark.parametrize(
    ("name", "module", "options"),
    [
        ("wall.json", block_files, []),
        ("wall.txt", rows, []),
        ("wall.dxf", dxf, ["--thickness", "0.3"]),
    ],
)
def test_files_that_are_too_large_are_refused_unread(tmp_path, capsys, name, module, options):
    with (tmp_path / name).open("wb") as file:
        file.truncate(module.LARGEST_FILE + 1)
    options = [*options, "--output", tmp_path / "out.json", "--force"]
    assert accepted_or_refused(capsys, tmp_path / name, "import", *options) == 2


def test_a_picture_that_is_too_large_is_refused_unread(tmp_path, capsys):
    from PIL import Image

    Image.new("1", (5001, 5000)).save(tmp_path / "wall.png")  # 25 million pixels and 5000
    options = ["--thickness", "0.3", "--scale", "0.01", "--output", tmp_path / "out.json", "--force"]
    assert accepted_or_refused(capsys, tmp_path / "wall.png", "import", *options) == 2


def test_a_drawing_whose_references_have_no_end_is_refused(tmp_path, capsys):
    document = ezdxf.new("R2000")
    document.header["$INSUNITS"] = 4
    for name, other in (("A", "B"), ("B", "A")):
        document.blocks.new(name).add_blockref(other, (1, 0))
    document.modelspace().add_blockref("A", (0, 0))
    document.saveas(tmp_path / "source.dxf")
    assert read_drawing(tmp_path, capsys, (tmp_path / "source.dxf").read_bytes()) == 2


def test_a_drawing_whose_references_multiply_is_refused(tmp_path, capsys):
    """A bomb: ten references to ten references, seven deep, are ten million stones in a file of a few kB."""
    document = ezdxf.new("R2000")
    document.header["$INSUNITS"] = 4
    below = document.blocks.new("B0")
    below.add_lwpolyline([(0, 0), (1, 0), (1, 1)], close=True, dxfattribs={"layer": "blocks"})
    for level in range(1, 8):
        here = document.blocks.new(f"B{level}")
        for x in range(10):
            here.add_blockref(f"B{level - 1}", (x, 0))
    document.modelspace().add_blockref("B7", (0, 0))
    document.saveas(tmp_path / "source.dxf")
    assert read_drawing(tmp_path, capsys, (tmp_path / "source.dxf").read_bytes()) == 2
