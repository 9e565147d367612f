"""Joints about whose ends stones turn as a wall fails, and over what length they are pressed there.

In a mechanism that has moved by d, joint j has turned by r_j d, and is pressed over a_j = 4 N_j / (pi E t r_j d)
(masonry/pressed_edges.py), with the resultant at a_j / 4 from the end, where rigid blocks have it. That takes

    sum_j N_j r_j a_j / 4    over the live load

from the multiplier: the less the further the wall has moved, which takes its own part (the curve of rigid blocks in
large displacements). Lengths are those at the d where the most is left. Virtual work; own combination.
"""

from __future__ import annotations

import numpy as np

from orchestrator.basis.arrays import FloatArray
from orchestrator.limit_analysis.paper.limit_state import LimitAnalysis
from orchestrator.masonry.joints import Assemblage
from orchestrator.masonry.pressed_edges import compliances, is_at_end, under_turning

COUNTS = 0.02
"""part of what all joints take from the multiplier that one has to take to be named"""


def pressed_at_hinges(assemblage: Assemblage, analysis: LimitAnalysis) -> FloatArray:
    """Return over what length x (joints, 2) in m joints are pressed at their start and at their end, as stones turn
    about it in the headline's mechanism; 0 elsewhere, and for walls that were not pushed in large displacements."""
    joints, headline, curve = assemblage.joints, analysis.headline, analysis.rigid_curve
    lengths, velocities = np.zeros((joints.count, 2)), headline.mechanism.velocities
    power = (analysis.loads.live * velocities).sum()
    if curve is None or not (curve[:, 0] > 0.0).any() or min(power, analysis.horizontal_load) <= 0.0:
        return lengths
    normal = np.maximum(headline.joint_forces[: joints.count, :2], 0.0)
    force, per_live = normal.sum(axis=1), power / analysis.horizontal_load
    turn = np.abs(velocities[joints.j, 2] - velocities[joints.i, 2]) / per_live  # rad per m of the live load's motion
    soft = compliances(assemblage.wall, joints, analysis.elastic_modulus).sum(axis=1) * joints.length / joints.area
    turns = is_at_end(normal) & (turn * soft > 0.0)
    moved, bears = curve[curve[:, 0] > 0.0].T
    pressed = np.zeros((len(moved), joints.count))
    pressed[:, turns] = under_turning(force[turns], soft[turns], moved[:, None] * turn[turns])
    pressed = np.minimum(pressed, joints.length)
    takes = force * turn * pressed / (3.0 * analysis.horizontal_load)
    most = int(np.argmax(bears - takes.sum(axis=1)))
    counts = takes[most] > COUNTS * takes[most].sum()
    lengths[counts, normal[counts].argmax(axis=1)] = pressed[most, counts]
    return lengths
