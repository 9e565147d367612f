"""A peak that is only a lower bound, or of a curve that is not valid, says so wherever it is printed."""

from __future__ import annotations

from dataclasses import replace

import pytest
from rich.console import Console

from orchestrator import storage
from orchestrator.limit_analysis import analyse
from orchestrator.present.answer import answer_of_limit
from orchestrator.present.phrases import phrases
from orchestrator.present.tables import load_cases_table, run_table
from orchestrator.present.verdict import kind_of, sentence
from orchestrator.storage.notes import COARSE_TOES
from tests.support.limit_analysis_cases import assemblage_of, box
from tests.support.pushed import PUSHED
from tests.support.verdicts import of, summary

SHORT = replace(PUSHED, peak_reached=False)
INVALID = replace(SHORT, valid=False, not_valid_because="equilibrium: too far off")


def text_of(table):
    console = Console(width=120)
    with console.capture() as capture:
        console.print(table)
    return capture.get()


@pytest.mark.parametrize(("pushed", "said"), [(PUSHED, False), (SHORT, True), (INVALID, False)])
def test_a_peak_that_was_not_reached_is_at_least_that_only_of_a_valid_curve(pushed, said):
    found = replace(summary(), pushover=(pushed,))
    row = {
        "load_case": "a", "model": "micro", "valid": pushed.valid, "peak_reached": pushed.peak_reached,
        "associative": 0.3, "last_rest": False, "non_associative": 0.25, "peak_multiplier": pushed.peak_multiplier,
        "peak_base_shear_N": pushed.peak_base_shear, "displacement_at_peak_m": 0.005, "initial_stiffness_N_per_m": 1e6,
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
    assert said.startswith("No limit state was found; the wall was at rest up to λ = (0.5")
    assert "counts" not in said
    limit = storage.limit_summary(rest)
    assert limit.only_at_rest
    assert not storage.limit_summary(found).only_at_rest
    whole = replace(summary(), limit_analysis=limit)
    assert "micro-LA last rest" in text_of(run_table(whole))
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
    assert whole.rows[0]["remarks"].count(COARSE_TOES) == said
    assert (COARSE_TOES in sentence(whole)) is (said > 0)
    assert COARSE_TOES not in sentence(whole, phrases("it"))
    assert kind_of(whole.rows[0], found) == "peak of a curve"
