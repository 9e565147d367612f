"""What the page of the seismic verification says: inputs, materials, verdict and notes beside the record itself."""

from __future__ import annotations

from functools import partial
from typing import Any

from orchestrator.assessment.seismic.kinematic import DAMPING
from orchestrator.assessment.seismic.settings import LIKE, known_states
from orchestrator.assessment.seismic.verification_record import in_its_unit, notes, numbers, verdict
from orchestrator.macroblocks.bodies import make_bodies
from orchestrator.macroblocks.criteria import one_body_per_block
from orchestrator.present.phrases import in_language, phrases
from orchestrator.pushover.solids.elastic_constants import slip_tolerance_of
from orchestrator.storage.stored_run import StoredRun

LABELS = {"macro": "Macroblock FE", "micro": "Micro-FE"}
SPECTRA = {
    "ec8_type1": "EN 1998-1 3.2.2.2, type 1", "ec8_type2": "EN 1998-1 3.2.2.2, type 2",
    "ntc2018": "NTC 2018 3.2.3.2.1", "parameters": "EN 1998-1 3.2.2.2, S and periods as given",
}  # fmt: skip


def seismic_contents(run: StoredRun, live_load: str) -> dict[str, Any] | None:
    """Return what the template of the verification needs, None for a run without one."""
    record = run.summary.seismic
    if record is None:
        return None
    rows = [row for row in record["checks"] if "refused" not in row]
    failed, refused = sum(row["safety_ratio"] < 1.0 for row in rows), len(record["checks"]) - len(rows)
    listed, say = notes(record), phrases(run.case.project.language)
    stones = make_bodies(run.assemblage, one_body_per_block(run.assemblage))
    local = partial(in_language, language=run.case.project.language)
    return {
        "record": record,
        "labels": LABELS,
        "failed": failed,
        "refused": refused,
        "verdict": "; ".join(map(say, verdict(record).split("; "))),
        "inputs": [
            (name, local(said) if "FC" in name else said) for name, said in _inputs(run, record, say(live_load))
        ],
        "slip_tolerance": slip_tolerance_of(stones, run.case.elastic, run.case.contact),
        "notes": listed,
        "numbers": partial(numbers, of=listed),
        "in_unit": lambda value, unit: local(in_its_unit(value, unit)),
    }


def spectrum_words(record: dict[str, Any]) -> str:
    """Return the spectrum and the ground of a verification."""
    spectrum = record["spectrum"]
    return f"{SPECTRA[spectrum['kind']]}; ground {spectrum['ground']}"


def _inputs(run: StoredRun, record: dict[str, Any], live_load: str) -> list[tuple[str, str]]:
    settings = run.case.seismic
    factors = f"{settings.confidence_factor:g}, {settings.behaviour_factor:g}"
    above = settings.mechanism_height > 0.0
    known = known_states(settings.spectrum)
    place = "on the ground"
    if above:
        place = f"z = {settings.mechanism_height:g} m of {settings.building_height:g} m, "
        place += f"T1 = {settings.building_period:g} s, n = {settings.storeys}, ξ1 = {settings.building_damping:g}"
    of_mechanism = ", ".join(
        f"{damping:.2f} at {'/'.join(state for state in known if LIKE.get(state, state) == like)}"
        for like, damping in DAMPING.items()
    )
    return [
        ("spectrum", spectrum_words(record)),
        ("damping", f"{settings.damping:.3g} (curves); {of_mechanism} (mechanism)"),
        ("FC, q of the mechanism", in_language(factors, run.case.project.language)),
        ("stands", place),
        ("control point", str(record["control_point"])),
        ("live load", f"{run.case.load.direction}, {live_load}"),
    ]
