"""The picture of the house shows the rooms there are, what is named beside it exists, tests/unit has the same rooms."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from xml.etree import ElementTree

from tests.conftest import SLOW, stored
from tests.support.paths import PROJECT

PICTURE = PROJECT / "docs" / "figures" / "house.svg"
ROOMS = {path.parent.name for path in (PROJECT / "orchestrator").glob("*/__init__.py")}


def test_the_picture_names_every_room_there_is():
    texts = [text.text for text in ElementTree.parse(PICTURE).iter("{http://www.w3.org/2000/svg}text")]
    modules = {path.stem for path in (PROJECT / "orchestrator").glob("*.py")}
    assert set(texts[::2]) == ROOMS | modules - {"__init__", "__main__"}


def test_the_picture_is_the_one_that_its_script_draws(tmp_path):
    program = f"import house; house.PICTURE = type(house.PICTURE)({str(tmp_path / 'house.svg')!r}); house.main()"
    subprocess.run([sys.executable, "-c", program], cwd=PROJECT / "docs", check=True, timeout=120)
    assert (tmp_path / "house.svg").read_text() == PICTURE.read_text()


def test_every_file_and_target_that_newcomers_are_sent_to_exists():
    text = (PROJECT / "CONTRIBUTING.md").read_text()
    targets = set(re.findall(r"^([a-z0-9]+):", (PROJECT / "Makefile").read_text(), re.M))
    assert set(re.findall(r"\bmake ([a-z]+)", text)) <= targets
    for name in re.findall(r"`((?:[a-z_]+/)*[a-z_]+\.py|[a-z_]+/)`", text):
        assert any((folder / name).exists() for folder in (PROJECT, PROJECT / "orchestrator")) or name == "settings.py"


def test_unit_tests_are_in_the_rooms_they_test():
    """A folder below tests/unit is one of orchestrator's, every room has one, and no two test files share a name."""
    files = sorted((PROJECT / "tests").rglob("test_*.py"))
    assert len({file.name for file in files}) == len(files)
    units = [file.relative_to(PROJECT / "tests" / "unit") for file in files if "unit" in file.parts]
    assert [str(file) for file in units if not (PROJECT / "orchestrator" / file.parent / "__init__.py").exists()] == []
    assert {file.parts[0] for file in units} == ROOMS


def test_every_room_has_fast_tests():
    fast = {test.split("/")[2] for test, seconds in stored().items() if "/unit/" in test and seconds.alone <= SLOW}
    assert fast == ROOMS


def test_no_test_patches_a_constant():
    """A test of another threshold than the program's is a test of another program."""
    folders = (PROJECT / "orchestrator", PROJECT / "tests")
    sources, tests = ("\n".join(file.read_text() for file in folder.rglob("*.py")) for folder in folders)
    constants = {name for line in re.findall(r"^([A-Z][A-Z_, ]+) =", sources, re.M) for name in line.split(", ")}
    assert len(constants) > 100
    assert constants & set(re.findall(r"""setattr\([^)]*\b([A-Z][A-Z_]+)["']\s*,""", tests)) == set()


def test_every_number_has_one_assignment_and_says_where_it_comes_from():
    """Constants at the top of a module that are computed with, each with a docstring below it."""
    missing = []
    for file in sorted((PROJECT / "orchestrator").rglob("*.py")):
        body = ast.parse(file.read_text()).body
        for statement, below in zip(body, [*body[1:], None], strict=True):
            if not isinstance(statement, ast.Assign) or not is_number(statement.value):
                continue
            name = ast.unparse(statement.targets[0])
            said = isinstance(below, ast.Expr) and isinstance(below.value, ast.Constant)
            if not said or isinstance(statement.targets[0], ast.Tuple):
                missing.append(f"{file.relative_to(PROJECT)}: {name}")
    assert missing == []


def is_number(value: ast.expr) -> bool:
    """Whether a value is a number, a product of numbers, or numbers side by side."""
    if isinstance(value, ast.Tuple):
        return all(is_number(one) for one in value.elts)
    if isinstance(value, ast.BinOp):
        return is_number(value.left) and is_number(value.right)
    if isinstance(value, ast.UnaryOp):
        return is_number(value.operand)
    return isinstance(value, ast.Constant) and type(value.value) in (int, float)
