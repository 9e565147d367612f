"""What `sensitivity` counts at a point: the capacity of the load case that governs, in a quantity that compares all."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos
from typing import Any, Literal

from orchestrator.app import load_cases
from orchestrator.assessment.seismic.settings import limit_states
from orchestrator.loads.block_loads import is_measured_by_base_shear
from orchestrator.present.verdict import Answered, kind_of, verdict
from orchestrator.settings.case import Case

Quantity = Literal["ground acceleration that passes (m/s²)", "load multiplier", "base shear (kN)"]
ACCELERATION: Quantity = "ground acceleration that passes (m/s²)"
MULTIPLIER: Quantity = "load multiplier"
BASE_SHEAR: Quantity = "base shear (kN)"
COLUMN_OF = {
    ACCELERATION: ("capacity_ag_m_per_s2", 1.0),
    MULTIPLIER: ("multiplier", 1.0),
    BASE_SHEAR: ("capacity", 1e-3),
}
"""column of the verdict that holds a quantity, and factor from SI"""
NO_ANSWER = "no answer"
"""kind of answer of a point at which a load case has none"""


def compared(case: Case) -> dict[str, Case]:
    """Return the load cases that a capacity is the least of: of several, without a ground acceleration, those that
    base shears compare."""
    cases = load_cases.each(case)
    if len(cases) == 1 or limit_states(case.seismic):
        return cases
    return {name: one for name, one in cases.items() if is_measured_by_base_shear(one.load.inclination)}


def quantity_of(case: Case) -> Quantity:
    """Return what capacities are counted in: one quantity that means the same in all load cases that are compared, and
    at all points.

    A load multiplier does where all of them have one horizontal load at a multiplier of 1, as those of the envelope.
    """
    if limit_states(case.seismic):
        return ACCELERATION
    loads = [one.load for one in compared(case).values()]
    horizontal = {(load.live, cos(load.inclination), tuple(d for d in load.dead if d.inertia)) for load in loads}
    return MULTIPLIER if len(horizontal) == 1 else BASE_SHEAR


def governing(answers: Sequence[Answered], remarks: Sequence[str], quantity: Quantity) -> dict[str, Any]:
    """Return the capacity, in a quantity, of the load case that governs, and which kind of answer it is; None where a
    load case has no answer."""
    judgement = verdict("", answers) if answers else None
    row = None if judgement is None or remarks else judgement.governing
    key, factor = COLUMN_OF[quantity]
    if row is None or row[key] == "":
        said = "; ".join(remarks) or "nothing counts"
        return {"capacity": None, "kind": NO_ANSWER, "load_case": "", "check": "", "remark": said}
    capacity = row[key] * factor
    assert judgement is not None
    summary = next(answer.summary for answer in answers if answer.name == row["load_case"])
    assert summary is not None
    left_out = judgement.left_open.format(count=judgement.not_made) if judgement.not_made else ""
    remark = "; ".join(text for text in (left_out, *row["remarks"]) if text)
    kind = kind_of(row, summary)
    if judgement.not_made and row["safety_ratio"] != "":
        kind += f", {judgement.not_made} not made"
    return {"capacity": capacity, "kind": kind, "load_case": row["load_case"], "check": row["check"], "remark": remark}
