"""Checks and summaries made by hand, and the verdict over them."""

from __future__ import annotations

from dataclasses import replace

from orchestrator.present.verdict import Answered, verdict
from orchestrator.storage.summary import LimitSummary, Summary, WallSummary
from tests.support.pushed import PUSHED


def check(ratio, state="SD", approach="N2, micro-FE"):
    return {
        "approach": approach, "limit_state": state, "ag_m_per_s2": 1.962, "demand": 0.01, "capacity": 0.02, "unit": "m",
        "capacity_ag_m_per_s2": 1.962 * ratio, "safety_ratio": ratio, "clause": "B.5", "remarks": [],
    }  # fmt: skip


def summary(*checks, peak=10e3, valid=True, models=("macro", "micro")):
    limit = LimitSummary(0.3, 0.25, (0.25, 0.26), 4, True, 1e-12, 8e3, 1.0)
    curves = tuple(replace(PUSHED, model=model, valid=valid, peak_base_shear=peak) for model in models)
    seismic = {"checks": list(checks)} if checks else None
    return Summary("wall", WallSummary(4, 8, 40e3, 40e3, 40e3), limit, None, curves, seismic)


def of(**summaries):
    return verdict("wall", [Answered(name, "+x", "mass", found) for name, found in summaries.items()])
