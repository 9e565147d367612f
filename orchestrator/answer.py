"""Which of several numbers counts, and why: one sentence for the terminal."""

from __future__ import annotations

from typing import Any

from orchestrator.limit_analysis import LimitAnalysis

ALIKE = 1e-4
"""part by which two multipliers differ that are one answer"""


def answer_of_limit(analysis: LimitAnalysis) -> str:
    """Return the sentence on a limit analysis: the multiplier that counts, its base shear, and how sure it is."""
    state, bound = analysis.headline, analysis.bound.load_multiplier
    multiplier = state.load_multiplier
    counts = f"λ = {multiplier:.5f} counts ({state.flow_rule.replace('_', ' ')}): "
    shear = f"base shear {multiplier * analysis.horizontal_load / 1e3:.4f} kN, "
    if state is analysis.associative:
        return f"{counts}{shear}an upper bound only, as no state with friction that does not dilate was found."
    why = "a collapse state with friction that does not dilate; "
    if not state.converged:
        why = "the wall was found at rest there, and no collapse state was closed; "
    found = analysis.non_associative_range or (multiplier, multiplier)
    low = min(found[0], analysis.lowest.load_multiplier if analysis.lowest else found[0])
    high = found[1]
    if bound - low <= ALIKE * bound:
        return f"{counts}{shear}{why}it reaches the associative upper bound, and no lower one was found."
    if high - low <= ALIKE * high:
        return f"{counts}{shear}{why}the associative {bound:.5f} is an upper bound."
    between = f"such states were found from {low:.5f} to {high:.5f}, as friction leaves the answer open"
    return f"{counts}{shear}{why}{between}; the associative {bound:.5f} is an upper bound."


def answer_of_run(summary: dict[str, Any]) -> str:
    """Return the sentence on a run: the base shear that counts, or that none does."""
    valid = {entry["model"]: entry for entry in summary["pushover"] if entry["valid"]}
    if not valid:
        return "No peak counts: none of the curves is valid; limit analysis alone stands."
    entry = valid.get("micro") or valid["macro"]
    peak, multiplier = entry["peak_base_shear"] / 1e3, entry["peak_multiplier"]
    bodies = "every stone" if entry["model"] == "micro" else "macroblocks"
    text = f"{peak:.4f} kN counts (λ = {multiplier:.4f}, FE of {bodies})"
    if not entry.get("peak_reached", True):
        text += ", a lower bound, as the curve ends before its peak"
    if "macro" in valid and entry["model"] == "micro":
        text += f"; macroblocks ({valid['macro']['peak_base_shear'] / 1e3:.4f} kN) are its fast approximation"
    return f"{text}; limit analysis takes the stones as rigid and displacements as small."
