"""Joints of different friction: what slides over the one does not take the friction of the other, in no numbering.

A stone lies on the foot of an L and against its upright, the bed of 0.3, the joint beside it of 0.9. Pushed away from
the upright it slides at 0.3, as far as it goes.

Two stones that are one macroblock, side by side on a slab of 0.2 and 0.8: pushed by lambda of its weight the block, 1 m
wide and 0.25 m high, has pressures W/b (1 +- 6 e/b), e = 0.125 lambda, on its lower and its rougher half

    lambda = [0.2 (1/2 - 3 e / (2 b)) + 0.8 (1/2 + 3 e / (2 b))],    lambda = 0.5 / (1 - 0.6 * 1.5 * 0.125) = 0.563
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from orchestrator.macroblocks.bodies import make_bodies
from orchestrator.macroblocks.criteria import one_body_per_block, partition_of
from orchestrator.masonry.joints import Assemblage, JointSettings, find_joints
from orchestrator.masonry.wall import Block, Wall
from orchestrator.pushover.meshing import MeshSettings
from orchestrator.pushover.path.curve import pushover_increments
from orchestrator.pushover.settings import SteppingSettings
from tests.support.walls import rectangle, upright

ROUGH = 5.0


def with_friction(blocks: list[Block], frictions: dict[tuple[int, int], list[float]]) -> Assemblage:
    """Return the assemblage whose joints between blocks of two ids have the frictions, level joints first; others are
    ROUGH."""
    found = find_joints(Wall("joints", tuple(blocks), 0.3, 0.6), JointSettings())
    ids = np.array([block.id for block in blocks])
    friction = np.full(found.joints.count, ROUGH)
    for pair, values in frictions.items():
        between = [set(both) == set(pair) for both in zip(ids[found.joints.i], ids[found.joints.j], strict=True)]
        numbers = sorted(np.flatnonzero(between), key=lambda k: abs(found.joints.normal[k, 0]))
        friction[numbers] = values
    return replace(found, joints=replace(found.joints, friction=friction))


def largest(
    assemblage: Assemblage, bodies: list[int] | None, size: float | None, way: float = 1.0, far: float = 0.1
) -> float:
    """Return the largest load multiplier of a pushover along +x or -x to `far` m, of every stone or of bodies (n,)."""
    partition = partition_of(assemblage, np.array(bodies)) if bodies else one_body_per_block(assemblage)
    made = make_bodies(assemblage, partition)
    rows = pushover_increments(
        made, MeshSettings(size=size), stepping=SteppingSettings(final_displacement=far, final_drop=1.0),
        direction=(way, 0.0), expected_multiplier=0.4,
    )  # fmt: skip
    return max(row.load_multiplier for row in rows)


@pytest.mark.parametrize("order", [(0, 1, 2), (0, 2, 1)])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_stone_that_slides_off_an_l_has_the_friction_of_its_bed(order, way):
    ell = np.array([(0, 0), (3, 0), (3, 0.6), (0.8, 0.6), (0.8, 1.4), (0, 1.4)])
    outlines = [rectangle(-1, -0.3, 5, 0.3), ell, rectangle(0.8, 0.6, 0.9, 0.3)]
    if way < 0.0:
        outlines = [(outline * [-1, 1])[::-1] for outline in outlines]
    blocks = [Block(k, outlines[k], k == 0, 20e3) for k in order]
    assert largest(with_friction(blocks, {(1, 2): [0.3, 0.9]}), None, 0.15, way) == pytest.approx(0.3, rel=1e-3)


def test_a_node_that_two_joints_share_has_the_friction_of_both():
    stones = [upright(2, 0, 0.3, 0.5, 0.25), upright(3, 0.5, 0.3, 0.5, 0.25)]
    below = [upright(0, -2, -0.3, 6, 0.3, fixed=True), upright(1, -1, 0, 4, 0.3)]
    found = [
        largest(with_friction([*below, *above], {(1, 2): [0.2], (1, 3): [0.8]}), [0, 1, 9, 9], None, far=1e-3)
        for above in (stones, stones[::-1])
    ]
    assert found[1] == pytest.approx(found[0], rel=1e-9)
    assert found[0] == pytest.approx(0.5 / (1 - 0.6 * 1.5 * 0.125), rel=0.02), "0.470 and 0.611 with that of one"
