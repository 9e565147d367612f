"""summary.json: the figures that scripts outside this repository read; the keys stay. All SI."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from orchestrator.capacity import Capacity
from orchestrator.joints import Assemblage
from orchestrator.limit_analysis.state import LimitAnalysis
from orchestrator.macroblocks import Partition
from orchestrator.masonry.wall import FloatArray
from orchestrator.meshing import BodyMeshes
from orchestrator.pushover.state import Increment

COARSE = 0.01
"""part of a joint by which the resultant of its toe may lie off before that is told"""
TOLD = 5
"""local failures that are told one by one"""
TIMINGS = ("mesh", "assembly", "factorise", "contact", "total")
"""what `seconds` of a pushover holds, in s"""


@dataclass(frozen=True, slots=True)
class Event:
    """Bodies that fell while the wall went on: their names, share of the mass, the load multiplier and base shear (N)
    of the last static state before, and in which increment they had left their neighbours."""

    bodies: tuple[str, ...]
    mass_share: float
    load_multiplier: float
    base_shear: float
    increment: int


@dataclass(frozen=True, slots=True)
class Effort:
    """What a pushover cost: folded from all its increments, gravity included.

    newton_iterations counts those of failed attempts too; moving_steps: increments in which the wall moves. rescues:
    what was done about failed attempts, and how often. energy_error: the largest imbalance of work and energies
    (record.py), over stored energy plus friction at the end plus the largest work of the live load: on a
    block that rocks dead and live work cancel, and stored energy measures nothing. events: local failures, in order.
    """

    steps: int
    moving_steps: int
    newton_iterations: int
    rescues: dict[str, int]
    energy_error: float
    events: tuple[Event, ...]


def effort_of(increments: Iterable[Increment], names: Sequence[str], mass: FloatArray) -> Effort:
    """Fold increments, one at a time, into their effort; names and mass (b,) in kg of the bodies."""
    steps = moving = iterations = 0
    imbalance = turned_over = driven = 0.0
    rescues: Counter[str] = Counter()
    events: list[Event] = []
    static = (0.0, 0.0)
    fallen = np.zeros(len(mass), bool)
    for increment in increments:
        steps, moving = steps + 1, moving + increment.moving
        iterations += increment.iterations + sum(attempt.iterations for attempt in increment.attempts)
        rescues.update(attempt.action for attempt in increment.attempts)
        turned_over = increment.internal_energy + increment.dissipated_energy
        driven = max(driven, abs(increment.live_work))
        imbalance = float(np.maximum(imbalance, abs(increment.energy_error)))  # max() would lose a nan
        if (gone := np.flatnonzero(increment.fallen & ~fallen)).size:
            share = float(mass[gone].sum() / mass.sum())
            events.append(Event(tuple(names[body] for body in gone), share, *static, increment.number))
        fallen = increment.fallen
        if not increment.moving:
            static = (increment.load_multiplier, increment.base_shear)
    measure = turned_over + driven
    error = imbalance / measure if measure else 0.0
    return Effort(steps, moving, iterations, dict(rescues), error, tuple(events))


def pushover_summary(
    model: Literal["macro", "micro"],
    meshes: BodyMeshes,
    contacts: int,
    effort: Effort,
    capacity: Capacity,
    stopped_because: str,
    *,
    overlap: tuple[float, float],
    toe_error: float,
    large_displacement: bool,
    ranks: int,
    seconds: Mapping[str, float],
    peak_memory: int,
    complaint: str | None,
    not_valid_because: str | None,
) -> dict[str, Any]:
    """Return one entry of `pushover`. seconds: exactly the keys of TIMINGS; peak_memory in bytes; overlap: of displaced
    outlines in m, and over the smaller body's size. toe_error: how far toes that crush may lie off, over their joint.

    complaint: why the curve ended early or is not valid; None for a good one. not_valid_because: the checks of the
    result that failed (pushover.checks), in words; None: it is valid.
    """
    assert set(seconds) == set(TIMINGS), f"timings {sorted(seconds)}, not {sorted(TIMINGS)}"
    return {
        "model": model,
        "bodies": len(meshes.unit_weight),
        "nodes": len(meshes.nodes),
        "tetrahedra": len(meshes.tetrahedra),
        "contacts": contacts,
        "displacements": "large" if large_displacement else "small",
        "ranks": ranks,
        **asdict(effort),
        "max_penetration": overlap[0],
        "max_penetration_over_size": overlap[1],
        "toe_error": toe_error,
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


def remarks(pushovers: Sequence[dict[str, Any]]) -> list[str]:
    """Return what entries of `pushover` have to say beside their figures: local failures, a peak that was not reached.

    Many events are told in short: the first ones, and how many there were.
    """
    said = []
    for entry in pushovers:
        for event in entry["events"][:TOLD]:
            bodies, share = ", ".join(event["bodies"]), 100 * event["mass_share"]
            said.append(
                f"{entry['model']} FE: {bodies} ({share:.2g} % of the mass) fell at a load multiplier of "
                f"{event['load_multiplier']:.4f}; the wall went on"
            )
        if (more := len(entry["events"]) - TOLD) > 0:
            said.append(f"{entry['model']} FE: {more} more local failures, in summary.json")
        if entry.get("toe_error", 0.0) > COARSE:
            said.append(
                f"{entry['model']} FE: at the peak the resultant of a toe may lie off by "
                f"{100 * entry['toe_error']:.2g} % of its joint, "
                "as elements are longer than what crushes; lower mesh.size"
            )
        if not entry["peak_reached"]:
            multiplier = entry["peak_multiplier"]
            said.append(f"{entry['model']} FE: the peak was not reached; the wall carries at least {multiplier:.4f}")
    return said


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
        "associative_left": analysis.associative_left and analysis.associative_left.load_multiplier,
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
        "converged": found is not None and headline.converged,
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
