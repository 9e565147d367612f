"""Joints about whose ends stones turn as a wall fails, and over what length they are pressed there.

In a mechanism that has moved by d, joint j has turned by r_j d, and is pressed over a_j = 4 N_j / (pi E t r_j d)
(masonry/pressed_edges.py), with the resultant at a_j / 4 from the end, where rigid blocks have it. That takes

    sum_j N_j r_j a_j / 4    over the live load

from the multiplier: the less the further the wall has moved, which takes its own part: the curve of rigid blocks in
large displacements has it and, beyond its end or of walls that were not pushed so, the slope with which it begins
(softening_slope.py). Rigid blocks may snap where stones that give way move on. Lengths are those at the d where the
most is left before that. Virtual work; own combination. Where a joint has mortar with a stiffness, that is what gives
way, and the curve has it.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.basis.printed import as_lambda
from orchestrator.limit_analysis.paper.limit_state import LimitAnalysis
from orchestrator.limit_analysis.search.loading_path import SAME_ANSWER
from orchestrator.limit_analysis.search.rigid_pushover import DRIFT
from orchestrator.limit_analysis.softening_slope import softening_slope
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.pressed_edges import compliances, is_at_end, under_turning

LEFT_OUT = 0.002
"""part of the multiplier that joints may take together which are left out, those that take least"""
LEAST_MOVED = 1e-4
"""least over largest of the motions that are looked at where the wall was not pushed"""
MOTIONS = 200
"""how many these are: 5 % from one to the next"""
FAR_LESS = 0.05
"""part of what rigid blocks bear from which on it is no longer the wall's, where edges take as much"""
BY_ROUNDING = 1e-6
"""part by which joints that are alike may differ in what they take: all of them are left out, or none"""


def pressed_at_hinges(assemblage: Assemblage, analysis: LimitAnalysis) -> FloatArray:
    """Return over what length x (joints, 2) in m joints are pressed at their start and at their end, as stones turn
    about it in the headline's mechanism; 0 elsewhere, where all of a joint is pressed, where joints take LEFT_OUT of
    the multiplier together, and where nothing says how far the wall moves (`_curve`)."""
    lengths, turning = np.zeros((assemblage.joints.count, 2)), _turning(assemblage, analysis)
    if turning is None:
        return lengths
    normal, pressed, takes, _ = turning
    least_first = np.sort(takes)
    beyond = least_first[np.cumsum(least_first) > LEFT_OUT * analysis.headline.load_multiplier]
    counts = (takes >= (1.0 - BY_ROUNDING) * beyond.min(initial=np.inf)) & (pressed < assemblage.joints.length)
    lengths[counts, normal[counts].argmax(axis=1)] = pressed[counts]
    return lengths


def left_at_hinges(assemblage: Assemblage, analysis: LimitAnalysis) -> float | None:
    """Return the most that rigid blocks in large displacements bear less what joints take so, as a multiplier, 0 where
    these take more; None where nothing says how far the wall moves (`_curve`), and of a curve that does not fall
    again."""
    turning = _turning(assemblage, analysis)
    return None if turning is None or turning[3] is None else max(turning[3], 0.0)


def edges_take(analysis: LimitAnalysis, part: float) -> bool:
    """Return whether stones that give way at edges leave less than rigid blocks bear by more than a part of it."""
    left, state = analysis.pressed_peak, analysis.headline.load_multiplier
    return left is not None and left < (1.0 - part) * min(state, analysis.rigid_peak or state)


def edge_words(analysis: LimitAnalysis) -> Iterator[str]:
    """Yield about what is left as stones give way at edges, where rigid blocks bear more by more than SAME_ANSWER."""
    if analysis.pressed_peak is not None and edges_take(analysis, SAME_ANSWER):
        warns = "WARNING: " if edges_take(analysis, FAR_LESS) else ""
        left, tell = f"about {as_lambda(analysis.pressed_peak)}", ", finite elements tell (`run`)"
        if not analysis.pressed_peak:
            left, tell = "about nothing", "; finite elements tell whether the wall stands (`run`)"
        yield f"{warns}stones give way at the edges that they turn about: {left} is left in large displacements{tell}"


def _turning(
    assemblage: Assemblage, analysis: LimitAnalysis
) -> tuple[FloatArray, FloatArray, FloatArray, float | None] | None:
    """Return forces (joints, 2) in N at the ends of joints, the lengths (joints,) in m that they are pressed over when
    the most is left of the curve that was followed, what (joints,) they take from the multiplier then, and the most
    that is left beyond its end, too, None where that grows on."""
    joints, headline = assemblage.joints, analysis.headline
    velocities = headline.mechanism.velocities
    power, live = (analysis.loads.live * velocities).sum(), headline.live_total
    if min(power, live) <= 0.0 or (known := _curve(assemblage, analysis)) is None:
        return None
    curve, followed = known
    normal = np.maximum(headline.joint_forces[: joints.count, :2], 0.0)
    force, per_live = normal.sum(axis=1), power / live
    turn = np.abs(velocities[joints.j, 2] - velocities[joints.i, 2]) / per_live  # rad per m of the live load's motion
    soft = compliances(assemblage.wall, joints, analysis.elastic_modulus).sum(axis=1) * joints.length / joints.area
    turns = is_at_end(normal) & (turn * soft > 0.0) & np.isinf(joints.normal_stiffness)
    moved, bears = curve.T
    pressed = np.zeros((len(moved), joints.count))
    pressed[:, turns] = under_turning(force[turns], soft[turns], moved[:, None] * turn[turns])
    pressed = np.minimum(pressed, joints.length)
    takes = force * turn * pressed / (3.0 * live)
    left = bears - takes.sum(axis=1)
    most, there = int(np.argmax(left)), int(np.argmax(left[:followed] if followed else left))
    return normal, pressed[there], takes[there], float(left[most]) if most < len(left) - 1 else None


def _curve(assemblage: Assemblage, analysis: LimitAnalysis) -> tuple[FloatArray, int] | None:
    """Return displacements along the live load in m, all above 0, and multipliers (s, 2) of rigid blocks there, and how
    many were followed: up to their peak if it was not passed, and else, as of walls that were not pushed, a line with
    the slope of the beginning goes on, no higher than the peak.

    None where that has none, as joints pull until they break, or crush, or no limit state was closed.
    """
    known, joints, state = analysis.rigid_curve, assemblage.joints, analysis.headline
    known = np.zeros((0, 2)) if known is None else known[known[:, 0] > 0.0]
    if analysis.rigid_curve is not None and analysis.rigid_peak is None:
        return (known, len(known)) if len(known) else None
    holds = joints.tensile_strength.any()
    closed = state.converged and state is not analysis.associative
    if not len(known) and (holds or not closed or np.isfinite(joints.compressive_strength).any()):
        return None
    free = np.vstack([block.polygon for block in assemblage.wall.blocks if not block.fixed])
    moved = np.geomspace(LEAST_MOVED, 1.0, MOTIONS) * DRIFT * float(np.ptp(free[:, 1]))
    moved = moved[moved > known[:, 0].max(initial=0.0)]
    falls = state.load_multiplier + softening_slope(assemblage, analysis.loads, state) * moved
    most = np.inf if analysis.rigid_peak is None else analysis.rigid_peak
    return np.vstack([known, np.column_stack([moved, np.minimum(falls, most)])]), len(known)
