"""Tables that the commands print (rich), made from results; cli.py prints them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.table import Table

from orchestrator.assessment.seismic.verification_record import in_its_unit, notes, numbers, ratio
from orchestrator.assessment.sensitivity import value_of_range
from orchestrator.basis.printed import Figure, counted, marked, printed
from orchestrator.limit_analysis import LimitAnalysis, LimitState
from orchestrator.macroblocks.bodies import Bodies
from orchestrator.macroblocks.criteria import Partition
from orchestrator.masonry.wall import Wall
from orchestrator.present.verdict import Verdict
from orchestrator.present.weights import weight_words
from orchestrator.storage import PushoverSummary, Summary
from orchestrator.storage.summary import IN_BRACKETS

STUDIED: dict[str, Figure] = {
    "peak_multiplier": "multiplier", "peak_over_micro": "ratio",
    "initial_stiffness_N_per_m": "stiffness", "stiffness_over_micro": "ratio",
    "seconds": "seconds", "seconds_over_micro": "ratio",
}  # fmt: skip
"""figures of a row of a study's table"""
AT_LEAST = "≥ "
"""before the peak of a valid curve that ends before its peak"""


def limit_table(analysis: LimitAnalysis, load_case: str = "") -> Table:
    """Return multiplier, in brackets when not converged, base shear, effort and residuals of every rule.

    In place of the base shear stands a live load that has none: an upright one.
    """
    title = f"Micro limit analysis{', ' * bool(load_case)}{load_case}"
    table = Table(
        box=SIMPLE_HEAD,
        padding=0,
        title=f"{title}, {weight_words(analysis)}, {analysis.seconds:.2f} s",
    )
    load = "shear\nkN" if analysis.upright_load is None else "load\nkN"
    columns = ("", "multiplier", load, "tilt\ndeg", "LPs", "time\ns", "residual\nbalance", "\nyield", "\npower")
    for column in columns:
        table.add_column(column, justify="right" if column else "left", no_wrap=bool(column))
    path, left = analysis.path, analysis.associative_left
    names = {
        "associative, a bound" if analysis.is_bound else "associative": analysis.associative,
        **({"without loose stones": left} if left else {}),
        "met by loading" if path is None or path.flow_rule == "path" else path.name: path,
        "the paper's value": analysis.sequence,
        "lowest found": analysis.lowest,
    }
    for name, state in names.items():
        table.add_row(name, *(_limit_row(state, analysis) if state else ["none"]))
    return table


def _limit_row(state: LimitState, analysis: LimitAnalysis) -> list[str]:
    seconds = sum(record.seconds for record in state.records)
    residuals = [f"{one:.0e}" for one in (state.equilibrium_residual, state.yield_residual, state.power_residual)]
    if state.flow_rule == "large_displacements":  # it balances where the stones have moved to, not as drawn
        residuals = [""] * len(residuals)
    upright = analysis.upright_load
    load = printed("force", state.base_shear if upright is None else state.load_multiplier * abs(upright))
    angle = analysis.tilt_angle(state)
    tilt = "" if angle is None else f"{math.degrees(angle):.2f}"
    multiplier = marked("limit multiplier", state.load_multiplier, state.converged)
    effort = [str(len(state.records)), f"{seconds:.2f}", *residuals]
    return [multiplier, load, tilt, *effort]


def bodies_table(wall: Wall, partition: Partition, bodies: Bodies) -> Table:
    """Return the macroblocks with the ids of their blocks, and their areas."""
    title = f"{counted(partition.count, 'macroblock')}, {counted(len(bodies.joint), 'joint')} between them"
    table = Table(box=SIMPLE_HEAD, padding=0, title=title)
    for column in ("body", "blocks", "area m2"):
        table.add_column(column, justify="right")
    table.add_column("ids")
    for body in bodies.bodies[: bodies.moving]:
        ids = in_ranges([wall.blocks[block].id for block in body.blocks])
        table.add_row(str(body.number), str(len(body.blocks)), f"{body.area:.4f}", ids)
    return table


def in_ranges(ids: Sequence[int]) -> str:
    """Return whole numbers in words, neighbours as a range: 1-4, 7."""
    ordered = np.sort(ids)
    runs = np.split(ordered, np.flatnonzero(np.diff(ordered) > 1) + 1)
    return ", ".join(f"{run[0]}-{run[-1]}" if len(run) > 1 else str(run[0]) for run in runs)


def study_table(name: str, rows: Sequence[dict[str, Any]]) -> Table:
    """Return the table of a study; the last row is micro-FE, to which ratios refer."""
    table = Table(box=SIMPLE_HEAD, padding=0, title=f"{name}: peak, stiffness and time as parts of micro-FE's")
    columns = (
        "tol_n", "tol_D\nmm", "bodies", "joints", "peak\nmultiplier", "of\nmicro", "stiffness\nkN/mm", "of\nmicro",
        "time\ns", "of\nmicro",
    )  # fmt: skip
    for column in columns:
        table.add_column(column, justify="right", no_wrap=True)
    for row in rows:
        distance = row["tol_D_m"]
        table.add_row(
            str(row["tol_n"]),
            distance if isinstance(distance, str) else f"{1e3 * distance:g}",
            str(row["bodies"]) + ", NOT VALID" * (row["valid"] is False),
            str(row["joints"]),
            *(printed(figure, row[key]) if row[key] != "" else "" for key, figure in STUDIED.items()),
        )
    return table


def run_table(summary: Summary) -> Table:
    """Return the short table at the end of a run."""
    limit = summary.limit_analysis
    title = [f"{summary.case}: {weight_words(summary.wall)}"]
    kinematics = dict.fromkeys(pushed.displacements for pushed in summary.pushover)
    table = Table(box=SIMPLE_HEAD, padding=0, title=", ".join([*title, *(f"{k} displacements" for k in kinematics)]))
    columns = ("", "bodies", "peak\nmultiplier", "base shear\nkN", "at\nmm", "stiffness\nkN/mm", "time\ns")
    for column in columns:
        table.add_column(column, justify="right" if column else "left", no_wrap=True)
    rows: dict[str, tuple[float | None, float | None]] = {
        "micro-LA associative": (limit.associative, limit.associative * summary.wall.horizontal_load)
    }
    if limit.associative_left is not None:
        rows["  without loose stones"] = limit.associative_left, limit.base_shear_left
    others = {"last load at rest": "last at rest", "peak in large displacements": "large displ."}
    rows[f"micro-LA {others.get(limit.kind, 'non-assoc.')}"] = limit.non_associative, limit.base_shear
    for name, (multiplier, shear) in rows.items():
        cells = ["none found", ""]
        if multiplier is not None and shear is not None:
            closed = multiplier != limit.non_associative or not limit.in_brackets
            cells = [marked("multiplier", multiplier, closed), marked("force", shear, closed)]
        seconds = printed("seconds", limit.seconds) if name == "micro-LA associative" else ""
        table.add_row(name, str(summary.wall.blocks), *cells, "", "", seconds)
    for pushed in summary.pushover:
        table.add_row(*_pushover_row(pushed))
    return table


def seismic_table(record: dict[str, Any], load_case: str = "") -> Table:
    """Return the seismic verification: one row per check; the numbers behind ratios are those of its notes."""
    title = f"Seismic verification{', ' * bool(load_case)}{load_case}"
    table = Table(box=SIMPLE_HEAD, padding=0, title=title)
    for column in ("", "limit\nstate", "ag\nm/s2", "demand", "capacity", "ratio\n(e* = 1)", "notes"):
        wraps = column in ("", "notes")  # words, and lists of numbers; no figure is cut, and none loses its unit
        table.add_column(column, justify="right" if column else "left", no_wrap=not wraps, overflow="fold")
    listed = notes(record)
    for row in record["checks"]:
        said = numbers(row, listed)
        if "refused" in row:
            table.add_row(row["approach"], row["limit_state"], "", "not", "verified", "", said)
            continue
        demand, capacity = (in_its_unit(row[key], row["unit"]) for key in ("demand", "capacity"))
        table.add_row(
            row["approach"], row["limit_state"], printed("acceleration", row["ag_m_per_s2"]), demand, capacity,
            ratio(row), said,
        )  # fmt: skip
    return table


def verdict_table(verdict: Verdict) -> Table:
    """Return all checks of all load cases; the row that governs is marked."""
    table = Table(box=SIMPLE_HEAD, padding=0, title=f"{verdict.case}: verdict")
    for column in ("load case", "limit\nstate", "check", "demand", "capacity", "safety\nratio", "verified", ""):
        figures = column in ("demand", "capacity", "safety\nratio")
        table.add_column(column, justify="right" if figures else "left", no_wrap=figures, overflow="fold")
    for row in verdict.rows:
        demand = capacity = ratio_said = ""
        if row["safety_ratio"] != "":
            demand, capacity = (in_its_unit(row[key], row["unit"]) for key in ("demand", "capacity"))
            ratio_said = printed("ratio", row["safety_ratio"])
        elif row["capacity"] != "":
            capacity = f"{printed('force', row['capacity'])} kN"
        elif row["multiplier"] != "":
            capacity = f"λ = {printed('multiplier', row['multiplier'])}"
        governs = "governs" if row["governs"] else ""
        texts = (row["load_case"], row["limit_state"], row["check"], demand, capacity, ratio_said)
        table.add_row(*texts, row["verified"], governs)
    return table


def sensitivity_table(name: str, quantity: str, base: float | None, kind: str, bars: Sequence[dict[str, Any]]) -> Table:
    """Return the tornado: every range with its ends and the capacity at both, the one that matters most on top. kind:
    which kind of answer is compared."""
    as_given = "no answer" if base is None else f"{base:.4g} ({kind})"
    table = Table(box=SIMPLE_HEAD, padding=0, title=f"{name}: {quantity}, as given {as_given}")
    for column in ("range", "low", "high", "at\nlow", "at\nhigh"):
        table.add_column(column, justify="left" if column == "range" else "right", no_wrap=True)
    for bar in bars:
        ends = [value_of_range(bar["name"], bar[end]) for end in ("low", "high")]
        table.add_row(bar["name"].replace("_", " "), *ends, *(_end_of(bar, end) for end in ("low", "high")))
    return table


def _end_of(bar: dict[str, Any], end: str) -> str:
    if bar[f"found_{end}"] is None:
        return "no answer"
    return "other kind" if bar[f"at_{end}"] is None else f"{bar[f'at_{end}']:.4g}"


def _pushover_row(pushed: PushoverSummary) -> list[str]:
    peak = (printed("multiplier", pushed.peak_multiplier), printed("force", pushed.peak_base_shear))
    return [
        {"macro": "macroblock FE", "micro": "micro-FE"}[pushed.model] + ", NOT VALID" * (not pushed.valid),
        str(pushed.bodies),
        *(AT_LEAST * (pushed.valid and not pushed.peak_reached) + said for said in peak),
        printed("displacement", pushed.displacement_at_peak),
        printed("stiffness", pushed.initial_stiffness),
        printed("seconds", pushed.seconds["total"]),
    ]


def load_cases_table(name: str, rows: Sequence[dict[str, Any]]) -> Table:
    """Return the table of several load cases, one row for each curve."""
    table = Table(box=SIMPLE_HEAD, padding=0, title=f"{name}: load cases")
    table.add_column("")
    table.add_column("", no_wrap=True)
    for column in ("micro-LA\nassoc.", "\nnon-as.", "FE peak\nλ", "shear\nkN", "at\nmm", "stiffness\nkN/mm"):
        table.add_column(column, justify="right", no_wrap=True)
    figures: dict[str, Figure] = {
        "associative": "multiplier", "non_associative": "multiplier", "peak_multiplier": "multiplier",
        "peak_base_shear_N": "force", "displacement_at_peak_m": "displacement",
        "initial_stiffness_N_per_m": "stiffness",
    }  # fmt: skip
    for row in rows:
        model = f"{row['model']} FE" if row["model"] else "no curve"
        named = model + ", NOT VALID" * (row["valid"] is False)
        cells = {key: printed(figure, row[key]) if row[key] != "" else "" for key, figure in figures.items()}
        if row["valid"] is True and row["peak_reached"] is False:
            cells |= {key: AT_LEAST + cells[key] for key in ("peak_multiplier", "peak_base_shear_N")}
        if row["kind"] in IN_BRACKETS:
            cells["non_associative"] = f"({cells['non_associative']})"
        table.add_row(row["load_case"], named, *cells.values())
    return table
