"""Interfaces as one value: parts of them and several together keep what belongs to each, in the plane and in space."""

import numpy as np
import pytest

from orchestrator.masonry.interfaces import Interfaces
from orchestrator.space.contacts import find_joints
from tests.support.space_walls import GROUND, extruded, wall_of
from tests.support.walls import four_blocks

SLAB = extruded([[-1.0, 0.0], [1.0, 0.0], [1.0, 0.3], [-1.0, 0.3]], 0.5)
WEDGE = extruded([[-0.5, 0.3], [0.5, 0.3], [0.0, 0.8]], 0.4)


def in_space() -> Interfaces:
    return find_joints(wall_of([GROUND, SLAB, WEDGE], 0.6)).joints


@pytest.mark.parametrize("made", [lambda: four_blocks().joints, in_space])
def test_parts_in_any_order_keep_the_points_of_each(made):
    whole = made()
    order = np.arange(whole.count)[::-1]
    turned = whole.part(order)
    for number, before in enumerate(order.tolist()):
        assert (turned.i[number], turned.j[number]) == (whole.i[before], whole.j[before])
        np.testing.assert_array_equal(turned.corners(number), whole.corners(before))
    last = whole.part(np.arange(whole.count) == whole.count - 1)
    np.testing.assert_array_equal(last.point, whole.corners(whole.count - 1))
    assert last.joint.tolist() == [0] * len(last.point)


@pytest.mark.parametrize("made", [lambda: four_blocks().joints, in_space])
def test_parts_put_together_are_the_whole_again(made):
    whole = made()
    first = np.arange(whole.count) < 1
    again = whole.part(first).and_also(whole.part(~first))
    for name in Interfaces.__dataclass_fields__:
        np.testing.assert_array_equal(getattr(again, name), getattr(whole, name))


def test_frames_are_right_handed_and_point_from_i_to_j():
    plane, space = four_blocks().joints, in_space()
    np.testing.assert_allclose(np.cross(plane.normal, plane.tangent), 1.0)  # t is n turned by +90 degrees
    np.testing.assert_allclose(np.cross(space.tangents[:, 0], space.tangents[:, 1]), space.normal)
    for joints, centroids in ((plane, {0: [1, -0.1], 3: [1, 0.75]}), (space, {1: [0, 0.25, 0.15], 2: [0, 0.2, 0.5]})):
        for k, (i, j) in enumerate(joints.pairs):
            for block, sign in ((i, -1), (j, 1)):
                if block in centroids:
                    assert sign * (np.array(centroids[block]) - joints.centroid[k]) @ joints.normal[k] > 0


def test_groups_are_what_interfaces_connect():
    joints = four_blocks().joints.part(np.array([0, 4]))  # 0-1 and 2-3
    group = joints.groups(5)
    assert group[0] == group[1] != group[2] == group[3]
    assert len(set(group.tolist())) == 3
