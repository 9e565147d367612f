"""Tables that commands print."""

from __future__ import annotations

from dataclasses import replace

from rich.console import Console

from orchestrator.limit_analysis import DeadLoad, LoadSettings, analyse, loads_on
from orchestrator.tables import limit_table
from tests.support.limit_analysis_cases import assemblage_of, box


def printed(analysis):
    console = Console(width=100)
    with console.capture() as capture:
        console.print(limit_table(analysis))
    return capture.get()


def test_multiplier_that_has_not_converged_stands_in_brackets():
    """A block 0.5 m wide and 1 m high overturns at 0.5."""
    found = analyse(assemblage_of([box(-3, -1, 6, 1), box(0, 0, 0.5, 1.0)]))
    assert "(0.5" not in printed(found)
    assert printed(found).count("0.50000") > 1
    astray = replace(found, dilation_shift=replace(found.dilation_shift, converged=False))
    assert printed(astray).count("(0.50000)") == 1


def test_what_lambda_multiplies_is_named_where_it_is_not_the_weight():
    """A block of 10 kN with a floor of 6 kN on it that has inertia: base shears are lambda x 16 kN."""
    assemblage = assemblage_of([box(-3, -1, 6, 1), box(0, 0, 0.5, 1.0)])
    assert "weight 10.000 kN, " in printed(analyse(assemblage))
    floor = LoadSettings(dead=(DeadLoad((1,), force=6e3, inertia=True),))
    said = " ".join(printed(analyse(assemblage, loads=loads_on(assemblage.wall, floor))).split())
    assert "weight of the blocks 10.000 kN, base shear at λ = 1 16.000 kN, " in said
