"""A peak that is only a lower bound, or of a curve that is not valid, says so wherever it is printed."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from orchestrator import storage
from orchestrator.app.commands import console_of
from orchestrator.assessment.capacity import Capacity
from orchestrator.limit_analysis import analyse
from orchestrator.present import plots
from orchestrator.present.answer import answer_of_limit, answer_of_run
from orchestrator.present.phrases import phrases
from orchestrator.present.tables import limit_table, load_cases_table, run_table
from orchestrator.present.verdict import Answered, kind_of, sentence, verdict
from orchestrator.pushover.increments import PushoverCurve
from orchestrator.storage.notes import COARSE_TOES, DISTRUST
from tests.support.limit_analysis_cases import assemblage_of, box
from tests.support.pushed import PUSHED
from tests.support.verdicts import of, summary

SHORT = replace(PUSHED, peak_reached=False)
INVALID = replace(SHORT, valid=False, not_valid_because="equilibrium: too far off")


def text_of(table):
    console = console_of(width=120)
    with console.capture() as capture:
        console.print(table)
    return capture.get()


@pytest.mark.parametrize(("pushed", "said"), [(PUSHED, False), (SHORT, True), (INVALID, False)])
def test_a_peak_that_was_not_reached_is_at_least_that_only_of_a_valid_curve(pushed, said):
    found = replace(summary(), pushover=(pushed,))
    row = {
        "load_case": "a", "model": "micro", "valid": pushed.valid, "peak_reached": pushed.peak_reached,
        "associative": 0.3, "kind": "collapse state", "non_associative": 0.25,
        "peak_multiplier": pushed.peak_multiplier, "peak_base_shear_N": pushed.peak_base_shear,
        "displacement_at_peak_m": 0.005, "initial_stiffness_N_per_m": 1e6,
    }  # fmt: skip
    for table in (run_table(found), load_cases_table("wall", [row])):
        assert ("≥ 0.2968" in text_of(table)) is said
        assert ("NOT VALID" in text_of(table)) is not pushed.valid
    assert any("carries at least" in remark for remark in storage.remarks(found)) is said
    assert any("the peak was not reached" in remark for remark in storage.remarks(found)) is not pushed.peak_reached


def test_a_last_rest_is_no_collapse_multiplier():
    """A block 0.5 m wide and 1 m high overturns at 0.5; made one that no limit state closed."""
    found = analyse(assemblage_of([box(-3, -1, 6, 1), box(0, 0, 0.5, 1.0)]))
    assert "counts" in answer_of_limit(found)
    rest = replace(found, path=replace(found.headline, flow_rule="last_rest", converged=False))
    assert rest.headline.flow_rule == "last_rest"
    said = answer_of_limit(rest)
    assert said.startswith("Loading met no limit state; the wall was at rest up to λ = (0.5")
    assert "counts" not in said
    limit = storage.limit_summary(rest)
    assert limit.kind == "last load at rest"
    assert storage.limit_summary(found).kind == "collapse state"
    whole = replace(summary(), limit_analysis=limit)
    assert "micro-LA last at rest" in text_of(run_table(whole))
    assert "(0.5000)" in text_of(run_table(whole))


@pytest.mark.parametrize(("over", "crushing", "toe", "said"), [
    (1.06, True, 0.0, 1), (1.04, True, 0.0, 0), (1.06, False, 0.0, 0), (0.9, True, 0.02, 1), (1.06, True, 0.02, 2),
])  # fmt: skip
def test_a_peak_far_above_the_bound_where_joints_crush_is_doubted_in_remarks_and_verdict(over, crushing, toe, said):
    found = summary()
    peak = over * found.limit_analysis.bound
    pushed = replace(PUSHED, peak_multiplier=peak, crushing=crushing, toe_error=toe)
    found = replace(found, pushover=(pushed,))
    assert sum(COARSE_TOES in remark for remark in storage.remarks(found)) == said
    whole = of(a=found)
    assert "; ".join(whole.rows[0]["remarks"]).count(COARSE_TOES) == said
    assert (COARSE_TOES in sentence(whole)) is (said > 0)
    assert COARSE_TOES not in sentence(whole, phrases("it"))
    assert kind_of(whole.rows[0], found) == "peak of a curve"


@pytest.mark.parametrize(("model", "over", "said"), [("macro", 1.06, 1), ("macro", 1.04, 0), ("micro", 1.06, 0)])
def test_macroblocks_that_bear_far_more_than_every_stone_as_a_rigid_block_are_doubted(model, over, said):
    """Lower or upper end of an interval: beyond the upper one it is told, in remarks and verdict."""
    doubt = "compare with --model micro"
    found = summary()
    low, high = 0.9 * found.limit_analysis.multiplier, found.limit_analysis.multiplier
    limit = replace(found.limit_analysis, non_associative=low, interval=(low, high), associative=2.0 * high)
    found = replace(found, limit_analysis=limit, pushover=())
    found = replace(found, pushover=(replace(PUSHED, model=model, bodies=3, peak_multiplier=over * high),))
    assert sum(doubt in remark for remark in storage.remarks(found)) == said
    assert "; ".join(of(a=found).rows[0]["remarks"]).count(doubt) == said
    assert (doubt in sentence(of(a=found))) is (said > 0)
    assert doubt not in sentence(of(a=found), phrases("pt"))


@pytest.mark.parametrize(
    ("model", "bodies", "over", "moved", "said"),
    [
        ("micro", 4, 1.06, None, True),
        ("micro", 4, 1.04, None, False),
        ("micro", 4, 1.06, 1.05, False),  # rigid blocks bear as much once they have moved
        ("macro", 4, 1.06, None, True),  # as many macroblocks as stones
        ("macro", 3, 1.06, None, False),
    ],
)
def test_every_stone_far_above_the_associative_bound_is_to_be_distrusted(model, bodies, over, moved, said):
    """No theorem for large displacements, but nothing that dry stones do explains so much."""
    found = summary()
    bound = found.limit_analysis.bound
    limit = replace(found.limit_analysis, large_displacements=moved and moved * bound)
    pushed = replace(PUSHED, model=model, bodies=bodies, peak_multiplier=over * bound)
    found = replace(found, limit_analysis=limit, pushover=(pushed,))
    told = f"{model} FE: {DISTRUST} "
    remarks = storage.remarks(found)
    assert any(remark.startswith(told) for remark in remarks) is said
    assert any(remark.startswith(told) for remark in of(a=found).rows[0]["remarks"]) is said
    assert any("tension inside macroblocks" in remark for remark in remarks) is (bodies == 3)
    assert not any(DISTRUST in phrases("it")(remark) for remark in remarks)
    assert (DISTRUST in answer_of_run(found).lower()) is said
    assert ("counts" in answer_of_run(found)) is not said


def test_pictures_and_page_bracket_a_last_rest_and_say_at_least_of_a_peak_that_was_not_reached():
    found = analyse(assemblage_of([box(-3, -1, 6, 1), box(0, 0, 0.5, 1.0)]))
    rest = replace(found, path=replace(found.headline, flow_rule="last_rest", converged=False))
    shear, none, counts = np.array([0.0, 5.0]), np.zeros(2), np.zeros(2, int)
    columns = (counts, none, shear, shear, shear, 1e-3 * shear, none, none, *4 * [counts], none, counts, counts, "")
    curve, capacity = PushoverCurve(*columns), Capacity(5.0, 0.5, 0.005, 0.005, 1e3, 0.0, False)
    said = limit_lines(found, capacity, curve)
    assert [line for line in said if "micro-LA, collapse state met by loading: λ = 0.5" in line]
    (line,) = [line for line in limit_lines(rest, capacity, curve) if "collapse state" in line or "rest" in line]
    assert re.fullmatch(r"micro-LA, last load at rest: λ = \(0\.5\d+\)", line)
    title = plots.mechanism(assemblage_of([box(-3, -1, 6, 1), box(0, 0, 0.5, 1.0)]), rest.headline, np.array([1.0, 0]))
    assert "(last load at rest): load multiplier (0.5" in title.axes[0].get_title()
    assert any(line.startswith("peak ≥ 0.005") and "λ ≥ 0.5" in line for line in limit_lines(found, capacity, curve))
    for line in (*limit_lines(rest, capacity, curve), title.axes[0].get_title().splitlines()[1]):
        assert phrases("it")(line) != line


def limit_lines(analysis, capacity, curve):
    figure = plots.curves({"macroblock FE (3 bodies)": (curve, capacity)}, analysis, "")
    return [text.get_text() for text in figure.legends[0].get_texts()]


def test_a_peak_in_large_displacements_is_called_so_everywhere():
    """Where geometry decides the wall was not at rest up to the answer: it bears it, and then gives way."""
    assemblage = assemblage_of([box(-3, -1, 6, 1), box(0, 0, 0.5, 1.0)])
    found = analyse(assemblage)
    peak = replace(found.headline, flow_rule="large_displacements", load_multiplier=0.47, converged=False)
    decided = replace(found, path=peak, drawn=found.path, rigid_curve=np.array([[0.0, 0.0], [0.01, 0.47]]))
    limit = storage.limit_summary(decided)
    assert limit.kind == "peak in large displacements"
    tables = text_of(run_table(replace(summary(), limit_analysis=limit))) + text_of(limit_table(decided))
    title = plots.mechanism(assemblage, decided.headline, np.array([1.0, 0])).axes[0].get_title()
    assert "micro-LA large displ." in tables
    assert "peak in large displacements" in tables
    assert "(peak in large displacements): load multiplier (0.4700" in title
    verdict_of = verdict("wall", [Answered("a", "+x", "mass", replace(summary(), limit_analysis=limit, pushover=()))])
    assert "(peak in large displacements)" in sentence(verdict_of)
    assert not [said for said in (tables, title, sentence(verdict_of)) if "rest" in said.replace("interest", "")]


def test_macroblocks_that_bear_more_than_limit_analysis_do_not_count():
    """Neither in the sentence nor in the verdict, nor beside every stone as its approximation."""
    found = summary()
    high = found.limit_analysis.multiplier
    limit = replace(found.limit_analysis, associative=2.0 * high)
    macro = replace(PUSHED, model="macro", bodies=3, peak_multiplier=1.375 * high, peak_base_shear=11e3)
    alone = replace(found, limit_analysis=limit, pushover=(macro,))
    said = answer_of_run(alone)
    assert said.startswith("No finite element number counts: 11.00 kN")
    assert "take limit analysis (λ = 0.25000)" in said
    assert not storage.counts(alone)
    (row,) = of(a=alone).rows
    assert (row["check"], row["capacity"], row["governs"]) == ("limit analysis", limit.base_shear, "yes")
    both = replace(alone, pushover=(macro, replace(PUSHED, peak_multiplier=high, peak_base_shear=8e3)))
    said = answer_of_run(both)
    assert said.startswith("8.000 kN counts")
    assert "macroblocks (11.00 kN, +37.5%) do not count" in said
    assert storage.counts(both)
    assert of(a=both).rows[0]["capacity"] == 8e3


def test_a_peak_of_what_is_left_says_how_much_has_fallen():
    """The bound is of what is left: 0.7, where the whole wall bears 0.3."""
    found, fell = summary(), storage.AtPeak(fallen=0.375, bound_left=0.7)
    pushed = replace(PUSHED, peak_multiplier=0.7, at_peak=fell)
    left = replace(found, pushover=(pushed,))
    assert "(λ = 0.7000, FE of every stone), of what is left when 38 % of the dead load has fallen;" in answer_of_run(
        left
    )
    told = "micro FE: the peak is of what is left when 38 % of the dead load has fallen"
    assert told in storage.remarks(left)
    assert told in of(a=left).rows[0]["remarks"]
    assert not any(DISTRUST in remark for remark in storage.remarks(left))
    low = replace(found, pushover=(replace(pushed, at_peak=replace(fell, bound_left=0.6)),))
    assert any(DISTRUST in remark for remark in storage.remarks(low))


@pytest.mark.parametrize(("drawn", "distrusted"), [(0.29, False), (0.5, True), (None, True)])
def test_a_peak_that_contacts_bear_which_were_not_drawn_is_told_as_such(drawn, distrusted):
    """Bound 0.3, peak 0.5: without the new contacts the moved wall bears 0.29, or as much as with them."""
    found = replace(
        summary(), pushover=(replace(PUSHED, peak_multiplier=0.5, at_peak=storage.AtPeak(0.0, None, drawn)),)
    )
    remarks = storage.remarks(found)
    assert any(DISTRUST in remark for remark in remarks) is distrusted
    assert any("without contacts that were not drawn" in remark for remark in remarks) is not distrusted
    assert ("contacts that were not drawn, without which it bears" in answer_of_run(found)) is not distrusted
    assert "finer mesh" not in answer_of_run(found) or distrusted


def test_a_wall_that_supports_hold_has_no_number():
    found = replace(summary(), pushover=(replace(PUSHED, held=True, peak_reached=False, peak_multiplier=0.6),))
    said = answer_of_run(found)
    assert said.startswith("Held by supports once it has moved: this load does not bring the wall down")
    assert "counts" not in said
    assert not any("carries at least" in remark or DISTRUST in remark for remark in storage.remarks(found))
    (row,) = of(a=found).rows
    assert row["check"] == "limit analysis"
    assert "this load does not bring the wall down" in row["remarks"][0]


@pytest.mark.parametrize(("increment", "said"), [(7, ["fell at a load"]), (9, ["fell after the peak, at a load"])])
def test_what_falls_after_the_peak_is_said_to(increment, said):
    event = storage.Event(("body 1",), 0.02, 0.25, 2.0, increment)
    pushed = replace(PUSHED, events=(event,), at_peak=storage.AtPeak(increment=8))
    remarks = storage.remarks(replace(summary(), pushover=(pushed,)))
    assert [text for text in ("fell at a load", "fell after the peak, at a load") if text in "".join(remarks)] == said


@pytest.mark.parametrize(
    ("model", "over", "said"), [("micro", 1.06, True), ("micro", 1.04, False), ("macro", 1.06, False)]
)
def test_every_stone_far_above_limit_analysis_is_told(model, over, said):
    found = summary()
    limit = replace(found.limit_analysis, associative=2.0 * found.limit_analysis.multiplier)
    pushed = replace(PUSHED, model=model, bodies=3, peak_multiplier=over * limit.multiplier)
    remarks = storage.remarks(replace(found, limit_analysis=limit, pushover=(pushed,)))
    assert any("what every stone bears in limit analysis: friction may lead" in remark for remark in remarks) is said


def test_of_a_peak_far_above_limit_analysis_it_is_said_that_stones_have_fallen_here_alone():
    """Nine stones of which two fall at 0.1447, where limit analysis has the wall fail, and the others bear 0.2756."""
    found = summary()
    limit = replace(found.limit_analysis, associative=2.0 * found.limit_analysis.multiplier)
    peak = 1.5 * limit.multiplier
    pushed = replace(PUSHED, model="micro", bodies=3, peak_multiplier=peak, at_peak=storage.AtPeak(fallen=0.043))
    said = " ".join(storage.remarks(replace(found, limit_analysis=limit, pushover=(pushed,))))
    assert "every stone bears in limit analysis, with what has fallen here in its place: friction may lead" in said


@pytest.mark.parametrize(
    ("of", "share", "said"),
    [
        ({}, 0.89, True),
        ({}, 0.91, False),
        ({"interval": (0.5, 1.0)}, 0.89, False),
        ({"pressed_peak": 0.95}, 0.89, False),
        ({"going_down": (1,)}, 0.89, False),
    ],
)
def test_every_stone_far_below_limit_analysis_is_told(of, share, said):
    """Arches of four and five voussoirs bore half of what they bear in short elements, and less, without a word."""
    found = summary()
    load = found.limit_analysis.multiplier
    times = {"interval": lambda ends: tuple(load * end for end in ends), "pressed_peak": lambda part: load * part}
    limit = replace(found.limit_analysis, **{name: times.get(name, tuple)(value) for name, value in of.items()})
    pushed = replace(PUSHED, model="micro", bodies=3, peak_multiplier=share * load)
    remarks = storage.remarks(replace(found, limit_analysis=limit, pushover=(pushed,)))
    assert any("below" in remark and "compare with a quarter of mesh.size" in remark for remark in remarks) is said


def test_every_stone_far_below_what_loading_meets_but_not_below_other_states_is_told():
    found = summary()
    load = found.limit_analysis.multiplier
    pushed = replace(PUSHED, model="micro", bodies=3, peak_multiplier=0.8 * load)
    for lowest, said in (
        (0.79, "another state, as were found from"),
        (0.81, "another state, or elements are too long"),
    ):
        limit = replace(found.limit_analysis, lowest=lowest * load)
        (remark,) = [
            remark
            for remark in storage.remarks(replace(found, limit_analysis=limit, pushover=(pushed,)))
            if "is more than 10 % below" in remark
        ]
        assert said in remark
