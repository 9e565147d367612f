"""The documentation builds without a warning, and every command in it does what it says."""

from __future__ import annotations

import json
import re
import runpy
import shlex
import shutil
import subprocess
import sys
import tomllib

import pytest

from orchestrator.app.cli import argument_parser, main
from orchestrator.masonry.sources import block_files
from orchestrator.settings import case as cases
from tests.support.intake import WALL_1, as_polylines, painted, written
from tests.support.paths import PROJECT

GALLERY = runpy.run_path(str(PROJECT / "docs" / "gallery.py"))
CALL = "    .venv/bin/python -m orchestrator "


def commands(page):
    lines = (PROJECT / "docs" / page).read_text().splitlines()
    return [shlex.split(line.removeprefix(CALL)) for line in lines if line.startswith(CALL)]


def build(project, folder):
    """Build the pages of `project`. With --quiet strict sees no warning, and dead links pass."""
    return subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)],
        cwd=project, capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("docs") / "site"
    built = build(PROJECT, folder)
    assert built.returncode == 0, built.stderr
    return folder


def test_dead_links_fail_the_build(tmp_path):
    shutil.copytree(PROJECT / "docs", tmp_path / "docs")
    shutil.copy(PROJECT / "mkdocs.yml", tmp_path)
    (tmp_path / "orchestrator").symlink_to(PROJECT / "orchestrator")
    with (tmp_path / "docs" / "limits.md").open("a") as page:
        page.write("\n[no page](nowhere.md), [no place](index.md#nowhere)\n")
    built = build(tmp_path, tmp_path / "site")
    assert built.returncode == 1
    assert "'nowhere.md'" in built.stderr
    assert "'index.md#nowhere'" in built.stderr


def test_links_of_pages_lead_somewhere_in_the_repository_too():
    for page in (PROJECT / "README.md", *(PROJECT / "docs").rglob("*.md")):
        for link in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text()):
            assert link.startswith("code/") or (page.parent / link).exists(), (page.name, link)


def test_every_key_of_a_block_file_is_on_the_page_that_its_reader_points_to():
    page, section = re.search(r"(docs/\S+), '([^']+)'", block_files.ALL_KEYS).groups()
    text = (PROJECT / page).read_text().partition(f"### {section}")[2].partition("\n## ")[0]
    top = (*block_files.REQUIRED, *block_files.OPTIONAL, *block_files.INFORMATION)
    assert not [key for key in (*top, *block_files.BLOCK_KEYS) if f"`{key}`" not in text]


def test_every_option_of_every_command_is_on_some_page():
    pages = "".join(page.read_text() for page in (PROJECT / "README.md", *(PROJECT / "docs").glob("*.md")))
    commands = next(action.choices for action in argument_parser()._actions if isinstance(action.choices, dict))
    options = {
        option
        for command in commands.values()
        for action in command._actions
        for option in action.option_strings
        if option.startswith("--") and option not in ("--help", "--print-completion")
    }
    assert not sorted(option for option in options if not re.search(rf"{option}\b(?!-)", pages))


def test_every_page_is_built_and_fetches_nothing(site):
    for page in ("index", "start", "your_wall", "theory", "python", "settings", "limits", "verification", "about"):
        html = (site / f"{page}.html").read_text()
        fetched = re.findall(r'<(?:script|link|img)[^>]+(?:src|href)="(https?:[^"]+)"', html)
        assert not fetched, page


def test_every_equation_is_mathml_and_every_module_named_has_a_page(site):
    """A TeX command that the converter does not know stays in its output with its backslash."""
    html, text = (site / "theory.html").read_text(), (PROJECT / "docs" / "theory.md").read_text()
    equations = re.findall(r"<math.*?</math>", html, re.DOTALL)
    alone = text.count("$$")
    assert len(equations) == alone // 2 + (text.count("$") - 2 * alone) // 2
    assert not [equation for equation in equations if "\\" in equation or "&</mi>" in equation]
    assert [html.count(f">({number})</div>") for number in (1, 2, 3, 4)] == [1, 1, 1, 1]
    for module in set(re.findall(r"orchestrator/([\w/]+)\.py", text)):
        assert (site / "code" / f"{module}.html").exists(), module


def test_the_settings_page_has_every_key(site):
    html = (site / "settings.html").read_text()
    for table in ("wall.classes", "load.dead", "load.live", "load.cases", "joints.classes"):
        assert f"[[{table}]]" in html
        for key in cases.table_types()[table].__dataclass_fields__:
            assert f"<code>{key}</code>" in html, (table, key)
    for section, kind in cases.section_types().items():
        assert f"[{section}]" in html
        assert all(f"<code>{key}</code>" in html for key in kind.__dataclass_fields__), section


@pytest.mark.parametrize("page", ["start.md", "your_wall.md"])
def test_every_command_of_a_page_works_in_its_order(page, tmp_path, monkeypatch):
    """`run` is only parsed here; tests/regression and tests/unit/app/test_cli.py run it."""
    monkeypatch.chdir(tmp_path)
    written(tmp_path / "survey.dxf", as_polylines(WALL_1))
    painted(tmp_path / "stones.png", WALL_1, 0.005, 0.02)
    stone = '<g id="blocks"><rect width="9" height="9"/></g><g id="supports"><rect y="9" width="9" height="9"/></g>'
    (tmp_path / "wall.svg").write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="90cm" height="180cm" viewBox="0 0 9 18">{stone}</svg>'
    )
    outlined = {"id": 1, "image_id": 1, "category_id": 1, "segmentation": [[0, 0, 99, 0, 99, 99, 0, 99]]}
    image = {"id": 1, "width": 100, "height": 100, "file_name": "wall.jpg"}
    record = {"images": [image], "categories": [{"id": 1, "name": "brick"}], "annotations": [outlined]}
    (tmp_path / "annotations.json").write_text(json.dumps(record))
    text = (PROJECT / "docs" / "your_wall.md").read_text()
    (tmp_path / "door.txt").write_text(re.search(r"(    unit = mm\n(?:    .*\n)+)", text)[1])
    found = commands(page)
    assert len(found) >= 3
    for command in found:
        if command[0] == "run":
            argument_parser().parse_args(command)
        else:
            assert main(command) == 0, command


def test_every_wall_of_the_gallery_has_its_picture_and_a_command_that_takes_it():
    """The pictures are looked at, not compared; small walls are analysed by the page's own command."""
    shown = GALLERY["entries"]((PROJECT / "docs" / "gallery.md").read_text())
    assert len(shown) >= 10
    assert len(shown) == len(commands("gallery.md"))
    for name, (command, picture) in shown.items():
        assert (PROJECT / "docs" / "figures" / "gallery" / f"{name}.png").stat().st_size > 5000
        options = argument_parser().parse_args(command)
        given = getattr(options, "case", None) or options.file
        assert (PROJECT / given).exists(), name
        assert picture.is_relative_to(options.output.parent), name


@pytest.mark.parametrize("name", ["given", "materials", "arch", "vault"])
def test_a_wall_of_the_gallery_leaves_its_picture(name, tmp_path, monkeypatch):
    command, picture = GALLERY["entries"]((PROJECT / "docs" / "gallery.md").read_text())[name]
    for folder in ("docs", "templates"):
        (tmp_path / folder).symlink_to(PROJECT / folder)
    monkeypatch.chdir(tmp_path)
    assert main(command) == 0
    assert picture.exists()


def test_walls_of_the_gallery_are_those_of_their_script():
    folder = PROJECT / "docs" / "examples" / "gallery"
    made = runpy.run_path(str(folder / "make_walls.py"))
    for name, wall in made["WALLS"].items():
        assert (folder / f"{name}.json").read_text() == made["block_file"](name, wall), name


def test_two_blocks_of_the_first_page_slide_at_their_friction(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["new", "my_wall"]) == 0
    assert main(["limit", "my_wall.toml"]) == 0
    assert "0.60000" in capsys.readouterr().out


def test_citation_and_changelog_name_version_and_date_of_the_package():
    version = tomllib.loads((PROJECT / "pyproject.toml").read_text())["project"]["version"]
    citation = (PROJECT / "CITATION.cff").read_text()
    assert f"\nversion: {version}\n" in citation
    (date,) = re.findall(r"^date-released: (\d{4}-\d\d-\d\d)$", citation, re.M)
    assert re.findall(r"^## (.+)$", (PROJECT / "CHANGELOG.md").read_text(), re.M)[0] == f"{version} ({date})"


def test_no_command_installs_into_the_python_of_the_system():
    """Debian 12 and Ubuntu 24.04 refuse it ("externally-managed-environment"): the wheel's instructions ended there."""
    pages = [PROJECT / "README.md", *(PROJECT / "docs").glob("*.md")]
    lines = [line for page in pages for line in page.read_text().splitlines()]
    assert [line for line in lines if re.match(r"    (sudo )?(pip3?|python3? -m pip) ", line)] == []
