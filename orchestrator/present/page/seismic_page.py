"""What the page of the seismic verification says: inputs, materials, verdict and notes beside the record itself."""

from __future__ import annotations

from functools import partial
from textwrap import shorten
from typing import Any

from orchestrator.assessment.seismic.verification_record import in_its_unit, notes, numbers, verdict
from orchestrator.present.phrases import in_language, phrases
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
        "materials": [(name, said if name == "stones" else local(said)) for name, said in _materials(run)],
        "notes": listed,
        "numbers": partial(numbers, of=listed),
        "in_unit": lambda value, unit: local(in_its_unit(value, unit)),
    }


def _inputs(run: StoredRun, record: dict[str, Any], live_load: str) -> list[tuple[str, str]]:
    settings, spectrum = run.case.seismic, record["spectrum"]
    factors = f"{settings.confidence_factor:g}, {settings.behaviour_factor:g}"
    above = settings.mechanism_height > 0.0
    place = f"z = {settings.mechanism_height:g} m of {settings.building_height:g} m" if above else "on the ground"
    return [
        ("spectrum", f"{SPECTRA[spectrum['kind']]}; ground {spectrum['ground']}"),
        ("damping", f"{settings.damping:.3g} (curves); 0.08 at SLV, 0.10 at SLC (mechanism)"),
        ("FC, q of the mechanism", in_language(factors, run.case.project.language)),
        ("stands", place),
        ("control point", str(record["control_point"])),
        ("live load", f"{run.case.load.direction}, {live_load}"),
    ]


def _materials(run: StoredRun) -> list[tuple[str, str]]:
    wall, elastic = run.assemblage.wall, run.case.elastic
    weights = sorted({block.unit_weight for block in wall.blocks if not block.fixed})
    names = sorted({block.material for block in wall.blocks if block.material})
    floors, carried = len(run.case.load.dead), sum(load.inertia for load in run.case.load.dead)
    return [
        ("unit weight", ", ".join(f"{1e-3 * weight:.4g}" for weight in weights[:4]) + " kN/m³"),
        ("thickness; friction coefficient", f"{wall.thickness:.4g} m; {wall.friction:.4g}"),
        ("elastic modulus; Poisson's ratio", f"{1e-9 * elastic.elastic_modulus:.4g} GPa; {elastic.poisson_ratio:.3g}"),
        ("slip tolerance of joints", f"{1e3 * run.case.contact.slip_tolerance:.3g} mm"),
        ("stones", shorten(", ".join(names) or "one material", 60, placeholder=" …")),
        ("floors", f"{floors} extra dead load{'s' * (floors != 1)}, {carried} with mass"),
    ]
