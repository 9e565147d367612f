"""A run that is stopped and resumed ends where the uninterrupted one does."""

from __future__ import annotations

from dataclasses import replace

import pytest

from orchestrator.app import driver, load_cases
from orchestrator.app.progress import IncrementDone
from orchestrator.basis.errors import CaseError
from orchestrator.settings import case
from tests.support.paths import DATA

pytestmark = pytest.mark.usefixtures("without_pictures")


class Killed(Exception):
    """Stands for the signal that ends a run between two increments."""


def micro_case(*overrides):
    wall = DATA / "ferris_tinloi_wall1.json"
    settings = ["stepping.final_displacement=2mm", "run.models=['micro']", *overrides]
    return case.read(wall, settings)


def killing(after):
    """Return a report that kills a run after an increment, None: never."""

    def report(event):
        if isinstance(event, IncrementDone) and event.increment.number == after:
            raise Killed

    return report


def run(folder, resume=False, killed_after=None, **changes):
    return driver.run(replace(micro_case(), **changes), folder, resume, None, killing(killed_after))


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    run(folder)
    return (folder / "micro" / "curve.csv").read_text().splitlines()


def test_resumed_curve_is_the_uninterrupted_one(whole, tmp_path):
    """Killed under gravity (3), in load control (20) and in displacement control (40), and resumed each time."""
    for phase_end in (3, 20, 40):
        with pytest.raises(Killed):
            run(tmp_path, resume=phase_end > 3, killed_after=phase_end)
        assert len([*(tmp_path / "micro" / "states").glob("*.h5")]) == phase_end
        assert not (tmp_path / "micro" / "curve.csv").exists(), "no result is written of an unfinished run"
    run(tmp_path, resume=True)
    found = (tmp_path / "micro" / "curve.csv").read_text().splitlines()
    assert len(found) == len(whole) > 35
    for line, expected in zip(found[1:], whole[1:], strict=True):
        first, second = ([float(value) for value in row.split(",")] for row in (line, expected))
        assert first[:5] == pytest.approx(second[:5], rel=1e-10, abs=1e-9)


@pytest.mark.parametrize("sooner", ["final_displacement=1mm", "largest_increments=20"])
def test_a_curve_that_is_longer_than_asked_for_is_refused_and_kept(sooner, tmp_path):
    """A smaller end cannot take back what is stored; a larger one goes on with it."""
    run(tmp_path)
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    with pytest.raises(CaseError, match=r"would end the curve in .* at increment") as refused:
        driver.run(micro_case(f"stepping.{sooner}"), tmp_path, True, None, killing(None))
    assert refused.value.key == "stepping"
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before
    driver.run(micro_case("stepping.final_displacement=2.5mm"), tmp_path, True, None, killing(None))
    last = (tmp_path / "micro" / "curve.csv").read_text().splitlines()[-1]
    assert float(last.split(",")[5]) > 2.4e-3


def test_resume_with_another_wall_is_refused_at_once_and_nothing_is_lost(tmp_path, monkeypatch):
    with pytest.raises(Killed):
        run(tmp_path, killed_after=5)
    stored = sorted((tmp_path / "micro" / "states").glob("*.h5"))
    assert len(stored) == 5
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    with monkeypatch.context() as patched:
        patched.setattr(driver, "segment", lambda _: pytest.fail("limit analysis is done before the refusal"))
        with pytest.raises(CaseError, match=r"'-x' here, and '\+x' in .*without --resume") as refused:
            run(tmp_path, resume=True, load=case.LoadSettings("-x"))
    assert refused.value.key == "load.direction"
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before
    assert set(stored) <= set(before)


def test_a_run_over_an_earlier_one_leaves_nothing_of_it_and_can_be_resumed(tmp_path):
    """Pictures, pages and increments of another wall would be taken for results of this one."""
    old = tmp_path / "over"
    run(old)
    (old / "notes.txt").write_text("of the user")
    (old / "figures" / "photo.png").write_text("of the user")
    for stale in ("report.html", "verdict.csv", "figures/bilinear.png", "figures/bilinear.svg", "macro/curve.csv"):
        (old / stale).parent.mkdir(exist_ok=True)
        (old / stale).write_text("stale")
    other = replace(case.read(DATA / "tower_5_blocks.json"), run=micro_case().run)
    with pytest.raises(Killed):
        driver.run(other, old, False, None, killing(4))
    assert len([*(old / "micro" / "states").glob("*.h5")]) == 4
    for stale in (
        "macro",
        "report.html",
        "verdict.csv",
        "summary.json",
        "figures/bilinear.png",
        "figures/bilinear.svg",
    ):
        assert not (old / stale).exists()
    assert (old / "notes.txt").read_text() == (old / "figures" / "photo.png").read_text() == "of the user"
    outcome = driver.run(other, old, True, None, lambda event: None)
    assert outcome.summary.wall.blocks == 5
    assert not outcome.complaints


def test_what_does_not_fit_into_the_memory_is_refused_before_anything_is_written(tmp_path):
    run(tmp_path)
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    with pytest.raises(CaseError, match=r"mesh\.size"):
        run(tmp_path, mesh=replace(micro_case().mesh, size=1e-4))
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before
    _, said = load_cases.examine(replace(micro_case(), mesh=replace(micro_case().mesh, size=1e-4)))
    assert any("run does not: " in one and "mesh.size" in one for one in said)


def both_models(folder, resume=False, killed_after=None, models=("macro", "micro"), displacement=1e-3, **changes):
    """Run a tower, killed after an increment of micro-FE (None: never); return the summary."""

    def report(event):
        if isinstance(event, IncrementDone) and (event.model, event.increment.number) == ("micro", killed_after):
            raise Killed

    tower = case.read(DATA / "tower_5_blocks.json", [f"stepping.final_displacement={displacement}"])
    chosen = replace(tower, run=case.RunSettings(models), **changes)
    return driver.run(chosen, folder, resume, None, report).summary


def test_a_finished_model_is_carried_on_where_the_other_one_is_resumed(tmp_path):
    """Both have a folder, so both have their place in the summary."""
    before = both_models(tmp_path).pushover
    for one in ("macro", "micro"):
        after = both_models(tmp_path, resume=True, models=(one,)).pushover
        assert [pushed.model for pushed in after] == ["macro", "micro"]
        assert [pushed.peak_multiplier for pushed in after] == [pushed.peak_multiplier for pushed in before]
    assert case.read(tmp_path / "case.toml").run.models == ("macro", "micro")
    with pytest.raises(CaseError, match=r"'-x' here, and '\+x' in .*without --resume"):
        both_models(tmp_path, resume=True, models=("macro",), load=case.LoadSettings("-x"))


def test_a_model_that_was_stopped_is_gone_on_with_only_when_it_is_asked_for(tmp_path):
    with pytest.raises(Killed):
        both_models(tmp_path, killed_after=4)
    assert [pushed.model for pushed in both_models(tmp_path, resume=True, models=("macro",)).pushover] == ["macro"]
    left = sorted((tmp_path / "micro" / "states").glob("*.h5"))
    assert len(left) == 4
    both = both_models(tmp_path, resume=True, models=("micro",))
    assert [pushed.model for pushed in both.pushover] == ["macro", "micro"]
