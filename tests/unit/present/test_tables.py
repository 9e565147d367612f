"""Tables that commands print."""

from __future__ import annotations

from dataclasses import replace

import pytest

from orchestrator.app.commands import console_of
from orchestrator.assessment.seismic.verification_record import notes, numbers
from orchestrator.basis.printed import printed as printed_figure
from orchestrator.limit_analysis import analyse
from orchestrator.loads import DeadLoad, LoadSettings, loads_on
from orchestrator.present.answer import answer_of_run
from orchestrator.present.page.writing import _environment
from orchestrator.present.tables import in_ranges, limit_table, run_table, seismic_table, verdict_table
from orchestrator.storage.summary import LimitSummary, Summary, WallSummary
from tests.support.limit_analysis_cases import assemblage_of, box
from tests.support.pushed import PUSHED
from tests.support.verdicts import check, of, summary


def printed(analysis):
    console = console_of(width=100)
    with console.capture() as capture:
        console.print(limit_table(analysis))
    return capture.get()


def test_the_table_of_limit_analysis_fits_a_terminal_of_80_columns():
    """Nothing is shortened, with times of minutes and base shears of many digits."""
    analysis = analyse(assemblage_of([box(-3, -1, 6, 1), box(0, 0, 0.5, 1.0)]))
    states = [analysis.associative, analysis.path, analysis.sequence, analysis.lowest]
    record = replace(analysis.headline.records[0], seconds=147.44)
    slow = [state and replace(state, records=(record,) * 81, horizontal_load=1.2e7) for state in states]
    names = ("associative", "path", "sequence", "lowest")
    console = console_of(width=80, record=True)
    heavy = replace(analysis, weight=1e7, **dict(zip(names, slow, strict=True)))
    console.print(limit_table(heavy))
    rocks = replace(heavy.path, flow_rule="large_displacements", converged=False)
    console.print(limit_table(replace(heavy, path=rocks)))
    printed = console.export_text()
    assert "…" not in printed
    assert "associative, a bound" in printed
    (row,) = [line.split() for line in printed.splitlines() if line.startswith(" peak in large")]
    assert len(row) == 8, "in large displacements, its residuals on the wall as drawn say nothing"


@pytest.mark.parametrize("table", ["checks", "verdict"])
def test_the_tables_of_a_verification_fit_a_terminal_of_80_columns(table):
    """Nothing is shortened, no figure parts from its unit, and the notes of a row are in order."""
    remarks = [f"remark {number}" for number in range(12)]
    row = check(31.23) | {"approach": "kinematic, non-linear", "demand": 0.00052381, "capacity": 1234.5e-3, "unit": "m"}
    rows = [
        row | {"remarks": remarks},
        row | {"approach": "drift, macroblock FE", "unit": "drift", "safety_ratio": 123.4, "remarks": remarks[::-2]},
        row | {"unit": "m/s2", "safety_ratio_without_e_star": 31.23, "remarks": remarks[:5]},
    ]
    console = console_of(width=80, record=True)
    if table == "checks":
        console.print(seismic_table({"checks": rows}, "a load case"))
    else:
        console.print(verdict_table(of(**{"a load case of a long name": summary(*rows)})))
    printed = console.export_text()
    assert "…" not in printed
    assert max(map(len, printed.splitlines())) <= 80
    for figure in ("0.5238 mm", "1234 mm", "0.05238 %", "123.4 %", "0.0005238 m/s²", "1.234 m/s²", "31.230", "123.400"):
        assert figure in printed
    assert numbers(rows[1], notes({"checks": rows})) == "2, 4, 6, 8, 10, 12"


def test_numbers_of_blocks_are_told_in_ranges():
    assert [in_ranges(ids) for ids in ([3, 1, 2, 7], [5], [1, 3, 5, 6])] == ["1-3, 7", "5", "1, 3, 5-6"]


def test_multiplier_that_has_not_converged_stands_in_brackets():
    """A block 0.5 m wide and 1 m high overturns at 0.5."""
    found = analyse(assemblage_of([box(-3, -1, 6, 1), box(0, 0, 0.5, 1.0)]))
    assert "(0.5" not in printed(found)
    assert printed(found).count("0.50000") > 1
    astray = replace(found, sequence=replace(found.sequence, converged=False))
    assert printed(astray).count("(0.50000)") == 1


def test_what_lambda_multiplies_is_named_where_it_is_not_the_weight():
    """A block of 10 kN with a floor of 6 kN on it that has inertia: base shears are lambda x 16 kN."""
    assemblage = assemblage_of([box(-3, -1, 6, 1), box(0, 0, 0.5, 1.0)])
    assert "weight 10.000 kN, " in printed(analyse(assemblage))
    floor = LoadSettings(dead=(DeadLoad((1,), force=6e3, inertia=True),))
    said = " ".join(printed(analyse(assemblage, loads=loads_on(assemblage.wall, floor))).split())
    assert "weight of the blocks 10.000 kN, with floors 16.000 kN, " in said


def test_a_figure_of_a_run_has_one_form_in_table_sentence_and_report():
    limit = LimitSummary(0.3478, 0.2963, (0.2963, 0.3011), 4, True, 1e-12, 0.2963 * 22225.0, 1.5)
    summary = Summary("wall", WallSummary(4, 8, *3 * [22225.0]), limit, None, (PUSHED,))
    console = console_of(width=120)
    with console.capture() as capture:
        console.print(run_table(summary))
    row = next(line for line in capture.get().splitlines() if "micro-FE" in line)
    assert row.split() == ["micro-FE", "4", "0.2968", "6.596", "5.876", "39.08", "5.68"]
    assert "6.596 kN counts (λ = 0.2968" in answer_of_run(summary)
    filters = _environment("en").filters
    assert filters["printed"](PUSHED.peak_base_shear, "force") == "6.596"
    assert filters["printed"](PUSHED.displacement_at_peak, "displacement") == "5.876"


def test_a_chimney_that_falls_first_leaves_no_state_above_its_bound():
    """The wall without it carries 0.45, more than the 0.375 at which it falls: 0.5 bounds what is left, 32 kN."""
    limit = LimitSummary(
        0.375, 0.45, (0.45, 0.45), 4, True, 1e-12, 14.4e3, 1.0, associative_left=0.5, base_shear_left=16e3
    )
    console = console_of(width=100)
    with console.capture() as capture:
        console.print(run_table(Summary("a", WallSummary(4, 8, 40e3, 40e3, 40e3), limit, None, ())))
    rows = [line.split() for line in capture.get().splitlines()]
    assert ["without", "loose", "stones", "4", "0.5000", "16.00"] in rows
    assert ["micro-LA", "non-assoc.", "4", "0.4500", "14.40"] in rows


@pytest.mark.parametrize(
    ("figure", "value", "text"),
    [
        ("memory", 273_682_432, "274"),  # an int takes its factor too
        ("force", 133_370.2, "133.4"), ("force", 25_123_456.0, "25123"), ("force", 1234e3, "1234"),
        ("displacement", 2.5e-9, "2.500e-06"), ("multiplier", 0.29634, "0.2963"), ("multiplier", None, "–"),
    ],
)  # fmt: skip
def test_figures_in_their_units(figure, value, text):
    assert printed_figure(figure, value) == text


@pytest.mark.parametrize(
    ("multiplier", "text"), [(0.29637, "0.2964"), (0.0, "0.0000"), (0.00487, "0.004870"), (2e-6, "2.000e-06")]
)
def test_multipliers_have_four_digits_whatever_the_unit_of_a_load(multiplier, text):
    assert printed_figure("multiplier", multiplier) == text
