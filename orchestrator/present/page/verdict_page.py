"""What the page says of the verdict: its sentence, and its table with values in their units."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from orchestrator import storage
from orchestrator.assessment.seismic.verification_record import in_its_unit
from orchestrator.basis.printed import printed
from orchestrator.present.phrases import in_language, phrases
from orchestrator.present.verdict import COLUMNS, STRENGTH, Answered, Verdict, sentence, verdict
from orchestrator.settings.case import Case
from orchestrator.settings.project import Language


def verdict_contents(verdict: Verdict, language: Language) -> dict[str, Any]:
    """Return what the template of the verdict needs, in a language."""
    least = (
        None
        if verdict.governing is None or verdict.governing["safety_ratio"] == ""
        else verdict.governing["safety_ratio"]
    )
    return {
        "sentence": in_language(sentence(verdict, phrases(language)), language),
        "state": verdict.state,
        "ratio": least,
        "rows": [_row(row, language) for row in verdict.rows],
    }


def verdict_of(case: Case, summary: storage.Summary) -> Verdict:
    """Return the verdict on a run of one load case from its summary."""
    load = case.load
    name = f"{load.direction} {load.distribution.replace('_', ' x ')}"
    about = (name, load.direction, load.distribution, summary)
    return verdict(summary.case, [Answered(*about, inclination=load.inclination)])


def write_verdict(folder: Path, verdict: Verdict) -> Path:
    """Write verdict.csv into a run folder; return its path."""
    path = folder / "verdict.csv"
    rows = (row | {"remarks": "; ".join(row["remarks"])} for row in verdict.rows)
    storage.write_csv(path, COLUMNS, ([row[name] for name in COLUMNS] for row in rows))
    return path


def _row(row: dict[str, Any], language: Language) -> dict[str, Any]:
    shown = {"demand": "", "capacity": "", "ground": "", "ratio": ""}
    if row["limit_state"] == STRENGTH and row["multiplier"] != "":
        shown["capacity"] = multiplier = f"λ = {printed('multiplier', row['multiplier'])}"
        if row["capacity"] != "":
            shown["capacity"] = f"{printed('force', row['capacity'])} kN ({multiplier})"
    elif row["safety_ratio"] != "":
        shown = {
            "demand": in_its_unit(row["demand"], row["unit"]),
            "capacity": in_its_unit(row["capacity"], row["unit"]),
            "ground": " / ".join(printed("acceleration", row[key]) for key in ("capacity_ag_m_per_s2", "ag_m_per_s2")),
            "ratio": printed("ratio", row["safety_ratio"]),
        }
    row = row | {"remarks": "; ".join(map(phrases(language), row["remarks"]))}
    keys = ("load_case", "limit_state", "check", "verified", "governs", "remarks")
    return {key: row[key] for key in keys} | {key: in_language(text, language) for key, text in shown.items()}
