"""The picture of the house in CONTRIBUTING.md shows the rooms there are, and what is named beside it exists."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

PROJECT = Path(__file__).parents[2]
PICTURE = PROJECT / "docs" / "figures" / "house.svg"


def test_the_picture_names_every_room_there_is():
    texts = [text.text for text in ElementTree.parse(PICTURE).iter("{http://www.w3.org/2000/svg}text")]
    package = PROJECT / "orchestrator"
    rooms = {path.stem for path in package.glob("*.py")} | {path.parent.name for path in package.glob("*/__init__.py")}
    assert set(texts[::2]) == rooms - {"__init__", "__main__"}


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
