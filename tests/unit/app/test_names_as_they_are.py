"""Names of materials, walls and folders are printed as they are: what looks like markup is none."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from orchestrator.app.cli import main
from tests.support.two_blocks import WALL
from tests.support.undrawn import undrawn

CASE = """
[wall]
blocks = "wall.json"
[[wall.classes]]
material = "[/stone]"
friction = 0.5
[[joints.classes]]
between = ["[/stone]", "[/stone]"]
friction = 0.4
[[load.cases]]
name = "push"
[[load.cases]]
name = "pull"
direction = "-x"
[stepping]
final_displacement = "0.05 mm"
"""


@pytest.fixture
def case(tmp_path):
    """A case whose material and name could be markup."""
    blocks = [block | ({} if block.get("fixed") else {"material": "[/stone]"}) for block in WALL["blocks"]]
    (tmp_path / "wall.json").write_text(json.dumps(WALL | {"name": "wall [/A] [bold red]B", "blocks": blocks}))
    (tmp_path / "case.toml").write_text(CASE)
    return tmp_path / "case.toml"


@pytest.mark.parametrize(
    ("command", "name"),
    [
        *(("check", name) for name in ("a[old]", "a[/b]", "[/]", ":smile:")),
        ("limit", "[/]"),
        ("segment", "a[old]"),
        ("run --model macro", "a[/b]"),
    ],
)
def test_a_folder_is_printed_as_it_is_called(case, capsys, command, name):
    output = case.with_name("out") / name
    with undrawn():
        assert main([*command.split(), str(case), "--output", str(output)]) == 0
    printed, error = capsys.readouterr()
    assert error == ""
    paths = re.findall(rf"{re.escape(str(output))}[^;,\n]*", printed)
    assert len(paths) >= 2
    assert all(Path(path).exists() for path in paths), paths
    if command == "check":
        assert "[/stone]" in printed


@pytest.mark.parametrize("command", ["sensitivity", "limit --settle 0"])
def test_other_commands_too(case, capsys, command):
    output = case.with_name("out") / "a[/b]"
    name, *rest = command.split()
    settings = ("sensitivity.friction=[0.3,0.4]", "sensitivity.samples=0")
    given = [word for one in settings for word in ("--set", one)] if name == "sensitivity" else []
    with undrawn():
        assert main([name, str(case), *rest, *given, "--output", str(output)]) == 0
    assert str(output) in capsys.readouterr().out


def test_a_wall_in_space_too(case, capsys):
    output = case.with_name("out") / "a[/b]"
    for command in ("check", "limit"):
        setting = ("--set", "load.direction=+z")
        assert main([command, str(case.with_name("wall.json")), *setting, "--output", str(output)]) == 0
        assert str(output) in capsys.readouterr().out


def test_what_new_says_to_do_next_can_be_pasted(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["new", "my wall [b]"]) == 0
    assert capsys.readouterr().out == "my wall [b].toml; next: python -m orchestrator check 'my wall [b].toml'\n"
