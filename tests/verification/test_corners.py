"""Four stones that meet in a point: the corner of one does not go through the corner of the one across.

A wall of 30 irregular quadrilaterals whose stones slide past their neighbours' corners on the descent, the same wall
pushed from the other side, and corners of two stones side by side in closed form.
"""

from __future__ import annotations

from dataclasses import replace
from random import Random

import numpy as np
import pytest

from orchestrator import JointSettings, analyse, find_joints, one_body_per_block, push
from orchestrator.loads import LoadSettings, loads_on
from orchestrator.masonry.wall import Block, Wall
from orchestrator.pushover.contact.contact_tracking import ONTO
from orchestrator.pushover.contact.corners import corners_in_common, of_larger_gap
from orchestrator.pushover.contact.faces import find_faces
from tests.support.pushover_chain import bodies_of, rectangle


def cross_of(*corners):
    """Four stones round the point (1, 1), the lower ones on a support; their other corners are those of a square."""
    ground = Block(0, rectangle(-0.5, -0.2, 3.0, 0.2), True, 20e3)
    stones = [rectangle(x, y, 1.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)]
    return Wall("cross", (ground, *(Block(n, stone, False, 20e3) for n, stone in enumerate(stones, 1))), 0.3, 0.6)


def test_stones_across_a_point_have_contacts_of_their_corners():
    """Each corner against both faces of the one across, and none of stones that have a joint."""
    bodies = bodies_of(cross_of())
    faces, joints = find_faces(bodies), bodies.interfaces
    known = {(min(i, j), max(i, j)) for i, j in zip(joints.i.tolist(), joints.j.tolist(), strict=True)}
    pairs = corners_in_common(faces, 1e-4, 0.1, known, bodies.moving)
    both = [(int(faces.body[slave]), int(faces.body[master])) for slave, master in pairs]
    assert sorted(both) == sorted(2 * [(0, 3), (3, 0), (1, 2), (2, 1)])
    for slave, master in pairs:
        np.testing.assert_allclose(faces.end[slave], [1.0, 1.0], atol=1e-12)
        assert [1.0, 1.0] in np.round([faces.start[master], faces.end[master]], 12).tolist()


@pytest.mark.parametrize(
    ("heights", "known", "exist"),
    [
        ((-0.002, -0.03), False, (False, False)),  # as the edge of a real stone is rounded
        ((-0.002, -0.03), True, (True, False)),
        ((-0.006, -0.03), False, (True, False)),
        ((0.01, -0.03), False, (False, False)),  # beside the corner
        ((0.01, -0.03), True, (True, False)),
    ],
)
def test_a_corner_is_out_through_the_nearer_face(heights, known, exist):
    place, were = np.zeros(2, np.int64), np.array([known, False])
    found = of_larger_gap(place, np.array(heights), were, np.full(2, 0.004))
    assert found.tolist() == list(exist)


def cyclopean(direction: int) -> Wall:
    """A grid of 6 x 5 quadrilaterals in 2 m x 1.5 m whose inner corners lie at random, mirrored for -1."""
    random, columns, rows = Random(5), 6, 5
    corner: dict[tuple[int, int], tuple[float, float]] = {}
    for i in range(columns + 1):
        for j in range(rows + 1):
            x, y = 2.0 * i / columns, 1.5 * j / rows
            x += random.uniform(-0.09, 0.09) if 0 < i < columns else 0.0
            y += random.uniform(-0.08, 0.08) if 0 < j < rows else 0.0
            corner[i, j] = (round(x, 4), round(y, 4))
    blocks = [Block(0, rectangle(-0.3, -0.2, 2.6, 0.2), True, 20e3)]
    for j in range(rows):
        for i in range(columns):
            stone = np.array([corner[i, j], corner[i + 1, j], corner[i + 1, j + 1], corner[i, j + 1]])
            blocks.append(Block(len(blocks), stone, False, 20e3))
    if direction < 0:
        turned = [replace(block, polygon=(block.polygon * [-1.0, 1.0])[::-1]) for block in blocks]
        return Wall("cyclopean", tuple(turned), 0.3, 0.4)
    return Wall("cyclopean", tuple(blocks), 0.3, 0.4)


@pytest.mark.parametrize("direction", [1, -1])
def test_stones_that_slide_past_their_neighbours_corners_do_not_overlap(direction):
    """Corners of two pairs of stones went 9 and 13 mm into each other while they had no contact; they have one from a
    depth of ONTO on."""
    assemblage = find_joints(cyclopean(direction), JointSettings())
    load = LoadSettings("+x" if direction > 0 else "-x")
    analysis = analyse(assemblage, loads=loads_on(assemblage.wall, load))
    done = push(assemblage, analysis, one_body_per_block(assemblage), load)
    assert not done.complaints
    assert done.summary.max_penetration_over_size < ONTO
    assert done.capacity.peak_reached
    assert done.capacity.peak_multiplier == pytest.approx(0.19815, rel=1e-3), "the same wall from both sides"
