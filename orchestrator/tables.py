"""Tables that the commands print (rich), made from results; cli.py prints them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.markup import escape
from rich.table import Table

from orchestrator.bodies import Bodies
from orchestrator.limit_analysis import LimitAnalysis, LimitState
from orchestrator.macroblocks import Partition
from orchestrator.seismic.record import in_its_unit, notes, numbers, ratio
from orchestrator.sensitivity import value_of_range
from orchestrator.verdict import Verdict


def limit_table(analysis: LimitAnalysis, load_case: str = "") -> Table:
    """Return multiplier, in brackets when not converged, base shear, effort and residuals of every rule."""
    title = f"Micro limit analysis{', ' * bool(load_case)}{escape(load_case)}"
    table = Table(
        box=SIMPLE_HEAD,
        padding=0,
        title=f"{title}, {weight_words(analysis.weight, analysis.horizontal_load)}, {analysis.seconds:.2f} s",
    )
    columns = (
        "",
        "multiplier",
        "base shear\nkN",
        "tilt\ndeg",
        "LPs",
        "time\ns",
        "residuals:\nequilibrium",
        "\nyield",
        "\npower",
    )
    for column in columns:
        table.add_column(column, justify="right" if column else "left", no_wrap=True)
    path, left = analysis.path, analysis.associative_left
    names = {
        "associative, a bound": analysis.associative,
        **({"bound without loose stones": left} if left else {}),
        "met by loading" if path is None or path.converged else "last rest (no state)": path,
        "the paper's value": analysis.sequence,
        "lowest found": analysis.lowest,
    }
    for name, state in names.items():
        table.add_row(name, *(_limit_row(state, analysis) if state else ["none"]))
    return table


def weight_words(weight: float, base_shear: float) -> str:
    """Return the weight of the blocks (N) in words, with the base shear at a load multiplier of 1 where it is another:
    floors whose mass the live load acts on, an inclined live load, given forces."""
    if abs(base_shear - weight) <= 1e-6 * weight:
        return f"weight {weight / 1e3:.3f} kN"
    return f"weight of the blocks {weight / 1e3:.3f} kN, base shear at λ = 1 {base_shear / 1e3:.3f} kN"


def _limit_row(state: LimitState, analysis: LimitAnalysis) -> list[str]:
    seconds = sum(record.seconds for record in state.records)
    residuals = (state.equilibrium_residual, state.yield_residual, state.power_residual)
    shear = state.load_multiplier * analysis.horizontal_load / 1e3
    angle = analysis.tilt_angle(state)
    tilt = "" if angle is None else f"{math.degrees(angle):.3f}"
    multiplier = f"{state.load_multiplier:.5f}" if state.converged else f"({state.load_multiplier:.5f})"
    found = [multiplier, f"{shear:.4f}", tilt, str(len(state.records)), f"{seconds:.2f}"]
    return found + [f"{residual:.0e}" for residual in residuals]


def bodies_table(partition: Partition, bodies: Bodies) -> Table:
    """Return the macroblocks with their blocks and areas."""
    title = f"{partition.count} macroblocks, {len(bodies.joint)} joints between them"
    table = Table(box=SIMPLE_HEAD, padding=0, title=title)
    for column in ("body", "blocks", "area m2"):
        table.add_column(column, justify="right")
    for body in bodies.bodies[: bodies.moving]:
        table.add_row(str(body.number), str(len(body.blocks)), f"{body.area:.4f}")
    return table


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
        figures = (
            ("peak_multiplier", ".4f", 1.0), ("peak_over_micro", ".3f", 1.0),
            ("initial_stiffness_N_per_m", ".2f", 1e-6), ("stiffness_over_micro", ".2f", 1.0),
            ("seconds", ".1f", 1.0), ("seconds_over_micro", ".2f", 1.0),
        )  # fmt: skip
        table.add_row(
            str(row["tol_n"]),
            distance if isinstance(distance, str) else f"{1e3 * distance:g}",
            str(row["bodies"]) + ", NOT VALID" * (row["valid"] is False),
            str(row["joints"]),
            *(format(row[key] * factor, form) if row[key] != "" else "" for key, form, factor in figures),
        )
    return table


def run_table(summary: dict[str, Any]) -> Table:
    """Return the short table at the end of a run."""
    limit = summary["limit_analysis"]
    horizontal_load = limit["base_shear"] / (limit["non_associative"] or limit["associative"])
    title = [f"{summary['case']}: {weight_words(summary['wall']['weight'], horizontal_load)}"]
    kinematics = dict.fromkeys(pushover["displacements"] for pushover in summary["pushover"])
    table = Table(box=SIMPLE_HEAD, padding=0, title=", ".join([*title, *(f"{k} displacements" for k in kinematics)]))
    columns = ("", "bodies", "peak\nmultiplier", "base shear\nkN", "at\nmm", "stiffness\nkN/mm", "time\ns")
    for column in columns:
        table.add_column(column, justify="right" if column else "left", no_wrap=True)
    rows = {"associative": limit["associative"], "non-assoc.": limit["non_associative"]}
    for rule, multiplier in rows.items():
        found = (
            [f"{multiplier:.4f}", f"{multiplier * horizontal_load / 1e3:.4f}"]
            if multiplier is not None
            else ["none found", ""]
        )
        seconds = f"{limit['seconds']:.1f}" if rule == "associative" else ""
        table.add_row(f"micro-LA {rule}", str(summary["wall"]["blocks"]), *found, "", "", seconds)
    for pushover in summary["pushover"]:
        table.add_row(*_pushover_row(pushover))
    return table


def seismic_table(record: dict[str, Any], load_case: str = "") -> Table:
    """Return the seismic verification: one row per check; the numbers behind ratios are those of its notes."""
    title = f"Seismic verification{', ' * bool(load_case)}{escape(load_case)}"
    table = Table(box=SIMPLE_HEAD, padding=0, title=title)
    for column in ("", "limit\nstate", "ag\nm/s2", "demand", "capacity", "ratio\n(e* = 1)", "notes"):
        table.add_column(column, justify="right" if column else "left", no_wrap=True)
    listed = notes(record)
    for row in record["checks"]:
        said = numbers(row, listed)
        if "refused" in row:
            table.add_row(row["approach"], row["limit_state"], "", "not", "verified", "", said)
            continue
        demand, capacity = (in_its_unit(row[key], row["unit"]) for key in ("demand", "capacity"))
        table.add_row(
            row["approach"], row["limit_state"], f"{row['ag_m_per_s2']:.4g}", demand, capacity, ratio(row), said
        )
    return table


def verdict_table(found: Verdict) -> Table:
    """Return all checks of all load cases; the row that governs is marked."""
    table = Table(box=SIMPLE_HEAD, padding=0, title=f"{escape(found.case)}: verdict")
    for column in ("load case", "limit\nstate", "check", "demand", "capacity", "safety\nratio", "verified", ""):
        table.add_column(column, justify="right" if column in ("demand", "capacity", "safety\nratio") else "left")
    for row in found.rows:
        demand = capacity = ratio_said = ""
        if row["safety_ratio"] != "":
            demand, capacity = (in_its_unit(row[key], row["unit"]) for key in ("demand", "capacity"))
            ratio_said = f"{row['safety_ratio']:.3f}"
        elif row["capacity"] != "":
            capacity = f"{1e-3 * row['capacity']:.4g} kN"
        governs = "governs" if row["governs"] else ""
        texts = (escape(row["load_case"]), row["limit_state"], row["check"], demand, capacity, ratio_said)
        table.add_row(*texts, row["verified"], governs)
    return table


def sensitivity_table(name: str, quantity: str, base: float | None, bars: Sequence[dict[str, Any]]) -> Table:
    """Return the tornado: every range with its ends and the capacity at both, the one that matters most on top."""
    given = "no answer" if base is None else f"{base:.4g}"
    table = Table(box=SIMPLE_HEAD, padding=0, title=f"{escape(name)}: {quantity}, as given {given}")
    for column in ("range", "low", "high", "at\nlow", "at\nhigh"):
        table.add_column(column, justify="left" if column == "range" else "right", no_wrap=True)
    for bar in bars:
        ends = [value_of_range(bar["name"], bar[end]) for end in ("low", "high")]
        found = ["no answer" if bar[f"at_{end}"] is None else f"{bar[f'at_{end}']:.4g}" for end in ("low", "high")]
        table.add_row(bar["name"].replace("_", " "), *ends, *found)
    return table


def _pushover_row(pushover: dict[str, Any]) -> list[str]:
    return [
        {"macro": "macroblock FE", "micro": "micro-FE"}[pushover["model"]] + ", NOT VALID" * (not pushover["valid"]),
        str(pushover["bodies"]),
        f"{pushover['peak_multiplier']:.4f}",
        f"{pushover['peak_base_shear'] / 1e3:.4f}",
        f"{1e3 * pushover['displacement_at_peak']:.2f}",
        f"{pushover['initial_stiffness'] / 1e6:.3f}",
        f"{pushover['seconds']['total']:.1f}",
    ]


def load_cases_table(name: str, rows: Sequence[dict[str, Any]]) -> Table:
    """Return the table of several load cases, one row for each curve."""
    table = Table(box=SIMPLE_HEAD, padding=0, title=f"{name}: load cases")
    table.add_column("")
    table.add_column("", no_wrap=True)
    for column in ("micro-LA\nassoc.", "\nnon-as.", "FE peak\nλ", "shear\nkN", "at\nmm", "stiffness\nkN/mm"):
        table.add_column(column, justify="right", no_wrap=True)
    figures = (
        ("associative", ".4f", 1.0), ("non_associative", ".4f", 1.0), ("peak_multiplier", ".4f", 1.0),
        ("peak_base_shear_N", ".4f", 1e-3), ("displacement_at_peak_m", ".2f", 1e3),
        ("initial_stiffness_N_per_m", ".3f", 1e-6),
    )  # fmt: skip
    for row in rows:
        model = f"{row['model']} FE" if row["model"] else "no curve"
        marked = model + ", NOT VALID" * (row["valid"] is False)
        cells = [format(row[key] * factor, form) if row[key] != "" else "" for key, form, factor in figures]
        table.add_row(escape(row["load_case"]), marked, *cells)
    return table
