"""What `import` never writes over, and what of a block file it keeps."""

from __future__ import annotations

import json

import pytest

from orchestrator.app import cli
from tests.support.intake import WALL_1, painted
from tests.support.paths import PROJECT


def imported(*arguments):
    return cli.main(["import", *map(str, arguments)])


@pytest.mark.parametrize("force", [[], ["--force"]])
@pytest.mark.parametrize("name", ["wall.png", "wall_imported.png", "wall_refused.png"])
def test_import_never_writes_over_the_picture_it_reads(tmp_path, capsys, name, force):
    """The picture that it draws is not named like the block file; where a picture to read is, it says so."""
    source, output = tmp_path / name, tmp_path / "wall.json"
    painted(source, WALL_1, 0.0025, 0.01)
    before = source.read_bytes()
    options = ["--thickness", "0.1", "--scale", "2.5mm", "--ground", "200 mm", "--mortar", "15 mm", *force]
    assert imported(source, "--output", output, *options) == (0 if name == "wall.png" else 2)
    assert source.read_bytes() == before
    assert output.exists() == (name == "wall.png")
    said = capsys.readouterr()
    assert (f"{source}: is read by this command" in said.err) == (name != "wall.png")


def test_an_imported_block_file_keeps_what_it_says_for_people(tmp_path):
    source, output = tmp_path / "given.json", tmp_path / "wall.json"
    record = json.loads((PROJECT / "tests/data/ferris_tinloi_wall1.json").read_text())
    source.write_text(json.dumps(record | {"source": "survey of 1987", "licence": "CC0", "remark": "as drawn"}))
    assert imported(source, "--output", output, "--mortar", "1 mm") == 0
    written = json.loads(output.read_text())
    assert (written["source"], written["licence"]) == ("survey of 1987", "CC0")
    assert written["remark"].startswith("as drawn")


def test_import_writes_over_no_other_picture_without_force(tmp_path, capsys):
    source, output, other = tmp_path / "wall.txt", tmp_path / "wall.json", tmp_path / "wall_imported.svg"
    source.write_text((PROJECT / "templates/wall1.txt").read_text())
    other.write_text("mine")
    assert imported(source, "--output", output) == 2
    assert (
        "wall_imported.svg: exists already; give another name, or overwrite it with --force" in capsys.readouterr().err
    )
    assert other.read_text() == "mine"
    assert not output.exists()
    assert imported(source, "--output", output, "--force") == 0
    assert other.read_text() != "mine"
