"""Where one model of a run has no curve, those of the others are written, printed and reported, and the failure named.

A stone that is wider below hangs between two others. Friction could hold it if something pressed them together, and
nothing does: as a stone it falls under its own weight. In one macroblock with its neighbours it cannot.
"""

from __future__ import annotations

import csv
import json
import shutil

import pytest

from orchestrator import storage
from orchestrator.app.cli import main
from orchestrator.storage.stored_run import read_run
from tests.support.paths import DATA
from tests.support.undrawn import undrawn

STONES = (
    [[0, 0], [0.46, 0], [0.48, 0.2], [0.52, 0.8], [0, 0.8]],
    [[1.4, 0], [1.4, 0.8], [0.88, 0.8], [0.92, 0.2], [0.94, 0]],
    [[0.48, 0.2], [0.92, 0.2], [0.88, 0.8], [0.52, 0.8]],
)
GROUND = [[-0.5, -0.2], [2.0, -0.2], [2.0, 0.0], [-0.5, 0.0]]
CASE = """[wall]
blocks = "wall.json"
[macroblocks]
tol_n = "none"
tol_d = "none"
[stepping]
final_displacement = "0.2 mm"
[project]
language = "{language}"
"""
FALLS = "the wall does not stand under its dead load: block 3 falls"


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    folder = tmp_path_factory.mktemp("hanging")
    wall = {"units": {"length": "m", "unit_weight": "kN/m3"}, "thickness": 0.3, "friction": 0.7, "unit_weight": 20.0}
    blocks = [{"id": n, "polygon": p, "fixed": not n} for n, p in enumerate((GROUND, *STONES))]
    (folder / "wall.json").write_text(json.dumps(wall | {"blocks": blocks}), encoding="utf-8")
    (folder / "case.toml").write_text(CASE.format(language="en"), encoding="utf-8")
    return folder / "case.toml"


def run(case, output, *more):
    with undrawn():
        return main(["run", str(case), "--output", str(output), *more])


@pytest.fixture(scope="module")
def done(case, tmp_path_factory):
    """The folder of a run of both models, and its exit code."""
    folder = tmp_path_factory.mktemp("run")
    return folder, run(case, folder, "--quiet")


def test_the_other_model_is_written_and_the_failure_named(done):
    folder, code = done
    assert code == 1
    record = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    (macro,) = record["pushover"]
    assert (macro["model"], macro["valid"], macro["complaint"]) == ("macro", True, None)
    (failed,) = record["failed"].items()
    assert failed[0] == "micro"
    assert failed[1].startswith("micro FE: stopped after increment")
    assert failed[1].endswith(FALLS)
    assert (folder / "macro" / "curve.csv").is_file()
    assert not (folder / "micro" / "curve.csv").exists()
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "No curve" in page
    assert FALLS in page
    assert [model.name for model in read_run(folder).models] == ["macro"]
    with (folder / "verdict.csv").open(newline="", encoding="utf-8") as file:
        (row,) = csv.DictReader(file)
    assert row["check"] == "limit analysis", "macroblocks bear more than the stones can"
    assert "every stone, the reference of macroblocks, has no curve" in row["remarks"]


def test_it_is_printed_and_a_resumed_run_ends_alike(case, done, tmp_path, capsys):
    folder = tmp_path / "again"
    shutil.copytree(done[0], folder)
    before = (folder / "macro" / "curve.csv").read_bytes()
    pieces = sorted((folder / "macro").rglob("*.h5"))
    assert run(case, folder, "--resume") == 1
    printed = capsys.readouterr()
    assert "NO CURVE: micro FE: stopped after increment" in " ".join(printed.out.split())
    assert "FE of macroblocks" in printed.out
    assert "but every stone, the reference of macroblocks, has no curve" in printed.out
    assert printed.err.count(FALLS) == 1
    assert (folder / "macro" / "curve.csv").read_bytes() == before
    assert sorted((folder / "macro").rglob("*.h5")) == pieces
    assert storage.read_summary(folder).failed == storage.read_summary(done[0]).failed


def test_its_report_is_rebuilt_and_says_so_in_another_language(done, tmp_path):
    folder = tmp_path / "told"
    shutil.copytree(done[0], folder)
    for path in (folder / "case.toml", folder / "summary.json"):
        text = path.read_text(encoding="utf-8").replace('language = "en"', 'language = "it"')
        path.write_text(text.replace('"language": "en"', '"language": "it"'), encoding="utf-8")
    storage.write_summary(folder, storage.read_summary(folder))  # as a run of such a case had written it
    with undrawn():
        assert main(["report", str(folder)]) == 0
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "Nessuna curva" in page
    assert "la parete non regge i carichi permanenti: cade" in page
    assert FALLS not in page


def test_where_every_model_fails_nothing_is_reported(case, tmp_path, capsys):
    assert run(case, tmp_path / "run", "--model", "micro", "--quiet") == 1
    assert capsys.readouterr().err.count(FALLS) == 1
    assert not (tmp_path / "run" / "summary.json").exists()


def test_of_several_load_cases_too(case, tmp_path, capsys):
    text = case.read_text(encoding="utf-8")
    cases = "".join(f'[[load.cases]]\nname = "{name}"\ndirection = "{name}"\n' for name in ("+x", "-x"))
    (case.parent / "both.toml").write_text(text + cases, encoding="utf-8")
    for more in ((), ("--resume",)):
        assert run(case.parent / "both.toml", tmp_path / "run", "--quiet", *more) == 1
        assert capsys.readouterr().err.count(FALLS) == 2
    rows = (tmp_path / "run" / "load_cases.csv").read_text(encoding="utf-8").splitlines()
    assert sum(",macro," in row for row in rows) == 2
    assert sum(FALLS in row for row in rows) == 2


def test_where_both_fail_both_are_named(tmp_path, capsys):
    """An arch that falls under its own weight: of two models that fell the macroblocks alone were told."""
    assert run(DATA / "arch_3_voussoirs.json", tmp_path, "--set", "load.direction=+x") == 1
    said = capsys.readouterr().err
    assert "macro FE: stopped after increment" in said
    assert "micro FE: stopped after increment" in said
    assert said.count("the wall does not stand under its dead load") == 2
