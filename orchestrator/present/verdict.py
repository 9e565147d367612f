"""The verdict over all load cases of a wall: one table, the check that governs, and one sentence that can be signed.

strength      of every load case the base shear that counts: FE of every stone, else of macroblocks, where its curve
              is valid and counts (storage/notes.py); else the headline of limit analysis. The least base shear
              governs. Of several load cases those whose live load is more vertical than horizontal are not compared: no
              base shear measures them
verification  where a ground acceleration is asked for: every check of every load case. A limit state is verified
              where all its checks pass, and open where one of them could not be made. The least ratio governs
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from orchestrator.basis.printed import printed
from orchestrator.loads.block_loads import is_measured_by_base_shear
from orchestrator.masonry.wall import GRAVITY
from orchestrator.storage.notes import (
    COARSE_TOES,
    cautions,
    first_of_valid,
    rigid_stones_alone,
    standing_is_open,
    why_not,
    without_reference,
)
from orchestrator.storage.summary import LimitSummary, PushoverSummary, Summary

COLUMNS = (
    "load_case", "direction", "distribution", "limit_state", "check", "ag_m_per_s2", "demand", "capacity", "unit",
    "capacity_ag_m_per_s2", "safety_ratio", "verified", "governs", "multiplier", "clause", "remarks",
)  # fmt: skip
STRENGTH = "strength"
"""what stands for the limit state in rows of base shear"""
ENDS_EARLY = "the curve ends before its peak: a lower bound"
LIMIT = "limit analysis"
"""the check of such a row where it is not from a curve"""
STEEP = "its live load is more vertical than horizontal: its base shear is not compared"
"""remark on such a row of a load case that is one of several"""
ROUNDING = 1e-6
"""part of a value that is rounding"""
State = Literal["verified", "not verified", "open", "strength", "not compared", "nothing"]


@dataclass(frozen=True, eq=False, slots=True)
class Answered:
    """What one load case has answered: its name, live load (inclination above the horizontal in rad), and summary (None
    where there is none: complaints)."""

    name: str
    direction: str
    distribution: str
    summary: Summary | None
    complaints: tuple[str, ...] = ()
    inclination: float = 0.0


@dataclass(frozen=True, eq=False, slots=True)
class Verdict:
    """rows: those of the table (keys COLUMNS; remarks are a tuple); state; governing: the row that governs, None where
    nothing counts."""

    case: str
    rows: tuple[dict[str, Any], ...]
    state: State
    governing: dict[str, Any] | None

    @property
    def load_cases(self) -> list[str]:
        """Names of the load cases, each once."""
        return list(dict.fromkeys(row["load_case"] for row in self.rows))

    @property
    def limit_states(self) -> list[str]:
        """Limit states that were asked for, each once, in the order of the rows."""
        return list(
            dict.fromkeys(row["limit_state"] for row in self.rows if row["limit_state"] not in (STRENGTH, "all"))
        )

    def of(self, limit_state: str) -> list[dict[str, Any]]:
        """Return the rows of a limit state."""
        return [row for row in self.rows if row["limit_state"] == limit_state]

    @property
    def steep(self) -> list[str]:
        """Names of the load cases whose base shear is not compared."""
        return [row["load_case"] for row in self.rows if STEEP in row["remarks"]]

    @property
    def not_made(self) -> int:
        """How many checks could not be made, the rows that say so."""
        return sum(row["verified"] == "not made" for row in self.rows)

    @property
    def left_open(self) -> str:
        """What is left open, as a phrase with its {count}: checks or, where none was asked for, load cases."""
        if self.state in ("strength", "not compared", "nothing"):
            one = self.not_made == 1
            return "1 load case has no certain answer" if one else "{count} load cases have no certain answer"
        return "1 check could not be made" if self.not_made == 1 else "{count} checks could not be made"


def verdict(case: str, answers: Sequence[Answered]) -> Verdict:
    """Return the verdict on load cases; `case` names the wall."""
    rows = [row for answer in answers for row in _rows(answer)]
    if len(answers) > 1:
        steep = {answer.name for answer in answers if not is_measured_by_base_shear(answer.inclination)}
        rows = [_not_compared(row) if row["load_case"] in steep else row for row in rows]
    asked = [row for row in rows if row["limit_state"] != STRENGTH]
    least, state = _governing(rows, asked)
    governing = None if least is None else least | {"governs": "yes"}
    marked = tuple(governing if row is least and governing is not None else row for row in rows)
    return Verdict(case, marked, state, governing)


def _governing(rows: Sequence[dict[str, Any]], asked: Sequence[dict[str, Any]]) -> tuple[dict[str, Any] | None, State]:
    """Return the row that governs and what follows from all."""
    ratios = [row for row in asked if row["safety_ratio"] != ""]
    if not asked:
        counted = [row for row in rows if row["capacity"] != ""]
        if not counted:
            return None, "not compared" if any(row["multiplier"] != "" for row in rows) else "nothing"
        return _first_of_least(counted, "capacity"), "strength"
    if failed := [row for row in ratios if row["safety_ratio"] < 1.0]:
        return _first_of_least(failed, "safety_ratio"), "not verified"
    least = _first_of_least(ratios, "safety_ratio") if ratios else None
    unknown = any(row["verified"] == "not made" for row in rows)
    return least, "open" if unknown else "verified"


def _first_of_least(rows: Sequence[dict[str, Any]], key: str) -> dict[str, Any]:
    """Return the first row that has the least value but for ROUNDING, by which mirror images may differ."""
    least = min(row[key] for row in rows)
    return next(row for row in rows if row[key] <= least + ROUNDING * abs(least))


def _not_compared(row: dict[str, Any]) -> dict[str, Any]:
    """Return a row of a load case whose live load no base shear measures: its multiplier alone stands."""
    if row["limit_state"] != STRENGTH or row["multiplier"] == "":
        return row
    return row | {"capacity": "", "unit": "", "remarks": (*row["remarks"], STEEP)}


def _rows(answer: Answered) -> list[dict[str, Any]]:
    about = {"load_case": answer.name, "direction": answer.direction, "distribution": answer.distribution}
    row = dict.fromkeys(COLUMNS, "") | about | {"remarks": ()}
    if answer.summary is None:
        return [row | {"limit_state": STRENGTH, "verified": "not made", "remarks": answer.complaints}]
    checks = [_check(check) for check in (answer.summary.seismic["checks"] if answer.summary.seismic else ())]
    strength = _strength(answer.summary)
    if any(check["verified"] == "not made" for check in checks):
        strength["verified"] = ""  # the same doubt is not counted twice
    return [row | answered for answered in (strength, *checks)]


def _check(check: Mapping[str, Any]) -> dict[str, Any]:
    row = {"limit_state": check["limit_state"], "check": check["approach"]}
    if "refused" in check:
        return row | {"verified": "not made", "remarks": (check["refused"],)}
    keys = ("ag_m_per_s2", "demand", "capacity", "unit", "capacity_ag_m_per_s2", "safety_ratio", "clause")
    passed = "yes" if check["safety_ratio"] >= 1.0 else "no"
    return row | {key: check[key] for key in keys} | {"verified": passed, "remarks": tuple(check["remarks"])}


def kind_of(row: Mapping[str, Any], summary: Summary) -> str:
    """Return which kind of answer a row that governs is, of the summary it comes from: only like can be compared."""
    limit = summary.limit_analysis.kind
    if row["limit_state"] != STRENGTH:
        return "checks" if limit == "collapse state" else f"checks, {limit}"
    if row["check"] == LIMIT:
        return limit
    return "curve without its peak" if ENDS_EARLY in row["remarks"] else "peak of a curve"


def _strength(summary: Summary) -> dict[str, Any]:
    """Return the base shear of one load case that counts, and what it is from."""
    row = {"limit_state": STRENGTH, "unit": "N"}
    pushed = first_of_valid(summary.pushover)
    if pushed is None:
        return row | _of_limit_analysis(summary.limit_analysis, ["no curve is valid"] if summary.pushover else [])
    reference = without_reference(summary) if pushed.model == "macro" else None
    doubts = [reference] if reference else []
    if why := why_not(pushed, summary.limit_analysis, summary.wall.blocks):
        return row | _of_limit_analysis(summary.limit_analysis, [why, *doubts])
    return row | _of_curve(pushed, summary, doubts)


def _of_curve(pushed: PushoverSummary, summary: Summary, doubts: list[str]) -> dict[str, Any]:
    check = "FE of every stone" if pushed.model == "micro" else "FE of macroblocks"
    said = [*([] if pushed.peak_reached else [ENDS_EARLY]), *doubts]
    return {
        "check": check,
        "capacity": pushed.peak_base_shear,
        "multiplier": pushed.peak_multiplier,
        "remarks": (*said, *cautions(pushed, summary.limit_analysis, summary.wall.blocks)),
    }


def _of_limit_analysis(limit: LimitSummary, doubts: list[str]) -> dict[str, Any]:
    rigid = rigid_stones_alone(limit)
    said = [*([] if limit.kind == "collapse state" else [limit.kind]), *([rigid] if rigid else []), *doubts]
    if is_open := standing_is_open(limit):
        return {"check": LIMIT, "unit": "", "remarks": (is_open, *said), "verified": "not made"}
    row = {"check": LIMIT, "capacity": limit.base_shear, "multiplier": limit.multiplier}
    return row | {"remarks": tuple(said), "verified": "not made" if said else ""}


def sentence(judged: Verdict, say: Callable[[str], str] = str) -> str:
    """Return the verdict in one sentence: what was asked, whether it holds, what governs, and what is open.

    say: a phrase in the language of the reader.
    """
    count, cases = len(judged.load_cases), ", ".join(map(say, judged.load_cases))
    head = "{case}, 1 load case in the plane of the wall ({cases})"
    if count > 1:
        head = "{case}, {count} load cases in the plane of the wall ({cases})"
    text = say(head).format(case=judged.case, count=count, cases=cases) + ": " + _body(judged, say)
    unverified = judged.state in ("strength", "not compared")
    if unverified and judged.steep:
        steep = ", ".join(map(say, judged.steep))
        text += "; " + say("not compared, as more vertical than horizontal: {load_cases}").format(load_cases=steep)
    if judged.not_made:
        text += "; " + say(judged.left_open).format(count=judged.not_made)
    if any(COARSE_TOES in remark for row in judged.rows for remark in row["remarks"]) and say(COARSE_TOES) not in text:
        text += "; " + say(COARSE_TOES)
    if unverified:
        text += "; " + say("no ground acceleration was given, so nothing is verified")
    return text + "."


def _body(judged: Verdict, say: Callable[[str], str]) -> str:
    row = judged.governing
    if judged.state == "not compared":
        return say("no load case governs by its base shear")
    if row is None:
        return say("NOTHING CAN BE SAID")
    if judged.state == "strength":
        said = say("{load_case} governs with the least base shear, {shear} kN (load multiplier {multiplier}, {check})")
        values = {"shear": printed("force", row["capacity"]), "multiplier": printed("multiplier", row["multiplier"])}
        remarks = f" ({'; '.join(map(say, row['remarks']))})" if row["remarks"] else ""
        return said.format(load_case=say(row["load_case"]), check=say(row["check"]), **values) + remarks
    words = {"verified": "VERIFIED", "not verified": "NOT VERIFIED", "open": "NOT YET VERIFIED"}[judged.state]
    text = (
        "{load_case} governs at {state} with {check}, safety ratio {ratio}: the wall passes up to a ground "
        "acceleration of {passes} g, {asked} g is asked for"
    )
    if judged.not_made:
        text = (
            "{load_case} governs at {state} with {check}, safety ratio {ratio}: as far as it could be checked, the "
            "wall passes up to a ground acceleration of {passes} g, {asked} g is asked for"
        )
    said = say(text).format(
        load_case=say(row["load_case"]), state=row["limit_state"], check=say(row["check"]),
        ratio=printed("ratio", row["safety_ratio"]), **_accelerations(row),
    )  # fmt: skip
    failed = [state for state in judged.limit_states if any(one["verified"] == "no" for one in judged.of(state))]
    states = ", ".join(failed if judged.state == "not verified" else judged.limit_states)
    return f"{say(words)} ({states}); {said}{_other_states(judged, row['limit_state'], say)}"


def _other_states(judged: Verdict, governing: str, say: Callable[[str], str]) -> str:
    """Return up to what ground acceleration the wall passes at other limit states that it does not pass."""
    said = ""
    for state in judged.limit_states:
        failed = [row for row in judged.of(state) if row["verified"] == "no"]
        if failed and state != governing:
            row = _first_of_least(failed, "safety_ratio")
            text = say("at {state} up to {passes} g, {asked} g is asked for")
            said += f"; {text.format(state=state, **_accelerations(row))}"
    return said


def _accelerations(row: Mapping[str, Any]) -> dict[str, str]:
    """Return up to what ground acceleration a check passes, and what is asked for, as printed, over gravity."""
    keys = {"passes": "capacity_ag_m_per_s2", "asked": "ag_m_per_s2"}
    return {name: f"{row[key] / GRAVITY:.3f}" for name, key in keys.items()}
