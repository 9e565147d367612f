"""The verdict over load cases: what governs, what is open, and the sentence; from summaries made by hand."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from math import radians

import pytest

from orchestrator.app.cli import main
from orchestrator.app.commands import console_of
from orchestrator.assessment.seismic.verification_record import ratio
from orchestrator.assessment.seismic.verification_record import verdict as of_record
from orchestrator.loads import load_cases
from orchestrator.present.page.verdict_page import verdict_contents
from orchestrator.present.phrases import phrases
from orchestrator.present.tables import verdict_table
from orchestrator.present.verdict import COLUMNS, Answered, sentence, verdict
from orchestrator.settings import case as cases
from tests.support.leaning_stone import CASE, stone
from tests.support.pushed import PUSHED
from tests.support.undrawn import undrawn
from tests.support.verdicts import check, of, summary


def test_the_least_ratio_of_all_load_cases_governs():
    found = of(a=summary(check(1.5), check(1.2, "NC")), b=summary(check(1.3), check(1.1, "NC", "kinematic, linear")))
    assert found.state == "verified"
    assert (found.governing["load_case"], found.governing["check"]) == ("b", "kinematic, linear")
    assert [row["governs"] for row in found.rows].count("yes") == 1
    said = sentence(found)
    assert "VERIFIED (SD, NC); b governs at NC with kinematic, linear, safety ratio 1.100" in said
    assert "up to a ground acceleration of 0.220 g, 0.200 g is asked for" in said


def test_every_limit_state_that_is_not_passed_has_its_ground_acceleration():
    """A wall passed up to 0.193 g at SLC, for 0.18 g asked for at SLV, where it passes up to 0.163 g alone."""
    found = of(a=summary(check(0.9), check(0.8, "NC")), b=summary(check(0.85), check(1.2, "DL")))
    assert sentence(found).endswith(
        "to a ground acceleration of 0.160 g, 0.200 g is asked for; at SD up to 0.170 g, 0.200 g is asked for."
    )


def test_of_load_cases_that_differ_by_rounding_the_first_governs():
    """A wall that is its own mirror image, pushed both ways."""
    assert of(plus=summary(peak=9e3 * (1.0 + 1e-9)), minus=summary(peak=9e3)).governing["load_case"] == "plus"
    by_ratio = of(plus=summary(check(1.1 * (1.0 + 1e-9))), minus=summary(check(1.1)))
    assert by_ratio.governing["load_case"] == "plus"
    by_a_hair = of(plus=summary(check(1.0 + 4e-7)), minus=summary(check(1.0 - 4e-7)))
    assert (by_a_hair.state, by_a_hair.governing["load_case"]) == ("not verified", "minus")


def test_one_failed_check_of_one_load_case_is_enough():
    found = of(a=summary(check(1.5)), b=summary(check(0.999)))
    assert found.state == "not verified"
    assert ": NOT VERIFIED (SD); b governs" in sentence(found)
    of_two = of(a=summary(check(0.9), check(1.2, "DL")))
    assert ": NOT VERIFIED (SD); a governs at SD" in sentence(of_two), "DL passes"
    failed_beside_a_gap = of(a=summary(check(0.5)), b=None)
    assert failed_beside_a_gap.state == "not verified"


@pytest.mark.parametrize(
    "missing",
    [
        {"b": None},
        {"b": summary({"approach": "N2, micro-FE", "limit_state": "all", "refused": "the peak was not reached"})},
        {"b": summary(check(2.0), valid=False)},
    ],
    ids=["no curve", "refused", "not valid"],
)
def test_a_check_that_could_not_be_made_leaves_the_verdict_open(missing):
    found = of(a=summary(check(1.5)), **missing)
    assert found.state == "open"
    assert "NOT YET VERIFIED" in sentence(found)
    assert "1 check could not be made" in sentence(found)


def test_without_ground_acceleration_no_check_was_to_be_made():
    """A wall that bears less as it moves, under a load that no base shear compares, was counted as a missing check."""
    found = of(a=summary(peak=12e3), b=None)
    assert "; 1 load case has no certain answer; no ground acceleration was given" in sentence(found)
    assert "check" not in sentence(found)
    assert "; 2 load cases have no certain answer" in sentence(of(a=summary(peak=12e3), b=None, c=None))


def test_without_ground_acceleration_the_least_base_shear_governs_and_nothing_is_verified():
    found = of(a=summary(peak=12e3), b=summary(peak=9e3))
    assert (found.state, found.governing["load_case"], found.governing["capacity"]) == ("strength", "b", 9e3)
    assert "9.000 kN" in sentence(found)
    assert sentence(found).endswith("nothing is verified.")


def test_curves_that_are_not_valid_leave_limit_analysis_and_say_so():
    found = of(a=summary(valid=False))
    assert (found.governing["check"], found.governing["capacity"]) == ("limit analysis", 8e3)
    assert found.governing["remarks"] == ("no curve is valid",)
    assert "NOTHING CAN BE SAID" in sentence(of(a=None))


def near_limit_analysis(found):
    """A summary whose limit analysis has the peak of its curves."""
    return replace(found, limit_analysis=replace(found.limit_analysis, non_associative=PUSHED.peak_multiplier))


def test_macroblocks_that_count_as_their_reference_has_no_curve_say_so():
    """docs/which_number.md: the peak of every stone counts, where it was run and is valid."""
    alone, both = (near_limit_analysis(summary(models=models)) for models in (("macro",), ("macro", "micro")))
    said = "every stone, the reference of macroblocks, has no curve"
    found = of(a=replace(alone, failed={"micro": "the wall does not stand under its dead load: block 28 falls"}))
    assert (found.governing["check"], found.governing["remarks"]) == ("FE of macroblocks", (said,))
    assert said in sentence(found)
    assert of(a=alone).governing["remarks"] == ()
    broken = replace(both, pushover=(both.pushover[0], replace(both.pushover[1], valid=False)))
    said = "the curve of every stone, the reference of macroblocks, is not valid"
    assert of(a=broken).governing["remarks"] == (said,)
    assert of(a=both).governing["remarks"] == ()


def test_the_envelope_is_four_load_cases_before_those_given(tmp_path):
    (tmp_path / "stone.json").write_text(json.dumps(stone(mirror=False)))
    (tmp_path / "case.toml").write_text(
        CASE.format(blocks="stone", common="envelope = true").replace("+x mass", "mine").replace("-x mass", "other")
    )
    load = cases.read(tmp_path / "case.toml").load
    found = [(name, case.direction, case.distribution) for name, case in load_cases(load).items()]
    standard = [("+x mass", "+x", "mass"), ("-x mass", "-x", "mass")]
    assert found[:2] == standard
    assert {(direction, shape) for _, direction, shape in found[2:4]} == {("+x", "mass_height"), ("-x", "mass_height")}
    assert found[4][0] == "mine"


def test_a_run_of_load_cases_prints_and_writes_its_verdict(tmp_path, capsys):
    """The stone overturns at 0.917 to the right and at 0.583 to the left: to the left governs."""
    (tmp_path / "stone.json").write_text(json.dumps(stone(mirror=False)))
    text = CASE.format(blocks="stone", common="") + "[seismic]\npeak_ground_acceleration = '0.1 g'\n"
    (tmp_path / "case.toml").write_text(text)
    with undrawn():
        main(["run", str(tmp_path / "case.toml"), "--output", str(tmp_path / "out")])
    printed = " ".join(capsys.readouterr().out.split())
    with (tmp_path / "out" / "verdict.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert set(rows[0]) == set(COLUMNS)
    strength = {row["load_case"]: float(row["capacity"]) for row in rows if row["limit_state"] == "strength"}
    assert strength["-x mass"] < strength["+x mass"]
    (governing,) = (row for row in rows if row["governs"])
    least = min(float(row["safety_ratio"]) for row in rows if row["safety_ratio"])
    assert float(governing["safety_ratio"]) == least
    said = f"{governing['load_case']} governs at SD with {governing['check']}, safety ratio {least:.3f}"
    page = (tmp_path / "out" / "report.html").read_text()
    assert said in printed
    assert said in page
    assert (tmp_path / "out" / "-x mass" / "verdict.csv").is_file()


def test_a_doubt_that_a_refused_check_tells_is_counted_once_as_its_record_counts_it():
    """A curve that is not valid: N2 and drift are refused, and the strength from limit analysis says so too."""
    refused = [
        {"approach": approach, "limit_state": "all", "refused": "the curve is not valid", "remarks": []}
        for approach in ("N2, micro-FE", "drift, micro-FE")
    ]
    checks = [check(1.5), *refused]
    found = of(a=summary(*checks, valid=False))
    assert found.rows[0]["remarks"] == ("no curve is valid",)
    assert "2 checks could not be made" in sentence(found)
    assert "2 could not be made" in of_record({"checks": checks})
    assert [row["verified"] for row in found.rows].count("not made") == 2


def test_what_the_wall_passes_is_told_as_far_as_it_could_be_checked():
    whole, open_one = of(a=summary(check(1.5))), of(a=summary(check(1.5)), b=None)
    failed = of(a=None, b=summary(check(0.5)))
    assert "as far as it could be checked" not in sentence(whole)
    for found in (open_one, failed):
        assert ": as far as it could be checked, the wall passes up to" in sentence(found)
    assert "per quanto si è potuto verificare" in sentence(open_one, phrases("it"))
    assert "tanto quanto se pôde verificar" in sentence(open_one, phrases("pt"))


def test_a_safety_ratio_has_one_rounding_in_sentence_record_and_tables():
    checks = [check(4.23678) | {"safety_ratio_without_e_star": 3.8764}]
    assert "safety ratio 4.237" in sentence(of(a=summary(*checks)))
    assert "least safety ratio 4.237 (" in of_record({"checks": checks})
    assert ratio(checks[0]) == "4.237 (3.876)"


def steep(**summaries):
    """The verdict over load cases whose live load stands at 0, 90, 89.99 and 46 degrees, in the order given."""
    answers = zip(summaries.items(), (0.0, 90.0, 89.99, 46.0), strict=False)
    return verdict("wall", [Answered(n, "+x", "mass", s, (), radians(angle)) for (n, s), angle in answers])


def test_load_cases_more_vertical_than_horizontal_are_listed_and_not_ranked():
    found = steep(side=summary(peak=9e3), lift=summary(peak=1e-13), steep=summary(peak=1.0), inclined=summary(peak=5e3))
    assert (found.governing["load_case"], found.governing["capacity"]) == ("side", 9e3)
    assert [row["capacity"] for row in found.rows] == [9e3, "", "", ""]
    assert all(row["multiplier"] for row in found.rows), "what they bear is told"
    assert "; not compared, as more vertical than horizontal: lift, steep, inclined; no ground" in sentence(found)
    rows = verdict_contents(found, "it")["rows"]
    assert [" kN " in row["capacity"] for row in rows] == [True, False, False, False]
    assert all("λ = 0,2" in row["capacity"] for row in rows)
    assert "non confrontati, perché più verticali che orizzontali: lift" in sentence(found, phrases("it"))
    assert "não comparados, por serem mais verticais do que horizontais: lift" in sentence(found, phrases("pt"))
    console = console_of(width=120)
    with console.capture() as capture:
        console.print(verdict_table(found))
    assert capture.get().count("λ = ") == 3


def test_load_cases_of_which_none_is_compared_leave_none_to_govern():
    answers = [Answered(name, "+x", "mass", summary(peak=1e3), (), radians(80.0)) for name in ("up", "more")]
    found = verdict("wall", answers)
    assert (found.state, found.governing) == ("not compared", None)
    assert ": no load case governs by its base shear; not compared, as more vertical than horizontal: up, more; " in (
        sentence(found)
    )
    assert "nessun caso di carico governa per taglio alla base" in sentence(found, phrases("it"))
    assert "nenhum caso de carga condiciona pelo corte basal" in sentence(found, phrases("pt"))


def test_a_single_load_case_is_compared_with_nothing_and_governs():
    found = verdict("wall", [Answered("alone", "+x", "mass", summary(peak=1e3), (), radians(80.0))])
    assert (found.state, found.governing["capacity"]) == ("strength", 1e3)


def test_checks_of_steep_load_cases_are_compared_by_their_ratios():
    found = steep(side=summary(check(1.5)), lift=summary(check(1.2)))
    assert (found.state, found.governing["load_case"]) == ("verified", "lift")
    assert "not compared" not in sentence(found)
