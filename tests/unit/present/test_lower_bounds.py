"""A peak that is only a lower bound, or of a curve that is not valid, says so wherever it is printed."""

from __future__ import annotations

from dataclasses import replace

import pytest
from rich.console import Console

from orchestrator import storage
from orchestrator.present.tables import load_cases_table, run_table
from tests.support.pushed import PUSHED
from tests.support.verdicts import summary

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
        "associative": 0.3, "non_associative": 0.25, "peak_multiplier": pushed.peak_multiplier,
        "peak_base_shear_N": pushed.peak_base_shear, "displacement_at_peak_m": 0.005, "initial_stiffness_N_per_m": 1e6,
    }  # fmt: skip
    for table in (run_table(found), load_cases_table("wall", [row])):
        assert ("≥ 0.2968" in text_of(table)) is said
        assert ("NOT VALID" in text_of(table)) is not pushed.valid
    assert any("carries at least" in remark for remark in storage.remarks(found)) is said
    assert any("the peak was not reached" in remark for remark in storage.remarks(found)) is not pushed.peak_reached
