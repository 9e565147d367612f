"""The tolerance study on wall 1 of Ferris and Tin-Loi (33 stones), a fraction of a millimetre far."""

from __future__ import annotations

import csv
import math
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from orchestrator import storage
from orchestrator.app import driver, study_runs
from orchestrator.basis.errors import CaseError, ConvergenceError
from orchestrator.macroblocks.tolerance_grid import StudySettings, distinct, grid
from orchestrator.settings import case as cases
from tests.support.paths import DATA
from tests.support.ranks import on_ranks, quiet
from tests.support.undrawn import undrawn

WALL = DATA / "ferris_tinloi_wall1.json"
FRICTION = 0.65
SETTINGS = [
    "stepping.final_displacement=0.1mm",
    "study.tol_n=[2.5e-6, 'none']",
    "study.tol_d=['450 mm', 'none']",
]


@pytest.fixture(scope="module")
def case():
    return cases.read(WALL, SETTINGS)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("study")


@pytest.fixture(scope="module")
def outcome(case, folder):
    return study_runs.study(case, folder, None, quiet)


def without_times(rows):
    return [{name: text for name, text in row.items() if "seconds" not in name} for row in rows]


def table(folder):
    with (folder / "table.csv").open() as file:
        return without_times(csv.DictReader(file))


def test_default_grid_is_the_paper_s():
    settings = StudySettings()
    assert settings.scale == "unit_power"
    assert settings.tol_n == (2.5e-6, 3.75e-6, 7.5e-6, 22.5e-6, math.inf)
    assert settings.tol_d == (0, 0.001, 0.45, 0.9, math.inf)


def test_lists_take_units_and_none_and_are_written_back(case, tmp_path):
    assert case.study.tol_n == (2.5e-6, math.inf)
    assert case.study.tol_d == (0.45, math.inf)
    written = tmp_path / "case.toml"
    written.write_text(cases.as_toml(case, "blocks.json"))
    assert cases.read(written).study == case.study


@pytest.mark.parametrize(
    ("override", "complaint"),
    [
        ("study.tol_n=[]", "study.tol_n: "),
        ("study.tol_n=3", "study.tol_n: 3 is not accepted; write a list"),
        ("study.tol_n=[-1.0]", r"study\.tol_n\.0: "),
        ("study.tol_d=['1 kN']", "study.tol_d.0: unit 'kN' does not fit"),
        ("study.scale=metres", "study.scale: "),
    ],
)
def test_complaints_about_the_grid(override, complaint):
    with pytest.raises(CaseError, match=complaint):
        cases.read(WALL, [override])


def test_looser_tolerances_give_no_more_bodies_and_none_at_all_gives_one(case):
    segmented = driver.segment(case)
    mechanism = segmented.analysis.headline.mechanism
    cells = grid(segmented.assemblage, mechanism, case.macroblocks, StudySettings())
    count = {(cell.tol_n, cell.tol_d): cell.partition.count for cell in cells}
    assert len(count) == 25
    for (normal, distance), bodies in count.items():
        assert all(bodies >= other for (n, d), other in count.items() if n >= normal and d >= distance)
    assert count[math.inf, math.inf] == 1
    assert len(distinct(cell.partition for cell in cells)) < 25


def test_a_tolerance_below_the_noise_is_refused_by_its_key_in_the_study(case, tmp_path):
    noise = replace(case, study=StudySettings(tol_n=(1e-30,)))
    with pytest.raises(CaseError, match=r"wall1\.json: study\.tol_n: 1e-30 is below .* use at least"):
        study_runs.study(noise, tmp_path, None, quiet)


def test_a_case_that_chooses_automatically_can_be_studied_too(case):
    segmented = driver.segment(case)
    criteria = replace(case.macroblocks, choose="automatic")
    cells = grid(segmented.assemblage, segmented.analysis.headline.mechanism, criteria, case.study)
    assert {cell.partition.tolerances.choose for cell in cells} == {"tolerances"}


def test_macroblocks_between_every_stone_and_one_body(outcome):
    """One body on its support slides at lambda = mu, whatever else; every stone is the reference of all ratios."""
    *cells, micro = outcome.rows
    assert [(row["tol_n"], row["tol_D_m"]) for row in cells] == [
        (2.5e-6, 0.45), (2.5e-6, "none"), ("none", 0.45), ("none", "none"),
    ]  # fmt: skip
    assert (micro["bodies"], micro["joints"]) == (33, 83)
    assert [micro[name] for name in study_runs.COLUMNS if name.endswith("over_micro")] == [1.0] * 4
    one_body = cells[-1]
    assert one_body["bodies"] == 1
    assert one_body["peak_multiplier"] == pytest.approx(FRICTION, rel=1e-3)
    assert one_body["joints"] == 5 + 1, "the joints of the base: six stones in the halved course"
    assert outcome.complaints == ()


def test_what_is_left(case, folder, outcome):
    assert {path.name for path in folder.iterdir()} == {"table.csv", "figures", "runs", "results.json"}
    drawn = {path.name for path in (folder / "figures").iterdir()}
    assert drawn == {f"{name}.{kind}" for name in ("table", "mechanisms", "curves") for kind in ("png", "svg")}
    assert len(list((folder / "runs").iterdir())) == len({row["run"] for row in outcome.rows})
    assert len(table(folder)) == 5


def test_a_finished_study_runs_nothing_again(case, folder, outcome, monkeypatch):
    monkeypatch.setattr(driver, "push", lambda *_: pytest.fail("ran again"))
    assert study_runs.study(case, folder, None, quiet).rows == outcome.rows
    other = replace(case, elastic=replace(case.elastic, poisson_ratio=0.1))
    with pytest.raises(pytest.fail.Exception, match="ran again"):
        study_runs.study(other, folder, None, quiet, force=True)


FEW = ["study.tol_n=['none']", "study.tol_d=['450 mm']"]
"""one cell of the grid, and every stone"""


def test_a_peak_that_does_not_count_says_so_in_the_table(case, folder, outcome, tmp_path):
    """One body, had limit analysis found half the multiplier; it was valid, without a word."""
    again = Path(shutil.copytree(folder, tmp_path / "again"))
    run = again / "runs" / outcome.rows[3]["run"]
    found = storage.read_summary(run)
    half = 0.5 * found.limit_analysis.multiplier
    limit = replace(found.limit_analysis, associative=half, non_associative=half, non_associative_range=None)
    limit = replace(limit, large_displacements=None, rigid_peak=None, pressed_peak=None, interval=None, highest=None)
    storage.write_summary(run, replace(found, limit_analysis=limit))
    row = study_runs.study(case, again, None, quiet).rows[3]
    assert row["valid"]
    assert row["complaints"].endswith("and does not count: compare with --model micro")


def rows_of_few(outcome):
    """Return the rows of these cells in the whole study, as its table has them."""
    one, micro = outcome.rows[2], outcome.rows[4]
    assert (one["tol_n"], one["tol_D_m"]) == ("none", 0.45)
    return without_times([{key: str(value) for key, value in row.items()} for row in (one, micro)])


def test_an_interrupted_study_goes_on_where_it_stopped(outcome, tmp_path, monkeypatch):
    case = cases.read(WALL, [*SETTINGS, *FEW])
    push, started = driver.push, []

    def killed_in_the_second(case, segmented, output, *rest):
        started.append(output)
        done = push(case, segmented, output, *rest)
        if len(started) == 2:
            raise KeyboardInterrupt
        return done

    monkeypatch.setattr(driver, "push", killed_in_the_second)
    with undrawn(), pytest.raises(KeyboardInterrupt):
        study_runs.study(case, tmp_path, None, quiet)
    whole = [path for path in (tmp_path / "runs").iterdir() if not path.name.startswith(".")]
    assert len(whole) == 1
    with undrawn():
        study_runs.study(case, tmp_path, None, quiet)
    assert len(started) == 1 + 2
    assert not list((tmp_path / "runs").glob(".*")), "nothing half-written is left"
    assert table(tmp_path) == rows_of_few(outcome)


def test_a_run_without_a_curve_is_a_complaint_and_an_empty_cell(case, tmp_path, monkeypatch):
    push = driver.push

    def one_fails(case, segmented, *rest):
        if segmented.partition.count == 1:
            raise ConvergenceError("macro FE", "stopped before any increment")
        return push(case, segmented, *rest)

    monkeypatch.setattr(driver, "push", one_fails)
    few = replace(case, study=StudySettings(tol_n=(math.inf,), tol_d=(math.inf,)))
    with undrawn():
        found = study_runs.study(few, tmp_path, None, quiet)
    assert found.rows[0]["peak_multiplier"] == ""
    assert len(found.complaints) == 1
    assert "stopped before any increment" in found.complaints[0]


def test_ranks_share_the_runs_and_change_no_number(outcome, tmp_path):
    command = ["-m", "orchestrator", "study", WALL, "--output", tmp_path]
    command += [part for text in [*SETTINGS, *FEW] for part in ("--set", text)]
    done = on_ranks(3, *command, options=("--mca", "mpi_yield_when_idle", "0"))
    assert done.returncode == 0, done.stdout + done.stderr
    assert table(tmp_path) == rows_of_few(outcome)
    assert done.stdout.count("micro-LA and grid") == 1, "only one rank prints"
    assert Path(tmp_path, "figures", "table.png").exists()
