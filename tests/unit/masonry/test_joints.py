from __future__ import annotations

import json
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orchestrator.basis.errors import CaseError
from orchestrator.masonry.joint_warnings import short_contacts
from orchestrator.masonry.joints import JointClass, JointSettings, check_assemblage, find_joints, is_bed
from orchestrator.masonry.sources.block_files import read_blocks, wall_from
from orchestrator.masonry.wall import Block, Wall, check_wall
from tests.support.paths import DATA, PROJECT
from tests.support.walls import between

FILES = [*sorted((DATA).glob("*.json")), PROJECT / "meshes" / "ferris_tinloi_wall6.json"]


def wall(*blocks):
    """Blocks as (polygon, fixed)."""
    made = tuple(Block(10 + n, np.array(p, dtype=float), fixed, 1e4) for n, (p, fixed) in enumerate(blocks))
    return Wall("test", made, 0.1, 0.5)


GROUND = ([[-1, -1], [3, -1], [3, 0], [-1, 0]], True)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_number_of_joints_is_the_one_the_file_carries(path):
    assemblage = find_joints(read_blocks(path), JointSettings())
    assert assemblage.joints.count == json.loads(path.read_text())["interfaces"]
    check_assemblage(assemblage)


def test_segment_normal_and_order():
    stone = ([[0, 0], [2, 0], [2, 1], [0, 1]], False)
    above = ([[1, 1], [3, 1], [3, 2], [1, 2]], False)
    joints = find_joints(wall(GROUND, stone, above), JointSettings()).joints
    assert joints.i.tolist() == [0, 1]
    assert joints.j.tolist() == [1, 2]
    assert joints.start.tolist() == [[2, 0], [2, 1]]  # counter-clockwise round the lower block: leftwards on its top
    assert joints.end.tolist() == [[0, 0], [1, 1]]
    assert joints.normal == pytest.approx(np.array([[0, 1], [0, 1]]))
    assert joints.length == pytest.approx([2.0, 1.0])
    assert joints.friction.tolist() == [0.5, 0.5]


def test_inclined_contact():
    """A stone on a pair of wedges."""
    left = ([[0, 0], [1, 0], [0, 1]], False)
    right = ([[1, 0], [1, 1], [0, 1]], False)
    bridge_like = ([[0, 1], [1, 1], [1, 2], [0, 2]], False)
    joints = find_joints(wall(GROUND, left, right, bridge_like), JointSettings()).joints
    pairs = list(joints.pairs)
    assert pairs == [(0, 1), (1, 2), (2, 3)]
    assert joints.normal[1] == pytest.approx(np.array([1, 1]) / np.sqrt(2))


@pytest.mark.parametrize("first", range(8))
def test_two_joints_with_one_neighbour_are_in_order_along_the_first_block(first):
    portal = [[0, 0], [0.5, 0], [0.5, 1], [1.5, 1], [1.5, 0], [2, 0], [2, 2], [0, 2]]
    joints = find_joints(wall(GROUND, (np.roll(portal, first, axis=0), False)), JointSettings()).joints
    assert joints.j.tolist() == [1, 1]
    assert joints.start.tolist() == [[2, 0], [0.5, 0]]  # leftwards on the ground, whatever corner the portal starts at
    assert joints.end.tolist() == [[1.5, 0], [0, 0]]


def test_supports_have_no_joint_and_gaps_beyond_the_tolerance_none():
    ground = ([[3, -1], [5, -1], [5, 0], [3, 0]], True)
    floating = ([[0, 3e-5], [1, 3e-5], [1, 1], [0, 1]], False)
    assert find_joints(wall(GROUND, ground, floating), JointSettings()).joints.count == 0
    near = find_joints(wall(GROUND, ground, floating), JointSettings(tolerance=4e-5))
    assert near.joints.j.tolist() == [2]


@pytest.mark.parametrize("scale", [0.1, 1.0, 10.0])
def test_a_gap_and_a_contact_are_joints_or_not_by_their_share_of_a_stone(scale):
    """Of a stone of 1 m: a gap of 2e-5 is the rounding of a drawing and one of 4e-5 is none; a contact of 3 mm is a
    joint and one of 2 mm, whose ends that rounding may turn by 0.01 rad, is none, which is said with its place."""

    def count(gap, contact):
        stone = [[0, gap], [1, gap], [1, 1], [0, 1]]
        beside = [[1 - contact, 1], [2, 1], [2, 2], [1 - contact, 2]]
        blocks = [(scale * np.array(polygon), fixed) for polygon, fixed in (GROUND, (stone, False), (beside, False))]
        assemblage = find_joints(wall(*blocks), JointSettings())
        return assemblage.joints.count, short_contacts(assemblage, JointSettings())

    assert count(2e-5, 3e-3) == (2, [])
    assert count(4e-5, 3e-3) == (1, [])
    found, (said,) = count(2e-5, 2e-3)
    assert found == 1
    place = f"blocks 11 and 12 at ({scale * 0.999:.4g}, {scale * 1.0:.4g}) m, {2 * scale:g} mm"
    remedy = "joints.minimum_length says what is long enough"
    assert said == f"WARNING: 1 contact of stones is too short for a joint: {place}; {remedy}"


@pytest.mark.parametrize("shift", [0.0, 3.7, 5.1])
def test_joints_at_45_degrees_are_bed_joints_wherever_the_wall_stands(shift):
    """Rounding decided: of an arch of four voussoirs the left one was a head joint, the right one a bed joint."""
    inner, outer = (
        radius * np.column_stack([np.cos(at), np.sin(at)]) + [shift, 0.0]
        for at, radius in ((np.linspace(0, np.pi, 5), radius) for radius in (1.0, 1.2))
    )
    voussoirs = [([inner[k], outer[k], outer[k + 1], inner[k + 1]], k == 0) for k in range(4)]
    joints = find_joints(wall(*voussoirs), JointSettings()).joints
    assert is_bed(joints).tolist() == [True, False, True]


def test_a_gap_is_not_told_to_be_closed_by_more_than_an_option_takes():
    """Two stones 60 mm apart: import takes a tolerance of 50 mm at most."""
    stone, above = ([[0, 0], [1, 0], [1, 1], [0, 1]], False), ([[0, 1.06], [1, 1.06], [1, 2], [0, 2]], False)
    with pytest.raises(CaseError, match=r'import the file with --mortar "80 mm"$'):
        check_assemblage(find_joints(wall(GROUND, stone, above), JointSettings()))


def test_groups_without_support_are_named():
    stone, above = ([[0, 0], [1, 0], [1, 1], [0, 1]], False), ([[0, 5], [1, 5], [1, 6], [0, 6]], False)
    top = ([[0, 6], [1, 6], [1, 7], [0, 7]], False)
    with pytest.raises(CaseError, match="block 12: touches no other block"):
        check_assemblage(find_joints(wall(GROUND, stone, above), JointSettings()))
    with pytest.raises(CaseError, match="block 12: is not connected to any support"):
        check_assemblage(find_joints(wall(GROUND, stone, above, top), JointSettings()))


def test_a_wall_in_another_unit_is_asked_for_its_unit_instead_of_its_stones():
    stones = [([[x, 0.1], [x + 1, 0.1], [x + 1, 1], [x, 1]], False) for x in (0, 1.5)]
    small = wall(*((1e-3 * np.array(polygon), fixed) for polygon, fixed in (GROUND, *stones)))
    with pytest.raises(
        CaseError, match=r"block 11: touches no other .*; the wall measures 0.004 m: is the unit right\?"
    ):
        check_assemblage(find_joints(small, JointSettings()))


def test_shared_segment_is_cut_to_both_edges():
    """The stone's base runs over both ends of a short support; its left side continues that of the stone below."""
    support = ([[0.3, -1], [0.8, -1], [0.8, 0], [0.3, 0]], True)
    joints = find_joints(wall(support, ([[0, 0], [1, 0], [1, 1], [0, 1]], False)), JointSettings()).joints
    assert joints.start.tolist() == [[0.8, 0]]
    assert joints.end == pytest.approx(np.array([[0.3, 0]]))
    assert joints.centroid.tolist() == [[0.55, 0]]


def test_a_contact_below_the_minimum_length_is_no_joint():
    beside = ([[0.95, 1], [2, 1], [2, 2], [0.95, 2]], False)
    assemblage = wall(GROUND, ([[0, 0], [1, 0], [1, 1], [0, 1]], False), beside)
    assert find_joints(assemblage, JointSettings(minimum_length=0.049)).joints.count == 2
    assert find_joints(assemblage, JointSettings(minimum_length=0.051)).joints.count == 1
    assert len(short_contacts(find_joints(assemblage, JointSettings()), JointSettings(minimum_length=0.051))) == 1


def test_edges_that_run_the_same_way_share_nothing():
    """Two stones on one line of the ground, one above and one below a common level, touch at a corner only."""
    left, right = ([[0, 0], [1, 0], [1, 1], [0, 1]], False), ([[1, 1], [2, 1], [2, 2], [1, 2]], False)
    joints = find_joints(wall(GROUND, left, right), JointSettings()).joints
    assert joints.j.tolist() == [1]


SIDE = st.sampled_from([0.0, 1.0, 0.5, 2.0, 1e-12, 1e-5, 1e-3, 1e5, 1e90, 5e-324]) | st.floats(-3, 3)


@settings(max_examples=200, deadline=None)
@given(st.lists(st.tuples(SIDE, SIDE), min_size=3, max_size=5), st.sampled_from(["mm", "m", "km"]))
def test_no_drawing_gets_further_than_a_case_error_or_joints_of_finite_length(corners, unit):
    ground = {"id": 1, "polygon": [[-3, -1], [3, -1], [3, 0], [-3, 0]], "fixed": True}
    stone = {"id": 2, "polygon": [[0, 0], [1, 0], [1, 1], [0, 1]]}
    drawing = {"units": {"length": unit, "unit_weight": "kN/m3"}, "thickness": 1, "unit_weight": 20, "friction": 0.6}
    drawing["blocks"] = [ground, stone, {"id": 3, "polygon": [list(corner) for corner in corners]}]
    said = ""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            made = wall_from(drawing, "drawing")
            check_wall(made)
            assemblage = find_joints(made, JointSettings())
            joints = assemblage.joints
            check_assemblage(assemblage)
            assert len(joints.length) >= 2
            assert (joints.length > 0.0).all()
            assert np.isfinite(joints.normal).all()
        except CaseError as error:
            said = str(error)
    assert "\n" not in said


def test_the_mortar_between_two_blocks_is_found_whichever_is_named_first():
    """Two stones side by side on the ground, all of mortar of 1 GPa, 10 mm thick."""
    boxes = {0: (-1, -0.2, 3, 0), 1: (0, 0, 1, 0.5), 2: (1, 0, 2, 0.5)}
    blocks = [{"id": k, "polygon": between(*box).tolist(), "fixed": k == 0} for k, box in boxes.items()]
    record = {"units": {"length": "m", "unit_weight": "kN/m3"}, "thickness": 0.3, "unit_weight": 20, "friction": 0.5}
    for pair in ([1, 2], [2, 1]):
        wall = wall_from(record | {"blocks": blocks, "mortar": [[0, 1, 0.01], [2, 0, 0.01], [*pair, 0.01]]}, "wall")
        found = find_joints(wall, JointSettings(classes=(JointClass(mortar_modulus=1e9),))).joints
        assert found.normal_stiffness == pytest.approx([1e11, 1e11, 1e11])
