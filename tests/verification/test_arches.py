"""Arches of voussoirs against their thrust line, which the test finds with three redundants and no block in sight."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import linprog

from orchestrator.limit_analysis import analyse, settle
from orchestrator.macroblocks.automatic import macroblocks_of
from orchestrator.macroblocks.criteria import MacroblockSettings
from orchestrator.masonry.joints import JointSettings, find_joints
from orchestrator.masonry.patterns import Arch, arch_on_piers
from tests.support.limit_analysis_cases import analysed
from tests.support.pushover_chain import model_of, run

WEIGHT = 20e3
FRICTION = 3.0
"""nothing slides: hinges only, as the thrust line assumes"""
SEMICIRCULAR = Arch(15, 1.0, 0.18, friction=FRICTION, thickness=0.3, unit_weight=WEIGHT)
SEGMENTAL = Arch(11, 1.6, 0.2, angle=1.8, friction=FRICTION, thickness=0.3, unit_weight=WEIGHT)
ON_PIERS = Arch(13, 0.9, 0.22, courses=4, pier_width=0.55, pier_height=1.2, friction=FRICTION, thickness=0.3)
SEGMENTAL_ON_PIERS = Arch(
    9, 1.3, 0.24, angle=2.0, courses=3, pier_width=0.6, pier_height=0.9, friction=FRICTION, thickness=0.3
)
ARCHES = [SEMICIRCULAR, SEGMENTAL, ON_PIERS, SEGMENTAL_ON_PIERS]


def sections(arch):
    """Return the ends of all joints (j, 2, 2) from the left support to the right one, and the outlines between them.

    Built from the arch's numbers, not from the wall's blocks: piers of equal courses, radial joints.
    """
    half = 0.5 * arch.angle
    angle = np.linspace(-half, half, arch.voussoirs + 1)
    outwards = np.column_stack([np.sin(angle), np.cos(angle)])
    inner, outer = (arch.radius - 0.5 * arch.depth) * outwards, (arch.radius + 0.5 * arch.depth) * outwards
    radial = [np.array([i, o]) for i, o in zip(inner, outer, strict=True)]
    lift = np.array([0.0, arch.pier_height - inner[0, 1] if arch.courses else 0.0])
    radial = [joint + lift for joint in radial]
    ring = [np.array([p[0], p[1], q[1], q[0]]) for p, q in pairwise(radial)]
    if not arch.courses:
        return radial, ring
    right, left = radial[0][0, 0], radial[0][0, 0] - arch.pier_width
    heights = np.linspace(0.0, arch.pier_height, arch.courses + 1)
    level = [np.array([[left, y], [right, y]]) for y in heights[:-1]]
    pier = [np.array([p[0], p[1], q[1], q[0]]) for p, q in pairwise(level)]
    head = np.array([level[-1][0], level[-1][1], radial[0][0], radial[0][1], [left, radial[0][1, 1]]])
    mirrored = [joint * [-1.0, 1.0] for joint in level]
    pieces = [*pier, head]
    others = [piece * [-1.0, 1.0] for piece in pieces]
    return [*level, *radial, *mirrored[::-1]], [*pieces, *ring, *others[::-1]]


def area_and_centroid(polygon):
    x, y = polygon.T
    cross = x * np.roll(y, -1) - np.roll(x, -1) * y
    area = 0.5 * cross.sum()
    centroid = np.array([((x + np.roll(x, -1)) * cross).sum(), ((y + np.roll(y, -1)) * cross).sum()]) / (6 * area)
    return abs(area), centroid


def thrust_program(joints, loads, points):
    """Return rows A x <= b that keep the thrust line inside the joints; x = (H, V, M, lambda).

    (H, V) acts on the chain at the first joint's middle, with moment M about it; loads (n, 3): dead weight (downwards)
    of piece k, at its centroid `points` (n, 2), and the horizontal live load for lambda = 1, both in N.
    """
    start = joints[0].mean(axis=0)
    rows = []
    for k, joint in enumerate(joints):
        a, b = joint
        middle, along = joint.mean(axis=0), (b - a)
        width = np.linalg.norm(along)
        along = along / width
        normal = np.array([-along[1], along[0]])
        if normal @ (joints[min(k + 1, len(joints) - 1)].mean(axis=0) - joints[max(k - 1, 0)].mean(axis=0)) < 0:
            normal = -normal
        # resultant on the part behind the joint, carried to its middle: force F = (H, V) + loads, moment about middle
        force = np.zeros((2, 5))
        force[0, 0], force[1, 1] = 1.0, 1.0
        arm = start - middle
        moment = np.array([-arm[1], arm[0], 1.0, 0.0, 0.0])
        for (weight, push), point in zip(loads[:k], points[:k], strict=True):
            force[1, 4] -= weight
            force[0, 3] += push
            r = point - middle
            moment[4] += r[0] * -weight
            moment[3] += -r[1] * push
        compression = normal @ force  # what the part behind passes on across the joint
        rows += [moment - 0.5 * width * compression, -moment - 0.5 * width * compression, -compression]
    rows = np.array(rows)
    return rows[:, :4], -rows[:, 4]


def chain(arch):
    joints, outlines = sections(arch)
    parts = [area_and_centroid(outline) for outline in outlines]
    weight = np.array([area * arch.thickness * arch.unit_weight for area, _ in parts])
    return joints, weight, np.array([centroid for _, centroid in parts])


def extreme(arch, cost, live=True):
    joints, weight, points = chain(arch)
    matrix, right = thrust_program(joints, list(zip(weight, weight, strict=True)), points)
    bounds = [(None, None)] * 3 + [(None, None) if live else (0.0, 0.0)]
    found = linprog(cost, A_ub=matrix, b_ub=right, bounds=bounds, method="highs")
    assert found.status == 0
    return found.x


NAMES = ["semicircular", "segmental", "semicircular on piers", "segmental on piers"]


@pytest.mark.parametrize("arch", ARCHES, ids=NAMES)
def test_horizontal_load_at_collapse_is_that_of_the_thrust_line(arch):
    expected = extreme(arch, [0.0, 0.0, 0.0, -1.0])[3]
    analysis = analyse(find_joints(arch_on_piers(arch), JointSettings()))
    assert expected > 0.05
    assert analysis.associative.load_multiplier == pytest.approx(expected, rel=1e-6)
    assert analysis.headline.load_multiplier == pytest.approx(expected, rel=5e-3)


@pytest.mark.parametrize("arch", ARCHES, ids=NAMES)
def test_thrust_limits_are_those_of_the_thrust_line(arch):
    """A support that gives way outwards finds the least thrust, one that is pushed inwards the largest."""
    least, largest = (sign * extreme(arch, [sign, 0.0, 0.0, 0.0], live=False)[0] for sign in (1.0, -1.0))
    assemblage = find_joints(arch_on_piers(arch), JointSettings())
    right = max(range(2), key=lambda k: assemblage.wall.blocks[k].polygon[:, 0].mean())
    support = assemblage.wall.blocks[right].id
    outwards, inwards = (settle(assemblage, support, angle) for angle in (0.0, np.pi))
    assert -outwards.load_multiplier == pytest.approx(abs(least), rel=1e-6)
    assert inwards.load_multiplier == pytest.approx(abs(largest), rel=1e-6)


@pytest.mark.parametrize("macroblocks", [False, True], ids=["every stone", "macroblocks"])
@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("arch", ARCHES, ids=NAMES)
def test_pushover_peaks_at_the_multiplier_of_the_thrust_line(arch, direction, macroblocks):
    """Elastic voussoirs in large displacements, as users push them: within 1 % of rigid ones, both ways."""
    arch = replace(arch, friction=1.2)
    assemblage = find_joints(arch_on_piers(arch), JointSettings())
    partition = macroblocks_of(assemblage, analysed(assemblage, direction), MacroblockSettings())
    if macroblocks:
        assert partition.count < len(assemblage.wall.blocks) - 2
    model = model_of(assemblage.wall, partition if macroblocks else None, direction=direction, large_displacement=True)
    curve = run(model, 2e-3).increments
    peak = max(increment.load_multiplier for increment in curve if increment.phase != "gravity")
    assert peak == pytest.approx(extreme(arch, [0.0, 0.0, 0.0, -1.0])[3], rel=0.01)
    assert curve[-1].load_multiplier < peak
