"""Tables that commands print."""

from __future__ import annotations

from dataclasses import replace

from rich.console import Console

from orchestrator.limit_analysis import analyse
from orchestrator.tables import limit_table
from tests.verification.limit_analysis_cases import assemblage_of, box


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
    astray = replace(found, sequence=replace(found.sequence, converged=False))
    assert printed(astray).count("(0.50000)") == 1
