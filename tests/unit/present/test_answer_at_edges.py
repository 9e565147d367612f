"""What is said of the answer where stones that give way at edges take much of it."""

from __future__ import annotations

from dataclasses import replace

from orchestrator.limit_analysis import analyse
from orchestrator.present.answer import answer_of_limit, answer_of_run
from orchestrator.present.verdict import Answered, verdict
from tests.support.limit_analysis_cases import assemblage_of, box
from tests.support.pushed import PUSHED
from tests.support.verdicts import summary


def test_what_rigid_stones_bear_is_told_from_what_the_wall_bears_where_edges_take_much():
    """By more than 5 %: a basket arch of 3.5 GPa bears 0.0979 in finite elements, as rigid blocks 0.113."""
    rigid = replace(analyse(assemblage_of([box(-3, -1, 6, 1), box(0, 0, 0.5, 1.0)])), rigid_peak=0.5)
    assert answer_of_limit(replace(rigid, pressed_peak=0.47)).startswith("λ = 0.50000 counts for rigid stones (")
    assert answer_of_limit(replace(rigid, pressed_peak=0.48)).startswith("λ = 0.50000 counts (")
    nothing = " About nothing is left in large displacements as stones give way at edges; "
    nothing += "finite elements (`run`) tell whether the wall stands."
    assert answer_of_limit(replace(rigid, pressed_peak=0.0)).endswith(nothing)


def test_beside_a_peak_of_finite_elements_nothing_left_is_called_an_estimate():
    micro = replace(PUSHED, model="micro", bodies=4, valid=True, peak_base_shear=20e3, peak_multiplier=0.2)
    limit = replace(summary().limit_analysis, pressed_peak=0.0, rigid_peak=0.199, large_displacements=0.199)
    found = replace(summary(), pushover=(replace(micro, displacements="large"),), limit_analysis=limit)
    said = answer_of_run(found)
    assert said.endswith("; by an estimate nothing is left where stones give way at edges.")


def test_without_a_valid_curve_limit_analysis_stands_for_rigid_stones_alone():
    limit = replace(summary().limit_analysis, non_associative=0.25, rigid_peak=None, pressed_peak=0.2)
    found = replace(summary(), pushover=(replace(PUSHED, valid=False),), limit_analysis=limit)
    rigid = "rigid stones bear far more than is left as they give way at edges"
    assert answer_of_run(found).endswith(f"; limit analysis alone stands, but {rigid}.")
    row = verdict("wall", [Answered("+x", "+x", "mass", found)]).rows[0]
    assert rigid in row["remarks"]
    assert row["verified"] == "not made"
    nearly = replace(found, limit_analysis=replace(limit, pressed_peak=0.24))
    assert answer_of_run(nearly).endswith("; limit analysis alone stands.")
