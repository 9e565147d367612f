"""summary.json: the figures that scripts outside this repository read; the keys stay. All SI."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from orchestrator.capacity import Capacity
from orchestrator.joints import Assemblage
from orchestrator.limit_analysis.state import LimitAnalysis
from orchestrator.macroblocks import Partition
from orchestrator.meshing import BodyMeshes
from orchestrator.pushover.state import Increment

TIMINGS = ("mesh", "assembly", "factorise", "contact", "total")
"""what `seconds` of a pushover holds, in s"""


@dataclass(frozen=True, slots=True)
class Effort:
    """What a pushover cost and how far its contacts overlap (m): folded from all its increments, gravity included.

    newton_iterations counts those of failed attempts too. energy_error: the largest imbalance of work and energies
    (record.py), over stored energy plus friction at the end.
    """

    steps: int
    newton_iterations: int
    failed_attempts: int
    max_penetration: float
    energy_error: float


def effort_of(increments: Iterable[Increment]) -> Effort:
    """Fold increments, one at a time, into their effort."""
    steps = iterations = failed = 0
    penetration = imbalance = turned_over = 0.0
    for increment in increments:
        steps += 1
        iterations += increment.iterations + sum(attempt.iterations for attempt in increment.attempts)
        failed += len(increment.attempts)
        penetration = max(penetration, float(np.nanmax(-increment.gap, initial=0.0)))
        turned_over = increment.internal_energy + increment.dissipated_energy
        spent = turned_over + increment.kinetic_energy + increment.algorithmic_dissipation
        imbalance = float(np.maximum(imbalance, abs(increment.external_work - spent)))  # max() would lose a nan
    return Effort(steps, iterations, failed, penetration, imbalance / turned_over if turned_over else 0.0)


def pushover_summary(
    model: Literal["macro", "micro"],
    meshes: BodyMeshes,
    contacts: int,
    effort: Effort,
    capacity: Capacity,
    stopped_because: str,
    *,
    large_displacement: bool,
    ranks: int,
    seconds: Mapping[str, float],
    peak_memory: int,
    complaint: str | None,
    not_valid_because: str | None,
) -> dict[str, Any]:
    """Return one entry of `pushover`. seconds: exactly the keys of TIMINGS; peak_memory in bytes.

    complaint: why the curve ended early or is not valid; None for a good one. not_valid_because: the checks of the
    result that failed (pushover.checks), in words; None: it is valid.
    """
    assert set(seconds) == set(TIMINGS), f"timings {sorted(seconds)}, not {sorted(TIMINGS)}"
    counted = asdict(effort)
    counted.pop("failed_attempts")
    return {
        "model": model,
        "bodies": len(meshes.unit_weight),
        "nodes": len(meshes.nodes),
        "tetrahedra": len(meshes.tetrahedra),
        "contacts": contacts,
        "displacements": "large" if large_displacement else "small",
        "ranks": ranks,
        **counted,
        **asdict(capacity),
        "seconds": {name: float(seconds[name]) for name in TIMINGS},
        "peak_memory": int(peak_memory),
        "stopped_because": stopped_because,
        "complaint": complaint,
        "valid": not_valid_because is None,
        "not_valid_because": not_valid_because,
    }


def reasons(pushovers: Sequence[dict[str, Any]]) -> list[str]:
    """Return why entries of `pushover` are not valid."""
    return [f"{entry['model']} FE: {entry['not_valid_because']}" for entry in pushovers if not entry["valid"]]


def summary(
    case: str,
    assemblage: Assemblage,
    analysis: LimitAnalysis,
    partition: Partition | None,
    pushovers: Sequence[dict[str, Any]],
) -> dict[str, Any]:
    """Return the whole record. `macroblocks` is null where the run stopped before them, `pushover` may be empty.

    Non-associative values are null where no such solution was found; infinite tolerances are null.
    """
    return {
        "case": case,
        "wall": {
            "blocks": sum(not block.fixed for block in assemblage.wall.blocks),
            "joints": len(assemblage.block_i),
            "weight": analysis.weight,
        },
        "limit_analysis": _limit_analysis(analysis),
        "macroblocks": partition and _macroblocks(partition, len(assemblage.block_i)),
        "pushover": list(pushovers),
    }


def _limit_analysis(analysis: LimitAnalysis) -> dict[str, Any]:
    headline = analysis.headline
    found = analysis.non_associative_range
    return {
        "associative": analysis.associative.load_multiplier,
        "non_associative": headline.load_multiplier if found else None,
        "non_associative_range": list(found) if found else None,
        "path": analysis.path and analysis.path.load_multiplier,
        "last_rest": analysis.last_rest,
        "soft_from": analysis.soft_from,
        "interval": analysis.interval and list(analysis.interval),
        "papers_value": analysis.sequence and analysis.sequence.load_multiplier,
        "lowest": analysis.lowest and analysis.lowest.load_multiplier,
        "highest": analysis.highest,
        "local_failures": [
            {"stones": list(failure.stones), "share": failure.share, "multipliers": list(failure.multipliers)}
            for failure in analysis.local_failures
        ],
        "iterations": len(headline.records),
        "converged": found is not None,
        "equilibrium_residual": headline.equilibrium_residual,
        "base_shear": headline.load_multiplier * analysis.horizontal_load,
        "seconds": analysis.seconds,
    }


def _macroblocks(partition: Partition, joints: int) -> dict[str, Any]:
    tolerances = partition.tolerances
    return {
        "count": partition.count,
        "joints": joints - len(partition.vanished_joints),
        "tol_n": tolerances and tolerances.normal,
        "tol_d": tolerances and tolerances.centre_distance,
        "trivial": partition.count == 1,
    }
