"""What the page says: plain values for the template, made from a stored run."""

from __future__ import annotations

import base64
import math
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from orchestrator import storage
from orchestrator.assessment.capacity import Bilinear, idealise
from orchestrator.basis.errors import ResultError
from orchestrator.basis.units import FACTORS, QUANTITY, quantity
from orchestrator.loads import LoadSettings
from orchestrator.masonry.block_properties import block_areas, block_weights
from orchestrator.masonry.joints import is_bed
from orchestrator.present.page.collapse import collapse
from orchestrator.present.page.damage import Damage, damage_sequence
from orchestrator.present.page.practice import practice_contents
from orchestrator.present.page.seismic_page import LABELS, seismic_contents
from orchestrator.present.page.tie_forces import tie_rows
from orchestrator.present.page.verdict_page import verdict_contents, verdict_of
from orchestrator.present.phrases import phrases
from orchestrator.present.tie_states import ShownTies, shown_ties
from orchestrator.present.weights import carried_words, multiplier_words
from orchestrator.pushover.increments import PushoverCurve
from orchestrator.pushover.path import curve_checks
from orchestrator.pushover.solids.elastic_constants import slip_tolerance_of
from orchestrator.storage.stored_run import StoredModel, StoredRun

ROOM = 3_000_000
"""bytes for the collapse of all models; the page stays under 5 MB"""
LARGEST_DRAWING = 250_000
"""bytes; a larger SVG is replaced by its PNG"""
DAMAGE_LIMIT = 10.0
"""opening or slip that counts as damage, in slip tolerances of the contact law"""
SHOWN_DAMAGE = 25
"""rows of the damage table before the rest, which is folded away"""
FILES = (
    "case.toml", "blocks.json", "joints.csv", "limit_analysis.json", "macroblocks.json", "summary.json",
    "macro/curve.csv", "macro/states.h5", "micro/curve.csv", "micro/states.h5",
)  # fmt: skip
"""whose hashes the page states"""


def bilinear_of(curve: PushoverCurve) -> Bilinear | str:
    """Return the bilinear idealisation, or why a curve has none: it ends on its elastic branch, or goes against the
    load."""
    try:
        return idealise(curve.static.base_shear_N, curve.static.control_displacement_m)
    except ResultError as error:
        return error.detail


def contents(run: StoredRun) -> dict[str, Any]:
    """Return everything the template needs."""
    wall, models = run.assemblage.wall, run.models
    settings = tomllib.loads((run.folder / "case.toml").read_text(encoding="utf-8"))
    pushed = storage.remarks(run.summary)
    remarks = [*run.analysis.remarks, *run.partition.remarks, *pushed]
    return {
        "summary": run.summary,
        "verdict": verdict_contents(verdict_of(run.case, run.summary), run.case.project.language),
        "practice": practice_contents(run),
        "project": run.case.project,
        "language": run.case.project.language,
        "seismic": seismic_contents(run, in_words(run.case.load)),
        "title": wall.name or run.summary.case,
        "settings": list(_settings(settings)),
        "wall": _wall(run),
        "load": {
            "direction": run.case.load.direction,
            "words": in_words(run.case.load),
            "weights": multiplier_words(run.summary.wall),
        },
        "carried": carried_words(run.summary.wall),
        "limit_states": list(_limit_states(run)),
        "headline": run.analysis.headline.name,
        "bodies": _bodies(run),
        "tolerances": run.partition.tolerances,
        "pictures": {path.stem: picture(path) for path in sorted((run.folder / "figures").glob("*.png"))},
        "models": [_model(run, model) for model in models],
        "complaints": [(LABELS[m.name], m.summary.complaint) for m in models if m.summary.complaint],
        "failed": [(LABELS[name], why) for name, why in (run.summary.failed or {}).items()],
        "remarks": remarks,
        "failed_checks": sum(not check["passed"] for model in models for check in _checks(model.summary)),
        "versions": dict(_provenance(run.folder)),
        "hashes": {name: storage.hash_file(run.folder / name) for name in FILES if (run.folder / name).exists()},
        "collapse": _collapse(run),
    }


def _wall(run: StoredRun) -> dict[str, Any]:
    """Return the sums of a wall; lengths in m, without its supports."""
    wall = run.assemblage.wall
    points = np.vstack([block.polygon for block in wall.blocks if not block.fixed])
    free = np.array([not block.fixed for block in wall.blocks])
    return {
        "width": float(np.ptp(points[:, 0])),
        "height": float(np.ptp(points[:, 1])),
        "thickness": wall.thickness,
        "area": float(block_areas(wall)[free].sum()),
        "supports": int((~free).sum()),
    }


def _collapse(run: StoredRun) -> dict[str, Any]:
    """Return what the collapse under the slider is drawn from."""
    say = phrases(run.case.project.language)
    return {
        "models": [
            {"name": say(LABELS[m.name])}
            | collapse(m.store, m.bodies, m.meshes, m.contacts, m.curve, ROOM // len(run.models), _ties(run, m))
            for m in run.models
        ],
        "curves": [_points(model) for model in run.models],
        "limit": _limit_lines(run),
    }


def _limit_lines(run: StoredRun) -> dict[str, float]:
    """Return the base shears of limit analysis, N: the associative bound, and the headline where it is another."""
    limit = run.summary.limit_analysis
    bound = {"associative": run.analysis.bound.base_shear}
    return bound if limit.non_associative is None else bound | {"headline": limit.base_shear}


def _ties(run: StoredRun, model: StoredModel) -> ShownTies | None:
    return shown_ties(run.assemblage.wall, model.bodies, model.meshes, run.case.reinforcement.ties)


def in_words(load: LoadSettings) -> str:
    """Return what the live load is like."""
    shape = {
        "mass": "proportional to mass",
        "mass_height": "proportional to mass × height above the base",
        "per_block": "given block by block",
    }[load.distribution]
    return shape + (f", {math.degrees(load.inclination):g}° above the horizontal" if load.inclination else "")


def _settings(record: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, str]]:
    """Yield every setting as (section.key, value with its unit)."""
    for key, value in record.items():
        entries = value if isinstance(value, list) else [value]
        if isinstance(value, dict):
            yield from _settings(value, f"{prefix}{key}.")
        elif any(isinstance(entry, dict) for entry in entries):
            for number, entry in enumerate(entries, start=1):
                yield from _settings(entry, f"{prefix}{key}.{number}.")
        else:
            yield f"{prefix}{key}", ", ".join(map(_as_set, entries)) or "none"


def _as_set(value: Any) -> str:
    """Return a value as one would write it into a case file: 3.5 GPa for 3500000000.0 Pa, true, none for inf."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float) and math.isinf(value):
        return "none"
    if isinstance(value, float):
        return f"{value:.10g}"
    measured = QUANTITY.fullmatch(str(value))
    return quantity(float(measured[1]), measured[2]) if measured and measured[2] in FACTORS else str(value)


def _limit_states(run: StoredRun) -> Iterator[dict[str, Any]]:
    names = {
        "associative": "associative (upper bound)" if run.analysis.is_bound else "associative",
        "associative_left": "associative, without loose stones",
        "path": run.analysis.headline.name,
        "sequence": "non-associative, the paper's value",
        "lowest": "lowest state found",
    }
    for key, name in names.items():
        if (state := getattr(run.analysis, key)) is not None:
            yield {
                "name": name,
                "multiplier": state.load_multiplier,
                "base_shear": state.base_shear,
                "programs": len(state.records),
                "equilibrium": state.equilibrium_residual,
                "yield_residual": state.yield_residual,
                "power": state.power_residual,
                "headline": state is run.analysis.headline,
                "closed": state.converged,
            }


def _bodies(run: StoredRun) -> list[dict[str, Any]]:
    areas, wall = block_areas(run.assemblage.wall), run.assemblage.wall
    weights = block_weights(wall)
    members = [np.flatnonzero(run.partition.body_of_block == number) for number in range(run.partition.count)]
    return [
        {
            "number": number,
            "blocks": [wall.blocks[block].id for block in blocks],
            "area": float(areas[blocks].sum()),
            "weight": float(weights[blocks].sum()),
        }
        for number, blocks in enumerate(members)
    ]


def _model(run: StoredRun, model: StoredModel) -> dict[str, Any]:
    limit = DAMAGE_LIMIT * slip_tolerance_of(model.bodies, run.case.elastic, run.case.contact)
    sequence = damage_sequence(model.store.these(model.curve.step.tolist()), model.contacts, limit)
    rows = [_damage(run, model, damage) for damage in sequence]
    return {
        "key": model.name,
        "label": LABELS[model.name],
        "summary": model.summary,
        "bilinear": bilinear_of(model.curve),
        "checks": _checks(model.summary),
        "damage": rows[:SHOWN_DAMAGE],
        "more_damage": rows[SHOWN_DAMAGE:],
        "damage_limit": limit,
        "interfaces": len(model.bodies.joint),
        "ties": tie_rows(model, run.case.reinforcement.ties),
        "bonded": bool(model.bodies.interfaces.cohesion.any()),
    }


def _damage(run: StoredRun, model: StoredModel, damage: Damage) -> dict[str, Any]:
    """Return a row of the table; the joint is named by the ids of its blocks and the position of its middle."""
    joint, wall = int(model.bodies.joint[damage.interface]), run.assemblage.wall
    ends = run.assemblage.joints.start[joint], run.assemblage.joints.end[joint]
    ids = [wall.blocks[int(side[joint])].id for side in (run.assemblage.joints.i, run.assemblage.joints.j)]
    return {
        "damage": damage,
        "joint": joint,
        "blocks": sorted(ids),
        "position": 0.5 * (ends[0] + ends[1]),
        "type": "bed" if is_bed(run.assemblage.joints)[joint] else "head",
    }


def _checks(summary: storage.PushoverSummary) -> list[dict[str, Any]]:
    """Return what `pushover.checks` asks of a curve, with the figures of the summary."""
    asked = (
        (
            "equilibrium",
            "equilibrium_residual",
            curve_checks.EQUILIBRIUM,
            "largest |λ H − V| / peak, H: horizontal live load",
        ),
        (
            "penetration",
            "max_penetration_over_size",
            curve_checks.OVERLAP,
            "largest overlap of two bodies / smaller size",
        ),
        (
            "touch",
            "max_pressed_gap_over_size",
            curve_checks.APART,
            "largest gap between two bodies that press each other / smaller size",
        ),
        ("energy balance", "energy_error", curve_checks.ENERGY, "largest imbalance of work and energies"),
    )
    return [
        {
            "name": name,
            "meaning": meaning,
            "key": key,
            "value": value,
            "bound": bound,
            "passed": value is not None and value <= bound,
        }
        for name, key, bound, meaning in asked
        for value in [getattr(summary, key)]
    ]


def _points(model: StoredModel) -> dict[str, Any]:
    """Return the curve for the page: displacement in mm, base shear in kN; and from where to where the wall went at
    rest, mm.

    The control point may belong to a stone that falls: what it does then does not say how wide the chart is.
    """
    curve, bilinear = model.curve, bilinear_of(model.curve)
    moved, still = (
        1e3 * (one.control_displacement_m - curve.control_displacement_m[0]) for one in (curve, curve.static)
    )
    corners: list[list[float]] = []
    if isinstance(bilinear, Bilinear):
        force = bilinear.yield_force / 1e3
        yields, ends = 1e3 * bilinear.yield_displacement, 1e3 * bilinear.ultimate_displacement
        corners = [[0.0, 0.0], [yields, force], [ends, force]]
    shear = np.round(curve.base_shear_N / 1e3, 6)
    return {"x": np.round(moved, 6), "y": shear, "at_rest": [still.min(), still.max()], "bilinear": corners}


def picture(png: Path) -> str:
    """Return a picture as data URL: the drawing, or the raster where the drawing is too large."""
    svg = png.with_suffix(".svg")
    if svg.exists() and svg.stat().st_size <= LARGEST_DRAWING:
        return "data:image/svg+xml;base64," + base64.b64encode(svg.read_bytes()).decode()
    return "data:image/png;base64," + base64.b64encode(png.read_bytes()).decode()


def _provenance(folder: Path) -> Iterator[tuple[str, str]]:
    """Yield the versions and hashes that stand in the comments at the end of case.toml."""
    _, _, tail = (folder / "case.toml").read_text(encoding="utf-8").partition("\n# As run, with:\n")
    for line in tail.splitlines():
        if line.startswith("# "):
            name, _, value = line[2:].rpartition(" ")
            yield name.removesuffix(":"), value
