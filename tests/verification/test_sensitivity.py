"""Sensitivity of one block on the ground, by closed form.

A slender block (b < mu h) overturns at lambda = b/h, whatever its unit weight, thickness and friction above b/h. A
squat one slides at lambda = mu: linear in friction, and its fragility is the distribution of friction itself. With the
kinematic approach (Circolare 7/2019, linear, ground A of EN 1998-1, S = 1) it passes up to a_g = q lambda g / FC.
"""

from __future__ import annotations

import csv
import json
from collections import Counter
from dataclasses import replace
from math import exp, log, radians, sqrt, tan

import numpy as np
import pytest

from orchestrator.app import sensitivity_runs
from orchestrator.app.cli import main
from orchestrator.app.counted_capacity import ACCELERATION, MULTIPLIER, governing
from orchestrator.assessment.sensitivity import SensitivitySettings, fragility, latin_hypercube, lognormal, ranges
from orchestrator.basis.errors import CaseError
from orchestrator.present.verdict import Answered
from orchestrator.settings import case as cases
from orchestrator.storage.summary import LimitSummary, Summary, WallSummary
from tests.support.ranks import on_ranks
from tests.support.verdicts import check, summary

SAMPLES = 16
RANGES = """
[sensitivity]
friction = [0.55, 0.75]
unit_weight = ["16 kN/m3", "24 kN/m3"]
samples = {samples}
seed = {seed}
"""


def quiet(event):
    pass


def write(folder, width, height, more="", samples=SAMPLES, seed=1):
    """Write a block of 1 m thickness on the ground, friction 0.6, and its ranges; return the case file."""
    ground = {"id": 0, "polygon": [[-5, -1], [9, -1], [9, 0], [-5, 0]], "fixed": True}
    block = {"id": 1, "polygon": [[0, 0], [width, 0], [width, height], [0, height]]}
    record = {"units": {"length": "m", "unit_weight": "kN/m3"}, "thickness": 1.0, "friction": 0.6, "unit_weight": 20.0}
    (folder / "block.json").write_text(json.dumps(record | {"blocks": [ground, block]}), encoding="utf-8")
    path = folder / "case.toml"
    path.write_text("[wall]\nblocks = 'block.json'\n" + RANGES.format(samples=samples, seed=seed) + more, "utf-8")
    return path


def bars(outcome):
    return {bar["name"]: (bar["at_low"], bar["at_high"]) for bar in outcome.bars}


def test_a_slender_block_overturns_at_b_over_h_whatever_weight_and_friction(tmp_path):
    path = write(tmp_path, 0.5, 1.0)
    outcome = sensitivity_runs.sensitivity(cases.read(path), tmp_path / "out", None, quiet)
    assert outcome.base == pytest.approx(0.5, rel=1e-6)
    for pair in bars(outcome).values():
        assert pair == pytest.approx((0.5, 0.5), rel=1e-6)
    assert outcome.samples == pytest.approx([0.5] * SAMPLES, rel=1e-6)
    assert outcome.fit is None, "one answer has no dispersion"
    assert "All samples have one answer: these ranges do not matter." in sensitivity_runs.words(outcome)
    kinds = Counter({outcome.kind: SAMPLES - 2, "no answer": 1, "an upper bound only": 1})
    left_out = replace(outcome, samples=(*outcome.samples[:-2], None, None), kinds=kinds)
    said = sensitivity_runs.words(left_out)
    assert "14 samples have one answer, 2 are left out: whether these ranges matter is not known." in said
    assert not any("do not matter" in text for text in said)


@pytest.fixture(scope="module")
def squat(tmp_path_factory):
    folder = tmp_path_factory.mktemp("squat")
    path = write(folder, 4.0, 1.0)
    return path, sensitivity_runs.sensitivity(cases.read(path), folder / "out", None, quiet), folder / "out"


def test_a_squat_block_slides_at_its_friction_and_the_tornado_is_its_range(squat):
    _, outcome, _ = squat
    assert outcome.base == pytest.approx(0.6, rel=1e-6)
    assert bars(outcome)["friction"] == pytest.approx((0.55, 0.75), rel=1e-6)
    assert bars(outcome)["unit_weight"] == pytest.approx((0.6, 0.6), rel=1e-6)
    assert [bar["name"] for bar in outcome.bars] == ["friction", "unit_weight"], "the longest bar is on top"


def test_the_fragility_of_a_sliding_block_is_the_uniform_distribution_of_its_friction(squat):
    """The i-th smallest of n lies in the i-th of n equal strata: F and the points differ by half a stratum at most."""
    _, outcome, folder = squat
    ordered, probability = fragility(outcome.samples)
    exact = (ordered - 0.55) / (0.75 - 0.55)
    assert np.all(np.abs(exact - probability) <= 0.5 / SAMPLES + 1e-6)
    assert [int(SAMPLES * x) for x in exact] == list(range(SAMPLES)), "one in each stratum"
    with (folder / "fragility.csv").open() as file:
        rows = list(csv.reader(file))
    assert rows[0] == ["load multiplier", "probability", "lognormal"]
    assert [float(row[0]) for row in rows[1:]] == pytest.approx(ordered.tolist())


def test_the_fit_of_a_uniform_range_is_that_of_the_integrals_and_says_how_far_off_it_is(squat):
    """Of mu uniform on [a, b]: E ln mu = (b ln b - a ln a)/(b - a) - 1; E ln^2 mu likewise by parts."""
    a, b = 0.55, 0.75
    mean = (b * log(b) - a * log(a)) / (b - a) - 1
    square = (b * (log(b) ** 2 - 2 * log(b) + 2) - a * (log(a) ** 2 - 2 * log(a) + 2)) / (b - a)
    fit = squat[1].fit
    stratum = (b - a) / SAMPLES / a
    assert fit.median == pytest.approx(exp(mean), rel=stratum)
    assert fit.beta == pytest.approx(sqrt(square - mean**2), abs=stratum)
    assert 0.03 < fit.distance < 0.2, "a uniform distribution is no lognormal one"


def test_with_a_ground_acceleration_the_fragility_is_in_that(tmp_path):
    more = "[seismic]\npeak_ground_acceleration = '0.3 g'\nlimit_state = 'SD'\n"
    path = write(tmp_path, 4.0, 1.0, more)
    outcome = sensitivity_runs.sensitivity(cases.read(path), tmp_path / "out", None, quiet)
    assert outcome.quantity == "ground acceleration that passes (m/s²)"
    assert bars(outcome)["friction"] == pytest.approx((2 * 0.55 * 9.81 / 1.35, 2 * 0.75 * 9.81 / 1.35), rel=1e-5)


def test_the_same_seed_gives_the_same_samples_and_another_one_others():
    given = {"friction": (0.4, 0.8), "cohesion": (0.0, 1e5)}
    assert latin_hypercube(given, 8, 1) == latin_hypercube(given, 8, 1) != latin_hypercube(given, 8, 2)
    for number, (low, high) in enumerate(given.values()):
        values = [point.values[number][1] for point in latin_hypercube(given, 8, 3)]
        assert sorted(int(8 * (value - low) / (high - low)) for value in values) == list(range(8))


def test_what_is_there_is_not_run_again_and_another_range_is(squat, monkeypatch):
    path, before, folder = squat
    ran = []
    monkeypatch.setattr(sensitivity_runs, "compute", lambda run: ran.append(run.point.name) or "")
    after = sensitivity_runs.sensitivity(cases.read(path), folder, None, quiet)
    assert (ran, after.samples, after.bars) == ([], before.samples, before.bars)
    (folder / "points" / next((folder / "points").iterdir())).unlink()
    monkeypatch.undo()
    again = sensitivity_runs.sensitivity(cases.read(path), folder, None, quiet)
    assert again.samples == before.samples, "the one that was missing is as it was"


def test_ranks_change_no_number(squat, tmp_path):
    path, alone, _ = squat
    done = on_ranks(3, "-m", "tests.support.undrawn", "sensitivity", path, "--output", tmp_path / "out")
    assert done.returncode == 0, done.stdout + done.stderr
    with (tmp_path / "out" / "sensitivity.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["point"].startswith("sample")]
    assert [float(row["capacity"]) for row in rows] == list(alone.samples)


def test_a_wall_that_does_not_stand_has_no_capacity_and_no_fit(tmp_path, capsys):
    """A block on a slope of 0.6 slides under its weight below that friction."""
    slope = {"id": 0, "polygon": [[0, 0], [0, -3], [5, -3]], "fixed": True}
    block = {"id": 1, "polygon": [[1, -0.6], [2, -1.2], [2.6, -0.2], [1.6, 0.4]]}
    record = {"units": {"length": "m", "unit_weight": "kN/m3"}, "thickness": 1.0, "friction": 0.7, "unit_weight": 20.0}
    (tmp_path / "block.json").write_text(json.dumps(record | {"blocks": [slope, block]}))
    text = "[wall]\nblocks = 'block.json'\n[sensitivity]\nfriction = [0.5, 0.7]\nsamples = 4\n"
    (tmp_path / "case.toml").write_text(text)
    assert main(["sensitivity", str(tmp_path / "case.toml"), "--output", str(tmp_path / "out")]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "2 of them do not stand under their dead load" in printed
    assert lognormal([0.0, 0.3]) is None


def test_a_wall_that_an_extra_dead_load_brings_down_has_no_capacity_either(tmp_path, capsys):
    """A block of 1.2 m2 that stands 0.1 m inside the edge below, with 5 kN 0.4 m beyond that: it falls below
    2 kN m / 0.1 m / 1.2 m3 = 16.7 kN/m3. As given it stands at 20, and half of the samples lie below."""
    ground, below = [[-1, -0.2], [2, -0.2], [2, 0], [-1, 0]], [[0, 0], [1, 0], [1, 1], [0, 1]]
    above = [[0.3, 1], [1.5, 1], [1.5, 2], [0.3, 2]]
    blocks = [{"id": n, "polygon": p, "fixed": not n} for n, p in enumerate((ground, below, above))]
    record = {"units": {"length": "m", "unit_weight": "kN/m3"}, "thickness": 1.0, "friction": 0.7, "unit_weight": 20.0}
    (tmp_path / "block.json").write_text(json.dumps(record | {"blocks": blocks}))
    text = "[wall]\nblocks = 'block.json'\n[[load.dead]]\nblocks = [2]\nforce = '5 kN'\nat = [1.4, 2]\n"
    text += "[sensitivity]\nunit_weight = ['11.7 kN/m3', '21.7 kN/m3']\nsamples = 4\n"
    (tmp_path / "case.toml").write_text(text)
    assert main(["sensitivity", str(tmp_path / "case.toml"), "--output", str(tmp_path / "out")]) == 0
    assert "2 of them do not stand under their dead load" in " ".join(capsys.readouterr().out.split())
    with (tmp_path / "out" / "sensitivity.csv").open() as file:
        (low,) = (row for row in csv.DictReader(file) if row["point"] == "unit_weight low")
    assert (float(low["capacity"]), low["kind"], low["check"]) == (0.0, "cannot stand", "dead load")
    assert low["remark"].startswith("the wall stands under its own weight, but not under this dead load too: block 2 ")


@pytest.mark.parametrize(
    ("given", "key"),
    [
        ({}, "sensitivity"),
        ({"friction": (0.7, 0.5)}, "sensitivity.friction"),
        ({"cohesion": (1.0,)}, "sensitivity.cohesion"),
    ],
)
def test_what_is_no_range_is_refused_by_its_key(given, key):
    with pytest.raises(CaseError) as refused:
        ranges(SensitivitySettings(**given))
    assert refused.value.key == key


def test_a_curve_without_its_peak_is_not_compared_with_a_peak(tmp_path, capsys):
    """A cube slides at friction 0.3 and has its peak; at 0.98 it rises to 0.98 and is not there by 0.065 mm: no end of
    a bar."""
    more = "analysis = 'macro'\n[mesh]\nsize = '0.2 m'\n[stepping]\nfinal_displacement = '0.065 mm'\n"
    path = write(tmp_path, 1.0, 1.0, samples=4)
    text = path.read_text("utf-8").replace("friction = [0.55, 0.75]", "friction = [0.25, 0.98]")
    path.write_text("\n".join(line for line in text.splitlines() if "unit_weight" not in line) + "\n" + more, "utf-8")
    block = tmp_path / "block.json"
    block.write_text(block.read_text("utf-8").replace('"friction": 0.6', '"friction": 0.3'), "utf-8")
    assert main(["sensitivity", str(path), "--output", str(tmp_path / "out")]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    with (tmp_path / "out" / "sensitivity.csv").open() as file:
        rows = {row["point"]: row for row in csv.DictReader(file)}
    assert rows["as given"]["kind"] == rows["friction low"]["kind"] == "peak of a curve"
    assert rows["friction high"]["kind"] == "curve without its peak"
    assert float(rows["friction high"]["capacity"]) > 0.6, "what was found stands in the table"
    outcome = sensitivity_runs.sensitivity(cases.read(path), tmp_path / "out", None, quiet)
    assert bars(outcome)["friction"] == (pytest.approx(0.25, rel=1e-3), None)
    assert f"friction 0.98: {float(rows['friction high']['capacity']):.4g}, curve without its peak" in printed
    assert "curve without its peak, not compared with the case as given (peak of a curve)" in printed
    counted = [row for name, row in rows.items() if name.startswith("sample") and row["kind"] == "peak of a curve"]
    assert [capacity for capacity in outcome.samples if capacity is not None] == [
        float(row["capacity"]) for row in counted
    ]
    others = 4 - len(counted)
    assert 0 < others < 4, "in the uppermost quarter of the range the cube has no peak yet"
    have = "1 of 4 samples has" if others == 1 else f"{others} of 4 samples have"
    assert f"{have} another kind of answer ({others} curve without its peak)" in printed


def limit(**changes):
    found = {"associative": 0.5, "non_associative": 0.4, "non_associative_range": (0.4, 0.4), "iterations": 1}
    found |= {"converged": True, "equilibrium_residual": 0.0, "base_shear": 4e3, "seconds": 0.0}
    return Summary("", WallSummary(1, 1, 1e4, 1e4, 1e4), LimitSummary(**found | changes), None, ())


@pytest.mark.parametrize(
    ("changes", "kind"),
    [
        ({}, "collapse state"),
        ({"converged": False}, "last load at rest"),
        ({"non_associative": None, "non_associative_range": None, "converged": False}, "an upper bound only"),
    ],
)
def test_a_last_rest_and_an_upper_bound_are_called_so(changes, kind):
    found = governing([Answered("a", "+x", "mass", limit(**changes))], [], MULTIPLIER)
    assert (found["kind"], found["capacity"]) == (kind, limit(**changes).limit_analysis.multiplier)


def test_a_check_that_could_not_be_made_is_one():
    refused = {"approach": "N2, micro-FE", "limit_state": "all", "refused": "the peak was not reached"}
    found = governing([Answered("a", "+x", "mass", summary(check(1.5), refused))], [], ACCELERATION)
    assert found["remark"].startswith("1 check could not be made")


STONE = """
[wall]
blocks = "stone.json"
[load]
{common}
{cases}
[sensitivity]
friction = [0.4, 0.6]
samples = 6
"""
TWO = """
[[load.cases]]
name = "mass"
dead = [{blocks = [1], force = "0.5 kN", at = [0.5, 1.0]}]
[[load.cases]]
name = "top"
distribution = "per_block"
inclination = "20 deg"
live = [{blocks = [1], force = "100 N"}]
dead = [{blocks = [1], force = "0.5 kN", at = [0.0, 1.0]}]
"""


def write_stone(folder, load_cases, common=""):
    """Write a stone of 3 kN, 0.5 m wide and 1 m high, with its load cases; return the case file."""
    ground = {"id": 0, "polygon": [[-1, -0.2], [2, -0.2], [2, 0], [-1, 0]], "fixed": True}
    block = {"id": 1, "polygon": [[0, 0], [0.5, 0], [0.5, 1], [0, 1]]}
    record = {"units": {"length": "m", "unit_weight": "kN/m3"}, "thickness": 0.3, "friction": 0.9, "unit_weight": 20.0}
    (folder / "stone.json").write_text(json.dumps(record | {"blocks": [ground, block]}), "utf-8")
    (folder / "stone.toml").write_text(STONE.format(common=common, cases=load_cases), "utf-8")
    return folder / "stone.toml"


def of_stone(folder, load_cases, common="", more=()):
    """Run the ranges of a stone; return the rows of the table by point."""
    path = write_stone(folder, load_cases, common)
    assert main(["sensitivity", str(path), "--output", str(folder / "out"), *more]) == 0
    with (folder / "out" / "sensitivity.csv").open(encoding="utf-8") as file:
        return {row["point"]: row for row in csv.DictReader(file)}


def test_load_cases_of_other_live_loads_are_compared_by_base_shear(tmp_path, capsys):
    """W = 3 kN and 0.5 kN on it. By mass it overturns at W b / h = 1.5 kN and slides at 3.5 mu kN; under a force F that
    points up by 20 degrees it slides at F cos 20 = 3.5 mu / (1 + mu tan 20) kN, and overturns at 1.69 kN."""
    rows = of_stone(tmp_path, TWO)
    friction = {name: float(row["friction"] or 0.9) for name, row in rows.items()}
    for name, row in rows.items():
        sliding = 3.5 * friction[name] / (1.0 + friction[name] * tan(radians(20.0)))
        assert float(row["capacity"]) == pytest.approx(min(sliding, 1.5), rel=1e-6)
        assert row["load_case"] == ("top" if sliding < 1.5 else "mass")
        assert row["quantity"] == "base shear (kN)"
    ordered = [float(rows[name]["capacity"]) for name in sorted(friction, key=friction.get)]
    assert ordered == pytest.approx(sorted(ordered), rel=1e-6), "more friction bears no less"
    said = " ".join(capsys.readouterr().out.split())
    assert "6 samples, base shear (kN): from " in said
    with (tmp_path / "out" / "fragility.csv").open(encoding="utf-8") as file:
        assert next(csv.reader(file))[0] == "base shear (kN)"


def test_load_cases_of_one_horizontal_load_are_compared_by_its_multiplier(tmp_path):
    """The envelope: all four load cases have the weight as their horizontal load, whatever the unit weight."""
    rows = of_stone(tmp_path, "", "envelope = true", ["--set", 'sensitivity.unit_weight=["16 kN/m3", "24 kN/m3"]'])
    assert {row["quantity"] for row in rows.values()} == {"load multiplier"}
    for row in rows.values():
        assert float(row["capacity"]) == pytest.approx(min(float(row["friction"] or 0.9), 0.5), rel=1e-6)


@pytest.mark.parametrize("degrees", [90, -90, 89.99, 80])
def test_a_load_case_that_lifts_or_presses_does_not_govern_by_its_small_base_shear(tmp_path, capsys, degrees):
    """At 80 degrees the stone is all but lifted at a base shear of W / tan 80, a third of what overturns it."""
    steep = f'[[load.cases]]\nname = "side"\n[[load.cases]]\nname = "steep"\ninclination = "{degrees} deg"\n'
    if degrees < 0:  # pressed along its weight it stands for ever, pressed on its edge it slides or overturns
        steep += 'distribution = "per_block"\nlive = [{blocks = [1], force = "1 kN"}]\n'
    rows = of_stone(tmp_path, steep)
    assert {row["load_case"] for row in rows.values()} == {"side"}
    assert float(rows["as given"]["capacity"]) == pytest.approx(0.5, rel=1e-6)
    assert float(rows["friction low"]["capacity"]) == pytest.approx(0.4, rel=1e-6)
    said = " ".join(capsys.readouterr().out.split())
    assert "Not compared, as more vertical than horizontal: steep." in said


def test_load_cases_that_no_base_shear_compares_are_refused(tmp_path, capsys):
    steep = "".join(f'[[load.cases]]\nname = "{n}"\ninclination = "{n} deg"\n' for n in (60, 90))
    assert main(["sensitivity", str(write_stone(tmp_path, steep)), "--output", str(tmp_path / "out")]) == 2
    assert "stone.toml: load.cases: all of them have a live load that is more vertical" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
