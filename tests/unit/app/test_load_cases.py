"""Several load cases in one file: a stone with one leaning side, pushed both ways, and its mirror image.

The stone is 0.6 m wide below, 0.3 m above and 0.9 m high, with its upright side on the left: its centroid is 0.7/3 m
from that side and 0.4 m high. It overturns, with much friction, at (distance of the centroid from the toe) / height.
"""

from __future__ import annotations

import csv
import json
import math
import shutil

import pytest

from orchestrator import storage
from orchestrator.app import driver, load_case_runs, load_cases
from orchestrator.app.cli import main
from orchestrator.basis.errors import CaseError, ConvergenceError
from orchestrator.settings import case as cases
from tests.support.leaning_stone import CASE, stone
from tests.support.paths import PROJECT
from tests.support.ranks import on_ranks, quiet
from tests.support.undrawn import undrawn

TO_THE_RIGHT, TO_THE_LEFT = (0.6 - 0.7 / 3) / 0.4, (0.7 / 3) / 0.4


@pytest.fixture(scope="module")
def walls(tmp_path_factory):
    """Case files of the stone and of its mirror image."""
    folder = tmp_path_factory.mktemp("walls")
    for name, mirror in (("stone", False), ("image", True)):
        (folder / f"{name}.json").write_text(json.dumps(stone(mirror)))
        (folder / f"{name}.toml").write_text(CASE.format(blocks=name, common=""))
    return folder


@pytest.fixture(scope="module")
def runs(walls):
    """The run folders of both, each with both load cases."""
    assert main(["run", str(walls / "stone.toml"), "--output", str(walls / "stone"), "-q"]) == 0
    with undrawn():
        assert main(["run", str(walls / "image.toml"), "--output", str(walls / "image"), "-q"]) == 0
    return walls


def table(folder):
    with (folder / "load_cases.csv").open() as file:
        return list(csv.DictReader(file))


def test_each_direction_has_its_closed_form_and_the_mirror_image_swaps_them(runs):
    expected = {"stone": (TO_THE_RIGHT, TO_THE_LEFT), "image": (TO_THE_LEFT, TO_THE_RIGHT)}
    for name, values in expected.items():
        rows = table(runs / name)
        assert [row["load_case"] for row in rows] == ["+x mass", "-x mass"]
        for row, value in zip(rows, values, strict=True):
            assert float(row["associative"]) == pytest.approx(value, rel=1e-6)
            assert float(row["peak_multiplier"]) == pytest.approx(value, rel=1e-2)  # P-delta takes some of it
    found = [{row["load_case"]: float(row["peak_base_shear_N"]) for row in table(runs / name)} for name in expected]
    assert found[0]["+x mass"] == pytest.approx(found[1]["-x mass"], rel=1e-3)
    assert found[0]["-x mass"] == pytest.approx(found[1]["+x mass"], rel=1e-3)


def test_a_load_case_is_a_run_of_its_own_and_the_same_as_alone(runs, tmp_path):
    folder = runs / "stone" / "-x mass"
    assert {"case.toml", "blocks.json", "summary.json", "report.html", "macro", "figures"} <= {
        path.name for path in folder.iterdir()
    }
    single = CASE.split("[[load.cases]]")[0].format(blocks="stone", common='direction = "-x"')
    alone = runs / "alone.toml"
    alone.write_text(single + "[stepping]" + CASE.split("[stepping]")[1])
    with undrawn():
        assert main(["run", str(alone), "--output", str(tmp_path), "-q"]) == 0
    assert (tmp_path / "macro" / "curve.csv").read_text() == (folder / "macro" / "curve.csv").read_text()
    assert not (tmp_path / "load_cases.csv").exists(), "a file without load cases is run as ever"


def test_every_column_of_the_table_is_in_the_documents():
    text = (PROJECT / "docs" / "your_wall.md").read_text(encoding="utf-8")
    assert [column for column in load_case_runs.COLUMNS if f"`{column}`" not in text] == []


def test_the_index_page_has_the_project_and_what_was_verified(walls, tmp_path):
    text = CASE.format(blocks=walls / "stone", common="") + "[seismic]\npeak_ground_acceleration = '0.1 g'\n"
    text += "[project]\nclient = 'Comune di Ferrara'\nauthor = 'M. Rossi'\ndate = '12 maggio 2026'\nlanguage = 'it'\n"
    (walls / "project.toml").write_text(text)
    with undrawn():
        assert main(["run", str(walls / "project.toml"), "--output", str(tmp_path), "-q"]) == 0
    for _ in ("as run", "made again"):
        page = (tmp_path / "report.html").read_text()
        for said in ("<dt>committente</dt><dd>Comune di Ferrara</dd>", "Redatto da: M. Rossi", "Data: 12 maggio 2026"):
            assert said in page
        assert "Azione sismica" in page
        assert '<td class="t">SD</td><td>0,9810</td>' in page
        assert "EN 1998-1 3.2.2.2, tipo 1; suolo A" in page
        assert "λ = taglio alla base / peso; peso" in page
        (tmp_path / "report.html").unlink()
        with undrawn():
            assert main(["report", str(tmp_path)]) == 0


def test_the_index_page_links_every_report_and_shows_the_curves(runs):
    page = (runs / "stone" / "report.html").read_text()
    for name in ("+x mass", "-x mass"):
        assert f'href="{name.replace(" ", "%20").replace("+", "%2B")}/report.html"' in page
    assert "data:image/svg+xml;base64," in page
    assert {path.name for path in (runs / "stone" / "figures").iterdir()} == {"curves.png", "curves.svg"}


def test_report_rebuilds_all_pages_from_stored_results_alone(runs, capsys):
    pages = [runs / "image" / "report.html", runs / "image" / "+x mass" / "report.html"]
    for page in pages:
        page.unlink()
    assert main(["report", str(runs / "image")]) == 0
    assert str(pages[0]) in capsys.readouterr().out
    assert all(page.is_file() for page in pages)


@pytest.fixture
def alone(runs, tmp_path):
    """A copy of the run of one load case."""
    shutil.copytree(runs / "stone" / "-x mass", tmp_path / "alone")
    return tmp_path / "alone"


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        (
            'direction = "-x"',
            'direction = "+x"',
            "load.direction: is '+x', but the run was made with '-x'; set it back",
        ),
        ("layers = 1", "layers = 2", "mesh.layers: is 2"),
        ('elastic_modulus = "', 'elastic_modulus = "9', "elastic.elastic_modulus: is '9"),
        ("dead = []", 'dead = [{blocks = [1], force = "1 kN"}]', "load.dead: is [{'blocks': [1]"),
    ],
)
def test_a_report_of_an_edited_case_is_refused(alone, capsys, old, new, complaint):
    case, page = (alone / "case.toml").read_text(), (alone / "report.html").read_bytes()
    assert case.count(old) == 1
    (alone / "case.toml").write_text(case.replace(old, new))
    assert main(["report", str(alone)]) == 2
    said = capsys.readouterr().err
    assert f"case.toml: {complaint}" in said
    assert said.count("\n") == 1
    assert (alone / "report.html").read_bytes() == page


def test_a_report_of_edited_blocks_is_refused(alone, capsys):
    blocks = json.loads((alone / "blocks.json").read_text())
    blocks["blocks"][-1]["unit_weight"] *= 2
    (alone / "blocks.json").write_text(json.dumps(blocks))
    assert main(["report", str(alone)]) == 2
    assert "blocks.json: is not what the run was made with; run it again" in capsys.readouterr().err


@pytest.mark.parametrize("file", ["states.h5", "geometry.h5", "curve.csv", "../limit_analysis.json", "../blocks.json"])
def test_a_report_says_which_file_is_missing(alone, capsys, file):
    (model,) = {path.parent for path in alone.glob("*/states.h5")}
    (model / file).unlink()
    with undrawn():
        assert main(["report", str(alone)]) == 2
    said = capsys.readouterr().err
    name = (model / file).resolve()
    assert said.endswith(f"{name}: is missing from the folder of this run; copy it back, or run the case again\n")


def test_project_and_seismic_may_change_before_a_report(alone):
    text = (alone / "case.toml").read_text()
    assert "[seismic]" in text
    (alone / "case.toml").write_text(text.replace('client = ""', 'client = "Comune di Ferrara"'))
    with undrawn():
        assert main(["report", str(alone)]) == 0
    assert "Comune di Ferrara" in (alone / "report.html").read_text()


def test_a_report_names_the_load_that_its_case_has(runs, tmp_path):
    folder = tmp_path / "by height"
    shutil.copytree(runs / "stone" / "-x mass", folder)
    case = (folder / "case.toml").read_text()
    changed = case.replace('distribution = "mass"', 'distribution = "mass_height"')
    changed = changed.replace('inclination = "0.0 rad"', 'inclination = "10 deg"')
    assert changed.count("mass_height") > case.count("mass_height")
    before, after = "proportional to mass", "proportional to mass × height above the base, 10° above the horizontal"
    named = (folder / "report.html").read_text().count(before)
    assert named >= 2
    (folder / "case.toml").write_text(changed)
    summary = storage.read_summary(folder)
    summary.settings["load"] |= {"distribution": "mass_height", "inclination": f"{math.radians(10.0)!r} rad"}
    storage.write_summary(folder, summary)
    with undrawn():
        assert main(["report", str(folder)]) == 0
    page = (folder / "report.html").read_text()
    assert page.count(after) == page.count(before) == named


def test_resume_leaves_finished_load_cases_alone_and_finishes_the_others(walls, tmp_path, monkeypatch):
    case, run = cases.read(walls / "stone.toml"), driver.run
    started = []

    def killed_in_the_second(case, *rest):
        started.append(case.load.direction)
        if len(started) == 2:
            raise KeyboardInterrupt
        return run(case, *rest)

    monkeypatch.setattr(driver, "run", killed_in_the_second)
    with undrawn():
        with pytest.raises(KeyboardInterrupt):
            load_case_runs.run(case, tmp_path, False, None, quiet)
        outcome = load_case_runs.run(case, tmp_path, True, None, quiet)
    assert started == ["+x", "-x", "-x"]
    assert [done.summary.limit_analysis.associative for done in outcome.done] == pytest.approx(
        [TO_THE_RIGHT, TO_THE_LEFT], rel=1e-6
    )


def test_a_load_case_without_a_curve_is_a_complaint_and_the_others_are_run(walls, tmp_path, monkeypatch):
    run = driver.run

    def first_fails(case, *rest):
        if case.load.direction == "+x":
            raise ConvergenceError("macro FE", "stopped before any increment")
        return run(case, *rest)

    monkeypatch.setattr(driver, "run", first_fails)
    with undrawn():
        outcome = load_case_runs.run(cases.read(walls / "stone.toml"), tmp_path, False, None, quiet)
    assert [str(complaint) for complaint in outcome.complaints] == [
        "load case +x mass: macro FE: stopped before any increment"
    ]
    first, second = table(tmp_path)
    assert (first["peak_multiplier"], first["complaint"]) == ("", "macro FE: stopped before any increment")
    assert float(second["peak_multiplier"]) == pytest.approx(TO_THE_LEFT, rel=1e-2)


@pytest.mark.parametrize(("ranks", "shared"), [(2, 0), (3, 10**6)])
def test_ranks_change_no_number(runs, tmp_path, ranks, shared):
    """Load cases are spread over the ranks, or all ranks share each one's linear system."""
    command = ("-m", "tests.support.undrawn", "run", runs / "stone.toml", "--output", tmp_path)
    done = on_ranks(ranks, *command, "--set", f"newton.distribute_above={shared}")
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count("load_cases.csv") == 1, "only one rank prints"
    for here, there in zip(table(tmp_path), table(runs / "stone"), strict=True):
        assert here["load_case"] == there["load_case"]
        assert float(here["peak_base_shear_N"]) == pytest.approx(float(there["peak_base_shear_N"]), rel=1e-6)


def test_limit_and_segment_answer_for_every_load_case(walls, capsys, tmp_path):
    assert main(["limit", str(walls / "stone.toml"), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert {name: one["associative"] for name, one in found.items()} == pytest.approx(
        {"+x mass": TO_THE_RIGHT, "-x mass": TO_THE_LEFT}, rel=1e-6
    )
    assert main(["limit", str(walls / "stone.toml"), "--output", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert all(text in printed for text in ("+x mass", "-x mass", "0.91667", "0.58333"))
    for name in ("+x mass", "-x mass"):
        assert (tmp_path / name / "figures" / "mechanism.png").is_file()
    assert main(["segment", str(walls / "stone.toml")]) == 0
    assert capsys.readouterr().out.count("1 macroblock") == 2
    assert main(["check", str(walls / "stone.toml"), "--output", str(tmp_path)]) == 0
    assert "2 load cases" in capsys.readouterr().out


def test_what_is_left_out_is_that_of_the_load_section(walls):
    common = 'inclination = "-5 deg"\n[[load.dead]]\nblocks = [1]\nforce = "1 kN"'
    text = CASE.format(blocks="stone", common=common).replace(
        'direction = "-x"', 'direction = "-x"\ndistribution = "mass_height"\ndead = [{blocks = [1], force = "2 kN"}]'
    )
    (walls / "own.toml").write_text(text)
    first, second = load_cases.each(cases.read(walls / "own.toml")).values()
    assert (first.load.direction, second.load.direction) == ("+x", "-x")
    assert (first.load.distribution, second.load.distribution) == ("mass", "mass_height")
    assert first.load.inclination == second.load.inclination != 0.0
    assert [load.force for load in first.load.dead] == [1e3]
    assert [load.force for load in second.load.dead] == [1e3, 2e3], "dead loads of a load case come on top"


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (("-x mass", "+x mass"), r"load\.cases\.1\.name: '\+x mass' is the name of another one"),
        (("-x mass", "a/b"), r"load\.cases\.1\.name: 'a/b' cannot name a folder"),
        (("-x mass", ".."), r"load\.cases\.1\.name: '\.\.' cannot name a folder"),
        (("-x mass", "figures"), r"load\.cases\.1\.name: 'figures' cannot name a folder"),
        (("-x mass", "Report.html"), r"load\.cases\.1\.name: 'Report\.html' cannot name a folder"),
        (('direction = "-x"', 'direction = "x"'), r"load\.cases\.1\.direction: 'x' is not accepted"),
        (('direction = "-x"', 'distribution = "per_block"'), r"load\.cases\.1\.live: 0 given"),
    ],
)
def test_load_cases_that_cannot_be(walls, tmp_path, change, complaint):
    (walls / "wrong.toml").write_text(CASE.format(blocks="stone", common="").replace(*change))
    with pytest.raises(CaseError, match=rf"wrong\.toml: {complaint}"):
        load_case_runs.run(cases.read(walls / "wrong.toml"), tmp_path, False, None, quiet)
    assert not list(tmp_path.iterdir()), "nothing is begun"


@pytest.mark.parametrize("command", ["study", "export"])
def test_commands_that_take_one_load_case_say_so(walls, capsys, command):
    assert main([command, str(walls / "stone.toml")]) == 2
    assert f"stone.toml: load.cases: {command} takes one load case; " in capsys.readouterr().err


def test_a_run_ranks_no_load_case_by_a_base_shear_that_its_live_load_hardly_has(walls, tmp_path, capsys):
    """At 80 degrees the stone is lifted about its toe at a base shear below the one that overturns it."""
    steep = (
        CASE.format(blocks="stone", common="")
        .replace('"-x mass"', '"steep"')
        .replace('"-x"', '"-x"\ninclination = "80 deg"')
    )
    (walls / "steep.toml").write_text(steep)
    with undrawn():
        assert main(["run", str(walls / "steep.toml"), "--output", str(tmp_path)]) in (0, 3)
    printed = " ".join(capsys.readouterr().out.split())
    assert "+x mass governs with the least base shear" in printed
    assert {row["load_case"]: row["inclination_deg"] for row in table(tmp_path)} == {"+x mass": "0.0", "steep": "80.0"}
    assert "-x (+80°)" in (tmp_path / "report.html").read_text()
    for _ in ("as run", "made again"):
        with (tmp_path / "verdict.csv").open() as file:
            found = {row["load_case"]: row for row in csv.DictReader(file)}
        assert found["+x mass"]["governs"] == "yes"
        assert (found["steep"]["capacity"], found["steep"]["multiplier"] != "") == ("", True)
        assert "not compared, as more vertical than horizontal: steep" in (tmp_path / "report.html").read_text()
        (tmp_path / "verdict.csv").unlink()
        with undrawn():
            assert main(["report", str(tmp_path)]) == 0
