"""What studies share: how near a headline is to be, figures not computed twice, curves that may stop early, tables."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from time import process_time
from typing import Any

from orchestrator import CollapseError, ConvergenceError, PushoverCurve, SteppingSettings
from orchestrator.pushover.increments import Increment, end_of_curve
from orchestrator.storage import write_json

NEAR, ABOVE = 0.015, 0.03
"""parts of micro-FE's peak: a headline this near counts as right; none may lie further above"""

RESULTS = Path(__file__).parents[2] / "results"
"""where figures are kept; `make clean` removes them, and so must who changes the mechanics"""


def stored(file: Path, compute: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """Return what `file` (JSON) holds, computed and written first if it is not there: a study that stopped goes on."""
    if not file.exists():
        write_json(file, compute())
    return dict(json.loads(file.read_text()))


def followed(
    increments: Iterable[Increment], stepping: SteppingSettings, limit: float = float("inf")
) -> tuple[PushoverCurve, int, float]:
    """Return the curve, its contacts and its CPU seconds; it is left after `limit` s, and may end early by itself.

    stepping: with a final displacement, as no wall is at hand that it could be a share of.

    `stopped_because` of the curve says what ended it.
    """
    began, done, stopped = process_time(), list[Increment](), None
    try:
        for increment in increments:
            done.append(increment)
            if process_time() - began > limit:
                stopped = f"left after {limit:g} s"
                break
    except (CollapseError, ConvergenceError) as error:
        stopped = str(error)
    stopped = stopped or end_of_curve(done[-1], stepping, float("nan")) or ""
    return PushoverCurve.from_increments(done, stopped), len(done[-1].status), process_time() - began


def written_after_each(
    rows: Iterable[dict[str, Any]], columns: Iterable[str], write: Callable[[list[dict[str, Any]]], None]
) -> None:
    """Write all rows that are done anew after each of them, and print its columns."""
    done: list[dict[str, Any]] = []
    for row in rows:
        done.append(row)
        print({name: row[name] for name in columns}, flush=True)
        write(done)


def markdown(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown."""
    return "\n".join(f"| {' | '.join(line)} |" for line in (heads, ["---"] * len(heads), *rows))


def table(rows: Sequence[dict[str, object]]) -> str:
    """Return rows with the columns of the first as a table in Markdown."""
    return markdown(list(rows[0]), [[str(row.get(name, "")) for name in rows[0]] for row in rows])
